//! Behavior of a filter on ropes.

use crate::dense::Dense;
use lariat_fit::{CurveSpace, Filter, FilterOptions, FilterStep, Noise, Point};
use lariat_portable::SplitMix64;

const FRAME_NS: u64 = 10_000_000;

/// Options for a rope that certainly does not move, with any noise.
fn at_rest() -> FilterOptions {
    FilterOptions::default()
        .acceleration_px_s2(0.0)
        .acceleration_lasts_s(0.1)
        .speed_px_s(0.0)
        .noise_scale(1.0)
        .gate_sigma(f64::INFINITY)
        .longest_gap_s(1.0)
}

fn bezier(order: usize) -> CurveSpace {
    CurveSpace::new(Dense::bezier(order, 120).matrix()).unwrap()
}

fn even(variance_px2: f64) -> Noise<'static> {
    Noise::Even { variance_px2 }
}

fn line<const D: usize>(count: usize) -> Vec<[f64; D]> {
    (0..count)
        .map(|i| std::array::from_fn(|axis| 30.0 * i as f64 + 7.0 * axis as f64))
        .collect()
}

#[track_caller]
fn assert_near<const D: usize>(a: &[[f64; D]], b: &[[f64; D]], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
        assert!((a - b).abs() < tolerance, "{a} is not {b}");
    }
}

#[test]
fn a_rope_at_rest_is_known_k_times_as_well_after_k_shapes() {
    let b = Dense::bezier(8, 120);
    let of_fit = b.transposed().times(&b).inverse();
    let space = bezier(8);
    for given_as_matrix in [false, true] {
        let mut filter = Filter::<2>::new(9, at_rest()).unwrap();
        let random = &mut SplitMix64::new(3);
        let mut sum = [[0.0; 2]; 9];
        let variance_px2 = 0.25;
        let covariance = of_fit.scaled(variance_px2);
        for k in 1..=100u64 {
            let shape: Vec<[f64; 2]> = line(9)
                .iter()
                .map(|p: &[f64; 2]| p.map(|c| c + 10.0 * random.normal()))
                .collect();
            for (sum, p) in sum.iter_mut().zip(&shape) {
                *sum = [sum[0] + p[0], sum[1] + p[1]];
            }
            let noise = if given_as_matrix {
                Noise::Covariance(&covariance.numbers)
            } else {
                even(variance_px2)
            };
            filter.update(k * FRAME_NS, &space, &shape, noise).unwrap();
            let now = filter.predict(k * FRAME_NS).unwrap();
            let mean: Vec<_> = sum.iter().map(|s| s.map(|c| c / k as f64)).collect();
            assert_near(&now.control_points, &mean, 1e-6);
            let found = Dense::from_fn(9, 9, |i, j| now.covariance_px2[i * 9 + j]);
            let expected = covariance.scaled(1.0 / k as f64);
            // 1e-4 px is added to every noise: 1e-8 of 0.25 · 9/120 px².
            assert!(found.difference(&expected) < 1e-5, "{k}");
            assert_near(&now.velocities_px_s, &[[0.0; 2]; 9], 1e-12);
        }
    }
}

fn moving<const D: usize>(count: usize, t_ns: u64) -> Vec<[f64; D]> {
    let mut shape = line(count);
    for (i, p) in shape.iter_mut().enumerate() {
        for (axis, c) in p.iter_mut().enumerate() {
            *c += (100.0 - 3.0 * (i * axis) as f64) * t_ns as f64 * 1e-9;
        }
    }
    shape
}

