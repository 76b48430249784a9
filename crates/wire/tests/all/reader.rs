//! Guarantees for control loops.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use lariat_wire::*;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// More than the age of any image.
const ANY_AGE: Duration = Duration::from_secs(3600);

/// A rig for one test, in a domain that no other test run shares.
struct Place {
    name: String,
    rig: Rig,
}

impl Place {
    fn new(rig: &str) -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        Self {
            name: format!("c{}-{number}", std::process::id()),
            rig: rig.parse().expect("a plain name"),
        }
    }

    fn domain(&self) -> Domain {
        Domain::named(&self.name).expect("a domain")
    }

    fn reader(&self) -> Reader {
        Reader::open_in(self.domain(), &self.rig).expect("a reader")
    }

    fn chain(&self) -> Chain {
        Chain::start(self.domain(), &self.rig)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(format!("/tmp/lariat-{}", self.name));
    }
}

/// Stands in for the chain.
struct Chain {
    writer: Writer<Descriptors>,
    _domain: Domain,
    trace: Trace,
}

impl Chain {
    fn start(domain: Domain, rig: &Rig) -> Self {
        let writer =
            Writer::<Descriptors>::create(&domain, rig, &DESCRIPTORS, &Delivery::NewestWins)
                .expect("the only writer");
        Self {
            writer,
            _domain: domain,
            trace: Trace::EMPTY,
        }
    }

    /// Sends an image of these ropes, taken just now.
    fn send(&mut self, ropes: &[Descriptor]) {
        self.send_as(now_ns(), [640, 480], ropes);
    }

    fn send_as(&mut self, exposed_ns: u64, [width, height]: [u32; 2], ropes: &[Descriptor]) {
        self.trace.extracted += 1;
        self.trace.fitted += 1;
        self.trace.exposed_ns = exposed_ns;
        // A chain whose clock is ahead.
        self.trace.fitted_ns = now_ns().max(exposed_ns);
        let mut slot = self.writer.slot().expect("a slot");
        slot.trace = self.trace;
        (slot.width, slot.height) = (width, height);
        slot.unit = Unit::Pixel as u32;
        slot.count = ropes.len() as u32;
        slot.curves[..ropes.len()].copy_from_slice(ropes);
        for (points, rope) in slot.centerlines.iter_mut().zip(ropes) {
            *points = points_of(rope);
        }
        slot.send().expect("sent");
    }
}

/// A straight rope from (x, 0) to (x, 100).
fn rope(track: u32, status: Status, x: f64) -> Descriptor {
    let mut rope = Descriptor::EMPTY;
    (rope.track, rope.status, rope.confidence) = (track, status as u32, 1.0);
    (rope.degree, rope.count, rope.samples) = (1, 2, 120);
    rope.control_points[..2].copy_from_slice(&[[x, 0.0], [x, 100.0]]);
    rope
}

/// The rope's three points; the last one is covered.
fn points_of(rope: &Descriptor) -> CenterlinePoints {
    let mut points = CenterlinePoints::EMPTY;
    points.count = 3;
    for i in 0..3 {
        points.points[i] = [rope.control_points[0][0] as f32, 50.0 * i as f32];
        points.widths[i] = 10.0 + i as f32;
    }
    points.set_hidden([false, false, true]);
    points
}

fn x_of(rope: &Rope) -> f64 {
    rope.shape().expect("a curve").point_at(0.5)[0]
}

#[test]
fn a_reader_is_there_before_the_chain_and_says_that_nothing_came() {
    let place = Place::new("early");
    let mut reader = place.reader();
    let frame = reader.latest().unwrap();
    assert!(!frame.is_new() && frame.age().is_none() && frame.run() == 0);
    assert!(matches!(
        frame.only_rope(ANY_AGE),
        Seen::Absent(Absent::NothingYet)
    ));
    let mut chain = place.chain();
    chain.send(&[rope(1, Status::Ok, 5.0)]);
    let frame = reader.latest().unwrap();
    assert!(frame.is_new() && frame.run() == 1);
    let Seen::Fresh(rope) = frame.only_rope(ANY_AGE) else {
        panic!("it is seen");
    };
    assert_eq!((x_of(&rope), rope.track().number()), (5.0, 1));
    assert_eq!(rope.unit(), Some(Unit::Pixel));
}

