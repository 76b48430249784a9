//! The ways to a centerline, by name.

/// How the rope's pixels become a centerline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// The mask is thinned, and each cross-section measured between pixels.
    #[default]
    Skeleton,
    /// Centers by [`KMeans`](crate::KMeans), put in order.
    KMeans,
}
