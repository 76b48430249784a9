//! Whether something new is in the rest of the image: colors in a few of its rows that were not there.
//!
//! Of every sixteenth row the range of colors in each block of sixteen pixels is kept; an eighth of these rows is looked at
//! in each frame. What leaves the range is new. Where much leaves it, the camera moves: then only that is new which is in no
//! block around either. An alarm after which nothing new was found is followed by a time of quiet, each time longer.

use super::rope::Rope;
use crate::image::{Image, color};

/// Rows from one that is kept to the next, and pixels of a block.
const APART: usize = 16;
/// Frames in which all of them are looked at.
const PHASES: usize = 8;
/// Pixels from one that is looked at in a row to the next.
const STEP: usize = 4;
/// Pixels that are looked at in a block.
const SAMPLES: usize = APART / STEP;
/// Levels by which a color lies outside of a range.
const LEVELS: f32 = 32.0;
/// Blocks in which something is new that are more than noise: in one frame, and in all that look at all rows.
const LEAST_BLOCKS: usize = 2;
const LEAST_IN_ALL: usize = 3;
/// The share of blocks whose colors change when the camera or the light does.
const MOVING: f32 = 0.15;
/// Frames of quiet after an alarm, at first and at most.
const QUIET: (u32, u32) = (4, 32);

/// The least and the largest of each channel in a block.
#[derive(Clone, Copy, Debug, Default)]
struct Range {
    low: [u8; 4],
    high: [u8; 4],
}

/// What is remembered of the image.
#[derive(Debug, Default)]
pub(super) struct Novelty {
    blocks: Vec<Range>,
    now: Vec<Range>,
    /// Blocks in a row.
    columns: usize,
    rows: usize,
    /// Whether a rope is near each block, and was when it was kept.
    near: Vec<bool>,
    was_near: Vec<bool>,
    places: Vec<usize>,
    samples: Vec<u32>,
    phase: usize,
    /// Blocks in which something was new when a phase was last looked at.
    new: [usize; PHASES],
    /// Frames until an alarm is given again, and how many it will be after that.
    quiet: u32,
    wait: u32,
    /// Ropes when the last alarm was given.
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

    /// Keeps the image of the moment.
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
        // An alarm that led to another number of ropes was none in vain.
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

    /// Whether something is new in the image.
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
        // All of it is new: another light, or another place.
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

    /// Keeps what was seen in a row; what is new in it only once an alarm may be given for it.
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

    /// The colors in the blocks of a row.
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

    /// The range of colors in a block and those about it.
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

    /// Marks the blocks that a rope is near.
    fn mark(&mut self, ropes: &[Rope]) {
        self.near.clear();
        self.near.resize(self.columns * self.rows, false);
        let side = APART as f32;
        for rope in ropes {
            // The way from one place that is marked to the next is within the reach.
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
                // A row is its first one of pixels.
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

    /// Whether some of it lies outside of another by more than a tolerance.
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
