//! Locates ropes in depth images of a realistic sensor, and compares them with their true places.

use crate::drawn::Line;
use lariat_camera::{
    Camera, DepthCamera, DepthImage, DepthKind, Lens, NoDepth, Pose, RopeDepth, SeenRope,
    SpacePoint,
};
use lariat_drawn::space::{DepthSensor, Eye, LiftOptions, LiftedRope, depth};
use lariat_portable::Arch;

const SIZE: [usize; 2] = [848, 480];
/// From the color camera to the depth camera, mm.
const ASIDE: [f64; 3] = [-15.0, 0.5, 0.0];
const FAR_ASIDE: [f64; 3] = [-80.0, 0.0, 0.0];
const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

struct Scene {
    rope: LiftedRope,
    color: Eye,
    depth: Eye,
    points: Vec<[f32; 2]>,
    widths: Vec<f32>,
    hidden: Vec<bool>,
    /// True distance of the axis ahead of the color camera, at each point.
    ahead: Vec<f64>,
}

/// Places a rope in front of two cameras; its centerline in the color image is known.
fn scene(options: &LiftOptions, seed: u64) -> Scene {
    let color = Eye::above(610.0, SIZE, 500.0, 15.0, 40.0 * seed as f64);
    let rope = LiftedRope::new(options, &color, seed).expect("a rope that fits");
    scene_of(rope, color)
}

/// Places a rope in front of these two cameras. It is hidden where it passes under itself.
fn scene_of(rope: LiftedRope, color: Eye) -> Scene {
    let Line {
        points,
        widths,
        ahead,
        rhos,
    } = Line::of(&rope, &color);
    let step_mm = |pair: &[[f64; 3]]| {
        let between = [0, 1, 2].map(|c| pair[1][c] - pair[0][c]);
        between.iter().map(|c| c * c).sum::<f64>().sqrt()
    };
    let length_mm: f64 = rope.points.windows(2).map(step_mm).sum();
    let covers = |rho: f64| {
        let reach = 2.5 * rope.radius_mm / length_mm;
        (rope.crossings.iter()).any(|[_, under]| (rho - under).abs() < reach)
    };
    Scene {
        hidden: rhos.iter().map(|&rho| covers(rho)).collect(),
        depth: color.beside(ASIDE, 425.0, SIZE),
        rope,
        color,
        points,
        widths,
        ahead,
    }
}

fn pair(scene: &Scene) -> DepthCamera {
    pair_at(scene, ASIDE)
}

fn pair_at(scene: &Scene, aside: [f64; 3]) -> DepthCamera {
    let camera = |eye: &Eye| {
        let size = Some(eye.size.map(|side| side as u32));
        Camera::new(
            eye.focal_px,
            eye.center_px,
            Lens::brown_conrady(&[0.0; 4]).expect("no distortion"),
            size,
        )
        .expect("a camera")
    };
    let (color, depth) = (camera(&scene.color), camera(&scene.depth));
    // Both cameras look in the same direction. The depth camera's origin is at `aside` in the color
    // camera's frame.
    let pose = Pose::new(IDENTITY, aside).expect("a pose");
    DepthCamera::new(color, depth, pose, 3.6, [200.0, 1500.0]).expect("a pair")
}

fn locate(scene: &Scene, sensor: &DepthSensor, seed: u64) -> Result<Vec<SpacePoint>, NoDepth> {
    locate_by(&mut RopeDepth::new(pair(scene)), scene, sensor, seed)
}

fn locate_by(
    finder: &mut RopeDepth,
    scene: &Scene,
    sensor: &DepthSensor,
    seed: u64,
) -> Result<Vec<SpacePoint>, NoDepth> {
    let units = depth(&scene.rope, &scene.depth, sensor, seed);
    locate_in(finder, scene, &units, sensor.unit_mm)
}

