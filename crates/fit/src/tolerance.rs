//! When a curve lies on its points.

/// The share of the points that may lie farther from the curve than most: one in twenty.
const STRAY: usize = 20;

/// How near a curve must lie to its points, in their unit. Distances are those of points from the curve at their own ρ,
/// which are never less than those from the nearest point of it: where they are small, so are those, and the curve is also
/// where ρ says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// 95 of 100 points are no farther off. Default: 2 px.
    pub most: f64,
    /// No point is farther off. Default: 8 px, half the width of a rope of which 2 px are an eighth.
    pub all: f64,
    /// The standard deviation of the points themselves, where they are less sure than a curve has to be near: so much of a distance
    /// is not the curve's. Default: 0.
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

/// How many standard deviations of noise 95 of 100 points are off by, and all of them.
const NOISY: [f64; 2] = [2.0, 5.0];

impl Tolerance {
    /// How much of a rope's width counts as on the rope, if nothing else is said.
    pub const WIDTHS: f64 = 0.125;

    /// And how much at most, px.
    pub const LIMIT_PX: f64 = 2.0;

    /// The tolerance that the chain uses for a rope of this width, px: an eighth of it, and at most 2 px.
    pub fn of_rope(width_px: impl Into<f64>) -> Self {
        Self::of_width(width_px.into(), Self::WIDTHS, Self::LIMIT_PX)
    }

    /// That of a rope so wide: `share` of the width for most points, but no more than `limit`, and half of it for all.
    /// A width that is not known leaves the limit.
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

    /// One of `factor` times these distances; the points' noise stays what it is.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self {
            most: factor * self.most,
            all: factor * self.all,
            noise: self.noise,
        }
    }

    /// The squares of both distances, with what noise adds to them.
    pub(crate) fn squared(self) -> [f64; 2] {
        let [most, all] = NOISY.map(|sigmas| sigmas * self.noise);
        [
            self.most * self.most + most * most,
            self.all * self.all + all * all,
        ]
    }

    /// By how much these distances would have to be larger to hold such points: 1 or less if they hold them. Sorts.
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

    /// Whether points whose *squared* distances are these lie near enough. What is hidden does not count: where nobody
    /// saw the rope, the curve cannot be beside it.
    pub(crate) fn holds(self, squared: &[f64], hidden: &[bool]) -> bool {
        let (mut seen, mut stray) = (0, 0);
        let [most, all] = self.squared();
        for (i, &distance) in squared.iter().enumerate() {
            if hidden.get(i) == Some(&true) {
                continue;
            }
            // NaN is no distance.
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
        // √(1² + (2·0.5)²) for most, √(4² + (5·0.5)²) for all; half the tolerance leaves the noise as it is.
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
        // Of 20 points seen one may stray, not two.
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