#[test]
fn the_newest_stays_at_hand_and_gets_older() {
    let place = Place::new("held");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    for x in 0..100 {
        chain.send(&[rope(1, Status::Ok, f64::from(x))]);
    }
    let first = reader.latest().unwrap();
    let age = first.age().unwrap();
    assert!(first.is_new());
    let again = reader.latest().unwrap();
    assert!(!again.is_new() && again.age().unwrap() > age);
    let Seen::Fresh(rope) = again.only_rope(ANY_AGE) else {
        panic!("it is seen");
    };
    assert_eq!(x_of(&rope), 99.0);
    assert!(reader.age().unwrap() > age);
}

#[test]
fn a_kept_frame_stays_what_it_was_and_goes_to_another_thread() {
    let place = Place::new("kept");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let before = reader.latest().unwrap().keep();
    assert!(before.frame().message().is_none() && before.frame().age().is_none());
    chain.send(&[rope(1, Status::Ok, 5.0)]);
    let frame = reader.latest().unwrap();
    let (age, kept) = (frame.age(), frame.keep());
    chain.send(&[rope(1, Status::Ok, 6.0), rope(2, Status::Lost, 7.0)]);
    reader.latest().unwrap();
    drop((chain, reader));
    let said = std::thread::spawn(move || {
        let frame = kept.frame();
        let Seen::Fresh(rope) = frame.only_rope(ANY_AGE) else {
            panic!("it was seen");
        };
        (x_of(&rope), frame.is_new(), frame.run(), frame.age())
    });
    assert_eq!(said.join().unwrap(), (5.0, true, 1, age));
}

#[test]
fn an_image_older_than_allowed_has_no_fresh_rope_whatever_it_shows() {
    let place = Place::new("stale");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let second = Duration::from_secs(1);
    for status in [Status::Ok, Status::Partial, Status::Lost] {
        chain.send_as(
            now_ns() - 2 * second.as_nanos() as u64,
            [640, 480],
            &[rope(1, status, 5.0)],
        );
        let frame = reader.latest().unwrap();
        let Seen::Stale(last) = frame.only_rope(second) else {
            panic!("{status:?}: it is two seconds old");
        };
        assert!(last.age() >= 2 * second && x_of(&last.as_it_was()) == 5.0);
        assert!(!matches!(frame.only_rope(3 * second), Seen::Stale(_)));
    }
    // An image of a chain whose clock is ahead must not stay fresh forever either.
    chain.send_as(u64::MAX, [640, 480], &[rope(1, Status::Ok, 5.0)]);
    let frame = reader.latest().unwrap();
    assert!(matches!(frame.only_rope(Duration::ZERO), Seen::Stale(_)));
}

#[test]
fn a_covered_and_a_lost_rope_are_other_things_than_a_rope() {
    let place = Place::new("states");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let mut partial = rope(1, Status::Partial, 5.0);
    partial.hidden = 30;
    chain.send(&[partial]);
    match reader.latest().unwrap().only_rope(ANY_AGE) {
        Seen::Partial(rope) => assert_eq!(rope.hidden(), 0.25),
        other => panic!("{other}"),
    }
    let mut lost = rope(1, Status::Lost, 5.0);
    lost.age_ns = 2_000_000_000;
    chain.send(&[lost]);
    match reader.latest().unwrap().only_rope(ANY_AGE) {
        Seen::Lost(last) => assert!(last.age() >= Duration::from_secs(2)),
        other => panic!("{other}"),
    }
}

#[test]
fn a_rope_below_the_confidence_that_a_loop_asks_for_is_not_fresh() {
    let place = Place::new("confidence");
    for (least, confidence, status, expected) in [
        // The default: more likely right than wrong.
        (None, 0.5, Status::Ok, "fresh"),
        (None, 0.49, Status::Ok, "LowConfidence"),
        (None, 0.05, Status::Partial, "LowConfidence"),
        (Some(0.0), 0.0, Status::Ok, "fresh"),
        (None, f32::NAN, Status::Ok, "LowConfidence"),
        (Some(0.9), 0.91, Status::Ok, "fresh"),
        (Some(0.9), 0.91, Status::Partial, "partial"),
        (Some(0.9), 0.89, Status::Ok, "LowConfidence"),
        (Some(0.9), 0.89, Status::Partial, "LowConfidence"),
        (Some(0.9), f32::NAN, Status::Ok, "LowConfidence"),
        (Some(f32::NAN), 1.0, Status::Ok, "LowConfidence"),
        (Some(0.9), 0.89, Status::Doubtful, "NoRope"),
    ] {
        let (mut reader, mut chain) = (place.reader(), place.chain());
        if let Some(least) = least {
            reader.min_confidence(least);
        }
        let mut sent = rope(1, status, 5.0);
        sent.confidence = confidence;
        chain.send(&[sent]);
        let frame = reader.latest().unwrap();
        let seen = frame.only_rope(ANY_AGE);
        if expected == "LowConfidence" && !confidence.is_nan() {
            let sentence = format!("has a confidence of {:.0} % only", 100.0 * confidence);
            assert!(seen.to_string().contains(&sentence), "{seen}");
        }
        let said = match seen {
            Seen::Fresh(_) => "fresh".to_owned(),
            Seen::Partial(_) => "partial".to_owned(),
            Seen::Unsure(_, why) => format!("{why:?}"),
            other => other.to_string(),
        };
        assert_eq!(said, expected, "{least:?} {confidence} {status:?}");
    }
}

