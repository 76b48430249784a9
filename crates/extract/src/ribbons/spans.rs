//! Finds the stretches between two edges on a scan line.

use lariat_portable::{Arch, NullaryFnOnce};

use super::{Color, STEP, distance, squared_distance};

/// Minimum change of color over two pixels at an edge, as a multiple of the picture's noise and in
/// levels.
const EDGE: (f32, f32) = (2.0, 5.0);
/// Minimum width of a span, in pixels.
const NARROWEST_PX: f32 = 3.0;
/// Distance from its edges at which a span's own color is read, and the minimum width for this, in
/// pixels.
const INSIDE_PX: (f32, f32) = (1.5, 6.0);
/// Nearest and farthest distance from an edge at which the ground is read, in pixels.
const BESIDE_PX: (f32, f32) = (1.5, 4.5);
/// Weight of a span's variation in brightness, relative to that in chroma: a round rope is shaded.
const SHADED: f32 = 0.25;
/// Minimum distance of a span from what is next to it, in levels, and relative to its own spread
/// and noise. The first value is for a span of probability 0, and the second for one of probability
/// 1.
const APART: (f32, f32) = (14.0, 8.0);
const QUALITY: (f32, f32) = (1.5, 0.8);
/// A span below the probability `LIKELY` must have the quality and distance `PLAIN`. `LIKELY_WORTH`
/// is the weight of the probability in a span's worth.
const PLAIN: (f32, f32) = (3.0, 30.0);
const LIKELY: f32 = 0.3;
const LIKELY_WORTH: f32 = 2.0;
/// Variation of any color in levels, and the share of the picture's noise that counts: the mean of
/// a span has less noise than a pixel.
const LEVELS: f32 = 3.0;
const NOISE: f32 = 0.5;
/// Maximum number of edges and of spans that are kept per line.
pub(super) const MOST: usize = 128;
/// Quality at which a span is worth 0, maximum quality that counts, and minimum worth.
const WORTH: (f32, f32, f32) = (1.0, 4.0, 0.3);

/// A stretch of a scan line between two edges, of a color that differs from those next to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// Number of the line, and the positions of the edges on it.
    pub(super) line: u32,
    pub(super) from: f32,
    pub(super) to: f32,
    pub(super) color: Color,
    /// Colors before it and after it.
    pub(super) sides: [Color; 2],
    pub(super) quality: f32,
    /// Worth of the span alone.
    pub(super) worth: f32,
}

impl Span {
    pub(super) fn middle(&self) -> f32 {
        0.5 * (self.from + self.to)
    }

    pub(super) fn width_px(&self) -> f32 {
        self.to - self.from
    }

    /// Position of the line.
    pub(super) fn line_px(&self) -> f32 {
        (self.line as usize * STEP + STEP / 2) as f32
    }
}

/// A place where the color changes, with the data for a span that begins or ends there.
#[derive(Debug)]
struct Edge {
    at: f32,
    /// The nearest pixel.
    nearest: usize,
    /// First pixel of a narrow span that begins here, and of a wide one.
    first: [usize; 2],
    /// Index after the last pixel of a narrow span that ends here, and of a wide one.
    end: [usize; 2],
    /// Colors on either side, if there is room.
    before: Option<Color>,
    after: Option<Color>,
}

/// Running sums of the colors and of their squares, up to a pixel. Arrays of four numbers fill
/// registers.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    colors: [f64; 4],
    squares: [f64; 4],
}

/// Memory for a stretch of a line.
#[derive(Debug, Default)]
pub(super) struct Line {
    /// Squared changes over two pixels.
    steps: Vec<f32>,
    edges: Vec<Edge>,
    /// Sums up to each pixel.
    sums: Vec<Sum>,
    /// Probabilities of rope, summed up to each pixel.
    likely: Vec<f32>,
}

impl Line {
    /// Reserves the buffers for a line of this many pixels.
    pub(super) fn reserve(&mut self, pixels: usize) {
        self.steps.reserve(pixels);
        self.edges.reserve(MOST);
        self.sums.reserve(pixels + 1);
        self.likely.reserve(pixels + 1);
    }

