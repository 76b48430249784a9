//! `lariat trace` on pictures drawn here.

mod crossings;
mod masks;
mod meant;
mod notices;

use assert_cmd::Command;
use image::{GrayImage, Rgb, RgbImage};
use serde_json::Value;
use tempfile::TempDir;

/// Runs the binary in an empty folder, so that it finds no settings file.
fn trace(folder: &TempDir, args: &[&str]) -> Command {
    let mut command = assert_cmd::cargo::cargo_bin_cmd!("lariat");
    command.current_dir(folder).arg("trace").args(args);
    command
}

const TABLE: Rgb<u8> = Rgb([225, 220, 210]);
const ROPE: Rgb<u8> = Rgb([40, 90, 190]);

/// A plain table with a rope along `centerline`, 9 px wide with smooth edges.
fn rope_picture(width: u32, height: u32, centerline: impl Fn(f64) -> [f64; 2]) -> RgbImage {
    let mut picture = RgbImage::from_pixel(width, height, TABLE);
    let mut covered = vec![0.0f64; (width * height) as usize];
    for step in 0..=4000 {
        let [x, y] = centerline(f64::from(step) / 4000.0);
        for py in (y as i64 - 6)..=(y as i64 + 6) {
            for px in (x as i64 - 6)..=(x as i64 + 6) {
                if (0..i64::from(width)).contains(&px) && (0..i64::from(height)).contains(&py) {
                    let distance = (px as f64 - x).hypot(py as f64 - y);
                    let pixel = &mut covered[(py * i64::from(width) + px) as usize];
                    *pixel = pixel.max((5.0 - distance).clamp(0.0, 1.0));
                }
            }
        }
    }
    for (pixel, share) in picture.pixels_mut().zip(covered) {
        for (channel, rope) in pixel.0.iter_mut().zip(ROPE.0) {
            *channel =
                (f64::from(*channel) * (1.0 - share) + f64::from(rope) * share).round() as u8;
        }
    }
    picture
}

/// One wave across the picture.
fn wave(t: f64) -> [f64; 2] {
    [40.0 + 240.0 * t, 120.0 + 60.0 * (5.0 * t).sin()]
}

fn wave_picture() -> RgbImage {
    rope_picture(320, 240, wave)
}

fn save(folder: &TempDir, name: &str, picture: &RgbImage) {
    picture.save(folder.path().join(name)).unwrap();
}

