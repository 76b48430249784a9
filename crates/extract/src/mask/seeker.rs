//! Ropes where no plain table is: the network says about where, and their edges are those that are seen there.

use std::sync::Arc;

use lariat_network::Network;
use lariat_portable::{Arch, NullaryFnOnce};

use super::evened::Evener;
use super::neural::Finder;
use crate::image::gray::GrayPlane;
use crate::image::{Image, Region};
use crate::ribbons::Ribbons;

/// How likely the network finds what it sees, of 255, and what it guesses; which share of what it guesses it must see to be believed;
/// and how likely all are when it is not.
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
    /// How likely the network says that each pixel is of a rope.
    pub(crate) likely: GrayPlane,
    /// Whether it saw none, so that they are found by their shape alone.
    pub(crate) is_blind: bool,
    /// Whether there were ropes in the last image that it was asked about.
    pub(crate) has_found: bool,
}

impl Seeker {
    /// Asks another network.
    pub(crate) fn use_network(&mut self, network: Arc<Network>) {
        self.finder = Finder::new(network);
    }

    /// Paints the ropes in the part `within` of `image` into `levels`, of its size. Where the network guesses none at a glance it is left at
    /// that, unless the last image had some.
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
            // What it knows nothing of may still have a rope's shape.
            let columns = within.x..within.x + within.width;
            for y in within.y..within.y + within.height {
                self.likely.row_mut(y)[columns.clone()].fill(UNKNOWN);
            }
        }
        self.ribbons.find(image, &self.likely, levels);
        self.evener.run(levels);
    }

    /// Makes the buffers for images of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        self.ribbons.reserve(width, height);
        self.evener.reserve(width);
        self.finder.reserve(width, height);
        self.likely.resize(width, height);
    }
}

/// Counts the levels that reach one.
struct Count<'a> {
    likely: &'a [u8],
    least: u8,
}

impl NullaryFnOnce for Count<'_> {
    type Output = u32;

    #[inline(always)]
    fn call(self) -> u32 {
        // A byte counts so many.
        let some = self.likely.chunks(128).map(|levels| {
            let levels = levels.iter().map(|&level| u8::from(level >= self.least));
            u32::from(levels.sum::<u8>())
        });
        some.sum()
    }
}
