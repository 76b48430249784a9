//! Scans the rest of the image for new objects, a few rows in each frame and others in the next.

use super::chord::Reader;
use super::profile::{self, BLOCK, Lanes, Stretch, WORD, Work};
use crate::vec2::Vec2;

/// Distance between the rows of one frame. An object of that height is found at once, any other
/// within as many frames.
const APART: usize = 64;
/// Step of these rows from frame to frame. It is coprime to their distance.
const MOVE: usize = 13;
/// Side of the squares that mark the ropes' neighborhood, in pixels. Pixels that are read together
/// are in one square.
const SQUARE: usize = BLOCK;
/// Minimum number of adjacent pixels that are an object.
const LEAST: u32 = 4;
/// Number of squares whose table color is computed in parallel. It divides the number of squares in
/// a word of bits.
const SIDE: usize = 16;

/// State and buffers of the scan.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    phase: usize,
    /// One bit per square along each of the scanned rows, set if a rope is near.
    near: Vec<u64>,
    /// Words of bits per row.
    words: usize,
}

impl Sweep {
    /// Starts a frame of this size, without any rope.
    pub(super) fn begin(&mut self, width: usize, height: usize) {
        self.phase = (self.phase + MOVE) % APART;
        self.words = width.div_ceil(64 * SQUARE);
        let rows = height.saturating_sub(self.phase).div_ceil(APART);
        self.near.clear();
        self.near.resize(self.words * rows, 0);
    }

    /// Marks the squares within `reach_px` of a place on a rope.
    pub(super) fn note(&mut self, at: Vec2, reach_px: f32) {
        let square = |v: f32| v.max(0.0) as u32 as usize / SQUARE;
        let (left, right) = (square(at[0] - reach_px), square(at[0] + reach_px));
        let (top, bottom) = (square(at[1] - reach_px), square(at[1] + reach_px));
        let right = right.min(64 * self.words - 1);
        let (from, to) = (u64::MAX << (left % 64), u64::MAX >> (63 - right % 64));
        // Scanned rows that run through these squares.
        let first = (SQUARE * top + APART - 1 - self.phase) / APART;
        let count = (SQUARE * (bottom + 1) + APART - 1 - self.phase) / APART - first;
        let rows = self
            .near
            .chunks_exact_mut(self.words)
            .skip(first)
            .take(count);
        for row in rows {
            if left / 64 == right / 64 {
                row[left / 64] |= from & to;
            } else {
                row[left / 64] |= from;
                row[left / 64 + 1..right / 64].fill(u64::MAX);
                row[right / 64] |= to;
            }
        }
    }

    /// Returns whether something differs from the table by `level` in this frame's rows, away from
    /// the ropes.
    pub(super) fn finds(&mut self, reader: &Reader, level: u8) -> bool {
        let mut found = false;
        profile::dispatch(Scan {
            reader,
            sweep: self,
            level,
            found: &mut found,
        });
        found
    }
}

/// The scan of all rows.
struct Scan<'a, 'b> {
    reader: &'a Reader<'b>,
    sweep: &'a Sweep,
    level: u8,
    found: &'a mut bool,
}

impl Work for Scan<'_, '_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self {
            reader,
            sweep,
            level,
            found,
        } = self;
        let width = reader.image.width();
        for (k, near) in sweep.near.chunks_exact(sweep.words).enumerate() {
            let y = sweep.phase + APART * k;
            for x in (0..width).step_by(SIDE * SQUARE) {
                let square = x / SQUARE;
                let near = near[square / 64] >> (square % 64);
                *found |= part(reader, lanes, [x, y], near, level);
            }
            if *found {
                return;
            }
        }
    }
}

/// Returns whether something differs in [`SIDE`] squares, from a pixel on. It skips squares whose
/// bit in `near` is set.
#[inline(always)]
fn part(reader: &Reader, lanes: impl Lanes, [x, y]: [usize; 2], near: u64, level: u8) -> bool {
    let middles = std::array::from_fn(|i| (x + SQUARE * i + SQUARE / 2) as f32);
    let mut tables = [0u32; SIDE];
    (reader.background).at_all(&middles, &[y as f32; SIDE], &mut tables);
    let mut out = [0; WORD];
    let mut found = 0;
    let (tables, _) = tables.as_chunks::<{ WORD / SQUARE }>();
    for (i, &tables) in tables.iter().enumerate() {
        let from = x + WORD * i;
        // The pixels left at the end of a row are fewer than a square.
        let count = reader.image.width().saturating_sub(from).min(WORD) / SQUARE * SQUARE;
        let near = near >> (WORD / SQUARE * i) & 0xF;
        if count == 0 || near == 0xF {
            continue;
        }
        let set = lanes.read(
            &Stretch {
                image: reader.image,
                from: [from, y],
                axis: 0,
                count,
                tables,
                cut: level,
            },
            &mut out,
        );
        // Expands each bit to the sixteen pixels of its square.
        let squares = near & 1 | (near & 2) << 15 | (near & 4) << 30 | (near & 8) << 45;
        let away = set & !(squares * 0xFFFF);
        found |= (1..LEAST).fold(away, |run, k| run & away >> k);
    }
    found != 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rope_is_near_in_the_rows_that_run_by_it() {
        let mut sweep = Sweep::default();
        for _ in 0..APART {
            sweep.begin(1100, 500);
            let (at, reach_px) = ([1050.0, 200.0], 40.0);
            sweep.note(at, reach_px);
            for (k, near) in sweep.near.chunks_exact(sweep.words).enumerate() {
                let y = sweep.phase + APART * k;
                let square = |x: f32, y: f32| [x, y].map(|v| v as usize / SQUARE);
                let ([left, top], [right, bottom]) = (square(1010.0, 160.0), square(1090.0, 240.0));
                let rows = top..=bottom;
                for x in 0..1100 / SQUARE {
                    let expected = rows.contains(&(y / SQUARE)) && (left..=right).contains(&x);
                    assert_eq!(near[x / 64] >> (x % 64) & 1 == 1, expected, "{x} {y}");
                }
            }
        }
    }
}
