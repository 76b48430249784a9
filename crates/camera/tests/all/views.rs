//! Locates ropes in two views, and compares them with their true places. The centerlines are the
//! true ones with noise.

use crate::drawn::Line;
use lariat_camera::{
    Camera, Lens, NoSecondView, Partner, Pose, RopeViews, SeenRope, SpacePoint, ViewPair,
    ViewPairError,
};
use lariat_drawn::space::{Eye, LiftOptions, LiftedRope};
use lariat_portable::SplitMix64;
use std::sync::LazyLock;

const SIZE: [usize; 2] = [848, 480];
const FOCAL_PX: f64 = 610.0;
/// From the first camera to the second, mm.
const ASIDE: [f64; 3] = [100.0, 0.0, 0.0];

#[derive(Clone)]
struct Scene {
    rope: LiftedRope,
    eyes: [Eye; 2],
    lines: [Line; 2],
}

impl Scene {
    /// Places a rope in front of two cameras.
    fn new(options: &LiftOptions, seed: u64) -> Self {
        let first = Eye::above(FOCAL_PX, SIZE, 500.0, 15.0, 40.0 * seed as f64);
        let rope = LiftedRope::new(options, &first, seed).expect("a rope that fits");
        Self::of(rope, [first, first.verging(ASIDE, 500.0)])
    }

    fn of(rope: LiftedRope, eyes: [Eye; 2]) -> Self {
        let lines = eyes.map(|eye| Line::of(&rope, &eye));
        Self { rope, eyes, lines }
    }

    /// Adds noise of `sigma_px` pixels to the points of the centerlines.
    fn blur(&mut self, sigma_px: f64, seed: u64) {
        let mut random = SplitMix64::of_stream(seed, 7);
        for line in &mut self.lines {
            for point in &mut line.points {
                *point = point.map(|c| (f64::from(c) + sigma_px * random.normal()) as f32);
            }
        }
    }

    fn finder(&self) -> RopeViews {
        RopeViews::new(pair(self.eyes))
    }

    /// Locates the first view's points.
    fn locate(&self, finder: &mut RopeViews) -> Result<Vec<SpacePoint>, NoSecondView> {
        finder.clear();
        finder.add_first(&seen(&self.lines[0], &[false; 120]));
        finder.add_second(&seen(&self.lines[1], &[false; 120]));
        finder.pair();
        finder.locate(0).map(<[_]>::to_vec)
    }

    /// Distance of each point from the rope's true axis, mm.
    fn errors(&self, places: &[SpacePoint]) -> Vec<f64> {
        let truth: Vec<[f64; 3]> = (self.rope.points.iter())
            .map(|&p| self.eyes[0].see(p))
            .collect();
        let far = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>();
        let nearest = |place: &SpacePoint| {
            let squares = truth.iter().map(|&t| far(t, place.point));
            squares.fold(f64::MAX, f64::min).sqrt()
        };
        places.iter().map(nearest).collect()
    }
}

fn seen<'a>(line: &'a Line, hidden: &'a [bool]) -> SeenRope<'a> {
    SeenRope {
        points: &line.points,
        widths_px: &line.widths,
        hidden,
        closed: false,
        // The points are those of the axis.
        ends: [false; 2],
    }
}

fn camera(eye: &Eye) -> Camera {
    let size = Some(eye.size.map(|side| side as u32));
    Camera::new(eye.focal_px, eye.center_px, Lens::IDEAL, size).expect("a camera")
}

fn pair(eyes: [Eye; 2]) -> ViewPair {
    let (rotation, place) = eyes[1].pose_in(&eyes[0]);
    let pose = Pose::new(rotation, place).expect("a pose");
    ViewPair::new(camera(&eyes[0]), camera(&eyes[1]), pose, [200.0, 1500.0]).expect("a pair")
}

/// Ropes on the table, lifted, and lifted high, with zero to two crossings. Each rope is drawn
/// once.
fn scenes() -> impl Iterator<Item = (u64, Scene)> {
    static SCENES: LazyLock<Vec<Scene>> = LazyLock::new(|| (0..18).map(scene).collect());
    (0..).zip(SCENES.iter().cloned())
}

fn scene(seed: u64) -> Scene {
    let options = LiftOptions {
        length_mm: 600.0,
        radius_mm: 4.0,
        lift_mm: [0.0, 60.0, 120.0][seed as usize % 3],
        crossings: seed as usize / 3 % 3,
    };
    Scene::new(&options, seed)
}

