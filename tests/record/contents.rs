//! Contents of a recording.

use lariat_capture::{RenderOptions, Source};
use lariat_extract::{Extractor, Image, PixelFormat};
use lariat_fit::Fitter;
use lariat_record::{CompressedImageRecord, ImageRecord, Losses, Record};
use lariat_wire::{Centerlines, Descriptors, FrameHeader};
use rustix::process::Signal;

use crate::annotations::assert_polygons_end_where_ropes_do;
use crate::recording::Recording;
use crate::rig::{Bench, send};
use crate::rings::{Own, wait_until_announced};

const FRAMES: u64 = 150;

#[test]
fn a_lossless_recording_holds_every_frame_and_all_that_was_made_of_it() {
    let bench = Bench::new();
    let frames = FRAMES.to_string();
    let flags = ["run", "--lossless", "--fps", "max", "--frames", &frames];
    let ended = bench.run(
        &[
            &flags[..],
            &["--record", "run.mcap", "--control-points", "7"],
        ]
        .concat(),
    );
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success(), "{said}");
    assert!(
        said.contains("recorded 150 frames") && said.contains("nothing was dropped"),
        "{said}"
    );
    let recording = Recording::read(&bench.path("run.mcap"));
    assert!(recording.is_closed);
    assert_eq!(
        recording.losses(),
        Losses {
            at_ns: recording.losses().at_ns,
            ..Losses::default()
        }
    );
    let offset_ns: i64 = recording.about["monotonic_to_wall_ns"].parse().unwrap();
    let settings = String::from_utf8(recording.attachments[0].1.clone()).unwrap();
    assert_eq!(recording.attachments[0].0, "lariat.toml");
    assert!(settings.contains("control_points = 7"), "{settings}");
    compare_with_the_libraries(&recording, offset_ns);
    bench.assert_nothing_is_left();
}

/// A channel can only be joined while its writer lives, and capture ends with its only picture. On a
/// loaded machine the recorder may come too late, so this states a rate. Before frames woke the
/// recorder, it was always too late.
#[test]
fn one_picture_is_recorded_unless_capture_ends_first() {
    let picture = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/rope.png");
    let has_frame = |_| {
        let bench = Bench::new();
        let ended = bench.run(&["run", "--source", picture, "--record", "run.mcap"]);
        assert!(ended.status.success(), "{ended:?}");
        let recording = Recording::read(&bench.path("run.mcap"));
        bench.assert_nothing_is_left();
        recording.count("frames") + recording.count("image") == 2
    };
    assert!((0..4).any(has_frame));
}

/// Checks that every frame, centerline, truth and descriptor is the libraries' result for the
/// rendered rope.
fn compare_with_the_libraries(recording: &Recording, offset_ns: i64) {
    let mut source = lariat_capture::open(&Source::Rendered(RenderOptions::default())).unwrap();
    let mut extractor = Extractor::new(lariat_extract::Options::default()).unwrap();
    let options = lariat_fit::Options::default().basis(lariat_fit::Basis::Bezier { order: 6 });
    let mut fitter = Fitter::new(options).unwrap();
    let mut pixels = vec![0; source.largest_frame_bytes()];
    let mut header = FrameHeader::default();
    let mut seen = Box::new(Centerlines::EMPTY);
    let mut truth = Box::new(Centerlines::EMPTY);
    let mut truth_seen = Box::new(Centerlines::EMPTY);
    let mut shapes = Box::new(Descriptors::EMPTY);
    for topic in [
        "frames",
        "image",
        "centerlines",
        "truth",
        "descriptors",
        "annotations/ropes",
        "annotations/control_points",
    ] {
        assert_eq!(recording.count(topic), FRAMES, "{topic}");
    }
    for i in 0..FRAMES as usize {
        let frame = source.next().unwrap().expect("without end");
        source.write(&mut pixels);
        let message = &recording.of("frames")[i];
        header.decode(&message.cdr).unwrap();
        assert_eq!(header.trace.captured, i as u64 + 1);
        assert_eq!(
            message.log_ns,
            header.trace.captured_ns.wrapping_add_signed(offset_ns)
        );
        assert_eq!(u64::from(message.sequence), frame.sequence);
        let image = ImageRecord::decode(&recording.of("image")[i].cdr).unwrap();
        assert_eq!((image.width, image.height), (frame.width, frame.height));
        assert!(image.data == &pixels[..image.data.len()], "frame {i}");
        seen.decode(&recording.of("centerlines")[i].cdr).unwrap();
        let view = Image::new(
            &pixels,
            frame.width as usize,
            frame.height as usize,
            frame.stride as usize,
            PixelFormat::Rgb8,
        );
        let scene = extractor
            .at(header.trace.exposed_ns)
            .extract(&view.unwrap());
        truth_seen.decode(&recording.of("truth")[i].cdr).unwrap();
        assert!(source.truth(&mut truth));
        assert_eq!(truth_seen.curves()[0].points(), truth.curves()[0].points());
        shapes.decode(&recording.of("descriptors")[i].cdr).unwrap();
        assert_eq!(seen.curves().len(), scene.curves.len());
        for ((curve, drawn), shape) in scene.curves.iter().zip(seen.curves()).zip(shapes.curves()) {
            assert_eq!(drawn.points(), &curve.points[..]);
            let points: Vec<_> = curve.points.iter().map(|p| p.map(f64::from)).collect();
            let fit = fitter.fit(&points).unwrap();
            assert_eq!(shape.control_points(), &fit.control_points[..]);
        }
    }
}

