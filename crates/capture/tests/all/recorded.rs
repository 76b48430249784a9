//! Recordings as frames: they are shown with their gaps, times and truth.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::num::NonZeroU64;
use std::path::Path;
use std::time::Duration;

use image::{ImageFormat, Rgb, RgbImage};
use lariat_capture::{
    FileOptions, Frame, FrameSource, Position, Range, RenderOptions, Source, SourceError,
    names_a_recording, open,
};
use lariat_message::{Centerlines, FrameHeader, PixelFormat, SourceKind, Trace};
use lariat_record::{
    Compression, Existing, Head, Record, Topic, Writer, encode_compressed_image, encode_image,
};
use tempfile::TempDir;

/// Offset of log times from a trace's times.
const OFFSET_NS: u64 = 1_700_000_000_000_000_000;
const RIG: &str = "table";

type Opened = Result<Box<dyn FrameSource>, SourceError>;

/// A recording being written.
struct Made {
    writer: Writer,
    cdr: Vec<u8>,
}

impl Made {
    fn new(path: &Path, compression: Compression) -> Self {
        let about = [
            ("version".to_owned(), "0.1.0".to_owned()),
            ("monotonic_to_wall_ns".to_owned(), OFFSET_NS.to_string()),
        ];
        let head = Head {
            rig: RIG.to_owned(),
            about: BTreeMap::from(about),
        };
        let writer = Writer::create(path, Existing::Replace, &head, compression).unwrap();
        Self {
            writer,
            cdr: Vec::new(),
        }
    }

    fn message<R: Record>(&mut self, topic: Topic, trace: &Trace, message: &R) {
        message.encode(&mut self.cdr);
        let log_ns = OFFSET_NS + trace.captured_ns;
        self.writer
            .write(topic, trace.sequence as u32, log_ns, &self.cdr)
            .unwrap();
    }

    /// Writes a frame whose bytes are `grey`.
    fn frame(&mut self, header: &FrameHeader, grey: u8) {
        let trace = &header.trace;
        self.message(Topic::Frames, trace, header);
        let log_ns = OFFSET_NS + trace.captured_ns;
        let bytes = vec![grey; header.image_bytes().unwrap_or(0)];
        if encode_image(header, &bytes, log_ns, RIG, &mut self.cdr) {
            self.writer
                .write(Topic::Image, trace.sequence as u32, log_ns, &self.cdr)
                .unwrap();
        }
    }

    fn truth(&mut self, header: &FrameHeader) {
        let truth = Centerlines {
            trace: header.trace,
            width: header.width,
            count: header.trace.sequence as u32 % 8,
            ..Centerlines::EMPTY
        };
        self.message(Topic::Truth, &header.trace, &truth);
    }
}

/// The header of a frame of 8 × 4 pixels, taken at `at_ms`.
fn header(sequence: u64, at_ms: u64) -> FrameHeader {
    let exposed_ns = 1_000_000 * (1000 + at_ms);
    FrameHeader {
        trace: Trace {
            sequence,
            captured: sequence,
            exposed_ns,
            captured_ns: exposed_ns + 300_000,
            ..Trace::EMPTY
        },
        width: 8,
        height: 4,
        stride: 24,
        pixel_format: PixelFormat::Bgr8 as u32,
        source: SourceKind::Camera as u32,
        reserved: [0; 3],
    }
}

/// Frames 5 to 16 of a camera, without 8 and 9, 10 ms apart except for a late one; 12 is blank.
fn made(compression: Compression) -> (TempDir, std::path::PathBuf) {
    let folder = TempDir::new().expect("the system has a folder for temporary files");
    let path = folder.path().join("recording.mcap");
    let mut made = Made::new(&path, compression);
    for sequence in (5..=16).filter(|sequence| ![8, 9].contains(sequence)) {
        let late_ms = if sequence == 7 { 3 } else { 0 };
        let mut header = header(sequence, 10 * sequence + late_ms);
        if sequence == 12 {
            (header.width, header.height) = (0, 0);
        }
        made.frame(&header, sequence as u8);
    }
    made.writer.finish().unwrap();
    (folder, path)
}

fn open_range(path: &Path, range: Range, looped: bool) -> Opened {
    let options = FileOptions {
        range,
        looped,
        ..FileOptions::default()
    };
    open(&Source::named(&[path], options, RenderOptions::default()))
}

fn open_whole(path: &Path) -> Box<dyn FrameSource> {
    open_range(path, Range::default(), false).unwrap()
}

