//! The two cameras see what is in front of them.

use super::*;
use lariat_simulation::Options;

fn seen(seed: u64) -> (SpaceScene, Vec<u8>, Vec<u16>) {
    let options = Options {
        seed,
        ..Options::default()
    };
    let simulation = SpaceSimulation::new(&options).unwrap();
    let mut scene = SpaceScene::new(&simulation, 2.5);
    // The previous drawing is gone.
    scene.draw(&SpaceSimulation::new(&Options::default()).unwrap());
    scene.draw(&simulation);
    let mut pixels = vec![0; 3 * 640 * 480];
    scene.write(1, &mut pixels);
    let mut bytes = vec![0; 2 * 848 * 480];
    scene.write_depth(1, &mut bytes);
    let depths = bytes.as_chunks().0.iter().map(|&b| u16::from_ne_bytes(b));
    let depths = depths.collect();
    (scene, pixels, depths)
}

#[test]
fn rope_and_table_are_where_the_truth_says_in_colour_and_in_depth() {
    for seed in [3, 4] {
        let (scene, pixels, depths) = seen(seed);
        let mut flat = Box::new(Centerlines::EMPTY);
        let mut truth = Box::new(Descriptors3::EMPTY);
        assert!(scene.truth(100, &mut flat) && scene.truth_in_space(100, &mut truth));
        let points = truth.curves()[0].points();
        let (mut measured, mut off_mm) = (0, 0.0);
        for (&point, &at) in points
            .iter()
            .zip(flat.curves()[0].points())
            .skip(5)
            .take(90)
        {
            // Both lines have equal steps, but the steps of one are equal in the picture.
            let seen = scene.color.eye.see(point.map(f64::from));
            let [x, y] = scene.color.eye.pixel(seen);
            assert!((x - f64::from(at[0])).abs() < 8.0 && (y - f64::from(at[1])).abs() < 8.0);
            let [r, _, b] =
                [0, 1, 2].map(|c| pixels[3 * (y.round() as usize * 640 + x.round() as usize) + c]);
            assert!(b > r + 40, "{x} {y}: {r} {b}");
            let seen = scene.depth.eye.see(point.map(f64::from));
            let [x, y] = scene.depth.eye.pixel(seen).map(|c| c.round() as usize);
            let depth = f64::from(depths[y * 848 + x]);
            if depth > 0.0 {
                measured += 1;
                off_mm += depth - (seen[2] - RADIUS_MM);
            }
        }
        // A hundredth of the pixels are holes. The bounds are five deviations of the mean of 90
        // values with 2 mm of noise each. A tube is nearest in its middle.
        assert!(measured > 80, "{measured}");
        let mean_mm = off_mm / f64::from(measured);
        assert!((-1.1..2.5).contains(&mean_mm), "{mean_mm}");
        // A corner shows the table.
        let far = f64::from(scene.depth.table[20 * 848 + 700]);
        let around = (0..40)
            .map(|i| f64::from(depths[20 * 848 + 700 + i]))
            .filter(|d| *d > 0.0);
        let (sum, count) = around.fold((0.0, 0.0), |(sum, count), d| (sum + d, count + 1.0));
        assert!((sum / count - far).abs() < 4.0, "{} {far}", sum / count);
    }
}

/// The second imager is to the right, so the rope hides from it what is to the left of the rope.
#[test]
fn what_the_rope_hides_from_the_second_imager_has_no_depth() {
    let (scene, _, depths) = seen(3);
    let [mut left, mut right] = [0, 0];
    for &point in &scene.line[scene.line.len() / 8..scene.line.len() / 3] {
        let at = scene.depth.eye.pixel(scene.depth.eye.see(point));
        let [x, y] = at.map(|c| c.round() as usize);
        let holes = |from: usize| {
            (from..from + 4)
                .filter(|x| depths[y * 848 + x] == 0)
                .count()
        };
        (left, right) = (left + holes(x - 10), right + holes(x + 7));
    }
    assert!(left > 3 * right + 20, "{left} {right}");
}