fn a_steady_rope_is_predicted<const D: usize>(b: &Dense)
where
    [f64; D]: Point<D>,
{
    let count = b.columns;
    let space = CurveSpace::new(b.matrix()).unwrap();
    let mut filter = Filter::<D>::new(32, FilterOptions::default()).unwrap();
    for frame in 0..20 {
        let t_ns = frame * FRAME_NS;
        let step = filter
            .update(t_ns, &space, &moving(count, t_ns), even(0.0))
            .unwrap();
        assert_eq!(step.is_beginning(), frame == 0, "{step}");
    }
    let velocities: Vec<[f64; D]> = (0..count)
        .map(|i| std::array::from_fn(|axis| 100.0 - 3.0 * (i * axis) as f64))
        .collect();
    // At order 31, rounding of control points is amplified by B's condition number, but the curve
    // is exact.
    let curve = |points: &[[f64; D]]| -> Vec<[f64; D]> {
        let found = b.times(&Dense::from_fn(count, D, |i, j| points[i][j]));
        found.numbers.as_chunks().0.to_vec()
    };
    // Half a second ahead, between frames, at a frame, and back.
    for t_ns in [
        690_000_000,
        193_456_789,
        190_000_000,
        187_000_000,
        101_000_000,
    ] {
        let found = filter.predict(t_ns).unwrap();
        assert_eq!(found.t_ns, t_ns);
        assert_near(
            &curve(&found.control_points),
            &curve(&moving(count, t_ns)),
            1e-5,
        );
        assert_near(&curve(&found.velocities_px_s), &curve(&velocities), 1e-5);
    }
}

#[test]
fn a_rope_of_constant_velocity_is_predicted_exactly() {
    a_steady_rope_is_predicted::<2>(&Dense::bezier(8, 120));
    a_steady_rope_is_predicted::<3>(&Dense::bezier(8, 120));
    a_steady_rope_is_predicted::<2>(&Dense::bezier(4, 120));
    a_steady_rope_is_predicted::<2>(&Dense::identity(1));
    a_steady_rope_is_predicted::<3>(&Dense::identity(32));
    a_steady_rope_is_predicted::<2>(&Dense::bezier(31, 256));
}

#[test]
fn the_further_ahead_or_back_the_less_is_known() {
    let space = bezier(8);
    let mut filter = Filter::<2>::new(9, FilterOptions::default()).unwrap();
    for frame in 10..40 {
        let t_ns = frame * FRAME_NS;
        filter
            .update(t_ns, &space, &moving(9, t_ns), even(0.2))
            .unwrap();
    }
    let last = 39 * FRAME_NS as i64;
    for direction in [1, -1] {
        let mut least = [0.0; 2];
        // Going back reduces the uncertainty of positions at first, because errors of position and
        // velocity cancel.
        for step in if direction > 0 { 0..20 } else { 6..20 } {
            let found = filter
                .predict((last + direction * step * 10_000_000) as u64)
                .unwrap();
            let traces = [&found.covariance_px2, &found.velocity_covariance_px2_s2]
                .map(|covariance| covariance.iter().step_by(10).sum::<f64>());
            assert!(traces[0] > least[0] && traces[1] > least[1], "{step}");
            least = traces;
        }
    }
}

#[test]
fn what_a_shape_does_not_see_is_left_as_it_was() {
    // The shape has an uncertainty of 30,000 px in one direction only, and is far off in that
    // direction.
    let count = 9;
    let b = Dense::bezier(8, 120);
    let gram = b.transposed().times(&b);
    let space = bezier(8);
    let direction: Vec<f64> = (0..count).map(|i| (1.3 * i as f64).sin() + 0.2).collect();
    let uncertain = gram.inverse().scaled(0.1).plus(
        1e9,
        &Dense::from_fn(count, count, |i, j| direction[i] * direction[j]),
    );
    // The direction orthogonal to everything observed, by the observed covariance.
    let dual = Dense::from_fn(1, count, |_, j| direction[j]).times(&gram);
    let along =
        |points: &[[f64; 2]], axis: usize| dual.times(&Dense::column_of(points, axis))[(0, 0)];
    let mut filter = Filter::<2>::new(count, at_rest()).unwrap();
    filter
        .update(FRAME_NS, &space, &line(count), even(0.1))
        .unwrap();
    let before = filter.predict(FRAME_NS).unwrap().control_points.clone();
    let shape: Vec<[f64; 2]> = line(count)
        .iter()
        .zip(&direction)
        .map(|(p, d): (&[f64; 2], _)| [p[0] + 400.0 * d + 2.0, p[1] - 300.0 * d])
        .collect();
    filter
        .update(
            2 * FRAME_NS,
            &space,
            &shape,
            Noise::Covariance(&uncertain.numbers),
        )
        .unwrap();
    let after = &filter.predict(2 * FRAME_NS).unwrap().control_points;
    let moved: Vec<[f64; 2]> = after
        .iter()
        .zip(&before)
        .map(|(a, b)| [a[0] - b[0], a[1] - b[1]])
        .collect();
    let scale: f64 = along(&direction.iter().map(|&d| [d, d]).collect::<Vec<_>>(), 0);
    // No motion along the hidden direction. In the others, half of the way to the shape.
    for axis in [0, 1] {
        assert!((along(&moved, axis) / scale).abs() < 1e-4, "{axis}");
    }
    let ones: Vec<[f64; 2]> = vec![[1.0, 1.0]; count];
    let hidden_part = along(&ones, 0) / scale;
    for (moved, d) in moved.iter().zip(&direction) {
        assert!(
            (moved[0] - (1.0 - hidden_part * d)).abs() < 1e-3,
            "{moved:?}"
        );
        assert!(moved[1].abs() < 1e-3, "{moved:?}");
    }
}

