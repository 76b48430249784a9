use super::*;
use crate::writing::place::Existing;
use crate::writing::writer::Compression;
use crate::{ImageRecord, writing::queue::Outlet};
use lariat_message::{PixelFormat, Trace};

pub(super) fn head() -> Head {
    Head {
        rig: "left".into(),
        about: BTreeMap::new(),
    }
}

pub(super) fn options(queue_bytes: usize, waits: bool) -> Options {
    Options {
        images: Images::Raw,
        queue_bytes,
        waits,
        clock: Clock {
            monotonic_to_wall_ns: 1_000_000,
        },
    }
}

/// A recorder whose messages wait until the returned sender is used.
fn stalled(queue_bytes: usize) -> (Recorder, std::sync::mpsc::Sender<()>) {
    let (intake, outlet) = queue(queue_bytes, queue_bytes / 8);
    let (release, wait) = std::sync::mpsc::channel();
    let thread = std::thread::spawn(move || {
        let _ = wait.recv();
        drain(&outlet);
        Ending {
            written: Written::default(),
            fault: None,
        }
    });
    let recorder = Recorder::new(intake, thread, &head(), options(queue_bytes, false));
    (recorder, release)
}

fn drain(outlet: &Outlet) {
    while let Ok(item) = outlet.next(None) {
        if let Item::Message(parcel) = item {
            outlet.give_back(parcel.cdr);
        }
    }
}

/// Returns the buffers of all waiting messages.
pub(super) fn drain_waiting(outlet: &Outlet) {
    while outlet.has_more() {
        if let Ok(Item::Message(parcel)) = outlet.next(None) {
            outlet.give_back(parcel.cdr);
        }
    }
}

pub(super) fn header(count: u64) -> FrameHeader {
    FrameHeader {
        trace: Trace {
            sequence: 10 + count,
            captured: count,
            exposed_ns: 2000 * count,
            captured_ns: 2000 * count + 7,
            ..Trace::EMPTY
        },
        width: 500,
        height: 400,
        stride: 512,
        pixel_format: PixelFormat::Gray8 as u32,
        source: 1,
        reserved: [0; 3],
    }
}

pub(super) fn centerlines(count: u64) -> Box<Centerlines> {
    let mut seen = Box::new(Centerlines::EMPTY);
    seen.trace = header(count).trace;
    seen.trace.extracted = count;
    seen.trace.extracted_ns = 3000 * count;
    seen.count = 1;
    seen.curves[0].count = 120;
    seen
}

#[test]
fn everything_comes_back_from_the_file_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let writer = Writer::create(&path, Existing::Keep, &head(), Compression::Lz4).unwrap();
    let mut recorder = Recorder::to_file(writer, &head(), options(8 << 20, true)).unwrap();
    let pixels: Vec<u8> = (0..512 * 400).map(|i| (i % 251) as u8).collect();
    let mut shapes = Box::new(Descriptors::EMPTY);
    for count in 1..=50 {
        recorder.frame(&header(count), &pixels).unwrap();
        recorder.centerlines(&centerlines(count)).unwrap();
        recorder.truth(&centerlines(count)).unwrap();
        shapes.trace = centerlines(count).trace;
        shapes.trace.fitted_ns = 4000 * count;
        recorder.descriptors(&shapes, Some).unwrap();
    }
    recorder.losses(&Losses::default()).unwrap();
    assert_eq!(recorder.drops(), Drops::default());
    let ending = recorder.finish();
    assert!(ending.fault.is_none());
    assert_eq!(ending.written.messages.iter().sum::<u64>(), 50 * 7 + 1);
    let bytes = std::fs::read(&path).unwrap();
    let mut seen = Box::new(Centerlines::EMPTY);
    let mut images = 0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let count = u64::from(message.sequence).saturating_sub(10);
        match message.channel.topic.as_str() {
            "/left/image" => {
                let image = ImageRecord::decode(&message.data).unwrap();
                assert!(image.is_whole());
                assert_eq!((image.width, image.height, image.step), (500, 400, 500));
                assert_eq!(&image.data[500..1000], &pixels[512..1012]);
                assert_eq!(image.stamp_ns, 2000 * count + 1_000_000);
                assert_eq!(message.log_time, 2000 * count + 7 + 1_000_000);
                images += 1;
            }
            "/left/centerlines" => {
                seen.decode(&message.data).unwrap();
                assert_eq!(*seen, *centerlines(count));
                assert_eq!(message.log_time, 3000 * count + 1_000_000);
            }
            _ => {}
        }
    }
    assert_eq!(images, 50);
}

