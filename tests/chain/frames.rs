//! Frames that arrive, and frames that do not.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lariat_capture::{RenderOptions, Source};
use lariat_extract::{Extractor, Image, PixelFormat};
use lariat_fit::Fitter;
use lariat_wire::{DESCRIPTORS, Delivery, Descriptors, Domain, Message, Payload, Receiver, Rig};
use rustix::process::Signal;
use serde_json::json;

use crate::rig::Bench;

/// Track and control points of one rope, and the points and widths of its centerline.
type Shape = (u32, Vec<[f64; 2]>, Vec<[f32; 2]>, Vec<f32>);

/// Results of the libraries for the rendered rope, frame by frame.
struct Library {
    source: Box<dyn lariat_capture::FrameSource>,
    pixels: Vec<u8>,
    extractor: Extractor,
    fitter: Fitter,
}

impl Library {
    fn new() -> Self {
        let source = lariat_capture::open(&Source::Rendered(RenderOptions::default())).unwrap();
        Self {
            pixels: vec![0; source.largest_frame_bytes()],
            source,
            extractor: Extractor::new(lariat_extract::Options::default()).unwrap(),
            fitter: Fitter::new(lariat_fit::Options::default()).unwrap(),
        }
    }

    /// Returns the number of the next frame and the shapes in it, for the time at which the chain
    /// exposed it.
    fn next(&mut self, exposed_ns: u64) -> (u64, Vec<Shape>) {
        let frame = self.source.next().unwrap().expect("without end");
        self.source.write(&mut self.pixels);
        let (width, height, stride) = (frame.width, frame.height, frame.stride);
        assert_eq!(frame.format, lariat_wire::PixelFormat::Rgb8);
        let image = Image::new(
            &self.pixels,
            width as usize,
            height as usize,
            stride as usize,
            PixelFormat::Rgb8,
        );
        let scene = self.extractor.at(exposed_ns).extract(&image.unwrap());
        let mut curves = Vec::new();
        for curve in scene.curves {
            let points: Vec<_> = curve
                .points
                .iter()
                .map(|point| point.map(f64::from))
                .collect();
            let fit = self.fitter.fit(&points).unwrap();
            curves.push((
                curve.track,
                fit.control_points.clone(),
                curve.points.clone(),
                curve.widths_px.clone(),
            ));
        }
        (frame.sequence, curves)
    }
}

#[test]
fn every_descriptor_of_a_lossless_chain_is_the_librarys_own() {
    every_descriptor_is_the_librarys_own(&[]);
}

#[test]
fn every_descriptor_of_a_chain_in_one_process_is_the_same() {
    every_descriptor_is_the_librarys_own(&["--fuse"]);
}

fn every_descriptor_is_the_librarys_own(options: &[&str]) {
    const FRAMES: u64 = 500;
    let bench = Bench::new();
    // This test is a reader in the chain's domain.
    let reader_domain = in_domain(&bench);
    let delivery = Delivery::Lossless {
        stop: Arc::default(),
    };
    let reader = Receiver::create(
        &reader_domain,
        &Rig::default(),
        &DESCRIPTORS,
        Some(&delivery),
    )
    .unwrap();
    let frames = FRAMES.to_string();
    let arguments = [
        "--lossless",
        "--fps",
        "max",
        "--frames",
        &frames,
        "--out",
        "out",
        "--control-points",
        "9",
    ];
    let chain = bench.start(&[&arguments, options].concat());
    let mut library = Library::new();
    for count in 1..=FRAMES {
        let message = wait_for_next(&reader, Instant::now() + Duration::from_secs(60));
        let (sequence, curves) = library.next(message.trace.exposed_ns);
        assert_eq!(message.trace.sequence, sequence);
        assert_eq!(
            [
                message.trace.captured,
                message.trace.extracted,
                message.trace.fitted
            ],
            [count; 3]
        );
        let seen: Vec<_> = message
            .curves()
            .iter()
            .zip(message.centerlines())
            .map(|(curve, centerline)| {
                (
                    curve.track,
                    curve.control_points().to_vec(),
                    centerline.points().to_vec(),
                    centerline.widths().to_vec(),
                )
            })
            .collect();
        assert_eq!(seen, curves, "frame {count}");
        assert_stamps_are_in_order(&message);
    }
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    let frames = &bench.summary("out")["frames"];
    assert_eq!(frames["published"], FRAMES);
    assert_eq!(frames["received"], FRAMES);
    assert_eq!(
        frames["lost"],
        json!({"source": 0, "capture": 0, "mask": 0, "extract": 0, "fit": 0, "bridge": 0, "sink": 0})
    );
    drop((reader, reader_domain));
    bench.assert_nothing_is_left();
}

