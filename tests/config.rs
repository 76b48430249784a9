//! `lariat config`, and the parsing of settings.

use assert_cmd::Command;
use tempfile::TempDir;

fn lariat(folder: &TempDir, args: &[&str]) -> Command {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("lariat");
    command.current_dir(folder).args(args);
    command
}

/// Returns a command's output or its error message; the other one is empty.
fn outcome(folder: &TempDir, args: &[&str]) -> Result<String, String> {
    let output = lariat(folder, args).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let complaint = String::from_utf8(output.stderr).unwrap();
    if output.status.success() {
        assert_eq!(complaint, "");
        Ok(printed)
    } else {
        assert_eq!(printed, "");
        Err(complaint)
    }
}

fn write(folder: &TempDir, text: &str) {
    std::fs::write(folder.path().join("lariat.toml"), text).unwrap();
}

/// Returns the error message of `config check` for this text.
fn complaint(text: &str) -> String {
    let folder = TempDir::new().unwrap();
    write(&folder, text);
    outcome(&folder, &["config", "check"]).expect_err(text)
}

/// Parses settings without the remarks about their origin.
fn values(shown: &str) -> toml::Table {
    shown.parse().unwrap()
}

#[test]
fn a_new_file_holds_the_defaults() {
    let folder = TempDir::new().unwrap();
    let defaults = outcome(&folder, &["config", "show"]).unwrap();
    assert!(
        defaults.contains("basis = \"auto\"  # default"),
        "{defaults}"
    );

    outcome(&folder, &["config", "init"]).unwrap();
    assert_eq!(
        outcome(&folder, &["config", "check"]).unwrap(),
        "lariat.toml is good\n"
    );
    let written = std::fs::read_to_string(folder.path().join("lariat.toml")).unwrap();
    assert_eq!(values(&written), values(&defaults));
    let shown = outcome(&folder, &["config", "show"]).unwrap();
    assert_eq!(values(&shown), values(&defaults));
    assert!(
        !shown.contains("default\n"),
        "every one comes from the file: {shown}"
    );
}

#[test]
fn the_examples_in_a_new_file_are_good() {
    let folder = TempDir::new().unwrap();
    outcome(&folder, &["config", "init"]).unwrap();
    let path = folder.path().join("lariat.toml");
    // Settings that need missing files, and control points, which the basis "auto" does not allow.
    let others = [
        "topic",
        "calibration",
        "plane",
        "unit",
        "depth",
        "second",
        "second_rig",
        "pose",
        "depth_images",
        "depth_source",
        "control_points",
    ];
    let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    let example = |line: &&str| {
        let name = line.split(" = ").next().unwrap();
        line.contains(" = ") && name.chars().all(is_name) && !others.contains(&name)
    };
    let examples: Vec<_> = std::fs::read_to_string(&path)
        .unwrap()
        .lines()
        .map(|line| {
            line.strip_prefix("# ")
                .filter(example)
                .unwrap_or(line)
                .to_owned()
        })
        .collect();
    let examples = examples
        .join("\n")
        .replace("mask = \"auto\"", "")
        .replace("# [{", "mask = [{");
    std::fs::write(&path, &examples).unwrap();
    let shown = values(&outcome(&folder, &["config", "show"]).unwrap());
    assert_eq!(shown, values(&examples));
    assert_eq!(shown["capture"]["controls"]["auto_exposure"], 1.into());
    assert_eq!(
        shown["extract"]["mask"].to_string(),
        "[{ hue_deg = [190, 250], saturation = [0.3, 1], value = [0.2, 1] }]"
    );
}

#[test]
fn a_found_settings_file_never_overwrites() {
    let folder = TempDir::new().unwrap();
    write(
        &folder,
        "[run]\ntrace = \"letter.json\"\n[record]\nreplace = true\n",
    );
    let letter = folder.path().join("letter.json");
    std::fs::write(&letter, "Dear").unwrap();
    let run = |more: &[&str]| {
        let words = ["run", "--source", "rendered", "--frames", "3"];
        let output = lariat(&folder, &[&words, more].concat()).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        (output.status.success(), said)
    };
    let (succeeded, said) = run(&[]);
    assert!(!succeeded && said.contains("record.replace of the lariat.toml"));
    assert_eq!(std::fs::read_to_string(&letter).unwrap(), "Dear");
    let (succeeded, said) = run(&["--config", "lariat.toml"]);
    assert!(succeeded, "{said}");
    assert_ne!(std::fs::read_to_string(&letter).unwrap(), "Dear");
}

