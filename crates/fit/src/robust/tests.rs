use super::*;
use crate::weighted::oracle::*;
use lariat_portable::SplitMix64;
use proptest::prelude::*;

/// A rope of 120 points and its fitter, of order 8 by default.
struct Setting<const D: usize> {
    b: Vec<f64>,
    r_inverse: Vec<f64>,
    count: usize,
    fitter: Weighted<D>,
}

impl<const D: usize> Setting<D> {
    fn new(points: usize, count: usize) -> Self {
        let b = bernstein_rows(&uniform(points), count);
        Self {
            r_inverse: r_inverse(&b, count),
            b,
            count,
            fitter: Weighted::new(points, count),
        }
    }

    fn huber(
        &mut self,
        points: &[[f64; D]],
        weights: &[f64],
        pins: bool,
    ) -> Result<(Vec<[f64; D]>, HuberFit), WeightedError> {
        let mut s = vec![[f64::NAN; D]; self.count];
        let problem = Problem {
            b: &self.b,
            r_inverse: &self.r_inverse,
            points,
            weights,
            pins,
            ridge: None,
        };
        let fit = self.fitter.huber(&problem, &mut s)?;
        Ok((s, fit))
    }

    fn least_squares(&mut self, points: &[[f64; D]], weights: &[f64]) -> Vec<[f64; D]> {
        let mut s = vec![[f64::NAN; D]; self.count];
        let problem = Problem {
            b: &self.b,
            r_inverse: &self.r_inverse,
            points,
            weights,
            pins: false,
            ridge: None,
        };
        self.fitter.solve(&problem, &mut s).unwrap();
        s
    }
}

/// Simpson's rule.
fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let steps = 20_000;
    let h = (to - from) / f64::from(steps);
    (0..=steps)
        .map(|i| {
            let weight = match i {
                0 => 1.0,
                i if i == steps => 1.0,
                i if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            weight * f(from + h * f64::from(i))
        })
        .sum::<f64>()
        * h
        / 3.0
}

#[test]
fn the_constants_are_those_of_gaussian_noise() {
    for (at, gaussian) in GAUSSIAN.iter().enumerate() {
        let d = (at + 1) as f64;
        let unscaled = |r: f64| r.powi(at as i32) * (-0.5 * r * r).exp();
        let whole = integral(0.0, 12.0, unscaled);
        let density = |r: f64| unscaled(r) / whole;
        assert!((integral(0.0, gaussian.median, density) - 0.5).abs() < 1e-11);

        let k = gaussian.tuning;
        let inside = integral(0.0, k, density);
        let weight = inside + integral(k, 12.0, |r| density(r) * k / r);
        let squares = integral(0.0, k, |r| density(r) * r * r) + k * k * (1.0 - inside);
        let slope = ((d - 1.0) * weight + inside) / d;
        let efficiency = slope * slope / (squares / d);
        assert!((efficiency - 0.95).abs() < 1e-9, "{efficiency}");
        // The documented covariance ratio: the true one, 1/0.95 of least squares', divided by
        // (BᵀWB)⁻¹.
        let told = [1.01, 0.98, 0.94][at];
        assert!((weight / 0.95 - told).abs() < 0.006, "{}", weight / 0.95);
    }
    assert!((GAUSSIAN[1].median - (2.0 * 2f64.ln()).sqrt()).abs() < 1e-12);
}

/// Ratio of the variance of least squares' curve to that of Huber's, over 4,000 ropes without
/// outliers, and the mean of σ².
fn efficiency<const D: usize>(seed: u64) -> (f64, f64, f64) {
    let mut random = SplitMix64::new(seed);
    let mut setting = Setting::<D>::new(120, 9);
    let weights = [1.0; 120];
    let (mut least, mut robust, mut variance, mut told) = (0.0, 0.0, 0.0, 0.0);
    let draws = 4000;
    for _ in 0..draws {
        let noise: Vec<[f64; D]> = (0..120)
            .map(|_| std::array::from_fn(|_| random.normal()))
            .collect();
        let s = setting.least_squares(&noise, &weights);
        least += power(&curve(&setting.b, &s));
        let (s, fit) = setting.huber(&noise, &weights, false).unwrap();
        robust += power(&curve(&setting.b, &s));
        variance += fit.sigma_px.powi(2);
        let c = setting.fitter.covariance();
        for row in setting.b.chunks_exact(9) {
            for (b, c) in row.iter().zip(c.chunks_exact(9)) {
                told += D as f64 * b * row.iter().zip(c).map(|(b, c)| b * c).sum::<f64>();
            }
        }
    }
    (least / robust, variance / f64::from(draws), robust / told)
}

