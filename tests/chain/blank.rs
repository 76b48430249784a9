//! Reports about ropes while a camera gives no image.

use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use lariat_capture::{FrameSource, RenderOptions, Source};
use lariat_wire::{
    Delivery, Descriptors, Domain, FrameHeader, Message, Receiver, Rig, SourceKind, Status, Trace,
    Writer, now_ns,
};
use rustix::process::Signal;

use crate::rig::{Bench, send, wait_until_told_by_signals};

/// A substitute for capture: sends frames of a rope as a camera would, each after the previous one
/// was answered.
struct Camera {
    rope: Box<dyn FrameSource>,
    frames: Writer<[u8]>,
    descriptors: Receiver<Descriptors>,
    count: u64,
}

impl Camera {
    /// Sends a frame, with the rope or blank; `None` if it is not answered soon.
    fn show(&mut self, is_blank: bool) -> Option<(u64, Message<Descriptors>)> {
        self.count += 1;
        let mut header = FrameHeader {
            trace: Trace {
                sequence: self.count,
                captured: self.count,
                exposed_ns: now_ns(),
                captured_ns: now_ns(),
                ..Trace::EMPTY
            },
            source: SourceKind::Camera as u32,
            ..FrameHeader::default()
        };
        let mut slot = if is_blank {
            self.frames.frame_slot(0).unwrap()
        } else {
            let frame = self.rope.next().unwrap().expect("without end");
            (header.width, header.height) = (frame.width, frame.height);
            (header.stride, header.pixel_format) = (frame.stride, frame.format as u32);
            let mut slot = self.frames.frame_slot(frame.bytes()).unwrap();
            self.rope.write(&mut slot);
            slot
        };
        *slot.header_mut() = header;
        slot.send().unwrap();
        let deadline = Instant::now() + Duration::from_secs(2);
        while let Some(message) = self.descriptors.wait(deadline).unwrap() {
            if message.trace.sequence == self.count {
                return Some((header.trace.exposed_ns, message));
            }
        }
        None
    }

    /// Sends such frames until one is answered, because stages that are starting miss early frames.
    fn show_surely(&mut self, is_blank: bool) -> (u64, Message<Descriptors>) {
        let deadline = Instant::now() + Duration::from_secs(60);
        loop {
            if let Some(answer) = self.show(is_blank) {
                return answer;
            }
            assert!(Instant::now() < deadline, "no frame is answered");
        }
    }
}

#[test]
fn while_a_camera_gives_no_image_its_ropes_are_told_to_be_lost() {
    let bench = Bench::new();
    let start = |stage: &&str| -> Child {
        bench
            .command(&[stage])
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    };
    let domain = Domain::named(&bench.domain).unwrap();
    let rig = Rig::default();
    let rope = lariat_capture::open(&Source::Rendered(RenderOptions::default())).unwrap();
    let bytes = rope.largest_frame_bytes();
    let mut camera = Camera {
        rope,
        frames: Writer::frames(&domain, &rig, &Delivery::NewestWins, bytes).unwrap(),
        descriptors: Receiver::descriptors(&domain, &rig).unwrap(),
        count: 0,
    };
    let mut stages: Vec<Child> = ["fit", "extract"].iter().map(start).collect();
    let (mut track, mut seen_ns) = (0, 0);
    for _ in 0..20 {
        let (exposed_ns, message) = camera.show_surely(false);
        let curve = &message.curves()[0];
        assert_eq!(curve.status(), Some(Status::Ok));
        (track, seen_ns) = (curve.track, exposed_ns);
    }
    for _ in 0..5 {
        let (exposed_ns, message) = camera.show_surely(true);
        assert_eq!((message.width, message.height), (0, 0));
        let [curve] = message.curves() else {
            panic!("{} curves", message.count);
        };
        assert_eq!(curve.track, track);
        assert_eq!(curve.status(), Some(Status::Lost));
        assert_eq!(curve.age_ns, exposed_ns - seen_ns);
        assert!(curve.count > 0, "its last shape is told");
    }
    let (_, message) = camera.show_surely(false);
    let curve = &message.curves()[0];
    assert_eq!((curve.track, curve.status()), (track, Some(Status::Ok)));
    drop(message);
    for stage in &mut stages {
        wait_until_told_by_signals(stage.id());
        send(stage.id() as i32, Signal::TERM);
        assert!(stage.wait().unwrap().success());
    }
    drop((camera, domain));
    bench.assert_nothing_is_left();
}