/// The next frame, its first byte (0 if it is blank), and when it is due after the first, in ms.
fn next(source: &mut dyn FrameSource) -> Option<(Frame, u8, u64)> {
    let frame = source.next().unwrap()?;
    let mut pixels = vec![0; frame.bytes()];
    source.write(&mut pixels);
    assert!(pixels.iter().all(|&byte| byte == pixels[0]));
    let due_ns = source.due_after_ns().expect("it has a pace of its own");
    Some((
        frame,
        pixels.first().copied().unwrap_or(0),
        due_ns / 1_000_000,
    ))
}

/// Sequence number, first byte and due time of the next frames.
fn shown(source: &mut dyn FrameSource, most: usize) -> Vec<(u64, u8, u64)> {
    std::iter::from_fn(|| next(source))
        .take(most)
        .map(|(frame, grey, due_ms)| (frame.sequence, grey, due_ms))
        .collect()
}

const ALL: [(u64, u8, u64); 10] = [
    (1, 5, 0),
    (2, 6, 10),
    (3, 7, 23),
    (6, 10, 50),
    (7, 11, 60),
    (8, 0, 70),
    (9, 13, 80),
    (10, 14, 90),
    (11, 15, 100),
    (12, 16, 110),
];

#[test]
fn frames_come_as_they_came_with_gaps_times_and_blanks() {
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        let (_folder, path) = made(compression);
        let mut source = open_whole(&path);
        assert_eq!(source.kind(), SourceKind::Camera);
        assert!(!source.has_truth());
        let (first, grey, due_ms) = next(&mut *source).unwrap();
        let expected = Frame {
            sequence: 1,
            width: 8,
            height: 4,
            stride: 24,
            format: PixelFormat::Bgr8,
            exposed_ns: None,
            slot: None,
        };
        assert_eq!((first, grey, due_ms), (expected, 5, 0));
        assert_eq!(shown(&mut *source, 99), ALL[1..]);
        assert_eq!(source.take_warning(), None);
    }
}

#[test]
fn a_part_begins_at_1_and_every_third_is_of_the_cameras_frames() {
    let (_folder, path) = made(Compression::None);
    let range = |from, to, every| Range {
        from,
        to,
        every: NonZeroU64::new(every).expect("not 0"),
    };
    let frame = |number| Some(Position::Frame(number));
    // Numbers count the ten frames that exist.
    let mut source = open_range(&path, range(frame(3), frame(5), 1), false).unwrap();
    assert_eq!(
        shown(&mut *source, 99),
        [(1, 7, 0), (4, 10, 27), (5, 11, 37)]
    );
    let time = |ms| Some(Position::Time(Duration::from_millis(ms)));
    let mut source = open_range(&path, range(time(80), time(100), 1), false).unwrap();
    assert_eq!(shown(&mut *source, 99), [(1, 13, 0), (2, 14, 10)]);
    // 5, 8 (lost), 11, 14.
    let mut source = open_range(&path, range(None, None, 3), false).unwrap();
    assert_eq!(
        shown(&mut *source, 99),
        [(1, 5, 0), (3, 11, 60), (4, 14, 90)]
    );
    let said = open_range(&path, range(frame(11), None, 1), false)
        .err()
        .unwrap()
        .to_string();
    assert!(
        said.contains("frame 11") && said.contains("holds 10"),
        "{said}"
    );
    let said = open_range(&path, range(frame(4), frame(3), 1), false)
        .err()
        .unwrap()
        .to_string();
    assert!(said.contains("choose a range"), "{said}");
}

#[test]
fn a_loop_goes_on_in_number_and_time() {
    let (_folder, path) = made(Compression::Lz4);
    let range = Range {
        from: Some(Position::Frame(8)),
        ..Range::default()
    };
    let mut source = open_range(&path, range, true).unwrap();
    let expected = [
        (1, 14, 0),
        (2, 15, 10),
        (3, 16, 20),
        (4, 14, 30),
        (5, 15, 40),
        (6, 16, 50),
        (7, 14, 60),
    ];
    assert_eq!(shown(&mut *source, 7), expected);
}