fn power<const D: usize>(points: &[[f64; D]]) -> f64 {
    points.as_flattened().iter().map(|x| x * x).sum()
}

#[test]
fn without_outliers_it_is_nearly_as_efficient_as_least_squares() {
    for (efficiency, variance, covariance) in [
        efficiency::<1>(11),
        efficiency::<2>(12),
        efficiency::<3>(13),
    ] {
        // The limit for many points is 0.95; 120 points for 9 control points are fewer.
        assert!((0.925..0.975).contains(&efficiency), "{efficiency}");
        assert!((0.93..1.07).contains(&variance), "{variance}");
        assert!((0.9..1.1).contains(&covariance), "{covariance}");
    }
}

/// Distribution of outliers.
#[derive(Debug, Clone, Copy)]
enum Outliers {
    /// Scattered, in random directions.
    AnyWay,
    /// Scattered, all to one side.
    OneWay,
}

/// Moves a tenth of the points by 100 px.
fn spoil(
    points: &[[f64; 2]],
    outliers: Outliers,
    random: &mut SplitMix64,
) -> (Vec<[f64; 2]>, Vec<f64>) {
    let mut spoiled = points.to_vec();
    let mut clean = vec![1.0; points.len()];
    let mut angle = 7.0 * random.unit();
    for _ in 0..points.len() / 10 {
        let at = loop {
            let at = (points.len() as f64 * random.unit()) as usize;
            if clean[at] > 0.0 {
                break at;
            }
        };
        clean[at] = 0.0;
        if matches!(outliers, Outliers::AnyWay) {
            angle = 7.0 * random.unit();
        }
        let (sin, cos) = f64::sin_cos(angle);
        spoiled[at][0] += 100.0 * cos;
        spoiled[at][1] += 100.0 * sin;
    }
    (spoiled, clean)
}

/// A tenth of the points is moved by 100 px, and the curve stays within the effect of noise.
#[test]
fn a_tenth_of_gross_outliers_hardly_moves_the_curve() {
    for outliers in [Outliers::AnyWay, Outliers::OneWay] {
        for sigma in [0.1, 0.3, 1.0] {
            let mut random = SplitMix64::new(77);
            let mut setting = Setting::<2>::new(120, 9);
            let (mut worst, mut mean, mut plain) = (0.0f64, 0.0, 0.0);
            let ropes = 200;
            for _ in 0..ropes {
                let exact = exact_rope(&setting.b, &mut random);
                let points: Vec<[f64; 2]> = exact
                    .iter()
                    .map(|p| p.map(|x| x + sigma * random.normal()))
                    .collect();
                let (spoiled, clean) = spoil(&points, outliers, &mut random);
                let without = setting.least_squares(&points, &clean);
                let without = curve(&setting.b, &without);
                let (s, fit) = setting.huber(&spoiled, &[1.0; 120], false).unwrap();
                let robust = curve(&setting.b, &s);
                let moved = apart(&robust, &without) / sigma;
                worst = worst.max(moved);
                mean += moved / f64::from(ropes);
                let least = setting.least_squares(&spoiled, &[1.0; 120]);
                plain += apart(&curve(&setting.b, &least), &without) / sigma / f64::from(ropes);
                assert!(fit.rounds <= MAX_ROUNDS);
            }
            // A tenth fewer points alone would move it by a tenth of the effect of noise.
            assert!(mean < 0.5, "{outliers:?} {sigma} px: {mean} σ");
            assert!(worst < 3.0, "{outliers:?} {sigma} px: {worst} σ");
            assert!(plain > 10.0, "least squares is moved far: {plain} σ");
        }
    }
}

