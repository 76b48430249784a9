//! Errors of measured curves relative to the true ones.
//!
//! Each measured curve is compared with the true rope to which its points have the smallest mean
//! distance. Its error is the distance of each of its points from that rope, at any position along
//! it. A gripper would miss the rope by this distance. In addition, each point is compared with the
//! true point at the same ρ, in the better of both directions. This detects a curve that lies on
//! the rope but ends too early.

use crate::polyline::{Point, Polyline, Polylines, between};
use crate::saved::{RestoreError, Saved, Saving};
use crate::summary::Distances;
use crate::times::{self, histogram};
use hdrhistogram::Histogram;
use lariat_message::MAX_POINTS;

/// Histograms count thousandths of a pixel, up to 100 000 px.
const PER_PX: f64 = 1000.0;
const FARTHEST: u64 = 100_000_000;

/// Distribution of distances. Mean and maximum are exact. Percentiles are accurate to a thousandth
/// of a pixel, and above 2 px to a thousandth of their value.
#[derive(Debug, Clone)]
pub(crate) struct Heap {
    sum_px: f64,
    max_px: f64,
    histogram: Histogram<u64>,
}

impl Heap {
    fn new() -> Self {
        Self {
            sum_px: 0.0,
            max_px: 0.0,
            histogram: histogram(FARTHEST, 3),
        }
    }

    fn add(&mut self, distance_px: f64) {
        self.sum_px += distance_px;
        self.max_px = self.max_px.max(distance_px);
        self.histogram
            .saturating_record((distance_px * PER_PX).round() as u64);
    }

    /// Copies another distribution.
    fn set_to(&mut self, other: &Self) {
        (self.sum_px, self.max_px) = (other.sum_px, other.max_px);
        self.histogram
            .set_to(&other.histogram)
            .expect("all heaps have the same bounds");
    }

    fn save(&self, to: &mut Saving) {
        times::save(&self.histogram, to);
        to.real(self.sum_px);
        to.real(self.max_px);
    }

    fn restore(from: &mut Saved) -> Result<Self, RestoreError> {
        let mut heap = Self::new();
        times::restore(&mut heap.histogram, from)?;
        (heap.sum_px, heap.max_px) = (from.real()?, from.real()?);
        Ok(heap)
    }

    /// Returns the sum and the number of the distances.
    pub(crate) fn sum(&self) -> (f64, u64) {
        (self.sum_px, self.histogram.len())
    }

    /// Returns the figures. They are empty if there is no distance.
    pub(crate) fn distances(&self) -> Distances {
        if self.histogram.is_empty() {
            return Distances::default();
        }
        let rounded = |px: f64| Some((px * 1e4).round() / 1e4);
        let within = |share| {
            let px = self.histogram.value_at_quantile(share) as f64 / PER_PX;
            rounded(px.min(self.max_px))
        };
        Distances {
            mean: rounded(self.sum_px / self.histogram.len() as f64),
            p95: within(0.95),
            p999: within(0.999),
            max: rounded(self.max_px),
        }
    }
}

/// Comparison of one kind of curve with the truth.
#[derive(Debug, Clone)]
pub(crate) struct Comparison {
    /// Distances to the rope, at any position along it.
    pub(crate) nearest: Heap,
    /// Distances to the true point at the same ρ. Only for open curves.
    pub(crate) point_by_point: Heap,
    /// Frames with a known truth.
    pub(crate) frames: u64,
    /// Frames that contain a rope but no curve at all.
    pub(crate) frames_without_curve: u64,
    /// True ropes, over all frames, to which no curve was matched.
    pub(crate) ropes_without_curve: u64,
    /// Curves with an invalid coordinate, or in a frame without a rope.
    pub(crate) curves_of_nothing: u64,
}

impl Comparison {
    pub(crate) fn new() -> Self {
        Self {
            nearest: Heap::new(),
            point_by_point: Heap::new(),
            frames: 0,
            frames_without_curve: 0,
            ropes_without_curve: 0,
            curves_of_nothing: 0,
        }
    }

    /// Copies another comparison if it has changed since the last call.
    fn follow(&mut self, other: &Self) {
        if self.frames == other.frames {
            return;
        }
        self.nearest.set_to(&other.nearest);
        self.point_by_point.set_to(&other.point_by_point);
        self.frames = other.frames;
        self.frames_without_curve = other.frames_without_curve;
        self.ropes_without_curve = other.ropes_without_curve;
        self.curves_of_nothing = other.curves_of_nothing;
    }

    fn save(&self, to: &mut Saving) {
        self.nearest.save(to);
        self.point_by_point.save(to);
        to.numbers([
            self.frames,
            self.frames_without_curve,
            self.ropes_without_curve,
            self.curves_of_nothing,
        ]);
    }

    fn restore(from: &mut Saved) -> Result<Self, RestoreError> {
        Ok(Self {
            nearest: Heap::restore(from)?,
            point_by_point: Heap::restore(from)?,
            frames: from.count()?,
            frames_without_curve: from.count()?,
            ropes_without_curve: from.count()?,
            curves_of_nothing: from.count()?,
        })
    }

    /// Begins a frame.
    pub(crate) fn frame<'a>(&'a mut self, truth: &'a Polylines) -> Frame<'a> {
        Frame {
            comparison: self,
            truth,
            curves: 0,
            matched: 0,
        }
    }
}

