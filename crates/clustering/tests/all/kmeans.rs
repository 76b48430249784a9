//! Compares k-means with scikit-learn's from the same start, and checks its results on input that
//! is not a rope. The script next to the fixture, `tests/kmeans.py`, made the fixture.

use lariat_clustering::{KMeans, Pixels, Run, Start};
use proptest::prelude::*;
use serde_json::Value;

fn pixels(runs: &Value) -> Pixels {
    let mut pixels = Pixels::default();
    for run in runs.as_array().expect("the fixture holds runs") {
        let number = |i: usize| run[i].as_u64().expect("of three numbers") as u16;
        pixels.push(Run {
            y: number(0),
            from: number(1),
            to: number(2),
        });
    }
    pixels
}

fn centers(listed: &Value) -> Vec<[f32; 2]> {
    let listed = listed.as_array().expect("the fixture holds centers");
    let number = |value: &Value| value.as_f64().expect("of two numbers") as f32;
    listed
        .iter()
        .map(|c| [number(&c[0]), number(&c[1])])
        .collect()
}

/// Sum over all pixels of the squared distance from the nearest center.
fn inertia(pixels: &Pixels, centers: &[[f32; 2]]) -> f64 {
    let places = pixels.xs().iter().zip(pixels.ys());
    let squares = places.map(|(&x, &y)| {
        let square = |c: &[f32; 2]| {
            (f64::from(c[0]) - f64::from(x)).powi(2) + (f64::from(c[1]) - f64::from(y)).powi(2)
        };
        centers.iter().map(square).fold(f64::INFINITY, f64::min)
    });
    squares.sum()
}

fn fixture() -> Vec<Value> {
    serde_json::from_str(include_str!("../kmeans.json")).expect("the fixture is JSON")
}

#[test]
fn from_the_same_start_it_ends_as_scikit_learn() {
    for case in fixture() {
        let name = &case["name"];
        let pixels = pixels(&case["runs"]);
        let mut found = centers(&case["start"]);
        let outcome = KMeans::default().run(&pixels, Start::Given, &mut found);
        let expected = case["inertia"].as_f64().expect("a number");
        let ratio = outcome.objective / expected;
        assert!((0.98..1.02).contains(&ratio), "{name}: {ratio}");
        let by_pixels = inertia(&pixels, &found);
        assert!((outcome.objective / by_pixels - 1.0).abs() < 1e-5, "{name}");
        // With empty cells, the rounds depend on scikit-learn's order among the farthest pixels.
        if !name.as_str().expect("a name").contains("far off") {
            assert_eq!(
                Some(u64::from(outcome.rounds)),
                case["rounds"].as_u64(),
                "{name}"
            );
            assert!((ratio - 1.0).abs() < 1e-4, "{name}: {ratio}");
            for (found, expected) in found.iter().zip(centers(&case["centers"])) {
                let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
                assert!(off < 0.05, "{name}: {found:?} {expected:?}");
            }
        }
    }
}

#[test]
fn centers_of_the_last_frame_take_fewer_rounds() {
    let case = &fixture()[0];
    let still = pixels(&case["runs"]);
    let mut moved = Pixels::default();
    for run in still.runs() {
        moved.push(Run {
            y: run.y + 1,
            from: run.from + 2,
            to: run.to + 2,
        });
    }
    let mut kmeans = KMeans::default();
    let mut centers = vec![[0.0; 2]; 40];
    let (mut cold, mut warm) = ([0.0; 2], [0.0; 2]);
    for seed in 0..10 {
        let sums = [
            (&still, Start::Seeded(seed), &mut cold),
            (&moved, Start::Given, &mut warm),
        ];
        for (pixels, start, sums) in sums {
            let outcome = kmeans.run(pixels, start, &mut centers);
            sums[0] += f64::from(outcome.rounds);
            sums[1] += outcome.objective;
        }
    }
    assert!(1.5 * warm[0] < cold[0], "{warm:?} {cold:?}");
    assert!(warm[1] < 1.01 * cold[1], "{warm:?} {cold:?}");
}

