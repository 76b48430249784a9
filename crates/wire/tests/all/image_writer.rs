//! Users' own frames and masks: their contents, and the cases that are refused.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::time::{Duration, Instant};

use lariat_wire::{
    Delivery, Domain, FRAMES, FrameReader, FrameWriter, MASKS, MaskWriter, PixelFormat, Receiver,
    Rig, Stamp, Waiting, WireError, WriteError, now_ns,
};

/// Name of a domain for one test.
fn name() -> String {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    format!("i{}-{number}", std::process::id())
}

fn domain(name: &str) -> Domain {
    Domain::named(name).expect("a domain")
}

fn writer(name: &str) -> FrameWriter {
    FrameWriter::open_in(domain(name), &Rig::default(), Waiting::default()).expect("a writer")
}

fn reader(name: &str) -> FrameReader {
    FrameReader::open_in(domain(name), &Rig::default(), None).expect("a reader")
}

fn soon() -> Option<Instant> {
    Some(Instant::now() + Duration::from_secs(30))
}

fn exposed(exposed_ns: u64) -> Stamp {
    Stamp {
        exposed_ns: Some(exposed_ns),
        ..Stamp::default()
    }
}

#[test]
fn a_frame_says_what_it_is_when_it_was_taken_and_which_it_is() {
    let name = name();
    let (mut writer, mut reader) = (writer(&name), reader(&name));
    let before_ns = now_ns();
    for (count, sequence) in [(1, None), (2, Some(10)), (3, None)] {
        let pixels = writer.loan(5, 4, PixelFormat::Nv12).unwrap();
        assert_eq!(pixels.len(), 5 * 6);
        pixels.fill(count as u8);
        let stamp = Stamp {
            sequence,
            ..Stamp::default()
        };
        assert!(writer.send(stamp).unwrap());
        let frame = reader.wait(soon()).unwrap().expect("a frame");
        let header = frame.header();
        assert_eq!((header.width, header.height, header.stride), (5, 4, 5));
        assert_eq!(header.format(), Some(PixelFormat::Nv12));
        assert_eq!(header.image_bytes(), Some(30));
        assert_eq!(header.trace.captured, count);
        assert_eq!(header.trace.sequence, [1, 10, 11][count as usize - 1]);
        let stamps = [
            before_ns,
            header.trace.exposed_ns,
            header.trace.captured_ns,
            now_ns(),
        ];
        assert!(stamps.is_sorted(), "{stamps:?}");
        assert_eq!(&frame[..], [count as u8; 30]);
    }
}

#[test]
fn a_camera_without_an_image_sends_a_blank_frame_in_its_turn() {
    let name = name();
    let (mut writer, mut reader) = (writer(&name), reader(&name));
    writer.loan(2, 2, PixelFormat::Gray8).unwrap();
    writer.send(Stamp::default()).unwrap();
    writer.send_blank(Stamp::default()).unwrap();
    let frame = reader.wait(soon()).unwrap().expect("a frame");
    assert!(frame.header().is_blank());
    assert_eq!(
        (frame.header().trace.captured, frame.header().trace.sequence),
        (2, 2)
    );
}

#[test]
fn what_cannot_be_is_refused_and_does_not_count() {
    let name = name();
    let (mut writer, mut reader) = (writer(&name), reader(&name));
    for (width, height) in [(0, 4), (4, 0), (8193, 4), (4, u32::MAX)] {
        let refused = writer.loan(width, height, PixelFormat::Rgb8);
        assert!(matches!(refused, Err(WriteError::Size { .. })));
    }
    assert!(matches!(
        writer.send(Stamp::default()),
        Err(WriteError::NothingOnLoan)
    ));
    let taken_ns = now_ns();
    let mut send = |stamp| {
        writer.loan(4, 4, PixelFormat::Gray8).unwrap();
        writer.send(stamp)
    };
    assert!(send(exposed(taken_ns)).unwrap());
    for again in [taken_ns, taken_ns - 1] {
        let refused = send(exposed(again));
        assert!(matches!(refused, Err(WriteError::Backwards { .. })));
    }
    // Like `time.time_ns()`, which counts from 1970.
    let refused = send(exposed(now_ns() + 1_000_000_000_000));
    assert!(refused.unwrap_err().to_string().contains("CLOCK_MONOTONIC"));
    for sequence in [0, 1] {
        let refused = send(Stamp {
            sequence: Some(sequence),
            ..Stamp::default()
        });
        assert!(matches!(refused, Err(WriteError::Sequence { .. })));
    }
    assert!(send(Stamp::default()).unwrap());
    let frame = reader.wait(soon()).unwrap().expect("a frame");
    assert_eq!(frame.header().trace.captured, 2);
}