#[test]
fn control_points_in_millimetres_are_drawn_where_the_rope_is_seen() {
    let bench = Bench::new();
    let slant = "homography = [[0.5, 0.1, 20], [0.02, 0.6, 10], [1e-5, 4e-4, 1]]\n";
    std::fs::write(bench.path("plane.toml"), slant).unwrap();
    let flags = ["run", "--lossless", "--fps", "max", "--frames", "20"];
    let ended = bench.run(
        &[
            &flags[..],
            &["--plane", "plane.toml", "--record", "mm.mcap"],
        ]
        .concat(),
    );
    assert!(ended.status.success(), "{ended:?}");
    let recording = Recording::read(&bench.path("mm.mcap"));
    assert_eq!(recording.count("annotations/control_points"), 20);
    let mut seen = Box::new(Centerlines::EMPTY);
    let drawn = recording.of("annotations/control_points");
    for (message, drawn) in recording.of("centerlines").iter().zip(drawn) {
        seen.decode(&message.cdr).unwrap();
        assert_polygons_end_where_ropes_do(&drawn.cdr, &seen);
    }
    bench.assert_nothing_is_left();
}

#[test]
fn frames_are_recorded_as_the_user_likes() {
    let bench = Bench::new();
    for (images, compression) in [("png", "zstd"), ("jpeg", "none"), ("none", "lz4")] {
        let file = format!("{images}.mcap");
        let flags = [
            "run",
            "--lossless",
            "--fps",
            "max",
            "--frames",
            "10",
            "--record",
            &file,
            "--images",
            images,
            "--compression",
            compression,
        ];
        let ended = bench.run(&flags);
        assert!(
            ended.status.success(),
            "{}",
            String::from_utf8_lossy(&ended.stderr)
        );
        let recording = Recording::read(&bench.path(&file));
        assert!(recording.is_closed);
        assert_eq!(recording.count("frames"), 10);
        assert_eq!(recording.about["images"], images);
        assert_eq!(recording.about["compression"], compression);
        let pictures = recording.of("image");
        assert_eq!(pictures.len(), if images == "none" { 0 } else { 10 });
        for picture in pictures {
            let record = CompressedImageRecord::decode(&picture.cdr).unwrap();
            assert_eq!(record.format, images);
        }
    }
    bench.assert_nothing_is_left();
}

#[test]
fn a_recorder_by_itself_is_there_before_the_rig_and_across_its_restart() {
    let bench = Bench::new();
    let mut recorder = Own::start(&bench, &["--out", "own.mcap", "--lossless"]);
    wait_until_announced(&bench, recorder.0.id());
    for points in ["100", "110"] {
        let flags = ["run", "--lossless", "--fps", "max", "--frames", "40"];
        let ended = bench.run(&[&flags[..], &["--points", points]].concat());
        assert!(
            ended.status.success(),
            "{}",
            String::from_utf8_lossy(&ended.stderr)
        );
    }
    send(recorder.0.id() as i32, Signal::TERM);
    let ended = recorder.0.wait().unwrap();
    assert!(ended.success());
    let recording = Recording::read(&bench.path("own.mcap"));
    assert!(recording.is_closed);
    for topic in ["frames", "image", "centerlines", "truth", "descriptors"] {
        assert_eq!(recording.count(topic), 80, "{topic}");
    }
    assert_eq!(recording.losses().dropped_frames, 0);
    // Settings of both runs, as announced by their stages.
    let settings: Vec<String> = recording
        .attachments
        .iter()
        .map(|(_, bytes)| String::from_utf8(bytes.clone()).unwrap())
        .collect();
    for points in ["points = 100", "points = 110"] {
        assert!(
            settings.iter().any(|text| text.contains(points)),
            "{settings:#?}"
        );
    }
    bench.assert_nothing_is_left();
}

#[test]
fn a_recorder_by_itself_ends_when_as_much_is_recorded_as_was_asked() {
    let bench = Bench::new();
    let mut chain = bench.start(&["--fps", "100", "--duration", "60"]);
    chain.wait_for_frames();
    let ended = bench.run(&["record", "--out", "own.mcap", "--frames", "20"]);
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(ended.status.success(), "{said}");
    let recording = Recording::read(&bench.path("own.mcap"));
    // Messages that waited together with the last frame are included, too.
    assert!((20..25).contains(&recording.count("frames")), "{said}");
    chain.signal_chain(Signal::INT);
    assert!(chain.end().status.success());
    bench.assert_nothing_is_left();
}