#[test]
fn ropes_are_found_to_a_fraction_of_a_millimetre() {
    for (sigma, most) in [(0.0, 0.1), (0.1, 0.6)] {
        let mut all = Vec::new();
        for (seed, mut scene) in scenes() {
            scene.blur(sigma, seed);
            let places = scene.locate(&mut scene.finder());
            let places = places.unwrap_or_else(|cause| panic!("{seed}: {cause}"));
            all.extend(scene.errors(&places));
        }
        all.sort_by(f64::total_cmp);
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let [p95, worst] = [95, 100].map(|share| all[(all.len() - 1) * share / 100]);
        println!("{sigma} px: mean {mean:.3} mm, 95 % {p95:.3}, worst {worst:.3}");
        assert!(mean < most && p95 < 3.0 * most && worst < 10.0);
    }
}

#[test]
fn the_stated_variance_is_that_of_the_errors() {
    const SIGMA_PX: f64 = 0.1;
    let (mut within, mut bridged) = ([0, 0], [0, 0]);
    for (seed, mut scene) in scenes() {
        let ahead = scene.lines[0].ahead.clone();
        scene.blur(SIGMA_PX, seed);
        let places = scene.locate(&mut scene.finder()).expect("a rope in space");
        for (place, ahead) in places.iter().zip(ahead) {
            let by_pixel = place.by_pixel[2].iter().map(|d| d * d).sum::<f64>();
            let variance = place.variance + SIGMA_PX * SIGMA_PX * by_pixel;
            let counts = if place.is_measured {
                &mut within
            } else {
                &mut bridged
            };
            counts[0] += usize::from((place.point[2] - ahead).abs() < 1.96 * variance.sqrt());
            counts[1] += 1;
        }
    }
    println!("{within:?}; bridged {bridged:?}");
    assert!(10 * within[0] >= 9 * within[1] && 100 * within[0] <= 99 * within[1]);
    assert!(10 * bridged[0] >= 9 * bridged[1]);
}

#[test]
fn ropes_are_told_from_each_other_whatever_their_order_and_direction() {
    let scenes: Vec<Scene> = scenes().step_by(5).map(|(_, scene)| scene).collect();
    // Both cameras are where those of the first scene are.
    let eyes = scenes[0].eyes;
    let of_first = |scene: Scene| Scene::of(scene.rope, eyes);
    let scenes: Vec<Scene> = scenes.into_iter().map(of_first).collect();
    let mut finder = scenes[0].finder();
    let count = scenes.len();
    for scene in &scenes {
        finder.add_first(&seen(&scene.lines[0], &[false; 120]));
    }
    for (k, scene) in scenes.iter().rev().enumerate() {
        let mut line = Line::of(&scene.rope, &eyes[1]);
        if k.is_multiple_of(2) {
            line.points.reverse();
            line.widths.reverse();
        }
        finder.add_second(&seen(&line, &[false; 120]));
    }
    let partners: Vec<Result<Partner, NoSecondView>> = (0..count)
        .map(|i| {
            let rope = count - 1 - i;
            let is_backward = rope.is_multiple_of(2);
            Ok(Partner { rope, is_backward })
        })
        .collect();
    assert_eq!(finder.pair(), partners);
    for (i, scene) in scenes.iter().enumerate() {
        let places = finder.locate(i).expect("a rope in space").to_vec();
        let errors = scene.errors(&places);
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(mean < 0.5, "rope {i}: {mean} mm");
    }
}

#[test]
fn strands_that_one_view_takes_for_each_other_are_told_by_the_other() {
    let mut tried = 0;
    for (seed, scene) in scenes().filter(|(_, scene)| !scene.rope.crossings.is_empty()) {
        for view in [0, 1] {
            let mut scene = scene.clone();
            let line = &mut scene.lines[view];
            let Some([from, to]) = crossing(&line.points) else {
                continue;
            };
            line.points[from + 1..=to].reverse();
            line.widths[from + 1..=to].reverse();
            let places = scene.locate(&mut scene.finder());
            let places = places.unwrap_or_else(|cause| panic!("{seed}: {cause}"));
            let errors = scene.errors(&places);
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            println!("{seed}, view {view}: {mean:.2} mm");
            assert!(mean < 1.0, "{seed}, view {view}: {mean} mm");
            tried += 1;
        }
    }
    assert!(tried > 12);
}

