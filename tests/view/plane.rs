//! The table's plane: clicked points become the chain's plane, and curves in millimeters are drawn
//! where the rope is.

use std::time::Instant;

use lariat_chain::settings::Settings;
use serde_json::{Value, json};

use crate::page::{PATIENCE, Page, assert_curves_lie_on_the_rope, end, shown};
use crate::rig::Bench;
use crate::viewing::Viewing;

/// Pixels of the rendered rope's pictures, and their positions on a table seen at an angle, in mm.
const POINTS: [[f64; 4]; 5] = [
    [160.0, 80.0, 0.0, 0.0],
    [480.0, 80.0, 200.0, 0.0],
    [600.0, 440.0, 200.0, 100.0],
    [40.0, 440.0, 0.0, 100.0],
    // Intersection of the diagonals.
    [320.0, 210.909, 100.0, 50.0],
];
const SIZE: [u32; 2] = [640, 480];

fn points(of: &[[f64; 4]]) -> Value {
    let point = |&[x, y, u, v]: &[f64; 4]| json!({"pixel": [x, y], "mm": [u, v]});
    of.iter().map(point).collect()
}

fn wish(name: &str, of: &[[f64; 4]]) -> Value {
    json!({"wish": name, "points": points(of), "size": SIZE})
}

/// Makes a plane's file from four of the points with the command.
pub(crate) fn make_plane(bench: &Bench, file: &str, more: &[&str]) {
    let four = POINTS[..4]
        .iter()
        .map(|[x, y, u, v]| format!("{x},{y}={u},{v}"));
    let four = four.collect::<Vec<_>>().join(" ");
    let command = [
        "calibrate",
        "plane",
        "--size",
        "640x480",
        "--points",
        &four,
        "--out",
        file,
    ];
    let made = bench.run(&[&command, more].concat());
    assert!(made.status.success(), "{made:?}");
}

/// Returns the next moment with lengths in this unit.
fn moment_in(page: &mut Page, unit: &str) -> (Value, Vec<u8>) {
    let deadline = Instant::now() + PATIENCE;
    loop {
        assert!(Instant::now() < deadline, "no curve in {unit} is drawn");
        page.ask();
        let (said, jpeg) = page.moment();
        if said["unit"] == unit && said["ropes"][0]["curve"][0].is_array() {
            return (said, jpeg);
        }
    }
}

fn length(said: &Value) -> f64 {
    said["ropes"][0]["length"].as_f64().expect("a number")
}

#[test]
fn points_that_were_clicked_become_the_chains_plane_and_can_be_kept() {
    let bench = Bench::new();
    std::fs::write(bench.path("lariat.toml"), "# mine\n").expect("written");
    let (chain, viewing, mut page) = shown(&bench, &[]);
    let judged = page.wish(wish("plane", &POINTS)).expect("a plane");
    for off in judged["off"].as_array().expect("residuals") {
        assert!(off[0].as_f64().expect("mm") < 0.01, "{judged}");
    }
    assert!(judged["most_mm"].as_f64().expect("mm") < 0.01);
    let lines = judged["grid"]["lines"].as_array().expect("lines");
    // The corner (0, 0) appears where it was clicked: two lines pass through it.
    let through = |line: &&Value| {
        let points = line.as_array().expect("points").windows(2);
        let far =
            |point: &Value| [0, 1].map(|axis| point[axis].as_f64().expect("px") - POINTS[0][axis]);
        // Uses the distance from the corner to each segment of the line.
        points.into_iter().any(|ends| {
            let ([ax, ay], [bx, by]) = (far(&ends[0]), far(&ends[1]));
            let (dx, dy) = (bx - ax, by - ay);
            let along = -(ax * dx + ay * dy) / (dx * dx + dy * dy);
            let along = along.clamp(0.0, 1.0);
            (ax + along * dx).hypot(ay + along * dy) < 0.5
        })
    };
    assert_eq!(lines.iter().filter(through).count(), 2, "{judged}");

    let written = page.wish(wish("write_plane", &POINTS)).expect("written");
    let plane = bench.path("plane.toml");
    let plane = plane.canonicalize().expect("the file");
    let change = format!("camera.plane={:?}", plane.to_str().expect("text"));
    assert_eq!(written["change"], change.as_str());
    let (in_mm, _) = moment_in(&mut page, "mm");
    page.wish(json!({"wish": "keep", "changes": [change]}))
        .expect("kept");
    let kept = Settings::of_file(&bench.path("lariat.toml")).expect("settings");
    assert_eq!(kept.camera.plane.as_deref(), Some(plane.as_path()));

    // Twice as large: the same file, which the chain reads again.
    let twice = POINTS.map(|[x, y, u, v]| [x, y, 2.0 * u, 2.0 * v]);
    let again = page.wish(wish("write_plane", &twice)).expect("written");
    assert_eq!(again["change"], change.as_str());
    let deadline = Instant::now() + PATIENCE;
    while length(&moment_in(&mut page, "mm").0) < 1.5 * length(&in_mm) {
        assert!(Instant::now() < deadline, "the plane is the one of before");
    }
    end(chain, viewing);
}

