use super::oracle::*;
use super::*;
use crate::factor::Qr;
use lariat_portable::SplitMix64;
use proptest::prelude::*;

/// A test problem, by rows.
#[derive(Clone)]
struct Case<const D: usize> {
    b: Vec<f64>,
    count: usize,
    r_inverse: Vec<f64>,
    points: Vec<[f64; D]>,
    weights: Vec<f64>,
    pins: bool,
    /// `√λD`.
    penalty: Vec<f64>,
}

impl<const D: usize> std::fmt::Debug for Case<D> {
    /// Omits the numbers of its matrices.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Case")
            .field("count", &self.count)
            .field("weights", &self.weights)
            .field("pins", &self.pins)
            .field("ridge", &!self.penalty.is_empty())
            .finish_non_exhaustive()
    }
}

impl<const D: usize> Case<D> {
    fn new(rho: &[f64], count: usize, random: &mut SplitMix64) -> Self {
        let b = bernstein_rows(rho, count);
        Self {
            r_inverse: r_inverse(&b, count),
            b,
            count,
            points: rope(rho, 0.5, random),
            weights: vec![1.0; rho.len()],
            pins: false,
            penalty: Vec::new(),
        }
    }

    fn with_ridge(mut self, lambda: f64) -> Self {
        self.penalty = differences(self.count, lambda);
        let upon: Vec<f64> = self.b.iter().chain(&self.penalty).copied().collect();
        self.r_inverse = r_inverse(&upon, self.count);
        self
    }

    fn ridge(&self) -> Vec<f64> {
        gram(&self.penalty, self.count)
    }

    fn problem<'a>(&'a self, ridge: &'a [f64]) -> Problem<'a, D> {
        Problem {
            b: &self.b,
            r_inverse: &self.r_inverse,
            points: &self.points,
            weights: &self.weights,
            pins: self.pins,
            ridge: (!self.penalty.is_empty()).then_some(ridge),
        }
    }

    fn fit(&self) -> Result<(Vec<[f64; D]>, WeightedFit, Weighted<D>), WeightedError> {
        let mut weighted = Weighted::new(self.points.len(), self.count);
        let mut control_points = vec![[f64::NAN; D]; self.count];
        let fit = weighted.solve(&self.problem(&self.ridge()), &mut control_points)?;
        Ok((control_points, fit, weighted))
    }

    fn expected(&self) -> Vec<[f64; D]> {
        solve(
            &self.b,
            &self.points,
            &self.weights,
            self.pins,
            &self.penalty,
        )
    }

    fn curve(&self, control_points: &[[f64; D]]) -> Vec<[f64; D]> {
        curve(&self.b, control_points)
    }
}

/// The same problem with one coordinate for each point. Its fits give the columns of `H` and `P`.
fn unit_responses<const D: usize>(case: &Case<D>) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    (0..case.points.len())
        .map(|i| {
            let mut points = vec![[0.0]; case.points.len()];
            points[i] = [1.0];
            let s = solve(&case.b, &points, &case.weights, case.pins, &case.penalty);
            let flat = |points: Vec<[f64; 1]>| points.into_flattened();
            (flat(curve(&case.b, &s)), flat(s))
        })
        .unzip()
}

/// Orders that the points determine, with random weights, with or without pins and ridge.
fn cases() -> impl Strategy<Value = Case<2>> {
    (
        2usize..=16,
        0usize..100,
        any::<u64>(),
        any::<bool>(),
        prop::option::of(-6.0f64..2.0),
    )
        .prop_map(|(count, more, seed, pins, ridge)| {
            let mut random = SplitMix64::new(seed | 1);
            let mut case = Case::new(&uniform(2 * count + more), count, &mut random);
            case.weights.fill_with(|| (4.0 * random.unit() - 2.0).exp());
            case.pins = pins;
            match ridge {
                Some(power) if count > 2 => case.with_ridge(10f64.powf(power)),
                _ => case,
            }
        })
}