#[test]
fn a_loop_that_is_too_large_to_keep_is_read_again() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("large.mcap");
    let mut made = Made::new(&path, Compression::None);
    for sequence in 1..=3 {
        let header = FrameHeader {
            width: 4000,
            height: 2000,
            stride: 12_000,
            ..header(sequence, 10 * sequence)
        };
        made.frame(&header, sequence as u8);
        made.truth(&header);
    }
    made.writer.finish().unwrap();
    let mut source = open_range(&path, Range::default(), true).unwrap();
    let mut truth = Box::new(Centerlines::EMPTY);
    for round in 0..3 {
        for number in 1..=3 {
            let (frame, grey, due_ms) = next(&mut *source).unwrap();
            let sequence = 3 * round + number;
            assert_eq!((frame.sequence, u64::from(grey)), (sequence, number));
            assert_eq!(due_ms, 10 * (sequence - 1));
            assert!(source.truth(&mut truth));
            assert_eq!(u64::from(truth.count), number);
        }
    }
}

#[test]
fn the_truth_comes_with_its_frame_wherever_it_stands() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("true.mcap");
    let mut made = Made::new(&path, Compression::None);
    let headers: Vec<_> = (1..=9)
        .map(|sequence| header(sequence, 10 * sequence))
        .collect();
    made.truth(&headers[0]);
    for three in headers.chunks(3) {
        three
            .iter()
            .for_each(|header| made.frame(header, header.trace.sequence as u8));
        // The truth of frame 5 was dropped; that of frame 1 comes before it.
        let known = three
            .iter()
            .filter(|header| ![1, 5].contains(&header.trace.sequence));
        known.for_each(|header| made.truth(header));
    }
    made.writer.finish().unwrap();
    let mut source = open_whole(&path);
    assert!(source.has_truth());
    for sequence in 1..=9 {
        let (frame, grey, _) = next(&mut *source).unwrap();
        assert_eq!((frame.sequence, u64::from(grey)), (sequence, sequence));
        let mut truth = Box::new(Centerlines::EMPTY);
        truth.trace.captured = 77;
        assert_eq!(source.truth(&mut truth), sequence != 5);
        assert_eq!(truth.trace.captured, 77, "the trace is the sender's");
        if sequence != 5 {
            assert_eq!((u64::from(truth.count), truth.width), (sequence % 8, 8));
        }
    }
    assert_eq!(source.next().unwrap(), None);
}

#[test]
fn a_count_or_a_clock_that_restarts_or_jumps_continues_by_a_period_and_says_so() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("again.mcap");
    let mut made = Made::new(&path, Compression::None);
    let frames = [
        (5, 50),
        (6, 60),
        (1, 10),
        (2, 20),
        (u64::MAX, 1 << 43),
        (u64::MAX, 30),
    ];
    for (sequence, at_ms) in frames {
        made.frame(&header(sequence, at_ms), 7);
    }
    made.writer.finish().unwrap();
    let expected = [(1, 0), (2, 10), (3, 20), (4, 30), (5, 40), (6, 50)];
    let mut source = open_whole(&path);
    let shown = shown(&mut *source, 99);
    let shown: Vec<_> = shown.iter().map(|frame| (frame.0, frame.2)).collect();
    assert_eq!(shown, expected);
    let news: Vec<String> = std::iter::from_fn(|| source.take_news()).collect();
    assert_eq!(news.len(), 2, "{news:?}");
    assert!(news[0].contains("frame 3 is stamped before the one before it"));
    assert!(news[1].contains("frame 5 is stamped"));
}

#[test]
fn room_is_made_for_the_largest_of_images_of_many_sizes() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("sizes.mcap");
    let mut made = Made::new(&path, Compression::Lz4);
    let sizes = [(8, 4), (700, 500), (90, 80)];
    for (sequence, (width, height)) in (1..).zip(sizes) {
        let header = FrameHeader {
            width,
            height,
            stride: 3 * width,
            ..header(sequence, 10 * sequence)
        };
        made.frame(&header, sequence as u8);
    }
    made.writer.finish().unwrap();
    let mut source = open_whole(&path);
    assert_eq!(source.largest_frame_bytes(), 3 * 700 * 500);
    for size in sizes {
        let (frame, _, _) = next(&mut *source).unwrap();
        assert_eq!((frame.width, frame.height), size);
    }
}