    /// Adds the spans of a stretch of line number `line` that begins at `start`. None is wider than
    /// `widest_px`.
    ///
    /// The inputs are the stretch's colors and the probabilities that its pixels are rope. The
    /// line's own spans begin at index `own`. All stretches of a line together keep at most
    /// [`MOST`] spans.
    pub(super) fn spans(
        &mut self,
        (colors, likely): (&[Color], &[u8]),
        (line, start, own): (usize, usize, usize),
        (noise, widest_px): (f32, f32),
        spans: &mut Vec<Span>,
    ) {
        self.find_edges(colors, noise);
        if self.edges.len() < 2 {
            return;
        }
        self.sum_up(colors, likely);
        self.look_beside();
        let first = spans.len();
        for (i, from) in self.edges.iter().enumerate() {
            for to in &self.edges[i + 1..] {
                let width_px = to.at - from.at;
                if width_px > widest_px || spans.len() - own >= MOST {
                    break;
                }
                if width_px < NARROWEST_PX {
                    continue;
                }
                if let Some(span) = self.span([from, to], noise) {
                    spans.push(Span {
                        line: line as u32,
                        from: start as f32 + from.at,
                        to: start as f32 + to.at,
                        ..span
                    });
                }
            }
        }
        spans[first..].sort_unstable_by(|a, b| {
            let by_place = a.middle().total_cmp(&b.middle());
            by_place.then(a.from.total_cmp(&b.from))
        });
    }

    /// The span between two edges, if there is one. Cheap tests come first, because most pairs of
    /// edges are not spans.
    fn span(&self, [from, to]: [&Edge; 2], noise: f32) -> Option<Span> {
        let sides = [from.before?, to.after?];
        let is_wide = usize::from(to.at - from.at >= INSIDE_PX.1);
        let inside = self.between(from.first[is_wide], to.end[is_wide])?;
        let color = inside.color();
        let likely = self.likely(from.nearest, to.nearest);
        let apart = sides.map(|side| distance(color, side));
        let least = apart[0].min(apart[1]);
        // A rope that the network is certain of may be hard to see. A rope that it misses has to be
        // clearly visible.
        let is_unlikely = likely < LIKELY;
        if least < between(APART, likely) || is_unlikely && least < PLAIN.1 {
            return None;
        }
        let quality = least / (inside.spread() + NOISE * noise + LEVELS);
        if quality < between(QUALITY, likely) || is_unlikely && quality < PLAIN.0 {
            return None;
        }
        Some(Span {
            line: 0,
            from: from.at,
            to: to.at,
            color,
            sides,
            quality,
            worth: (quality.min(WORTH.1) - WORTH.0).max(WORTH.2) + LIKELY_WORTH * (likely - 0.5),
        })
    }

    /// Finds the places where the color changes most, between pixels.
    fn find_edges(&mut self, colors: &[Color], noise: f32) {
        let least = (EDGE.0 * noise).max(EDGE.1);
        self.steps.clear();
        self.steps.resize(colors.len().saturating_sub(2), 0.0);
        Arch::new().dispatch(Steps {
            colors,
            out: &mut self.steps,
        });
        self.edges.clear();
        // Roots are taken only where there may be an edge. The limit is slightly lower, to allow
        // for rounding.
        let low = 0.999 * least * least;
        for (i, near) in self.steps.windows(3).enumerate() {
            if near[1] <= low {
                continue;
            }
            let [before, here, after] = [near[0].sqrt(), near[1].sqrt(), near[2].sqrt()];
            if here > least && here >= before && here > after && self.edges.len() < MOST {
                let bend = before - 2.0 * here + after;
                let off = if bend < 0.0 {
                    0.5 * (before - after) / bend
                } else {
                    0.0
                };
                let at = (i + 2) as f32 + off.clamp(-0.5, 0.5);
                self.edges.push(Edge::new(at, colors.len()));
            }
        }
    }

    fn sum_up(&mut self, colors: &[Color], likely: &[u8]) {
        self.sums.resize(colors.len() + 1, Sum::default());
        self.likely.resize(colors.len() + 1, 0.0);
        Arch::new().dispatch(SumUp {
            colors,
            likely,
            sums: &mut self.sums,
            likely_sums: &mut self.likely,
        });
    }