#[test]
fn a_hidden_part_goes_on_with_its_velocity() {
    let space = CurveSpace::of_points(2).unwrap();
    let mut filter = Filter::<2>::new(2, FilterOptions::default()).unwrap();
    let at = |frame: u64| [[frame as f64, 0.0], [2.0 * frame as f64, 50.0]];
    for frame in 0..30 {
        filter
            .update(frame * FRAME_NS, &space, &at(frame), even(0.01))
            .unwrap();
    }
    for frame in 30..40 {
        let shape = [at(frame)[0], [-3000.0, 900.0]];
        let hidden = [0.01, 0.0, 0.0, 1e14];
        let step = filter.update(frame * FRAME_NS, &space, &shape, Noise::Covariance(&hidden));
        assert!(!step.unwrap().is_beginning());
    }
    let found = filter.predict(39 * FRAME_NS).unwrap();
    assert_near(&found.control_points, &at(39), 0.5);
    assert!(found.covariance_px2[3] > 100.0 * found.covariance_px2[0]);
}

#[test]
fn a_rope_that_jumps_is_followed_from_where_it_is() {
    let space = bezier(8);
    let mut filter = Filter::<2>::new(9, FilterOptions::default()).unwrap();
    for frame in 1..20 {
        let t_ns = frame * FRAME_NS;
        filter
            .update(t_ns, &space, &moving(9, t_ns), even(0.1))
            .unwrap();
    }
    let elsewhere: Vec<[f64; 2]> = moving(9, 20 * FRAME_NS)
        .iter()
        .map(|p: &[f64; 2]| [p[0] + 60.0, p[1]])
        .collect();
    let step = filter
        .update(20 * FRAME_NS, &space, &elsewhere, even(0.1))
        .unwrap();
    assert!(
        matches!(step, FilterStep::Jumped { nis } if nis > 1e3),
        "{step}"
    );
    let found = filter.predict(20 * FRAME_NS).unwrap();
    assert_near(&found.control_points, &elsewhere, 1e-9);
    assert_near(&found.velocities_px_s, &[[0.0; 2]; 9], 1e-9);
    let speed_variance = FilterOptions::default().speed_px_s.powi(2);
    assert!(found.velocity_covariance_px2_s2[0] > 0.9 * speed_variance);
}

#[test]
fn a_long_gap_is_not_bridged_and_a_short_one_is() {
    let space = bezier(3);
    let mut filter = Filter::<2>::new(4, FilterOptions::default()).unwrap();
    let shape = line(4);
    assert_eq!(filter.last_ns(), None);
    filter.update(0, &space, &shape, even(0.1)).unwrap();
    let step = filter.update(500_000_000, &space, &shape, even(0.1));
    assert!(matches!(step, Ok(FilterStep::Updated { .. })));
    let step = filter.update(1_000_000_001, &space, &shape, even(0.1));
    assert!(matches!(step, Ok(FilterStep::LongGap { seconds }) if seconds > 0.5));
    assert_eq!(filter.last_ns(), Some(1_000_000_001));
}

