//! Ropes in 3-D are the same on every machine, two cameras see them where geometry predicts, and
//! the ropes have the requested shape.

use lariat_drawn::SpaceScene;
use lariat_drawn::space::{DepthSensor, Eye, LiftOptions, LiftedRope, depth, picture};
use lariat_simulation::SpaceSimulation;

const SIZE: [usize; 2] = [424, 240];
const WANTED: LiftOptions = LiftOptions {
    length_mm: 360.0,
    radius_mm: 4.0,
    lift_mm: 60.0,
    crossings: 1,
};

fn eye() -> Eye {
    Eye::above(300.0, SIZE, 500.0, 10.0, 30.0)
}

/// FNV-1a.
fn digest(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xCBF2_9CE4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3)
    })
}

#[test]
fn pictures_are_the_same_on_every_machine() {
    let rope = LiftedRope::new(&WANTED, &eye(), 3).expect("a rope that fits");
    let rgb = picture(&rope, &eye(), 3);
    let units = depth(&rope, &eye(), &DepthSensor::STEREO, 3);
    assert_eq!(rgb.len(), 3 * SIZE[0] * SIZE[1]);
    let found = [
        digest(rgb.into_iter()),
        digest(units.into_iter().flat_map(u16::to_le_bytes)),
    ];
    assert_eq!(
        found,
        [0x48C5_BA90_EF33_2B66, 0xDF0B_FE57_CDE2_54D4],
        "{found:#018x?}"
    );
}

#[test]
fn the_rope_is_as_long_as_wanted_lies_on_the_table_and_on_itself() {
    let eye = Eye::above(610.0, [848, 480], 500.0, 15.0, 30.0);
    for seed in 3..6 {
        let rope = LiftedRope::new(&WANTED, &eye, seed).expect("a rope that fits");
        let step = |p: &[[f64; 3]]| {
            (0..3)
                .map(|k| (p[0][k] - p[1][k]).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let length: f64 = rope.points.windows(2).map(step).sum();
        // A lifted rope is longer than one on the table.
        assert!((360.0..480.0).contains(&length), "{length}");
        let height = |i: usize| rope.points[i][2];
        assert!((0..rope.points.len()).all(|i| height(i) > 3.99));
        let [[over, under]] = rope.crossings[..] else {
            panic!("{:?}", rope.crossings);
        };
        let at = |rho: f64| (rho * (rope.points.len() - 1) as f64).round() as usize;
        assert!(height(at(over)) > height(at(under)) + 7.5);
        // Both are seen at one place.
        let [a, b] = [over, under].map(|rho| eye.pixel(eye.see(rope.points[at(rho)])));
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 6.0, "{a:?} {b:?}");
    }
}

#[test]
fn a_depth_image_without_faults_has_the_ropes_surface() {
    let rope = LiftedRope::new(&WANTED, &eye(), 3).expect("a rope that fits");
    let faultless = DepthSensor {
        noise_per_mm: 0.0,
        unit_mm: 0.1,
        grain_px: 1,
        holes: 0.0,
        edge_holes: 0.0,
        baseline_mm: 0.0,
    };
    let units = depth(&rope, &eye(), &faultless, 3);
    // Points near the crossing are skipped, because the other strand may be visible there, and so
    // are the ends, which are cut off square.
    for i in (50..rope.points.len()).step_by(50) {
        let rho = i as f64 / (rope.points.len() - 1) as f64;
        if rope.crossings[0].iter().any(|at| (rho - at).abs() < 0.06) {
            continue;
        }
        let seen = eye().see(rope.points[i]);
        let at = eye().pixel(seen).map(|c| c.round() as usize);
        let measured = f64::from(units[at[1] * SIZE[0] + at[0]]) * 0.1;
        // The surface is nearer than the axis by a radius. The difference is larger on a slope and
        // smaller to the side of the axis.
        let nearer = seen[2] - measured;
        assert!((2.5..6.5).contains(&nearer), "{i}: {nearer} mm");
    }
    assert_eq!(units.iter().filter(|&&unit| unit == 0).count(), 0);
}

#[test]
fn a_rope_that_does_not_fit_is_refused() {
    let long = LiftOptions {
        length_mm: 4000.0,
        ..WANTED
    };
    assert!(LiftedRope::new(&long, &eye(), 1).is_err());
}

#[test]
fn a_simulated_rope_lifted_is_the_same_picture_on_every_machine() {
    let simulation = SpaceSimulation::new(&lariat_simulation::Options::default()).unwrap();
    let mut scene = SpaceScene::new(&simulation, 2.5);
    scene.draw(&simulation);
    let mut bytes = vec![0; 3 * 640 * 480 + 2 * 848 * 480];
    let (pixels, depths) = bytes.split_at_mut(3 * 640 * 480);
    scene.write(1, pixels);
    scene.write_depth(1, depths);
    let digest = digest(bytes.into_iter());
    assert_eq!(digest, 0x9CEB_CB7A_D139_27EE, "{digest:#x}");
}