#[test]
fn what_finds_no_room_is_dropped_and_counted_and_shapes_find_room_when_images_do_not() {
    // Four images fit next to the part reserved for small messages.
    let (mut recorder, release) = stalled(1_000_000);
    let pixels = vec![0; 512 * 400];
    for count in 1..=10 {
        recorder.frame(&header(count), &pixels).unwrap();
        recorder.centerlines(&centerlines(count)).unwrap();
    }
    assert_eq!(
        recorder.drops(),
        Drops {
            frames: 6,
            ..Drops::default()
        }
    );
    drop(release);
    assert!(recorder.finish().fault.is_none());
}

#[test]
fn what_came_too_late_for_the_recorder_is_counted_from_the_counters() {
    let (mut recorder, release) = stalled(1 << 30);
    let pixels = vec![0; 512 * 400];
    for count in [3, 4, 8, 1, 3] {
        recorder.frame(&header(count), &pixels).unwrap();
    }
    // Nothing is known about the two frames before the first one, and a restarted capture is not a
    // loss.
    assert_eq!(recorder.drops().frames, 3 + 1);
    recorder.begins_with_the_rig();
    recorder.centerlines(&centerlines(3)).unwrap();
    assert_eq!(recorder.drops().centerlines, 2);
    drop(release);
    recorder.finish();
}

#[test]
fn a_recorder_that_waits_drops_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let writer = Writer::create(&path, Existing::Keep, &head(), Compression::Zstd).unwrap();
    let mut recorder = Recorder::to_file(writer, &head(), options(1_000_000, true)).unwrap();
    let pixels = vec![0; 512 * 400];
    for count in 1..=100 {
        recorder.frame(&header(count), &pixels).unwrap();
    }
    assert_eq!(recorder.drops().total(), 0);
    let ending = recorder.finish();
    assert_eq!(ending.written.messages[Topic::Image as usize], 100);
}

#[test]
fn a_blank_frame_is_a_head_without_an_image_and_no_loss() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let writer = Writer::create(&path, Existing::Keep, &head(), Compression::None).unwrap();
    let mut recorder = Recorder::to_file(writer, &head(), options(1_000_000, false)).unwrap();
    let blank = FrameHeader {
        width: 0,
        height: 0,
        ..header(1)
    };
    recorder.frame(&blank, &[]).unwrap();
    assert_eq!(recorder.drops().total(), 0);
    let written = recorder.finish().written;
    assert_eq!(written.messages[Topic::Frames as usize], 1);
    assert_eq!(written.messages[Topic::Image as usize], 0);
}

#[test]
fn a_writer_that_fell_is_noticed_and_nobody_waits_for_it() {
    let (intake, outlet) = queue(1_000_000, 0);
    let thread = std::thread::spawn(move || {
        drop(outlet);
        Ending {
            written: Written::default(),
            fault: Some(WriteError::Fallen),
        }
    });
    let mut recorder = Recorder::new(intake, thread, &head(), options(1_000_000, true));
    let pixels = vec![0; 512 * 400];
    let mut outcome = Ok(());
    for count in 1..=100 {
        outcome = outcome.and(recorder.frame(&header(count), &pixels));
    }
    assert_eq!(outcome, Err(Ended));
    assert!(recorder.finish().fault.is_some());
}
