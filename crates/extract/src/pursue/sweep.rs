//! A look at the rest of the image: a few rows of it in each frame, others in the next, so that something new is found.

use super::chord::Reader;
use crate::vec2::Vec2;

/// Rows from one that is read to the next: what is as high is seen at once, anything else within as many frames.
const APART: usize = 64;
/// Rows by which they move from frame to frame; it has no divisor in common with their distance.
const MOVE: usize = 13;
/// Side of the squares that the ropes' neighborhood is made of, in pixels.
const SQUARE: usize = 16;
/// Pixels side by side that are something.
const LEAST: u32 = 4;

/// Memory of the looking.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    phase: usize,
    /// One bit a square, whether a rope is near.
    near: Vec<u64>,
    words: usize,
    row: Vec<u8>,
    bits: Vec<u64>,
}

impl Sweep {
    /// Begins a frame of this size, with no rope anywhere.
    pub(super) fn begin(&mut self, width: usize, height: usize) {
        self.words = width.div_ceil(64 * SQUARE);
        self.near.clear();
        self.near.resize(self.words * height.div_ceil(SQUARE), 0);
        self.row.resize(width, 0);
        self.bits.resize(width.div_ceil(64), 0);
    }

    /// Notes that a rope lies within `reach_px` of a place.
    pub(super) fn note(&mut self, at: Vec2, reach_px: f32) {
        let square = |v: f32, most: usize| ((v.max(0.0) as usize) / SQUARE).min(most);
        let rows = self.near.len() / self.words;
        let [left, right] =
            [at[0] - reach_px, at[0] + reach_px].map(|x| square(x, 64 * self.words - 1));
        let [top, bottom] = [at[1] - reach_px, at[1] + reach_px].map(|y| square(y, rows - 1));
        let from = u64::MAX << (left % 64);
        let to = u64::MAX >> (63 - right % 64);
        for row in self
            .near
            .chunks_exact_mut(self.words)
            .take(bottom + 1)
            .skip(top)
        {
            if left / 64 == right / 64 {
                row[left / 64] |= from & to;
            } else {
                row[left / 64] |= from;
                row[left / 64 + 1..right / 64].fill(u64::MAX);
                row[right / 64] |= to;
            }
        }
    }

    /// Whether something stands out of the table by `level` in the rows of this frame, away from the ropes.
    pub(super) fn finds(&mut self, reader: &mut Reader, level: u8) -> bool {
        self.phase = (self.phase + MOVE) % APART;
        for y in (self.phase..reader.image.height()).step_by(APART) {
            reader
                .differencer
                .along(reader.image, reader.background, [0, y], &mut self.row);
            (reader.kernels.at_least)(&self.row, level, &mut self.bits);
            let near = &self.near[y / SQUARE * self.words..][..self.words];
            for (i, &word) in self.bits.iter().enumerate() {
                if word == 0 {
                    continue;
                }
                let mut away = word;
                for k in 0..64 / SQUARE {
                    let square = i * 64 / SQUARE + k;
                    if near[square / 64] >> (square % 64) & 1 == 1 {
                        away &= !(0xFFFF << (SQUARE * k));
                    }
                }
                if (1..LEAST).fold(away, |run, k| run & away >> k) != 0 {
                    return true;
                }
            }
        }
        false
    }
}