/// Ropes with a hidden part, at most a third, or with scattered hidden points.
fn partial_cases() -> impl Strategy<Value = Case<2>> {
    (
        2usize..=12,
        any::<u64>(),
        any::<bool>(),
        prop::option::of(-6.0f64..2.0),
    )
        .prop_map(|(count, seed, pins, ridge)| {
            let mut random = SplitMix64::new(seed | 1);
            let mut case = Case::new(&uniform(6 * count), count, &mut random);
            let hidden = (count as f64 * random.unit()) as usize;
            let from = (5.0 * count as f64 * random.unit()) as usize;
            case.weights[from..from + hidden / 2].fill(0.0);
            for _ in 0..hidden / 2 {
                case.weights[(6.0 * count as f64 * random.unit()) as usize] = 0.0;
            }
            case.pins = pins;
            match ridge {
                Some(power) if count > 2 => case.with_ridge(10f64.powf(power)),
                _ => case,
            }
        })
}

proptest! {
    #[test]
    fn any_weights_pins_and_ridge_equal_qr_of_the_whole_matrix(case in cases()) {
        let (control_points, fit, weighted) = case.fit().unwrap();
        let expected = case.expected();
        let (curve, wanted) = (case.curve(&control_points), case.curve(&expected));
        prop_assert!(apart(&curve, &wanted) < 1e-9, "curve {:e}", apart(&curve, &wanted));
        // Up to order 15 cond(B) is below 10⁵.
        prop_assert!(apart(&control_points, &expected) < 1e-7, "{:e}", apart(&control_points, &expected));
        let squared = |(point, on): (&[f64; 2], &[f64; 2])| distance(point, on).powi(2);
        let sum: f64 = case.points.iter().zip(&wanted).zip(&case.weights)
            .map(|(pair, weight)| weight * squared(pair)).sum();
        prop_assert!((fit.sum_w_r2 - sum).abs() < 1e-9 * sum + 1e-15, "{} {sum}", fit.sum_w_r2);
        let max = apart(&case.points, &wanted);
        prop_assert!((fit.max_px - max).abs() < 1e-8);
        prop_assert_eq!(weighted.weights().len(), case.points.len());
    }

    #[test]
    fn a_point_of_weight_0_is_as_good_as_left_out(case in partial_cases(), nonsense in any::<f64>()) {
        let mut case = case;
        let count = case.count;
        case.pins = false;
        if let Some(hidden) = case.weights.iter().position(|&weight| weight == 0.0) {
            case.points[hidden] = [nonsense, f64::NAN];
        }
        let Ok((control_points, fit, weighted)) = case.fit() else {
            // The remaining points cannot be fitted either, or only a hidden point of the curve is
            // uncertain.
            return Ok(());
        };
        let seen = |i: &usize| case.weights[*i] > 0.0;
        let kept: Vec<usize> = (0..case.points.len()).filter(seen).collect();
        let shorter = Case {
            b: kept.iter().flat_map(|&i| case.b[i * count..(i + 1) * count].to_vec()).collect(),
            count,
            r_inverse: case.r_inverse.clone(),
            points: kept.iter().map(|&i| case.points[i]).collect(),
            weights: vec![1.0; kept.len()],
            pins: false,
            penalty: case.penalty.clone(),
        };
        let (expected, without, other) = shorter.fit().unwrap();
        let scale = fit.noise_gain.max(1.0);
        prop_assert!(apart(&control_points, &expected) < 1e-7 * scale);
        let sum = without.sum_w_r2;
        prop_assert!((fit.sum_w_r2 - sum).abs() < 1e-9 + 1e-12 * sum, "{} {sum}", fit.sum_w_r2);
        prop_assert!((fit.max_px - without.max_px).abs() < 1e-9);
        prop_assert!((fit.degrees_of_freedom - without.degrees_of_freedom).abs() < 1e-9);
        for (a, b) in weighted.covariance().iter().zip(other.covariance()) {
            prop_assert!((a - b).abs() <= 1e-7 * (1.0 + a.abs()), "{a} {b}");
        }
    }

    #[test]
    fn weight_2_is_the_point_twice(case in cases(), at in any::<prop::sample::Index>()) {
        let mut case = case;
        case.pins = false;
        let (at, count) = (at.index(case.points.len()), case.count);
        let mut twice = Case { weights: case.weights.clone(), points: case.points.clone(),
            b: case.b.clone(), r_inverse: case.r_inverse.clone(), penalty: case.penalty.clone(), ..case };
        twice.points.push(case.points[at]);
        twice.weights.push(case.weights[at]);
        twice.b.extend_from_within(at * count..(at + 1) * count);
        case.weights[at] *= 2.0;
        let (a, fit, _) = case.fit().unwrap();
        let (b, other, _) = twice.fit().unwrap();
        prop_assert!(apart(&a, &b) < 1e-7);
        prop_assert!((fit.sum_w_r2 - other.sum_w_r2).abs() < 1e-9 * (1.0 + fit.sum_w_r2));
    }

    #[test]
    fn pinned_ends_are_exact_even_hidden_ones(case in partial_cases()) {
        let mut case = case;
        case.pins = true;
        case.weights[0] = 0.0;
        let Ok((control_points, ..)) = case.fit() else { return Ok(()) };
        prop_assert_eq!(control_points[0], case.points[0]);
        prop_assert_eq!(control_points[case.count - 1], *case.points.last().unwrap());
        let mut heavy = case;
        heavy.weights[0] = 7.0;
        let (other, ..) = heavy.fit().unwrap();
        prop_assert!(apart(&control_points, &other) < 1e-6, "the ends' own weights say nothing");
    }

    #[test]
    fn moving_turning_and_stretching_the_points_does_so_to_the_control_points(
        case in cases(),
        m in prop::array::uniform4(-2.0f64..2.0),
        shift in prop::array::uniform2(-1e3f64..1e3),
    ) {
        let affine = |p: &[f64; 2]| [
            m[0] * p[0] + m[1] * p[1] + shift[0],
            m[2] * p[0] + m[3] * p[1] + shift[1],
        ];
        let (before, ..) = case.fit().unwrap();
        let moved = Case { points: case.points.iter().map(affine).collect(), ..case };
        let (after, ..) = moved.fit().unwrap();
        let expected: Vec<_> = before.iter().map(affine).collect();
        prop_assert!(apart(&after, &expected) < 1e-6, "{:e}", apart(&after, &expected));
    }

    #[test]
    fn the_order_of_the_points_does_not_matter(case in cases(), seed in any::<u64>()) {
        let mut case = case;
        case.pins = false;
        let (before, fit, _) = case.fit().unwrap();
        let mut random = SplitMix64::new(seed | 1);
        for i in (1..case.points.len()).rev() {
            let j = ((i + 1) as f64 * random.unit()) as usize;
            case.points.swap(i, j);
            case.weights.swap(i, j);
            for k in 0..case.count {
                case.b.swap(i * case.count + k, j * case.count + k);
            }
        }
        let (after, other, _) = case.fit().unwrap();
        prop_assert!(apart(&before, &after) < 1e-7);
        prop_assert!((fit.degrees_of_freedom - other.degrees_of_freedom).abs() < 1e-9);
    }

    #[test]
    fn a_curve_read_backwards_has_its_control_points_backwards(case in cases()) {
        let (mut before, ..) = case.fit().unwrap();
        let mut case = case;
        case.points.reverse();
        case.weights.reverse();
        let (after, ..) = case.fit().unwrap();
        before.reverse();
        prop_assert!(apart(&before, &after) < 1e-6, "{:e}", apart(&before, &after));
    }

    #[test]
    fn freedom_covariance_and_gain_are_those_of_the_linear_map(case in partial_cases()) {
        let (h, p) = unit_responses(&case);
        let gain = |c: &[f64]| -> f64 {
            case.b.chunks_exact(case.count).map(|row| {
                let cb = c.chunks_exact(case.count).zip(row)
                    .map(|(c, b)| b * c.iter().zip(row).map(|(c, b)| c * b).sum::<f64>());
                cb.sum::<f64>()
            }).fold(0.0, f64::max).sqrt()
        };
        let (_, fit, weighted) = match case.fit() {
            Ok(fitted) => fitted,
            Err(WeightedError::Undetermined { gain, .. }) => {
                prop_assert!(gain > MAX_NOISE_GAIN);
                return Ok(());
            }
            Err(other) => return Err(TestCaseError::fail(other.to_string())),
        };
        let mut freedom = 0.0;
        for (j, column) in h.iter().enumerate() {
            for (i, &hat) in column.iter().enumerate() {
                let pinned = case.pins && (i == 0 || i + 1 == case.points.len());
                let weight = if pinned { 1.0 } else { case.weights[i] };
                freedom += weight * (f64::from(i == j) - hat).powi(2);
            }
        }
        prop_assert!((fit.degrees_of_freedom - freedom).abs() < 1e-6, "{} {freedom}", fit.degrees_of_freedom);
        let covariance = weighted.covariance();
        for i in 0..case.count {
            for j in 0..case.count {
                let expected: f64 = p.iter().map(|s| s[i] * s[j]).sum();
                let c = covariance[i * case.count + j];
                prop_assert!((c - expected).abs() < 1e-6 * (1.0 + fit.noise_gain * expected.abs()), "{i} {j} {c} {expected}");
            }
        }
        let expected = gain(covariance);
        if case.penalty.is_empty() {
            prop_assert!((fit.noise_gain - expected).abs() < 1e-5 * expected, "{} {expected}", fit.noise_gain);
        } else {
            prop_assert!(fit.noise_gain > (1.0 - 1e-6) * expected, "the ridge leaves more open than noise");
        }
    }

    #[test]
    fn narrow_registers_give_the_same(case in cases()) {
        let (wide, fit, _) = case.fit().unwrap();
        let mut weighted = Weighted::new(case.points.len(), case.count);
        weighted.arch = lariat_portable::Arch::Plain;
        let mut narrow = wide.clone();
        let other = weighted.solve(&case.problem(&case.ridge()), &mut narrow).unwrap();
        prop_assert!(apart(&wide, &narrow) < 1e-7);
        prop_assert!((fit.noise_gain - other.noise_gain).abs() < 1e-9);
    }
}

