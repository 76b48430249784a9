//! Reading back recordings.

use crate::made;

use std::time::Duration;

use lariat_message::{FrameHeader, PixelFormat};
use lariat_record::{
    Entry, Messages, Pixels, Place, Record, Recording, RecordingError, Schema, Span,
};
use made::{Made, OFFSET_NS, PERIOD_NS};
use mcap::{Compression, WriteOptions};

const ALL: [Option<Compression>; 3] = [None, Some(Compression::Lz4), Some(Compression::Zstd)];

/// Formats a message as one line. Messages with equal lines are equal.
fn line(entry: Entry) -> String {
    let encoded = |message: &dyn Fn(&mut Vec<u8>)| {
        let mut cdr = Vec::new();
        message(&mut cdr);
        cdr
    };
    match entry {
        Entry::Frame(frame) => format!("frame {:?} {:?}", frame.header, frame.pixels),
        Entry::Mask(frame) => format!("mask {:?} {:?}", frame.header, frame.pixels),
        Entry::Centerlines(message) => format!("lines {:?}", encoded(&|to| message.encode(to))),
        Entry::Truth(message) => format!("truth {:?}", encoded(&|to| message.encode(to))),
        Entry::Descriptors(message) => format!("fits {:?}", encoded(&|to| message.encode(to))),
        Entry::Losses(message) => format!("losses {message:?}"),
    }
}

/// Returns all messages that can be read.
fn lines(mut messages: Messages) -> Vec<String> {
    let mut lines = Vec::new();
    loop {
        match messages.next() {
            Ok(Some(entry)) => lines.push(line(entry)),
            Ok(None) => return lines,
            Err(_) => {}
        }
    }
}

fn all(recording: &Recording) -> Vec<String> {
    lines(recording.messages(Span::default()).unwrap())
}

/// Expected contents of a rig's recording, frame by frame.
fn expected(sequences: impl IntoIterator<Item = u64>) -> Vec<String> {
    let mut expected = Vec::new();
    for sequence in sequences {
        let pixels = made::pixels(sequence);
        expected.push(format!(
            "frame {:?} {:?}",
            made::header(sequence),
            Pixels::Raw(&pixels)
        ));
        let lines = made::centerlines(sequence);
        expected.push(line(Entry::Truth(&lines)));
        expected.push(line(Entry::Centerlines(&lines)));
        expected.push(line(Entry::Descriptors(&made::descriptors(sequence))));
        let losses = lariat_record::Losses {
            at_ns: sequence,
            ..Default::default()
        };
        expected.push(line(Entry::Losses(&losses)));
    }
    expected
}

#[test]
fn what_was_written_is_read_however_it_is_compressed() {
    for compression in ALL {
        let recording = Recording::from_bytes(made::rig(compression, 3, 2)).unwrap();
        assert_eq!(all(&recording), expected(1..=6));
        assert_eq!(recording.cut_off(), None);
        assert_eq!(recording.frames().unwrap(), 6);
        assert!(recording.has_traces());
        assert_eq!(recording.images(), Some("/r/image"));
        let settings = recording.attachment("lariat.toml").unwrap();
        assert_eq!(settings.as_deref(), Some(&b"[fit]\norder = 8\n"[..]));
        assert_eq!(recording.attachment("plane.toml").unwrap(), None);
        assert_eq!(recording.about().version(), Some("0.1.0"));
    }
}

