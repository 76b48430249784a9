//! The simulated rope rests without commands. Commands move it from the time when they were sent,
//! and its truth matches the drawing.

use std::sync::{Arc, Mutex};

use lariat_capture::{
    Commands, FrameSource, HandOptions, Pace, SimulatedOptions, Source, open, open_simulated,
};
use lariat_extract::{Extractor, HsvRange, Image, Mask, Options, PixelFormat, Status};
use lariat_message::{Centerlines, Command, now_ns};

const FPS: f64 = 250.0;

fn options() -> SimulatedOptions {
    SimulatedOptions {
        pace: Pace::Fps(FPS),
        ..SimulatedOptions::default()
    }
}

/// A queue of commands.
#[derive(Clone, Default)]
struct Letterbox(Arc<Mutex<Vec<Command>>>);

impl Letterbox {
    fn send(&self, sent_ns: u64, velocities: [[f64; 3]; 2]) {
        self.0.lock().unwrap().push(Command {
            sent_ns,
            grippers: 2,
            velocities: velocities.map(|[x, y, turn]| [x, y, 0.0, 0.0, 0.0, turn]),
            ..Command::default()
        });
    }

    fn reader(&self) -> Commands {
        let letters = self.0.clone();
        Box::new(move || {
            let mut letters = letters.lock().unwrap();
            (!letters.is_empty()).then(|| letters.remove(0))
        })
    }
}

fn truth(source: &dyn FrameSource) -> Box<Centerlines> {
    let mut truth = Box::new(Centerlines::EMPTY);
    assert!(source.truth(&mut truth));
    truth
}

