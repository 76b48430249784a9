//! Joins spans of neighboring scan lines by dynamic programming from line to line.

use std::ops::Range;

use super::picture::Picture;
use super::spans::{self, Line, Span};
use super::{Color, STEP, unlikeness};

/// Maximum width of a ribbon, as a share of the picture's longer side.
const WIDEST: f32 = 0.09;
/// Maximum sideways distance between spans of successive lines, in steps. Beyond it, the lines of
/// the other direction cut the ribbon better.
const ASIDE: f32 = 1.3;
/// Number of lines to look back, and the cost of each line that is left out.
const BACK: usize = 3;
const LEFT_OUT: f32 = 1.0;
/// Maximum difference in width, as a share and in pixels; maximum difference in color; maximum turn
/// of a chain from line to line.
const WIDTHS: (f32, f32) = (0.25, 1.0);
const UNLIKE: f32 = 16.0;
const TURN_PX: f32 = 3.0;
/// Cost of a pixel of turn, of a pixel of width, and of a level of color.
const COST: (f32, f32, f32) = (0.3, 0.3, 0.05);
/// Minimum probability, of 255, at which a rope is sought, and the distance around such pixels that
/// is searched as well, in pixels.
const POSSIBLE: u8 = 64;
const BESIDE: usize = 96;
/// Minimum number of spans in a chain.
const FEWEST: usize = 4;

/// Spans along a ribbon, line after line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chain {
    /// True if the lines are rows.
    pub(super) is_down: bool,
    /// Range of its spans in [`Chainer::links`].
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) worth: f32,
}

/// A span, and the best chain that ends with it. Holds only the fields that are read often.
#[derive(Clone, Copy, Debug)]
struct Link {
    middle: f32,
    width_px: f32,
    color: Color,
    /// Worth of the chain, its number of spans, and its slope.
    worth: f32,
    count: u32,
    slope: f32,
    /// The span before this one.
    before: Option<u32>,
    is_taken: bool,
}

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(super) struct Chainer {
    column: Column,
    line: Line,
    spans: Vec<Span>,
    /// One per span.
    ends: Vec<Link>,
    /// Index of the first span of each line.
    starts: Vec<usize>,
    order: Vec<u64>,
    /// The spans of all chains, one chain after the other.
    pub(super) links: Vec<Span>,
    /// The chains, the best first.
    pub(super) chains: Vec<Chain>,
}

impl Chainer {
    /// Reserves the buffers for a picture of this size.
    pub(super) fn reserve(&mut self, width: usize, height: usize) {
        let lines = width.max(height) / STEP + 1;
        self.column.reserve(width, height);
        self.line.reserve(width.max(height));
        let spans = lines * spans::MOST;
        self.spans.reserve(spans);
        self.ends.reserve(spans);
        self.order.reserve(spans);
        self.links.reserve(2 * spans);
        self.chains.reserve(2 * spans / FEWEST);
        self.starts.reserve(lines + 1);
    }

    /// Finds the chains of a picture, the best first.
    pub(super) fn run(&mut self, picture: &Picture) {
        self.links.clear();
        self.chains.clear();
        for is_down in [true, false] {
            self.cut(picture, is_down);
            for line in 0..self.starts.len() - 1 {
                self.join(line);
            }
            self.gather(is_down);
        }
        (self.chains)
            .sort_unstable_by(|a, b| b.worth.total_cmp(&a.worth).then(a.from.cmp(&b.from)));
    }

    /// Finds the spans of all rows, or of all columns.
    fn cut(&mut self, picture: &Picture, is_down: bool) {
        let lines = match is_down {
            true => picture.height / STEP,
            false => self.column.take(picture),
        };
        self.spans.clear();
        self.starts.clear();
        for number in 0..lines {
            let own = self.spans.len();
            self.starts.push(own);
            // Search only the stretches where ropes are likely.
            let mut from = 0;
            while let Some(stretch) = next_stretch(self.likely(picture, is_down, number), from) {
                from = stretch.end;
                self.add_spans(picture, is_down, (number, own), stretch);
            }
        }
        self.starts.push(self.spans.len());
        self.ends.clear();
        self.ends.extend(self.spans.iter().map(|span| Link {
            middle: span.middle(),
            width_px: span.width_px(),
            color: span.color,
            worth: span.worth,
            count: 1,
            slope: 0.0,
            before: None,
            is_taken: false,
        }));
    }

    /// Probabilities that the pixels of a line are rope.
    fn likely<'a>(&'a self, picture: &'a Picture, is_down: bool, number: usize) -> &'a [u8] {
        match is_down {
            true => picture.row(number * STEP + STEP / 2).1,
            false => self.column.likely(number),
        }
    }

    /// Adds the spans of a stretch of a line whose own spans begin at index `own`.
    fn add_spans(
        &mut self,
        picture: &Picture,
        is_down: bool,
        (number, own): (usize, usize),
        stretch: Range<usize>,
    ) {
        let place = (number, stretch.start, own);
        let widest_px = WIDEST * picture.width.max(picture.height) as f32;
        let limits = (picture.noise, widest_px);
        let (line, spans) = (&mut self.line, &mut self.spans);
        if is_down {
            let (colors, likely) = picture.row(number * STEP + STEP / 2);
            let stretch = (&colors[stretch.clone()], &likely[stretch]);
            line.spans(stretch, place, limits, spans);
        } else {
            self.column.gather(picture, number, stretch.clone());
            let colors = &self.column.colors[..stretch.len()];
            let likely = &self.column.likely(number)[stretch];
            line.spans((colors, likely), place, limits, spans);
        }
    }