/// State that a reader reports for a rope with this status and fit.
fn seen_as(place: &Place, accept: bool, status: Status, fit: u32) -> String {
    let (mut reader, mut chain) = (place.reader(), place.chain());
    reader.accept_coarse(accept);
    let mut sent = rope(1, status, 5.0);
    (sent.fit, sent.max, sent.width) = (fit, 15.84, 18.0);
    chain.send(&[sent]);
    match reader.latest().unwrap().only_rope(ANY_AGE) {
        Seen::Fresh(_) => "fresh".to_owned(),
        Seen::Partial(_) => "partial".to_owned(),
        Seen::Unsure(_, why) => format!("{why:?}"),
        other => other.to_string(),
    }
}

#[test]
fn a_coarse_curve_is_not_fresh_and_a_loop_that_accepts_it_gets_it() {
    let place = Place::new("coarse");
    let [unjudged, good, coarse] =
        [FitQuality::NotJudged, FitQuality::Good, FitQuality::Coarse].map(|fit| fit as u32);
    for (accept, status, fit, expected) in [
        // A writer that does not check the fit is trusted.
        (false, Status::Ok, unjudged, "fresh"),
        (false, Status::Ok, good, "fresh"),
        (false, Status::Partial, good, "partial"),
        (false, Status::Ok, coarse, "Coarse"),
        (false, Status::Partial, coarse, "Coarse"),
        (true, Status::Ok, coarse, "fresh"),
        (true, Status::Partial, coarse, "partial"),
        // The doubt about a rope is independent of the fit of its curve.
        (false, Status::Doubtful, good, "NoRope"),
        (false, Status::Doubtful, coarse, "NoRope"),
        (true, Status::Doubtful, good, "NoRope"),
        (false, Status::Ok, 3, &Absent::Unreadable.to_string()),
    ] {
        let said = seen_as(&place, accept, status, fit);
        assert_eq!(said, expected, "{accept} {status:?} {fit}");
    }
}

#[test]
fn an_unsure_rope_says_why_and_its_centerline_is_there() {
    let place = Place::new("unsure");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let mut coarse = rope(3, Status::Ok, 5.0);
    (coarse.fit, coarse.max, coarse.width) = (FitQuality::Coarse as u32, 15.84, 18.0);
    let doubtful = rope(4, Status::Doubtful, 9.0);
    chain.send(&[coarse, doubtful]);
    let frame = reader.latest().unwrap();
    let said: Vec<String> = frame.ropes(ANY_AGE).map(|seen| seen.to_string()).collect();
    assert_eq!(
        said,
        [
            "the curve of rope 3 misses it by up to 15.8, where it is 18.0 wide: its centerline is right, and \
             `lariat run --basis auto` finds a curve that lies on it",
            "rope 4 is doubtful: it may not be a rope, but a shadow, a pen or an edge",
        ]
    );
    let lines = frame.ropes(ANY_AGE).map(|seen| match seen {
        Seen::Unsure(rope, _) => rope.centerline().unwrap(),
        other => panic!("{other}"),
    });
    let lines: Vec<Centerline> = lines.collect();
    let line = lines[0];
    assert_eq!(line.points(), [[5.0, 0.0], [5.0, 50.0], [5.0, 100.0]]);
    assert_eq!(line.widths(), [10.0, 11.0, 12.0]);
    assert!(!line.is_hidden(1) && line.is_hidden(2) && !line.is_closed());
    assert_eq!(lines[1].points()[0], [9.0, 0.0]);
    // Stale and lost ropes have centerlines as well, unless the writer sends none.
    chain.send_as(now_ns() - 2_000_000_000, [640, 480], &[coarse]);
    let frame = reader.latest().unwrap();
    let Seen::Stale(last) = frame.only_rope(Duration::from_secs(1)) else {
        panic!("it is two seconds old");
    };
    assert!(last.as_it_was().centerline().is_some());
    assert!(Centerline::of(&CenterlinePoints::EMPTY).is_none());
}