#[test]
fn pictures_in_a_recording_are_decoded_and_a_broken_one_is_lost() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("pictures.mcap");
    let mut made = Made::new(&path, Compression::None);
    for sequence in 1..=4 {
        let header = header(sequence, 10 * sequence);
        made.message(Topic::Frames, &header.trace, &header);
        let mut file = Vec::new();
        let format = if sequence % 2 == 0 {
            ImageFormat::Png
        } else {
            ImageFormat::Jpeg
        };
        RgbImage::from_pixel(8, 4, Rgb([10 * sequence as u8; 3]))
            .write_to(&mut Cursor::new(&mut file), format)
            .unwrap();
        if sequence == 2 {
            file.truncate(50);
        }
        let log_ns = OFFSET_NS + header.trace.captured_ns;
        let name = if sequence % 2 == 0 { "png" } else { "jpeg" };
        encode_compressed_image(&file, name, log_ns, RIG, &mut made.cdr);
        made.writer
            .write(Topic::Picture, sequence as u32, log_ns, &made.cdr)
            .unwrap();
    }
    made.writer.finish().unwrap();
    let mut source = open_whole(&path);
    assert_eq!(source.largest_frame_bytes(), 96);
    assert_eq!(
        shown(&mut *source, 99),
        [(1, 10, 0), (3, 30, 20), (4, 40, 30)]
    );
    let said = source.take_warning().expect("it is said");
    assert!(said.contains("picture of frame 2"), "{said}");
}

#[test]
fn a_picture_is_decoded_by_its_bytes_whatever_its_format_says() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("pictures.mcap");
    let mut made = Made::new(&path, Compression::None);
    let kinds = [ImageFormat::WebP, ImageFormat::Png, ImageFormat::Jpeg];
    for (sequence, kind) in (1..).zip(kinds) {
        let header = header(sequence, 10 * sequence);
        made.message(Topic::Frames, &header.trace, &header);
        let mut file = Vec::new();
        RgbImage::from_pixel(8, 4, Rgb([10 * sequence as u8; 3]))
            .write_to(&mut Cursor::new(&mut file), kind)
            .unwrap();
        let log_ns = OFFSET_NS + header.trace.captured_ns;
        encode_compressed_image(&file, "", log_ns, RIG, &mut made.cdr);
        (made.writer)
            .write(Topic::Picture, sequence as u32, log_ns, &made.cdr)
            .unwrap();
    }
    made.writer.finish().unwrap();
    let right = [(1, 10, 0), (2, 20, 10), (3, 30, 20)];
    assert_eq!(shown(&mut *open_whole(&path), 99), right);
}

#[test]
fn the_folder_of_a_bag_is_one_source() {
    let folder = TempDir::new().unwrap();
    for (number, sequences) in [(0, 1..=3), (1, 4..=5)] {
        let path = folder.path().join(format!("x_{number}.mcap"));
        let mut made = Made::new(&path, Compression::Zstd);
        for sequence in sequences {
            made.frame(&header(sequence, 10 * sequence), sequence as u8);
        }
        made.writer.finish().unwrap();
    }
    let right = [(1, 1, 0), (2, 2, 10), (3, 3, 20), (4, 4, 30), (5, 5, 40)];
    assert_eq!(shown(&mut *open_whole(folder.path()), 99), right);
    // Recordings among pictures are ignored, like other files.
    RgbImage::new(8, 4)
        .save(folder.path().join("a.png"))
        .unwrap();
    assert!(!names_a_recording(folder.path()));
    std::fs::write(folder.path().join("metadata.yaml"), "").unwrap();
    assert!(names_a_recording(folder.path()));
}

#[test]
fn what_was_cut_off_is_shown_up_to_there_and_said() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("cut.mcap");
    let mut made = Made::new(&path, Compression::Lz4);
    for sequence in 1..=2000 {
        let header = FrameHeader {
            width: 64,
            height: 64,
            stride: 192,
            ..header(sequence, sequence)
        };
        made.frame(&header, 7);
    }
    made.writer.finish().unwrap();
    let whole = std::fs::read(&path).unwrap();
    std::fs::write(&path, &whole[..whole.len() * 7 / 10]).unwrap();
    let mut source = open_whole(&path);
    let count = shown(&mut *source, 9999).len();
    assert!((500..2000).contains(&count), "{count}");
    let said = source.take_warning().expect("it is said");
    assert!(said.contains("not closed"), "{said}");
}

#[test]
fn what_is_no_recording_or_holds_no_images_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("recording.mcap");
    let refusal = |path: &Path| {
        let said = open_range(path, Range::default(), false).err();
        said.expect("it is refused").to_string()
    };
    assert!(refusal(&path).contains("No such file"));
    std::fs::write(&path, "words").unwrap();
    assert!(refusal(&path).contains("not a recording"));
    let path = folder.path().join("without.mcap");
    let mut made = Made::new(&path, Compression::None);
    let of_frame = header(1, 10);
    made.message(Topic::Frames, &of_frame.trace, &of_frame);
    made.writer.finish().unwrap();
    assert!(refusal(&path).contains("no image"), "{}", refusal(&path));
}
