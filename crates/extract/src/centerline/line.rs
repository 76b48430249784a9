//! A rope's centerline as densely spaced samples: the stage between skeleton pixels and final
//! points.

use lariat_portable::{Arch, NullaryFnOnce};

use crate::image::gray::GrayPlane;
use crate::image::ray::LANES;
use crate::vec2::{self, Vec2};

/// Maximum number of lines made from the strands of one image. Further fragments of ropes are
/// ignored.
pub(crate) const MOST_PIECES: usize = 80;

/// One sample.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sample {
    pub(crate) at: Vec2,
    /// Weight of the measured position: 1 if measured in the image, 0 if not (inside of a
    /// crossing), [`OVERLAP`] where two strands are side by side.
    pub(crate) weight: f32,
    pub(crate) width_px: f32,
    /// In an overlap, the side on which this strand is: −1 at the edge along the tangent's −normal,
    /// 1 at the other.
    pub(crate) side: f32,
}

/// The weight of a sample in an overlap: only one of its edges is its own.
pub(crate) const OVERLAP: f32 = 0.2;

/// Samples in order. A closed line's last sample is joined to its first, which is not repeated.
#[derive(Debug, Default)]
pub(crate) struct Line {
    pub(crate) samples: Vec<Sample>,
    pub(crate) closed: bool,
    /// True for each end that leaves the image.
    pub(crate) border: [bool; 2],
}

impl Line {
    pub(crate) fn clear(&mut self) {
        self.samples.clear();
        self.closed = false;
        self.border = [false; 2];
    }

    /// Number of segments: between neighbors, and in a closed line also from last to first.
    fn segments(&self) -> usize {
        match self.samples.len() {
            0 | 1 => 0,
            n if self.closed => n,
            n => n - 1,
        }
    }

    pub(crate) fn length_px(&self) -> f32 {
        Arch::new().dispatch(Measuring(self))
    }

    /// Cuts off what is outside of the image at either end.
    pub(crate) fn cut_to(&mut self, image: &GrayPlane) {
        let leaves = |sample: Option<&Sample>| sample.is_some_and(|s| !image.holds(s.at));
        if leaves(self.samples.last()) {
            self.cut_last_to(image);
        }
        if leaves(self.samples.first()) {
            self.samples.reverse();
            self.cut_last_to(image);
            self.samples.reverse();
        }
    }

    fn cut_last_to(&mut self, image: &GrayPlane) {
        while let [.., before, last] = self.samples[..] {
            if image.holds(last.at) || self.samples.len() <= 2 {
                break;
            }
            self.samples.pop();
            if image.holds(before.at) {
                let part = image.part_within(before.at, last.at);
                self.samples.push(between(&before, &last, part));
                break;
            }
        }
    }

    /// Fills `out` with `count` samples at equal arc lengths: from tip to tip, or once around if
    /// closed. A stretch that touches a sample of weight 0 keeps weight 0.
    pub(crate) fn resample(&self, count: usize, out: &mut Vec<Sample>) {
        out.clear();
        let length_px = self.length_px();
        if self.segments() == 0 || length_px <= 0.0 {
            let count = if self.samples.is_empty() { 0 } else { count };
            out.extend(self.samples.iter().cycle().take(count));
            return;
        }
        Arch::new().dispatch(Resampling {
            line: self,
            length_px,
            count,
            out,
        });
    }

    /// Spaces the samples evenly, about `step_px` apart.
    pub(crate) fn space(&mut self, step_px: f32, spaced: &mut Vec<Sample>) {
        let steps = (self.length_px() / step_px).ceil().max(2.0) as usize;
        let count = if self.closed { steps } else { steps + 1 };
        self.resample(count, spaced);
        std::mem::swap(&mut self.samples, spaced);
    }

