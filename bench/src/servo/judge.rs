//! Judges how well the rope was driven: its true shape compared with the target, image by image.
//! For a lifted rope, values named px are in mm.

/// Number of points at which two curves are compared.
const POINTS: usize = 120;
/// Maximum mean distance from the target, in pixels, at which a shape has reached it.
pub(super) const REACHED_PX: f64 = 5.0;
/// Time over which the final error is averaged.
const END_S: f64 = 0.25;

/// The error at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moment {
    /// Time since the first image, in seconds.
    pub at_s: f64,
    /// Mean distance of the true rope from the target, point by point, in pixels.
    pub error_px: f64,
}

/// Result of driving one rope.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Outcome {
    pub seed: u64,
    /// Errors, image by image.
    pub errors: Vec<Moment>,
    /// The controller's last reported state in words. Empty if it never reported.
    pub doing: String,
}

impl Outcome {
    /// Returns the mean error over the final period, in pixels. Infinite if the rope was never
    /// seen.
    pub(super) fn final_px(&self) -> f64 {
        let Some(last) = self.errors.last() else {
            return f64::INFINITY;
        };
        let end: Vec<f64> = self
            .errors
            .iter()
            .filter(|moment| moment.at_s >= last.at_s - END_S)
            .map(|moment| moment.error_px)
            .collect();
        end.iter().sum::<f64>() / end.len() as f64
    }

    /// Returns whether the rope is at its target at the end.
    pub(super) fn is_reached(&self) -> bool {
        self.final_px() <= REACHED_PX
    }

    /// Returns the time after which the rope stayed at the target, in seconds. `None` if it did
    /// not.
    pub(super) fn reached_s(&self) -> Option<f64> {
        if !self.is_reached() {
            return None;
        }
        let out = self
            .errors
            .iter()
            .rposition(|moment| moment.error_px > REACHED_PX);
        let first = out.map_or(0, |out| out + 1);
        self.errors.get(first).map(|moment| moment.at_s)
    }

    /// Returns the maximum error after the rope first reached the target, in pixels. `None` if it
    /// never did.
    pub(super) fn overshoot_px(&self) -> Option<f64> {
        let first = self
            .errors
            .iter()
            .position(|moment| moment.error_px <= REACHED_PX)?;
        let after = self.errors[first..].iter();
        Some(after.map(|moment| moment.error_px).fold(0.0, f64::max))
    }
}

/// A target to compare curves with.
#[derive(Debug, Clone)]
pub(super) struct Judge<const D: usize> {
    target: Vec<[f64; D]>,
}

impl<const D: usize> Judge<D> {
    /// Creates a judge for a target curve through these points.
    pub(super) fn new(target: &[[f64; D]]) -> Self {
        Self {
            target: lariat_simulation::at_equal_steps(target, POINTS),
        }
    }

    /// Returns the mean distance of corresponding points, in pixels, or in millimeters for a lifted
    /// rope. The curve may run in either direction.
    pub(super) fn error_px(&self, curve: &[[f64; D]]) -> f64 {
        if curve.len() < 2 {
            return f64::INFINITY;
        }
        let curve = lariat_simulation::at_equal_steps(curve, POINTS);
        let mean = |sum: f64| sum / POINTS as f64;
        let along = curve.iter().zip(&self.target).map(distance).sum();
        let back = curve.iter().rev().zip(&self.target).map(distance).sum();
        mean(f64::min(along, back))
    }
}

fn distance<const D: usize>((a, b): (&[f64; D], &[f64; D])) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(errors: &[f64]) -> Outcome {
        let moment = |(i, error_px): (usize, &f64)| Moment {
            at_s: i as f64,
            error_px: *error_px,
        };
        Outcome {
            seed: 1,
            errors: errors.iter().enumerate().map(moment).collect(),
            doing: String::new(),
        }
    }

    #[test]
    fn a_rope_is_there_when_it_stays() {
        let there = outcome(&[50.0, 4.0, 9.0, 5.0, 2.0]);
        assert!(there.is_reached());
        assert_eq!(there.reached_s(), Some(3.0));
        assert_eq!(there.overshoot_px(), Some(9.0));
        let left = outcome(&[50.0, 4.0, 9.0]);
        assert_eq!((left.reached_s(), left.final_px()), (None, 9.0));
        let never = outcome(&[50.0, 20.0]);
        assert_eq!((never.reached_s(), never.overshoot_px()), (None, None));
        assert!(!outcome(&[]).is_reached());
    }

    #[test]
    fn a_curve_moved_sideways_is_as_far_off_whichever_way_it_runs() {
        let judge = Judge::new(&[[0.0, 0.0], [100.0, 0.0]]);
        let moved = [[0.0, 3.0], [50.0, 3.0], [100.0, 3.0]];
        let turned = [[100.0, 3.0], [0.0, 3.0]];
        assert!((judge.error_px(&moved) - 3.0).abs() < 1e-9);
        assert!((judge.error_px(&turned) - 3.0).abs() < 1e-9);
        assert_eq!(judge.error_px(&[[1.0, 1.0]]), f64::INFINITY);
    }
}
