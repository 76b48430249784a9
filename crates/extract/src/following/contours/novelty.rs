//! Detects new objects in the rest of the image, by colors that were not there before.
//!
//! Every sixteenth row is divided into blocks of sixteen pixels, and the range of colors in each
//! block is kept. Each frame checks an eighth of these rows. A color outside of its block's range
//! is new. If many blocks change, the camera is moving. Then a color is new only if it is also
//! outside of the ranges of the blocks around. After an alarm that finds nothing new, alarms are
//! suppressed for a time that grows with each repetition.

use super::rope::Rope;
use crate::image::{Image, color};

/// Distance between the rows that are kept, and length of a block, in pixels.
const APART: usize = 16;
/// Number of frames that check all rows once.
const PHASES: usize = 8;
/// Distance between the sampled pixels of a row.
const STEP: usize = 4;
/// Number of sampled pixels in a block.
const SAMPLES: usize = APART / STEP;
/// Minimum distance of a new color from a range, in levels.
const LEVELS: f32 = 32.0;
/// Minimum number of new blocks that is more than noise, in one frame.
const LEAST_BLOCKS: usize = 2;
/// Same over the frames that check all rows once.
const LEAST_IN_ALL: usize = 3;
/// Share of changed blocks above which the camera or the light has changed.
const MOVING: f32 = 0.15;
/// Number of frames for which alarms are suppressed, at first and at most.
const QUIET: (u32, u32) = (4, 32);

/// Minimum and maximum of each channel in a block.
#[derive(Clone, Copy, Debug, Default)]
struct Range {
    low: [u8; 4],
    high: [u8; 4],
}

/// State of the detection.
#[derive(Debug, Default)]
pub(super) struct Novelty {
    blocks: Vec<Range>,
    now: Vec<Range>,
    /// Number of blocks in a row.
    columns: usize,
    rows: usize,
    /// For each block, whether a rope is near.
    near: Vec<bool>,
    /// Same when the block was kept.
    was_near: Vec<bool>,
    places: Vec<usize>,
    samples: Vec<u32>,
    phase: usize,
    /// Number of new blocks in the last frame of each phase.
    new: [usize; PHASES],
    /// Number of frames until alarms are no longer suppressed.
    quiet: u32,
    /// Number of frames for which they were last suppressed.
    wait: u32,
    /// Number of ropes at the last alarm.
    ropes: Option<usize>,
}

impl Novelty {
    pub(super) fn reserve(&mut self, width: usize, height: usize) {
        let (columns, rows) = (width / APART, height.div_ceil(APART));
        self.blocks.reserve(columns * rows);
        self.now.reserve(columns);
        self.near.reserve(columns * rows);
        self.was_near.reserve(columns * rows);
        self.places.reserve(columns * SAMPLES);
        self.samples.reserve(columns * SAMPLES);
    }

    /// Keeps the current image.
    pub(super) fn keep(&mut self, image: &Image, ropes: &[Rope]) {
        let (columns, rows) = (image.width() / APART, image.height().div_ceil(APART));
        (self.columns, self.rows) = (columns, rows);
        self.places.clear();
        self.places
            .extend((0..columns * SAMPLES).map(|i| STEP * i + STEP / 2));
        self.samples.resize(columns * SAMPLES, 0);
        self.blocks.resize(columns * rows, Range::default());
        for row in 0..rows {
            self.look(image, row);
            let blocks = &mut self.blocks[columns * row..][..columns];
            blocks.copy_from_slice(&self.now);
        }
        self.mark(ropes);
        self.was_near.clone_from(&self.near);
        self.new = [0; PHASES];
        // An alarm was justified if it led to another number of ropes.
        if let Some(before) = self.ropes.take() {
            let in_vain = before == ropes.len();
            self.wait = if in_vain {
                (2 * self.wait).min(QUIET.1)
            } else {
                QUIET.0
            };
            self.quiet = if in_vain { self.wait } else { 0 };
        }
    }

