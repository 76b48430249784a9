//! The size of a curve by a tolerance: the smallest that satisfies it, kept while the rope moves.

use lariat_fit::{Basis, Curve, Fit, Fitter, Judged, Line, Options, SteadySize, Tolerance};
use proptest::prelude::*;
use std::f64::consts::TAU;

const POINTS: usize = 120;
/// 25 frames per second.
const FRAME_NS: u64 = 40_000_000;

/// A rope 400 px long with this heading at each ρ, at equal steps of arc length as in the chain.
fn heading(at_rho: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    const FINE: usize = 20;
    let steps = FINE * (POINTS - 1);
    let step = 400.0 / steps as f64;
    let (mut at, mut points) = ([320.0, 240.0], vec![[320.0, 240.0]]);
    for i in 1..=steps {
        let heading = at_rho((i as f64 - 0.5) / steps as f64);
        at = [at[0] + step * heading.cos(), at[1] + step * heading.sin()];
        if i % FINE == 0 {
            points.push(at);
        }
    }
    points
}

/// A rope whose heading is a sum of waves of these amplitudes, in radians, and phases.
fn rope(waves: &[(f64, f64)]) -> Vec<[f64; 2]> {
    let wave = |(k, (amplitude, phase)): (f64, &(f64, f64)), rho: f64| {
        amplitude * (0.5 * TAU * k * rho + phase).sin()
    };
    heading(|rho| (1..).map(f64::from).zip(waves).map(|w| wave(w, rho)).sum())
}

/// A rope that turns sharply at this ρ, and is straight elsewhere.
fn hairpin(at_rho: f64) -> Vec<[f64; 2]> {
    heading(|rho| 2.0 * ((rho - at_rho) / 0.02).tanh())
}

fn any_rope() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let wave = (-1.5f64..1.5, 0.0..TAU);
    prop::collection::vec(wave, 0..6).prop_map(|waves| rope(&waves))
}

const GOOD: Judged = Judged {
    is_good: true,
    is_resized: false,
    is_hopeless: false,
};

const MISFIT: Judged = Judged {
    is_good: false,
    ..GOOD
};

fn auto() -> Fitter {
    Fitter::new(Options::auto(POINTS, false)).unwrap()
}

/// Distances of the points from the curve at their ρ, by the curve's own evaluation.
fn distances(fit: &Fit, points: &[[f64; 2]]) -> Vec<f64> {
    let curve = Curve::new(fit.basis, &fit.control_points, &fit.weights, &fit.knots).unwrap();
    let at = |(i, p): (usize, &[f64; 2])| {
        let q = curve.point(fit.basis.even_rho(i, points.len()));
        (p[0] - q[0]).hypot(p[1] - q[1])
    };
    points.iter().enumerate().map(at).collect()
}

fn holds(fit: &Fit, points: &[[f64; 2]], tolerance: Tolerance) -> bool {
    let mut distances = distances(fit, points);
    distances.sort_by(f64::total_cmp);
    // 114 of 120 points, and all.
    distances[113] <= tolerance.most && distances[119] <= tolerance.all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_chosen_curve_lies_on_the_rope_and_no_smaller_one_does(points in any_rope(), width in 4.0f64..30.0) {
        let tolerance = Tolerance::of_width(width, Tolerance::WIDTHS, Tolerance::LIMIT_PX);
        let mut fitter = auto();
        let line = Line::of(&points);
        let (size, is_found) = fitter.least_size(&line, tolerance).unwrap();
        prop_assert!(is_found);
        prop_assert!(holds(fitter.fit_at(size, &line).unwrap(), &points, tolerance));
        prop_assert!(fitter.lies_on(&line, tolerance));
        for smaller in 0..size {
            prop_assert!(!holds(fitter.fit_at(smaller, &line).unwrap(), &points, tolerance));
            prop_assert!(!fitter.lies_on(&line, tolerance));
        }
    }

    #[test]
    fn a_closed_rope_is_a_series_that_lies_on_it(waves in prop::collection::vec((-8.0f64..8.0, 0.0..TAU), 0..4)) {
        let points: Vec<[f64; 2]> = (0..POINTS)
            .map(|i| {
                let angle = TAU * i as f64 / POINTS as f64;
                let radius: f64 = (2..).zip(&waves).map(|(k, (a, phase))| a * (f64::from(k) * angle + phase).sin()).sum();
                [320.0 + (90.0 + radius) * angle.cos(), 240.0 + (90.0 + radius) * angle.sin()]
            })
            .collect();
        let mut fitter = Fitter::new(Options::auto(POINTS, true)).unwrap();
        let line = Line::of(&points);
        let (size, is_found) = fitter.least_size(&line, Tolerance::default()).unwrap();
        let fit = fitter.fit_at(size, &line).unwrap();
        prop_assert!(is_found && fit.basis.is_closed());
        prop_assert!(holds(fit, &points, Tolerance::default()));
    }
}

