//! Small connected components ("pieces") of a picture in strips: drops specks and fills pinholes
//! without labeling the large pieces.
//!
//! The topmost row of a piece begins with a cap, a run of pixels with none of the piece above it.
//! Caps are few, and 64 pixels at a time are searched for them. From each cap, the piece is
//! followed run by run until it is complete or too large. The result equals that of labeling every
//! piece ([`Components`]), which is done if there are too many caps.

use super::bits::BitPlane;
use super::components::{Components, TooManyRuns, budget};
use super::strips::{BLOCK, Blocks, Strips, block};

/// Maximum number of large pieces that are followed in vain. Beyond it, all pieces are labeled
/// instead.
const MOST_LARGE: usize = 128;
/// Maximum number of runs of one piece that are followed. Beyond it, all pieces are labeled
/// instead.
const MOST_RUNS: usize = 4096;
/// Maximum number of caps from which a walk down looks for large pieces. Pictures of ropes have
/// fewer.
const MOST_WALKS: usize = 1024;
/// Minimum size, in pixels, of a hole that can extend into a block without a set pixel. One of the
/// hole's runs then fills a word.
const WORD: u32 = 64;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Pieces {
    /// Caps that may belong to small pieces.
    caps: Vec<Cap>,
    /// Runs of the piece that is being followed.
    runs: Vec<Run>,
    beside: Blocks,
    pub(crate) components: Components,
    plane: BitPlane,
}

/// A pixel of a cap.
#[derive(Clone, Copy, Debug)]
struct Cap {
    x: u16,
    y: u16,
}

#[derive(Clone, Copy, Debug)]
struct Run {
    y: u16,
    from: u16,
    to: u16,
}

/// Pixels that form pieces: set ones, which touch by sides and corners, or unset ones, which touch
/// by sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Specks,
    Holes,
}

impl Pieces {
    /// Clears pieces (pixels that touch by side or corner) of fewer than `least` pixels.
    pub(crate) fn drop_specks(
        &mut self,
        plane: &mut Strips,
        least: u32,
    ) -> Result<(), TooManyRuns> {
        self.reserve(plane);
        let most = least.saturating_sub(1);
        if self.find_caps(plane, Kind::Specks, most) > budget_of(plane) {
            return Err(TooManyRuns);
        }
        if !self.change_small(plane, Kind::Specks, most) {
            return self.label(plane, |components, rows| {
                components.drop_specks(rows, least)
            });
        }
        Ok(())
    }

    /// Sets holes (unset pixels that touch by their sides) of at most `most` pixels that do not
    /// touch the image's edge.
    pub(crate) fn fill_holes(&mut self, plane: &mut Strips, most: u32) -> Result<(), TooManyRuns> {
        self.reserve(plane);
        if most >= WORD {
            self.beside.beside(&plane.shape, &plane.used);
            plane.used.copy_from(&self.beside);
        }
        // A row has at most one more run of unset pixels than of set ones.
        let runs = self.find_caps(plane, Kind::Holes, most) + plane.shape.height();
        if runs > budget_of(plane) || !self.change_small(plane, Kind::Holes, most) {
            return self.label(plane, |components, rows| components.fill_holes(rows, most));
        }
        Ok(())
    }

    /// Reserves the memory that the worst picture of this shape needs.
    fn reserve(&mut self, plane: &Strips) {
        let size = [plane.shape.width(), plane.shape.height()];
        if size != [self.plane.width(), self.plane.height()] {
            self.runs.clear();
            self.runs.reserve(MOST_RUNS);
            self.caps.clear();
            // The block that exceeds the budget is still searched.
            self.caps.reserve(budget_of(plane) + BLOCK * 64);
            self.plane.resize(size[0], size[1]);
            self.components.reserve(size[0], size[1]);
        }
    }

    /// Labels all pieces instead.
    fn label(
        &mut self,
        plane: &mut Strips,
        change: impl FnOnce(&mut Components, &mut BitPlane) -> Result<(), TooManyRuns>,
    ) -> Result<(), TooManyRuns> {
        self.plane.resize(plane.shape.width(), plane.shape.height());
        plane.put(&mut self.plane);
        change(&mut self.components, &mut self.plane)?;
        // Blocks that became empty must still be written.
        self.beside.copy_from(&plane.used);
        plane.take(&self.plane);
        plane.used.add_all(&self.beside);
        Ok(())
    }