    /// Reads the colors on either side of the edges.
    fn look_beside(&mut self) {
        let mut edges = std::mem::take(&mut self.edges);
        for edge in &mut edges {
            let last = self.sums.len() - 1;
            let color =
                |from: f32, to: f32| Some(self.between(first(from), end(to, last))?.color());
            edge.before = color(edge.at - BESIDE_PX.1, edge.at - BESIDE_PX.0);
            edge.after = color(edge.at + BESIDE_PX.0, edge.at + BESIDE_PX.1);
        }
        self.edges = edges;
    }

    /// Mean of some pixels, if there are any.
    #[inline(always)]
    fn between(&self, from: usize, to: usize) -> Option<Mean> {
        if to <= from {
            return None;
        }
        let (a, b) = (&self.sums[from], &self.sums[to]);
        let share = 1.0 / (to - from) as f64;
        Some(Mean {
            color: std::array::from_fn(|c| share * (b.colors[c] - a.colors[c])),
            square: std::array::from_fn(|c| share * (b.squares[c] - a.squares[c])),
        })
    }

    /// Probability that what is between two edges is rope.
    #[inline(always)]
    fn likely(&self, from: usize, to: usize) -> f32 {
        let from = from.min(to);
        (self.likely[to] - self.likely[from]) / (to - from).max(1) as f32
    }
}

impl Edge {
    /// Creates an edge at a place in a stretch of `pixels` pixels.
    fn new(at: f32, pixels: usize) -> Self {
        let inside = [0.5, INSIDE_PX.0];
        Self {
            at,
            nearest: ((at + 0.5) as usize).min(pixels),
            first: inside.map(|off_px| first(at + off_px)),
            end: inside.map(|off_px| end(at - off_px, pixels)),
            before: None,
            after: None,
        }
    }
}

/// The first whole pixel from a place on.
fn first(from: f32) -> usize {
    libm::ceilf(from).max(0.0) as usize
}

/// Index after the last pixel up to a place, of `pixels` in all.
fn end(to: f32, pixels: usize) -> usize {
    (libm::floorf(to) + 1.0).clamp(0.0, pixels as f32) as usize
}

/// Means of the colors of some pixels, and of their squares.
struct Mean {
    color: [f64; 4],
    square: [f64; 4],
}

impl Mean {
    fn color(&self) -> Color {
        [0, 1, 2].map(|c| self.color[c] as f32)
    }

    /// Deviation of the pixels from their mean, with little weight on shading.
    fn spread(&self) -> f32 {
        let [y, u, v] =
            [0, 1, 2].map(|c| (self.square[c] - self.color[c] * self.color[c]).max(0.0) as f32);
        (SHADED * y + u + v).sqrt()
    }
}

/// Computes the squared changes over two pixels.
struct Steps<'a> {
    colors: &'a [Color],
    out: &'a mut [f32],
}

impl NullaryFnOnce for Steps<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let pairs = self.colors.iter().zip(self.colors.iter().skip(2));
        for (out, (a, b)) in self.out.iter_mut().zip(pairs) {
            *out = squared_distance(*a, *b);
        }
    }
}

/// Computes the sums up to each pixel.
struct SumUp<'a> {
    colors: &'a [Color],
    likely: &'a [u8],
    sums: &'a mut [Sum],
    likely_sums: &'a mut [f32],
}

impl NullaryFnOnce for SumUp<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (mut sum, mut likely_sum) = (Sum::default(), 0.0);
        let pixels = self.colors.iter().zip(self.likely);
        let sums = self.sums.iter_mut().zip(&mut *self.likely_sums);
        for ((out, likely_out), (&[y, u, v], &likely)) in sums.zip(pixels) {
            (*out, *likely_out) = (sum, likely_sum);
            let color = [y, u, v, 0.0].map(f64::from);
            for (c, level) in color.into_iter().enumerate() {
                sum.colors[c] += level;
                sum.squares[c] += level * level;
            }
            likely_sum += f32::from(likely) / 255.0;
        }
        let last = self.colors.len();
        (self.sums[last], self.likely_sums[last]) = (sum, likely_sum);
    }
}

/// Interpolates from one bound to the other by a share of the way.
fn between((from, to): (f32, f32), share: f32) -> f32 {
    from + share * (to - from)
}
