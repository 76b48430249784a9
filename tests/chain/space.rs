//! Ropes in 3-D: pictures and depth images of drawn ropes in folders, or pictures for two rigs,
//! pass through the chains' processes to a reader of 3-D shapes.

use std::collections::BTreeMap;
use std::fs;
use std::time::{Duration, Instant};

use image::{ImageBuffer, Luma, Rgb};
use lariat_drawn::space::{DepthSensor, Eye, LiftOptions, LiftedRope, depth, picture};
use lariat_view::Gatherer;
use lariat_wire::{Domain, NoShape, NoSpace, Place, Reader, Rig, Seen, now_ns};
use rustix::process::Signal;

use crate::rig::{Bench, Running};

const SIZE: [usize; 2] = [424, 240];
const ASIDE: [f64; 3] = [-15.0, 0.0, 0.0];

fn eye() -> Eye {
    Eye::above(305.0, SIZE, 500.0, 15.0, 30.0)
}

/// Draws a lifted rope for two cameras and writes their calibrations, in the bench's folder.
fn drawn(bench: &Bench) -> LiftedRope {
    let options = LiftOptions {
        length_mm: 500.0,
        radius_mm: 5.0,
        lift_mm: 80.0,
        crossings: 0,
    };
    let rope = LiftedRope::new(&options, &eye(), 3).expect("a rope that fits");
    let beside = eye().beside(ASIDE, 305.0, SIZE);
    let [width, height] = SIZE.map(|side| side as u32);
    for name in ["color", "depth"] {
        fs::create_dir(bench.path(name)).unwrap();
    }
    let pixels = picture(&rope, &eye(), 3);
    ImageBuffer::<Rgb<u8>, _>::from_raw(width, height, pixels)
        .unwrap()
        .save(bench.path("color/1.png"))
        .unwrap();
    let units = depth(&rope, &beside, &DepthSensor::STEREO, 3);
    ImageBuffer::<Luma<u16>, _>::from_raw(width, height, units)
        .unwrap()
        .save(bench.path("depth/1.png"))
        .unwrap();
    let camera = "image_width: 424\nimage_height: 240\ncamera_matrix: [305, 0, 211.5, 0, 305, 119.5, 0, 0, 1]\n\
                  distortion_coefficients: [0, 0, 0, 0]\n";
    let pose = "rotation: [0, 0, 0, 1]\ntranslation_mm: [-15, 0, 0]\nnoise_mm_at_1m: 3.6\nrange_mm: [200, 1500]\n";
    fs::write(bench.path("camera.yaml"), camera).unwrap();
    fs::write(bench.path("depth.yaml"), camera.to_owned() + pose).unwrap();
    rope
}

/// Draws the rope for a second camera and writes its calibration.
fn drawn_again(bench: &Bench, rope: &LiftedRope) {
    let second = eye().verging([100.0, 0.0, 0.0], 500.0);
    let [width, height] = SIZE.map(|side| side as u32);
    fs::create_dir(bench.path("right")).unwrap();
    let pixels = picture(rope, &second, 3);
    ImageBuffer::<Rgb<u8>, _>::from_raw(width, height, pixels)
        .unwrap()
        .save(bench.path("right/1.png"))
        .unwrap();
    let (rotation, place) = second.pose_in(&eye());
    let camera = fs::read_to_string(bench.path("camera.yaml")).unwrap();
    let pose = format!(
        "rotation: {:?}\ntranslation_mm: {place:?}\n",
        rotation.as_flattened()
    );
    fs::write(bench.path("right.yaml"), camera + &pose).unwrap();
}

const RIGHT: [&str; 7] = [
    "--rig", "right", "--source", "right", "--loop", "--fps", "30",
];
const BESIDE: [&str; 4] = ["--second", "right.yaml", "--second-rig", "right"];

const SOURCE: [&str; 7] = [
    "--source",
    "color",
    "--loop",
    "--fps",
    "30",
    "--calibration",
    "camera.yaml",
];

