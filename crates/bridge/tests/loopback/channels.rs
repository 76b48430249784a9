//! Channels other than descriptors: ropes in 3-D, and channels on request.

use std::thread;
use std::time::{Duration, Instant};

use lariat_wire::{
    Axes, CENTERLINES, Centerlines, DESCRIPTORS, DESCRIPTORS3, Delivery, Descriptor3, Descriptors,
    Descriptors3, FRAMES, FrameHeader, MASKS, NoSpace, PixelFormat, Place as Place3, Reader,
    Receiver, Seen, TRUTH, Writer, now_ns,
};

use crate::rope;
use crate::sides::{Chain, PATIENCE, Place, number, rig};

#[test]
fn who_has_descriptors_far_away_has_where_they_are_in_space() {
    let place = Place::new();
    let near = place.listen(&[]);
    let far = place.connect(place.port, &[]);
    let there = place.near();
    let mut reader = Reader::open_in(place.far(), &rig()).expect("a reader");
    reader.follow_in_space().expect("room for one more");
    let space =
        Writer::<Descriptors3>::create(&there, &rig(), &DESCRIPTORS3, &Delivery::NewestWins)
            .expect("the only one");
    let flat = Writer::<Descriptors>::create(&there, &rig(), &DESCRIPTORS, &Delivery::NewestWins)
        .expect("the only one");
    let (mut came, mut without, mut count) = (0, 0, 0);
    let deadline = Instant::now() + PATIENCE;
    while came < 20 {
        assert!(Instant::now() < deadline, "{came} came, {without} without");
        count += 1;
        let now_ns = now_ns();
        let mut slot = flat.slot().expect("a slot");
        rope::write(&mut slot, count, now_ns);
        let mut beside = space.slot().expect("a slot");
        beside.trace = slot.trace;
        (beside.count, beside.axes) = (1, Axes::Camera as u32);
        let curve = &mut beside.curves[0];
        *curve = Descriptor3::EMPTY;
        (curve.degree, curve.count, curve.samples) = (1, 2, 60);
        curve.place = Place3::Known as u32;
        let height = count as f64;
        curve.control_points[..2].copy_from_slice(&[[0.0, 0.0, height], [100.0, 0.0, height]]);
        beside.send().expect("sent");
        slot.send().expect("sent");
        // A camera's pace.
        let look_up = Instant::now() + Duration::from_millis(10);
        while let frame = reader.wait(look_up).expect("a reader")
            && frame.is_new()
        {
            let sequence = frame.message().expect("a frame").trace.sequence as f64;
            let Seen::Fresh(rope) = frame.only_rope(PATIENCE) else {
                panic!("a rope is seen");
            };
            match rope.in_space() {
                // It belongs to the same frame and to no other.
                Ok(shape) => {
                    assert_eq!(shape.point_at(0.5), [50.0, 0.0, sequence]);
                    came += 1;
                }
                // The first message that came opened the channel on the far side.
                Err(NoSpace::NoDepth) if came == 0 => without += 1,
                Err(cause) => panic!("{cause}, after {came}"),
            }
        }
    }
    let (said, near) = (far.end(), near.end());
    assert!(number(&near, "), ") >= came, "{near} {said}");
    drop((reader, flat, space, there));
}

#[test]
fn centerlines_and_the_truth_come_where_they_are_asked_for() {
    let place = Place::new();
    let near = place.listen(&[]);
    let far = place.connect(place.port, &["--also", "centerlines,truth"]);
    let (here, there) = (place.far(), place.near());
    let chain = Chain::start(&place);
    let channels = [&CENTERLINES, &TRUTH];
    let writers = channels.map(|channel| {
        Writer::<Centerlines>::create(&there, &rig(), channel, &Delivery::NewestWins)
            .expect("the only one")
    });
    let readers = channels
        .map(|channel| Receiver::create_unwoken(&here, &rig(), channel, None).expect("a reader"));
    let mut came = [0; 2];
    let deadline = Instant::now() + PATIENCE;
    while came.contains(&0) {
        assert!(Instant::now() < deadline, "{came:?}");
        for (width, writer) in writers.iter().enumerate() {
            let mut slot = writer.slot().expect("a slot");
            *slot = Centerlines::EMPTY;
            (slot.width, slot.count, slot.curves[0].count) = (width as u32 + 1, 1, 3);
            slot.curves[0].points[..3].copy_from_slice(&[[0.0, 9.0], [1.0, 8.0], [2.0, 7.0]]);
            slot.trace.exposed_ns = now_ns();
            slot.send().expect("sent");
        }
        // The pace of cameras.
        thread::sleep(Duration::from_millis(20));
        for (at, reader) in readers.iter().enumerate() {
            while let Some(message) = reader.next().expect("a reader") {
                assert_eq!(message.width as usize, at + 1);
                assert_eq!(message.curves()[0].points()[2], [2.0, 7.0]);
                came[at] += 1;
            }
        }
    }
    far.end();
    near.end();
    drop((readers, writers, here, there, chain));
}

