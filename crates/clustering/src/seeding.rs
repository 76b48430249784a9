//! Initial centers by k-means++ (D. Arthur and S. Vassilvitskii, SODA 2007). Each further center is
//! a pixel drawn with a probability proportional to its squared distance from the nearest earlier
//! center.
//!
//! The pixels are grouped into blocks. A new center is the nearest only for pixels around it. A
//! block is skipped if the block's box is farther from the new center than any of its pixels is
//! from the nearest earlier center. All K centers therefore cost about as much as ln K passes over
//! the pixels, not K.

use lariat_portable::{Arch, NullaryFnOnce};

use super::{Pixels, Start};
use lariat_portable::SplitMix64;

/// Pixels per block.
const BLOCK: usize = 64;
/// Number of parallel sums: the lanes of the widest register.
const LANES: usize = 16;
/// Centers with a larger coordinate, in pixels, are ignored. Images have up to 16,384 pixels per
/// side, and lists of runs up to 65,536.
const FAR: f32 = 131_072.0;

/// Pixels and their squared distances from the nearest center. The last block is padded with
/// distances of 0.
#[derive(Clone, Debug)]
struct Block {
    xs: [f32; BLOCK],
    ys: [f32; BLOCK],
    squares: [f32; BLOCK],
}

/// Bounds that allow a block to be skipped.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// Minimum and maximum column and row.
    x: [f32; 2],
    y: [f32; 2],
    /// The largest squared distance.
    most: f32,
}

/// Memory of the seeding.
#[derive(Debug, Default)]
pub(crate) struct Seeding {
    blocks: Vec<Block>,
    bounds: Vec<Bounds>,
    /// Sum of each block's squared distances, padded to whole lanes.
    sums: Vec<f32>,
}

/// Sets `centers` to those that [`Start::Seeded`] begins with: pixels drawn by k-means++. Without
/// pixels they do not change. Use it to give the same start to other methods. It allocates.
pub fn seed_centers(pixels: &Pixels, seed: u64, centers: &mut [[f32; 2]]) {
    Seeding::default().begin(pixels, Start::Seeded(seed), centers);
}

/// Returns whether a center is near enough to matter.
fn is_place(center: &[f32; 2]) -> bool {
    center.iter().all(|c| c.abs() <= FAR)
}

impl Seeding {
    /// Initializes `centers` according to `start`. Given centers that are not finite or far outside
    /// any picture are replaced by pixels, drawn as if the others had been chosen before them.
    /// Without pixels all centers stay.
    pub(crate) fn begin(&mut self, pixels: &Pixels, start: Start, centers: &mut [[f32; 2]]) {
        let seed = match start {
            Start::Given if centers.iter().all(is_place) => return,
            Start::Given => 0,
            Start::Seeded(seed) => seed,
        };
        if pixels.is_empty() {
            return;
        }
        if start != Start::Given {
            centers.fill([f32::NAN; 2]);
        }
        self.take(pixels);
        Arch::new().dispatch(Choosing {
            memory: self,
            pixels,
            random: SplitMix64::new(seed),
            centers,
        });
    }

    fn take(&mut self, pixels: &Pixels) {
        let count = pixels.len().div_ceil(BLOCK);
        let empty = Block {
            xs: [0.0; BLOCK],
            ys: [0.0; BLOCK],
            squares: [0.0; BLOCK],
        };
        self.blocks.resize(count, empty);
        self.bounds.clear();
        self.sums.clear();
        self.sums.resize(count.next_multiple_of(LANES), 0.0);
        let chunks = pixels.xs().chunks(BLOCK).zip(pixels.ys().chunks(BLOCK));
        for (block, (xs, ys)) in self.blocks.iter_mut().zip(chunks) {
            let many = xs.len();
            block.xs[..many].copy_from_slice(xs);
            block.ys[..many].copy_from_slice(ys);
            block.xs[many..].fill(xs[0]);
            block.ys[many..].fill(ys[0]);
            block.squares[..many].fill(f32::INFINITY);
            block.squares[many..].fill(0.0);
            let (mut least, mut largest) = ([xs[0]; LANES], [xs[0]; LANES]);
            for xs in block.xs.as_chunks::<LANES>().0 {
                for ((x, least), largest) in xs.iter().zip(&mut least).zip(&mut largest) {
                    *least = smaller(*x, *least);
                    *largest = larger(*x, *largest);
                }
            }
            self.bounds.push(Bounds {
                x: [
                    least.into_iter().fold(xs[0], smaller),
                    largest.into_iter().fold(xs[0], larger),
                ],
                y: [ys[0], ys[many - 1]],
                most: f32::INFINITY,
            });
        }
    }
}