    /// Lists the caps of pieces that may have at most `most` pixels, and returns the number of runs
    /// of set pixels. Beyond the budget, both are incomplete.
    fn find_caps(&mut self, plane: &Strips, kind: Kind, most: u32) -> usize {
        self.caps.clear();
        let caps = &mut self.caps;
        lariat_portable::Arch::new().dispatch(FindCaps {
            plane,
            kind,
            most,
            caps,
        })
    }

    /// Inverts pieces of at most `most` pixels. Returns false if there are too many large ones.
    fn change_small(&mut self, plane: &mut Strips, kind: Kind, most: u32) -> bool {
        let (caps, mut large) = (std::mem::take(&mut self.caps), 0);
        for cap in &caps {
            let at = [cap.x, cap.y].map(usize::from);
            large += match self.follow(plane, kind, at, most) {
                Size::Small => 0,
                Size::Large => 1,
                Size::Intricate => MOST_LARGE + 1,
            };
            if large > MOST_LARGE {
                break;
            }
        }
        self.caps = caps;
        large <= MOST_LARGE
    }

    /// Inverts the piece that contains pixel (x, y) if it is small and, for a hole, not at the
    /// image's edge.
    fn follow(&mut self, plane: &mut Strips, kind: Kind, [x, y]: [usize; 2], most: u32) -> Size {
        let (width, height) = (plane.shape.width(), plane.shape.height());
        let value = kind == Kind::Specks;
        if plane.get(x, y) != value {
            // Already inverted, from an earlier cap.
            return Size::Small;
        }
        let reach = usize::from(kind == Kind::Specks);
        self.runs.clear();
        self.take_run(plane, value, [x, y]);
        let (mut next, mut area, mut piece) = (0, 0, Size::Small);
        while next < self.runs.len() && piece == Size::Small {
            let Run { y, from, to } = self.runs[next];
            let [y, from, to] = [y, from, to].map(usize::from);
            next += 1;
            area += to - from;
            let at_edge = y == 0 || y + 1 == height || from == 0 || to == width;
            if area > most as usize || at_edge && kind == Kind::Holes {
                piece = Size::Large;
            }
            let (left, right) = (from.saturating_sub(reach), (to + reach).min(width));
            for y in [y.wrapping_sub(1), y + 1] {
                let mut x = left;
                while piece == Size::Small && y < height && x < right {
                    let Some(found) = next_of(plane, value, [x, y], right) else {
                        break;
                    };
                    x = self.take_run(plane, value, [found, y]) + 1;
                    if self.runs.len() == MOST_RUNS {
                        piece = Size::Intricate;
                    }
                }
            }
        }
        if piece != Size::Small {
            for &Run { y, from, to } in &self.runs {
                paint(plane, [y, from, to].map(usize::from), value);
            }
        }
        piece
    }

    /// Inverts the run that contains (x, y) and records it. Returns its end.
    fn take_run(&mut self, plane: &mut Strips, value: bool, [x, y]: [usize; 2]) -> usize {
        let width = plane.shape.width();
        let to = next_of(plane, !value, [x, y], width).unwrap_or(width);
        let from = last_of(plane, !value, [x, y]).map_or(0, |before| before + 1);
        paint(plane, [y, from, to], !value);
        let [y, from, to] = [y, from, to].map(|place| place as u16);
        self.runs.push(Run { y, from, to });
        usize::from(to)
    }
}

/// Result of following a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Size {
    Small,
    Large,
    /// The piece has more runs than are followed.
    Intricate,
}

/// Maximum number of runs in a plane of this shape.
fn budget_of(plane: &Strips) -> usize {
    budget(plane.shape.width(), plane.shape.height())
}

/// The search for caps, compiled for each kind of machine.
struct FindCaps<'a> {
    plane: &'a Strips,
    kind: Kind,
    most: u32,
    caps: &'a mut Vec<Cap>,
}

impl lariat_portable::NullaryFnOnce for FindCaps<'_> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        if self.kind == Kind::Specks {
            self.find::<true>()
        } else {
            self.find::<false>()
        }
    }
}