/// Waits for the next message, in order.
pub(crate) fn wait_for_next<P: Payload + ?Sized>(
    reader: &Receiver<P>,
    deadline: Instant,
) -> Message<P> {
    loop {
        if let Some(message) = reader.next().unwrap() {
            return message;
        }
        assert!(Instant::now() < deadline, "no message came");
        reader.sleep(Some(deadline), None).unwrap();
    }
}

fn assert_stamps_are_in_order(message: &Descriptors) {
    let trace = &message.trace;
    let stamps = [
        trace.exposed_ns,
        trace.captured_ns,
        trace.extract_started_ns,
        trace.extracted_ns,
        trace.fit_started_ns,
        trace.fitted_ns,
        lariat_wire::now_ns(),
    ];
    assert!(stamps.is_sorted(), "{stamps:?}");
}

/// Opens the domain of a test in this process.
fn in_domain(bench: &Bench) -> Domain {
    Domain::named(&bench.domain).unwrap()
}

#[test]
fn a_chain_that_cannot_keep_up_counts_exactly_what_it_skips() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "200", "--frames", "1200", "--out", "out"]);
    chain.wait_for_frames();
    // Extract is stopped for a while; capture does not wait for it.
    chain.signal_stage(1, Signal::STOP);
    let reader_domain = in_domain(&bench);
    let frames =
        Receiver::create(&reader_domain, &Rig::default(), &lariat_wire::FRAMES, None).unwrap();
    let deadline = Instant::now() + Duration::from_secs(60);
    for _ in 0..50 {
        wait_for_next(&frames, deadline);
    }
    drop((frames, reader_domain));
    chain.signal_stage(1, Signal::CONT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    let summary = bench.summary("out");
    let count = |key: &str| summary["frames"][key].as_u64().unwrap();
    let lost = |key: &str| summary["frames"]["lost"][key].as_u64().unwrap();
    assert_eq!(count("published"), 1200);
    assert!(lost("capture") >= 40, "{summary}");
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}

#[test]
fn the_timeline_shows_each_stage_at_work_on_each_frame() {
    let bench = Bench::new();
    let flags = ["run", "--lossless", "--fps", "max", "--frames", "40"];
    let ended = bench.run(&[&flags[..], &["--trace", "timeline.json"]].concat());
    assert!(ended.status.success());
    let bytes = std::fs::read(bench.path("timeline.json")).unwrap();
    let timeline: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    let events = timeline["traceEvents"].as_array().unwrap();
    for stage in 0..4 {
        let slices = events
            .iter()
            .filter(|event| event["ph"] == "X" && event["tid"] == stage);
        assert_eq!(slices.count(), 40, "stage {stage}");
    }
    bench.assert_nothing_is_left();
}

#[test]
fn two_rigs_run_side_by_side() {
    let bench = Bench::new();
    let arguments = |rig, out| ["--rig", rig, "--fps", "50", "--frames", "50", "--out", out];
    let left = bench.start(&arguments("left", "left"));
    let right = bench.start(&arguments("right", "right"));
    for ended in [left.end(), right.end()] {
        assert!(ended.status.success(), "{}", ended.stderr);
    }
    for rig in ["left", "right"] {
        assert_eq!(bench.summary(rig)["frames"]["published"], 50);
        bench.assert_every_frame_is_accounted_for(rig);
    }
    bench.assert_nothing_is_left();
}

#[test]
fn a_second_capture_on_a_rig_is_refused_and_the_first_goes_on() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "50", "--duration", "60", "--out", "out"]);
    chain.wait_for_frames();
    let second = bench.run(&["capture", "--frames", "10"]);
    assert!(!second.status.success());
    let message = String::from_utf8_lossy(&second.stderr);
    assert!(
        message.contains("lariat/default/frames already has a writer"),
        "{message}"
    );
    let whole = bench.run(&["run", "--frames", "10", "--record", "second.mcap"]);
    assert_eq!(whole.status.code(), Some(1));
    let message = String::from_utf8_lossy(&whole.stderr);
    let who = format!(
        "rig default is in use by process {} (lariat), which has run for ",
        chain.process.id()
    );
    assert!(message.contains(&who), "{message}");
    assert!(!bench.path("second.mcap").exists());
    chain.signal_chain(Signal::INT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    bench.assert_every_frame_is_accounted_for("out");
    bench.assert_nothing_is_left();
}
