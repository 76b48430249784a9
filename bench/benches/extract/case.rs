//! A film, the extractors that process it, and their timings.

use std::hint::black_box;
use std::time::{Duration, Instant};

use anyhow::Result;
use lariat_bench::{Picture, ReadPass, Samples};
use lariat_extract::{Extractor, Mask, Options, Scene, Step};

/// Minimum number of turns per table.
const FEWEST_TURNS: usize = 3;

/// The steps that are timed. Index [`WHOLE`] holds the total after them.
pub(crate) const STEPS: [Step; 5] = [
    Step::Follow,
    Step::Mask,
    Step::Skeleton,
    Step::Graph,
    Step::Points,
];
pub(crate) const WHOLE: usize = STEPS.len();

/// Timings of extractions: each step and the whole.
#[derive(Default)]
pub(crate) struct Times {
    /// Times in nanoseconds.
    pub(crate) ns: [Samples; WHOLE + 1],
    /// Times divided by the time of the preceding read of the same frame.
    pub(crate) over_read: [Samples; WHOLE + 1],
}

impl Times {
    /// Median time of the whole extraction, in nanoseconds.
    pub(crate) fn whole_ns(&self) -> f64 {
        self.ns[WHOLE].median()
    }

    /// Median of the whole extraction's time divided by the read time.
    pub(crate) fn whole_over_read(&self) -> f64 {
        self.over_read[WHOLE].median()
    }
}

/// A film and its measurements.
pub(crate) struct Case {
    pub(crate) name: String,
    film: Vec<Picture>,
    /// One mask per picture of the film, or empty.
    masks: Vec<Picture>,
    forgetful: Extractor,
    mindful: Extractor,
    pub(crate) read_ns: Samples,
    pub(crate) cold: Times,
    pub(crate) tracked: Times,
    /// Area of the ropes found in a frame by the cold extractor, in square pixels.
    pub(crate) rope_px2: Samples,
    /// Number of ropes found in a frame.
    pub(crate) ropes: Samples,
}

impl Case {
    /// Creates a case with the extractor's default options. All frames of `film` must have one
    /// size.
    pub(crate) fn new(name: impl Into<String>, film: Vec<Picture>) -> Result<Self> {
        Self::with(name, film, Options::default())
    }

    pub(crate) fn with(
        name: impl Into<String>,
        film: Vec<Picture>,
        options: Options,
    ) -> Result<Self> {
        let [mut forgetful, mut mindful] =
            [Extractor::new(options.clone())?, Extractor::new(options)?];
        if let Some(first) = film.first() {
            let [width, height] = first.size();
            forgetful.prepare(width, height);
            mindful.prepare(width, height);
        }
        Ok(Self {
            name: name.into(),
            film,
            masks: Vec::new(),
            forgetful,
            mindful,
            read_ns: Samples::default(),
            cold: Times::default(),
            tracked: Times::default(),
            rope_px2: Samples::default(),
            ropes: Samples::default(),
        })
    }

    /// Creates a case whose pictures come with external masks.
    pub(crate) fn masked(
        name: impl Into<String>,
        film: Vec<Picture>,
        masks: Vec<Picture>,
    ) -> Result<Self> {
        let options = Options::default().mask(Mask::External);
        Ok(Self {
            masks,
            ..Self::with(name, film, options)?
        })
    }

    /// Number of pixels in a frame.
    pub(crate) fn pixels(&self) -> f64 {
        let pixels = |picture: &Picture| picture.size().iter().product::<usize>() as f64;
        self.film.first().map_or(0.0, pixels)
    }

    /// Number of bytes in a frame.
    pub(crate) fn bytes(&self) -> f64 {
        self.film.first().map_or(0, |p| p.bytes().len()) as f64
    }

    /// Runs once through the film.
    fn turn(&mut self, read: &ReadPass) -> Result<()> {
        self.mindful.reset();
        for (k, frame) in self.film.iter().enumerate() {
            let (bytes, mask) = (frame.bytes(), self.masks.get(k));
            let fetch = || black_box(read.sum(black_box(bytes)));
            fetch();
            let read_ns = self.read_ns.time(fetch);
            fetch();
            self.forgetful.reset();
            let found = timed(&mut self.forgetful, (frame, mask), read_ns, &mut self.cold)?;
            self.ropes.push(found.ropes as f64);
            self.rope_px2.push(found.area_px2);
            fetch();
            if k == 0 {
                see(&mut self.mindful, (frame, mask), &mut |_| {})?;
            } else {
                timed(&mut self.mindful, (frame, mask), read_ns, &mut self.tracked)?;
            }
        }
        Ok(())
    }

    fn forget(&mut self) {
        (self.cold, self.tracked) = Default::default();
        (self.read_ns, self.ropes, self.rope_px2) = Default::default();
    }
}

/// Measures the cases in turns for at least `time`. Returns the number of turns of each case.
pub(crate) fn measure(cases: &mut [Case], time: Duration) -> Result<usize> {
    let read = ReadPass::default();
    for case in &mut *cases {
        case.turn(&read)?;
        case.forget();
    }
    let start = Instant::now();
    let mut turns = 0;
    while turns < FEWEST_TURNS || start.elapsed() < time {
        cases.iter_mut().try_for_each(|case| case.turn(&read))?;
        turns += 1;
    }
    Ok(turns)
}

/// The result of an extraction.
struct Found {
    ropes: usize,
    area_px2: f64,
}

/// A picture and its mask, if any.
type Frame<'a> = (&'a Picture, Option<&'a Picture>);

fn see<'a>(
    extractor: &'a mut Extractor,
    (picture, mask): Frame,
    after: &mut dyn FnMut(Step),
) -> Result<Scene<'a>> {
    let image = picture.image();
    Ok(match mask {
        Some(mask) => extractor.extract_masked_observed(&image, &mask.image(), after)?,
        None => extractor.extract_observed(&image, after),
    })
}

fn timed(extractor: &mut Extractor, seen: Frame, read_ns: f64, times: &mut Times) -> Result<Found> {
    let start = Instant::now();
    let (mut last, mut ns) = (start, [0.0; WHOLE + 1]);
    let scene = see(extractor, seen, &mut |step| {
        let now = Instant::now();
        if let Some(k) = STEPS.iter().position(|&s| s == step) {
            ns[k] = (now - last).as_secs_f64() * 1e9;
        }
        last = now;
    })?;
    ns[WHOLE] = start.elapsed().as_secs_f64() * 1e9;
    for (k, ns) in ns.into_iter().enumerate() {
        times.ns[k].push(ns);
        times.over_read[k].push(ns / read_ns);
    }
    let areas = scene.curves.iter().map(|c| c.length_px * c.width_px);
    Ok(Found {
        ropes: scene.curves.len(),
        area_px2: f64::from(areas.sum::<f32>()),
    })
}