/// The choice itself, dispatched to the widest registers.
struct Choosing<'a> {
    memory: &'a mut Seeding,
    pixels: &'a Pixels,
    random: SplitMix64,
    centers: &'a mut [[f32; 2]],
}

impl NullaryFnOnce for Choosing<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let mut any = false;
        for center in self.centers.iter().filter(|center| is_place(center)) {
            self.memory.add(*center);
            any = true;
        }
        for center in self.centers.iter_mut().filter(|center| !is_place(center)) {
            let drawn = if any {
                self.memory.draw(&mut self.random)
            } else {
                None
            };
            // Every pixel already has a center, so any pixel will do.
            *center = drawn.unwrap_or_else(|| {
                let i = self.random.below(self.pixels.len());
                [self.pixels.xs()[i], self.pixels.ys()[i]]
            });
            self.memory.add(*center);
            any = true;
        }
    }
}

impl Seeding {
    /// Adds a center.
    #[inline(always)]
    fn add(&mut self, center: [f32; 2]) {
        let [x, y] = center;
        let blocks = self.blocks.iter_mut().zip(&mut self.bounds);
        for ((block, bounds), total) in blocks.zip(&mut self.sums) {
            let dx = larger(larger(bounds.x[0] - x, x - bounds.x[1]), 0.0);
            let dy = larger(larger(bounds.y[0] - y, y - bounds.y[1]), 0.0);
            if dx * dx + dy * dy < bounds.most {
                (bounds.most, *total) = block.add(x, y);
            }
        }
    }

    /// Draws a pixel with a probability proportional to its square; `None` if all are 0.
    #[inline(always)]
    fn draw(&self, random: &mut SplitMix64) -> Option<[f32; 2]> {
        let mut lanes = [0.0f32; LANES];
        for sums in self.sums.as_chunks::<LANES>().0 {
            for (lane, sum) in lanes.iter_mut().zip(sums) {
                *lane += sum;
            }
        }
        let mut total = 0.0;
        for lane in lanes {
            total += lane;
        }
        // The order does not change a pixel's share: first the lane, then the block, then the
        // pixel.
        let mut rest = random.unit_f32() * total;
        let lane = fall(lanes.iter(), &mut rest)?;
        let row = fall(self.sums[lane..].iter().step_by(LANES), &mut rest)?;
        let block = &self.blocks[lane + row * LANES];
        let i = fall(block.squares.iter(), &mut rest)?;
        Some([block.xs[i], block.ys[i]])
    }
}

impl Block {
    /// Adds a center at (x, y). Returns the largest square and the sum of all.
    #[inline(always)]
    fn add(&mut self, x: f32, y: f32) -> (f32, f32) {
        let (mut most, mut sums) = ([0.0f32; LANES], [0.0f32; LANES]);
        let places = self.xs.as_chunks::<LANES>().0.iter();
        let places = places.zip(self.ys.as_chunks::<LANES>().0);
        for ((xs, ys), squares) in places.zip(self.squares.as_chunks_mut::<LANES>().0) {
            for i in 0..LANES {
                let (dx, dy) = (xs[i] - x, ys[i] - y);
                squares[i] = smaller(dx * dx + dy * dy, squares[i]);
                most[i] = larger(squares[i], most[i]);
                sums[i] += squares[i];
            }
        }
        // Pairwise reduction, to shorten the chain of dependent operations.
        let mut half = LANES / 2;
        while half > 0 {
            for i in 0..half {
                most[i] = larger(most[i], most[i + half]);
                sums[i] += sums[i + half];
            }
            half /= 2;
        }
        (most[0], sums[0])
    }
}

/// Returns the index of the share that `rest` falls into and leaves the remainder in `rest`. If
/// rounding leads past the end, it returns the last share that is not 0; `None` if all are 0.
#[inline(always)]
fn fall<'a>(shares: impl Iterator<Item = &'a f32>, rest: &mut f32) -> Option<usize> {
    let mut last = None;
    for (i, &share) in shares.enumerate() {
        if share > 0.0 {
            last = Some(i);
            if *rest < share {
                return last;
            }
            *rest -= share;
        }
    }
    last
}

