//! Exports of the golden recording.

use super::{GOLDEN, Place};
use serde_json::Value;

#[test]
fn control_points_are_a_table() {
    let place = Place::new();
    place.printed(&["export", GOLDEN, "--format", "csv", "--out", "rope.csv"]);
    let text = std::fs::read_to_string(place.path("rope.csv")).unwrap();
    let mut rows = text.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap();
    assert_eq!(
        (head[0], head[3], *head.last().unwrap()),
        ("sequence", "track", "y8")
    );
    let rows: Vec<_> = rows.collect();
    assert_eq!(rows.len(), 43);
    assert!(rows.iter().all(|row| row.len() == head.len()));
    assert_eq!((rows[6][0], rows[6][4], rows[6][6]), ("7", "ok", "bezier"));
    let x: f64 = rows[6][15].parse().unwrap();
    assert!((0.0..144.0).contains(&x));
}

#[test]
fn descriptors_are_lines_of_json_to_the_last_digit() {
    let place = Place::new();
    let part = ["--from", "3", "--to", "9", "--every", "3"];
    let export = ["export", GOLDEN, "--format", "jsonl", "--out", "rope.jsonl"];
    place.printed(&[&export[..], &part].concat());
    place.printed(&["export", GOLDEN, "--format", "csv", "--out", "rope.csv"]);
    let csv = std::fs::read_to_string(place.path("rope.csv")).unwrap();
    let text = std::fs::read_to_string(place.path("rope.jsonl")).unwrap();
    let lines: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let sequences: Vec<_> = lines
        .iter()
        .map(|line| line["trace"]["sequence"].as_u64())
        .collect();
    assert_eq!(sequences, [Some(3), Some(6), Some(9)]);
    let curve = &lines[0]["curves"][0];
    assert_eq!(
        (&curve["status"], &curve["unit"]),
        (&"ok".into(), &"px".into())
    );
    assert_eq!(curve["velocities"].as_array().unwrap().len(), 9);
    let mut rows = csv.lines();
    let mut columns = rows.next().unwrap().split(',');
    let first = columns.position(|name| name == "filtered").unwrap() + 1;
    let row: Vec<&str> = rows.nth(2).unwrap().split(',').collect();
    let in_csv: f64 = row[first].parse().unwrap();
    let in_json = curve["control_points"][0][0].as_f64().unwrap();
    assert_eq!(in_csv.to_bits(), in_json.to_bits());
}

#[test]
fn a_video_and_pictures_show_the_frames_again() {
    let place = Place::new();
    let to = ["--to", "4"];
    place.printed(
        &[
            &["export", GOLDEN, "--format", "png", "--out", "frames"][..],
            &to,
        ]
        .concat(),
    );
    let output = place.run(
        &[
            &["export", GOLDEN, "--format", "y4m", "--out", "rope.y4m"][..],
            &to,
        ]
        .concat(),
    );
    assert!(output.status.success());
    let note = String::from_utf8(output.stderr).unwrap();
    assert!(note.contains("colors are rounded"), "{note}");
    let mut names: Vec<_> = std::fs::read_dir(place.path("frames")).unwrap().collect();
    assert_eq!(names.len(), 4);
    let picture = image::open(place.path("frames/frame-00000003.png"))
        .unwrap()
        .into_rgb8();
    assert_eq!(picture.dimensions(), (144, 108));
    assert!(names.pop().is_some());

    // Both can be used as sources again.
    for source in ["rope.y4m", "frames"] {
        let out = format!("of-{source}");
        let run = [
            "run",
            "--source",
            source,
            "--fps",
            "max",
            "--lossless",
            "--out",
            &out,
        ];
        place.printed(&run);
        let summary = std::fs::read_to_string(place.path(&out).join("summary.json")).unwrap();
        let summary: Value = serde_json::from_str(&summary).unwrap();
        assert_eq!(summary["frames"]["with_curve"], 4, "{source}");
    }
    let complaint = place.complaint(&["export", GOLDEN, "--format", "png", "--out", "frames"]);
    assert!(complaint.contains("frames is there already"), "{complaint}");
}

#[test]
fn what_fails_leaves_no_file() {
    let place = Place::new();
    for format in ["csv", "y4m", "png", "jsonl"] {
        let none = ["--from", "44", "--format", format, "--out", "out"];
        let complaint = place.complaint(&[&["export", GOLDEN][..], &none].concat());
        assert!(
            complaint.contains("there is no frame 44: the recording holds 43"),
            "{complaint}"
        );
        assert_eq!(std::fs::read_dir(place.folder.path()).unwrap().count(), 0);
    }
}
