//! `lariat fit` as a filter of JSON lines.

use assert_cmd::Command;
use lariat_fit::{Fitter, Options, Solver};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;
use tempfile::TempDir;

/// Runs the binary in an empty folder, so that it finds no settings file.
fn fit(folder: &TempDir, args: &[&str]) -> Command {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("lariat");
    command.current_dir(folder).arg("fit").args(args);
    command
}

fn rope(count: usize) -> Vec<[f64; 2]> {
    (0..count)
        .map(|i| {
            let t = i as f64 / (count - 1) as f64;
            [100.0 + 400.0 * t, 240.0 + 90.0 * (4.0 * t).sin()]
        })
        .collect()
}

fn line(points: &[[f64; 2]]) -> String {
    format!("{}\n", json!({ "points": points }))
}

fn answers(stdout: &[u8]) -> Vec<Value> {
    std::str::from_utf8(stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn control_points(answer: &Value) -> Vec<[f64; 2]> {
    serde_json::from_value(answer["control_points"].clone()).unwrap()
}

#[test]
fn each_line_is_answered_in_order_whatever_its_number_of_points() {
    let folder = TempDir::new().unwrap();
    let sizes = [120, 9, 256, 120, 33];
    let input: String = sizes.iter().map(|&count| line(&rope(count))).collect();
    let output = fit(&folder, &["--basis", "bezier"])
        .write_stdin(input)
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let answers = answers(&output.stdout);
    assert_eq!(answers.len(), sizes.len());
    for (answer, points) in answers.iter().zip(sizes) {
        let options = Options::default().points(points);
        let mut fitter = Fitter::new(options).unwrap();
        let expected = fitter.fit(&rope(points)).unwrap();
        // JSON contains every digit.
        assert_eq!(control_points(answer), expected.control_points);
        assert_eq!(answer["rms"], expected.rms_px);
        assert_eq!(answer["max"], expected.max_px);
        assert_eq!(answer["basis"], "bezier");
        assert_eq!(answer["degree"], 8);
        let condition = answer["condition"].as_f64().unwrap();
        assert_eq!(condition, fitter.last().condition);
    }
}

#[test]
fn a_line_that_says_how_wide_its_rope_is_hears_whether_the_curve_lies_on_it() {
    let folder = TempDir::new().unwrap();
    let winding: Vec<[f64; 2]> = (0..120)
        .map(|i| [3.0 * f64::from(i), 40.0 * (0.15 * f64::from(i)).sin()])
        .collect();
    let mut said = line(&winding).trim_end().trim_end_matches('}').to_owned();
    said.push_str(",\"width\":8}\n");
    let one = |flags: &[&str]| {
        let output = fit(&folder, flags)
            .write_stdin(said.clone())
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
        answers(&output.stdout).remove(0)
    };
    let (chosen, named) = (one(&[]), one(&["--control-points", "5"]));
    assert_eq!([&chosen["fit"], &named["fit"]], ["good", "coarse"]);
    assert!(chosen["rms_widths"].as_f64().unwrap() < 0.125);
    assert!(named["worst_widths"].as_f64().unwrap() > 0.5);
}

#[test]
fn a_named_file_is_read_with_the_control_points_and_solver_that_are_asked_for() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("ropes.jsonl");
    // Other keys, blank lines and a missing line end after the last line are accepted.
    let text = format!(
        "\n{}\n{}",
        json!({ "frame": 1, "points": rope(50) }),
        line(&rope(50)).trim_end()
    );
    std::fs::write(&path, text).unwrap();
    for solver in [Solver::Pinv, Solver::Cholesky, Solver::Qr] {
        let args = [
            "ropes.jsonl",
            "--control-points",
            "5",
            "--solver",
            &solver.to_string(),
        ];
        let output = fit(&folder, &args).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let answers = answers(&output.stdout);
        assert_eq!(answers.len(), 2);
        let options = Options::bezier(4).points(50).solver(solver);
        let mut fitter = Fitter::new(options).unwrap();
        let expected = &fitter.fit(&rope(50)).unwrap().control_points;
        assert_eq!(&control_points(&answers[0]), expected);
        assert_eq!(answers[0], answers[1]);
    }
}

#[test]
fn a_bad_line_is_named_and_the_others_are_answered() {
    let folder = TempDir::new().unwrap();
    let good = line(&rope(20));
    let bad = [
        ("{\"points\":[[1,2],[3", "column"),
        ("{\"dots\":[[1,2]]}", "points"),
        ("{\"points\":[[1,NaN]]}", "column"),
        ("{\"points\":[[1,2,3]]}", "column"),
        ("{\"points\":[]}", "0 points"),
        ("{\"points\":[[1,2]]}", "1 points"),
        (
            "{\"points\":[[1,2],[3,4],[5,6]]}",
            "choose a Bezier curve of 3 control points",
        ),
        (&line(&rope(300)), "300 points are too many"),
        (
            &line(&[[0.0, 1.0], [2e9, 1.0]].repeat(10)),
            "point 1 has the coordinate 2000000000",
        ),
        (
            &line(&[[0.0, 1.0], [2.0, 1.0], [2.0, 1.0], [9.0, 9.0]]),
            "points 1 and 2 are the same, (2, 1)",
        ),
    ];
    for (text, why) in bad {
        let input = format!("{good}{}\n{good}", text.trim_end());
        let output = fit(&folder, &["--control-points", "9"])
            .write_stdin(input)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert_eq!(answers(&output.stdout).len(), 2, "{text}");
        let complaint = String::from_utf8(output.stderr).unwrap();
        assert!(
            complaint.starts_with("lariat: standard input, line 2: "),
            "{complaint}"
        );
        assert!(complaint.contains(why), "{complaint}");
        assert_eq!(complaint.lines().count(), 1, "{complaint}");
    }
}

#[test]
fn bytes_that_are_no_text_are_a_bad_line_like_any_other() {
    let folder = TempDir::new().unwrap();
    let mut input = vec![0xff, 0xfe, b'\n'];
    input.extend(line(&rope(20)).bytes());
    let output = fit(&folder, &["-"]).write_stdin(input).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(answers(&output.stdout).len(), 1);
}

#[test]
fn an_answer_comes_before_the_next_question() {
    let folder = TempDir::new().unwrap();
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("lariat"))
        .current_dir(&folder)
        .arg("fit")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    for count in [10, 20] {
        input.write_all(line(&rope(count)).as_bytes()).unwrap();
        // Without an answer this would wait forever, because the input stays open.
        let mut answer = String::new();
        output.read_line(&mut answer).unwrap();
        assert!(answer.contains("control_points"), "{answer}");
    }
    drop(input);
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_missing_file_is_said() {
    let folder = TempDir::new().unwrap();
    let output = fit(&folder, &["none.jsonl"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let complaint = String::from_utf8(output.stderr).unwrap();
    assert!(complaint.contains("cannot open none.jsonl"), "{complaint}");
}

#[test]
fn a_line_without_an_end_is_refused_after_what_came_before_it() {
    let folder = TempDir::new().unwrap();
    let endless = fit(&folder, &["/dev/zero"]).output().unwrap();
    assert_eq!(endless.status.code(), Some(1));
    let said = String::from_utf8_lossy(&endless.stderr).into_owned();
    assert!(
        said.contains("/dev/zero, line 1: it is longer than 4 MB"),
        "{said}"
    );

    let mut input = line(&rope(120)).into_bytes();
    input.extend(vec![b' '; (4 << 20) + 1]);
    let output = fit(&folder, &[]).write_stdin(input).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(answers(&output.stdout).len(), 1);
    assert!(String::from_utf8_lossy(&output.stderr).contains("line 2: it is longer"));
}
