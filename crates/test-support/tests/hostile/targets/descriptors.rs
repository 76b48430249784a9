//! Messages that a control loop and the sink receive.

use std::hint::black_box;
use std::time::Duration;

use lariat_sink::{FinalCounts, Machine, Options, Sink};
use lariat_wire::fields::Message as _;
use lariat_wire::{
    Basis, DESCRIPTORS, Delivery, Descriptor, Descriptors, FitQuality, Frame, Reader, Seen, Status,
    Track, Writer, now_ns,
};

use super::curve;
use super::edit::edit_all;
use super::in_c;
use super::input::Input;
use super::rig::Place;

/// A writer of a rig, and its readers.
struct Bench {
    writer: Writer<Descriptors>,
    reader: Reader,
    in_c: in_c::Reader,
    /// Dropped last.
    _place: Place,
}

impl Bench {
    fn new() -> Self {
        let place = Place::new();
        let (domain, rig) = (place.domain(), &place.rig);
        let reader = Reader::open_in(place.domain(), rig).expect("a reader");
        let in_c = in_c::Reader::open(&place);
        let writer =
            Writer::<Descriptors>::create(&domain, rig, &DESCRIPTORS, &Delivery::NewestWins);
        Self {
            writer: writer.expect("the rig's only writer"),
            reader,
            in_c,
            _place: place,
        }
    }
}

thread_local! {
    static BENCH: std::cell::RefCell<Bench> = std::cell::RefCell::new(Bench::new());
}

/// Sends a message of descriptors to control loops in Rust and in C, and to the sink.
///
/// # Panics
/// Panics if an invariant does not hold.
pub fn descriptors(bytes: &[u8]) {
    let mut input = Input(bytes);
    let mut message = sound(&mut input);
    edit_all(&mut *message, &mut input);
    BENCH.with_borrow_mut(|bench| {
        let mut slot = bench.writer.slot().expect("a slot");
        *slot = *message;
        slot.send().expect("sent");
        let frame = bench.reader.latest().expect("readable");
        assert!(frame.is_new());
        ask(frame);
        let message = frame.message().expect("it has just come");
        let kept = frame.keep();
        let kept = kept.frame().message().expect("it has just come");
        assert_eq!(kept.fields().len(), message.fields().len());
        assert_eq!(kept.curves().len(), message.curves().len());
        ask_sink(message);
        bench.in_c.ask();
    });
}

/// A message of three ropes, with a basis that the input selects.
pub(crate) fn sound(input: &mut Input) -> Box<Descriptors> {
    let basis = Basis::ALL[usize::from(input.byte()) % Basis::ALL.len()];
    let mut message = Box::new(Descriptors::EMPTY);
    let now = now_ns();
    message.trace.sequence = 1;
    (
        message.trace.captured,
        message.trace.extracted,
        message.trace.fitted,
    ) = (1, 1, 1);
    message.trace.exposed_ns = now.saturating_sub(1_000_000);
    (message.trace.fit_started_ns, message.trace.fitted_ns) = (now, now);
    (message.width, message.height, message.count) = (640, 480, 3);
    for (rope, descriptor) in message.curves[..3].iter_mut().enumerate() {
        *descriptor = described(basis, rope as u32);
    }
    for points in &mut message.centerlines[..3] {
        points.count = 120;
        for (i, point) in points.points[..120].iter_mut().enumerate() {
            *point = [100.0 + i as f32, 200.0];
        }
    }
    message
}

fn described(basis: Basis, track: u32) -> Descriptor {
    let (degree, count) = match basis {
        Basis::Bezier | Basis::RationalBezier => (8, 9),
        Basis::BSpline => (3, 9),
        Basis::Fourier => (4, 9),
        Basis::FeaturePoints => (0, 9),
        Basis::CenterOfMass => (0, 1),
    };
    let mut descriptor = Descriptor {
        track,
        status: Status::Ok as u32,
        basis: basis as u32,
        degree,
        count,
        samples: 120,
        fit: FitQuality::Good as u32,
        filtered: 1,
        confidence: 0.9,
        width: 12.0,
        length: 120.0,
        ..Descriptor::EMPTY
    };
    for j in 0..count as usize {
        descriptor.control_points[j] = [100.0 + 13.0 * j as f64, 200.0 + (j % 3) as f64];
        descriptor.covariances[j] = [0.5, 0.1, 0.4];
        descriptor.velocities[j] = [3.0, -1.0];
        descriptor.weights[j] = 1.0;
    }
    for (i, knot) in descriptor.knots[..5].iter_mut().enumerate() {
        *knot = (i + 1) as f64 / 6.0;
    }
    descriptor
}

fn ask(frame: Frame) {
    black_box((frame.age(), frame.run()));
    let message = frame.message().expect("it has just come");
    let count = message.curves().len();
    assert_eq!(message.centerlines().len(), count);
    assert!(!message.fields().is_empty());
    for max_age in [Duration::ZERO, Duration::from_secs(1), Duration::MAX] {
        assert_eq!(frame.ropes(max_age).count(), count);
        assert!(!frame.only_rope(max_age).to_string().is_empty());
        for number in [0, 1, u32::MAX] {
            for run in [0, frame.run()] {
                let seen = frame.rope(Track::new(run, number), max_age);
                assert!(!seen.to_string().is_empty());
            }
        }
    }
    frame.ropes(Duration::from_secs(1)).for_each(ask_seen);
    for descriptor in message.curves() {
        black_box((descriptor.weights(), descriptor.all_knots().count()));
    }
}

fn ask_seen(seen: Seen) {
    assert!(!seen.to_string().is_empty());
    match seen {
        Seen::Fresh(rope) | Seen::Partial(rope) | Seen::Unsure(rope, _) => curve::ask(&rope),
        Seen::Lost(last) | Seen::Stale(last) => {
            black_box(last.age());
            curve::ask(&last.as_it_was());
        }
        Seen::Absent(why) => assert!(!why.to_string().is_empty()),
    }
}

/// Gives a sink this message, with valid ones before and after.
pub(crate) fn ask_sink(message: &Descriptors) {
    let mut sink = Sink::new(Options {
        period_ns: Some(1_000_000),
        from_start: true,
        ..Options::default()
    });
    let mut others = sound(&mut Input(&[0]));
    let mut receive = |sink: &mut Sink, number: u64| {
        let trace = &mut others.trace;
        trace.sequence = number;
        (trace.captured, trace.extracted, trace.fitted) = (number, number, number);
        trace.fitted_ns = now_ns();
        sink.descriptors(&others, now_ns());
    };
    receive(&mut sink, 1);
    sink.descriptors(message, now_ns());
    receive(&mut sink, u64::from(u32::MAX) + 2);
    sink.finish(FinalCounts::default());
    let frames = sink.frames();
    let lost = frames.lost;
    let accounted = frames.received + lost.total() - lost.source;
    assert_eq!(frames.published, accounted, "{frames:?}");
    // The messages after it are received, whatever it contained.
    assert!(frames.received >= 2, "{frames:?}");
    let machine = Machine {
        cpu: None,
        cores: None,
        kernel: String::new(),
        governor: None,
        memory_mb: None,
    };
    let report = sink.report_on(machine);
    assert!(!report.to_string().is_empty());
    report.files().expect("memory takes it");
    report
        .write_timeline(&mut Vec::new())
        .expect("memory takes it");
}
