//! Guarantees of channels for a writer and its readers, within one process. Separate processes are
//! tested in the root package.

use std::os::fd::AsFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::prelude::*;
use lariat_wire::*;

/// A domain that no other test run shares.
fn domain() -> Domain {
    Domain::named(&name()).expect("a domain")
}

fn name() -> String {
    format!("w{}", std::process::id())
}

fn rig(name: &str) -> Rig {
    name.parse().expect("a plain name")
}

fn send(writer: &Writer<Descriptors>, fitted: u64) {
    let mut slot = writer.slot().expect("a slot");
    slot.trace.fitted = fitted;
    slot.count = 0;
    slot.send().expect("sent");
}

#[test]
fn a_reader_gets_the_newest_or_each_in_order() {
    let (domain, rig) = (domain(), rig("order"));
    let reader = Receiver::descriptors(&domain, &rig).unwrap();
    let writer =
        Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins).unwrap();
    assert!(reader.latest().unwrap().is_none());
    for fitted in 1..=3 {
        send(&writer, fitted);
    }
    assert_eq!(reader.next().unwrap().unwrap().trace.fitted, 1);
    assert_eq!(reader.latest().unwrap().unwrap().trace.fitted, 3);
    assert!(reader.latest().unwrap().is_none());
}

#[test]
fn a_slow_reader_loses_the_oldest_and_never_slows_the_writer() {
    let (domain, rig) = (domain(), rig("slow"));
    let reader = Receiver::descriptors(&domain, &rig).unwrap();
    let writer =
        Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins).unwrap();
    for fitted in 1..=100 {
        send(&writer, fitted);
    }
    let first = reader.next().unwrap().unwrap().trace.fitted;
    assert_eq!(first, 93, "eight wait, the others made room");
    assert_eq!(reader.latest().unwrap().unwrap().trace.fitted, 100);
}

#[test]
fn a_late_reader_is_given_the_newest_descriptor() {
    let (domain, rig) = (domain(), rig("late"));
    let writer =
        Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins).unwrap();
    send(&writer, 1);
    send(&writer, 2);
    let reader = Receiver::descriptors(&domain, &rig).unwrap();
    writer.welcome().unwrap();
    assert_eq!(reader.latest().unwrap().unwrap().trace.fitted, 2);
}

#[test]
fn a_waiting_reader_wakes_for_a_message_a_descriptor_or_its_deadline() {
    let (domain, rig) = (domain(), rig("wake"));
    let reader = Receiver::descriptors(&domain, &rig).unwrap();
    let writer =
        Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins).unwrap();
    assert!(
        reader
            .wait(Instant::now() + Duration::from_millis(5))
            .unwrap()
            .is_none()
    );
    send(&writer, 7);
    let far = Instant::now() + Duration::from_secs(3600);
    assert_eq!(reader.wait(far).unwrap().unwrap().trace.fitted, 7);
    // A pipe whose other end is closed is readable.
    let (readable, _) = rustix::pipe::pipe().unwrap();
    reader.sleep(None, Some(readable.as_fd())).unwrap();
    assert!(reader.latest().unwrap().is_none());
    send(&writer, 8);
    // A waiting message prevents sleep, whatever happened to its notification.
    reader.sleep(None, None).unwrap();
    assert_eq!(reader.latest().unwrap().unwrap().trace.fitted, 8);
}

#[test]
fn a_lossless_writer_waits_for_a_slow_reader_and_loses_nothing() {
    let (domain, rig) = (domain(), rig("lossless"));
    let delivery = Delivery::Lossless {
        stop: Arc::default(),
    };
    let reader = Receiver::create(&domain, &rig, &DESCRIPTORS, Some(&delivery)).unwrap();
    let writer = std::thread::spawn({
        let (rig, delivery) = (rig.clone(), delivery.clone());
        move || {
            let domain = Domain::named(&name()).unwrap();
            let writer =
                Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &delivery).unwrap();
            for fitted in 1..=1000 {
                send(&writer, fitted);
            }
        }
    });
    for fitted in 1..=1000 {
        let message = loop {
            match reader.next().unwrap() {
                Some(message) => break message,
                None => reader.sleep(None, None).unwrap(),
            }
        };
        assert_eq!(message.trace.fitted, fitted);
    }
    writer.join().unwrap();
    assert!(reader.next().unwrap().is_none());
}

#[test]
fn a_lossless_writer_that_is_told_to_stop_gives_up_and_says_so() {
    let (domain, rig) = (domain(), rig("told"));
    let stop = Arc::new(AtomicBool::new(false));
    let delivery = Delivery::Lossless { stop: stop.clone() };
    let writer = Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &delivery).unwrap();
    let reader = Receiver::create(&domain, &rig, &DESCRIPTORS, Some(&delivery)).unwrap();
    stop.store(true, Ordering::Relaxed);
    for fitted in 1..=8 {
        send(&writer, fitted);
    }
    assert!(reader.next().unwrap().is_some());
    send(&writer, 9);
    assert!(
        !writer.slot().unwrap().send().unwrap(),
        "no room for a tenth"
    );
    for fitted in 2..=9 {
        assert_eq!(reader.next().unwrap().unwrap().trace.fitted, fitted);
    }
}

#[test]
fn frames_travel_with_their_header_on_a_cache_line() {
    let (domain, rig) = (domain(), rig("frames"));
    let reader = Receiver::create(&domain, &rig, &FRAMES, None).unwrap();
    let writer = Writer::frames(&domain, &rig, &Delivery::NewestWins, 64 * 48).unwrap();
    let mut slot = writer.frame_slot(32 * 48).unwrap();
    slot.fill(200);
    slot.header_mut().width = 32;
    slot.send().unwrap();
    let frame = reader.latest().unwrap().unwrap();
    assert_eq!(frame.header().width, 32);
    assert_eq!(frame.len(), 32 * 48);
    assert!(frame.iter().all(|&byte| byte == 200));
    assert_eq!(frame.as_ptr() as usize % 64, 0);
}