fn locate_in(
    finder: &mut RopeDepth,
    scene: &Scene,
    units: &[u16],
    unit_mm: f64,
) -> Result<Vec<SpacePoint>, NoDepth> {
    let bytes: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
    let kind = DepthKind::Whole { unit_mm };
    let image = DepthImage::new(&bytes, SIZE, 2 * SIZE[0], kind).expect("an image");
    let rope = SeenRope {
        points: &scene.points,
        widths_px: &scene.widths,
        hidden: &scene.hidden,
        closed: false,
        // The points are those of the axis.
        ends: [false; 2],
    };
    finder.locate(&image, &rope).map(<[_]>::to_vec)
}

/// Distance of each point from the rope's true axis, mm.
fn errors(scene: &Scene, places: &[SpacePoint]) -> Vec<f64> {
    let truth: Vec<[f64; 3]> = scene
        .rope
        .points
        .iter()
        .map(|&p| scene.color.see(p))
        .collect();
    let far = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    places
        .iter()
        .map(|place| {
            truth
                .iter()
                .map(|&t| far(t, place.point))
                .fold(f64::MAX, f64::min)
        })
        .collect()
}

/// Ropes on the table, lifted, and lifted high, with zero to two crossings.
fn scenes(radius_mm: f64) -> impl Iterator<Item = (u64, Scene)> {
    (0..12).map(move |seed| {
        let options = LiftOptions {
            length_mm: 600.0,
            radius_mm,
            lift_mm: [0.0, 60.0, 120.0][seed as usize % 3],
            crossings: seed as usize / 3 % 3,
        };
        (seed, scene(&options, seed))
    })
}

#[test]
fn lifted_ropes_that_cross_themselves_are_found_to_a_fraction_of_a_millimetre() {
    let mut all = Vec::new();
    for (seed, scene) in scenes(4.0) {
        let places = locate(&scene, &DepthSensor::STEREO, seed).expect("a rope in space");
        let errors = errors(&scene, &places);
        for end in [errors[0], errors[119]] {
            assert!(end < 2.0, "{seed}: an end is {end} mm off");
        }
        all.extend(errors);
    }
    all.sort_by(f64::total_cmp);
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let p95 = all[all.len() * 95 / 100];
    let worst = all[all.len() - 1];
    println!("mean {mean:.3} mm, 95 % {p95:.3}, worst {worst:.3}");
    assert!(mean < 0.35 && p95 < 0.9 && worst < 5.0);
}

#[test]
fn points_are_the_same_to_the_bit_whatever_registers_the_machine_has() {
    for radius_mm in [2.0, 4.0] {
        let (seed, scene) = scenes(radius_mm).next().expect("a rope");
        let units = depth(&scene.rope, &scene.depth, &DepthSensor::STEREO, seed);
        let found = Arch::all().into_iter().map(|arch| {
            arch.keep_to();
            let mut finder = RopeDepth::new(pair(&scene));
            locate_in(&mut finder, &scene, &units, DepthSensor::STEREO.unit_mm).expect("a rope")
        });
        let found: Vec<_> = found.collect();
        assert!(found.iter().all(|places| *places == found[0]));
    }
}

#[test]
fn the_stated_variance_is_that_of_the_errors() {
    for grain_px in [1, 3] {
        let sensor = DepthSensor {
            grain_px,
            ..DepthSensor::STEREO
        };
        let (mut within, mut bridged, mut count) = (0, [0, 0], 0);
        for (seed, scene) in scenes(4.0) {
            let places = locate(&scene, &sensor, seed).expect("a rope in space");
            for (place, ahead) in places.iter().zip(&scene.ahead) {
                let is_within = (place.point[2] - ahead).abs() < 1.96 * place.variance.sqrt();
                if place.is_measured {
                    count += 1;
                    within += usize::from(is_within);
                } else {
                    bridged[0] += usize::from(is_within);
                    bridged[1] += 1;
                }
            }
        }
        let share = within as f64 / f64::from(count);
        println!("noise of {grain_px} px: {share:.3} of {count}; bridged {bridged:?}");
        assert!((0.9..0.99).contains(&share));
        assert!(10 * bridged[0] >= 9 * bridged[1]);
    }
}