#[test]
fn the_same_seed_gives_the_same_centers() {
    let pixels = pixels(&fixture()[1]["runs"]);
    let run = |seed, kmeans: &mut KMeans| {
        let mut centers = vec![[0.0; 2]; 40];
        kmeans.run(&pixels, Start::Seeded(seed), &mut centers);
        centers
    };
    let mut kmeans = KMeans::default();
    let first = run(1, &mut kmeans);
    assert_ne!(first, run(2, &mut kmeans));
    assert_eq!(first, run(1, &mut kmeans));
}

#[test]
fn without_pixels_there_is_no_round() {
    let mut centers = [[1.0, 2.0], [3.0, 4.0]];
    for start in [Start::Seeded(0), Start::Given] {
        let outcome = KMeans::default().run(&Pixels::default(), start, &mut centers);
        assert_eq!((outcome.rounds, outcome.objective), (0, 0.0));
        assert_eq!(centers, [[1.0, 2.0], [3.0, 4.0]]);
    }
}

#[test]
fn without_centers_there_is_no_round() {
    let pixels = pixels(&fixture()[0]["runs"]);
    let outcome = KMeans::default().run(&pixels, Start::Seeded(0), &mut []);
    assert_eq!((outcome.rounds, outcome.objective), (0, 0.0));
}

#[test]
fn one_pixel_has_a_center_on_it() {
    let mut pixels = Pixels::default();
    pixels.push(Run {
        y: 9,
        from: 5,
        to: 6,
    });
    let mut centers = [[f32::NAN; 2]; 3];
    for start in [Start::Seeded(0), Start::Given] {
        let outcome = KMeans::default().run(&pixels, start, &mut centers);
        assert_eq!(outcome.objective, 0.0);
        assert!(centers.contains(&[5.0, 9.0]));
    }
}

#[test]
fn centers_on_one_place_are_spread_over_the_pixels() {
    let pixels = pixels(&fixture()[0]["runs"]);
    let mut kmeans = KMeans::default();
    let mut spread = vec![[100.0, 60.0]; 40];
    let given = kmeans.run(&pixels, Start::Given, &mut spread);
    let seeded = kmeans.run(&pixels, Start::Seeded(0), &mut vec![[0.0; 2]; 40]);
    assert!(
        given.objective < 2.0 * seeded.objective,
        "{given:?} {seeded:?}"
    );
}

proptest! {
    #[test]
    fn any_runs_and_any_centers_end_with_finite_centers_and_a_true_objective(
        rows in proptest::collection::vec(proptest::collection::vec((1u16..60, 1u16..60), 0..3), 0..24),
        start in proptest::collection::vec(
            prop_oneof![
                3 => [0f32..200.0, 0f32..30.0],
                1 => [proptest::num::f32::ANY, proptest::num::f32::ANY],
                1 => Just([50.0, 7.0]),
            ],
            1..60,
        ),
        seed in proptest::option::of(any::<u64>()),
    ) {
        let mut pixels = Pixels::default();
        for (y, row) in rows.iter().enumerate() {
            let mut x = 0;
            for (gap, length) in row {
                let y = y as u16;
                pixels.push(Run { y, from: x + gap, to: x + gap + length });
                x += gap + length;
            }
        }
        let mut centers = start;
        let given = centers.clone();
        let start = seed.map_or(Start::Given, Start::Seeded);
        let outcome = KMeans::default().run(&pixels, start, &mut centers);
        if pixels.is_empty() {
            prop_assert!(centers.iter().flatten().zip(given.iter().flatten()).all(|(a, b)| a.to_bits() == b.to_bits()));
            return Ok(());
        }
        prop_assert!(centers.iter().flatten().all(|c| c.is_finite()));
        let expected = inertia(&pixels, &centers);
        prop_assert!((outcome.objective - expected).abs() <= 1e-4 * expected + 1e-3, "{outcome:?} {expected}");
        prop_assert!(outcome.rounds >= 1);
        if pixels.len() <= centers.len() {
            // Every pixel has a center of its own.
            prop_assert!(expected < 1e-3, "{expected}");
        }
    }
}
