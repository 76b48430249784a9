//! Recordings with the images of several cameras, as other programs make them.

use std::collections::BTreeMap;
use std::io::Cursor;

use lariat_record::{ENCODING, IMAGE, SCHEMA_ENCODING, encode_image};
use lariat_wire::{FrameHeader, PixelFormat};
use mcap::WriteOptions;
use mcap::records::MessageHeader;

use crate::rig::Bench;

/// Five frames of the left camera, each with a rope, and three of the right camera, which sees a
/// bare table.
fn two_cameras() -> Vec<u8> {
    let (width, height) = (160, 120);
    let header = FrameHeader {
        width,
        height,
        stride: width,
        pixel_format: PixelFormat::Gray8 as u32,
        ..FrameHeader::default()
    };
    let table = vec![200; (width * height) as usize];
    let mut rope = table.clone();
    for row in rope.chunks_exact_mut(width as usize).skip(50).take(9) {
        row[20..140].fill(40);
    }
    let mut writer = WriteOptions::new().create(Cursor::new(Vec::new())).unwrap();
    let schema = writer.add_schema(IMAGE.name, SCHEMA_ENCODING, IMAGE.text.as_bytes());
    let schema = schema.unwrap();
    let mut cdr = Vec::new();
    for (topic, pixels, frames) in [("/left/image_raw", rope, 5), ("/right/image_raw", table, 3)] {
        let channel = writer.add_channel(schema, topic, ENCODING, &BTreeMap::new());
        let channel_id = channel.unwrap();
        for frame in 0..frames {
            let log_time = 1_700_000_000_000_000_000 + frame * 10_000_000;
            assert!(encode_image(&header, &pixels, log_time, "r", &mut cdr));
            let header = MessageHeader {
                channel_id,
                sequence: 0,
                log_time,
                publish_time: log_time,
            };
            writer.write_to_known_channel(&header, &cdr).unwrap();
        }
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

#[test]
fn of_several_cameras_one_is_chosen_and_none_is_taken_unasked() {
    let bench = Bench::new();
    std::fs::write(bench.path("two.mcap"), two_cameras()).unwrap();
    for command in [&["run", "--source", "two.mcap"][..], &["trace", "two.mcap"]] {
        let output = bench.run(command);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        let both = "/left/image_raw, /right/image_raw";
        assert!(said.contains(both) && said.contains("--topic"), "{said}");
    }
    for (topic, frames, with_curve) in [("/left/image_raw", 5, 5), ("/right/image_raw", 3, 0)] {
        let show = [
            "--source",
            "two.mcap",
            "--lossless",
            "--force",
            "--out",
            "out",
            "--topic",
            topic,
        ];
        let output = bench.run(&[&["run"], &show[..]].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        let summary = bench.summary("out");
        assert_eq!(summary["frames"]["received"].as_u64(), Some(frames));
        assert_eq!(summary["frames"]["with_curve"].as_u64(), Some(with_curve));
    }
    let trace = [
        "trace",
        "two.mcap",
        "--topic",
        "/left/image_raw",
        "--from",
        "2",
        "--every",
        "2",
    ];
    let output = bench.run(&[&trace[..], &["--json"]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), 2);
    let output = bench.run(&["run", "--source", "two.mcap", "--topic", "/middle"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("/middle") && said.contains("/left/image_raw"),
        "{said}"
    );
    bench.assert_nothing_is_left();
}