#[test]
fn what_is_seen_behind_a_lifted_rope_is_not_taken_for_it() {
    // The depth camera is far to the side, and sees the table where the color camera sees the rope.
    let options = LiftOptions {
        length_mm: 400.0,
        radius_mm: 4.0,
        lift_mm: 150.0,
        crossings: 0,
    };
    for seed in 0..4 {
        let mut scene = scene(&options, seed);
        scene.depth = scene.color.beside(FAR_ASIDE, 425.0, SIZE);
        let mut finder = RopeDepth::new(pair_at(&scene, FAR_ASIDE));
        let places = locate_by(&mut finder, &scene, &DepthSensor::STEREO, seed).expect("a rope");
        let errors = errors(&scene, &places);
        let worst = errors.iter().fold(0.0, |worst: f64, &e| worst.max(e));
        println!("{seed}: worst {worst:.3} mm");
        assert!(worst < 5.0, "{seed}: {worst} mm");
    }
}

#[test]
fn what_is_seen_through_a_hole_beside_a_lifted_rope_is_not_taken_for_it() {
    let options = LiftOptions {
        length_mm: 600.0,
        radius_mm: 4.0,
        lift_mm: 160.0,
        crossings: 0,
    };
    for seed in 0..3 {
        let scene = scene(&options, seed);
        let whole = depth(&scene.rope, &scene.depth, &DepthSensor::STEREO, seed);
        // The table may be visible through one hole. The other holes hide the rope and its
        // surroundings.
        for hole in (21..100).step_by(6) {
            let mut units = whole.clone();
            for (i, reach_px) in [(hole - 6, 5.0), (hole, 1.0), (hole + 6, 5.0)] {
                dig(&mut units, place(&scene, i), reach_px);
            }
            let mut finder = RopeDepth::new(pair(&scene));
            let places = locate_in(&mut finder, &scene, &units, 1.0).expect("a rope in space");
            let worst = errors(&scene, &places).into_iter().fold(0.0, f64::max);
            assert!(worst < 10.0, "{seed}, {hole}: {worst} mm");
        }
    }
}

/// The place in the depth image that shows a point of the rope.
fn place(scene: &Scene, i: usize) -> [f64; 2] {
    let far = |p: [f64; 3]| {
        let [x, y] = scene.color.pixel(scene.color.see(p));
        let at = scene.points[i].map(f64::from);
        (x - at[0]).hypot(y - at[1])
    };
    let nearest = (scene.rope.points.iter()).min_by(|&&a, &&b| far(a).total_cmp(&far(b)));
    scene
        .depth
        .pixel(scene.depth.see(*nearest.expect("a rope has points")))
}

#[test]
fn a_depth_image_of_the_table_alone_gives_a_rope_no_place() {
    let far: Vec<_> = (0..20)
        .map(|k| [10_000.0 + f64::from(k), 0.0, 5.0])
        .collect();
    let elsewhere = LiftedRope::along(&far, 4.0);
    for grain_px in [1, 3] {
        let sensor = DepthSensor {
            grain_px,
            ..DepthSensor::STEREO
        };
        for (seed, scene) in scenes(4.0) {
            let units = depth(&elsewhere, &scene.depth, &sensor, seed);
            let mut finder = RopeDepth::new(pair(&scene));
            let place = locate_in(&mut finder, &scene, &units, sensor.unit_mm);
            assert!(
                matches!(place, Err(NoDepth::Flat | NoDepth::Unmeasured { .. })),
                "{seed}: {:?}",
                place.map(|places| places[60])
            );
        }
    }
    let (seed, scene) = scenes(4.0).next().expect("a rope");
    for nothing in [0, 500] {
        let units = vec![nothing; SIZE[0] * SIZE[1]];
        let mut finder = RopeDepth::new(pair(&scene));
        let place = locate_in(&mut finder, &scene, &units, 1.0);
        assert!(place.is_err(), "{seed}, all {nothing}");
    }
}