/// At every order allowed for the pseudoinverse, a curve is recovered as accurately as by QR.
#[test]
fn a_curve_of_the_basis_is_found_again_at_any_order() {
    let mut random = SplitMix64::new(7);
    for count in 2..=32 {
        let mut case = Case::<2>::new(&uniform(256), count, &mut random);
        let control_points: Vec<[f64; 2]> = (0..count)
            .map(|_| [640.0 * random.unit(), 480.0 * random.unit()])
            .collect();
        case.points = case.curve(&control_points);
        let (found, fit, _) = case.fit().unwrap();
        let by_qr = apart(&case.expected(), &control_points);
        let condition = Qr::new(matrix(&case.b, count).as_ref()).condition();
        let error = apart(&found, &control_points);
        assert!(
            error < 640.0 * 4.0 * f64::EPSILON * condition,
            "{count}: {error:e}, QR {by_qr:e}"
        );
        assert!(fit.max_px < 1e-11 * condition.max(1e2));
    }
}

#[test]
fn without_a_preconditioner_low_orders_are_the_same() {
    let mut random = SplitMix64::new(3);
    let case = Case::<3>::new(&uniform(120), 9, &mut random);
    let (expected, ..) = case.fit().unwrap();
    let mut weighted = Weighted::new(120, 9);
    let mut control_points = vec![[0.0; 3]; 9];
    let identity: Vec<f64> = (0..81).map(|k| f64::from(u8::from(k % 10 == 0))).collect();
    let problem = Problem {
        r_inverse: &identity,
        ..case.problem(&[])
    };
    weighted.solve(&problem, &mut control_points).unwrap();
    assert!(apart(&control_points, &expected) < 1e-8);
}