#[test]
fn frames_come_where_they_are_asked_for() {
    let place = Place::new();
    let near = place.listen(&[]);
    let far = place.connect(place.port, &["--frames", "20"]);
    let (here, there) = (place.far(), place.near());
    let (width, height) = (160, 120);
    let bytes = 3 * (width * height) as usize;
    let color = |at: usize| [(at % 160) as u8, (at / 160) as u8, 90];
    let writer = Writer::<[u8]>::frames(&there, &rig(), &Delivery::NewestWins, bytes);
    let writer = writer.expect("the only one");
    let reader = Receiver::create_unwoken(&here, &rig(), &FRAMES, None).expect("a reader");
    let (mut came, mut sequence, mut last) = (0, 0, 0);
    let deadline = Instant::now() + PATIENCE;
    while came < 3 {
        assert!(Instant::now() < deadline, "no frames come");
        sequence += 1;
        let mut slot = writer.frame_slot(bytes).expect("a slot");
        for (at, pixel) in slot.chunks_exact_mut(3).enumerate() {
            pixel.copy_from_slice(&color(at));
        }
        let header = slot.header_mut();
        *header = FrameHeader {
            width,
            height,
            stride: 3 * width,
            pixel_format: PixelFormat::Rgb8 as u32,
            ..FrameHeader::default()
        };
        (header.trace.sequence, header.trace.exposed_ns) = (sequence, now_ns());
        slot.send().expect("sent");
        // A camera's pace.
        thread::sleep(Duration::from_millis(20));
        while let Some(frame) = reader.next().expect("a reader") {
            let header = frame.header();
            assert_eq!((header.width, header.height), (width, height));
            assert!(header.trace.sequence > last);
            last = header.trace.sequence;
            // The colors of a JPEG are nearly right.
            let off = frame.chunks_exact(3).enumerate().map(|(at, pixel)| {
                let off = |i: usize| u32::from(pixel[i].abs_diff(color(at)[i]));
                off(0) + off(1) + off(2)
            });
            let off: u32 = off.sum();
            assert!(off / (width * height) < 9, "{off}");
            came += 1;
        }
    }
    far.end();
    near.end();
    drop((reader, writer, here, there));
}

#[test]
fn masks_come_to_the_bit_where_they_are_asked_for() {
    let place = Place::new();
    let near = place.listen(&[]);
    let far = place.connect(place.port, &["--also", "masks"]);
    let (here, there) = (place.far(), place.near());
    let (width, height) = (320, 200_u32);
    let bytes = (width * height) as usize;
    // The soft edge of a rope, and noise next to it: no two masks are the same, and none fits into
    // one datagram.
    let level = |at: usize, sequence: u64| match at % 320 {
        column @ 100..140 => (6 * column) as u8,
        150..160 => ((at as u64 + sequence).wrapping_mul(0x9e37_79b9) >> 16) as u8,
        _ => 0,
    };
    let writer = Writer::<[u8]>::masks(&there, &rig(), &Delivery::NewestWins, bytes);
    let writer = writer.expect("the only one");
    let reader = Receiver::create_unwoken(&here, &rig(), &MASKS, None).expect("a reader");
    let (mut came, mut sequence, mut last) = (0, 0, 0);
    let deadline = Instant::now() + PATIENCE;
    while came < 10 {
        assert!(Instant::now() < deadline, "no masks come");
        sequence += 1;
        let mut slot = writer.frame_slot(bytes).expect("a slot");
        for (at, pixel) in slot.iter_mut().enumerate() {
            *pixel = level(at, sequence);
        }
        let header = FrameHeader {
            width,
            height,
            ..FrameHeader::default()
        };
        *slot.header_mut() = header.of_mask();
        let trace = &mut slot.header_mut().trace;
        (trace.sequence, trace.exposed_ns) = (sequence, now_ns());
        slot.send().expect("sent");
        // A camera's pace.
        thread::sleep(Duration::from_millis(20));
        while let Some(mask) = reader.next().expect("a reader") {
            let header = mask.header();
            assert_eq!((header.width, header.height), (width, height));
            assert!(header.trace.sequence > last);
            last = header.trace.sequence;
            let is_same = |(at, pixel): (usize, &u8)| *pixel == level(at, last);
            assert!(mask.iter().enumerate().all(is_same));
            came += 1;
        }
    }
    let (far, near) = (far.end(), near.end());
    assert!(number(&far, "0 frames, ") >= came, "{far}");
    assert!(number(&near, " 0 frames, ") >= came, "{near}");
    drop((reader, writer, here, there));
}
