//! The required accuracy of a curve.

/// One in this many points may be farther from the curve than `most`.
const STRAY: usize = 20;

/// Maximum distances of a curve from its points, in their unit. Each distance is measured between a
/// point and the curve at the point's own ρ. It is never less than the distance to the curve's
/// nearest point. If all are small, the curve is thus near its points, and also at the right place
/// at each ρ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Maximum distance of 95 of 100 points. Default: 2 px.
    pub most: f64,
    /// Maximum distance of all points. Default: 8 px. This is half the width of a rope of 16 px,
    /// for which `most` is an eighth of the width.
    pub all: f64,
    /// Standard deviation of the points themselves, if they are less accurate than the curve has to
    /// be. This part of a distance is not the curve's error. Default: 0.
    pub noise: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self {
            most: 2.0,
            all: 8.0,
            noise: 0.0,
        }
    }
}

/// Distances, in standard deviations of the noise, that contain 95 of 100 points and all points.
const NOISY: [f64; 2] = [2.0, 5.0];

impl Tolerance {
    /// Default share of a rope's width that counts as on the rope.
    pub const WIDTHS: f64 = 0.125;

    /// Default maximum of that distance, px.
    pub const LIMIT_PX: f64 = 2.0;

    /// The tolerance that the chain uses for a rope of this width, px: an eighth of it, and at most
    /// 2 px.
    pub fn of_rope(width_px: impl Into<f64>) -> Self {
        Self::of_width(width_px.into(), Self::WIDTHS, Self::LIMIT_PX)
    }

    /// Creates the tolerance of a rope of this width: `share` of the width for most points, but at
    /// most `limit`, and half the width for all. If the width is unknown, the limit is used.
    pub fn of_width(width: f64, share: f64, limit: f64) -> Self {
        if width > 0.0 && width.is_finite() {
            let most = limit.min(share * width);
            Self {
                most,
                all: most.max(0.5 * width),
                noise: 0.0,
            }
        } else {
            Self {
                most: limit,
                all: 4.0 * limit,
                noise: 0.0,
            }
        }
    }

    /// Multiplies the distances by `factor`. The points' noise stays the same.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self {
            most: factor * self.most,
            all: factor * self.all,
            noise: self.noise,
        }
    }

    /// Squares of both distances, including noise.
    pub(crate) fn squared(self) -> [f64; 2] {
        let [most, all] = NOISY.map(|sigmas| sigmas * self.noise);
        [
            self.most * self.most + most * most,
            self.all * self.all + all * all,
        ]
    }

    /// Factor by which these distances would have to grow to accept such points: 1 or less if they
    /// accept them. Sorts the input.
    pub(crate) fn excess(self, squared: &mut [f64], hidden: &[bool]) -> f64 {
        let mut seen = 0;
        for i in 0..squared.len() {
            if hidden.get(i) != Some(&true) {
                squared.swap(seen, i);
                seen += 1;
            }
        }
        let near = &mut squared[..seen];
        near.sort_unstable_by(f64::total_cmp);
        let Some(&farthest) = near.last() else {
            return 0.0;
        };
        let most = near[near.len() - 1 - near.len() / STRAY];
        let [of_most, of_all] = self.squared().map(f64::sqrt);
        (most.sqrt() / of_most).max(farthest.sqrt() / of_all)
    }

    /// Returns whether points with these *squared* distances are near enough. Hidden points do not
    /// count, because the rope was not observed there.
    pub(crate) fn holds(self, squared: &[f64], hidden: &[bool]) -> bool {
        let (mut seen, mut stray) = (0, 0);
        let [most, all] = self.squared();
        for (i, &distance) in squared.iter().enumerate() {
            if hidden.get(i) == Some(&true) {
                continue;
            }
            // Also rejects NaN.
            if distance.is_nan() || distance > all {
                return false;
            }
            seen += 1;
            stray += usize::from(distance > most);
        }
        STRAY * stray <= seen
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCE: Tolerance = Tolerance {
        most: 1.0,
        all: 4.0,
        noise: 0.0,
    };

    fn holds(distances: &[(usize, f64)], hidden: &[bool]) -> bool {
        let mut squared = [0.25; 100];
        for &(i, distance) in distances {
            squared[i] = distance * distance;
        }
        TOLERANCE.holds(&squared, hidden)
    }

    #[test]
    fn one_point_in_twenty_may_be_farther_off_but_none_by_more_than_the_second_distance() {
        let strays = |count: usize| (0..count).map(|i| (7 * i, 3.0)).collect::<Vec<_>>();
        assert!(holds(&strays(5), &[]));
        assert!(!holds(&strays(6), &[]));
        assert!(holds(&[(50, 3.9)], &[]));
        assert!(!holds(&[(50, 4.1)], &[]));
        assert!(!holds(&[(50, f64::NAN)], &[]));
    }

    #[test]
    fn what_is_noise_of_the_points_is_not_the_curves() {
        let noisy = Tolerance {
            noise: 0.5,
            ..TOLERANCE
        };
        // √(1² + (2·0.5)²) for most, √(4² + (5·0.5)²) for all; half the tolerance leaves the noise
        // as it is.
        let strays = |far: f64| [[0.25; 90], [far * far; 90]].concat();
        assert!(noisy.holds(&strays(1.41), &[]) && !noisy.holds(&strays(1.42), &[]));
        let one = |far: f64| [[0.25; 99].as_slice(), &[far * far]].concat();
        assert!(noisy.holds(&one(4.71), &[]) && !noisy.holds(&one(4.72), &[]));
        let half = noisy.times(0.5);
        assert!(half.holds(&strays(1.11), &[]) && !half.holds(&strays(1.12), &[]));
    }

    #[test]
    fn what_is_hidden_does_not_count() {
        let hidden: Vec<bool> = (0..100).map(|i| i == 50).collect();
        assert!(holds(&[(50, 100.0)], &hidden));
        assert!(!holds(&[(51, 100.0)], &hidden));
        // With 20 visible points, one may be farther off, but not two.
        let hidden: Vec<bool> = (0..100).map(|i| i >= 20).collect();
        assert!(holds(&[(3, 2.0)], &hidden));
        assert!(!holds(&[(3, 2.0), (4, 2.0)], &hidden));
    }

    #[test]
    fn a_rope_has_a_tolerance_of_its_width_up_to_a_limit() {
        let of = |width| Tolerance::of_width(width, 0.125, 2.0);
        assert_eq!(of(8.0), TOLERANCE);
        assert_eq!(
            of(40.0),
            Tolerance {
                most: 2.0,
                all: 20.0,
                noise: 0.0
            }
        );
        for unknown in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(of(unknown), Tolerance::default());
        }
    }
}
