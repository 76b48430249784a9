//! A film, the extractors that see it, and what they took.

use std::hint::black_box;
use std::time::{Duration, Instant};

use anyhow::Result;
use lariat_bench::{Picture, ReadPass, Samples};
use lariat_extract::{Extractor, Options};

/// Turns that a table has at least.
const FEWEST_TURNS: usize = 3;

/// What extractions took, in nanoseconds.
#[derive(Default)]
pub(crate) struct Times {
    /// Mask, skeleton, graph, points.
    pub(crate) steps: [Samples; 4],
    pub(crate) whole: Samples,
}

/// A film, and what was measured on it.
pub(crate) struct Case {
    pub(crate) name: String,
    film: Vec<Picture>,
    cold: Extractor,
    tracked: Extractor,
    pub(crate) read_ns: Samples,
    pub(crate) cold_ns: Times,
    pub(crate) tracked_ns: Times,
    /// Area of the ropes found in a frame, cold, in pixels.
    pub(crate) rope_px2: Samples,
    /// How many were found.
    pub(crate) ropes: Samples,
}

impl Case {
    /// A case of a film whose frames are of one size, with the extractor's default options.
    pub(crate) fn new(name: impl Into<String>, film: Vec<Picture>) -> Result<Self> {
        Self::with(name, film, Options::default())
    }

    pub(crate) fn with(
        name: impl Into<String>,
        film: Vec<Picture>,
        options: Options,
    ) -> Result<Self> {
        let [mut cold, mut tracked] = [Extractor::new(options.clone())?, Extractor::new(options)?];
        if let Some(first) = film.first() {
            let [width, height] = first.size();
            cold.prepare(width, height);
            tracked.prepare(width, height);
        }
        Ok(Self {
            name: name.into(),
            film,
            cold,
            tracked,
            read_ns: Samples::default(),
            cold_ns: Times::default(),
            tracked_ns: Times::default(),
            rope_px2: Samples::default(),
            ropes: Samples::default(),
        })
    }

    /// Pixels of a frame.
    pub(crate) fn pixels(&self) -> f64 {
        let pixels = |picture: &Picture| picture.size().iter().product::<usize>() as f64;
        self.film.first().map_or(0.0, pixels)
    }

    /// Bytes of a frame.
    pub(crate) fn bytes(&self) -> f64 {
        self.film.first().map_or(0, |p| p.bytes().len()) as f64
    }

    /// Once through the film.
    fn turn(&mut self, read: &ReadPass) {
        self.tracked.reset();
        for (k, frame) in self.film.iter().enumerate() {
            let bytes = frame.bytes();
            let fetch = || black_box(read.sum(black_box(bytes)));
            fetch();
            self.read_ns.time(fetch);
            fetch();
            self.cold.reset();
            let (ropes, area_px2) = timed(&mut self.cold, frame, &mut self.cold_ns);
            self.ropes.push(ropes as f64);
            self.rope_px2.push(area_px2);
            fetch();
            if k == 0 {
                self.tracked.extract(&frame.image());
            } else {
                timed(&mut self.tracked, frame, &mut self.tracked_ns);
            }
        }
    }

    fn forget(&mut self) {
        (self.cold_ns, self.tracked_ns) = Default::default();
        (self.read_ns, self.ropes, self.rope_px2) = Default::default();
    }
}

/// Lets the cases take turns for that long; returns how many turns each had.
pub(crate) fn measure(cases: &mut [Case], time: Duration) -> usize {
    let read = ReadPass::default();
    for case in &mut *cases {
        case.turn(&read);
        case.forget();
    }
    let start = Instant::now();
    let mut turns = 0;
    while turns < FEWEST_TURNS || start.elapsed() < time {
        cases.iter_mut().for_each(|case| case.turn(&read));
        turns += 1;
    }
    turns
}

/// One extraction; how many ropes it found, and their area in pixels.
fn timed(extractor: &mut Extractor, frame: &Picture, times: &mut Times) -> (usize, f64) {
    let image = frame.image();
    let start = Instant::now();
    let (mut last, mut step) = (start, 0);
    let scene = extractor.extract_observed(&image, &mut |_| {
        let now = Instant::now();
        times.steps[step].push((now - last).as_secs_f64() * 1e9);
        (last, step) = (now, step + 1);
    });
    times.whole.push(start.elapsed().as_secs_f64() * 1e9);
    let areas = scene.curves.iter().map(|c| c.length_px * c.width_px);
    (scene.curves.len(), f64::from(areas.sum::<f32>()))
}
