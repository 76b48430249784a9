//! Messages that fit and the sink receive: extract's result, and the truth.

use std::cell::RefCell;

use lariat_chain::pipeline::CurveFitter;
use lariat_chain::settings::Settings;
use lariat_sink::{Options, Sink};
use lariat_wire::fields::Message as _;
use lariat_wire::{
    CENTERLINES, Centerlines, Crossing, Delivery, Descriptors, MAX_CROSSINGS, MAX_CURVES,
    MAX_POINTS, Receiver, Shape, Writer, now_ns,
};

use super::curve;
use super::descriptors::ask_sink;
use super::edit::edit_all;
use super::input::Input;
use super::rig::Place;

/// A writer of a rig, a reader, and two kinds of fitters.
struct Bench {
    writer: Writer<Centerlines>,
    reader: Receiver<Centerlines>,
    fitters: [CurveFitter; 2],
    answer: Box<Descriptors>,
    /// Dropped last.
    _place: Place,
}

impl Bench {
    fn new() -> Self {
        let place = Place::new();
        let (domain, rig) = (place.domain(), &place.rig);
        let delivery = Delivery::NewestWins;
        let reader = Receiver::create(&domain, rig, &CENTERLINES, None).expect("a reader");
        let writer = Writer::<Centerlines>::create(&domain, rig, &CENTERLINES, &delivery);
        let mut robust = Settings::default();
        robust.fit.filter = true;
        robust.fit.robust = true;
        Self {
            writer: writer.expect("the rig's only writer"),
            reader,
            fitters: [Settings::default(), robust]
                .map(|settings| CurveFitter::new(&settings).expect("settings that make sense")),
            answer: Box::new(Descriptors::EMPTY),
            _place: place,
        }
    }
}

thread_local! {
    static BENCH: RefCell<Bench> = RefCell::new(Bench::new());
}

/// Sends a message of centerlines to fit, and to the sink as a result and as the truth.
///
/// # Panics
/// Panics if an invariant does not hold.
pub fn centerlines(bytes: &[u8]) {
    let mut input = Input(bytes);
    let mut message = sound();
    edit_all(&mut *message, &mut input);
    BENCH.with_borrow_mut(|bench| {
        let Bench {
            writer,
            reader,
            fitters,
            answer,
            ..
        } = bench;
        let mut slot = writer.slot().expect("a slot");
        *slot = *message;
        slot.send().expect("sent");
        let message = reader
            .latest()
            .expect("readable")
            .expect("it has just come");
        assert!(message.curves().len() <= MAX_CURVES);
        assert!(message.crossings().len() <= MAX_CROSSINGS);
        assert!(!message.fields().is_empty());
        for curve in message.curves() {
            assert!(curve.points().len() <= MAX_POINTS);
            assert_eq!(curve.widths_px().len(), curve.points().len());
        }
        let mut sink = Sink::new(Options::default());
        sink.truth(&message);
        sink.centerlines(&message);
        for fitter in fitters {
            fitter.forget();
            // The second pass follows the first one.
            for _ in 0..2 {
                fitter.answer(&message, answer);
                assert!(answer.curves().len() <= message.curves().len());
                answer.trace = message.trace;
                answer.trace.fitted_ns = now_ns();
                sink.descriptors(answer, now_ns());
                for descriptor in answer.curves() {
                    if let Ok(shape) = Shape::of(descriptor) {
                        curve::ask_shape(&shape);
                    }
                }
            }
        }
        ask_sink(answer);
        assert!(!sink.live_line(now_ns()).is_empty());
    });
}

/// Three ropes that cross each other.
fn sound() -> Box<Centerlines> {
    let mut message = Box::new(Centerlines::EMPTY);
    message.trace.sequence = 1;
    (message.trace.captured, message.trace.extracted) = (1, 1);
    message.trace.exposed_ns = now_ns().saturating_sub(1_000_000);
    (message.width, message.height) = (640, 480);
    (message.count, message.crossing_count) = (3, 1);
    for (rope, curve) in message.curves[..3].iter_mut().enumerate() {
        (curve.track, curve.count) = (rope as u32, 120);
        (curve.width_px, curve.length_px, curve.confidence) = (12.0, 150.0, 0.9);
        for (i, point) in curve.points[..120].iter_mut().enumerate() {
            let x = i as f32;
            *point = [
                100.0 + x,
                150.0 + 0.3 * x + 40.0 * rope as f32 + 5.0 * (x / 9.0).sin(),
            ];
        }
        curve.widths_px[..120].fill(12.0);
    }
    message.crossings[0] = Crossing {
        at: [150.0, 170.0],
        over: 0,
        under: 1,
        over_rho: 0.4,
        under_rho: 0.5,
        confidence: 0.8,
        reserved: 0,
    };
    message
}
