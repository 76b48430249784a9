//! Resamples a line at equal steps of arc length, for points of an image seen through a map that
//! stretches unevenly.
//!
//! In each interval, the line through the points is a cubic parametrized by chord length
//! (Hermite's, with Bessel's tangents: those of the parabola through a point and its two
//! neighbors). Each new point is a mean of four old ones, so the effect of noise on it is known
//! ([`Noise`](crate::noise)). A straight line stays straight, with steps that are equal up to
//! rounding, however unevenly it was seen. On an arc of radius r with chords h, lengths are too
//! short by a fraction of h²/24r². This fraction is the same everywhere if the chords are equal.

use crate::options::MAX_POINTS;
use crate::point::Point;
use thiserror::Error;

/// Why points cannot be resampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ResampleError {
    /// Fewer than two points, or too many.
    #[error("{0} points make no line to walk along: give 2 to {MAX_POINTS}")]
    Count(usize),
    /// Two neighbors coincide, or a coordinate is not finite.
    #[error("point {0} lies where the next one does, or nowhere: there is no way between them")]
    NoStep(usize),
}

/// A new point as a mean of four old ones.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Mean {
    /// Indices of consecutive points. On a closed line, they may continue from the last point to
    /// the first.
    from: [usize; 4],
    pub(crate) weights: [f64; 4],
    /// Normalized arc length of the new point.
    pub(crate) rho: f64,
}

impl Mean {
    /// Old points of the mean, each with its weight.
    pub(crate) fn sources(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        let sources = self.from.into_iter().zip(self.weights);
        sources.filter(|(_, weight)| *weight != 0.0)
    }
}

/// Resamples lines of points at equal steps.
#[derive(Debug, Clone)]
pub struct Resampler<const D: usize = 2> {
    count: usize,
    closed: bool,
    length: f64,
    /// Arc length up to each point and, for a closed line, up to the first again.
    arcs: Vec<f64>,
    /// Directions of the chords from each point to the next.
    pub(crate) chords: Vec<[f64; D]>,
    pub(crate) means: Vec<Mean>,
    points: Vec<[f64; D]>,
}

impl<const D: usize> Default for Resampler<D> {
    fn default() -> Self {
        Self::in_dimensions()
    }
}

impl Resampler {
    /// Creates a resampler with memory for lines of [`MAX_POINTS`] points. It does not allocate
    /// afterwards.
    pub fn new() -> Self {
        Self::in_dimensions()
    }
}

impl<const D: usize> Resampler<D>
where
    [f64; D]: Point<D>,
{
    /// Resamples the line through these points with the same number of points at equal steps. The
    /// first point stays in place, and so does the last point of an open line.
    ///
    /// # Errors
    /// Fails if there are too few or too many points, or if two neighbors coincide.
    pub fn resample(
        &mut self,
        points: &[[f64; D]],
        closed: bool,
    ) -> Result<&[[f64; D]], ResampleError> {
        <[f64; D]>::resample(self, points, closed)
    }
}

impl<const D: usize> Resampler<D> {
    /// Like [`Resampler::new`], for points of any dimension.
    pub fn in_dimensions() -> Self {
        Self {
            count: 0,
            closed: false,
            length: 0.0,
            arcs: vec![0.0; MAX_POINTS + 1],
            chords: vec![[0.0; D]; MAX_POINTS],
            means: vec![Mean::default(); MAX_POINTS],
            points: vec![[0.0; D]; MAX_POINTS],
        }
    }

    /// Implements [`Resampler::resample`].
    pub(crate) fn even_out(
        &mut self,
        points: &[[f64; D]],
        closed: bool,
    ) -> Result<&[[f64; D]], ResampleError> {
        let count = points.len();
        if !(2..=MAX_POINTS).contains(&count) {
            return Err(ResampleError::Count(count));
        }
        (self.count, self.closed) = (count, closed);
        self.measure(points)?;
        let steps = if closed { count } else { count - 1 };
        let mut interval = 0;
        for k in 0..count {
            let rho = k as f64 / steps as f64;
            let target = rho * self.length;
            while interval + 1 < steps && self.arcs[interval + 1] <= target {
                interval += 1;
            }
            let mean = self.mean(interval, target, rho);
            self.means[k] = mean;
            self.points[k] = mean.sources().fold([0.0; D], |sum, (i, weight)| {
                std::array::from_fn(|axis| sum[axis] + weight * points[i][axis])
            });
        }
        Ok(&self.points[..count])
    }

    /// Length of the last line, in the points' unit.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Indices of the old points between which new point `k` is.
    pub fn between(&self, k: usize) -> [usize; 2] {
        let [_, before, after, _] = self.means[k].from;
        [before, after]
    }

    /// Interpolates values at the old points linearly at new point `k`.
    pub fn carry(&self, k: usize, values: &[f64]) -> f64 {
        let mean = &self.means[k];
        let [_, before, after, _] = mean.from;
        let (start, end) = (self.arcs[before], self.arcs[before + 1]);
        let share = ((mean.rho * self.length - start) / (end - start)).clamp(0.0, 1.0);
        values[before] + share * (values[after] - values[before])
    }