#[test]
fn slots_grow_with_the_frames_and_readers_stay() {
    let name = name();
    let (mut writer, mut reader) = (writer(&name), reader(&name));
    for side in [8, 64, 16, 200] {
        let had_room = writer.has_room(200 * 200);
        assert!(!had_room);
        writer
            .loan(side, side, PixelFormat::Gray8)
            .unwrap()
            .fill(side as u8);
        writer.send(Stamp::default()).unwrap();
        let frame = reader.wait(soon()).unwrap().expect("a frame");
        assert_eq!(frame.header().width, side);
        assert!(frame.iter().all(|&byte| byte == side as u8));
    }
    assert!(writer.has_room(200 * 200));
}

#[test]
fn a_rig_has_one_writer_of_frames_from_the_moment_it_is_opened() {
    let name = name();
    let first = writer(&name);
    let open = || FrameWriter::open_in(domain(&name), &Rig::default(), Waiting::default());
    let said = open().expect_err("there is one").to_string();
    assert!(said.contains("--source external"), "{said}");
    drop(first);
    open().expect("there is none any more");
}

#[test]
fn a_writer_goes_by_the_chain_that_runs_and_says_so_when_asked_for_the_other() {
    let name = name();
    let rig = Rig::default();
    let delivery = Delivery::Lossless {
        stop: Arc::default(),
    };
    let _extract = Receiver::create(&domain(&name), &rig, &FRAMES, Some(&delivery)).unwrap();
    assert!(writer(&name).is_lossless());
    assert!(reader(&name).is_lossless());
    let refused = FrameWriter::open_in(
        domain(&name),
        &rig,
        Waiting {
            lossless: Some(false),
            ..Waiting::default()
        },
    );
    assert!(matches!(
        refused,
        Err(WriteError::Wire(WireError::Delivery { .. }))
    ));
}

#[test]
fn a_lossless_writer_that_is_told_to_stop_meanwhile_loses_its_frame_and_says_so() {
    let name = name();
    let stop = Arc::new(AtomicBool::new(false));
    let looks = Arc::new(AtomicU32::new(0));
    let meanwhile = {
        let (stop, looks) = (stop.clone(), looks.clone());
        move || {
            looks.fetch_add(1, Ordering::Relaxed);
            stop.store(true, Ordering::Relaxed);
        }
    };
    let waiting = Waiting {
        lossless: Some(true),
        stop,
        meanwhile: Some(Arc::new(meanwhile)),
    };
    let mut writer = FrameWriter::open_in(domain(&name), &Rig::default(), waiting).unwrap();
    writer.loan(2, 2, PixelFormat::Gray8).unwrap();
    // The reader connects with its first call and then reads no more, so only three frames fit its
    // buffer.
    let mut reader = reader(&name);
    assert!(reader.try_next().unwrap().is_none());
    let send = |writer: &mut FrameWriter| {
        writer.loan(2, 2, PixelFormat::Gray8).unwrap();
        writer.send(Stamp::default()).unwrap()
    };
    let sent = (0..10).take_while(|_| send(&mut writer)).count();
    assert!(sent == 3 && looks.load(Ordering::Relaxed) > 0, "{sent}");
    // The writer does not wait for a reader that has left.
    assert_eq!(
        reader.try_next().unwrap().unwrap().header().trace.captured,
        1,
        "in order"
    );
    drop(reader);
    assert!(send(&mut writer));
}

#[test]
fn a_mask_has_its_frames_size_and_way() {
    let name = name();
    let rig = Rig::default();
    let (mut writer, mut frames) = (writer(&name), reader(&name));
    let mut masks = MaskWriter::open_in(domain(&name), &rig, Waiting::default()).unwrap();
    let extract = Receiver::create(&domain(&name), &rig, &MASKS, None).unwrap();
    for (width, height) in [(4, 3), (40, 30)] {
        writer.loan(width, height, PixelFormat::Bgr8).unwrap();
        writer.send(Stamp::default()).unwrap();
        let frame = frames.wait(soon()).unwrap().expect("a frame");
        masks.loan(frame.header()).unwrap().fill(255);
        masks.send().unwrap();
        let mask = extract.latest().unwrap().expect("a mask");
        assert_eq!(*mask.header(), frame.header().of_mask());
        assert_eq!(mask.len(), (width * height) as usize);
        assert!(mask.iter().all(|&byte| byte == 255));
    }
    writer.send_blank(Stamp::default()).unwrap();
    let blank = frames.wait(soon()).unwrap().expect("a frame");
    assert!(matches!(
        masks.loan(blank.header()),
        Err(WriteError::NoImage)
    ));
    assert!(matches!(masks.send(), Err(WriteError::NothingOnLoan)));
}
