//! Compares the self-organizing map, mixture and fuzzy c-means with MiniSom, scikit-learn and
//! scikit-fuzzy, from the same start. The script that made the fixture is `tests/clusterings.py`.

use serde_json::Value;

use super::fuzzy::MOST_ROUNDS;
use super::som::Training;
use super::{FuzzyMeans, Mixture, Pixels, Run, Som, Start};

/// A start, and the references' results from it.
struct Case {
    pixels: Pixels,
    centers: Vec<[f32; 2]>,
    expected: Value,
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("the fixture has a number here")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("the fixture has a list here")
}

fn points(value: &Value) -> Vec<[f32; 2]> {
    let point = |point| [0, 1].map(|axis| number(&list(point)[axis]) as f32);
    list(value).iter().map(point).collect()
}

fn cases() -> Vec<Case> {
    let fixture = include_str!("../tests/clusterings.json");
    let fixture: Value = serde_json::from_str(fixture).expect("the fixture is JSON");
    let mut pixels = Pixels::default();
    for run in list(&fixture["runs"]) {
        let [y, from, to] = [0, 1, 2].map(|i| number(&list(run)[i]) as u16);
        pixels.push(Run { y, from, to });
    }
    let case = |expected: &Value| Case {
        pixels: pixels.clone(),
        centers: points(&expected["centers"]),
        expected: expected.clone(),
    };
    list(&fixture["cases"]).iter().map(case).collect()
}

#[track_caller]
fn assert_near(found: f64, expected: f64, relative: f64, count: usize) {
    let off = (found / expected - 1.0).abs();
    assert!(off < relative, "{count} centers: {found}, not {expected}");
}

#[test]
fn the_map_is_as_near_to_the_pixels_as_minisoms() {
    for mut case in cases() {
        let expected = &case.expected["som"];
        let seed = expected["seed"].as_u64().expect("a seed");
        let mut som = Som::default();
        let outcome = som.train(&case.pixels, Training::COLD, seed, &mut case.centers);
        let count = case.centers.len();
        assert_eq!(outcome.rounds, 10_000);
        // If two nodes are nearly equidistant, rounding occasionally makes the other one win.
        let expected = number(&expected["quantization_error"]);
        assert_near(outcome.objective, expected, 0.02, count);
    }
}

#[test]
fn the_mixture_is_as_likely_as_scikit_learns() {
    for mut case in cases() {
        let expected = &case.expected["mixture"];
        let outcome = Mixture::default().run(&case.pixels, Start::Given, &mut case.centers);
        let count = case.centers.len();
        assert_eq!(u64::from(outcome.rounds), expected["rounds"], "{count}");
        let expected = number(&expected["lower_bound"]);
        assert_near(outcome.objective, expected, 1e-6, count);
    }
}

#[test]
fn fuzzy_means_are_where_scikit_fuzzys_are() {
    for mut case in cases() {
        let expected = &case.expected["fuzzy"];
        let mut fuzzy = FuzzyMeans::default();
        let outcome = fuzzy.move_centers(&case.pixels, MOST_ROUNDS, &mut case.centers);
        let count = case.centers.len();
        assert_eq!(u64::from(outcome.rounds), expected["rounds"], "{count}");
        let objective = number(&expected["objective"]);
        assert_near(outcome.objective, objective, 1e-4, count);
        let expected = points(&expected["centers"]);
        for (center, expected) in case.centers.iter().zip(&expected) {
            // Along the rope, 120 centers are nearly free to move, so rounding errors add up over
            // 300 rounds.
            let off = (center[0] - expected[0]).hypot(center[1] - expected[1]);
            assert!(off < 0.1, "{count} centers: {center:?}, not {expected:?}");
        }
    }
}