/// All comparisons with the truth.
#[derive(Debug, Clone)]
pub(crate) struct Compared {
    /// Comparison of centerlines with the truth.
    pub(crate) centerline: Comparison,
    /// Comparison of fitted curves with the truth.
    pub(crate) curve: Comparison,
    /// Number of fitted curves that this version cannot draw.
    pub(crate) unknown_basis: u64,
    /// True if the unit of fitted curves differs from that of the truth, which is image pixels.
    pub(crate) elsewhere: bool,
}

impl Compared {
    pub(crate) fn new() -> Self {
        Self {
            centerline: Comparison::new(),
            curve: Comparison::new(),
            unknown_basis: 0,
            elsewhere: false,
        }
    }

    /// Returns the comparison for the live line: that of centerlines or, if there are none, that of
    /// curves.
    pub(crate) fn shown(&self) -> &Comparison {
        match self.centerline.frames {
            0 => &self.curve,
            _ => &self.centerline,
        }
    }

    /// Copies what has changed in `other` since the last call.
    pub(crate) fn follow(&mut self, other: &Self) {
        self.centerline.follow(&other.centerline);
        self.curve.follow(&other.curve);
        self.unknown_basis = other.unknown_basis;
        self.elsewhere = other.elsewhere;
    }

    pub(crate) fn save(&self, to: &mut Saving) {
        self.centerline.save(to);
        self.curve.save(to);
        to.numbers([self.unknown_basis, self.elsewhere.into()]);
    }

    pub(crate) fn restore(from: &mut Saved) -> Result<Self, RestoreError> {
        Ok(Self {
            centerline: Comparison::restore(from)?,
            curve: Comparison::restore(from)?,
            unknown_basis: from.count()?,
            elsewhere: from.flag()?,
        })
    }
}

/// The comparison of one frame. Must be ended with [`end`](Self::end).
pub(crate) struct Frame<'a> {
    comparison: &'a mut Comparison,
    truth: &'a Polylines,
    curves: u64,
    /// One bit for each true rope.
    matched: u32,
}

impl Frame<'_> {
    /// Adds a measured curve: its points in order, at most 256.
    pub(crate) fn curve(&mut self, points: impl Iterator<Item = Point>, closed: bool) {
        let mut buffer = [[0.0; 2]; MAX_POINTS];
        let mut count = 0;
        for (place, point) in buffer.iter_mut().zip(points) {
            *place = point;
            count += 1;
        }
        let points = &buffer[..count];
        let mut trial = [0.0; MAX_POINTS];
        let mut best: Option<(f64, usize, [f64; MAX_POINTS])> = None;
        // The rope at the same index is the most likely one. If it matches well, the others are
        // ruled out quickly.
        let ropes = self.truth.len();
        for index in (0..ropes).map(|i| (self.curves as usize + i) % ropes) {
            let rope = self.truth.get(index);
            let least = best.map_or(f64::INFINITY, |(least, ..)| least);
            if let Some(sum) = distances(points, &rope, least, &mut trial) {
                best = Some((sum, index, trial));
            }
        }
        let Some((_, index, nearest)) = best.filter(|_| count > 0) else {
            self.comparison.curves_of_nothing += 1;
            self.curves += 1;
            return;
        };
        self.curves += 1;
        self.matched |= 1 << index;
        for distance in &nearest[..count] {
            self.comparison.nearest.add(*distance);
        }
        let rope = self.truth.get(index);
        if !closed && !rope.closed {
            self.point_by_point(points, &rope);
        }
    }

    fn point_by_point(&mut self, points: &[Point], rope: &Polyline) {
        let last = points.len().saturating_sub(1).max(1) as f64;
        let along = |i: usize| between(points[i], rope.at(i as f64 / last));
        let against = |i: usize| between(points[i], rope.at(1.0 - i as f64 / last));
        let sum = |distance: &dyn Fn(usize) -> f64| (0..points.len()).map(distance).sum::<f64>();
        let better: &dyn Fn(usize) -> f64 = if sum(&along) <= sum(&against) {
            &along
        } else {
            &against
        };
        for i in 0..points.len() {
            self.comparison.point_by_point.add(better(i));
        }
    }

    /// Ends the frame: counts the ropes without a curve.
    pub(crate) fn end(self) {
        let ropes = self.truth.len();
        self.comparison.frames += 1;
        self.comparison.frames_without_curve += u64::from(ropes > 0 && self.curves == 0);
        self.comparison.ropes_without_curve += ropes as u64 - u64::from(self.matched.count_ones());
    }
}

/// Computes each point's distance from the rope, and their sum. Returns `None` as soon as the sum
/// reaches `least`.
fn distances(
    points: &[Point],
    rope: &Polyline,
    least: f64,
    into: &mut [f64; MAX_POINTS],
) -> Option<f64> {
    let longest_step = rope.longest_step();
    let scale = rope.points.len() as f64 / points.len() as f64;
    let mut sum = 0.0;
    for (i, (distance, point)) in into.iter_mut().zip(points).enumerate() {
        // Both lines are evenly spaced, so points at equal fractions of the indices are near each
        // other, unless the directions differ.
        *distance = rope.distance(*point, longest_step, (i as f64 * scale) as usize);
        sum += *distance;
        if sum >= least {
            return None;
        }
    }
    Some(sum)
}