fn lines(stdout: &[u8]) -> Vec<Value> {
    std::str::from_utf8(stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<_> = value
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    keys.sort_unstable();
    keys
}

fn points(value: &Value) -> Vec<[f64; 2]> {
    serde_json::from_value(value.clone()).unwrap()
}

/// Distance of `p` from the wave, extended by half the rope's width because its tips are round.
fn distance_to_wave(p: [f64; 2]) -> f64 {
    (-40..=2040)
        .map(|i| wave(f64::from(i) / 2000.0))
        .map(|w| (w[0] - p[0]).hypot(w[1] - p[1]))
        .fold(f64::INFINITY, f64::min)
}

/// The only output line for the only picture, the wave.
fn the_waves_line() -> Value {
    let folder = TempDir::new().unwrap();
    save(&folder, "wave.png", &wave_picture());
    let output = trace(&folder, &["wave.png", "--json"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(output.stderr.is_empty(), "{output:?}");
    let [report] = &lines(&output.stdout)[..] else {
        panic!("one line for one picture: {output:?}")
    };
    report.clone()
}

#[test]
fn a_line_has_the_keys_that_were_promised() {
    let report = the_waves_line();
    let curve = &report["curves"][0];
    let expected = [
        (
            &report,
            "crossings curves height image notices schema timing_us width",
        ),
        (
            &report["timing_us"],
            "decode fit follow graph mask points skeleton total",
        ),
        (
            curve,
            "age_ms border closed confidence crossing_sequence descriptor hidden length_px points pulls_straight status \
             track width_px widths_px",
        ),
        (
            &curve["descriptor"],
            "basis condition control_points degree fit knots length max noise_gain residual_variance rms rms_widths unit \
             worst_widths",
        ),
    ];
    for (object, promised) in expected {
        assert_eq!(keys(object).join(" "), promised);
    }
}

#[test]
fn a_rope_is_traced_and_described() {
    let report = the_waves_line();
    assert_eq!(report["image"], "wave.png");
    assert_eq!([&report["width"], &report["height"]], [320, 240]);
    let [curve] = &report["curves"].as_array().unwrap()[..] else {
        panic!("one rope: {report}")
    };
    assert_eq!(curve["status"], "ok");
    assert_eq!(curve["closed"], false);
    let centerline = points(&curve["points"]);
    assert_eq!(centerline.len(), 120);
    for &p in &centerline {
        assert!(distance_to_wave(p) < 1.0, "{p:?}");
    }
    let width_px = curve["width_px"].as_f64().unwrap();
    assert!((width_px - 9.0).abs() < 1.5, "{width_px}");

    let descriptor = &curve["descriptor"];
    assert_eq!(
        [&descriptor["basis"], &descriptor["fit"]],
        ["bspline", "good"]
    );
    assert_eq!(descriptor["degree"], 3);
    let control_points = points(&descriptor["control_points"]);
    let knots = descriptor["knots"].as_array().unwrap();
    let knots: Vec<f64> = knots.iter().map(|knot| knot.as_f64().unwrap()).collect();
    let basis = lariat_fit::Basis::BSpline {
        degree: 3,
        control_points: control_points.len(),
        knots: lariat_fit::Knots::Uniform,
    };
    let drawn = lariat_fit::Curve::new(basis, &control_points, &[], &knots).unwrap();
    for i in 0..=100 {
        let p = drawn.point(f64::from(i) / 100.0);
        assert!(distance_to_wave(p) < 2.0, "{p:?}");
    }
}

#[test]
fn the_descriptor_is_what_lariat_fit_makes_of_the_points() {
    let folder = TempDir::new().unwrap();
    save(&folder, "wave.png", &wave_picture());
    let args = [
        "wave.png",
        "--json",
        "--control-points",
        "6",
        "--points",
        "60",
        "--solver",
        "qr",
    ];
    let output = trace(&folder, &args).output().unwrap();
    let report = &lines(&output.stdout)[0];
    let curve = &report["curves"][0];
    let mut fitter = lariat_fit::Fitter::new(
        lariat_fit::Options::bezier(5)
            .points(60)
            .solver(lariat_fit::Solver::Pinv),
    )
    .unwrap();
    let fit = fitter.fit(&points(&curve["points"])).unwrap();
    // Both are printed to a thousandth of a pixel, and control points amplify differences of the
    // points.
    for (ours, theirs) in fit.control_points.iter().flatten().zip(
        points(&curve["descriptor"]["control_points"])
            .iter()
            .flatten(),
    ) {
        assert!((ours - theirs).abs() < 0.01, "{ours} {theirs}");
    }
}

#[test]
fn a_picture_without_a_rope_has_no_curves() {
    let folder = TempDir::new().unwrap();
    save(&folder, "table.png", &RgbImage::from_pixel(64, 48, TABLE));
    save(&folder, "dot.png", &RgbImage::from_pixel(1, 1, ROPE));
    let args = ["table.png", "dot.png", "--json", "--overlay", "over"];
    let output = trace(&folder, &args).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let reports = lines(&output.stdout);
    assert_eq!(reports.len(), 2);
    for report in &reports {
        assert_eq!(report["curves"], serde_json::json!([]));
    }
    assert_eq!([&reports[1]["width"], &reports[1]["height"]], [1, 1]);
    assert_eq!(
        image::open(folder.path().join("over/dot.png"))
            .unwrap()
            .width(),
        1
    );

    let table = trace(&folder, &["table.png"]).output().unwrap();
    assert!(String::from_utf8(table.stdout).unwrap().contains("no rope"));
}

#[test]
fn a_picture_taken_sideways_is_traced_upright() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("wave.jpg");
    image::imageops::rotate270(&wave_picture())
        .save(&path)
        .unwrap();
    // EXIF data "turn me right" (orientation 6), after the start of the image.
    let mut note = b"\xff\xe1\x00\x22Exif\0\0MM\0*\0\0\0\x08".to_vec();
    note.extend([0, 1, 0x01, 0x12, 0, 3, 0, 0, 0, 1, 0, 6, 0, 0, 0, 0, 0, 0]);
    let lying = std::fs::read(&path).unwrap();
    std::fs::write(&path, [&lying[..2], &note, &lying[2..]].concat()).unwrap();
    let output = trace(&folder, &["wave.jpg", "--json"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let report = &lines(&output.stdout)[0];
    assert_eq!([&report["width"], &report["height"]], [320, 240]);
    let points = points(&report["curves"][0]["points"]);
    assert!(points.into_iter().all(|p| distance_to_wave(p) < 1.0));
}

#[test]
fn a_large_picture_is_no_trouble() {
    let folder = TempDir::new().unwrap();
    // Gray keeps the test fast; a rope of 5,000 px in 48 million pixels.
    let mut picture = GrayImage::from_pixel(8000, 6000, image::Luma([200]));
    for x in 1500..6500 {
        for y in 2990..3010 {
            picture.put_pixel(x, y, image::Luma([30]));
        }
    }
    picture.save(folder.path().join("large.png")).unwrap();
    let output = trace(&folder, &["large.png", "--json"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let report = &lines(&output.stdout)[0];
    assert_eq!([&report["width"], &report["height"]], [8000, 6000]);
    let length_px = report["curves"][0]["length_px"].as_f64().unwrap();
    assert!((length_px - 5000.0).abs() < 20.0, "{length_px}");
}

#[test]
fn what_is_no_picture_is_said_and_the_others_are_traced() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    save(&folder, "wave.png", &wave_picture());
    let whole = std::fs::read(at("wave.png")).unwrap();
    std::fs::write(at("cut.png"), &whole[..whole.len() / 2]).unwrap();
    std::fs::write(at("letter.png"), "Dear rope,\n").unwrap();
    std::fs::write(at("empty.png"), "").unwrap();
    std::fs::create_dir(at("nothing")).unwrap();
    std::fs::create_dir_all(at("above/pictures")).unwrap();

    let args = [
        "cut.png",
        "letter.png",
        "empty.png",
        "missing.png",
        "nothing",
        "above",
        "wave.png",
        "--json",
        "--overlay",
        "over",
    ];
    let output = trace(&folder, &args).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let reports = lines(&output.stdout);
    assert_eq!(reports.len(), 1);
    assert_eq!(reports[0]["image"], "wave.png");
    let complaints = String::from_utf8(output.stderr).unwrap();
    for (count, name) in [
        "nothing",
        "above",
        "cut.png",
        "letter.png",
        "empty.png",
        "missing.png",
    ]
    .into_iter()
    .enumerate()
    {
        let line = complaints.lines().nth(count).unwrap_or_default();
        assert!(
            line.contains(name),
            "line {count} is about {name}: {complaints}"
        );
    }
    assert_eq!(complaints.lines().count(), 6, "{complaints}");
    assert!(complaints.contains("name one of its folders, such as above/pictures"));
    let overlays: Vec<_> = std::fs::read_dir(at("over"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(overlays, ["wave.png"], "no broken or temporary files");
}

#[test]
fn a_folder_is_taken_in_natural_order() {
    let folder = TempDir::new().unwrap();
    std::fs::create_dir(folder.path().join("frames")).unwrap();
    let table = RgbImage::from_pixel(16, 16, TABLE);
    for name in ["frame10.png", "frame9.png", "frame1.PNG", "frame2.jpg"] {
        save(&folder, &format!("frames/{name}"), &table);
    }
    std::fs::write(folder.path().join("frames/notes.txt"), "not a picture").unwrap();
    let output = trace(&folder, &["frames", "--json"]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let names: Vec<_> = lines(&output.stdout)
        .iter()
        .map(|report| report["image"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(
        names,
        [
            "frames/frame1.PNG",
            "frames/frame2.jpg",
            "frames/frame9.png",
            "frames/frame10.png"
        ]
    );
}

#[test]
fn the_overlay_shows_the_curve_over_the_picture() {
    let folder = TempDir::new().unwrap();
    let picture = wave_picture();
    save(&folder, "wave.png", &picture);
    save(&folder, "wave.jpg", &picture);
    let args = ["wave.png", "wave.jpg", "--overlay", "new/over"];
    assert!(trace(&folder, &args).output().unwrap().status.success());
    let read = |name: &str| image::open(folder.path().join(name)).unwrap().into_rgb8();
    // Two pictures of the same name do not overwrite each other.
    for overlay in [read("new/over/wave.png"), read("new/over/wave-2.png")] {
        assert_eq!(overlay.dimensions(), picture.dimensions());
    }
    let overlay = read("new/over/wave.png");
    let is_changed = |x: f64, y: f64| {
        let (x, y) = (x.round() as u32, y.round() as u32);
        overlay.get_pixel(x, y) != picture.get_pixel(x, y)
    };
    let on_the_rope = (0..=100).map(|i| wave(f64::from(i) / 100.0));
    let drawn = on_the_rope.filter(|p| is_changed(p[0], p[1])).count();
    assert!(drawn > 90, "{drawn} of 101 places along the rope");
    assert!(!is_changed(5.0, 235.0), "a far corner is left alone");
}

#[test]
fn no_overlay_replaces_a_picture() {
    let folder = TempDir::new().unwrap();
    save(&folder, "wave.png", &wave_picture());
    let before = std::fs::read(folder.path().join("wave.png")).unwrap();
    let output = trace(&folder, &["wave.png", "--overlay", "."])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        String::from_utf8(output.stderr)
            .unwrap()
            .contains("another folder")
    );
    assert_eq!(
        std::fs::read(folder.path().join("wave.png")).unwrap(),
        before
    );
}

#[test]
fn a_video_keeps_the_direction_of_a_rope_that_turns_and_single_pictures_do_not() {
    let folder = TempDir::new().unwrap();
    // One end moves from the top left halfway around to the bottom right, 22 px per picture.
    let end_at = |step: u32, t: f64| {
        let angle = (225.0 + 15.0 * f64::from(step)).to_radians();
        let from_center = 85.0 * (1.0 - 2.0 * t);
        [
            160.0 + from_center * angle.cos(),
            120.0 + from_center * angle.sin(),
        ]
    };
    let names: Vec<String> = (0..=12).map(|step| format!("{step}.png")).collect();
    for (step, name) in (0..).zip(&names) {
        save(&folder, name, &rope_picture(320, 240, |t| end_at(step, t)));
    }
    let last_first_point = |flags: &[&str]| -> [f64; 2] {
        let images: Vec<&str> = names.iter().map(String::as_str).collect();
        let output = trace(&folder, &[&images[..], &["--json"], flags].concat())
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
        points(&lines(&output.stdout)[12]["curves"][0]["points"])[0]
    };
    let near = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]) < 8.0;
    let still = last_first_point(&[]);
    assert!(
        near(still, end_at(12, 1.0)),
        "alone, from the top left: {still:?}"
    );
    let moving = last_first_point(&["--video"]);
    assert!(
        near(moving, end_at(12, 0.0)),
        "in time, from the end that was first: {moving:?}"
    );
}

#[test]
fn colours_and_limits_come_from_the_settings_file() {
    let folder = TempDir::new().unwrap();
    save(&folder, "wave.png", &wave_picture());
    let settings = |hue: &str| {
        let text = format!("[extract]\nmask = [{{ hue_deg = {hue}, saturation = [0.4, 1] }}]\n");
        std::fs::write(folder.path().join("lariat.toml"), text).unwrap();
        let output = trace(&folder, &["wave.png", "--json"]).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        lines(&output.stdout)[0]["curves"].as_array().unwrap().len()
    };
    assert_eq!(settings("[200, 240]"), 1, "the rope is blue");
    assert_eq!(settings("[340, 20]"), 0, "and not red");
}

#[test]
fn a_number_of_control_points_that_cannot_be_is_refused_before_the_first_picture() {
    let folder = TempDir::new().unwrap();
    let output = trace(&folder, &["missing.png", "--control-points", "41"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        "lariat: --control-points: 41: choose a whole number from 2 to 32\n"
    );
}