    /// Returns whether something is new in the image.
    pub(super) fn is_in(&mut self, image: &Image, ropes: &[Rope]) -> bool {
        self.phase = (self.phase + 1) % PHASES;
        self.quiet = self.quiet.saturating_sub(1);
        self.mark(ropes);
        let tolerance = tolerance(image);
        let columns = self.columns;
        let (mut asked, mut changed, mut new) = (0usize, 0usize, 0usize);
        for row in (self.phase..self.rows).step_by(PHASES) {
            self.look(image, row);
            for column in 0..columns {
                let k = columns * row + column;
                if self.near[k] || self.was_near[k] {
                    continue;
                }
                asked += 1;
                if self.now[column].leaves(&self.blocks[k], tolerance) {
                    changed += 1;
                    new +=
                        usize::from(self.now[column].leaves(&self.around(row, column), tolerance));
                }
            }
            self.refresh(row, tolerance);
        }
        let is_moving = changed as f32 > MOVING * asked as f32;
        let found = if is_moving { new } else { changed };
        // Everything is new, so the light or the place has changed.
        let is_other = new as f32 > MOVING * asked as f32;
        self.new[self.phase] = if is_other || self.quiet > 0 { 0 } else { found };
        let in_all = self.new.iter().sum::<usize>();
        let alarm = self.new[self.phase] >= LEAST_BLOCKS || in_all >= LEAST_IN_ALL;
        if alarm {
            self.ropes = Some(ropes.len());
            self.wait = self.wait.max(QUIET.0);
        }
        alarm
    }

    /// Keeps the colors of a row. While alarms are suppressed, new colors are not kept.
    fn refresh(&mut self, row: usize, tolerance: [u8; 4]) {
        for column in 0..self.columns {
            let k = self.columns * row + column;
            let is_quiet = self.quiet > 0 && self.now[column].leaves(&self.blocks[k], tolerance);
            if !is_quiet {
                self.blocks[k] = self.now[column];
                self.was_near[k] = self.near[k];
            }
        }
    }

    /// Reads the color ranges of the blocks in a row.
    fn look(&mut self, image: &Image, row: usize) {
        color::at_places(
            image,
            APART * row,
            self.places.iter().copied(),
            &mut self.samples,
        );
        self.now.clear();
        for samples in self.samples.as_chunks::<SAMPLES>().0 {
            let mut range = Range {
                low: [255; 4],
                high: [0; 4],
            };
            for sample in samples {
                range.add(&sample.to_le_bytes(), &sample.to_le_bytes());
            }
            self.now.push(range);
        }
    }

    /// Color range of a block and those around it.
    fn around(&self, row: usize, column: usize) -> Range {
        let mut all = self.blocks[self.columns * row + column];
        for row in row.saturating_sub(1)..(row + 2).min(self.rows) {
            for column in column.saturating_sub(1)..(column + 2).min(self.columns) {
                let block = &self.blocks[self.columns * row + column];
                all.add(&block.low, &block.high);
            }
        }
        all
    }

    /// Marks the blocks near a rope.
    fn mark(&mut self, ropes: &[Rope]) {
        self.near.clear();
        self.near.resize(self.columns * self.rows, false);
        let side = APART as f32;
        for rope in ropes {
            // The distance between marked places is within the reach.
            let apart = ((APART as f32 / rope.spacing_px()) as usize).max(1);
            let reach_px = rope.reach_px() + 0.5 * apart as f32 * rope.spacing_px();
            let places = rope
                .stations
                .iter()
                .step_by(apart)
                .chain(rope.stations.last());
            for station in places {
                let span = |c: usize, count: usize| {
                    let from = ((station.at[c] - reach_px) / side).max(0.0) as usize;
                    let to = ((station.at[c] + reach_px) / side).max(0.0) as usize + 1;
                    from.min(count)..to.min(count)
                };
                // A block row is read at its first pixel row.
                let rows = span(1, self.rows);
                for row in rows.start..(rows.end + 1).min(self.rows) {
                    self.near[self.columns * row..][span(0, self.columns)].fill(true);
                }
            }
        }
    }
}

impl Range {
    #[inline(always)]
    fn add(&mut self, low: &[u8; 4], high: &[u8; 4]) {
        for c in 0..4 {
            self.low[c] = if low[c] < self.low[c] {
                low[c]
            } else {
                self.low[c]
            };
            self.high[c] = if high[c] > self.high[c] {
                high[c]
            } else {
                self.high[c]
            };
        }
    }

    /// Returns whether some of this range is outside of `other` by more than a tolerance.
    fn leaves(&self, other: &Self, tolerance: [u8; 4]) -> bool {
        let mut leaves = false;
        for (c, tolerance) in tolerance.into_iter().enumerate() {
            let most = other.high[c].saturating_add(tolerance);
            let least = other.low[c].saturating_sub(tolerance);
            leaves |= self.high[c] > most || self.low[c] < least;
        }
        leaves
    }
}

fn tolerance(image: &Image) -> [u8; 4] {
    let chroma = (LEVELS / color::chroma_weight(image.format())) as u8;
    [LEVELS as u8, chroma, chroma, 255]
}