/// Removes the depths around a place.
fn dig(units: &mut [u16], at: [f64; 2], reach_px: f64) {
    for (i, unit) in units.iter_mut().enumerate() {
        let [x, y] = [i % SIZE[0], i / SIZE[0]].map(|c| c as f64);
        if (x - at[0]).hypot(y - at[1]) <= reach_px {
            *unit = 0;
        }
    }
}

#[test]
fn a_rope_is_measured_where_it_is_a_little_thinner_than_three_pixels() {
    // The rope is 2.6 to 3.3 depth pixels wide where it lies on the table.
    let (mut all, mut bridged) = (Vec::new(), 0);
    for (seed, scene) in scenes(1.75) {
        let places = locate(&scene, &DepthSensor::STEREO, seed).expect("a rope in space");
        let seen = places.iter().zip(&scene.hidden);
        bridged += seen
            .filter(|(place, hidden)| !place.is_measured && !**hidden)
            .count();
        all.extend(errors(&scene, &places));
    }
    all.sort_by(f64::total_cmp);
    let (p95, worst) = (all[all.len() * 95 / 100], all[all.len() - 1]);
    println!(
        "bridged {bridged} of {}, 95 % {p95:.3}, worst {worst:.3}",
        all.len()
    );
    assert!(100 * bridged < 2 * all.len() && p95 < 1.2 && worst < 6.0);
}

#[test]
fn a_rope_is_measured_where_it_is_little_more_than_two_pixels_thin() {
    // Its ends are 1.2 m away and 2.8 depth pixels wide. In between it sags away from the cameras
    // by 250 mm, to 2.3 pixels.
    let color = Eye::above(610.0, SIZE, 1650.0, 0.0, 0.0);
    let points: Vec<[f64; 3]> = (0..=200)
        .map(|k| {
            let along = f64::from(k) / 200.0;
            let turn = std::f64::consts::PI * along;
            let height = 450.0 - 250.0 * turn.sin().powi(2);
            [800.0 * along - 400.0, 150.0 * turn.sin(), height]
        })
        .collect();
    let scene = scene_of(LiftedRope::along(&points, 4.0), color);
    for seed in 0..4 {
        let places = locate(&scene, &DepthSensor::STEREO, seed).expect("a rope in space");
        let bridged = places.iter().filter(|place| !place.is_measured).count();
        let errors = errors(&scene, &places);
        let mean = errors.iter().sum::<f64>() / 120.0;
        let worst = errors.iter().fold(0.0, |worst: f64, &e| worst.max(e));
        println!("{seed}: bridged {bridged}, mean {mean:.2} mm, worst {worst:.2}");
        // The sensor's noise is 5 to 8 mm per pixel there.
        assert!(
            bridged < 30 && mean < 4.0 && worst < 20.0,
            "{seed}: {bridged} bridged, {mean} mm, {worst} at worst"
        );
    }
}

#[test]
fn both_parts_of_a_rope_are_measured_where_it_points_at_the_camera_in_between() {
    // 300 mm of the rope point straight at the camera and appear as a few pixels in the image. A
    // quarter of the rope is beyond them, at its first end.
    let color = Eye::above(610.0, SIZE, 1300.0, 0.0, 0.0);
    let mut points: Vec<[f64; 3]> = Vec::new();
    points.extend((0..=150).map(|k| [f64::from(k) - 250.0, 60.0, 150.0]));
    points.extend((1..=300).map(|k| [-100.0 + 0.02 * f64::from(k), 60.0, 150.0 + f64::from(k)]));
    points.extend((1..=350).map(|k| [-94.0 + f64::from(k), 60.0, 450.0]));
    let scene = scene_of(LiftedRope::along(&points, 4.0), color);
    for seed in 0..4 {
        let places = locate(&scene, &DepthSensor::STEREO, seed).expect("a rope in space");
        let errors = errors(&scene, &places);
        let off = errors.iter().filter(|&&off| off > 10.0).count();
        println!("{seed}: {off} points are off; {errors:.1?}");
        assert!(off <= 6, "{seed}: {off} of its points are off");
    }
}