    /// The place this many pixels straight ahead of the first or last sample. The line must be open
    /// and have two or more samples.
    pub(crate) fn ahead(&self, last: bool, by_px: f32) -> Vec2 {
        let count = self.samples.len();
        let step_px = (self.length_px() / (count - 1) as f32).max(0.1);
        let back = ((by_px / step_px) as usize).clamp(1, count - 1);
        let at = |k: usize| self.samples[if last { count - 1 - k } else { k }].at;
        let out = vec2::unit_or(vec2::sub(at(0), at(back)), [1.0, 0.0]);
        vec2::along(at(0), out, by_px)
    }

    /// The greatest curvature (1 / radius) at any place that `is_seen`, measured over this many
    /// pixels to either side.
    pub(crate) fn sharpest(&self, reach_px: f32, is_seen: impl Fn(Vec2) -> bool) -> f32 {
        let count = self.samples.len();
        let step_px = (self.length_px() / (count.max(2) - 1) as f32).max(0.1);
        let reach = ((reach_px / step_px) as usize).max(1);
        let places = (reach..count.saturating_sub(reach)).filter(|&i| is_seen(self.samples[i].at));
        let bends = places.map(|i| {
            let [before, at, behind] = [i - reach, i, i + reach].map(|i| self.samples[i].at);
            vec2::angle(vec2::sub(at, before), vec2::sub(behind, at)).abs()
        });
        bends.fold(0.0, f32::max) / (reach as f32 * step_px)
    }

    /// The tangent at sample `i`, not normalized: that of the parabola through three samples
    /// `reach` apart. `i` is the middle one, except near an end of an open line.
    #[inline(always)]
    pub(crate) fn slope(&self, i: usize, reach: usize) -> Vec2 {
        let n = self.samples.len();
        let at = |i: usize| self.samples[i].at;
        if i >= reach && i + reach < n {
            return vec2::sub(at(i + reach), at(i - reach));
        }
        if self.closed {
            let (a, b) = ((i + n - reach % n) % n, (i + reach) % n);
            return vec2::sub(at(b), at(a));
        }
        let reach = reach.min((n - 1) / 2).max(1);
        let middle = i.clamp(
            reach.min(n - 1),
            (n - 1).saturating_sub(reach).max(reach.min(n - 1)),
        );
        let (a, b) = (middle.saturating_sub(reach), (middle + reach).min(n - 1));
        let (back, ahead) = (vec2::sub(at(middle), at(a)), vec2::sub(at(b), at(middle)));
        let aside = (i as f32 - middle as f32) / reach as f32;
        vec2::add(
            vec2::scale(back, 0.5 - aside),
            vec2::scale(ahead, 0.5 + aside),
        )
    }
}

/// Number of segments measured at once.
const BLOCK: usize = 64;

/// Lengths of some segments, and their reciprocals.
struct Spans {
    first: usize,
    px: [f32; BLOCK],
    shares: [f32; BLOCK],
}

impl Spans {
    const NONE: Self = Self {
        first: 0,
        px: [0.0; BLOCK],
        shares: [0.0; BLOCK],
    };

    /// Measures the line's segments from `first` on. Segments beyond the last have length 0.
    #[inline(always)]
    fn measure(&mut self, line: &Line, first: usize) {
        self.first = first;
        let mut ways = [[0.0; BLOCK]; 2];
        let samples = &line.samples[first..];
        for (k, (from, to)) in samples.iter().zip(&samples[1..]).enumerate().take(BLOCK) {
            ways[0][k] = to.at[0] - from.at[0];
            ways[1][k] = to.at[1] - from.at[1];
        }
        if let ([.., last], true) = (samples, line.closed && samples.len() <= BLOCK) {
            // This segment leads back to the first sample.
            let way = vec2::sub(line.samples[0].at, last.at);
            (ways[0][samples.len() - 1], ways[1][samples.len() - 1]) = (way[0], way[1]);
        }
        let [xs, ys] = &ways;
        for k in 0..BLOCK {
            let (x, y) = (xs[k], ys[k]);
            self.px[k] = (x * x + y * y).sqrt();
            let share = 1.0 / self.px[k];
            self.shares[k] = if self.px[k] > 0.0 { share } else { 0.0 };
        }
    }
}