#[test]
fn a_file_that_is_there_is_kept_unless_force_is_said() {
    let folder = TempDir::new().unwrap();
    write(&folder, "[fit]\ncontrol_points = 6\n");
    let complaint = outcome(&folder, &["config", "init"]).unwrap_err();
    assert!(complaint.contains("--force"), "{complaint}");
    assert!(
        outcome(&folder, &["config", "show"])
            .unwrap()
            .contains("control_points = 6")
    );
    outcome(&folder, &["config", "init", "--force"]).unwrap();
    assert!(
        outcome(&folder, &["config", "show"])
            .unwrap()
            .contains("basis = \"auto\"")
    );
    let names: Vec<_> = std::fs::read_dir(&folder).unwrap().collect();
    assert_eq!(names.len(), 1, "no temporary files: {names:?}");
}

#[test]
fn flags_win_over_the_file_and_the_file_over_the_defaults() {
    let folder = TempDir::new().unwrap();
    write(&folder, "[fit]\ncontrol_points = 6\nsolver = \"qr\"\n");
    let shown = outcome(
        &folder,
        &[
            "config",
            "show",
            "--control-points",
            "7",
            "--fps",
            "max",
            "--source",
            "a.png",
            "b",
            "--duration",
            "2m",
            "--deadline",
            "33ms",
            "--size",
            "800x600",
            "--seed",
            "7",
            "--loop",
            "--lossless",
            "--rig",
            "left-arm",
            "--frames",
            "240",
            "--points",
            "60",
            "--out",
            "report",
        ],
    )
    .unwrap();
    for line in [
        "control_points = 7  # --control-points",
        "solver = \"qr\"  # lariat.toml, line 3",
        "fps = \"max\"  # --fps",
        "source = [\"a.png\", \"b\"]  # --source",
        "duration_s = 120  # --duration",
        "deadline_us = 33000  # --deadline",
        "size = [800, 600]  # --size",
        "seed = 7  # --seed",
        "loop = true  # --loop",
        "lossless = true  # --lossless",
        "rig = \"left-arm\"  # --rig",
        "frames = 240  # --frames",
        "points = 60  # --points",
        "out = \"report\"  # --out",
        "ropes = 24  # default",
    ] {
        assert!(shown.lines().any(|shown| shown == line), "{line}\n{shown}");
    }
}

#[test]
fn another_file_is_read_where_one_is_named() {
    let folder = TempDir::new().unwrap();
    write(&folder, "[fit]\ncontrol_points = 6\n");
    std::fs::write(
        folder.path().join("other.toml"),
        "[fit]\ncontrol_points = 4\n",
    )
    .unwrap();
    let shown = outcome(&folder, &["config", "show", "--config", "other.toml"]).unwrap();
    assert!(
        shown.contains("control_points = 4  # other.toml, line 2"),
        "{shown}"
    );
    let missing = outcome(&folder, &["config", "show", "--config", "none.toml"]).unwrap_err();
    assert!(missing.contains("none.toml"), "{missing}");
}

#[test]
fn an_unknown_key_is_named_with_its_line_and_its_neighbours() {
    assert_eq!(
        complaint("[camera]\n\n# in the world\nunits = 7\n"),
        "lariat: lariat.toml, line 4: [camera] has no key \"units\". Did you mean \"unit\"? Its keys are calibration, \
         plane, unit, depth, second, second_rig, second_within_us, pose, depth_deadline_us\n"
    );
    for (text, why) in [
        (
            "[fit]\ndegre = 7\n",
            "[fit] has no key \"degre\". Did you mean \"degree\"? Its keys are basis, control_points, max_control_points, ",
        ),
        (
            "[run]\nduration = 7\n",
            "[run] has no key \"duration\". Did you mean \"duration_s\"? Its keys are rig, lossless, duration_s, ",
        ),
        (
            "[fit]\npoints = 7\n",
            "[fit] has no key \"points\". It belongs in [extract]. Its keys are basis, control_points, max_control_points, ",
        ),
    ] {
        let said = complaint(text);
        let expected = format!("lariat: lariat.toml, line 2: {why}");
        assert!(said.starts_with(&expected), "{said}");
    }
    assert_eq!(
        complaint("\n[captur]\nfps = 7\n"),
        "lariat: lariat.toml, line 2: there is no section [captur]. Did you mean [capture]? The sections are \
         [run], [capture], [simulation], [camera], [extract], [fit], [sink], [record]\n"
    );
    assert_eq!(
        complaint("control_points = 9\n"),
        "lariat: lariat.toml, line 1: \"control_points\" stands outside any section: put it below a line [fit]\n"
    );
    assert_eq!(
        complaint("[extract]\nmask = [{ hue = [1, 2] }]\n"),
        "lariat: lariat.toml, line 2: mask = [{ hue = [1, 2] }]: a range has no \"hue\". Did you mean \
         \"hue_deg\"? It has hue_deg, saturation and value\n"
    );
}