#[test]
fn the_condition_number_is_near_that_of_the_singular_values() {
    let mut random = SplitMix64::new(5);
    for count in [2, 3, 5, 9, 12, 16] {
        for hidden in [0, 5, 20] {
            let mut case = Case::<2>::new(&uniform(120), count, &mut random);
            case.weights[60..60 + hidden].fill(0.0);
            let (_, fit, _) = case.fit().unwrap();
            let rows: Vec<f64> = (case.b.chunks_exact(count).zip(&case.weights))
                .flat_map(|(row, weight)| row.iter().map(move |b| b * weight.sqrt()))
                .collect();
            let exact = Qr::new(matrix(&rows, count).as_ref()).condition().powi(2);
            let ratio = fit.condition / exact;
            assert!((0.5..2.0).contains(&ratio), "{count} {hidden}: {ratio}");
        }
    }
}

#[test]
fn too_few_seen_points_are_refused_with_both_numbers() {
    let mut case = Case::<2>::new(&uniform(120), 9, &mut SplitMix64::new(1));
    case.weights[8..].fill(0.0);
    let error = case.fit().err().unwrap();
    assert_eq!(
        error,
        WeightedError::TooFewSeen {
            seen: 8,
            control_points: 9
        }
    );
    assert!(
        error
            .to_string()
            .starts_with("only 8 points are seen, and they cannot fix 9 control points")
    );
    // A pinned end is known, seen or not.
    case.pins = true;
    assert!(!matches!(
        case.fit().err(),
        Some(WeightedError::TooFewSeen { .. })
    ));
}

