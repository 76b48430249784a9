//! Files decoded ahead into lent memory yield the same frames as files decoded on request.
#![allow(unsafe_code)] // Lending a slot is unsafe; the reason is given at each place.

use std::ptr::NonNull;

use image::{GrayImage, Luma};
use lariat_capture::{FileOptions, Frame, FrameSource, LentSlot, RenderOptions, Source, open};

/// Slots as a sender of frames has them: a few, lent again after their frame was read.
struct Slots(Vec<Vec<u8>>);

impl Slots {
    fn lend(&mut self, index: usize, source: &mut dyn FrameSource) {
        let memory = NonNull::from(&mut self.0[index][..]);
        // SAFETY: the memory is not touched until the source gives it back, and outlives the
        // source.
        source.lend(unsafe { LentSlot::new(index, memory) });
    }
}

/// Returns each frame's number, width and pixels, and how many frames were in a slot.
fn shown(source: &mut dyn FrameSource, slots: &mut Slots) -> (Vec<(u64, u32, Vec<u8>)>, usize) {
    let (mut frames, mut in_slots) = (Vec::new(), 0);
    while let Some(frame) = source.next().unwrap() {
        let Frame {
            sequence, width, ..
        } = frame;
        let mut pixels = vec![0; frame.bytes()];
        match frame.slot {
            None => source.write(&mut pixels),
            Some(key) => {
                in_slots += 1;
                pixels.copy_from_slice(&slots.0[key.index()][..frame.bytes()]);
                slots.lend(key.index(), source);
            }
        }
        frames.push((sequence, width, pixels));
    }
    (frames, in_slots)
}

#[test]
fn pictures_are_decoded_into_the_slots_that_are_lent() {
    let folder = tempfile::tempdir().unwrap();
    for number in 1..=9u8 {
        let path = folder.path().join(format!("{number}.png"));
        match number {
            4 => std::fs::write(path, "broken").unwrap(),
            _ => GrayImage::from_fn(4 + u32::from(number), 5, |x, y| {
                Luma([number + x as u8 + 10 * y as u8])
            })
            .save(path)
            .unwrap(),
        }
    }
    let paths = [folder.path().to_owned()];
    let source = Source::named(&paths, FileOptions::default(), RenderOptions::default());
    let (expected, none) = shown(&mut *open(&source).unwrap(), &mut Slots(Vec::new()));
    assert_eq!((expected.len(), none), (8, 0));
    for lent in 1..=4 {
        // Dropped after the source.
        let mut slots = Slots(vec![vec![0xa5; 100]; lent]);
        let mut source = open(&source).unwrap();
        assert!(source.slots_wanted() > 0);
        (0..lent).for_each(|index| slots.lend(index, &mut *source));
        let (frames, in_slots) = shown(&mut *source, &mut slots);
        assert_eq!(frames, expected);
        // The first frame is decoded before anything is lent.
        assert_eq!(in_slots, 7);
    }
}

#[test]
fn a_source_that_is_dropped_has_let_go_of_its_slots() {
    let folder = tempfile::tempdir().unwrap();
    for number in 1..=9 {
        let picture = GrayImage::from_pixel(64, 64, Luma([7]));
        picture
            .save(folder.path().join(format!("{number}.png")))
            .unwrap();
    }
    let paths = [folder.path().to_owned()];
    let source = Source::named(&paths, FileOptions::default(), RenderOptions::default());
    let mut slots = Slots(vec![vec![0; 64 * 64]; 4]);
    let mut opened = open(&source).unwrap();
    (0..4).for_each(|index| slots.lend(index, &mut *opened));
    opened.next().unwrap();
    drop(opened);
    slots.0.iter_mut().for_each(|slot| slot.fill(1));
    std::thread::yield_now();
    assert!(slots.0.iter().flatten().all(|&byte| byte == 1));
}