/// A curve of the basis some hundred pixels long.
fn exact_rope(b: &[f64], random: &mut SplitMix64) -> Vec<[f64; 2]> {
    let s: Vec<[f64; 2]> = (0..9)
        .map(|j| [80.0 * j as f64, 400.0 * random.unit()])
        .collect();
    curve(b, &s)
}

#[test]
fn an_exact_curve_stays_exact_and_outliers_lose_it_nothing() {
    let mut random = SplitMix64::new(5);
    let mut setting = Setting::<2>::new(120, 9);
    for scale in [1.0, 1e-6, 1e6] {
        let exact: Vec<[f64; 2]> = exact_rope(&setting.b, &mut random)
            .iter()
            .map(|p| p.map(|x| scale * x))
            .collect();
        let (s, fit) = setting.huber(&exact, &[1.0; 120], false).unwrap();
        assert!(apart(&curve(&setting.b, &s), &exact) < 1e-11 * scale);
        assert!(fit.sigma_px < 1e-9 * scale);
        assert!(setting.fitter.weights().iter().all(|&weight| weight > 0.3));
    }
    let (s, fit) = setting.huber(&[[0.0; 2]; 120], &[1.0; 120], false).unwrap();
    assert_eq!((s, fit.sigma_px), (vec![[0.0; 2]; 9], 0.0));
    // With as many points as control points, nothing distinguishes outliers.
    let mut tight = Setting::<2>::new(9, 9);
    let points = rope(&uniform(9), 1.0, &mut random);
    let (s, _) = tight.huber(&points, &[1.0; 9], false).unwrap();
    assert!(apart(&curve(&tight.b, &s), &points) < 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn hidden_points_stay_hidden_and_pins_exact(seed in any::<u64>(), pins in any::<bool>(), from in 20usize..90) {
        let mut random = SplitMix64::new(seed | 1);
        let mut setting = Setting::<2>::new(120, 9);
        let mut points: Vec<[f64; 2]> = rope(&uniform(120), 0.3, &mut random);
        let mut weights = [1.0; 120];
        weights[from..from + 8].fill(0.0);
        let (before, _) = setting.huber(&points, &weights, pins).unwrap();
        points[from..from + 8].fill([f64::NAN; 2]);
        let (after, fit) = setting.huber(&points, &weights, pins).unwrap();
        prop_assert_eq!(&before, &after);
        prop_assert!(fit.fit.max_px.is_finite());
        prop_assert!(setting.fitter.weights()[from..from + 8].iter().all(|&w| w == 0.0));
        if pins {
            prop_assert_eq!((after[0], after[8]), (points[0], points[119]));
        }
    }

    // Medians are taken axis by axis, so a rope turned by another angle may have another start.
    #[test]
    fn a_scaled_rope_upside_down_read_backwards_has_the_same_curve_so(
        seed in any::<u64>(), scale in 0.01f64..100.0,
    ) {
        let mut random = SplitMix64::new(seed | 1);
        let mut setting = Setting::<2>::new(120, 9);
        let points = rope(&uniform(120), 0.3, &mut random);
        let (points, _) = spoil(&points, Outliers::AnyWay, &mut random);
        let turn = |p: &[f64; 2]| [scale * p[1], -scale * p[0]];
        let (before, fit) = setting.huber(&points, &[1.0; 120], false).unwrap();
        let turned: Vec<_> = points.iter().rev().map(turn).collect();
        let (after, other) = setting.huber(&turned, &[1.0; 120], false).unwrap();
        let expected: Vec<_> = before.iter().rev().map(turn).collect();
        prop_assert!(apart(&after, &expected) < 1e-6 * scale, "{:e}", apart(&after, &expected) / scale);
        prop_assert!((other.sigma_px / fit.sigma_px / scale - 1.0).abs() < 1e-6);
    }
}