#[test]
fn a_frame_that_is_kept_says_the_same_and_nothing_stale() {
    let place = Place::new("kept");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    // The slots of the channel have held other ropes.
    for _ in 0..20 {
        chain.send(&[rope(8, Status::Ok, 8.0), rope(9, Status::Ok, 9.0)]);
        reader.latest().unwrap();
    }
    let mut coarse = rope(3, Status::Ok, 5.0);
    coarse.fit = FitQuality::Coarse as u32;
    chain.send(&[coarse]);
    let frame = reader.latest().unwrap();
    let kept = frame.keep();
    let (was, now) = (frame.message().unwrap(), kept.frame().message().unwrap());
    assert!((now.trace, now.count, now.unit) == (was.trace, 1, was.unit));
    assert!(now.curves() == was.curves() && now.centerlines() == was.centerlines());
    assert!(now.curves[1].track == 0 && now.centerlines[1].count == 0);
    let seen = frame.only_rope(ANY_AGE).to_string();
    assert_eq!(kept.frame().only_rope(ANY_AGE).to_string(), seen);
}

#[test]
fn no_rope_and_no_image_are_told_from_each_other() {
    let place = Place::new("nothing");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let why = |reader: &mut Reader, max_age| match reader.latest().unwrap().only_rope(max_age) {
        Seen::Absent(why) => why,
        other => panic!("{other}"),
    };
    chain.send(&[]);
    assert_eq!(why(&mut reader, ANY_AGE), Absent::NoRope);
    chain.send_as(now_ns(), [0, 0], &[]);
    assert_eq!(why(&mut reader, ANY_AGE), Absent::NoImage);
    assert_eq!(why(&mut reader, Duration::ZERO), Absent::NothingLately);
}

#[test]
fn of_several_ropes_none_is_the_only_one_and_each_has_its_track() {
    let place = Place::new("several");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let two = [rope(4, Status::Ok, 4.0), rope(7, Status::Lost, 7.0)];
    chain.send(&two);
    let frame = reader.latest().unwrap();
    // Also if all but one are lost, because the visible one may not be the intended one.
    assert!(matches!(
        frame.only_rope(ANY_AGE),
        Seen::Absent(Absent::Several)
    ));
    let tracks = frame.ropes(ANY_AGE).filter_map(|seen| match seen {
        Seen::Fresh(rope) => Some(rope.track()),
        _ => None,
    });
    let tracks: Vec<Track> = tracks.collect();
    let [track] = tracks[..] else {
        panic!("one of them is seen");
    };
    assert_eq!(track.number(), 4);
    chain.send(&[two[1], two[0]]);
    let Seen::Fresh(rope) = reader.latest().unwrap().rope(track, ANY_AGE) else {
        panic!("it is seen");
    };
    assert_eq!(x_of(&rope), 4.0);
    chain.send(&two[1..]);
    assert!(matches!(
        reader.latest().unwrap().rope(track, ANY_AGE),
        Seen::Absent(Absent::NoRope)
    ));
}

#[test]
fn a_chain_restarted_numbers_ropes_again_and_no_old_track_finds_one() {
    let place = Place::new("again");
    let mut reader = place.reader();
    let mut chain = place.chain();
    chain.send(&[rope(1, Status::Ok, 5.0)]);
    let Seen::Fresh(seen) = reader.latest().unwrap().only_rope(ANY_AGE) else {
        panic!("it is seen");
    };
    let track = seen.track();
    drop(chain);
    // Until a new chain sends, the old shape stays and gets older.
    assert!(matches!(
        reader.latest().unwrap().rope(track, Duration::ZERO),
        Seen::Stale(_)
    ));
    let mut chain = place.chain();
    chain.send(&[rope(1, Status::Ok, 6.0)]);
    let frame = reader.latest().unwrap();
    assert!(frame.is_new() && frame.run() == 2);
    assert!(matches!(
        frame.rope(track, ANY_AGE),
        Seen::Absent(Absent::OtherRun)
    ));
    let Seen::Fresh(seen) = frame.only_rope(ANY_AGE) else {
        panic!("it is seen");
    };
    assert_eq!((x_of(&seen), seen.track().run()), (6.0, 2));
}

