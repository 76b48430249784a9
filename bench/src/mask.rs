//! Mask options of the measurements.

/// Method that segments the ropes' pixels.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum Mask {
    /// Difference from a plain table; the network on other backgrounds
    Auto,
    /// Always the network
    Network,
}

impl From<Mask> for lariat_extract::Mask {
    fn from(mask: Mask) -> Self {
        match mask {
            Mask::Auto => Self::Auto,
            Mask::Network => Self::Network,
        }
    }
}
