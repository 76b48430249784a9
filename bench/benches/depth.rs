//! Cost of finding a rope's 120 points in a depth image.
//!
//! Run it with `cargo bench --manifest-path bench/Cargo.toml --bench depth`.
//!
//! The rope is lifted and crosses itself once, half a meter in front of a present-day depth camera.
//! Its centerline in the color image is the ground truth. Iterations cycle through eight noisy
//! images.
#![allow(missing_docs)] // criterion's macros generate undocumented functions.

use criterion::{Criterion, criterion_group, criterion_main};
use lariat_camera::{
    Camera, DepthCamera, DepthImage, DepthKind, Lens, Pose, RopeDepth, SeenRope, SpacePoint,
};
use lariat_drawn::space::{DepthSensor, Eye, LiftOptions, LiftedRope, depth};

const SIZE: [usize; 2] = [848, 480];
const POINTS: usize = 120;
const IMAGES: usize = 8;
/// Position of the depth camera relative to the color camera, mm.
const ASIDE: [f64; 3] = [-15.0, 0.0, 0.0];
const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const USUAL: LiftOptions = LiftOptions {
    length_mm: 600.0,
    radius_mm: 4.0,
    lift_mm: 80.0,
    crossings: 1,
};

fn pair(color: &Eye, beside: &Eye, noise_mm: f64) -> DepthCamera {
    let camera = |eye: &Eye| {
        let size = Some(eye.size.map(|side| side as u32));
        Camera::new(eye.focal_px, eye.center_px, Lens::IDEAL, size).expect("a camera")
    };
    let pose = Pose::new(IDENTITY, ASIDE).expect("a pose");
    let range_mm = [200.0, 1500.0];
    DepthCamera::new(camera(color), camera(beside), pose, noise_mm, range_mm).expect("a pair")
}

fn depths(criterion: &mut Criterion) {
    let color = Eye::above(610.0, SIZE, 500.0, 15.0, 0.0);
    let beside = color.beside(ASIDE, 425.0, SIZE);
    let rope = LiftedRope::new(&USUAL, &color, 1).expect("a rope that fits");
    let sensor = DepthSensor::STEREO;
    let images: Vec<Vec<u8>> = (0..IMAGES as u64)
        .map(|seed| {
            let units = depth(&rope, &beside, &sensor, seed);
            units.iter().flat_map(|unit| unit.to_le_bytes()).collect()
        })
        .collect();
    let last = rope.points.len() - 1;
    let places = (0..POINTS).map(|i| last * i / (POINTS - 1));
    let seen: Vec<[f64; 3]> = places.clone().map(|i| color.see(rope.points[i])).collect();
    let points: Vec<[f32; 2]> = (seen.iter())
        .map(|&p| color.pixel(p).map(|c| c as f32))
        .collect();
    let widths: Vec<f32> = (seen.iter())
        .map(|p| (2.0 * rope.radius_mm * color.focal_px[0] / p[2]) as f32)
        .collect();
    let covers = |i: usize| {
        let reach = 2.5 * rope.radius_mm / USUAL.length_mm;
        let rho = i as f64 / last as f64;
        (rope.crossings.iter()).any(|[_, under]| (rho - under).abs() < reach)
    };
    let hidden: Vec<bool> = places.map(covers).collect();
    let seen = SeenRope {
        points: &points,
        widths_px: &widths,
        hidden: &hidden,
        closed: false,
        ends: [true; 2],
    };
    let mut finder = RopeDepth::new(pair(&color, &beside, 1e6 * sensor.noise_per_mm));
    let kind = DepthKind::Whole {
        unit_mm: sensor.unit_mm,
    };
    let mut k = 0;
    criterion.bench_function("a rope's 120 points in a depth image", |bencher| {
        bencher.iter(|| {
            k = (k + 1) % IMAGES;
            let image = DepthImage::new(&images[k], SIZE, 2 * SIZE[0], kind).expect("an image");
            let places: &[SpacePoint] = finder.locate(&image, &seen).expect("a rope in space");
            places[POINTS / 2].point
        });
    });
}

criterion_group!(benches, depths);
criterion_main!(benches);