#[test]
fn what_is_no_plane_is_refused_and_nothing_is_written() {
    let bench = Bench::new();
    std::fs::write(bench.path("plane.toml"), "# another's\n").expect("written");
    let (chain, viewing, mut page) = shown(&bench, &[]);
    let in_line = [0.0, 10.0, 20.0, 30.0].map(|at| [at, at, at, at]);
    let many = [[1.0; 4]; 65];
    let huge = POINTS.map(|[x, y, u, v]| [x, y, u, 1e300 * v]);
    for (points, why) in [
        (&POINTS[..3], "3 points do not determine"),
        (&in_line[..], "lie in one line"),
        (&many[..], "at most 64 points"),
        (&huge[..], "finite numbers"),
    ] {
        for name in ["plane", "write_plane"] {
            let refused = page.wish(wish(name, points)).expect_err("refused");
            assert!(refused.contains(why), "{name}: {refused}");
        }
    }
    let mut other = wish("write_plane", &POINTS);
    other["size"] = json!([641, 480]);
    let refused = page.wish(other).expect_err("refused");
    assert!(refused.contains("another size"), "{refused}");
    // A client that does not prove to be lariat's own page may read but not write.
    let mut foreign = Page::of(&viewing);
    foreign.ask();
    foreign.moment();
    foreign.wish(wish("plane", &POINTS)).expect("judged");
    let refused = foreign
        .wish(wish("write_plane", &POINTS))
        .expect_err("refused");
    assert!(refused.contains("may not change"), "{refused}");
    // The page must not overwrite a file of this name that the chain does not use.
    let refused = page
        .wish(wish("write_plane", &POINTS))
        .expect_err("refused");
    assert!(refused.contains("is there already"), "{refused}");
    let left = std::fs::read_to_string(bench.path("plane.toml")).expect("the file");
    assert_eq!(left, "# another's\n");
    end(chain, viewing);
}

#[test]
fn curves_in_millimetres_are_drawn_on_the_rope() {
    let bench = Bench::new();
    let yaml = "image_width: 640\nimage_height: 480\nK: [600, 0, 320, 0, 600, 240, 0, 0, 1]\nD: [-0.2, 0.05, 0, 0]\n";
    std::fs::write(bench.path("camera.yaml"), yaml).expect("written");
    make_plane(&bench, "table.toml", &["--calibration", "camera.yaml"]);
    // Paths are relative to the folder where the chain was started, not to the page's.
    let lens = ["--calibration", "camera.yaml"];
    for (flags, unit) in [
        (&["--plane", "table.toml"][..], "mm"),
        (&[][..], "ideal px"),
    ] {
        let flags = [&lens, flags].concat();
        let mut chain = bench.start(&[&["--rig", "cell", "--seed", "3"], &flags[..]].concat());
        chain.wait_for_frames();
        let mut elsewhere = Bench::new();
        elsewhere.domain.clone_from(&bench.domain);
        let viewing = Viewing::start(&elsewhere, &["--rig", "cell"]);
        let mut page = Page::of(&viewing);
        let (said, jpeg) = moment_in(&mut page, unit);
        assert_curves_lie_on_the_rope(&said, &jpeg);
        end(chain, viewing);
    }
}