#[test]
fn numbers_that_make_no_rope_are_no_rope() {
    let place = Place::new("broken");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let good = rope(1, Status::Ok, 5.0);
    let mut cases = [good; 3];
    cases[0].status = 9;
    cases[1].count = 99;
    cases[2].control_points[1] = [f64::INFINITY, 0.0];
    for broken in cases {
        chain.send(&[broken]);
        assert!(matches!(
            reader.latest().unwrap().only_rope(ANY_AGE),
            Seen::Absent(Absent::Unreadable)
        ));
    }
}

#[test]
fn a_waiting_reader_wakes_for_a_message_or_its_deadline() {
    let place = Place::new("wait");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let soon = Instant::now() + Duration::from_millis(5);
    assert!(!reader.wait(soon).unwrap().is_new());
    assert!(Instant::now() >= soon);
    chain.send(&[rope(1, Status::Ok, 5.0)]);
    let far = Instant::now() + Duration::from_secs(3600);
    assert!(reader.wait(far).unwrap().is_new());
}

#[test]
fn a_reader_goes_to_the_thread_that_reads() {
    let place = Place::new("thread");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let control = std::thread::spawn(move || {
        let far = Instant::now() + Duration::from_secs(60);
        match reader.wait(far).unwrap().only_rope(ANY_AGE) {
            Seen::Fresh(rope) => x_of(&rope),
            other => panic!("{other}"),
        }
    });
    chain.send(&[rope(1, Status::Ok, 5.0)]);
    assert_eq!(control.join().unwrap(), 5.0);
}

#[test]
fn a_poll_of_ones_own_is_woken_and_does_not_spin() {
    let place = Place::new("poll");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let sleep = |reader: &mut Reader, at_most_ms: u64| {
        let longest = reader.before_poll().unwrap();
        let own = Duration::from_millis(at_most_ms);
        let timeout = longest.map_or(own, |longest| longest.min(own));
        let timeout = Timespec::try_from(timeout).unwrap();
        poll(&mut [PollFd::new(&*reader, PollFlags::IN)], Some(&timeout)).unwrap()
    };
    // Drain the call that the writer sent when it joined.
    sleep(&mut reader, 0);
    assert_eq!(sleep(&mut reader, 1), 0, "nothing came");
    let longest = reader.before_poll().unwrap();
    assert!(longest.is_none_or(|longest| longest > Duration::ZERO));
    chain.send(&[rope(1, Status::Ok, 5.0)]);
    let message_waits = Some(Duration::ZERO);
    assert_eq!(reader.before_poll().unwrap(), message_waits);
    assert!(reader.latest().unwrap().is_new());
    assert_eq!(sleep(&mut reader, 1), 0, "its bell was emptied");
    let control = std::thread::spawn(move || {
        let readable = sleep(&mut reader, 60_000);
        (readable, reader.latest().unwrap().is_new())
    });
    chain.send(&[rope(1, Status::Ok, 6.0)]);
    let (_, is_new) = control.join().unwrap();
    assert!(is_new);
}

#[test]
fn a_slow_or_silent_reader_does_not_hold_up_the_chain() {
    let place = Place::new("slow");
    let (mut reader, _silent) = (place.reader(), place.reader());
    let mut chain = place.chain();
    for x in 0..1000 {
        chain.send(&[rope(1, Status::Ok, f64::from(x))]);
    }
    let Seen::Fresh(rope) = reader.latest().unwrap().only_rope(ANY_AGE) else {
        panic!("it is seen");
    };
    assert_eq!(x_of(&rope), 999.0);
}

#[test]
fn a_sentence_says_what_is_seen() {
    let place = Place::new("says");
    let (mut reader, mut chain) = (place.reader(), place.chain());
    let says = |reader: &mut Reader| reader.latest().unwrap().only_rope(ANY_AGE).to_string();
    assert_eq!(
        says(&mut reader),
        "nothing came yet: the chain does not run, waits for its source or its masks, or has just been joined"
    );
    chain.send(&[rope(3, Status::Ok, 5.0)]);
    assert_eq!(says(&mut reader), "rope 3 is seen whole");
    let mut partial = rope(3, Status::Partial, 5.0);
    partial.hidden = 30;
    chain.send(&[partial]);
    assert_eq!(says(&mut reader), "25 % of rope 3 is covered");
}