#[test]
fn the_smallest_curve_is_a_cubic_and_few_points_have_one_too() {
    let straight = rope(&[]);
    let mut fitter = auto();
    let (size, _) = fitter
        .least_size(&Line::of(&straight), Tolerance::default())
        .unwrap();
    assert_eq!(size, 0);
    let fit = fitter.fit_at(0, &Line::of(&straight)).unwrap();
    assert_eq!(fit.basis, Basis::Bezier { order: 3 });
    for points in 2..12 {
        let mut fitter = Fitter::new(Options::auto(points, false)).unwrap();
        let fit = fitter.fit(&straight[..points]).unwrap();
        assert!(fit.max_px < 1e-6, "{points}: {fit:?}");
    }
}

#[test]
fn what_no_size_can_follow_has_the_largest_and_is_no_fit() {
    let jagged: Vec<[f64; 2]> = (0..POINTS)
        .map(|i| [3.0 * i as f64, 40.0 * (i % 2) as f64])
        .collect();
    let mut fitter = auto();
    let chosen = fitter.least_size(&Line::of(&jagged), Tolerance::default());
    assert_eq!(chosen, Ok((fitter.sizes() - 1, false)));
    let judged =
        SteadySize::default().fit(&mut fitter, &Line::of(&jagged), Tolerance::default(), 0);
    assert_eq!(judged, Ok(MISFIT));
}

#[test]
fn a_rope_that_even_knots_cannot_follow_has_its_own_where_it_bends() {
    let tolerance = Tolerance::of_width(4.0, Tolerance::WIDTHS, Tolerance::LIMIT_PX);
    let bends = [0.35, 0.7];
    let ropes = bends.map(hairpin);
    let mut fitter = auto();
    let mut sizes = [SteadySize::of(0), SteadySize::of(1)];
    // The ropes share a fitter and take turns.
    for frame in 0..60 {
        for ((points, bend), size) in ropes.iter().zip(bends).zip(&mut sizes) {
            let line = Line::of(points);
            assert!(!fitter.least_size(&line, tolerance).unwrap().1);
            let judged = size.fit(&mut fitter, &line, tolerance, frame * FRAME_NS);
            assert_eq!(judged, Ok(GOOD));
            let fit = fitter.last();
            assert!(holds(fit, points, tolerance));
            let inner = &fit.knots[4..32];
            let near = inner
                .iter()
                .filter(|knot| (*knot - bend).abs() < 0.1)
                .count();
            assert!(near >= 10 && inner.is_sorted(), "{inner:?}");
        }
    }
}

#[test]
fn a_curve_of_a_named_order_is_judged_and_never_resized() {
    let points = rope(&[(1.2, 0.3), (1.4, 2.0), (1.5, 1.0)]);
    let mut fitter = Fitter::new(Options::bezier(4)).unwrap();
    let mut size = SteadySize::default();
    for frame in 0..90 {
        let line = Line::of(&points);
        let judged = size.fit(&mut fitter, &line, Tolerance::default(), frame * FRAME_NS);
        let is_hopeless = frame > 0 && frame % 25 == 0;
        assert_eq!(
            judged,
            Ok(Judged {
                is_hopeless,
                ..MISFIT
            }),
            "frame {frame}"
        );
        let mut alone = Fitter::new(Options::bezier(4)).unwrap();
        assert_eq!(alone.fit(&points).unwrap(), fitter.last());
    }
}

