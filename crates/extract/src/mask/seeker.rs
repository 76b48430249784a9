//! Ropes on a background that is not a plain table. The network tells roughly where they are, and
//! their edges are then found in the image.

use std::sync::Arc;

use lariat_network::Network;
use lariat_portable::{Arch, NullaryFnOnce};

use super::evened::Evener;
use super::neural::Finder;
use crate::image::gray::GrayPlane;
use crate::image::{Image, Region};
use crate::ribbons::Ribbons;

/// Minimum probability, of 255, of pixels that the network sees as rope, and of those that it
/// guesses. The network is believed if it sees more than the share `BELIEVED` of the guessed
/// pixels. Otherwise, every pixel gets the probability `UNKNOWN`.
const SEES: u8 = 191;
const GUESSES: u8 = 64;
const BELIEVED: f32 = 0.3;
const UNKNOWN: u8 = 128;

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Seeker {
    finder: Finder,
    ribbons: Ribbons,
    evener: Evener,
    /// The network's probability that each pixel is rope, of 255.
    pub(crate) likely: GrayPlane,
    /// True if the network saw no rope, so that ropes are found by their shape alone.
    pub(crate) is_blind: bool,
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
        self.is_blind = !self.has_found && !self.finder.glance(image, within, GUESSES);
        match self.is_blind {
            true => (0..image.height()).for_each(|y| levels.row_mut(y).fill(0)),
            false => self.look_closely(image, within, levels),
        }
    }

    fn look_closely(&mut self, image: &Image, within: Region, levels: &mut GrayPlane) {
        self.finder.find(image, within, &mut self.likely);
        let likely = self.likely.bytes();
        let reaches = |least| Count { likely, least };
        let [seen, guessed] = [SEES, GUESSES].map(|least| Arch::new().dispatch(reaches(least)));
        self.is_blind = seen as f32 <= BELIEVED * guessed as f32;
        if self.is_blind {
            // Pixels unknown to the network may still have a rope's shape.
            let columns = within.x..within.x + within.width;
            for y in within.y..within.y + within.height {
                self.likely.row_mut(y)[columns.clone()].fill(UNKNOWN);
            }
        }
        self.ribbons.find(image, &self.likely, levels);
        self.evener.run(levels);
    }

    /// Reserves the buffers for images of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        self.ribbons.reserve(width, height);
        self.evener.reserve(width);
        self.finder.reserve(width, height);
        self.likely.resize(width, height);
    }
}

/// Counts the levels of at least `least`.
struct Count<'a> {
    likely: &'a [u8],
    least: u8,
}

impl NullaryFnOnce for Count<'_> {
    type Output = u32;

    #[inline(always)]
    fn call(self) -> u32 {
        // A byte can count this many.
        let some = self.likely.chunks(128).map(|levels| {
            let levels = levels.iter().map(|&level| u8::from(level >= self.least));
            u32::from(levels.sum::<u8>())
        });
        some.sum()
    }
}
