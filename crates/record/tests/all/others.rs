//! Recordings of other programs: folders, files compressed as a whole, other schemas, and refusals
//! with a reason.

use std::fs;
use std::path::Path;

use lariat_message::{FrameHeader, PixelFormat};
use lariat_record::{
    Cdr, Encoder, Entry, Pixels, Place, Recording, RecordingError, Span, put_header,
};

use crate::made::{self, Made};

const RGB: &[u8] = &[1, 2, 3, 4, 5, 6];
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n and so on";
const JPEG: &[u8] = b"\xff\xd8\xff\xe0 and so on";
const WEBP: &[u8] = b"RIFF\x10\0\0\0WEBPVP8 and so on";

/// Returns the first frame's header, and its pixels as text.
fn first(recording: &Recording) -> Result<(FrameHeader, String), RecordingError> {
    let mut messages = recording.messages(Span::default())?;
    let frame = messages.next_frame()?.expect("there is a frame");
    Ok((frame.header, format!("{:?}", frame.pixels)))
}

fn of(bytes: Vec<u8>) -> Result<(FrameHeader, String), RecordingError> {
    first(&Recording::from_bytes(bytes)?)
}

/// Encodes a field of a protocol buffer.
fn bytes_field(number: u8, bytes: &[u8]) -> Vec<u8> {
    [&[number << 3 | 2, bytes.len() as u8][..], bytes].concat()
}

fn fixed_field(number: u8, value: u32) -> Vec<u8> {
    [&[number << 3 | 5][..], &value.to_le_bytes()].concat()
}

/// 5 s and 7 ns.
const STAMP: &[u8] = &[8, 5, 16, 7];
const STAMP_NS: u64 = 5_000_000_007;

#[test]
fn foxgloves_raw_images_are_read_in_every_encoding() {
    let protobuf = [
        bytes_field(1, STAMP),
        bytes_field(7, b"camera"),
        fixed_field(2, 2),
        fixed_field(3, 1),
        bytes_field(4, b"rgb8"),
        fixed_field(5, 6),
        bytes_field(6, RGB),
    ]
    .concat();
    let json = br#"{"timestamp":{"sec":5,"nsec":7},"frame_id":"camera","width":2,"height":1,"encoding":"rgb8","step":6,"data":"AQIDBAUG"}"#;
    let mut cdr = Vec::new();
    let mut to = Encoder::new(&mut cdr);
    put_header(&mut to, STAMP_NS, "camera");
    2_u32.put(&mut to);
    1_u32.put(&mut to);
    to.string("rgb8");
    6_u32.put(&mut to);
    to.byte_count(RGB.len());
    to.raw(RGB);
    for (kind, message) in [
        (["protobuf", "foxglove.RawImage", "protobuf"], &protobuf[..]),
        (["json", "foxglove.RawImage", "jsonschema"], json),
        (["cdr", "foxglove_msgs/msg/RawImage", "ros2msg"], &cdr),
    ] {
        let mut made = Made::new(None);
        made.encoded("/camera", kind, 9, message);
        let (header, pixels) = of(made.finish()).unwrap();
        assert_eq!(
            (header.width, header.height, header.stride),
            (2, 1, 6),
            "{kind:?}"
        );
        assert_eq!(header.format(), Some(PixelFormat::Rgb8));
        assert_eq!(header.trace.exposed_ns, STAMP_NS);
        assert_eq!(pixels, format!("{:?}", Pixels::Raw(RGB)));
        // A message cut off anywhere is refused without a panic.
        for end in 0..message.len() {
            let mut made = Made::new(None);
            made.encoded("/camera", kind, 9, &message[..end]);
            assert!(of(made.finish()).is_err(), "{kind:?} cut at {end}");
        }
    }
}

#[test]
fn foxgloves_and_ros1s_picture_files_are_read() {
    let protobuf = [
        bytes_field(1, STAMP),
        bytes_field(2, JPEG),
        bytes_field(3, b"jpeg"),
    ]
    .concat();
    let json = br#"{"timestamp":{"sec":5,"nsec":7},"frame_id":"","data":"\/9j\/4CBhbmQgc28gb24=","format":"jpeg"}"#;
    let mut ros1 = Vec::new();
    for number in [1_u32, 5, 7, 0, 4] {
        ros1.extend(number.to_le_bytes());
    }
    ros1.extend(b"jpeg");
    ros1.extend((JPEG.len() as u32).to_le_bytes());
    ros1.extend(JPEG);
    for (kind, message) in [
        (
            ["protobuf", "foxglove.CompressedImage", "protobuf"],
            &protobuf[..],
        ),
        (["json", "foxglove.CompressedImage", "jsonschema"], json),
        (["ros1", "sensor_msgs/CompressedImage", "ros1msg"], &ros1),
    ] {
        let mut made = Made::new(None);
        made.encoded("/camera", kind, 9, message);
        let (header, pixels) = of(made.finish()).unwrap();
        assert_eq!(header.trace.exposed_ns, STAMP_NS, "{kind:?}");
        assert_eq!(pixels, format!("{:?}", Pixels::Jpeg(JPEG)), "{kind:?}");
    }
}

