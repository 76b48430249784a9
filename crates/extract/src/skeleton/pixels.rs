//! The skeleton as a list: each pixel's position, neighbors and distance to the rope's edge.

use crate::bitmap::bits::BitPlane;
use crate::bitmap::edge_distance::EdgeDistance;
use crate::bitmap::strips::{BLOCK, Strips};
use crate::skeleton::wide::Place;

/// Stands for a missing pixel, node, edge or arm.
pub(crate) const NONE: u32 = u32::MAX;
/// Maximum number of skeleton pixels. An image with more is treated as noise: this is more than
/// eight ropes that each cross the longest image a few times.
const BUDGET: usize = 1 << 17;

/// The pixels of a skeleton in row order.
#[derive(Debug, Default)]
pub(crate) struct Skeleton {
    /// Index of the first pixel of each word in a block that has any.
    first: Vec<u32>,
    /// Words that have pixels, in row order.
    held: Vec<u32>,
    /// Strips that have pixels in the rows being listed.
    filled: Vec<u32>,
    edge_distance: EdgeDistance,
    pub(crate) pixels: Vec<Pixel>,
}

/// One pixel of the skeleton.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    pub(crate) x: u16,
    pub(crate) y: u16,
    /// Distance from the pixel's center to the rope's edge, in pixels.
    pub(crate) half_px: f32,
    /// The first `degree` are valid, at most four. A corner neighbor counts only if neither of the
    /// side neighbors next to it is set.
    pub(crate) neighbors: [u32; 5],
    pub(crate) degree: u8,
}

impl Pixel {
    pub(crate) fn at(&self) -> [f32; 2] {
        [f32::from(self.x), f32::from(self.y)]
    }
}

impl Skeleton {
    /// Lists the pixels of `thin`, the skeleton of `mask`. `rows` is the same mask row by row. An
    /// image that is noise gets no pixels.
    pub(crate) fn list(&mut self, thin: &Strips, mask: &Strips, rows: &BitPlane) {
        self.edge_distance.take(mask);
        lariat_portable::Arch::new().dispatch(List {
            skeleton: self,
            thin,
            mask: rows,
        });
    }

    /// Lists the pixels with their half-widths, or none if there are too many.
    #[inline(always)]
    fn list_places(&mut self, thin: &Strips, mask: &BitPlane) {
        let shape = &thin.shape;
        self.pixels.clear();
        self.held.clear();
        // There are at most as many words with pixels as pixels.
        self.held.reserve(self.pixels.capacity());
        self.first.resize(shape.words(), 0);
        for top in (0..shape.height()).step_by(BLOCK) {
            self.filled.clear();
            for strip in 0..shape.strips() {
                if thin.used.holds(shape, strip, top / BLOCK) {
                    self.filled.push(strip as u32);
                }
            }
            if self.filled.is_empty() {
                continue;
            }
            for y in top..(top + BLOCK).min(shape.height()) {
                for &strip in &self.filled {
                    let at = shape.index(strip as usize, y);
                    let mut word = thin.words[at];
                    self.first[at] = self.pixels.len() as u32;
                    if word != 0 {
                        self.held.push(at as u32);
                    }
                    while word != 0 {
                        let (x, y) = ((64 * strip + word.trailing_zeros()) as u16, y as u16);
                        self.pixels.push(Pixel {
                            x,
                            y,
                            half_px: self.edge_distance.half_px(mask, x, y),
                            neighbors: [NONE; 5],
                            degree: 0,
                        });
                        word &= word - 1;
                    }
                }
                if self.pixels.len() > BUDGET {
                    self.pixels.clear();
                    self.held.clear();
                    return;
                }
            }
        }
    }