#[test]
fn a_hidden_part_that_nothing_holds_is_refused_with_its_gain() {
    let mut case = Case::<2>::new(&uniform(120), 9, &mut SplitMix64::new(1));
    let mut last = 0.0;
    let mut refused_from = None;
    for hidden in 0..100 {
        case.weights[120 - hidden..].fill(0.0);
        let gain = match case.fit() {
            Ok((_, fit, _)) => {
                assert!(
                    refused_from.is_none(),
                    "what is hidden further is refused as well"
                );
                fit.noise_gain
            }
            Err(WeightedError::Undetermined { gain, limit }) => {
                assert!(gain > limit && limit == MAX_NOISE_GAIN);
                refused_from.get_or_insert(hidden);
                gain
            }
            Err(other) => panic!("{other}"),
        };
        assert!(gain >= 0.99 * last, "{hidden}: {gain} {last}");
        last = gain;
    }
    // Extrapolation of order 8 is accepted for a tenth of the rope.
    assert!((8..=20).contains(&refused_from.unwrap()));
    // A ridge, which states how smooth the rope is, determines it.
    case.weights.fill(1.0);
    case.weights[90..].fill(0.0);
    assert!(case.fit().is_err());
    assert!(case.with_ridge(10.0).fit().is_ok());
}

#[test]
fn points_at_one_place_of_the_curve_are_refused() {
    let case = Case::<2>::new(&uniform(40), 6, &mut SplitMix64::new(1));
    let stuck = Case {
        b: bernstein_rows(&[0.25; 40], 6),
        ..case
    };
    let error = stuck.fit().err().unwrap();
    assert!(
        matches!(error, WeightedError::Undetermined { gain, .. } if gain > 1e3),
        "{error}"
    );
    assert!(error.to_string().contains("do not determine the curve"));
}

#[test]
fn what_is_no_weight_is_refused() {
    let mut case = Case::<2>::new(&uniform(40), 6, &mut SplitMix64::new(1));
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        case.weights[7] = bad;
        let error = case.fit().err().unwrap();
        assert!(
            matches!(error, WeightedError::NotAWeight { index: 7, .. }),
            "{error}"
        );
    }
    case.weights[7] = -0.0;
    assert!(case.fit().is_ok());
}

