//! What lies between two edges on a scan line.

use super::{Color, STEP, distance};

/// The least edge, in the picture's noise and in levels over two pixels.
const EDGE: (f32, f32) = (2.0, 5.0);
/// The narrowest span, in pixels.
const NARROWEST_PX: f32 = 3.0;
/// How far off its edges a span's own color is read, and from which width on.
const INSIDE_PX: (f32, f32) = (1.5, 6.0);
/// From where to where beside an edge the ground is read.
const BESIDE_PX: (f32, f32) = (1.5, 4.5);
/// What a span's brightness may vary, against its chroma: a round rope is shaded.
const SHADED: f32 = 0.25;
/// The least distance of a span from what lies beside it, in levels, and in its own spread and noise: of one that is hardly
/// likely, and of one that is certain.
const APART: (f32, f32) = (14.0, 8.0);
const QUALITY: (f32, f32) = (1.5, 0.8);
/// How likely a span is at least, unless it has this quality and distance from what lies beside it; and what it is worth.
const PLAIN: (f32, f32) = (3.0, 30.0);
const LIKELY: f32 = 0.3;
const LIKELY_WORTH: f32 = 2.0;
/// Levels that any color varies by, and how much of the picture's noise: the mean of a span has less of it than a pixel.
const LEVELS: f32 = 3.0;
const NOISE: f32 = 0.5;
/// The most edges and spans of a line that are kept.
pub(super) const MOST: usize = 128;
/// What a span is worth by its quality: from where on, at most, at least.
const WORTH: (f32, f32, f32) = (1.0, 4.0, 0.3);

/// A stretch of a scan line between two edges, of one color that is another than beside it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// The line's number, and where on it the edges lie.
    pub(super) line: usize,
    pub(super) from: f32,
    pub(super) to: f32,
    pub(super) color: Color,
    /// What lies before it and after it.
    pub(super) sides: [Color; 2],
    pub(super) quality: f32,
    /// The best chain that ends here: what it is worth, the span before this one, how many there are, and how it runs.
    pub(super) worth: f32,
    pub(super) before: Option<u32>,
    pub(super) count: u32,
    pub(super) slope: f32,
    pub(super) is_taken: bool,
}

impl Span {
    pub(super) fn middle(&self) -> f32 {
        0.5 * (self.from + self.to)
    }

    pub(super) fn width_px(&self) -> f32 {
        self.to - self.from
    }

    /// Where the line lies.
    pub(super) fn line_px(&self) -> f32 {
        (self.line * STEP + STEP / 2) as f32
    }
}

/// Memory for one line.
#[derive(Debug, Default)]
pub(super) struct Line {
    colors: Vec<Color>,
    /// How likely ropes are, summed up to each pixel.
    likely: Vec<f32>,
    steps: Vec<f32>,
    edges: Vec<f32>,
    /// Sums of the colors and of their squares up to each pixel.
    sums: Vec<[f64; 6]>,
}

impl Line {
    /// Makes the buffers for a line of so many pixels.
    pub(super) fn reserve(&mut self, pixels: usize) {
        self.colors.reserve(pixels);
        self.likely.reserve(pixels + 1);
        self.steps.reserve(pixels);
        self.edges.reserve(MOST);
        self.sums.reserve(pixels + 1);
    }

    /// Begins a stretch of a line.
    pub(super) fn clear(&mut self) {
        self.colors.clear();
        self.likely.clear();
        self.likely.push(0.0);
    }

    /// Adds a pixel: its color, and how likely it is of a rope.
    pub(super) fn push(&mut self, color: Color, likely: u8) {
        let before = self.likely[self.colors.len()];
        self.colors.push(color);
        self.likely.push(before + f32::from(likely) / 255.0);
    }