    /// Finds the neighbors of the pixels in the word at `at`, whose first pixel has index `i`.
    /// Returns the index after its last.
    ///
    /// A corner neighbor that is also reached through a side neighbor is left out, so that a
    /// staircase is a path and not a row of junctions.
    #[inline(always)]
    fn connect(&mut self, thin: &Strips, at: usize, mut i: usize) -> usize {
        let (words, stride) = (&thin.words[..], thin.shape.stride);
        let [nw, n, ne] = three(words, at - 1, stride);
        let [w, mut rest, e] = three(words, at, stride);
        let [sw, s, se] = three(words, at + 1, stride);
        let (above, below) = (
            first_beside(&self.first, words, at - 1, stride),
            first_beside(&self.first, words, at + 1, stride),
        );
        let (se, sw) = (se & !e & !s, sw & !w & !s);
        let (nw, ne) = (nw & !w & !n, ne & !e & !n);
        while rest != 0 {
            let bit = rest.trailing_zeros();
            rest &= rest - 1;
            let left = (1u64 << bit) - 1;
            let above = above + (n & left).count_ones();
            let below = below + (s & left).count_ones();
            let here = i as u32;
            let kinds = [
                (e, here + 1),
                (s, below),
                (w, here.wrapping_sub(1)),
                (n, above),
                (se, below),
                (sw, below.wrapping_sub(1)),
                (nw, above.wrapping_sub(1)),
                (ne, above),
            ];
            // Always written, but kept only if the neighbor is there. This is random, so a branch
            // on it would be mispredicted.
            let (pixel, mut degree) = (&mut self.pixels[i], 0);
            for (are_there, index) in kinds {
                pixel.neighbors[degree] = index;
                degree += (are_there >> bit & 1) as usize;
            }
            pixel.degree = degree as u8;
            i += 1;
        }
        i
    }

    /// Adds places that no line runs through.
    pub(crate) fn add(&mut self, places: &[Place]) {
        (self.pixels).extend(places.iter().map(
            |&Place {
                 at: [x, y],
                 half_px,
             }| Pixel {
                x,
                y,
                half_px,
                neighbors: [NONE; 5],
                degree: 0,
            },
        ));
    }

    /// Removes pixel `i`, so that no neighbor leads to it.
    pub(crate) fn remove(&mut self, i: u32) {
        let Pixel {
            neighbors, degree, ..
        } = self.pixels[i as usize];
        for &other in &neighbors[..usize::from(degree)] {
            let other = &mut self.pixels[other as usize];
            let degree = usize::from(other.degree);
            if let Some(k) = other.neighbors[..degree].iter().position(|&n| n == i) {
                other.neighbors.swap(k, degree - 1);
                other.degree -= 1;
            }
        }
        self.pixels[i as usize].degree = 0;
    }
}

/// For the pixels of a word: their left neighbors, the pixels themselves, and their right
/// neighbors.
#[inline(always)]
fn three(words: &[u64], at: usize, stride: usize) -> [u64; 3] {
    let left = words[at] << 1 | words[at - stride] >> 63;
    let right = words[at] >> 1 | words[at + stride] << 63;
    [left, words[at], right]
}

/// Index of the first pixel in a word, or, if the word is empty, the index that it would have.
///
/// This is the index after the last pixel of the word to the left, and equals the first of the word
/// to the right. Pixels of a row have consecutive indices. The result must be valid only where one
/// of them touches a pixel of this word.
#[inline(always)]
fn first_beside(first: &[u32], words: &[u64], at: usize, stride: usize) -> u32 {
    if words[at] != 0 {
        return first[at];
    }
    match words[at - stride] {
        0 => first[at + stride],
        left => first[at - stride].wrapping_add(left.count_ones()),
    }
}

/// The listing, compiled for each kind of machine: most count bits in one instruction.
struct List<'a> {
    skeleton: &'a mut Skeleton,
    thin: &'a Strips,
    mask: &'a BitPlane,
}

impl lariat_portable::NullaryFnOnce for List<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let skeleton = self.skeleton;
        skeleton.list_places(self.thin, self.mask);
        let mut i = 0;
        for k in 0..skeleton.held.len() {
            i = skeleton.connect(self.thin, skeleton.held[k] as usize, i);
        }
    }
}
