//! The centers in all pieces of a mask, from frame to frame.
//!
//! Each piece of the mask, one rope or several that cross, gets its own K centers. They start from
//! the last frame's centers that are on the piece. Otherwise, they start among its pixels, with the
//! same seed every time.

use super::nerve::Nerve;
use crate::bitmap::bits::BitPlane;
use crate::bitmap::components::{Components, budget};
use crate::options::Method;
use lariat_clustering::{Cells, FuzzyMeans, KMeans, Mixture, Pixels, Run, Som, Start};

/// Seed of the random numbers of a cold start: any number, but the same every time.
const SEED: u64 = 0;
/// Maximum number of pieces per rope. A rope may be in two, on either side of a gripper.
const PIECES_PER_ROPE: usize = 2;
/// Minimum share of the last frame's centers that must be on a piece for it to be the same one. A
/// rope that moves by its own width from one frame to the next keeps this many.
const SAME: f32 = 0.25;
/// Maximum number of pixels in a cell, as a multiple of the mean. After a warm start, a larger cell
/// or an empty one means that the centers were left behind where the rope was.
const MOST_UNEVEN: u32 = 4;

/// A center, and the pixels that it stands for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Center {
    pub(crate) at: [f32; 2],
    pub(crate) pixels: u32,
}

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Clusterer {
    components: Components,
    names: Vec<u32>,
    pixels: Pixels,
    kmeans: KMeans,
    som: Som,
    mixture: Mixture,
    fuzzy_means: FuzzyMeans,
    cells: Cells,
    /// K positions for each piece, of this frame and of the last.
    places: Vec<[f32; 2]>,
    former: Vec<[f32; 2]>,
    taken: Vec<bool>,
    counts: Vec<u32>,
    /// The centers of all pieces that have a cell.
    pub(crate) centers: Vec<Center>,
    /// The connections between them.
    pub(crate) nerve: Nerve,
}

impl Clusterer {
    /// Reserves memory for images of this size, with `count` centers on each piece of `ropes`
    /// ropes.
    pub(crate) fn reserve(&mut self, width: usize, height: usize, count: usize, ropes: usize) {
        let pieces = PIECES_PER_ROPE * ropes;
        self.components.reserve(width, height);
        self.names.reserve(budget(width, height));
        for places in [&mut self.places, &mut self.former] {
            places.reserve(pieces * count);
        }
        self.taken.reserve(pieces);
        self.nerve.reserve(count);
        self.centers.reserve(pieces * count);
    }

    /// Forgets the last frame.
    pub(crate) fn forget(&mut self) {
        self.places.clear();
    }

    /// Finds `count` centers for each of the largest pieces of the mask, and the connections
    /// between them.
    pub(crate) fn run(&mut self, method: Method, mask: &BitPlane, count: usize, ropes: usize) {
        self.centers.clear();
        self.nerve.begin(mask.width(), mask.height());
        std::mem::swap(&mut self.places, &mut self.former);
        self.places.clear();
        self.taken.clear();
        self.taken.resize(self.former.len() / count, false);
        let most = PIECES_PER_ROPE * ropes;
        if (self.components.largest(mask, most, &mut self.names)).is_err() {
            return;
        }
        for piece in 0..self.names.len() {
            self.take_pixels(self.names[piece]);
            self.place(method, count);
        }
    }

    fn take_pixels(&mut self, name: u32) {
        let pixels = &mut self.pixels;
        pixels.clear();
        let push = |y, from, to| pixels.push(Run { y, from, to });
        self.components.for_each_run_of(name, push);
    }

    /// Finds the centers of the piece in `pixels`.
    fn place(&mut self, method: Method, count: usize) {
        let from = self.places.len();
        let former = self.former_centers(count);
        match former {
            Some(set) => {
                let centers = &self.former[set * count..][..count];
                self.places.extend_from_slice(centers);
                self.cluster(method, Start::Given, from);
                // The other methods make uneven cells.
                if method == Method::KMeans && self.is_uneven() {
                    self.cluster(method, Start::Seeded(SEED), from);
                }
            }
            None => {
                self.places.resize(from + count, [0.0; 2]);
                self.cluster(method, Start::Seeded(SEED), from);
            }
        }
        let places = &self.places[from..];
        self.nerve.add(self.cells.runs(), places);
        let centers = places.iter().zip(&self.counts);
        let centers = centers.map(|(&at, &pixels)| Center { at, pixels });
        self.centers
            .extend(centers.filter(|center| center.pixels > 0));
    }

    /// Moves the centers from index `from` on, and finds their cells.
    fn cluster(&mut self, method: Method, start: Start, from: usize) {
        let (pixels, centers) = (&self.pixels, &mut self.places[from..]);
        match method {
            // The skeleton has no centers. It is never requested here.
            Method::Skeleton | Method::KMeans => self.kmeans.run(pixels, start, centers),
            Method::Som => self.som.run(pixels, start, centers),
            Method::Mixture => self.mixture.run(pixels, start, centers),
            Method::FuzzyMeans => self.fuzzy_means.run(pixels, start, centers),
        };
        self.cells.assign(pixels, centers);
        self.counts.clear();
        self.counts.resize(centers.len(), 0);
        for cell in self.cells.runs() {
            self.counts[usize::from(cell.center)] += u32::from(cell.to - cell.from);
        }
    }

    /// Returns whether cells are empty or far too large although there are enough pixels for all.
    fn is_uneven(&self) -> bool {
        let (pixels, cells) = (self.pixels.len() as u32, self.counts.len() as u32);
        let most = MOST_UNEVEN * pixels.div_ceil(cells);
        pixels >= MOST_UNEVEN * cells
            && (self.counts.iter()).any(|&count| count == 0 || count > most)
    }

    /// The last frame's set with the most centers on the piece in `pixels`, if enough of them are
    /// there.
    fn former_centers(&mut self, count: usize) -> Option<usize> {
        let on_piece = |set: usize| {
            let centers = &self.former[set * count..][..count];
            centers.iter().filter(|at| self.is_on_piece(**at)).count()
        };
        let free = (0..self.taken.len()).filter(|&set| !self.taken[set]);
        let (most, set) = free
            .map(|set| (on_piece(set), set))
            .max_by_key(|&(on, _)| on)?;
        let is_same = most as f32 >= SAME * count as f32;
        self.taken[set] |= is_same;
        is_same.then_some(set)
    }

    /// Returns whether the pixel at a position is in `pixels`.
    fn is_on_piece(&self, [x, y]: [f32; 2]) -> bool {
        // Coordinates that are not finite or are outside become those of some pixel.
        let (x, y) = (x.round() as u16, y.round() as u16);
        let runs = self.pixels.runs();
        let behind = runs.partition_point(|run| (run.y, run.from) <= (y, x));
        let run = behind.checked_sub(1).map(|before| runs[before]);
        run.is_some_and(|run| run.y == y && x < run.to)
    }
}
