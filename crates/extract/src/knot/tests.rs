//! Ropes in space, seen from above: the height tells which strand is on top.

use super::*;
use crate::scene::{Crossing, Curve};

type Vec3 = [f64; 3];
/// Width of all ropes here: thin compared with their loops.
const WIDTH: f32 = 0.05;

/// Returns what an extractor would see of a rope along `space`, with y down.
fn seen(space: &[Vec3]) -> (Vec<Curve>, Vec<Crossing>) {
    let mut lengths = vec![0.0f64];
    for pair in space.windows(2) {
        let step = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        lengths.push(lengths[lengths.len() - 1] + step);
    }
    let whole = lengths[lengths.len() - 1];
    let points: Vec<Vec2> = (0..200)
        .map(|k| {
            let goal = whole * f64::from(k) / 199.0;
            let i = lengths.partition_point(|&l| l < goal).min(space.len() - 1);
            [space[i][0] as f32, space[i][1] as f32]
        })
        .collect();
    let mut crossings = Vec::new();
    for i in 0..space.len() - 1 {
        for j in i + 2..space.len() - 1 {
            let Some((t, u)) = meet([space[i], space[i + 1]], [space[j], space[j + 1]]) else {
                continue;
            };
            let height = |k: usize, t: f64| space[k][2] + t * (space[k + 1][2] - space[k][2]);
            let rho = |k: usize, t: f64| {
                ((lengths[k] + t * (lengths[k + 1] - lengths[k])) / whole) as f32
            };
            let (first, second) = (rho(i, t), rho(j, u));
            let is_first_over = height(i, t) > height(j, u);
            let (over_rho, under_rho) = if is_first_over {
                (first, second)
            } else {
                (second, first)
            };
            crossings.push(Crossing {
                at: [space[i][0] as f32, space[i][1] as f32],
                over: 0,
                under: 0,
                over_rho,
                under_rho,
                confidence: 1.0,
            });
        }
    }
    let curve = Curve {
        widths_px: vec![WIDTH; points.len()],
        hidden: vec![false; points.len()],
        points,
        width_px: WIDTH,
        length_px: whole as f32,
        confidence: 1.0,
        ..Curve::default()
    };
    (vec![curve], crossings)
}

/// The place where two segments cross, as shares of each.
fn meet([a, b]: [Vec3; 2], [c, d]: [Vec3; 2]) -> Option<(f64, f64)> {
    let (ab, cd) = ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]]);
    let ac = [c[0] - a[0], c[1] - a[1]];
    let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let area = cross(ab, cd);
    let (t, u) = (cross(ac, cd) / area, cross(ac, ab) / area);
    let inside = |v: f64| (0.0..1.0).contains(&v);
    (inside(t) && inside(u)).then_some((t, u))
}

fn sequence(space: &[Vec3]) -> CrossingSequence {
    sequence_of(&seen(space))
}

fn sequence_of((curves, crossings): &(Vec<Curve>, Vec<Crossing>)) -> CrossingSequence {
    let scene = Scene {
        curves,
        crossings,
        notice: None,
        followed: false,
    };
    CrossingSequence::of(&scene, 0)
}

/// Samples of `curve` from −`half` to `half`.
fn along_curve(half: f64, curve: impl Fn(f64) -> Vec3) -> Vec<Vec3> {
    (0..=800)
        .map(|i| curve(half * (f64::from(i) / 400.0 - 1.0)))
        .collect()
}

/// The long trefoil as a polynomial curve (A. R. Shastri, "Polynomial representations of knots",
/// 1992).
fn overhand_knot() -> Vec<Vec3> {
    along_curve(2.3, |t| {
        [
            t.powi(3) - 3.0 * t,
            t.powi(4) - 4.0 * t * t,
            t.powi(5) - 10.0 * t,
        ]
    })
}

/// The long figure-eight knot, also as a polynomial curve.
fn figure_eight() -> Vec<Vec3> {
    along_curve(2.15, |t| {
        [
            t.powi(3) - 3.0 * t,
            t * (t * t - 1.0) * (t * t - 4.0),
            t.powi(7) - 42.0 * t,
        ]
    })
}