#[test]
fn the_bytes_of_a_picture_file_tell_its_kind() {
    for (format, file, right) in [
        ("", PNG, Pixels::Png(PNG)),
        ("", JPEG, Pixels::Jpeg(JPEG)),
        ("jpeg", PNG, Pixels::Png(PNG)),
        ("webp", WEBP, Pixels::Other(WEBP)),
        ("", WEBP, Pixels::Other(WEBP)),
        ("rgb8; jpeg compressed bgr8", b"JPEG", Pixels::Jpeg(b"JPEG")),
    ] {
        let mut made = Made::new(None);
        made.picture("/camera", 1, format, file);
        assert_eq!(
            of(made.finish()).unwrap().1,
            format!("{right:?}"),
            "{format}"
        );
    }
    let mut made = Made::new(None);
    made.picture("/camera", 1, "h264", b"\0\0\0\x01video");
    let refused = of(made.finish()).unwrap_err().to_string();
    assert!(
        refused.contains("\"h264\"") && refused.contains("nv21"),
        "{refused}"
    );
}

#[test]
fn a_depth_image_of_image_transport_is_called_one() {
    let depth = [&[0; 12][..], PNG].concat();
    let made = |topics: &[&str]| {
        let mut made = Made::new(None);
        for topic in topics {
            made.picture(topic, 1, "16UC1; compressedDepth png", &depth);
        }
        made.picture("/color/compressed", 1, "jpeg", JPEG);
        made.finish()
    };
    let refused = of(made(&["/a/depth"])).unwrap_err().to_string();
    assert!(refused.contains("/a/depth are depth images"), "{refused}");
    // A topic with the usual name for depth images is not a camera unless requested.
    let recording = Recording::from_bytes(made(&["/a/compressedDepth"])).unwrap();
    assert_eq!(recording.cameras(), ["/color/compressed"]);
    assert_eq!(
        first(&recording).unwrap().1,
        format!("{:?}", Pixels::Jpeg(JPEG))
    );
    let file = tempfile::NamedTempFile::new().unwrap();
    fs::write(file.path(), made(&["/a/compressedDepth"])).unwrap();
    let recording = Recording::open_topic(file.path(), Some("/a/compressedDepth")).unwrap();
    let refused = first(&recording).unwrap_err().to_string();
    assert!(refused.contains("are depth images"), "{refused}");
}

/// A file of a bag, with frames of these numbers.
fn part(numbers: std::ops::Range<u64>, before: &[&str]) -> Vec<u8> {
    let mut made = Made::new(None);
    for topic in before {
        made.picture(topic, numbers.start, "jpeg", JPEG);
    }
    for number in numbers {
        made.image(
            "/camera",
            number,
            &made::header(number),
            &made::pixels(number),
        );
    }
    made.finish()
}

/// First bytes of all frames.
fn shown(recording: &Recording, span: Span) -> Vec<(u64, u8)> {
    let mut messages = recording.messages(span).unwrap();
    let mut shown = Vec::new();
    while let Some(entry) = messages.next().unwrap() {
        if let Entry::Frame(frame) = entry
            && let Pixels::Raw(bytes) = frame.pixels
        {
            shown.push((frame.header.trace.sequence, bytes[0]));
        }
    }
    shown
}

fn bag(folder: &Path) {
    fs::write(folder.join("x_0.mcap"), part(0..3, &[])).unwrap();
    // In this file, the topic has another channel number.
    fs::write(folder.join("x_1.mcap"), part(3..5, &["/a", "/b"])).unwrap();
    let packed = zstd::encode_all(&part(5..7, &[])[..], 1).unwrap();
    fs::write(folder.join("x_2.mcap.zstd"), packed).unwrap();
    let metadata = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - x_0.mcap\n    - x_1.mcap\n    - x_2.mcap.zstd\n";
    fs::write(folder.join("metadata.yaml"), metadata).unwrap();
}

#[test]
fn the_folder_of_a_bag_is_one_recording() {
    let folder = tempfile::TempDir::new().unwrap();
    bag(folder.path());
    let recording = Recording::open_topic(folder.path(), Some("/camera")).unwrap();
    let first = |number: u64| made::pixels(number)[0];
    let right: Vec<_> = (0..7).map(|number| (number + 1, first(number))).collect();
    assert_eq!(shown(&recording, Span::default()), right);
    assert_eq!(recording.frames().unwrap(), 7);
    assert_eq!(recording.times_ns(), (0, 6));
    assert_eq!(recording.cut_off(), None);
    let span = Span {
        from: Some(Place::Frame(3)),
        to: Some(Place::Frame(6)),
    };
    assert_eq!(shown(&recording, span), right[2..5]);
    let topics = recording.topics().unwrap();
    let camera = topics.iter().find(|topic| topic.name == "/camera").unwrap();
    assert_eq!(camera.messages, 7);
}