/// The number of control points in each frame of a film.
fn sizes(
    fitter: &mut Fitter,
    size: &mut SteadySize,
    film: impl Iterator<Item = Vec<[f64; 2]>>,
) -> Vec<(usize, Judged)> {
    let tolerance = Tolerance::of_width(12.0, Tolerance::WIDTHS, Tolerance::LIMIT_PX);
    let frames = film.zip(0u64..).map(|(points, frame)| {
        let judged = size.fit(fitter, &Line::of(&points), tolerance, 1 + frame * FRAME_NS);
        (fitter.last().control_points.len(), judged.unwrap())
    });
    frames.collect()
}

#[test]
fn a_rope_that_bends_more_and_less_keeps_its_size() {
    let film = (0..600).map(|frame| {
        let swing = (0.1 * f64::from(frame)).sin();
        rope(&[
            (0.9 + 0.1 * swing, 0.4),
            (0.8 - 0.15 * swing, 1.9),
            (0.5 * swing, 0.0),
        ])
    });
    let sizes = sizes(&mut auto(), &mut SteadySize::default(), film);
    let first = sizes[0].0;
    assert!(
        sizes.iter().all(|&frame| frame == (first, GOOD)),
        "{sizes:?}"
    );
}

#[test]
fn a_size_changes_after_a_second_of_misfit_once_and_says_so() {
    let winding = [(0.8, 0.4), (1.2, 1.9), (1.5, 0.7), (1.4, 2.2), (1.4, 5.0)];
    // Straight, wound for half a second, straight, and then wound permanently.
    let film = (0..150).map(|frame| match frame {
        30..42 | 60.. => rope(&winding),
        _ => rope(&[(0.1, 0.0)]),
    });
    let frames = sizes(&mut auto(), &mut SteadySize::default(), film);
    let (first, last) = (frames[0].0, frames[149].0);
    assert!(first < last, "{first} {last}");
    for (frame, &(size, judged)) in frames.iter().enumerate() {
        let is_after = frame >= 85;
        assert_eq!(size, if is_after { last } else { first }, "frame {frame}");
        assert_eq!(judged.is_resized, frame == 85, "frame {frame}");
        assert_eq!(
            judged.is_good,
            is_after || !matches!(frame, 30..42 | 60..),
            "frame {frame}"
        );
    }
}

#[test]
fn a_rope_unwound_keeps_the_size_that_it_needed() {
    let film = (0..90).map(|frame| match frame {
        0 => rope(&[(0.8, 0.4), (1.2, 1.9), (1.5, 0.7)]),
        _ => rope(&[]),
    });
    let frames = sizes(&mut auto(), &mut SteadySize::default(), film);
    assert!(frames.iter().all(|frame| frame.0 == frames[0].0));
}

#[test]
fn a_clock_that_goes_back_begins_the_second_again() {
    let (straight, wound) = (rope(&[]), rope(&[(1.4, 0.4), (1.4, 1.9), (1.5, 0.7)]));
    let (mut fitter, mut size) = (auto(), SteadySize::default());
    let mut at = |points: &[[f64; 2]], s: u64| {
        let tolerance = Tolerance::default();
        size.fit(&mut fitter, &Line::of(points), tolerance, s * 1_000_000_000)
            .unwrap()
    };
    at(&straight, 50);
    let resized = [60, 10, 11].map(|s| at(&wound, s).is_resized);
    assert_eq!(resized, [false, false, true]);
}

proptest! {
    #[test]
    fn points_in_single_precision_give_the_same_curve(points in any_rope(), width_px in 2.0f32..40.0) {
        let narrow: Vec<_> = points.iter().map(|p| p.map(|c| c as f32)).collect();
        let wide: Vec<_> = narrow.iter().map(|p| p.map(f64::from)).collect();
        let options = Options::auto(POINTS, false);
        let (mut one, mut other) = (Fitter::new(options).unwrap(), Fitter::new(options).unwrap());
        let tolerance = Tolerance::of_rope(width_px);
        let fit = one.fit_within(&narrow, tolerance).unwrap();
        prop_assert_eq!(fit, other.fit_within(&wide, tolerance).unwrap());
        let size = fit.control_points.len();
        prop_assert!(size >= one.fit_within(&narrow, Tolerance::of_rope(2.0 * width_px)).unwrap().control_points.len());
        prop_assert_eq!(&one.control_points(&narrow).unwrap(), &other.control_points(&wide).unwrap());
    }
}