#[test]
fn what_is_on_each_topic_is_counted_alike_with_indexes_and_without() {
    let whole = Recording::from_bytes(made::rig(Some(Compression::Lz4), 3, 2)).unwrap();
    let topics = whole.topics().unwrap();
    let names: Vec<_> = topics.iter().map(|topic| &topic.name[..]).collect();
    assert_eq!(
        names,
        [
            "/r/centerlines",
            "/r/descriptors",
            "/r/frames",
            "/r/image",
            "/r/losses",
            "/r/truth"
        ]
    );
    assert!(
        topics
            .iter()
            .all(|topic| topic.messages == 6 && topic.bytes > 0)
    );
    assert_eq!(topics[3].schema, "sensor_msgs/msg/Image");
    let mut made = Made::with(WriteOptions::new().emit_message_indexes(false));
    for sequence in 1..=6 {
        made::frame(&mut made, sequence);
    }
    let counted = Recording::from_bytes(made.finish())
        .unwrap()
        .topics()
        .unwrap();
    // Head, time, "r", width and height, "mono8", byte order, length of a row and of all rows, and
    // the pixels.
    assert_eq!(
        counted[3].bytes,
        6 * (4 + 8 + (4 + 4) + 8 + (4 + 6) + 2 + 8 + 32)
    );
    for (listed, counted) in topics.iter().zip(&counted) {
        assert_eq!(listed.messages, counted.messages);
        // The definitions of topics are among the messages in the first chunk.
        assert!(
            listed.bytes.abs_diff(counted.bytes) < 8000,
            "{listed:?} {counted:?}"
        );
    }
}

#[test]
fn a_recording_cut_off_anywhere_is_read_up_to_its_last_whole_chunk() {
    let whole = made::rig(Some(Compression::Lz4), 3, 1);
    let expected = expected(1..=3);
    let mut most = 0;
    for end in 0..whole.len() {
        let Ok(recording) = Recording::from_bytes(whole[..end].to_vec()) else {
            // Once a message can be read, it stays readable.
            assert_eq!(most, 0, "cut at {end}");
            continue;
        };
        let read = all(&recording);
        assert!(read.len() >= most, "cut at {end}");
        assert_eq!(read.len() % 5, 0);
        assert_eq!(read, expected[..read.len()]);
        // A chunk is readable as soon as its last byte is there, whatever comes after it.
        assert!(recording.cut_off().is_some() || read.len() == expected.len());
        most = read.len();
    }
    assert_eq!(most, expected.len());
}

#[test]
fn a_torn_last_chunk_is_left_out_also_where_its_length_is_right() {
    let mut bytes = made::rig(None, 3, 1);
    // As after a power failure: the index and the second half of the last chunk were never written,
    // but the file is longer.
    let last = find_last_chunk(&bytes);
    bytes[last + 400..].fill(0);
    let recording = Recording::from_bytes(bytes).unwrap();
    assert_eq!(all(&recording), expected(1..=2));
    let sentence = recording.cut_off().unwrap();
    assert!(
        sentence.contains(&format!("up to byte {last} of")),
        "{sentence}"
    );
}

/// Returns the position of the last chunk's head.
fn find_last_chunk(bytes: &[u8]) -> usize {
    let mut at = 8;
    let mut last = None;
    while bytes[at] != 0x0F {
        if bytes[at] == 0x06 {
            last = Some(at);
        }
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        at += 9 + length as usize;
    }
    last.unwrap()
}

#[test]
fn a_damaged_chunk_is_told_of_and_what_lies_around_it_is_read() {
    let mut bytes = made::rig(None, 3, 1);
    let name = b"/r/descriptors";
    // The pixels of the second frame.
    let pixels = made::pixels(2);
    let place = bytes.windows(pixels.len()).position(|part| part == pixels);
    bytes[place.unwrap()] ^= 1;
    assert!(bytes.windows(name.len()).any(|part| part == name));
    let recording = Recording::from_bytes(bytes).unwrap();
    assert_eq!(all(&recording), expected([1, 3]));
    let mut messages = recording.messages(Span::default()).unwrap();
    for _ in 0..5 {
        assert!(messages.next().unwrap().is_some());
    }
    let error = messages.next().err().unwrap();
    assert!(matches!(error, RecordingError::Damaged { .. }), "{error}");
}

#[test]
fn a_part_is_its_frames_and_all_that_was_made_of_them() {
    let recording = Recording::from_bytes(made::rig(None, 4, 3)).unwrap();
    let part = |from, to| lines(recording.messages(Span { from, to }).unwrap());
    let frame = |frame| Some(Place::Frame(frame));
    assert_eq!(part(frame(5), frame(9)), expected(5..=8));
    assert_eq!(part(frame(12), None), expected([12]));
    assert_eq!(part(None, frame(2)), expected([1]));
    assert_eq!(part(frame(4), frame(99)), expected(4..=12));
    assert_eq!(part(frame(5), frame(5)), expected([]));
    let after = |periods: u64| {
        let time = Duration::from_nanos(periods * PERIOD_NS);
        Some(Place::After(time))
    };
    assert_eq!(part(after(2), after(4)), expected(3..=4));
    assert_eq!(part(after(100), None), expected([]));
    let error = recording.messages(Span {
        from: frame(13),
        to: None,
    });
    assert_eq!(
        error.err().unwrap().to_string(),
        "there is no frame 13: the recording holds 12, counted from 1"
    );
}