/// Measures a line's length, for the widest registers.
struct Measuring<'a>(&'a Line);

impl NullaryFnOnce for Measuring<'_> {
    type Output = f32;

    #[inline(always)]
    fn call(self) -> f32 {
        let (mut spans, mut sums) = (Spans::NONE, [0.0; LANES]);
        for first in (0..self.0.segments()).step_by(BLOCK) {
            spans.measure(self.0, first);
            for spans in spans.px.as_chunks::<LANES>().0 {
                for l in 0..LANES {
                    sums[l] += spans[l];
                }
            }
        }
        sums.iter().sum()
    }
}

/// Takes samples at equal arc lengths, for the widest registers.
struct Resampling<'a> {
    line: &'a Line,
    length_px: f32,
    count: usize,
    out: &'a mut Vec<Sample>,
}

impl NullaryFnOnce for Resampling<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (samples, segments) = (&self.line.samples[..], self.line.segments());
        let intervals = if self.line.closed {
            self.count
        } else {
            self.count - 1
        };
        let step = f64::from(self.length_px) / intervals.max(1) as f64;
        let mut spans = Spans::NONE;
        spans.measure(self.line, 0);
        let (mut segment, mut passed) = (0, 0.0f64);
        let mut here = f64::from(spans.px[0]);
        let targets = (0..self.count).map(|k| {
            let target = step * k as f64;
            while passed + here < target && segment + 1 < segments {
                passed += here;
                segment += 1;
                if segment - spans.first == BLOCK {
                    spans.measure(self.line, segment);
                }
                here = f64::from(spans.px[segment % BLOCK]);
            }
            let t = (target - passed) as f32 * spans.shares[segment % BLOCK];
            // Only the last segment of a closed line leads back to the first sample.
            let next = if segment + 1 < samples.len() {
                segment + 1
            } else {
                0
            };
            between(&samples[segment], &samples[next], t.clamp(0.0, 1.0))
        });
        self.out.extend(targets);
    }
}

#[inline(always)]
fn between(a: &Sample, b: &Sample, t: f32) -> Sample {
    Sample {
        at: vec2::along(a.at, vec2::sub(b.at, a.at), t),
        weight: a.weight.min(b.weight),
        width_px: a.width_px + t * (b.width_px - a.width_px),
        side: a.side + t * (b.side - a.side),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: &[Vec2], closed: bool) -> Line {
        let samples = points
            .iter()
            .map(|&at| Sample {
                at,
                weight: 1.0,
                width_px: at[0],
                side: 0.0,
            })
            .collect();
        Line {
            samples,
            closed,
            border: [false; 2],
        }
    }

    #[test]
    fn a_corner_is_the_sharpest_bend_where_it_is_seen() {
        let mut at: Vec<_> = (0..=40).map(|x| [x as f32, 0.0]).collect();
        at.extend((1..=40).map(|y| [40.0, y as f32]));
        let corner = line(&at, false);
        // A quarter of a turn within ten pixels, like an arc of this length.
        let bend = corner.sharpest(10.0, |_| true);
        assert!((bend - 0.157).abs() < 0.01, "{bend}");
        assert!(corner.sharpest(10.0, |at| at[0] < 25.0) < 0.001);
    }

    #[test]
    fn equal_steps_run_from_tip_to_tip() {
        let mut out = Vec::new();
        line(&[[0.0, 0.0], [1.0, 0.0], [10.0, 0.0], [10.0, 10.0]], false).resample(5, &mut out);
        let at: Vec<_> = out.iter().map(|s| s.at).collect();
        assert_eq!(
            at,
            [
                [0.0, 0.0],
                [5.0, 0.0],
                [10.0, 0.0],
                [10.0, 5.0],
                [10.0, 10.0]
            ]
        );
        assert_eq!(out[1].width_px, 5.0);
    }

    #[test]
    fn a_ring_is_sampled_once_around() {
        let mut out = Vec::new();
        line(&[[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]], true).resample(4, &mut out);
        assert_eq!(out[3].at, [0.0, 10.0]);
    }
}