fn distance(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn without_commands_the_rope_rests_and_every_frame_has_its_moment() {
    let mut source = open(&Source::Simulated(options())).unwrap();
    let first = source.next().unwrap().unwrap();
    let (start_ns, start) = (first.exposed_ns.unwrap(), truth(source.as_ref()));
    let mut last = first;
    for _ in 0..20 {
        let frame = source.next().unwrap().unwrap();
        let after_ns = frame.exposed_ns.unwrap() - start_ns;
        let expected_ns = (frame.sequence - 1) as f64 * 1e9 / FPS;
        assert!((after_ns as f64 - expected_ns).abs() < 2.0, "{after_ns}");
        assert!(frame.exposed_ns < Some(now_ns()) && frame.sequence > last.sequence);
        last = frame;
    }
    let end = truth(source.as_ref());
    let pairs = start.curves()[0]
        .points()
        .iter()
        .zip(end.curves()[0].points());
    assert!(pairs.clone().count() == 120);
    assert!(pairs.into_iter().all(|(a, b)| distance(*a, *b) < 0.01));
}

#[test]
fn a_command_takes_effect_when_it_was_sent_and_a_silent_controller_stops_the_robot() {
    let letters = Letterbox::default();
    let mut source = open_simulated(&options(), letters.reader()).unwrap();
    let first = source.next().unwrap().unwrap();
    let start = truth(source.as_ref()).curves()[0].points()[0];
    // To the left from 100 ms on. The command is sent earlier and waits for its moment.
    let sent_ns = first.exposed_ns.unwrap() + 100_000_000;
    letters.send(sent_ns, [[-100.0, 0.0, 0.0], [-100.0, 0.0, 0.0]]);
    loop {
        let frame = source.next().unwrap().unwrap();
        let after_s = (frame.exposed_ns.unwrap() as f64 - sent_ns as f64) * 1e-9;
        let at = truth(source.as_ref()).curves()[0].points()[0];
        // The watchdog ends it after 0.25 s; a step takes 1 ms.
        let expected = f64::from(start[0]) - 100.0 * after_s.clamp(0.0, 0.25);
        let off = (f64::from(at[0]) - expected).abs();
        assert!(off < 0.25, "{after_s}: {at:?}, {expected}");
        assert!((at[1] - start[1]).abs() < 0.01);
        if after_s > 0.35 {
            break;
        }
    }
}

#[test]
fn what_is_between_the_jaws_is_seen_and_grippers_are_no_rope() {
    for seed in 1..=4 {
        let mut options = options();
        options.simulation.seed = seed;
        let mut source = open(&Source::Simulated(options)).unwrap();
        let mut extractor = Extractor::new(lariat_extract::Options::default()).unwrap();
        for _ in 0..5 {
            let frame = source.next().unwrap().unwrap();
            let mut pixels = vec![0; frame.bytes()];
            source.write(&mut pixels);
            let image = Image::new(&pixels, 640, 480, 1920, PixelFormat::Rgb8).unwrap();
            let scene = extractor.extract(&image);
            assert_eq!(scene.curves.len(), 1, "seed {seed}");
            let curve = &scene.curves[0];
            let truth = truth(source.as_ref());
            let truth = truth.curves()[0].points();
            let nearest = |p: &[f32; 2]| {
                let all = truth
                    .windows(2)
                    .map(|pair| to_segment(*p, pair[0], pair[1]));
                all.fold(f32::MAX, f32::min)
            };
            let mean = curve.points.iter().map(nearest).sum::<f32>() / curve.points.len() as f32;
            assert!(mean < 1.0, "seed {seed}: {mean}");
            let ends = [curve.points[0], curve.points[curve.points.len() - 1]];
            for end in [truth[0], truth[truth.len() - 1]] {
                let off = distance(end, ends[0]).min(distance(end, ends[1]));
                assert!(off < 5.0, "seed {seed}: {off}");
            }
        }
    }
}

fn to_segment(p: [f32; 2], a: [f32; 2], b: [f32; 2]) -> f32 {
    let [x, y] = [b[0] - a[0], b[1] - a[1]];
    let share = ((p[0] - a[0]) * x + (p[1] - a[1]) * y) / (x * x + y * y);
    let share = share.clamp(0.0, 1.0);
    distance(p, [a[0] + share * x, a[1] + share * y])
}

#[test]
fn a_hand_hides_a_part_of_the_rope_while_it_rests_there() {
    let mut source = open(&Source::Simulated(SimulatedOptions {
        hand: Some(HandOptions {
            at_s: 0.4,
            for_s: 0.2,
        }),
        ..options()
    }))
    .unwrap();
    // Selects by the rope's color, because fingers at the picture's edge are about as wide as a
    // rope.
    let blue = HsvRange {
        hue_deg: [190.0, 250.0],
        saturation: [0.3, 1.0],
        value: [0.1, 1.0],
    };
    let mut extractor = Extractor::new(Options::default().mask(Mask::Hsv(vec![blue]))).unwrap();
    let mut start_ns = None;
    loop {
        let frame = source.next().unwrap().unwrap();
        let start_ns = *start_ns.get_or_insert(frame.exposed_ns.unwrap());
        let after_s = (frame.exposed_ns.unwrap() - start_ns) as f64 * 1e-9;
        let mut pixels = vec![0; frame.bytes()];
        source.write(&mut pixels);
        let image = Image::new(&pixels, 640, 480, 1920, PixelFormat::Rgb8).unwrap();
        let scene = extractor.extract(&image);
        if (0.0..0.05).contains(&after_s) || after_s > 0.95 {
            assert_eq!(scene.curves.len(), 1, "{after_s}");
        }
        if (0.42..0.58).contains(&after_s) {
            let hidden = |curve: &lariat_extract::Curve| {
                curve.status == Status::Lost || curve.hidden.iter().filter(|h| **h).count() > 20
            };
            assert!(scene.curves.iter().all(hidden), "{after_s}");
        }
        if after_s > 1.0 {
            break;
        }
    }
}

#[test]
fn what_cannot_be_simulated_is_refused_with_a_sentence() {
    let said = |options: SimulatedOptions| {
        let refused = open(&Source::Simulated(options)).err();
        refused.expect("refused").to_string()
    };
    assert_eq!(
        said(SimulatedOptions {
            noise: 5.0,
            ..options()
        }),
        "the simulated rope needs noise from 0 to 4, not 5"
    );
    let mut many = options();
    many.simulation.grippers = 3;
    assert_eq!(
        said(many),
        "the simulated rope needs 1 or 2 grippers, not 3"
    );
}
