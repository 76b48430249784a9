//! What the measurements can be asked to look with.

/// How the ropes' pixels are told from the others.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum Mask {
    /// What differs from a plain table; where there is none, the network
    Auto,
    /// The network, always
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