/// Loops in a row, like the coils of a spring laid flat, each over or under itself.
fn coils(count: u32, is_over: impl Fn(u32) -> bool) -> Vec<Vec3> {
    let turns = f64::from(count) * std::f64::consts::TAU;
    (0..=1200)
        .map(|i| {
            let a = turns * f64::from(i) / 1200.0;
            let coil = (a / std::f64::consts::TAU) as u32;
            let height = if is_over(coil.min(count - 1)) {
                1.0
            } else {
                -1.0
            };
            [3.0 * a + 5.0 * a.sin(), 5.0 * a.cos(), height * a]
        })
        .collect()
}

/// The same rope with the upper and lower strand of one crossing exchanged.
fn turned_over(space: &[Vec3], crossing: usize) -> CrossingSequence {
    let (curves, mut crossings) = seen(space);
    let turned = &mut crossings[crossing];
    std::mem::swap(&mut turned.over_rho, &mut turned.under_rho);
    sequence_of(&(curves, crossings))
}

#[test]
fn an_overhand_knot_is_knotted() {
    let knot = sequence(&overhand_knot());
    assert_eq!(knot.to_string(), "U1 O2 U3 O1 U2 O3");
    assert!(knot.diagram.is_planar());
    let determinant = alexander::knot_determinant(knot.passes(), knot.diagram.signs());
    assert_eq!(determinant, 3);
    assert_eq!(knot.pulls_straight(), Some(false));
}

#[test]
fn an_overhand_knot_with_a_crossing_the_other_way_pulls_straight() {
    for crossing in 0..3 {
        let loose = turned_over(&overhand_knot(), crossing);
        assert_eq!(loose.pulls_straight(), Some(true), "{loose}");
    }
}

#[test]
fn a_figure_eight_is_knotted() {
    let knot = sequence(&figure_eight());
    assert!(knot.diagram.is_planar());
    let determinant = alexander::knot_determinant(knot.passes(), knot.diagram.signs());
    assert_eq!(determinant, 5);
    assert_eq!(knot.pulls_straight(), Some(false));
    for crossing in 0..knot.confidences.len() {
        let loose = turned_over(&figure_eight(), crossing);
        // Whichever crossing is turned over, the knot falls apart: one exchange of strands undoes
        // it.
        assert_eq!(loose.pulls_straight(), Some(true), "{loose}");
    }
}

#[test]
fn loops_pull_straight() {
    let plain = sequence(&coils(1, |_| true));
    assert_eq!(plain.pulls_straight(), Some(true), "{plain}");
    let straight = sequence(&[[0.0; 3], [9.0, 0.0, 0.0]]);
    assert_eq!(
        (straight.to_string().as_str(), straight.pulls_straight()),
        ("", Some(true))
    );
    for sides in 0..8u32 {
        let coiled = sequence(&coils(3, |coil| sides >> coil & 1 == 1));
        assert!(coiled.passes().len() >= 4, "{coiled}");
        assert_eq!(coiled.pulls_straight(), Some(true), "{coiled}");
    }
}

/// Random smooth ropes, each coordinate a few waves along the rope. If a crossing is so flat that
/// its sign is wrong, the diagram does not fit into a plane. Those few are left out.
fn random_ropes(is_laid_down: bool) -> Vec<CrossingSequence> {
    let mut seed = 1u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 40) as f64 / (1u64 << 24) as f64 - 0.5
    };
    let mut ropes = Vec::new();
    for _ in 0..300 {
        let waves: [[[f64; 2]; 5]; 3] =
            std::array::from_fn(|_| std::array::from_fn(|_| [random(), random()]));
        let rope = along_curve(1.0, |t| {
            let at = |axis: usize| -> f64 {
                let wave = |k: usize| {
                    let (sin, cos) = (2.2 * (k + 1) as f64 * t).sin_cos();
                    waves[axis][k][0] * sin + waves[axis][k][1] * cos
                };
                (0..5).map(wave).sum()
            };
            [at(0), at(1), if is_laid_down { t } else { at(2) }]
        });
        ropes.push(sequence(&rope));
    }
    ropes.retain(|rope| rope.diagram.is_planar());
    assert!(ropes.len() > 200, "{}", ropes.len());
    ropes
}

#[test]
fn a_rope_laid_down_from_end_to_end_pulls_straight_however_it_lies() {
    // Each rope only ever lies on its own earlier parts, so none is knotted.
    for rope in random_ropes(true) {
        assert_eq!(rope.pulls_straight(), Some(true), "{rope}");
    }
}