#[test]
fn a_part_of_a_recording_that_was_cut_off_is_found_too() {
    let whole = made::rig(Some(Compression::Zstd), 4, 3);
    let last = find_last_chunk(&whole);
    let recording = Recording::from_bytes(whole[..last + 20].to_vec()).unwrap();
    let from = Some(Place::Frame(8));
    let part = recording.messages(Span { from, to: None }).unwrap();
    assert_eq!(lines(part), expected(8..=9));
}

#[test]
fn messages_that_are_in_no_chunk_are_read() {
    let options = WriteOptions::new().use_chunks(false).compression(None);
    let mut made = Made::with(options);
    let offset = OFFSET_NS.to_string();
    made.metadata(&[("monotonic_to_wall_ns", &offset)]);
    for sequence in 1..=3 {
        made::frame(&mut made, sequence);
    }
    let recording = Recording::from_bytes(made.finish()).unwrap();
    assert_eq!(recording.cut_off(), None);
    assert_eq!(all(&recording), expected(1..=3));
    let from = Some(Place::Frame(3));
    let part = recording.messages(Span { from, to: None }).unwrap();
    assert_eq!(lines(part), expected([3]));
}

#[test]
fn a_frame_whose_image_is_not_there_has_no_pixels() {
    let mut made = Made::new(None);
    made.message("/r/frames", 1, &made::header(1));
    made.message("/r/frames", 2, &made::header(2));
    made.image("/r/image", 2, &made::header(2), &made::pixels(2));
    let blank = FrameHeader {
        width: 0,
        height: 0,
        ..made::header(3)
    };
    made.message("/r/frames", 3, &blank);
    made.message("/r/frames", 4, &made::header(4));
    let recording = Recording::from_bytes(made.finish()).unwrap();
    let mut messages = recording.messages(Span::default()).unwrap();
    let mut seen = Vec::new();
    while let Some(frame) = messages.next_frame().unwrap() {
        seen.push((frame.header.trace.sequence, frame.pixels != Pixels::None));
    }
    assert_eq!(seen, [(1, false), (2, true), (3, false), (4, false)]);
}

#[test]
fn picture_files_and_images_may_be_on_one_topic() {
    let mut made = Made::new(None);
    made.message("/r/frames", 1, &made::header(1));
    made.picture("/r/image", 1, "png", b"PNG");
    made.message("/r/frames", 2, &made::header(2));
    made.image_apart("/r/image", 2, &made::header(2), &made::pixels(2));
    let recording = Recording::from_bytes(made.finish()).unwrap();
    let mut messages = recording.messages(Span::default()).unwrap();
    let mut next = || {
        messages
            .next_frame()
            .unwrap()
            .map(|frame| format!("{:?}", frame.pixels))
    };
    assert_eq!(next(), Some(format!("{:?}", Pixels::Png(b"PNG"))));
    assert_eq!(next(), Some(format!("{:?}", Pixels::Raw(&made::pixels(2)))));
}

#[test]
fn masks_come_with_their_images() {
    let mut made = Made::new(None);
    let (header, mask) = (made::header(1), made::header(1).of_mask());
    made.message("/r/frames", 1, &header);
    made.image("/r/image", 1, &header, &made::pixels(1));
    made.message("/r/masks", 1, &mask);
    made.image("/r/mask_image", 1, &mask, &made::pixels(9));
    let recording = Recording::from_bytes(made.finish()).unwrap();
    let pixels = [made::pixels(1), made::pixels(9)];
    assert_eq!(
        all(&recording),
        [
            format!("frame {header:?} {:?}", Pixels::Raw(&pixels[0])),
            format!("mask {mask:?} {:?}", Pixels::Raw(&pixels[1])),
        ]
    );
}

