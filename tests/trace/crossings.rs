//! Crossings, and the sequence of a rope's own crossings.

use tempfile::TempDir;

use super::{keys, lines, points, rope_picture, save, trace};

/// A flat loop: the rope comes from the left, turns back over itself and continues to the right.
fn looped(t: f64) -> [f64; 2] {
    let a = std::f64::consts::TAU * (1.4 * t - 0.2);
    [
        160.0 + 18.0 * (a - std::f64::consts::PI) + 60.0 * a.sin(),
        120.0 + 60.0 * a.cos(),
    ]
}

#[test]
fn a_crossing_has_its_two_strands_and_a_loop_pulls_straight() {
    let folder = TempDir::new().unwrap();
    save(&folder, "loop.png", &rope_picture(320, 240, looped));
    let output = trace(&folder, &["loop.png", "--json"]).output().unwrap();
    let report = &lines(&output.stdout)[0];
    let curve = &report["curves"][0];
    assert_eq!(curve["widths_px"].as_array().unwrap().len(), 120);
    assert_eq!(curve["border"], serde_json::json!([false, false]));
    let [crossing] = &report["crossings"].as_array().unwrap()[..] else {
        panic!("one crossing: {report}")
    };
    assert_eq!(keys(crossing).join(" "), "at confidence over under");
    let mut rhos = Vec::new();
    for strand in ["over", "under"] {
        assert_eq!(crossing[strand]["track"], curve["track"]);
        rhos.push(crossing[strand]["rho"].as_f64().unwrap());
        // The curve passes there, within the distance of two of its points.
        let at = &points(&curve["points"])[(rhos[rhos.len() - 1] * 119.0).round() as usize];
        let crossing: [f64; 2] = serde_json::from_value(crossing["at"].clone()).unwrap();
        let apart = (at[0] - crossing[0]).hypot(at[1] - crossing[1]);
        assert!(apart < 4.0, "{apart}");
    }
    assert!((rhos[0] - rhos[1]).abs() > 0.2, "{rhos:?}");
    let sequence = curve["crossing_sequence"].as_str().unwrap();
    assert!(["O1 U1", "U1 O1"].contains(&sequence), "{sequence}");
    assert_eq!(curve["pulls_straight"], true, "whichever strand is on top");

    let table = trace(&folder, &["loop.png"]).output().unwrap();
    let table = String::from_utf8(table.stdout).unwrap();
    assert!(
        table.contains(&format!("{sequence}: pulls straight")),
        "{table}"
    );
}