#[test]
fn a_wrong_unit_is_converted() {
    for (text, advice) in [
        ("[capture]\nfps = \"30 Hz\"", "without a unit: write 30"),
        (
            "[capture]\nfps = \"33.3ms\"",
            "not the time between two frames: write 30",
        ),
        (
            "[run]\nduration_s = \"500ms\"",
            "a number of seconds, without a unit: write 0.5",
        ),
        (
            "[run]\ndeadline_us = \"33ms\"",
            "a number of microseconds, without a unit: write 33000",
        ),
        (
            "[extract]\nmask = [{ hue_deg = [100, 130], saturation = [50, 255] }]",
            "OpenCV's 0 to 255 is divided by 255, so write saturation = [0.2, 1]",
        ),
        (
            "[fit]\ncontrol_points = \"8\"",
            "write the number without quotes: 8",
        ),
    ] {
        let complaint = complaint(text);
        assert!(complaint.contains("lariat.toml, line 2: "), "{complaint}");
        assert!(complaint.contains(advice), "{complaint}");
    }
}

#[test]
fn a_range_turned_around_is_turned_back_but_a_hue_may_go_through_red() {
    let complaint = complaint("[extract]\nmask = [{ saturation = [0.9, 0.2] }]\n");
    assert!(
        complaint.contains("put the smaller first, saturation = [0.2, 0.9]"),
        "{complaint}"
    );
    let folder = TempDir::new().unwrap();
    write(&folder, "[extract]\nmask = [{ hue_deg = [350, 10] }]\n");
    let shown = outcome(&folder, &["config", "show"]).unwrap();
    assert!(
        shown.contains("[{ hue_deg = [350, 10], saturation = [0, 1], value = [0, 1] }]"),
        "{shown}"
    );
}

#[test]
fn values_that_cannot_be_are_refused() {
    for text in [
        "[run]\nrig = \"Left Arm\"",
        "[run]\nrig = \"\"",
        "[run]\nrig = \"abcdefghijklmnopqrstuvwxyz0123456\"",
        "[run]\nlossless = \"yes\"",
        "[run]\nduration_s = 0",
        "[run]\nduration_s = -3",
        "[run]\nduration_s = nan",
        "[run]\nduration_s = 1e12",
        "[run]\nframes = 0",
        "[run]\ndeadline_us = inf",
        "[run]\nout = 5",
        "[capture]\nsource = []",
        "[capture]\nsource = 5",
        "[capture]\nsource = [\"a\", 5]",
        "[capture]\nfps = 0",
        "[capture]\nfps = -30",
        "[capture]\nfps = \"fast\"",
        "[capture]\nfps = true",
        "[capture]\npixel_format = \"colour\"",
        "[capture]\npixel_format = 3",
        "[capture]\ncontrols = 3",
        "[capture]\ncontrols = { gain = 1.5 }",
        "[capture]\nlock = 1",
        "[capture]\nsize = [640]",
        "[capture]\nsize = [640, 63]",
        "[capture]\nsize = [640, 9000]",
        "[capture]\nsize = \"640\"",
        "[capture]\nseed = -1",
        "[extract]\nmask = \"blue\"",
        "[extract]\nmask = []",
        "[extract]\nmask = [5]",
        "[extract]\nmask = [{ hue_deg = [0, 400] }]",
        "[extract]\nmask = [{ hue_deg = 20 }]",
        "[extract]\nmask = [{ value = [-0.1, 1] }]",
        "[extract]\npoints = 257",
        "[extract]\npoints = 1",
        "[extract]\nropes = 25",
        "[extract]\nmask_level = 0",
        "[extract]\nmask_level = \"low\"",
        "[extract]\nropes = 0",
        "[extract]\nstart = [1]",
        "[extract]\nstart = [nan, 1]",
        "[fit]\ncontrol_points = 1",
        "[fit]\ncontrol_points = 33",
        "[fit]\ncontrol_points = 8.5",
        "[fit]\nsolver = \"svd\"",
        "[fit]\ncontrol_points = \"best\"",
        "[fit]\nbasis = \"spline\"",
        "[fit]\nknots = 3",
        "[fit]\nrho = \"odd\"",
        "[fit]\nridge = -1",
        "[fit]\nridge = nan",
        "[fit]\nacceleration_px_s2 = 0",
        "[fit]\nrobust = 1",
        "[sink]\nlive = 1",
        "[run]\ncpus = 1",
        "[run]\ncpus = \"all\"",
        "[run]\ncpus = [0, 1]",
        "[run]\ncpus = [0, 0, 0, -1]",
        "[run]\ncpus = { fits = 1 }",
        "[run]\ncpus = {}",
        "[run]\nscheduling = \"rr\"",
        "[run]\npriority = 97",
        "[run]\npriority = 0",
        "[run]\nwake = \"poll\"",
        "[run]\nspin_us = 10001",
        "[run]\nrealtime = \"yes\"",
    ] {
        let complaint = complaint(text);
        assert!(
            complaint.starts_with("lariat: lariat.toml, line 2: "),
            "{text}: {complaint}"
        );
        assert_eq!(complaint.lines().count(), 1, "{complaint}");
    }
}