// `f32::min` and `f32::max` check for NaN, whereas these compile to one instruction.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Run;

    /// A ring with radii of 10 to 20 pixels around (100, 100).
    fn ring() -> Pixels {
        let mut pixels = Pixels::default();
        for y in 80..=120u16 {
            let dy = i32::from(y) - 100;
            let inside = |x: &u16| {
                let dx = i32::from(*x) - 100;
                (100..=400).contains(&(dx * dx + dy * dy))
            };
            let mut row = (80..=120u16).filter(inside).peekable();
            while let Some(from) = row.next() {
                let mut to = from + 1;
                while row.next_if_eq(&to).is_some() {
                    to += 1;
                }
                pixels.push(Run { y, from, to });
            }
        }
        pixels
    }

    fn seeded(pixels: &Pixels, seed: u64, count: usize) -> Vec<[f32; 2]> {
        let mut centers = vec![[-1.0; 2]; count];
        Seeding::default().begin(pixels, Start::Seeded(seed), &mut centers);
        centers
    }

    fn square(a: [f32; 2], b: [f32; 2]) -> f32 {
        (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
    }

    #[test]
    fn centers_are_different_pixels_and_the_same_for_the_same_seed() {
        let pixels = ring();
        let centers = seeded(&pixels, 3, 60);
        for (i, a) in centers.iter().enumerate() {
            assert!((100.0..=400.0).contains(&square(*a, [100.0; 2])));
            assert!(centers[..i].iter().all(|b| a != b));
        }
        assert_eq!(centers, seeded(&pixels, 3, 60));
        assert_ne!(centers, seeded(&pixels, 4, 60));
    }

    #[test]
    fn squares_are_those_to_the_nearest_center() {
        let pixels = ring();
        let mut centers = vec![[0.0; 2]; 30];
        let mut seeding = Seeding::default();
        seeding.begin(&pixels, Start::Seeded(1), &mut centers);
        let squares = seeding.blocks.iter().flat_map(|block| block.squares);
        let places = pixels.xs().iter().zip(pixels.ys());
        for ((&x, &y), found) in places.zip(squares) {
            let to = centers.iter().map(|&c| square(c, [x, y]));
            assert_eq!(found, to.fold(f32::INFINITY, f32::min));
        }
    }

    #[test]
    fn a_pixel_is_drawn_by_the_square_of_its_distance() {
        // The pixels' squared distances from the given center are 1, 4 and 9.
        let mut pixels = Pixels::default();
        let run = |x| Run {
            y: 0,
            from: x,
            to: x + 1,
        };
        [11, 12, 13].into_iter().for_each(|x| pixels.push(run(x)));
        let mut seeding = Seeding::default();
        let mut centers = [[10.0, 0.0], [f32::NAN; 2]];
        seeding.begin(&pixels, Start::Given, &mut centers);
        seeding.take(&pixels);
        seeding.add([10.0, 0.0]);
        let mut random = SplitMix64::new(7);
        let mut counts = [0i32; 3];
        for _ in 0..14_000 {
            let drawn = seeding.draw(&mut random).expect("there are squares");
            counts[drawn[0] as usize - 11] += 1;
        }
        for (count, share) in counts.iter().zip([1000, 4000, 9000]) {
            // Six times the largest standard deviation.
            assert!((count - share).abs() < 350, "{counts:?}");
        }
    }

    #[test]
    fn fewer_pixels_than_centers_are_all_taken() {
        let mut pixels = Pixels::default();
        pixels.push(Run {
            y: 5,
            from: 3,
            to: 6,
        });
        let centers = seeded(&pixels, 0, 10);
        for x in [3.0, 4.0, 5.0] {
            assert!(centers.contains(&[x, 5.0]));
        }
        assert!(centers.iter().all(|c| c[1] == 5.0));
    }

    #[test]
    fn without_pixels_centers_stay() {
        assert_eq!(seeded(&Pixels::default(), 0, 2), [[-1.0; 2]; 2]);
    }

    #[test]
    fn given_centers_stay_and_those_that_are_no_place_are_chosen() {
        let pixels = ring();
        let given = [
            [110.0, 100.0],
            [f32::NAN, 1.0],
            [f32::INFINITY; 2],
            [1e30, 0.0],
        ];
        let mut centers = given;
        Seeding::default().begin(&pixels, Start::Given, &mut centers);
        assert_eq!(centers[0], given[0]);
        for center in &centers[1..] {
            assert!((100.0..=400.0).contains(&square(*center, [100.0; 2])));
        }
    }
}
