//! Spans of neighboring scan lines, put together: dynamic programming from line to line.

use super::picture::Picture;
use super::spans::{self, Line, Span};
use super::{STEP, unlikeness};

/// The widest ribbon, as a share of the picture's longer side.
const WIDEST: f32 = 0.09;
/// How far a span may lie aside of the one on the line before, in steps: beyond that the other lines cut it better.
const ASIDE: f32 = 1.3;
/// Lines that are looked back, and what each that is left out costs.
const BACK: usize = 3;
const LEFT_OUT: f32 = 1.0;
/// How far widths may differ, as a share and in pixels; how far colors may; and how far a chain may turn from line to line.
const WIDTHS: (f32, f32) = (0.25, 1.0);
const UNLIKE: f32 = 16.0;
const TURN_PX: f32 = 3.0;
/// What a pixel of turn and of width costs, and a level of color.
const COST: (f32, f32, f32) = (0.3, 0.3, 0.05);
/// How likely a rope is from which on it is looked for, of 255; and how far beside, in pixels.
const POSSIBLE: u8 = 64;
const BESIDE: usize = 96;
/// The fewest spans of a chain.
const FEWEST: usize = 4;

/// Spans along a ribbon, line after line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chain {
    /// Whether the lines are rows.
    pub(super) is_down: bool,
    /// Its spans, from where to where in [`Chainer::links`].
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) worth: f32,
}

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(super) struct Chainer {
    line: Line,
    spans: Vec<Span>,
    /// Where each line's spans begin.
    starts: Vec<usize>,
    order: Vec<u32>,
    /// The spans of all chains, one chain after the other.
    pub(super) links: Vec<Span>,
    /// The best first.
    pub(super) chains: Vec<Chain>,
}

impl Chainer {
    /// Makes the buffers for a picture of this size.
    pub(super) fn reserve(&mut self, width: usize, height: usize) {
        let lines = width.max(height) / STEP + 1;
        self.line.reserve(width.max(height));
        let spans = lines * spans::MOST;
        self.spans.reserve(spans);
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
            for line in 1..self.starts.len().saturating_sub(1) {
                self.join(line);
            }
            self.gather(is_down);
        }
        (self.chains)
            .sort_unstable_by(|a, b| b.worth.total_cmp(&a.worth).then(a.from.cmp(&b.from)));
    }

    /// The spans of all rows, or of all columns.
    fn cut(&mut self, picture: &Picture, is_down: bool) {
        let (width, height) = (picture.width, picture.height);
        let lines = if is_down { height } else { width } / STEP;
        let widest_px = WIDEST * width.max(height) as f32;
        self.spans.clear();
        self.starts.clear();
        for number in 0..lines {
            let own = self.spans.len();
            self.starts.push(own);
            let at = number * STEP + STEP / 2;
            let line = &mut self.line;
            let length = if is_down { width } else { height };
            let place = |i: usize| if is_down { (i, at) } else { (at, i) };
            let likely = |i: usize| {
                let (x, y) = place(i);
                picture.likely(x, y)
            };
            // Only stretches in which ropes are likely.
            let mut to = 0;
            while let Some(first) = (to..length).find(|&i| likely(i) >= POSSIBLE) {
                let from = first.saturating_sub(BESIDE);
                let mut last = first;
                while let Some(next) =
                    (last + 1..length.min(last + 2 * BESIDE)).find(|&i| likely(i) >= POSSIBLE)
                {
                    last = next;
                }
                to = (last + 1 + BESIDE).min(length);
                line.clear();
                for i in from..to {
                    let (x, y) = place(i);
                    line.push(picture.at(x, y), likely(i));
                }
                let limits = (picture.noise, widest_px);
                line.spans(number, (from, own), limits, &mut self.spans);
            }
        }
        self.starts.push(self.spans.len());
    }

    /// Finds for each span of a line the best chain that ends with it.
    fn join(&mut self, line: usize) {
        for i in self.starts[line]..self.starts[line + 1] {
            let own = self.spans[i];
            let mut best = own;
            for back in 1..=BACK.min(line) {
                let before = self.starts[line - back]..self.starts[line - back + 1];
                let reach_px = ASIDE * (STEP * back) as f32;
                let middle = own.middle();
                let spans = &self.spans[before.clone()];
                let first = spans.partition_point(|span| span.middle() < middle - reach_px);
                for (k, other) in spans.iter().enumerate().skip(first) {
                    if other.middle() > middle + reach_px {
                        break;
                    }
                    let moved = (middle - other.middle()) / back as f32;
                    let Some(cost) = cost(&own, other, moved) else {
                        continue;
                    };
                    let sum = other.worth + own.worth - cost - LEFT_OUT * (back - 1) as f32;
                    if sum > best.worth {
                        best.worth = sum;
                        best.before = Some((before.start + k) as u32);
                        best.count = other.count + 1;
                        best.slope = match other.count {
                            1 => moved,
                            _ => 0.5 * (other.slope + moved),
                        };
                    }
                }
            }
            self.spans[i] = best;
        }
    }

    /// Takes the chains out of the spans, the best first; a span belongs to one.
    fn gather(&mut self, is_down: bool) {
        let Self {
            spans,
            order,
            links,
            chains,
            ..
        } = self;
        order.clear();
        order.extend(0..spans.len() as u32);
        order.sort_unstable_by(|&a, &b| {
            let worth = |i: u32| spans[i as usize].worth;
            worth(b).total_cmp(&worth(a)).then(a.cmp(&b))
        });
        for &last in order.iter() {
            let (from, mut at) = (links.len(), Some(last));
            let mut rest = 0.0;
            while let Some(i) = at {
                let span = &mut spans[i as usize];
                if span.is_taken {
                    rest = span.worth;
                    break;
                }
                span.is_taken = true;
                links.push(*span);
                at = span.before;
            }
            if links.len() - from < FEWEST {
                links.truncate(from);
                continue;
            }
            let worth = links[from].worth - rest;
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

/// What it costs that a span goes on from another, which lies so far aside; nothing if it cannot.
fn cost(own: &Span, other: &Span, moved: f32) -> Option<f32> {
    let (width, before) = (own.width_px(), other.width_px());
    let wider = (width - before).abs();
    let unlike = unlikeness(own.color, other.color);
    let turn = if other.count > 1 {
        (moved - other.slope).abs()
    } else {
        0.0
    };
    let goes_on =
        wider <= WIDTHS.0 * width.max(before) + WIDTHS.1 && unlike <= UNLIKE && turn <= TURN_PX;
    goes_on.then_some(COST.0 * turn + COST.1 * wider + COST.2 * unlike)
}