    /// Adds the spans of a stretch of line number `line`, which begins at `start`, none wider than `widest_px`. The line's own begin
    /// at `own`: of all its stretches together so many are kept.
    pub(super) fn spans(
        &mut self,
        line: usize,
        (start, own): (usize, usize),
        (noise, widest_px): (f32, f32),
        spans: &mut Vec<Span>,
    ) {
        self.find_edges(noise);
        self.sum_up();
        let first = spans.len();
        for (i, &from) in self.edges.iter().enumerate() {
            for &to in &self.edges[i + 1..] {
                let width_px = to - from;
                if width_px > widest_px || spans.len() - own >= MOST {
                    break;
                }
                if width_px < NARROWEST_PX {
                    continue;
                }
                let likely = self.likely([from, to]);
                let Some((color, spread, sides)) = self.look([from, to]) else {
                    continue;
                };
                let apart = sides.map(|side| distance(color, side));
                let least = apart[0].min(apart[1]);
                let quality = least / (spread + NOISE * noise + LEVELS);
                // What the network is sure of may be hard to see; what it misses has to be plain.
                let is_plain = quality >= PLAIN.0 && least >= PLAIN.1;
                if likely < LIKELY && !is_plain
                    || quality < between(QUALITY, likely)
                    || least < between(APART, likely)
                {
                    continue;
                }
                spans.push(Span {
                    line,
                    from: start as f32 + from,
                    to: start as f32 + to,
                    color,
                    sides,
                    quality,
                    worth: (quality.min(WORTH.1) - WORTH.0).max(WORTH.2)
                        + LIKELY_WORTH * (likely - 0.5),
                    before: None,
                    count: 1,
                    slope: 0.0,
                    is_taken: false,
                });
            }
        }
        spans[first..].sort_unstable_by(|a, b| {
            let by_place = a.middle().total_cmp(&b.middle());
            by_place.then(a.from.total_cmp(&b.from))
        });
    }

    /// Where the color changes most, between pixels.
    fn find_edges(&mut self, noise: f32) {
        let least = (EDGE.0 * noise).max(EDGE.1);
        self.steps.clear();
        (self.steps).extend(
            self.colors
                .windows(3)
                .map(|near| distance(near[0], near[2])),
        );
        self.edges.clear();
        for (i, near) in self.steps.windows(3).enumerate() {
            let [before, here, after] = [near[0], near[1], near[2]];
            if here > least && here >= before && here > after && self.edges.len() < MOST {
                let bend = before - 2.0 * here + after;
                let off = if bend < 0.0 {
                    0.5 * (before - after) / bend
                } else {
                    0.0
                };
                self.edges.push((i + 2) as f32 + off.clamp(-0.5, 0.5));
            }
        }
    }

    fn sum_up(&mut self) {
        let mut sum = [0.0; 6];
        self.sums.clear();
        self.sums.push(sum);
        for color in &self.colors {
            for (c, &level) in color.iter().enumerate() {
                let level = f64::from(level);
                sum[c] += level;
                sum[3 + c] += level * level;
            }
            self.sums.push(sum);
        }
    }

    /// The mean color between two places of the line and its variance, of whole pixels.
    fn mean(&self, from: f32, to: f32) -> Option<(Color, Color)> {
        let from = libm::ceilf(from).max(0.0) as usize;
        let to = (libm::floorf(to) + 1.0).clamp(0.0, self.colors.len() as f32) as usize;
        if to <= from {
            return None;
        }
        let (a, b) = (&self.sums[from], &self.sums[to]);
        let share = 1.0 / (to - from) as f64;
        let mean: [f64; 3] = std::array::from_fn(|c| share * (b[c] - a[c]));
        let variance = std::array::from_fn(|c| {
            (share * (b[3 + c] - a[3 + c]) - mean[c] * mean[c]).max(0.0) as f32
        });
        Some((mean.map(|level| level as f32), variance))
    }

    /// How likely it is of a rope what lies between two edges.
    fn likely(&self, [from, to]: [f32; 2]) -> f32 {
        let last = self.colors.len();
        let (from, to) = ((from + 0.5) as usize, ((to + 0.5) as usize).min(last));
        let from = from.min(to);
        (self.likely[to] - self.likely[from]) / (to - from).max(1) as f32
    }

    /// The color between two edges, its spread, and the colors beside.
    fn look(&self, [from, to]: [f32; 2]) -> Option<(Color, f32, [Color; 2])> {
        let off_px = if to - from < INSIDE_PX.1 {
            0.5
        } else {
            INSIDE_PX.0
        };
        let (color, [y, u, v]) = self.mean(from + off_px, to - off_px)?;
        let (before, _) = self.mean(from - BESIDE_PX.1, from - BESIDE_PX.0)?;
        let (after, _) = self.mean(to + BESIDE_PX.0, to + BESIDE_PX.1)?;
        Some((color, (SHADED * y + u + v).sqrt(), [before, after]))
    }
}

/// From one bound to another by a share of the way.
fn between((from, to): (f32, f32), share: f32) -> f32 {
    from + share * (to - from)
}
