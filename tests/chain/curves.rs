//! The requested curve, on the rendered rope.

use crate::rig::Bench;

#[test]
fn every_basis_and_option_describes_the_rope() {
    const FRAMES: u64 = 40;
    let requests: [(&[&str], f64); 12] = [
        (&[], 0.5),
        (&["--filter"], 0.5),
        (&["--control-points", "9"], 1.0),
        (&["--control-points", "auto"], 1.0),
        (
            &["--control-points", "13", "--solver", "qr", "--pin-ends"],
            0.5,
        ),
        (&["--control-points", "13", "--robust"], 0.5),
        (&["--control-points", "13", "--rho", "measured"], 0.5),
        (&["--control-points", "13", "--filter"], 0.5),
        (
            &[
                "--basis",
                "bspline",
                "--control-points",
                "13",
                "--knots",
                "averaged",
            ],
            0.5,
        ),
        (&["--basis", "rational"], 0.5),
        (&["--basis", "points"], 5.0),
        (&["--basis", "mass"], 100.0),
    ];
    for (flags, most_px) in requests {
        let bench = Bench::new();
        let frames = FRAMES.to_string();
        let mut arguments = vec![
            "--lossless",
            "--fps",
            "max",
            "--frames",
            &frames,
            "--out",
            "out",
        ];
        arguments.extend(flags);
        let ended = bench.start(&arguments).end();
        assert!(ended.status.success(), "{flags:?}: {}", ended.stderr);
        let summary = bench.summary("out");
        assert_eq!(summary["frames"]["with_curve"], FRAMES, "{flags:?}");
        let mean_px = summary["error_px"]["curve"]["mean"].as_f64().unwrap();
        assert!(mean_px < most_px, "{flags:?}: {mean_px} px");
        bench.assert_nothing_is_left();
    }
}

/// A regression: the first command that a user types warned that its curve did not fit, and changed
/// the length of its vector.
#[test]
fn the_drawn_rope_keeps_its_vector_and_warns_of_nothing() {
    let bench = Bench::new();
    let ended = bench
        .start(&[
            "--lossless",
            // The frame rate of the demo; with "max", the machine decides how much time passes
            // between two frames.
            "--fps",
            "30",
            "--frames",
            "900",
            "--record",
            "run.mcap",
            "--images",
            "none",
        ])
        .end();
    assert!(ended.status.success(), "{}", ended.stderr);
    assert!(!ended.stderr.contains("WARN"), "{}", ended.stderr);
    let table = bench.run(&["export", "--format", "csv", "--out", "-", "run.mcap"]);
    let table = String::from_utf8(table.stdout).expect("text");
    let mut rows = table
        .lines()
        .map(|line| line.split(',').collect::<Vec<_>>());
    let heads = rows.next().expect("a head");
    let column = |name: &str| heads.iter().position(|head| *head == name);
    let [basis, fit, last] = ["basis", "fit", "y19"].map(|name| column(name).expect(name));
    assert_eq!(column("x20"), None);
    let mut count = 0;
    for row in rows {
        assert_eq!((row[basis], row[fit]), ("bspline", "good"), "{row:?}");
        assert!(!row[last].is_empty(), "{row:?}");
        count += 1;
    }
    assert_eq!(count, 900);
}

#[test]
fn a_curve_that_cannot_be_is_refused_before_anything_starts() {
    let bench = Bench::new();
    for (flags, why) in [
        (
            &["--control-points", "32", "--points", "32"][..],
            "choose a Bezier curve of 28 control points",
        ),
        (
            &["--basis", "auto", "--control-points", "9"],
            "\"auto\" chooses the control points itself",
        ),
        (&["--filter", "--basis", "rational"], "their weights change"),
        (
            &["--basis", "mass", "--robust"],
            "cannot be fitted with weights",
        ),
        (&["--basis", "splines"], "Did you mean \"bspline\"?"),
    ] {
        let output = bench.run(&[&["run"], flags].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(
            !output.status.success() && said.contains(why),
            "{flags:?}: {said}"
        );
        assert_eq!(said.trim().lines().count(), 1, "{said}");
    }
    bench.assert_nothing_is_left();
}