#[test]
fn where_the_colour_image_has_an_end_too_far_out_the_table_behind_is_not_the_rope() {
    // The rope is a meter away, and the table is 400 mm behind it.
    let color = Eye::above(610.0, SIZE, 1360.0, 0.0, 0.0);
    let kinds = [0.0, 50.0, 100.0].map(|rise| [2, 3, 4, 6].map(|beyond| (rise, beyond)));
    for (rise, beyond) in kinds.into_iter().flatten() {
        // The rope rises toward its last end.
        let points: Vec<[f64; 3]> = (0..=200)
            .map(|k| {
                let along = f64::from(k) / 200.0;
                let height = 400.0 + rise * along.powi(12);
                [900.0 * along - 450.0, 0.0, height]
            })
            .collect();
        let rope = LiftedRope::along(&points, 4.0);
        let Line {
            mut points,
            widths,
            ahead,
            ..
        } = Line::of(&rope, &color);
        points.drain(..beyond);
        let [before, last] = [points[points.len() - 2], points[points.len() - 1]];
        for k in 1..=beyond {
            points.push([0, 1].map(|c| last[c] + k as f32 * (last[c] - before[c])));
        }
        let end = ahead[119];
        let scene = Scene {
            depth: color.beside(ASIDE, 425.0, SIZE),
            hidden: vec![false; 120],
            rope,
            color,
            points,
            widths,
            ahead,
        };
        let places = locate(&scene, &DepthSensor::STEREO, 3).expect("a rope in space");
        let off = places.iter().map(|place| place.point[2] - end);
        let most = off.skip(120 - beyond).fold(0.0, f64::max);
        assert!(
            most < 30.0,
            "rising by {rise}, {beyond} points too far: {most} mm behind its end"
        );
    }
}

#[test]
fn ropes_that_cannot_be_told_are_refused_with_the_reason() {
    let (_, thin) = scenes(0.8).next().expect("a scene");
    let told = locate(&thin, &DepthSensor::STEREO, 1);
    assert!(matches!(told, Err(NoDepth::Thin { .. })), "{told:?}");
    let (_, scene) = scenes(4.0).next().expect("a scene");
    let blind = DepthSensor {
        holes: 1.0,
        ..DepthSensor::STEREO
    };
    let told = locate(&scene, &blind, 1);
    let none = NoDepth::Unmeasured {
        measured: 0,
        points: 120,
    };
    assert_eq!(told, Err(none));
    let short = SeenRope {
        points: &scene.points[..4],
        widths_px: &scene.widths[..4],
        hidden: &scene.hidden[..4],
        closed: false,
        ends: [false; 2],
    };
    let image = DepthImage::new(&[0; 8], [2, 2], 4, DepthKind::Whole { unit_mm: 1.0 });
    let mut finder = RopeDepth::new(pair(&scene));
    let told = finder.locate(&image.expect("an image"), &short);
    assert_eq!(told, Err(NoDepth::Points));
}

#[test]
fn depth_images_are_read_in_both_kinds_and_never_beyond_their_bytes() {
    let metres = [0.5f32, f32::NAN, -1.0, 2.0].map(f32::to_le_bytes);
    let image = DepthImage::new(metres.as_flattened(), [2, 2], 8, DepthKind::Metres);
    let image = image.expect("an image");
    let read = [[0, 0], [1, 0], [0, 1], [1, 1], [2, 0], [0, -1]].map(|[x, y]| image.at(x, y));
    assert_eq!(read, [Some(500.0), None, None, Some(2000.0), None, None]);
    let kind = DepthKind::Whole { unit_mm: 0.1 };
    for (bytes, size, stride) in [
        (7, [2, 2], 4),
        (8, [2, 2], 3),
        (0, [0, 0], 0),
        (8, [2, usize::MAX], 4),
    ] {
        assert!(DepthImage::new(&vec![1; bytes], size, stride, kind).is_err());
    }
}
