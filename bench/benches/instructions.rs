//! Instructions of the parts that decide lariat's speed, counted by valgrind: `.ci/gates instructions` holds them against its record.
//!
//! A count is exact on a busy machine, where a time is not. It is that of the build that runs the tests: valgrind knows no AVX-512, and
//! extraction is compiled at level 1 there, so that only its changes mean anything.
#![allow(missing_docs)] // gungraun's macros make undocumented functions.

#[allow(dead_code, reason = "written for the timings of extraction")]
#[path = "extract/paint.rs"]
mod paint;

use std::hint::black_box;

use gungraun::{library_benchmark, library_benchmark_group, main};
use lariat_bench::{Picture, rendered};
use lariat_capture::RenderOptions;
use lariat_drawn::scenes::{Class, draw};
use lariat_extract::{Extractor, Options};
use lariat_fit::{Fitter, Solver};
use lariat_network::{Maps, Network, Workspace};
use lariat_wire::{DESCRIPTORS, Delivery, Descriptors, Domain, Receiver, Rig, Writer};

/// The size of all pictures.
const SIZE: [usize; 2] = [640, 480];
/// Frames that are followed before the one that counts.
const FRAMES_BEFORE: u64 = 6;

fn still(class: Class) -> Picture {
    let still = draw(class, 1, SIZE[0], SIZE[1]).expect("seed 1 fits");
    Picture::rgb(SIZE, &still.rgb).expect("a picture")
}

fn extractor() -> Extractor {
    let mut extractor = Extractor::new(Options::default()).expect("the default");
    extractor.prepare(SIZE[0], SIZE[1]);
    extractor
}

/// An extractor that has seen no picture, and its first one.
fn first(picture: Picture) -> (Extractor, Picture) {
    (extractor(), picture)
}

/// An extractor that follows the rendered rope, and the next frame.
fn next_frame() -> (Extractor, Picture) {
    let options = RenderOptions {
        frames: Some(FRAMES_BEFORE + 1),
        ..RenderOptions::default()
    };
    let mut film = rendered(&options).expect("a film");
    let last = film.pop().expect("a frame").picture;
    let mut extractor = extractor();
    for frame in &film {
        extractor.extract(&frame.picture.image());
    }
    (extractor, last)
}

#[library_benchmark]
#[bench::one_crossing(first(still(Class::Crossings1)))]
#[bench::five_crossings(first(still(Class::Crossings5)))]
#[bench::ten_crossings(first(paint::ten_crossings().expect("a picture")))]
#[bench::eight_ropes(first(paint::eight_ropes().expect("a picture")))]
#[bench::followed_frame(next_frame())]
fn extraction((mut extractor, picture): (Extractor, Picture)) -> (Extractor, Picture) {
    black_box(extractor.extract(&picture.image()).curves.len());
    (extractor, picture)
}

fn points() -> Vec<[f64; 2]> {
    let at = |i: i32| {
        let t = f64::from(i) / 119.0;
        [50.0 + 540.0 * t, 240.0 + 150.0 * (5.0 * t).sin()]
    };
    (0..120).map(at).collect()
}

/// As many points as the chain has, and a solver.
fn options(solver: Solver) -> lariat_fit::Options {
    lariat_fit::Options {
        points: 120,
        solver,
        ..lariat_fit::Options::bezier(8)
    }
}

fn fitter(solver: Solver) -> (Fitter, Vec<[f64; 2]>) {
    let fitter = Fitter::new(options(solver)).expect("well conditioned");
    (fitter, points())
}

#[library_benchmark]
#[bench::pinv(fitter(Solver::Pinv))]
#[bench::cholesky(fitter(Solver::Cholesky))]
#[bench::qr(fitter(Solver::Qr))]
fn fit((mut fitter, points): (Fitter, Vec<[f64; 2]>)) -> (Fitter, Vec<[f64; 2]>) {
    let rms_px = fitter.fit(&points).map(|fit| fit.rms_px);
    black_box(rms_px).expect("a curve");
    (fitter, points)
}

#[library_benchmark]
#[bench::pinv(options(Solver::Pinv))]
fn fit_set_up(options: lariat_fit::Options) -> Fitter {
    Fitter::new(options).expect("well conditioned")
}

fn network() -> (Workspace, Picture, [Vec<u8>; 2]) {
    let size = [160, 128];
    let still = draw(Class::Medium, 1, 160, 160).expect("seed 1 fits");
    let picture = Picture::rgb(size, &still.rgb[..3 * size[0] * size[1]]).expect("a picture");
    Network::ropes();
    let mut workspace = Workspace::new();
    workspace.reserve(size[0], size[1]);
    let maps = [(); 2].map(|()| vec![0; size[0] * size[1]]);
    (workspace, picture, maps)
}

type Seen = (Workspace, Picture, [Vec<u8>; 2]);

#[library_benchmark]
#[bench::all_layers(network())]
fn mask_network((mut workspace, picture, mut maps): Seen) -> Seen {
    let [width, height] = picture.size();
    let seen = lariat_network::Picture {
        rgb: picture.bytes(),
        width,
        height,
        stride: 3 * width,
    };
    let [rope, seam] = &mut maps;
    let stride = width;
    let told = Network::ropes().run(&mut workspace, seen, Maps { rope, seam, stride });
    told.expect("room for the maps");
    (workspace, picture, maps)
}

type Channel = (Domain, Writer<Descriptors>, Receiver<Descriptors>);

fn channel() -> Channel {
    let domain = Domain::named(&format!("gate-{}", std::process::id())).expect("a domain");
    let rig: Rig = "default".parse().expect("a name");
    let writer = Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins)
        .expect("the only one");
    let reader = Receiver::descriptors(&domain, &rig).expect("a reader");
    // The first message finds the readers that there are.
    for _ in 0..2 {
        writer.slot().expect("a slot").send().expect("sent");
        reader.next().expect("readable");
    }
    (domain, writer, reader)
}

#[library_benchmark]
#[bench::descriptors(channel())]
fn message_written_and_read((domain, writer, reader): Channel) -> Channel {
    let slot = writer.slot().expect("a slot");
    slot.send().expect("sent");
    let message = reader.next().expect("readable").expect("a message");
    black_box(message.curves().len());
    drop(message);
    (domain, writer, reader)
}

library_benchmark_group!(
    name = parts;
    benchmarks = extraction,
    fit,
    fit_set_up,
    mask_network,
    message_written_and_read
);

main!(library_benchmark_groups = parts);