#[test]
fn a_missing_or_damaged_file_of_a_bag_is_named_and_the_others_are_read() {
    let folder = tempfile::TempDir::new().unwrap();
    bag(folder.path());
    fs::remove_file(folder.path().join("x_1.mcap")).unwrap();
    fs::write(folder.path().join("x_2.mcap.zstd"), b"nothing").unwrap();
    let recording = Recording::open(folder.path()).unwrap();
    assert_eq!(shown(&recording, Span::default()).len(), 3);
    let notes = recording.cut_off().expect("files are missing");
    assert!(
        notes.contains("x_1.mcap, which metadata.yaml names, is missing"),
        "{notes}"
    );
    assert!(notes.contains("x_2.mcap.zstd is not read"), "{notes}");
}

#[test]
fn a_file_that_was_compressed_as_a_whole_is_read_up_to_where_it_is_cut_off() {
    // The chunks are larger than zstd's block of 128 KiB, so that the first chunk is complete
    // without the second.
    let mut made = Made::new(None);
    for number in 0..3000 {
        made.image(
            "/camera",
            number,
            &made::header(number),
            &made::pixels(number),
        );
        if number == 1499 {
            made.end_chunk();
        }
    }
    let packed = zstd::encode_all(&made.finish()[..], 1).unwrap();
    let file = tempfile::Builder::new()
        .suffix(".mcap.zstd")
        .tempfile()
        .unwrap();
    fs::write(file.path(), &packed).unwrap();
    let recording = Recording::open(file.path()).unwrap();
    assert_eq!(
        (recording.frames().unwrap(), recording.cut_off()),
        (3000, None)
    );
    fs::write(file.path(), &packed[..packed.len() * 9 / 10]).unwrap();
    let recording = Recording::open(file.path()).unwrap();
    assert_eq!(recording.frames().unwrap(), 1500);
    assert!(
        recording
            .cut_off()
            .is_some_and(|note| note.contains("was not closed"))
    );
    fs::write(file.path(), &packed[..20]).unwrap();
    let refused = Recording::open(file.path()).err().unwrap().to_string();
    assert!(refused.contains("compressed as a whole"), "{refused}");
}

#[test]
fn recordings_of_other_formats_are_refused_with_the_way_to_convert_them() {
    for (bytes, words) in [
        (&b"SQLite format 3\0 and so on"[..], "mcap convert"),
        (b"#ROSBAG V2.0\n and so on", "rosbags-convert"),
    ] {
        let refused = Recording::from_bytes(bytes.to_vec())
            .err()
            .unwrap()
            .to_string();
        assert!(refused.contains(words), "{refused}");
    }
    let folder = tempfile::TempDir::new().unwrap();
    let refused = Recording::open(folder.path()).err().unwrap().to_string();
    assert!(refused.contains("holds no MCAP file"), "{refused}");
    fs::write(folder.path().join("x_0.db3"), b"SQLite format 3\0").unwrap();
    let refused = Recording::open(folder.path()).err().unwrap().to_string();
    assert!(refused.contains("mcap convert"), "{refused}");
}

#[test]
fn images_of_encodings_that_no_frame_has_are_converted() {
    // Two pixels as `sensor_msgs/Image`.
    let with = |encoding: &str, step: u32, data: &[u8]| {
        let mut cdr = Vec::new();
        let mut to = Encoder::new(&mut cdr);
        put_header(&mut to, 1, "camera");
        1_u32.put(&mut to);
        2_u32.put(&mut to);
        to.string(encoding);
        0_u8.put(&mut to);
        step.put(&mut to);
        to.byte_count(data.len());
        to.raw(data);
        let mut made = Made::new(None);
        made.raw("/camera", &lariat_record::IMAGE, 1, &cdr);
        of(made.finish())
    };
    let (header, pixels) = with("rgba8", 8, &[1, 2, 3, 255, 4, 5, 6, 0]).unwrap();
    assert_eq!(
        (header.format(), header.stride),
        (Some(PixelFormat::Rgb8), 6)
    );
    assert_eq!(pixels, format!("{:?}", Pixels::Raw(RGB)));
    let (header, _) = with("32FC1", 8, &[0; 8]).unwrap();
    assert_eq!(header.format(), Some(PixelFormat::Gray16));
    let refused = with("rgba8", 8, &[0; 7]).unwrap_err().to_string();
    assert!(refused.contains("not of the size"), "{refused}");
    let refused = with("yuv444", 6, &[0; 6]).unwrap_err().to_string();
    assert!(
        refused.contains("\"yuv444\": lariat reads mono8"),
        "{refused}"
    );
}