#[test]
fn a_slot_for_a_frame_takes_the_frames_bytes_and_little_more() {
    let (domain, rig) = (domain(), rig("slots"));
    let largest = 640 * 480 * 3;
    let writer = Writer::frames(&domain, &rig, &Delivery::NewestWins, largest).unwrap();
    let segment = std::fs::read_dir("/dev/shm")
        .unwrap()
        .flatten()
        .find(|entry| {
            let file = entry.file_name().to_string_lossy().into_owned();
            file.contains(&writer.id()) && file.ends_with(".data")
        })
        .expect("the frames' segment");
    // Four readers, each with three frames waiting and two held, and the one being written.
    let slots = 4 * (3 + 2) + 1;
    let bytes = segment.metadata().unwrap().len() as usize;
    assert!(
        (slots * largest..slots * (largest + 1024)).contains(&bytes),
        "{bytes} bytes for {slots} slots of {largest}"
    );
}

#[test]
fn a_second_writer_is_refused_and_told_what_to_do() {
    let (domain, rig) = (domain(), rig("second"));
    let _first = Writer::frames(&domain, &rig, &Delivery::NewestWins, 100).unwrap();
    let second = Writer::frames(&domain, &rig, &Delivery::NewestWins, 100).unwrap_err();
    assert!(matches!(second, WireError::SecondWriter { .. }));
    assert_eq!(
        second.to_string(),
        "lariat/second/frames already has a writer: stop the other one, or give this one a rig of its own with --rig NAME"
    );
}

#[test]
fn a_reader_too_many_is_told_so_on_a_lossless_channel_too() {
    let (domain, rig) = (domain(), rig("full"));
    let delivery = Delivery::Lossless {
        stop: Arc::default(),
    };
    let _writer = Writer::frames(&domain, &rig, &delivery, 64).unwrap();
    let read = || Receiver::create(&domain, &rig, &FRAMES, None);
    let _readers = [(); 4].map(|()| read().unwrap());
    let refused = [(); 2].map(|()| read().unwrap_err());
    for cause in refused {
        assert!(
            matches!(cause, WireError::TooManyReaders { most: 4, .. }),
            "{cause}"
        );
    }
}

#[test]
fn lossless_and_newest_wins_do_not_mix() {
    let (domain, rig) = (domain(), rig("mixed"));
    let _reader = Receiver::descriptors(&domain, &rig).unwrap();
    let delivery = Delivery::Lossless {
        stop: Arc::default(),
    };
    let refused =
        Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &delivery).unwrap_err();
    assert!(
        matches!(
            refused,
            WireError::Delivery {
                ours: "with --lossless",
                ..
            }
        ),
        "{refused}"
    );
    // A reader without requirements accepts the channel as it is.
    let lossless = Rig::default();
    let _writer =
        Writer::<Descriptors>::create(&domain, &lossless, &DESCRIPTORS, &delivery).unwrap();
    Receiver::descriptors(&domain, &lossless).unwrap();
}

/// The same size, but another version.
#[repr(C)]
#[derive(Debug, Clone, Copy, ZeroCopySend)]
#[type_name("lariat.Descriptors.v0")]
struct Older {
    bytes: [u64; size_of::<Descriptors>() / 8],
}

#[test]
fn another_version_of_a_message_is_refused_by_name() {
    // In a separate domain: processes that join or leave would treat objects created without
    // lariat's lock as half created.
    let name = format!("{}versions", name());
    let (domain, rig) = (Domain::named(&name).expect("a domain"), rig("versions"));
    let mut config = Config::global_config().clone();
    config.global.prefix = FileName::new(format!("lariat_{name}_").as_bytes()).unwrap();
    config
        .global
        .set_root_path(&Path::new(format!("/tmp/lariat-{name}").as_bytes()).unwrap());
    let node = NodeBuilder::new()
        .config(&config)
        .create::<ipc::Service>()
        .unwrap();
    let _older = node
        .service_builder(&"lariat/versions/descriptors".try_into().unwrap())
        .publish_subscribe::<Older>()
        .max_publishers(1)
        .create()
        .unwrap();
    let refused = Receiver::descriptors(&domain, &rig).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "lariat/versions/descriptors carries lariat.Descriptors.v0, and this program was made for lariat.Descriptors.v9: \
         use the same release of lariat for every process on a rig"
    );
}

#[test]
fn frames_that_do_not_fit_into_shared_memory_are_refused_before_the_first() {
    let (domain, rig) = (domain(), rig("large"));
    let refused = Writer::frames(&domain, &rig, &Delivery::NewestWins, 1 << 45).unwrap_err();
    assert!(
        matches!(refused, WireError::TooLittleSpace { .. }),
        "{refused}"
    );
    assert!(refused.to_string().contains("/dev/shm has "), "{refused}");
}

#[test]
fn nothing_is_left_when_all_are_gone() {
    let (domain, rig) = (domain(), rig("gone"));
    let name = name();
    let reader = Receiver::descriptors(&domain, &rig).unwrap();
    let writer =
        Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins).unwrap();
    let id = writer.id();
    let segments = || {
        std::fs::read_dir("/dev/shm")
            .unwrap()
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|file| file.starts_with(&format!("lariat_{name}_")) && file.contains(&id))
            .count()
    };
    assert!(segments() > 0);
    drop((writer, reader));
    assert_eq!(segments(), 0);
}