    /// Finds, for each span of a line, the best chain that ends with it.
    fn join(&mut self, line: usize) {
        let (before, rest) = self.ends.split_at_mut(self.starts[line]);
        let own_count = self.starts[line + 1] - self.starts[line];
        // Spans are in order, so the start of the nearby ones only increases.
        let mut begins: [_; BACK] =
            std::array::from_fn(|k| self.starts[line.saturating_sub(k + 1)]);
        for own in &mut rest[..own_count] {
            let single = *own;
            for back in 1..=BACK.min(line) {
                let reach_px = ASIDE * (STEP * back) as f32;
                let (low, high) = (single.middle - reach_px, single.middle + reach_px);
                let begin = &mut begins[back - 1];
                let all = &before[..self.starts[line - back + 1]];
                while all.get(*begin).is_some_and(|other| other.middle < low) {
                    *begin += 1;
                }
                let left_out = LEFT_OUT * (back - 1) as f32;
                for (k, other) in all.iter().enumerate().skip(*begin) {
                    if other.middle > high {
                        break;
                    }
                    let both = other.worth + single.worth;
                    if both - left_out <= own.worth {
                        continue;
                    }
                    let moved = (single.middle - other.middle) / back as f32;
                    let Some(cost) = cost(&single, other, moved) else {
                        continue;
                    };
                    let sum = both - cost - left_out;
                    if sum > own.worth {
                        own.worth = sum;
                        own.before = Some(k as u32);
                        own.count = other.count + 1;
                        own.slope = match other.count {
                            1 => moved,
                            _ => 0.5 * (other.slope + moved),
                        };
                    }
                }
            }
        }
    }

    /// Takes the chains from the spans, the best first. Each span belongs to one chain.
    fn gather(&mut self, is_down: bool) {
        let Self {
            spans,
            ends,
            order,
            links,
            chains,
            ..
        } = self;
        order.clear();
        (order).extend(
            (0u32..)
                .zip(&*ends)
                .map(|(i, end)| falling(end.worth) | u64::from(i)),
        );
        order.sort_unstable();
        for &last in order.iter() {
            let (from, mut at) = (links.len(), Some(last as u32));
            let mut rest = 0.0;
            while let Some(i) = at {
                let end = &mut ends[i as usize];
                if end.is_taken {
                    rest = end.worth;
                    break;
                }
                end.is_taken = true;
                links.push(spans[i as usize]);
                at = end.before;
            }
            if links.len() - from < FEWEST {
                links.truncate(from);
                continue;
            }
            let worth = ends[last as u32 as usize].worth - rest;
            links[from..].reverse();
            chains.push(Chain {
                is_down,
                from,
                to: links.len(),
                worth,
            });
        }
    }
}

/// The next stretch of a line, from a pixel on, where ropes are likely, with a margin on both
/// sides.
fn next_stretch(likely: &[u8], from: usize) -> Option<Range<usize>> {
    let next = |from: usize, to: usize| {
        let some = likely[..to.min(likely.len())].get(from..)?;
        Some(from + some.iter().position(|&level| level >= POSSIBLE)?)
    };
    let first = next(from, likely.len())?;
    let mut last = first;
    while let Some(near) = next(last + 1, last + 2 * BESIDE) {
        last = near;
    }
    Some(first.saturating_sub(BESIDE)..(last + 1 + BESIDE).min(likely.len()))
}

/// Upper half of a sorting key that decreases as `worth` grows.
fn falling(worth: f32) -> u64 {
    let bits = worth.to_bits();
    let rising = match bits >> 31 {
        0 => bits | 1 << 31,
        _ => !bits,
    };
    u64::from(!rising) << 32
}

/// Columns of the picture.
#[derive(Debug, Default)]
struct Column {
    height: usize,
    /// Colors of a stretch.
    colors: Vec<Color>,
    /// Probabilities of all columns that lines run along, one column after the other.
    likely: Vec<u8>,
}

impl Column {
    fn reserve(&mut self, width: usize, height: usize) {
        self.colors.reserve(height);
        self.likely.reserve(width / STEP * height);
    }

    /// Reads the probabilities of all columns that lines run along. Returns their number.
    fn take(&mut self, picture: &Picture) -> usize {
        let (height, lines) = (picture.height, picture.width / STEP);
        self.height = height;
        self.colors.resize(height, [0.0; 3]);
        self.likely.resize(lines * height, 0);
        for y in 0..height {
            let row = picture.row(y).1.as_chunks::<STEP>().0;
            for (number, four) in row.iter().enumerate() {
                self.likely[number * height + y] = four[STEP / 2];
            }
        }
        lines
    }

    fn likely(&self, number: usize) -> &[u8] {
        &self.likely[number * self.height..][..self.height]
    }

    /// Reads the colors of a stretch of a column.
    fn gather(&mut self, picture: &Picture, number: usize, stretch: Range<usize>) {
        for (color, y) in self.colors.iter_mut().zip(stretch) {
            *color = picture.at(number * STEP + STEP / 2, y);
        }
    }
}

/// Cost of continuing from one span to another, `moved` pixels to the side per line; `None` if it
/// is not possible.
#[inline(always)]
fn cost(own: &Link, other: &Link, moved: f32) -> Option<f32> {
    let (width, before) = (own.width_px, other.width_px);
    let wider = (width - before).abs();
    if wider > WIDTHS.0 * width.max(before) + WIDTHS.1 {
        return None;
    }
    let turn = if other.count > 1 {
        (moved - other.slope).abs()
    } else {
        0.0
    };
    if turn > TURN_PX {
        return None;
    }
    let unlike = unlikeness(own.color, other.color);
    (unlike <= UNLIKE).then_some(COST.0 * turn + COST.1 * wider + COST.2 * unlike)
}