#[test]
fn no_rope_is_both_straight_and_knotted() {
    // The moves and the invariant are independent of each other.
    let mut answers = [0; 3];
    for rope in random_ropes(false) {
        let diagram = &rope.diagram;
        let knotted = alexander::proves_a_knot(diagram.passes(), diagram.signs());
        let straight = diagram.clone().comes_apart();
        assert!(!(knotted && straight), "{rope}");
        answers[if knotted {
            0
        } else if straight {
            1
        } else {
            2
        }] += 1;
    }
    let [knotted, straight, undecided] = answers;
    assert!(
        knotted > 20 && straight > 100 && undecided < 10,
        "{answers:?}"
    );
}

#[test]
fn a_crossing_that_was_not_seen_clearly_counts_both_ways() {
    let mut knot = seen(&overhand_knot());
    knot.1[1].confidence = 0.05;
    assert_eq!(sequence_of(&knot).pulls_straight(), None);
    // For a plain loop, the confidence of its crossing does not matter.
    let mut plain = seen(&coils(1, |_| true));
    plain.1[0].confidence = 0.0;
    assert_eq!(sequence_of(&plain).pulls_straight(), Some(true));
    assert_eq!(sequence_of(&plain).confidence(), 0.0);
}

#[test]
fn an_answer_needs_the_probability_of_curve_and_crossings_together() {
    // Three crossings at 0.97 each: 0.913. Any one of them turned over would undo the knot.
    let answer = |curve: f32, crossing: f32| {
        let mut knot = seen(&overhand_knot());
        knot.0[0].confidence = curve;
        knot.1
            .iter_mut()
            .for_each(|one| one.confidence = 2.0 * crossing - 1.0);
        sequence_of(&knot).pulls_straight()
    };
    assert_eq!(answer(1.0, 0.97), Some(false));
    assert_eq!(answer(0.95, 0.97), None);
    assert_eq!(answer(1.0, 0.95), None);
    // For a straight rope, only the curve can be in doubt.
    let (mut curves, crossings) = seen(&[[0.0; 3], [9.0, 0.0, 0.0]]);
    for (confidence, answer) in [(0.95, Some(true)), (0.5, None)] {
        curves[0].confidence = confidence;
        let sequence = sequence_of(&(curves.clone(), crossings.clone()));
        assert_eq!(sequence.pulls_straight(), answer, "{confidence}");
    }
}

#[test]
fn a_bump_may_be_a_tight_knot() {
    let (mut curves, crossings) = seen(&[[0.0; 3], [9.0, 0.0, 0.0]]);
    curves[0].widths_px[100] = 2.0 * WIDTH;
    assert_eq!(sequence_of(&(curves, crossings)).pulls_straight(), None);
    // A rope looks wide at its crossing.
    let (mut curves, crossings) = seen(&coils(1, |_| true));
    let crossed = (199.0 * crossings[0].over_rho).round() as usize;
    curves[0].widths_px[crossed] = 2.0 * WIDTH;
    assert_eq!(
        sequence_of(&(curves, crossings)).pulls_straight(),
        Some(true)
    );
}

#[test]
fn nothing_is_said_of_a_rope_that_is_not_seen_whole() {
    let (mut curves, mut crossings) = seen(&overhand_knot());
    for status in [Status::Partial, Status::Lost] {
        curves[0].status = status;
        assert_eq!(
            sequence_of(&(curves.clone(), crossings.clone())).pulls_straight(),
            None
        );
    }
    curves[0].status = Status::Ok;
    curves[0].hidden[50] = true;
    let hidden = (curves.clone(), crossings.clone());
    assert_eq!(sequence_of(&hidden).pulls_straight(), None);
    curves[0].hidden[50] = false;
    // With a crossing missed, the rest does not fit into a plane.
    crossings.remove(1);
    assert_eq!(sequence_of(&(curves, crossings)).pulls_straight(), None);
}

#[test]
fn crossings_with_other_ropes_are_no_part_of_the_sequence() {
    let (mut curves, mut crossings) = seen(&overhand_knot());
    curves.push(curves[0].clone());
    for crossing in crossings.clone() {
        crossings.push(Crossing {
            under: 1,
            ..crossing
        });
    }
    let scene = Scene {
        curves: &curves,
        crossings: &crossings,
        notice: None,
        followed: false,
    };
    assert_eq!(CrossingSequence::of(&scene, 0).passes().len(), 6);
    assert_eq!(CrossingSequence::of(&scene, 1).passes().len(), 0);
}