#[test]
fn another_order_begins_again() {
    let (eight, ten) = (bezier(8), bezier(10));
    let mut filter = Filter::<2>::new(11, FilterOptions::default()).unwrap();
    let step = |filter: &mut Filter<2>, frame: u64, space: &CurveSpace| {
        filter
            .update(
                frame * FRAME_NS,
                space,
                &line(space.control_points()),
                even(0.1),
            )
            .unwrap()
    };
    assert_eq!(step(&mut filter, 1, &eight), FilterStep::Began);
    assert!(matches!(
        step(&mut filter, 2, &eight),
        FilterStep::Updated { .. }
    ));
    assert_eq!(step(&mut filter, 3, &ten), FilterStep::OtherCurves);
    assert_eq!(
        filter.predict(3 * FRAME_NS).unwrap().control_points.len(),
        11
    );
    assert!(matches!(
        step(&mut filter, 4, &ten.clone()),
        FilterStep::Updated { .. }
    ));
    assert_eq!(step(&mut filter, 5, &eight), FilterStep::OtherCurves);
    let found = filter.predict(5 * FRAME_NS).unwrap();
    assert_eq!(found.covariance_px2.len(), 81);
    assert_near(&found.control_points, &line(9), 1e-9);
    filter.forget();
    assert_eq!(step(&mut filter, 1, &eight), FilterStep::Began);
}

#[test]
fn every_step_is_a_sentence() {
    let sentences = [
        FilterStep::Began,
        FilterStep::Updated { nis: 17.25 },
        FilterStep::OtherCurves,
        FilterStep::LongGap { seconds: 1.5 },
        FilterStep::Jumped { nis: 4000.0 },
    ]
    .map(|step| step.to_string());
    assert_eq!(
        sentences,
        [
            "the filter began with this shape",
            "the shape was taken in, its normalized innovation squared 17.2",
            "the filter began again: the shape has other curves than those before it",
            "the filter began again: the last shape was 1.500 s ago",
            "the filter began again: the rope jumped, its normalized innovation squared 4000.0",
        ]
    );
}

#[test]
fn covariances_stay_positive_definite_over_many_steps() {
    // Parts appear and disappear, frames are late, and precise shapes follow vague ones.
    for (order, steps) in [(8, 20_000), (17, 2_000), (24, 500)] {
        let count = order + 1;
        let b = Dense::bezier(order, 120);
        let space = bezier(order);
        let random = &mut SplitMix64::new(order as u64);
        let covariances: Vec<Dense> = (0..5)
            .map(|part| {
                let weighed = Dense::from_fn(120, count, |i, j| {
                    let hidden = part > 0 && (part * 20..part * 20 + 15).contains(&i);
                    if hidden { 0.1 * b[(i, j)] } else { b[(i, j)] }
                });
                // Uses a factor, because the inverse itself would be inaccurate at order 24.
                let l = weighed.transposed().times(&weighed).cholesky();
                let inverse = l.expect("positive definite").lower_inverse();
                inverse.transposed().times(&inverse)
            })
            .collect();
        let options = FilterOptions::default().gate_sigma(f64::INFINITY);
        let mut filter = Filter::<2>::new(count, options).unwrap();
        let mut t_ns = 0;
        for step in 0..steps {
            let slow = random.unit().powi(8);
            t_ns += 100_000 + (0.4e9 * slow) as u64;
            let part = (random.unit() * 5.0) as usize;
            let variance_px2 = 10f64.powf(4.0 * random.unit() - 4.0);
            let scaled = covariances[part].scaled(variance_px2);
            let noise = if order <= 17 && part > 0 {
                Noise::Covariance(&scaled.numbers)
            } else {
                even(variance_px2)
            };
            let taken = filter.update(t_ns, &space, &line(count), noise).unwrap();
            assert_eq!(taken.is_beginning(), step == 0, "{step}: {taken}");
        }
        let found = filter.predict(t_ns + 1_000_000).unwrap();
        for covariance in [&found.covariance_px2, &found.velocity_covariance_px2_s2] {
            let matrix = Dense::from_fn(count, count, |i, j| covariance[i * count + j]);
            assert_eq!(matrix, matrix.transposed());
            // At order 24, rounding of control points alone makes the matrix indefinite.
            assert!(order > 17 || matrix.cholesky().is_some(), "order {order}");
        }
    }
}