#[test]
fn settings_that_do_not_go_together_are_refused() {
    assert_eq!(
        complaint("[extract]\npoints = 5\n[fit]\ncontrol_points = 9\n"),
        "lariat: lariat.toml, line 4: 5 points cannot fix a Bezier curve of 9 control points: \
         give at least 9 points, or choose a Bezier curve of 5 control points
"
    );
    let folder = TempDir::new().unwrap();
    write(&folder, "[fit]\ncontrol_points = 25\n");
    outcome(&folder, &["config", "check"]).unwrap();
    let complaint = outcome(&folder, &["config", "show", "--solver", "cholesky"]).unwrap_err();
    assert!(
        complaint.starts_with("lariat: --solver: for a Bezier curve of 25 control points"),
        "{complaint}"
    );
}

#[test]
fn the_old_names_of_a_curve_s_size_say_what_to_write_now() {
    for (text, now) in [
        ("[fit]\norder = 12\n", "write control_points = 13\n"),
        (
            "[fit]\norder = \"auto\"\n",
            "write control_points = \"auto\"\n",
        ),
        ("[fit]\nmax_order = 16\n", "write max_control_points = 17\n"),
    ] {
        let said = complaint(text);
        assert!(said.ends_with(now) && said.lines().count() == 1, "{said}");
    }
    let folder = TempDir::new().unwrap();
    for flags in [["--order", "12"], ["--degree", "12"]] {
        let said = outcome(&folder, &[&["config", "show"][..], &flags].concat()).unwrap_err();
        assert!(said.contains("write --control-points 13"), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
}

#[test]
fn basis_and_control_points_are_what_was_said_last() {
    let folder = TempDir::new().unwrap();
    let shown = |flags: &[&str]| {
        let shown = outcome(&folder, &[&["config", "show"], flags].concat()).unwrap();
        let fit = values(&shown)["fit"].clone();
        let count = fit
            .get("control_points")
            .map_or("none".to_owned(), |count| count.to_string());
        format!("{} {count}", fit["basis"].as_str().unwrap())
    };
    assert_eq!(shown(&[]), "auto none");
    assert_eq!(shown(&["--control-points", "13"]), "bezier 13");
    assert_eq!(shown(&["--basis", "bspline"]), "bspline 9");
    assert_eq!(
        shown(&["--basis", "bspline", "--control-points", "13"]),
        "bspline 13"
    );
    write(&folder, "[fit]\nbasis = \"auto\"\n");
    assert_eq!(shown(&["--control-points", "13"]), "bezier 13");
    write(&folder, "[fit]\ncontrol_points = 7\n");
    assert_eq!(shown(&[]), "bezier 7");
    assert_eq!(shown(&["--basis", "auto"]), "auto none");
    write(&folder, "");
    for said in [
        outcome(
            &folder,
            &["config", "show", "--basis", "auto", "--control-points", "9"],
        )
        .unwrap_err(),
        complaint("[fit]\nbasis = \"auto\"\ncontrol_points = 9\n"),
    ] {
        assert!(
            said.contains("the basis \"auto\" chooses the control points itself"),
            "{said}"
        );
    }
}

#[test]
fn stages_that_share_a_process_are_not_to_be_restarted() {
    let complaint = complaint("[run]\nfuse = true\nrestart = \"always\"\n");
    assert!(
        complaint.starts_with("lariat: lariat.toml, line 3: stages that share one process cannot"),
        "{complaint}"
    );
}

#[test]
fn a_reader_that_looks_and_its_writer_do_not_share_a_core() {
    let complaint = complaint("[run]\nwake = \"spin\"\ncpus = { capture = 0, extract = 0 }\n");
    assert!(
        complaint.starts_with("lariat: lariat.toml, line 3: wake = \"spin\" lets extract look"),
        "{complaint}"
    );
}

#[test]
fn cores_are_shown_as_they_were_given() {
    let folder = TempDir::new().unwrap();
    for (given, shown) in [
        ("0,0,1,1", "cpus = [0, 0, 1, 1]"),
        ("none", "cpus = \"none\""),
        ("auto", "cpus = \"auto\""),
    ] {
        let text = outcome(&folder, &["config", "show", "--cpus", given]).unwrap();
        assert!(text.contains(shown), "{text}");
    }
    write(&folder, "[run]\ncpus = { sink = 1, extract = 0 }\n");
    let text = outcome(&folder, &["config", "show"]).unwrap();
    assert!(text.contains("cpus = { extract = 0, sink = 1 }"), "{text}");
}

#[test]
fn everything_that_is_wrong_is_said_at_once_in_the_order_of_lines() {
    let complaint =
        complaint("[fit]\nsolver = \"x\"\ncontrol_points = 100\n[capture]\nfps = 0\nfsp = 1\n");
    let lines: Vec<_> = complaint
        .lines()
        .map(|line| {
            line.trim_start_matches("lariat: ")
                .split(": ")
                .next()
                .unwrap()
        })
        .collect();
    assert_eq!(
        lines,
        [
            "lariat.toml, line 2",
            "lariat.toml, line 3",
            "lariat.toml, line 5",
            "lariat.toml, line 6"
        ]
    );
}

#[test]
fn what_is_no_toml_is_said_with_its_line() {
    for text in [
        "[fit]\ncontrol_points = \n",
        "[fit\ncontrol_points = 9",
        "[fit]\ncontrol_points = 9\ncontrol_points = 10\n",
    ] {
        let complaint = complaint(text);
        assert!(complaint.contains("line "), "{complaint}");
        assert!(complaint.contains("this is not TOML"), "{complaint}");
    }
}

#[test]
fn a_flag_that_makes_no_sense_is_named() {
    let folder = TempDir::new().unwrap();
    for (flag, value) in [
        ("--fps", "30 Hz"),
        ("--fps", "-1"),
        ("--control-points", "1"),
        ("--control-points", "-1"),
        ("--points", "1000"),
        ("--duration", "5parsec"),
        ("--deadline", "0"),
        ("--size", "640"),
        ("--pixel-format", "colour"),
        ("--rig", "A"),
        ("--solver", "svd"),
        ("--basis", "spline"),
        ("--control-points", "best"),
        ("--ridge", "-1"),
        ("--degree", "0"),
        ("--frames", "0"),
        ("--cpus", "0,1"),
        ("--cpus", "a,b,c,d"),
        ("--priority", "0"),
        ("--wake", "never"),
        ("--spin", "1s"),
    ] {
        let complaint =
            outcome(&folder, &["config", "show", &format!("{flag}={value}")]).unwrap_err();
        assert!(complaint.contains(flag), "{complaint}");
    }
}

#[test]
fn a_cameras_controls_come_from_the_file_and_single_ones_from_flags() {
    let folder = TempDir::new().unwrap();
    write(
        &folder,
        "[capture]\npixel_format = \"mjpeg\"\nsize = \"auto\"\n[capture.controls]\nauto_exposure = 1\ngain = 20\n\
         white_balance_automatic = false\n",
    );
    let flags = [
        "config",
        "show",
        "--source",
        "/dev/video0",
        "--control",
        "gain=30",
        "--control",
        "power_line_frequency=50 Hz",
        "--lock",
    ];
    let shown = values(&outcome(&folder, &flags).unwrap());
    let capture = &shown["capture"];
    assert_eq!(capture["pixel_format"].as_str(), Some("mjpg"));
    assert_eq!(capture["lock"].as_bool(), Some(true));
    assert_eq!(capture["restore"].as_bool(), Some(false));
    assert_eq!(
        capture["controls"].to_string(),
        "{ auto_exposure = 1, gain = 30, power_line_frequency = \"50 Hz\", white_balance_automatic = \"off\" }"
    );

    for wrong in ["gain", "=3", "gain="] {
        let complaint = outcome(&folder, &["config", "show", "--control", wrong]).unwrap_err();
        assert!(complaint.contains("NAME=VALUE"), "{complaint}");
    }
}

#[test]
fn a_part_of_the_files_is_from_a_frame_or_a_time_on() {
    let folder = TempDir::new().unwrap();
    write(
        &folder,
        "[capture]\nsource = \"film.y4m\"\nfrom = 120\nto = \"1.5min\"\nevery = 3\n",
    );
    let shown = values(&outcome(&folder, &["config", "show"]).unwrap());
    let capture = &shown["capture"];
    assert_eq!(capture["from"].as_integer(), Some(120));
    assert_eq!(capture["to"].as_str(), Some("90s"));
    assert_eq!(capture["every"].as_integer(), Some(3));
    let flags = [
        "config",
        "show",
        "--from",
        "0s",
        "--to",
        "2400",
        "--every=1",
    ];
    let shown = values(&outcome(&folder, &flags).unwrap());
    assert_eq!(shown["capture"]["from"].as_str(), Some("0s"));
    assert_eq!(shown["capture"]["to"].as_integer(), Some(2400));
    for wrong in ["0", "-3", "2.5", "2.5 parsecs", "soon", "-1s"] {
        let flags = ["config", "show", &format!("--from={wrong}")];
        let complaint = outcome(&folder, &flags).unwrap_err();
        assert!(complaint.starts_with("lariat: --from"), "{complaint}");
    }
    assert!(outcome(&folder, &["config", "show", "--every=0"]).is_err());
}

#[test]
fn what_the_source_cannot_have_is_said() {
    let folder = TempDir::new().unwrap();
    for (flags, part) in [
        (
            &["--from", "3"][..],
            "it is for pictures and videos, and the source is the rendered rope",
        ),
        (
            &["--follow", "--source", "/dev/video0"],
            "--follow: it is for pictures and videos, and the source is a camera",
        ),
        (&["--loop", "--source", "/dev/video0"], "--loop: "),
        (
            &["--pixel-format", "yuyv", "--source", "a.png"],
            "--pixel-format: it is for a camera",
        ),
        (&["--control", "gain=3"], "--control: it is for a camera"),
        (&["--follow", "--loop", "--source", "a"], "does not end"),
        (
            &["--follow", "--to", "9", "--source", "a"],
            "shown as it grows",
        ),
    ] {
        let complaint = outcome(&folder, &[&["config", "show"], flags].concat()).unwrap_err();
        assert!(complaint.contains(part), "{complaint}");
    }
    let complaint = complaint("[capture]\nsource = \"a.png\"\nlock = true\nio = \"auto\"\n");
    assert!(
        complaint.starts_with("lariat: lariat.toml, line 3: it is for a camera"),
        "{complaint}"
    );
    assert_eq!(complaint.lines().count(), 1, "{complaint}");
}

#[test]
fn what_the_file_has_for_one_source_does_not_keep_a_flag_from_naming_another() {
    let folder = TempDir::new().unwrap();
    write(
        &folder,
        "[capture]\nsource = \"/dev/video0\"\nlock = true\n",
    );
    outcome(&folder, &["config", "show", "--source", "a.png"]).unwrap();
    write(&folder, "[capture]\nlock = true\nfrom = 3\n");
    for source in ["rendered", "a.png", "/dev/video0"] {
        outcome(&folder, &["config", "show", "--source", source]).unwrap();
    }
    outcome(&folder, &["config", "check"]).unwrap();
}
