//! Guarantees of the self-organizing map, the mixture and fuzzy c-means for any input.

use lariat_clustering::{FuzzyMeans, Mixture, Outcome, Pixels, Run, Som, Start};
use proptest::prelude::*;

type Method = Box<dyn FnMut(&Pixels, Start, &mut [[f32; 2]]) -> Outcome>;

fn methods() -> [(&'static str, Method); 3] {
    let (mut som, mut mixture) = (Som::default(), Mixture::default());
    let mut fuzzy = FuzzyMeans::default();
    [
        ("som", Box::new(move |p, s, c| som.run(p, s, c))),
        ("mixture", Box::new(move |p, s, c| mixture.run(p, s, c))),
        ("fuzzy", Box::new(move |p, s, c| fuzzy.run(p, s, c))),
    ]
}

fn pixels_of(runs: impl IntoIterator<Item = (u16, u16, u16)>) -> Pixels {
    let mut pixels = Pixels::default();
    for (y, from, to) in runs {
        pixels.push(Run { y, from, to });
    }
    pixels
}

/// Half of a ring with radii of 55 to 65 px around (100 + `right`, 100).
fn arc(right: u16) -> Pixels {
    pixels_of((35..=100u16).flat_map(move |y| {
        let half = |radius: i32| {
            let square = radius * radius - (i32::from(y) - 100).pow(2);
            f64::from(square.max(0)).sqrt() as u16
        };
        let (outer, inner, middle) = (half(65), half(55), 100 + right);
        match inner {
            0 => vec![(y, middle - outer, middle + outer + 1)],
            _ => vec![
                (y, middle - outer, middle - inner),
                (y, middle + inner + 1, middle + outer + 1),
            ],
        }
    }))
}

fn distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn without_pixels_or_centers_nothing_happens() {
    for (name, mut run) in methods() {
        let mut centers = [[1.5, -2.0], [3.0, 7.0]];
        for start in [Start::Given, Start::Seeded(1)] {
            let outcome = run(&Pixels::default(), start, &mut centers);
            assert_eq!(outcome.rounds, 0, "{name}");
            assert_eq!(centers, [[1.5, -2.0], [3.0, 7.0]], "{name}");
            assert_eq!(run(&arc(0), start, &mut []).rounds, 0, "{name}");
        }
    }
}

#[test]
fn all_centers_come_to_a_single_pixel() {
    for (name, mut run) in methods() {
        for start in [Start::Given, Start::Seeded(1)] {
            let mut centers = [[90.0, 20.0], [f32::NAN, 1.0], [7.0, 3.0]];
            let outcome = run(&pixels_of([(3, 7, 8)]), start, &mut centers);
            assert_eq!(centers, [[7.0, 3.0]; 3], "{name}");
            assert!(outcome.objective.is_finite(), "{name}");
        }
    }
}

#[test]
fn two_patches_have_a_center_in_the_middle_of_each() {
    let patches = pixels_of(
        (0..9)
            .map(|y| (y, 0, 9))
            .chain((200..209).map(|y| (y, 100, 109))),
    );
    // The map is skipped, because its two nodes are neighbors and pull each other.
    for (name, mut run) in methods().into_iter().skip(1) {
        let mut centers = [[0.0; 2]; 2];
        run(&patches, Start::Seeded(5), &mut centers);
        centers.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert!(
            distance(centers[0], [4.0, 4.0]) < 0.1,
            "{name}: {centers:?}"
        );
        assert!(
            distance(centers[1], [104.0, 204.0]) < 0.1,
            "{name}: {centers:?}"
        );
    }
}

#[test]
fn the_maps_line_runs_along_the_rope() {
    let mut centers = [[0.0; 2]; 60];
    let length = |centers: &[[f32; 2]]| {
        let steps = centers.windows(2);
        steps.map(|step| distance(step[0], step[1])).sum::<f32>()
    };
    let rope = std::f32::consts::PI * 60.0;
    for seed in 0..10 {
        Som::default().run(&arc(0), Start::Seeded(seed), &mut centers);
        // An unordered line would be several thousand pixels long. A folded line may double back.
        assert!(length(&centers) < 4.0 * rope, "{} {rope}", length(&centers));
    }
}

#[test]
fn centers_lie_on_the_rope_and_follow_it() {
    for (name, mut run) in methods() {
        let mut centers = [[0.0; 2]; 30];
        let cold = run(&arc(0), Start::Seeded(2), &mut centers);
        let off = |centers: &[[f32; 2]], middle: f32| {
            let off = |c: &[f32; 2]| (distance(*c, [middle, 100.0]) - 60.0).abs();
            centers.iter().map(off).sum::<f32>() / centers.len() as f32
        };
        assert!(
            off(&centers, 100.0) < 2.0,
            "{name}: {}",
            off(&centers, 100.0)
        );
        // The rope moves by 3 px between the frames.
        let warm = run(&arc(3), Start::Given, &mut centers);
        assert!(
            off(&centers, 103.0) < 2.0,
            "{name}: {}",
            off(&centers, 103.0)
        );
        // All methods but the mixture minimize their objective.
        let worse = match name {
            "mixture" => cold.objective - warm.objective,
            _ => warm.objective - cold.objective,
        };
        assert!(
            worse < 0.01 * cold.objective.abs(),
            "{name}: {cold:?} {warm:?}"
        );
        assert!(warm.rounds < cold.rounds, "{name}: {cold:?} {warm:?}");
        assert!(centers.iter().any(|c| c[0] < 60.0) && centers.iter().any(|c| c[0] > 146.0));
    }
}

#[test]
fn the_same_start_ends_the_same_whatever_was_before() {
    let ends = |before: bool| {
        methods().map(|(_, mut run)| {
            let mut centers = [[0.0; 2]; 25];
            if before {
                run(
                    &pixels_of([(3, 0, 900)]),
                    Start::Seeded(8),
                    &mut [[0.0; 2]; 90],
                );
            }
            let outcome = run(&arc(0), Start::Seeded(9), &mut centers);
            (outcome, centers)
        })
    };
    assert_eq!(ends(false), ends(true));
}

#[test]
fn a_gaussian_that_is_nearest_to_no_pixel_stays() {
    // A row with a center above each of its pixels, and one above them all.
    let row = pixels_of([(0, 0, 1), (9, 0, 20)]);
    let mut centers: Vec<[f32; 2]> = (0..20).map(|x| [x as f32, 9.0]).collect();
    centers.extend([[0.0, 0.0], [19.0, 4.0]]);
    let outcome = Mixture::default().run(&row, Start::Given, &mut centers);
    assert!(outcome.objective.is_finite());
    assert_eq!(centers[20..], [[0.0, 0.0], [19.0, 4.0]]);
}

#[test]
fn a_pixel_on_a_center_belongs_to_that_one() {
    let pixels = pixels_of([(0, 0, 1), (0, 100, 101)]);
    let mut centers = [[0.0, 0.0], [100.0, 0.0]];
    let outcome = FuzzyMeans::default().run(&pixels, Start::Given, &mut centers);
    assert_eq!(centers, [[0.0, 0.0], [100.0, 0.0]]);
    assert_eq!(outcome.rounds, 1);
    assert!(outcome.objective < 1e-6);
}

fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -20.0..120.0f32,
        1 => prop::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e5, 65_535.0]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn centers_are_numbers_within_the_box_around_the_pixels(
        runs in prop::collection::vec((0..100u16, 0..100u16, 1..30u16), 1..12),
        centers in prop::collection::vec([coordinate(), coordinate()], 1..40),
        seed in prop::option::of(any::<u64>()),
        scale in prop::sample::select(vec![1, 500]),
    ) {
        let runs: Vec<_> = runs.iter().map(|&(y, x, n)| (scale * y, scale * x, scale * x + n)).collect();
        let pixels = pixels_of(runs.iter().copied());
        let around = |c: [f32; 2]| {
            let range = |list: &[f32]| {
                let least = list.iter().fold(f32::INFINITY, |a, b| a.min(*b));
                least..=list.iter().fold(f32::NEG_INFINITY, |a, b| a.max(*b))
            };
            range(pixels.xs()).contains(&c[0]) && range(pixels.ys()).contains(&c[1])
        };
        for (name, mut run) in methods() {
            let mut centers = centers.clone();
            let start = seed.map_or(Start::Given, Start::Seeded);
            let outcome = run(&pixels, start, &mut centers);
            prop_assert!(centers.iter().all(|c| around(*c)), "{}: {:?}", name, centers);
            prop_assert!(outcome.objective.is_finite() && outcome.rounds > 0, "{}: {:?}", name, outcome);
        }
    }
}
