//! Frames that extract receives: a header and bytes that may not match.

use std::cell::RefCell;
use std::hint::black_box;

use lariat_chain::pipeline::{FrameExtractor, FrameView};
use lariat_chain::settings::Settings;
use lariat_wire::fields::Message as _;
use lariat_wire::{
    Centerlines, Delivery, FrameHeader, FrameReader, MAX_CURVES, PixelFormat, SourceKind, Writer,
    now_ns,
};

use super::edit::edit;
use super::input::Input;
use super::rig::Place;

/// Maximum number of bytes. Larger frames reveal little more, and slow the fuzzer down.
const MOST_BYTES: usize = 96 * 72 * 3;

/// A writer of a rig's frames, a reader, and the extractor.
struct Bench {
    writer: Writer<[u8]>,
    reader: FrameReader,
    extractor: FrameExtractor,
    answer: Box<Centerlines>,
    /// Dropped last.
    _place: Place,
}

impl Bench {
    fn new() -> Self {
        let place = Place::new();
        let (domain, rig) = (place.domain(), &place.rig);
        let writer = Writer::frames(&domain, rig, &Delivery::NewestWins, MOST_BYTES);
        let extractor = FrameExtractor::new(&Settings::default().extract);
        Self {
            writer: writer.expect("the rig's only writer"),
            reader: FrameReader::open_in(domain, rig, None).expect("a reader"),
            extractor: extractor.expect("settings that make sense"),
            answer: Box::new(Centerlines::EMPTY),
            _place: place,
        }
    }
}

thread_local! {
    static BENCH: RefCell<Bench> = RefCell::new(Bench::new());
}

/// Sends a frame to extract.
///
/// # Panics
/// Panics if an invariant does not hold.
pub fn frame(bytes: &[u8]) {
    let mut input = Input(bytes);
    let mut header = FrameHeader {
        width: 32,
        height: 24,
        stride: 32 * 3,
        pixel_format: PixelFormat::Rgb8 as u32,
        source: SourceKind::Camera as u32,
        ..FrameHeader::EMPTY
    };
    header.trace.exposed_ns = now_ns();
    for _ in 0..input.byte() % 8 {
        edit(&mut header, &mut input);
    }
    // As many bytes as the header states, or fewer, with a rope across them.
    let said = header.image_bytes().unwrap_or(64).min(MOST_BYTES);
    let length = said.saturating_sub(usize::from(input.byte() / 4));
    BENCH.with_borrow_mut(|bench| {
        let mut slot = bench.writer.frame_slot(length).expect("a slot");
        *slot.header_mut() = header;
        let row = (header.stride as usize).clamp(1, length.max(1));
        let pixels = input.rest();
        for (i, byte) in slot.iter_mut().enumerate() {
            let is_rope = (i / row).abs_diff(12) < 2;
            let made_up = pixels.get(i % pixels.len().max(1)).copied().unwrap_or(0);
            *byte = if is_rope { 230 } else { made_up / 4 };
        }
        slot.send().expect("sent");
        let message = bench.reader.try_next().expect("readable");
        let message = message.expect("it has just come");
        let header = message.header();
        assert!(!header.fields().is_empty());
        black_box((header.is_blank(), header.of_mask().image_bytes()));
        let view = FrameView::new(header, message);
        if let Ok(image) = view.image() {
            assert_eq!(
                (image.width(), image.height()),
                (header.width as usize, header.height as usize)
            );
        }
        let mask_header = header.of_mask();
        let mask = FrameView::new(&mask_header, message);
        for mask in [None, Some(mask)] {
            bench.extractor.forget();
            bench.extractor.answer(view, mask, &mut bench.answer);
            let answer = &bench.answer;
            assert!(answer.count as usize <= MAX_CURVES);
            let indices = answer.crossings().iter().flat_map(|c| [c.over, c.under]);
            assert!(indices.into_iter().all(|index| index < answer.count));
            let points = answer.curves().iter().flat_map(|curve| curve.points());
            assert!(points.flatten().all(|coordinate| coordinate.is_finite()));
        }
    });
}