#[test]
fn a_refused_fit_leaves_nothing_behind() {
    let case = Case::<2>::new(&uniform(120), 9, &mut SplitMix64::new(1));
    let (expected, fit, mut weighted) = case.fit().unwrap();
    let mut control_points = vec![[4.0, 2.0]; 9];
    let mut hidden = case.weights.clone();
    hidden[60..].fill(0.0);
    let nothing = vec![[f64::NAN; 2]; 120];
    for (points, weights) in [(&nothing, &hidden), (&case.points, &hidden)] {
        let problem = Problem {
            points,
            weights,
            pins: true,
            ..case.problem(&[])
        };
        let refused = weighted.solve(&problem, &mut control_points);
        assert!(refused.is_err());
        assert_eq!(control_points, [[4.0, 2.0]; 9]);
    }
    let again = weighted.solve(&case.problem(&[]), &mut control_points);
    assert_eq!(again.unwrap(), fit);
    assert_eq!(control_points, expected);
}

/// Empirical covariance of 20,000 noisy draws of a rope with a hidden part.
#[test]
fn the_covariance_of_a_partly_hidden_rope_is_that_of_noisy_draws() {
    const DRAWS: usize = 20_000;
    let mut random = SplitMix64::new(42);
    for (pins, ridge) in [(false, None), (true, None), (true, Some(0.01))] {
        let mut case = Case::<2>::new(&uniform(120), 9, &mut random);
        if let Some(lambda) = ridge {
            case = case.with_ridge(lambda);
        }
        case.pins = pins;
        case.weights[70..90].fill(0.0);
        let exact: Vec<[f64; 2]> = rope(&uniform(120), 0.0, &mut random);
        case.points.clone_from(&exact);
        let (mean, _, mut weighted) = case.fit().unwrap();
        let (sigma, gram) = (0.3, gram(&case.penalty, 9));
        let mut sums = vec![0.0; 81];
        let (mut residuals, mut freedom) = (0.0, 0.0);
        let mut s = vec![[0.0; 2]; 9];
        let mut bias_w_r2 = 0.0;
        for draw in 0..=DRAWS {
            for (point, exact) in case.points.iter_mut().zip(&exact) {
                *point = exact.map(|x| {
                    if draw == 0 {
                        x
                    } else {
                        x + sigma * random.normal()
                    }
                });
            }
            let problem = Problem {
                pins,
                ridge: ridge.map(|_| &gram[..]),
                ..case.problem(&[])
            };
            let fit = weighted.solve(&problem, &mut s).unwrap();
            if draw == 0 {
                bias_w_r2 = fit.sum_w_r2;
                continue;
            }
            freedom = fit.degrees_of_freedom;
            residuals += fit.sum_w_r2 - bias_w_r2;
            for i in 0..9 {
                for j in 0..9 {
                    for axis in 0..2 {
                        sums[i * 9 + j] +=
                            (s[i][axis] - mean[i][axis]) * (s[j][axis] - mean[j][axis]);
                    }
                }
            }
        }
        let samples = 2.0 * DRAWS as f64;
        let variance = residuals / samples / freedom;
        assert!(
            (variance / (sigma * sigma) - 1.0).abs() < 0.02,
            "{variance}"
        );
        let c = weighted.covariance();
        for i in 0..9 {
            for j in 0..9 {
                let (found, claimed) = (sums[i * 9 + j] / samples, sigma * sigma * c[i * 9 + j]);
                // Five percent of the variance, or of the product of both standard deviations.
                let scale = sigma * sigma * (c[i * 9 + i] * c[j * 9 + j]).sqrt();
                assert!(
                    (found - claimed).abs() < 0.05 * scale,
                    "{pins} {ridge:?} {i} {j}: {found} {claimed}"
                );
            }
        }
    }
}
