//! `lariat trace` on the frames of a recording gives the same results as the chain.

use std::fs;

use lariat_record::Record;
use lariat_wire::{Descriptor, Descriptors, FitQuality, Status};
use serde_json::Value;

use crate::recording::Recording;
use crate::rig::Bench;

const FRAMES: &str = "66";

/// A table seen at an angle.
const PLANE: &str = "homography = [[0.5, 0.1, 20], [0.02, 0.6, 10], [1e-5, 4e-4, 1]]\n";

/// Records a rope held by grippers, with a hand that covers it for a while; also exports its frames
/// as pictures.
fn covered_rope() -> Bench {
    let bench = Bench::new();
    let hand = "[simulation]\nhand_at_s = 0.7\nhand_for_s = 0.5\n[sink]\nlive = false\n";
    fs::write(bench.path("lariat.toml"), hand).unwrap();
    fs::write(bench.path("plane.toml"), PLANE).unwrap();
    let pace = ["--lossless", "--fps", "30", "--frames", FRAMES];
    run(&bench, "simulated", "rope.mcap", &pace);
    let export = ["export", "rope.mcap", "--format", "png", "--out", "frames"];
    said(&bench, &export);
    bench
}

/// Runs a command that must succeed, and returns its output.
fn said(bench: &Bench, arguments: &[&str]) -> String {
    let output = bench.run(arguments);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {complaint}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs the chain on a source, and returns its descriptors.
fn run(bench: &Bench, source: &str, file: &str, flags: &[&str]) -> Vec<Box<Descriptors>> {
    let words = ["run", "--source", source, "--record", file];
    said(bench, &[&words, flags].concat());
    let recording = Recording::read(&bench.path(file));
    let decoded = recording.of("descriptors").iter().map(|message| {
        let mut descriptors = Box::new(Descriptors::EMPTY);
        descriptors.decode(&message.cdr).unwrap();
        descriptors
    });
    decoded.collect()
}

/// Checks that `trace` prints for each frame what its chain sent.
fn compare(bench: &Bench, sent: &[Box<Descriptors>], trace: &[&str]) {
    let printed = said(bench, &[&["trace", "--json"], trace].concat());
    let printed: Vec<Value> = (printed.lines())
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(printed.len(), sent.len(), "{trace:?}");
    for (frame, (printed, sent)) in printed.iter().zip(sent).enumerate() {
        let curves = printed["curves"].as_array().unwrap();
        assert_eq!(curves.len(), sent.curves().len(), "frame {frame}");
        for (printed, sent) in curves.iter().zip(sent.curves()) {
            assert_eq!(
                of_trace(printed),
                of_chain(sent),
                "{trace:?}, frame {frame}"
            );
        }
    }
}

/// All numbers of a curve, rounded as `trace` prints them.
fn of_chain(curve: &Descriptor) -> Vec<f64> {
    let plain = [curve.rms, curve.max, curve.residual_variance, curve.length];
    let rest = [curve.condition, curve.max / curve.width];
    let numbers = plain.into_iter().chain(rest);
    let numbers = numbers.chain(curve.control_points().as_flattened().iter().copied());
    let thousandths = numbers.map(|x| (x * 1e3).round() / 1e3 + 0.0);
    [curve.track, curve.status, curve.fit, curve.degree]
        .map(f64::from)
        .into_iter()
        .chain([curve.age_ns as f64 / 1e6])
        .chain(thousandths)
        .collect()
}

/// The same numbers from the printed report.
fn of_trace(curve: &Value) -> Vec<f64> {
    let descriptor = &curve["descriptor"];
    let number = |value: &Value| value.as_f64().unwrap();
    let status = match curve["status"].as_str().unwrap() {
        "ok" => Status::Ok,
        "partial" => Status::Partial,
        "lost" => Status::Lost,
        _ => Status::Doubtful,
    };
    let fit = match descriptor["fit"].as_str().unwrap() {
        "good" => FitQuality::Good,
        _ => FitQuality::Coarse,
    };
    let named = [status as u32, fit as u32].map(f64::from);
    let names = ["rms", "max", "residual_variance", "length", "condition"];
    let points: Vec<[f64; 2]> =
        serde_json::from_value(descriptor["control_points"].clone()).unwrap();
    [number(&curve["track"])]
        .into_iter()
        .chain(named)
        .chain([number(&descriptor["degree"]), number(&curve["age_ms"])])
        .chain(names.map(|name| number(&descriptor[name])))
        .chain([number(&descriptor["worst_widths"])])
        .chain(points.into_iter().flatten())
        .collect()
}

#[test]
fn a_trace_of_a_video_is_what_the_chain_sends() {
    let bench = covered_rope();
    let plane = ["--robust", "--filter", "--plane", "plane.toml"];
    for flags in [&["--robust"][..], &["--filter"], &plane] {
        let pace = ["--lossless", "--fps", "60", "--force"];
        let sent = run(&bench, "frames", "chain.mcap", &[&pace, flags].concat());
        assert_eq!(sent.len().to_string(), FRAMES);
        let curves = || sent.iter().flat_map(|sent| sent.curves());
        let filtered = curves().filter(|curve| curve.filtered == 1).count();
        assert_eq!(filtered > 60, flags.contains(&"--filter"), "{filtered}");
        assert!(curves().filter(|curve| curve.hidden > 5).count() > 10);
        let pictures = ["--video", "--fps", "60", "frames"];
        compare(&bench, &sent, &[flags, &pictures].concat());
        // The first chain's recording has its own times, but the same images.
        let words = ["--lossless", "--force"];
        let sent = run(&bench, "rope.mcap", "again.mcap", &[&words, flags].concat());
        compare(&bench, &sent, &[flags, &["rope.mcap"]].concat());
    }
    bench.assert_nothing_is_left();
}