    /// Direction of the line at a new point.
    pub(crate) fn tangent(&self, mean: &Mean) -> [f64; D] {
        self.chords[mean.from[1]]
    }

    /// Share of a new point that comes from beyond a closed line's last point, minus the share from
    /// before its first.
    pub(crate) fn beyond_the_seam(&self, mean: &Mean) -> f64 {
        if !self.closed {
            return 0.0;
        }
        let interval = mean.from[1];
        let weights = mean.weights.iter().enumerate();
        let beyond = weights.map(|(step, weight)| match interval + step {
            0 => -weight,
            place if place > self.count => *weight,
            _ => 0.0,
        });
        beyond.sum()
    }

    /// The new points of the last line.
    pub(crate) fn points(&self) -> &[[f64; D]] {
        &self.points[..self.count]
    }

    /// Normalized arc length of the middle of the chord after old point `i`.
    pub(crate) fn middle(&self, i: usize) -> f64 {
        0.5 * (self.arcs[i] + self.arcs[i + 1]) / self.length
    }

    /// Number of points of the last line, and whether it was closed.
    pub(crate) fn shape(&self) -> (usize, bool) {
        (self.count, self.closed)
    }

    fn measure(&mut self, points: &[[f64; D]]) -> Result<(), ResampleError> {
        let steps = if self.closed {
            self.count
        } else {
            self.count - 1
        };
        self.arcs[0] = 0.0;
        for i in 0..steps {
            let (from, to) = (points[i], points[(i + 1) % self.count]);
            let way: [f64; D] = std::array::from_fn(|axis| to[axis] - from[axis]);
            let length = length(way);
            if !(length > 0.0 && length.is_finite()) {
                return Err(ResampleError::NoStep(i));
            }
            self.chords[i] = way.map(|c| c / length);
            self.arcs[i + 1] = self.arcs[i] + length;
        }
        self.length = self.arcs[steps];
        Ok(())
    }

    /// Length of the interval after point `i`, if there is one. On a closed line, `i` may be −1 or
    /// beyond the last.
    fn step(&self, i: isize) -> Option<f64> {
        let steps = if self.closed {
            self.count
        } else {
            self.count - 1
        };
        let i = if self.closed {
            i.rem_euclid(steps as isize) as usize
        } else {
            usize::try_from(i).ok().filter(|&i| i < steps)?
        };
        Some(self.arcs[i + 1] - self.arcs[i])
    }

    /// The point of the cubic in an interval at this arc length.
    fn mean(&self, interval: usize, target: f64, rho: f64) -> Mean {
        let i = interval as isize;
        let step = self.arcs[interval + 1] - self.arcs[interval];
        let u = ((target - self.arcs[interval]) / step).clamp(0.0, 1.0);
        let v = 1.0 - u;
        let mut weights = [0.0, (1.0 + 2.0 * u) * v * v, u * u * (3.0 - 2.0 * u), 0.0];
        let (before, after) = (self.step(i - 1), self.step(i + 1));
        // Tangents at both ends of the interval, in terms of the four points.
        let starts = tangent(before, step);
        let ends = tangent(after, step).map(|w| -w);
        let ends = [0.0, ends[2], ends[1], ends[0]];
        let [starts, ends] = match (before, after) {
            // At an open line's end, the parabola through its three points continues.
            (None, Some(_)) => [beside(ends, step), ends],
            (Some(_), None) => {
                let starts = [starts[0], starts[1], starts[2], 0.0];
                [starts, beside(starts, step)]
            }
            _ => [[starts[0], starts[1], starts[2], 0.0], ends],
        };
        for (at, weight) in weights.iter_mut().enumerate() {
            *weight += step * (u * v * v * starts[at] - u * u * v * ends[at]);
        }
        Mean {
            from: [self.count - 1, 0, 1, 2].map(|step| (interval + step) % self.count),
            weights,
            rho,
        }
    }
}

/// Length of a vector.
pub(crate) fn length<const D: usize>(way: [f64; D]) -> f64 {
    match way[..] {
        [x, y] => libm::hypot(x.abs(), y),
        _ => way.iter().map(|c| c * c).sum::<f64>().sqrt(),
    }
}

/// Weights of three consecutive points in the slope of their parabola at the middle one; `before`
/// and `step` are the distances between them. Without a previous point, the slope is that of the
/// chord.
fn tangent(before: Option<f64>, step: f64) -> [f64; 3] {
    match before {
        None => [0.0, -1.0 / step, 1.0 / step],
        Some(before) => {
            let both = before + step;
            [
                -step / (before * both),
                (step - before) / (step * before),
                before / (step * both),
            ]
        }
    }
}