/// The two points after which a line crosses itself for the first time.
fn crossing(points: &[[f32; 2]]) -> Option<[usize; 2]> {
    let side = |a: [f32; 2], b: [f32; 2], c: [f32; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
    };
    let last = points.len() - 1;
    let pairs = (0..last).flat_map(|i| (i + 2..last).map(move |j| [i, j]));
    let mut crosses = pairs.filter(|&[i, j]| {
        let [a, b, c, d] = [i, i + 1, j, j + 1].map(|k| points[k]);
        side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b)
    });
    crosses.next()
}

#[test]
fn of_a_rope_that_one_view_cuts_off_the_rest_is_bridged_and_says_so() {
    let mut within = [0, 0];
    for (seed, mut scene) in scenes().filter(|(seed, _)| seed % 4 == 1) {
        let [_, second] = &mut scene.lines;
        second.points.truncate(80);
        second.widths.truncate(80);
        let mut finder = scene.finder();
        finder.add_first(&seen(&scene.lines[0], &[false; 120]));
        finder.add_second(&seen(&scene.lines[1], &[false; 80]));
        finder.pair();
        let places = finder.locate(0).map(<[_]>::to_vec);
        let places = places.unwrap_or_else(|cause| panic!("{seed}: {cause}"));
        let errors = scene.errors(&places);
        assert!(errors[..60].iter().all(|&e| e < 6.0), "{seed}: {errors:?}");
        assert!(places[100..].iter().all(|place| !place.is_measured));
        let sigma = |i: usize| places[i].variance.sqrt();
        assert!(sigma(119) > sigma(95) && sigma(95) > sigma(60));
        for (place, ahead) in places.iter().zip(&scene.lines[0].ahead).skip(85) {
            within[0] += usize::from((place.point[2] - ahead).abs() < 1.96 * place.variance.sqrt());
            within[1] += 1;
        }
    }
    println!("{within:?}");
    assert!(10 * within[0] >= 9 * within[1]);
}

#[test]
fn a_ring_is_found_wherever_its_first_point_is() {
    let eye = Eye::above(FOCAL_PX, SIZE, 500.0, 15.0, 0.0);
    let eyes = [eye, eye.verging(ASIDE, 500.0)];
    let ring = |turn: f64| -> Vec<[f64; 3]> {
        (0..120)
            .map(|k| {
                let angle = std::f64::consts::TAU * (f64::from(k) / 120.0 + turn);
                let (sin, cos) = angle.sin_cos();
                eyes[0].see([100.0 * cos, 100.0 * sin, 40.0 + 30.0 * sin])
            })
            .collect()
    };
    let to_second = |point: [f64; 3]| {
        let (turn, shift) = eyes[0].pose_in(&eyes[1]);
        [0, 1, 2].map(|k| (0..3).map(|j| turn[k][j] * point[j]).sum::<f64>() + shift[k])
    };
    let first = ring(0.0);
    let mut there: Vec<[f64; 3]> = ring(0.37).into_iter().map(to_second).collect();
    there.reverse();
    let seen = |eye: &Eye, points: &[[f64; 3]]| -> Vec<[f32; 2]> {
        let pixels = points.iter().map(|&p| eye.pixel(p));
        pixels.map(|p| p.map(|c| c as f32)).collect()
    };
    let [one, other] = [seen(&eyes[0], &first), seen(&eyes[1], &there)];
    let rope = |points| SeenRope {
        points,
        widths_px: &[10.0; 120],
        hidden: &[false; 120],
        closed: true,
        ends: [false; 2],
    };
    let mut finder = RopeViews::new(pair(eyes));
    finder.add_first(&rope(&one));
    finder.add_second(&rope(&other));
    let partner = Partner {
        rope: 0,
        is_backward: true,
    };
    assert_eq!(finder.pair(), [Ok(partner)]);
    let places = finder.locate(0).expect("a ring in space");
    for (place, truth) in places.iter().zip(first) {
        let off = place.point[2] - truth[2];
        assert!(off.abs() < 0.5 || !place.is_measured, "{off} mm");
        assert!(off.abs() < 5.0, "{off} mm");
    }
}

