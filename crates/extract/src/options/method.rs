//! Methods for the centerline, by name.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// The method that turns the rope's pixels into a centerline.
///
/// All but the first are those of the paper (F. Chen, arXiv 2312.16502, fig. 1). They put
/// [`Options::points`](crate::Options::points) centers on each component of the mask and order
/// them. They exist for comparison. The first is more accurate, faster, and the only one that
/// follows a rope from frame to frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// Thins the mask and measures each cross-section with subpixel accuracy.
    #[default]
    Skeleton,
    /// Centers by `KMeans` of the clusterings.
    KMeans,
    /// Centers by `Som` of the clusterings.
    Som,
    /// Centers by `Mixture` of the clusterings.
    Mixture,
    /// Centers by `FuzzyMeans` of the clusterings.
    FuzzyMeans,
}

impl Method {
    /// All methods with their names.
    pub const ALL: [(&'static str, Self); 5] = [
        ("skeleton", Self::Skeleton),
        ("kmeans", Self::KMeans),
        ("som", Self::Som),
        ("gmm", Self::Mixture),
        ("fcm", Self::FuzzyMeans),
    ];
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = Self::ALL.iter().find(|(_, method)| method == self);
        f.pad(named.map_or("", |(name, _)| name))
    }
}

/// No method has this name.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no method '{0}': choose one of {list}", list = Method::ALL.map(|(name, _)| name).join(", "))]
pub struct UnknownMethod(pub String);

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let named = Self::ALL.iter().find(|(known, _)| *known == name);
        let unknown = || UnknownMethod(name.to_owned());
        named.map(|(_, method)| *method).ok_or_else(unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_called_by_its_name() {
        for (name, method) in Method::ALL {
            assert_eq!(
                (name.parse(), method.to_string()),
                (Ok(method), name.into())
            );
        }
        let why = "k-means".parse::<Method>().unwrap_err().to_string();
        assert!(why.contains("'k-means'") && why.contains("kmeans"), "{why}");
    }
}