/// Slope of a parabola at one end of an interval, given the slope at the other end: twice the
/// chord's slope, minus the given slope.
fn beside(other: [f64; 4], step: f64) -> [f64; 4] {
    let chord = [0.0, -2.0 / step, 2.0 / step, 0.0];
    std::array::from_fn(|at| chord[at] - other[at])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a map that stretches one end of an arc ten times as much as the other.
    fn uneven(count: usize, turn: f64) -> Vec<[f64; 2]> {
        (0..count)
            .map(|i| {
                let t = i as f64 / (count - 1) as f64;
                let s = t / (1.0 + 2.2 * (1.0 - t));
                let angle = turn * s;
                match turn {
                    0.0 => [400.0 * s, 300.0 * s],
                    _ => [
                        500.0 / turn * angle.sin(),
                        500.0 / turn * (1.0 - angle.cos()),
                    ],
                }
            })
            .collect()
    }

    #[test]
    fn a_straight_line_has_equal_steps_to_the_last_bits() {
        let mut resampler = Resampler::new();
        let even = resampler.resample(&uneven(120, 0.0), false).unwrap();
        for (k, point) in even.iter().enumerate() {
            let s = k as f64 / 119.0;
            assert!(
                (point[0] - 400.0 * s).hypot(point[1] - 300.0 * s) < 1e-9,
                "{k}: {point:?}"
            );
        }
        assert!((resampler.length() - 500.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_known_at_the_old_points_is_carried_to_the_new_ones() {
        let mut resampler = Resampler::new();
        let old = uneven(120, 0.0);
        resampler.resample(&old, false).unwrap();
        // Values that are linear along the line stay linear.
        let values: Vec<f64> = old.iter().map(|p| 3.0 + 0.1 * p[0]).collect();
        for k in 0..120 {
            let s = k as f64 / 119.0;
            assert!((resampler.carry(k, &values) - (3.0 + 40.0 * s)).abs() < 1e-9);
        }
        let ring = [[0.0, 0.0], [1.0, 0.0], [1.0, 4.0], [0.0, 4.0]];
        resampler.resample(&ring, true).unwrap();
        // Steps of 2.5 around a circumference of 10: the last point is between the last and the
        // first.
        let carried = [0, 1, 2, 3].map(|k| resampler.carry(k, &[1.0, 2.0, 6.0, 8.0]));
        assert_eq!(carried, [1.0, 3.5, 6.0, 5.375]);
    }

    #[test]
    fn on_an_arc_the_points_stay_on_the_arc() {
        let mut resampler = Resampler::new();
        let turn = 3.0;
        let even = resampler
            .resample(&uneven(120, turn), false)
            .unwrap()
            .to_vec();
        let radius = 500.0 / turn;
        for point in &even {
            let r = point[0].hypot(point[1] - radius);
            // The fourth power of a step of at most 13 in a radius of 167, divided by 384.
            assert!((r - radius).abs() < 2e-3, "{r}");
        }
        let steps: Vec<f64> = even
            .windows(2)
            .map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]))
            .collect();
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        assert!(
            steps.iter().all(|s| (s / mean - 1.0).abs() < 2e-3),
            "{steps:?}"
        );
    }

    #[test]
    fn a_ring_goes_round() {
        let ring: Vec<[f64; 2]> = (0..100)
            .map(|i| {
                let t = f64::from(i) / 100.0;
                let angle = std::f64::consts::TAU * (t + 0.1 * (std::f64::consts::TAU * t).sin());
                [80.0 * angle.cos(), 80.0 * angle.sin()]
            })
            .collect();
        let mut resampler = Resampler::new();
        let even = resampler.resample(&ring, true).unwrap();
        for (k, point) in even.iter().enumerate() {
            let angle = std::f64::consts::TAU * k as f64 / 100.0;
            let away = (point[0] - 80.0 * angle.cos()).hypot(point[1] - 80.0 * angle.sin());
            assert!(away < 0.05, "{k}: {away}");
        }
    }

    #[test]
    fn what_is_even_stays_where_it_is() {
        let points: Vec<[f64; 2]> = (0..50).map(|i| [f64::from(i), 2.0]).collect();
        let mut resampler = Resampler::new();
        let even = resampler.resample(&points, false).unwrap();
        assert!(
            even.iter()
                .zip(&points)
                .all(|(a, b)| (a[0] - b[0]).abs() < 1e-12)
        );
    }

    #[test]
    fn points_without_a_way_between_them_are_refused() {
        let mut resampler = Resampler::new();
        let one = [[1.0, 1.0]; 1];
        assert_eq!(
            resampler.resample(&one, false),
            Err(ResampleError::Count(1))
        );
        let twice = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        assert_eq!(
            resampler.resample(&twice, false),
            Err(ResampleError::NoStep(1))
        );
        let lost = [[0.0, 0.0], [f64::NAN, 0.0], [1.0, 0.0]];
        assert_eq!(
            resampler.resample(&lost, false),
            Err(ResampleError::NoStep(0))
        );
        let ring = [[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]];
        assert_eq!(
            resampler.resample(&ring, true),
            Err(ResampleError::NoStep(2))
        );
    }
}