impl FindCaps<'_> {
    #[inline(always)]
    fn find<const SPECKS: bool>(self) -> usize {
        let (shape, words) = (&self.plane.shape, &self.plane.words[..]);
        let budget = budget_of(self.plane);
        let (mut runs, mut walks) = (0, 0);
        for (at, count) in self.plane.used.runs(shape) {
            let (strip, y) = shape.place(at);
            let inside = shape.inside(strip);
            for from in (0..count).step_by(BLOCK) {
                let (ends, begun) = caps::<SPECKS>(words, at + from, shape.stride, inside);
                runs += begun as usize;
                if ends == [0; BLOCK] || self.most == 0 {
                    continue;
                }
                if runs > budget {
                    return runs;
                }
                // The last block extends below the picture.
                let rows = BLOCK.min(shape.height() - y - from);
                for (k, mut ends) in ends.into_iter().enumerate().take(rows) {
                    let at = at + from + k;
                    while ends != 0 {
                        let bit = ends & ends.wrapping_neg();
                        ends ^= bit;
                        walks += 1;
                        if walks <= MOST_WALKS
                            && is_surely_larger::<SPECKS>(words, at, bit, inside, self.most)
                        {
                            continue;
                        }
                        self.caps.push(Cap {
                            x: (64 * strip) as u16 + bit.trailing_zeros() as u16,
                            y: (y + from + k) as u16,
                        });
                    }
                }
            }
        }
        runs
    }
}

/// Returns a pixel of each cap that may end in a word of the block at `at`, and the number of runs
/// of set pixels that begin in the block.
#[inline(always)]
fn caps<const SPECKS: bool>(
    words: &[u64],
    at: usize,
    stride: usize,
    inside: u64,
) -> ([u64; BLOCK], u32) {
    let [own, left] = [at, at - stride].map(|at| block(words, at));
    let [up, up_left, up_right] =
        [at - 1, at - 1 - stride, at - 1 + stride].map(|at| block(words, at));
    let (mut ends, mut runs) = ([0; BLOCK], [0; BLOCK]);
    for k in 0..BLOCK {
        let (here, west) = (own[k], own[k] << 1 | left[k] >> 63);
        runs[k] = (here & !west).count_ones();
        // The pixels of pieces, the starts of their runs, and the pixels that have no pixel of a
        // piece above them.
        let (own, begins, free) = if SPECKS {
            let above = up[k] | up[k] << 1 | up_left[k] >> 63 | up[k] >> 1 | up_right[k] << 63;
            (here, here & !west, here & !above)
        } else {
            let own = !here & inside;
            (own, own & west, own & up[k])
        };
        let first = begins & free;
        // Adding the starts to the free runs carries through each run to the bit behind it. If the
        // piece does not include that bit, its whole run was free.
        let sum = free.wrapping_add(first);
        let behind = sum & !free & !own;
        // A carry out of the word means that the run continues in the next word. It counts as a
        // possible cap.
        let carried = u64::from(sum < free) << 63;
        ends[k] = if first == 0 { 0 } else { behind >> 1 | carried };
    }
    (ends, runs.iter().sum())
}

/// Returns whether the part of a piece below its topmost pixel has more than `most` pixels. The
/// pixel is `bit` of the word at `at`, and the part stays within the column of words below. It is
/// found faster than the whole piece.
#[inline(always)]
fn is_surely_larger<const SPECKS: bool>(
    words: &[u64],
    at: usize,
    bit: u64,
    inside: u64,
    most: u32,
) -> bool {
    let (mut part, mut area) = (bit, 0);
    // Below the picture, nothing is set: a speck ends there, and a hole would be at the image's
    // edge.
    for &word in &words[at..] {
        let (own, reached) = if SPECKS {
            (word, part | part << 1 | part >> 1)
        } else {
            (!word & inside, part)
        };
        let seeds = own & reached;
        if seeds == 0 {
            return false;
        }
        // Carries run through the rest of each run, to the left and to the right.
        let rest = |own: u64, seeds: u64| own & !own.wrapping_add(seeds & !(seeds << 1));
        let back = rest(own.reverse_bits(), seeds.reverse_bits()).reverse_bits();
        part = seeds | rest(own, seeds) | back;
        area += part.count_ones();
        if area > most {
            return true;
        }
    }
    false
}