/// Waits for a frame with a fresh rope that meets a condition; fails after some seconds.
fn wait_for(reader: &mut Reader, mut is_it: impl FnMut(&Seen) -> bool) {
    let deadline = Instant::now() + Duration::from_secs(20);
    loop {
        let frame = reader.wait(deadline).expect("readable");
        assert!(Instant::now() < deadline, "it did not come");
        if is_it(&frame.only_rope(Duration::from_secs(10))) {
            return;
        }
    }
}

fn far(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

fn reader(bench: &Bench) -> Reader {
    let domain = Domain::named(&bench.domain).expect("a domain");
    Reader::open_in(domain, &Rig::default()).expect("a reader")
}

/// Ends the chain and the reader, and checks that nothing is left.
fn end(bench: &Bench, chain: Running, reader: Reader) {
    chain.signal_chain(Signal::INT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    drop(reader);
    bench.assert_nothing_is_left();
}

#[test]
fn a_lifted_rope_comes_out_where_it_is() {
    let bench = Bench::new();
    let rope = drawn(&bench);
    let axis: Vec<[f64; 3]> = rope.points.iter().map(|&p| eye().see(p)).collect();
    let steps = axis.windows(2).map(|pair| far(pair[0], pair[1]));
    let length: f64 = steps.sum();
    let beside = ["--depth-images", "depth", "--depth", "depth.yaml"];
    let chain = bench.start(&[&SOURCE[..], &beside].concat());
    let mut reader = reader(&bench);
    let mut not_asked = None;
    wait_for(&mut reader, |seen| match seen {
        Seen::Fresh(rope) => {
            not_asked = rope.in_space().err();
            true
        }
        _ => false,
    });
    assert_eq!(not_asked, Some(NoSpace::NotFollowed));
    reader.follow_in_space().expect("room for one more");
    wait_for(&mut reader, |seen| {
        let Seen::Fresh(rope) = seen else {
            return false;
        };
        // Messages sent before this reader's first request are not available.
        let Ok(shape) = rope.in_space() else {
            return false;
        };
        for point in shape.points::<60>() {
            let off = axis
                .iter()
                .map(|&on| far(on, point))
                .fold(f64::MAX, f64::min);
            assert!(off < 3.0, "{point:?} is {off} mm beside the axis");
        }
        let heights = || axis.iter().map(|p| p[2]);
        let (near, distant) = (
            heights().fold(f64::MAX, f64::min),
            heights().fold(0.0, f64::max),
        );
        assert!(distant - near > 50.0, "it is no lifted rope");
        let said = rope.descriptor3().expect("it was said");
        assert_eq!(said.place(), Some(Place::Known));
        let off = said.length / length - 1.0;
        assert!(off.abs() < 0.03, "{} mm long, not {length}", said.length);
        assert!((said.width - 10.0).abs() < 2.0, "{} mm wide", said.width);
        assert!(said.measured > 90 && said.measured <= 120);
        for [xx, _, _, yy, _, zz] in said.covariances() {
            assert!([xx, yy, zz].iter().all(|&&v| v > 0.0 && v < 100.0));
        }
        true
    });
    // A viewer sees it, too.
    let domain = Domain::named(&bench.domain).expect("a domain");
    let mut gatherer = Gatherer::new(&domain, Some(Rig::default()));
    wait_for(&mut reader, |_| {
        gatherer.look(now_ns());
        let shape = gatherer.view(now_ns()).shape;
        let Some(seen) = shape.and_then(|shape| shape.ropes.first()?.in_space) else {
            return false;
        };
        assert_eq!(seen.place, Some(Place::Known));
        assert!((seen.length_mm / length - 1.0).abs() < 0.03, "{seen:?}");
        true
    });
    drop(gatherer);
    drop(domain);
    end(&bench, chain, reader);
}

#[test]
fn a_recording_has_every_depth_image_and_what_was_made_of_it_and_replays_as_any() {
    let bench = Bench::new();
    drawn(&bench);
    let beside = ["--depth-images", "depth", "--depth", "depth.yaml"];
    let recorded = ["--lossless", "--frames", "20", "--record", "run.mcap"];
    let output = bench.run(&[&["run"], &SOURCE[..], &beside, &recorded].concat());
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let bytes = fs::read(bench.path("run.mcap")).unwrap();
    let mut counts = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).expect("a recording") {
        let topic = message.expect("a message").channel.topic.clone();
        *counts.entry(topic).or_insert(0) += 1;
    }
    for topic in [
        "image",
        "depth",
        "depth_image",
        "descriptors3",
        "descriptors",
    ] {
        assert_eq!(
            counts.get(&format!("/default/{topic}")),
            Some(&20),
            "{topic}: {counts:?}"
        );
    }
    let output = bench.run(&["replay", "run.mcap", "--check"]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    bench.assert_nothing_is_left();
}

#[test]
fn without_a_depth_image_it_is_said_that_there_is_none_and_the_image_s_own_shape_stays() {
    let bench = Bench::new();
    drawn(&bench);
    let beside = ["--depth", "depth.yaml"];
    let chain = bench.start(&[&SOURCE[..], &beside].concat());
    let mut reader = reader(&bench);
    reader.follow_in_space().expect("room for one more");
    wait_for(&mut reader, |seen| {
        let Seen::Fresh(rope) = seen else {
            return false;
        };
        rope.shape().expect("a shape in the image");
        rope.in_space().err() == Some(NoSpace::NoShape(NoShape::Nowhere(Place::NoPartner)))
    });
    end(&bench, chain, reader);
}

#[test]
fn depth_images_that_are_none_and_cameras_that_do_not_fit_are_refused_with_a_sentence() {
    let bench = Bench::new();
    drawn(&bench);
    let ended = |more: &[&str]| {
        let output = bench.run(&[&["run"], &SOURCE[..], more].concat());
        assert!(!output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let said = ended(&["--depth-images", "color", "--depth", "depth.yaml"]);
    assert!(said.contains("not one number of 16 bits each"), "{said}");
    let said = ended(&["--depth", "nowhere.yaml"]);
    assert!(said.contains("nowhere.yaml"), "{said}");
    fs::write(
        bench.path("bad.yaml"),
        "image_width: 424\nimage_height: 240\nrotation: [1, 2, 3]\ntranslation_mm: [0, 0, 0]\n",
    )
    .unwrap();
    let said = ended(&["--depth", "bad.yaml"]);
    assert!(said.contains("rotation"), "{said}");
    let output = bench.run(&["run", "--source", "rendered", "--depth-images", "depth"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("name a folder of pictures"), "{said}");
    let beside = |more: &[&str]| {
        let output = bench.run(&[&["run", "--depth-source", "/dev/video98"], more].concat());
        assert!(!output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let said = beside(&["--source", "/dev/video99"]);
    assert!(
        said.contains("name its calibration (--depth FILE)"),
        "{said}"
    );
    let said = beside(&["--source", "color"]);
    assert!(said.contains("it is for a camera"), "{said}");
    let cameras = ["--calibration", "camera.yaml", "--depth", "depth.yaml"];
    let said = beside(&[&["--source", "/dev/video98"][..], &cameras].concat());
    assert!(said.contains("it is the source itself"), "{said}");
    bench.assert_nothing_is_left();
}

#[test]
fn a_lifted_rope_comes_out_where_two_cameras_see_it() {
    let bench = Bench::new();
    let rope = drawn(&bench);
    drawn_again(&bench, &rope);
    let axis: Vec<[f64; 3]> = rope.points.iter().map(|&p| eye().see(p)).collect();
    let right = bench.start(&RIGHT);
    let chain = bench.start(&[&SOURCE[..], &BESIDE].concat());
    let mut reader = reader(&bench);
    reader.follow_in_space().expect("room for one more");
    wait_for(&mut reader, |seen| {
        let Seen::Fresh(rope) = seen else {
            return false;
        };
        let Ok(shape) = rope.in_space() else {
            return false;
        };
        // A pixel of these small pictures corresponds to 8 mm of depth.
        let off = shape.points::<60>().map(|point| {
            let away = axis.iter().map(|&on| far(on, point));
            away.fold(f64::MAX, f64::min)
        });
        let mean = off.iter().sum::<f64>() / 60.0;
        assert!(mean < 2.0, "{mean} mm beside the axis in the mean: {off:?}");
        let said = rope.descriptor3().expect("it was said");
        assert_eq!(said.place(), Some(Place::Known));
        assert!(said.measured > 60 && said.measured <= 120);
        true
    });
    // Without its partner, this rig continues and says so.
    right.signal_chain(Signal::INT);
    assert!(right.end().status.success());
    wait_for(&mut reader, |seen| {
        let Seen::Fresh(rope) = seen else {
            return false;
        };
        rope.shape().expect("a shape in the image");
        rope.in_space().err() == Some(NoSpace::NoShape(NoShape::Nowhere(Place::NoPartner)))
    });
    chain.signal_chain(Signal::INT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    let said = ended.stderr;
    assert!(said.contains("is described in the image only"), "{said}");
    assert!(said.contains("rig right"), "{said}");
    drop(reader);
    bench.assert_nothing_is_left();
}

#[test]
fn of_a_second_camera_of_another_size_it_is_said_that_it_is_unreadable() {
    let bench = Bench::new();
    let rope = drawn(&bench);
    drawn_again(&bench, &rope);
    let text = fs::read_to_string(bench.path("right.yaml")).unwrap();
    let larger = text.replace("image_width: 424", "image_width: 640");
    fs::write(bench.path("right.yaml"), larger).unwrap();
    let right = bench.start(&RIGHT);
    let chain = bench.start(&[&SOURCE[..], &BESIDE].concat());
    let mut reader = reader(&bench);
    reader.follow_in_space().expect("room for one more");
    wait_for(&mut reader, |seen| {
        let Seen::Fresh(rope) = seen else {
            return false;
        };
        rope.in_space().err() == Some(NoSpace::NoShape(NoShape::Nowhere(Place::Unreadable)))
    });
    right.signal_chain(Signal::INT);
    assert!(right.end().status.success());
    chain.signal_chain(Signal::INT);
    let ended = chain.end();
    assert!(ended.status.success(), "{}", ended.stderr);
    assert!(
        ended
            .stderr
            .contains("frames of the second camera of 640×240 pixels"),
        "{}",
        ended.stderr
    );
    drop(reader);
    bench.assert_nothing_is_left();
}

#[test]
fn second_cameras_of_which_too_little_is_known_are_refused_with_a_sentence() {
    let bench = Bench::new();
    let rope = drawn(&bench);
    drawn_again(&bench, &rope);
    let ended = |more: &[&str]| {
        let output = bench.run(&[&["run"], &SOURCE[..], more].concat());
        assert!(!output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let said = ended(&BESIDE[..2]);
    assert!(said.contains("say which (--second-rig NAME)"), "{said}");
    let said = ended(&BESIDE[2..]);
    assert!(
        said.contains("name its calibration (--second FILE)"),
        "{said}"
    );
    let said = ended(&["--second", "right.yaml", "--second-rig", "default"]);
    assert!(said.contains("it is this rig itself"), "{said}");
    let said = ended(&["--second", "camera.yaml", "--second-rig", "right"]);
    assert!(said.contains("pose relative to the first camera"), "{said}");
    let said = ended(&[&BESIDE[..], &["--depth", "depth.yaml"]].concat());
    assert!(said.contains("name one of them"), "{said}");
    bench.assert_nothing_is_left();
}