#[test]
fn images_of_others_are_frames_without_a_way() {
    let mut made = Made::new(Some(Compression::Zstd));
    for i in 0..3 {
        made.image("/camera/image_raw", i, &made::header(i), &made::pixels(i));
        made.picture("/camera/other", i, "rgb8; jpeg compressed bgr8", b"JPEG");
    }
    let bytes = made.finish();
    let recording = Recording::from_bytes(bytes.clone()).unwrap();
    assert_eq!(recording.images(), Some("/camera/image_raw"));
    assert!(!recording.has_traces());
    let from = Some(Place::Frame(2));
    let mut messages = recording.messages(Span { from, to: None }).unwrap();
    let frame = messages.next_frame().unwrap().unwrap();
    assert_eq!(frame.header.trace.sequence, 2);
    assert_eq!(frame.header.format(), Some(PixelFormat::Gray8));
    assert_eq!(frame.pixels, Pixels::Raw(&made::pixels(1)));
    assert_eq!(recording.frames().unwrap(), 3);

    let path = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(path.path(), &bytes).unwrap();
    let recording = Recording::open_topic(path.path(), Some("/camera/other")).unwrap();
    let mut messages = recording.messages(Span::default()).unwrap();
    let frame = messages.next_frame().unwrap().unwrap();
    assert_eq!(frame.pixels, Pixels::Jpeg(b"JPEG"));
    let error = Recording::open_topic(path.path(), Some("/camera/none"));
    let error = error.err().unwrap().to_string();
    assert!(
        error.contains("/camera/image_raw (sensor_msgs/msg/Image)"),
        "{error}"
    );
}

#[test]
fn what_is_no_recording_is_told_apart() {
    let error = |bytes: &[u8]| Recording::from_bytes(bytes.to_vec()).err().unwrap();
    for bytes in [&b""[..], b"PNG", &[0x89, b'M', b'C'], &[0; 100]] {
        let error = error(bytes);
        assert!(matches!(error, RecordingError::NotMcap), "{error}");
    }
    let empty = made::rig(None, 0, 0);
    assert!(matches!(
        error(&empty),
        RecordingError::Empty { cut: false }
    ));
    assert!(matches!(
        error(&empty[..40]),
        RecordingError::Empty { cut: true }
    ));
    let mut made = Made::new(None);
    let other = Schema {
        name: "nav_msgs/msg/Odometry",
        text: "float64 x\n",
    };
    made.raw("/odometry", &other, 0, &[]);
    let text = error(&made.finish()).to_string();
    assert!(text.contains("/odometry (nav_msgs/msg/Odometry)"), "{text}");
}

#[test]
fn a_recording_of_another_release_is_refused_with_its_number() {
    let mut made = Made::new(None);
    made.metadata(&[("version", "7.0.0")]);
    let newer = Schema {
        name: "lariat_msgs/msg/Descriptors",
        text: "uint64 much_better # than ever\n",
    };
    made.raw("/r/descriptors", &newer, 0, &[0, 1, 0, 0]);
    let error = Recording::from_bytes(made.finish()).err().unwrap();
    let text = error.to_string();
    assert!(
        text.contains("made by lariat 7.0.0. Use that release"),
        "{text}"
    );
}

#[test]
fn images_that_are_not_what_they_say_are_no_frames() {
    let mut made = Made::new(None);
    let wider = FrameHeader {
        width: 9,
        stride: 9,
        ..made::header(1)
    };
    made.message("/r/frames", 1, &wider);
    made.image("/r/image", 1, &made::header(1), &made::pixels(1));
    made.message("/r/frames", 2, &made::header(2));
    made.image("/r/image", 2, &made::header(2), &made::pixels(2));
    let recording = Recording::from_bytes(made.finish()).unwrap();
    let mut messages = recording.messages(Span::default()).unwrap();
    let error = messages.next_frame().err().unwrap().to_string();
    assert!(error.contains("/r/image"), "{error}");
    let frame = messages.next_frame().unwrap().unwrap();
    assert_eq!(frame.header.trace.sequence, 2);
}