/// First pixel of row `y` with this value, from `x` on and before `end`.
fn next_of(plane: &Strips, value: bool, [x, y]: [usize; 2], end: usize) -> Option<usize> {
    let flip = if value { 0 } else { u64::MAX };
    let mut from = u64::MAX << (x % 64);
    for strip in x / 64..end.div_ceil(64) {
        let word = (plane.words[plane.shape.index(strip, y)] ^ flip) & from;
        if word != 0 {
            let found = 64 * strip + word.trailing_zeros() as usize;
            return (found < end).then_some(found);
        }
        from = u64::MAX;
    }
    None
}

/// Last pixel of row `y` with this value, up to `x`.
fn last_of(plane: &Strips, value: bool, [x, y]: [usize; 2]) -> Option<usize> {
    let flip = if value { 0 } else { u64::MAX };
    let mut to = u64::MAX >> (63 - x % 64);
    for strip in (0..=x / 64).rev() {
        let word = (plane.words[plane.shape.index(strip, y)] ^ flip) & to;
        if word != 0 {
            return Some(64 * strip + 63 - word.leading_zeros() as usize);
        }
        to = u64::MAX;
    }
    None
}

/// Sets pixels `from..to` of row `y` to `value`.
fn paint(plane: &mut Strips, [y, from, to]: [usize; 3], value: bool) {
    let mut x = from;
    while x < to {
        let end = to.min((x / 64 + 1) * 64);
        let bits = (u64::MAX >> (64 - (end - x))) << (x % 64);
        let word = &mut plane.words[plane.shape.index(x / 64, y)];
        if value {
            *word |= bits;
        } else {
            *word &= !bits;
        }
        x = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Specks dropped and holes filled, by caps and by labeling all pieces.
    fn both(plane: &BitPlane, limit: u32) -> [[BitPlane; 2]; 2] {
        let (mut pieces, mut components) = (Pieces::default(), Components::default());
        let mut by_caps = [Strips::default(), Strips::default()];
        by_caps.iter_mut().for_each(|strips| strips.take(plane));
        let mut by_labels = [plane.clone(), plane.clone()];
        let [specks, holes] = &mut by_caps;
        assert!(pieces.drop_specks(specks, limit).is_ok());
        assert!(pieces.fill_holes(holes, limit).is_ok());
        let [specks, holes] = &mut by_labels;
        assert!(components.drop_specks(specks, limit).is_ok());
        assert!(components.fill_holes(holes, limit).is_ok());
        // The strips are written over the original plane, as they are for the mask.
        let by_caps = by_caps.map(|strips| {
            let mut written = plane.clone();
            strips.put(&mut written);
            written
        });
        [by_caps, by_labels]
    }

    proptest! {
        #[test]
        fn caps_find_what_labeling_finds(
            width in 1usize..200, height in 1usize..24,
            words in proptest::collection::vec(any::<u64>(), 96),
            density in 0u32..4, scale in 1usize..12, limit in 0u32..150,
        ) {
            let mut plane = BitPlane::default();
            plane.resize(width, height);
            for y in 0..height {
                for x in 0..width {
                    // Small or large squares, few or many.
                    let (i, j) = (x / scale, y / scale.min(3));
                    let bits = |k: usize| words[(4 * j + i / 64 + k) % 96] >> (i % 64) & 1 == 1;
                    let set = match density {
                        0 => bits(0) && bits(7) && bits(31),
                        1 => bits(0) && bits(7),
                        2 => bits(0),
                        _ => bits(0) || bits(7),
                    };
                    plane.fill(y, x, x + 1, set);
                }
            }
            let [by_caps, by_labels] = both(&plane, limit);
            prop_assert_eq!(&by_caps[0], &by_labels[0]);
            prop_assert_eq!(&by_caps[1], &by_labels[1]);
        }
    }

    #[test]
    fn a_comb_of_more_teeth_than_are_followed_is_labeled() {
        let mut plane = BitPlane::default();
        plane.resize(600, 40);
        for x in (0..600).step_by(2) {
            (5..12).for_each(|y| plane.fill(y, x, x + 1, true));
        }
        plane.fill(12, 0, 600, true);
        // A speck in a block of its own.
        plane.fill(35, 10, 14, true);
        let [by_caps, by_labels] = both(&plane, 50);
        assert_eq!(by_caps, by_labels);
        assert!(!by_caps[0].get(12, 35));
    }
}