#[test]
fn a_rope_along_the_line_between_the_cameras_is_refused_with_the_reason() {
    let first = Eye::above(FOCAL_PX, SIZE, 500.0, 0.0, 0.0);
    let eyes = [first, first.beside(ASIDE, FOCAL_PX, SIZE)];
    for (rise, along) in [(0.0, false), (0.05, true)] {
        let points: Vec<[f64; 3]> = (-100..=150)
            .map(|k| [f64::from(k), rise * f64::from(k), 4.0])
            .collect();
        let scene = Scene::of(LiftedRope::along(&points, 4.0), eyes);
        let told = scene.locate(&mut scene.finder());
        match along {
            true => assert!(matches!(told, Err(NoSecondView::Along { .. })), "{told:?}"),
            false => assert_eq!(told, Err(NoSecondView::Alone)),
        }
    }
}

#[test]
fn a_rope_that_the_second_camera_does_not_see_has_no_place() {
    let scenes: Vec<Scene> = scenes().take(5).map(|(_, scene)| scene).collect();
    let mut finder = scenes[1].finder();
    finder.add_first(&seen(&scenes[1].lines[0], &[false; 120]));
    assert_eq!(finder.pair(), [Err(NoSecondView::Alone)]);
    assert_eq!(finder.locate(0), Err(NoSecondView::Alone));
    assert_eq!(finder.locate(1), Err(NoSecondView::Points));
    // A rope that is too short is rejected too.
    let line = &scenes[1].lines[0];
    finder.clear();
    finder.add_first(&SeenRope {
        points: &line.points[..4],
        widths_px: &line.widths[..4],
        hidden: &[false; 4],
        closed: false,
        ends: [false; 2],
    });
    finder.add_second(&seen(&scenes[1].lines[1], &[false; 120]));
    assert_eq!(finder.pair(), [Err(NoSecondView::Alone)]);
    assert_eq!(finder.locate(0), Err(NoSecondView::Points));
}

/// As many ropes as a message can contain, which go back and forth across the other view's epipolar
/// lines and all cross each other.
fn tangle(eyes: [Eye; 2]) -> [Vec<Line>; 2] {
    let ropes = (0..24).map(|rope| {
        let points: Vec<[f64; 3]> = (0..=600)
            .map(|k| {
                let along = f64::from(k) / 600.0;
                let swing =
                    libm::sin(std::f64::consts::TAU * (9.0 * along + f64::from(rope) / 24.0));
                [300.0 * along - 150.0, 60.0 * swing, 4.0 + f64::from(rope)]
            })
            .collect();
        LiftedRope::along(&points, 4.0)
    });
    let ropes: Vec<LiftedRope> = ropes.collect();
    eyes.map(|eye| ropes.iter().map(|rope| Line::of(rope, &eye)).collect())
}

#[test]
fn ropes_too_tangled_to_be_told_apart_have_no_place_and_say_why() {
    let (_, scene) = scenes().next().expect("a scene");
    let mut finder = scene.finder();
    let tangle = tangle(scene.eyes);
    let mut told = |ropes: usize| {
        finder.clear();
        for rope in &tangle[0][..ropes] {
            finder.add_first(&seen(rope, &[false; 120]));
        }
        for rope in &tangle[1][..ropes] {
            finder.add_second(&seen(rope, &[false; 120]));
        }
        finder.pair();
        (0..ropes)
            .map(|i| finder.locate(i).map(<[_]>::len))
            .collect::<Vec<_>>()
    };
    assert_eq!(told(1), [Ok(120)]);
    let of_all = told(24);
    assert!(of_all.contains(&Err(NoSecondView::Tangled)), "{of_all:?}");
}

#[test]
fn nothing_is_allocated_once_warm() {
    let (_, scene) = scenes().nth(4).expect("a scene");
    let mut finder = scene.finder();
    let mut again = || {
        finder.clear();
        finder.add_first(&seen(&scene.lines[0], &[false; 120]));
        finder.add_second(&seen(&scene.lines[1], &[false; 120]));
        finder.pair();
        finder.locate(0).expect("a rope in space").len()
    };
    again();
    let before = lariat_test_support::allocations();
    again();
    assert_eq!(lariat_test_support::allocations(), before);
}

#[test]
fn numbers_that_make_no_pair_are_refused() {
    let (_, scene) = scenes().next().expect("a scene");
    let [first, second] = scene.eyes.each_ref().map(camera);
    let range = [200.0, 1500.0];
    let told = ViewPair::new(first, second, Pose::SAME, range);
    assert_eq!(told, Err(ViewPairError::Baseline(0.0)));
    let aside = Pose::new([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], ASIDE);
    let told = ViewPair::new(first, second, aside.expect("a pose"), [1.0, 1.0]);
    assert_eq!(told, Err(ViewPairError::Range([1.0, 1.0])));
}
