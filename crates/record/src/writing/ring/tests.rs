use super::*;
use crate::writing::queue::{Intake, queue};
use crate::writing::topic::Topic;
use crate::writing::writer::Compression;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

const S: u64 = 1_000_000_000;

fn parcel(number: u64, bytes: usize) -> Parcel {
    Parcel {
        topic: Topic::Losses,
        sequence: number as u32,
        log_ns: number * S,
        cdr: vec![number as u8; bytes],
        is_pooled: true,
    }
}

/// Starts a ring with this time span and memory in a thread. Also returns its reports.
fn ring(seconds: u64, bytes: usize) -> (Intake, JoinHandle<Ending>, Arc<Mutex<Vec<Flushed>>>) {
    let (intake, outlet) = queue(bytes + (1 << 20), 0);
    let reports = Arc::<Mutex<Vec<Flushed>>>::default();
    let told = reports.clone();
    let options = RingOptions {
        time: Duration::from_secs(seconds),
        bytes,
        compression: Compression::Lz4,
        report: Box::new(move |flushed| told.lock().unwrap().push(flushed)),
    };
    let head = Head {
        rig: "left".into(),
        about: Default::default(),
    };
    let thread = std::thread::spawn(move || keep(options, head, outlet, Images::Raw));
    (intake, thread, reports)
}

fn sequences(path: &std::path::Path) -> Vec<u32> {
    let bytes = std::fs::read(path).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap();
    messages.map(|message| message.unwrap().sequence).collect()
}

#[test]
fn the_last_seconds_are_written_when_asked_for_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (mut intake, thread, reports) = ring(10, 1 << 20);
    let order = |order| Item::Order(Box::new(order));
    let attach = Order::Attach {
        name: "lariat.toml".into(),
        media_type: "application/toml",
        log_ns: 0,
        bytes: b"[fit]".into(),
    };
    intake.send_waiting(order(attach)).unwrap();
    let paths = ["a.mcap", "b.mcap"].map(|name| folder.path().join(name));
    for number in 0..50 {
        intake
            .send_waiting(Item::Message(parcel(number, 100)))
            .unwrap();
        if number == 24 {
            let flush = Order::Flush(paths[0].clone());
            intake.send_waiting(order(flush)).unwrap();
        }
    }
    let flush = Order::Flush(paths[1].clone());
    intake.send_waiting(order(flush)).unwrap();
    drop(intake);
    thread.join().unwrap();
    assert_eq!(sequences(&paths[0]), (14..=24).collect::<Vec<_>>());
    assert_eq!(sequences(&paths[1]), (39..=49).collect::<Vec<_>>());
    for flushed in reports.lock().unwrap().iter() {
        assert!(flushed.fault.is_none());
        assert_eq!(flushed.time, Duration::from_secs(10));
        let bytes = std::fs::read(&flushed.path).unwrap();
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        assert_eq!(summary.attachment_indexes[0].name, "lariat.toml");
    }
    assert_eq!(reports.lock().unwrap().len(), 2);
}

#[test]
fn its_memory_is_bounded() {
    let mut ring = Ring::new(Duration::from_secs(1000), 1 << 20);
    for number in 0..100 {
        ring.push(parcel(number, 100_000));
        while ring.overflows() {
            ring.pop();
        }
        assert!(ring.bytes <= 1 << 20);
    }
    assert_eq!(ring.parcels.len(), 10);
    assert_eq!(ring.parcels.back().unwrap().sequence, 99);
}

#[test]
fn what_is_still_to_be_written_is_not_forgotten_before() {
    let folder = tempfile::tempdir().unwrap();
    let (mut intake, thread, _) = ring(10, 1 << 20);
    let path = folder.path().join("a.mcap");
    for number in 0..20 {
        intake
            .send_waiting(Item::Message(parcel(number, 1000)))
            .unwrap();
    }
    intake
        .send_waiting(Item::Order(Box::new(Order::Flush(path.clone()))))
        .unwrap();
    // A message from an hour later replaces all others.
    intake
        .send_waiting(Item::Message(parcel(3600, 1000)))
        .unwrap();
    drop(intake);
    thread.join().unwrap();
    assert_eq!(sequences(&path), (9..=19).collect::<Vec<_>>());
}

#[test]
fn a_file_that_cannot_be_made_is_reported_and_the_ring_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let (mut intake, thread, reports) = ring(10, 1 << 20);
    let good = folder.path().join("a.mcap");
    for path in [folder.path().join("no/folder.mcap"), good.clone()] {
        intake.send_waiting(Item::Message(parcel(1, 10))).unwrap();
        intake
            .send_waiting(Item::Order(Box::new(Order::Flush(path))))
            .unwrap();
    }
    drop(intake);
    thread.join().unwrap();
    let reports = reports.lock().unwrap();
    assert!(matches!(reports[0].fault, Some(WriteError::Begin { .. })));
    assert!(reports[1].fault.is_none());
    assert_eq!(sequences(&good), [1, 1]);
}
