//! Ropes on a background that is not a plain table. The network tells roughly where they are, and
//! their edges are then found in the image.

use std::sync::Arc;

use lariat_network::Network;

use super::evened::Evener;
use super::neural::Finder;
use crate::image::gray::GrayPlane;
use crate::image::{Image, Region};
use crate::ribbons::Ribbons;

/// Minimum probability, of 255, of pixels that a glance of the network finds worth a closer look.
const GUESSES: u8 = 64;

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Seeker {
    finder: Finder,
    ribbons: Ribbons,
    evener: Evener,
    /// The network's probability that each pixel is rope, of 255.
    pub(crate) likely: GrayPlane,
    /// True if there were ropes in the last image that the network was asked about.
    pub(crate) has_found: bool,
}

impl Seeker {
    /// Sets another network.
    pub(crate) fn use_network(&mut self, network: Arc<Network>) {
        self.finder = Finder::new(network);
    }

    /// Paints the ropes in the part `within` of `image` into `levels`, which gets the image's size.
    /// If a glance of the network shows none, nothing more is done, unless the last image had some.
    pub(crate) fn run(&mut self, image: &Image, within: Region, levels: &mut GrayPlane) {
        levels.resize(image.width(), image.height());
        if self.has_found || self.finder.glance(image, within, GUESSES) {
            self.finder.find(image, within, &mut self.likely);
            self.ribbons.find(image, &self.likely, levels);
            self.evener.run(levels);
        } else {
            (0..image.height()).for_each(|y| levels.row_mut(y).fill(0));
        }
    }

    /// Reserves the buffers for images of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        self.ribbons.reserve(width, height);
        self.evener.reserve(width);
        self.finder.reserve(width, height);
        self.likely.resize(width, height);
    }
}
