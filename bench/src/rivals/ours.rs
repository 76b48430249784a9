//! Times of lariat for the same pictures, each as a scene of its own.

use std::time::Instant;

use crate::Samples;
use anyhow::Result;
use lariat_extract::{Extractor, Mask, Options};

use super::pictures::{Pictures, Shown};
use super::script::Work;

/// Times of one picture with one extractor, in nanoseconds, and the result.
#[derive(Default)]
pub(super) struct Measured {
    /// Mask, skeleton, graph, points, and the whole.
    ns: [Samples; 5],
    /// Points of the longest rope.
    pub(super) points: Vec<[f32; 2]>,
}

impl Measured {
    /// Returns the median time of the step that does this work.
    pub(super) fn median_ns(&self, work: Work) -> f64 {
        self.ns[Self::step(work).0].median()
    }

    /// Returns the index of the step that does this work, and a description of all that the step
    /// does.
    pub(super) fn step(work: Work) -> (usize, &'static str) {
        match work {
            Work::Threshold | Work::Components => (0, "mask: colours and components"),
            Work::ThinningSkimage | Work::ThinningOpencv => (1, "skeleton"),
            Work::Distance => (3, "points: centers and widths"),
            Work::Chain => (4, "whole"),
        }
    }
}

/// Both ways to segment a rope, on every picture: by given colors and automatically.
pub(super) struct Ours {
    told: Vec<(Extractor, Measured)>,
    auto: Extractor,
    found: Vec<Measured>,
}

impl Ours {
    /// Creates extractors for these pictures, with their buffers allocated.
    ///
    /// # Errors
    /// A picture's color ranges are invalid.
    pub(super) fn new(pictures: &Pictures) -> Result<Self> {
        let told = pictures.shown.iter().map(|shown| {
            let mask = Mask::Hsv(shown.ranges.clone());
            let extractor = Extractor::new(Options::default().mask(mask))?;
            Ok((extractor, Measured::default()))
        });
        Ok(Self {
            told: told.collect::<Result<_>>()?,
            auto: Extractor::new(Options::default())?,
            found: pictures.shown.iter().map(|_| Measured::default()).collect(),
        })
    }

    /// Extracts every picture in both ways, once to warm up and then `rounds` times.
    pub(super) fn measure(&mut self, pictures: &Pictures, rounds: usize) {
        let told = self.told.iter_mut().zip(&mut self.found);
        for (shown, ((told, by_colour), by_itself)) in pictures.shown.iter().zip(told) {
            for (extractor, measured) in [(told, by_colour), (&mut self.auto, by_itself)] {
                for round in 0..=rounds {
                    extract(extractor, shown, (round > 0).then_some(&mut *measured));
                }
            }
        }
    }

    /// Returns the measurement with the colors that the scripts are given.
    pub(super) fn told(&self, picture: usize) -> &Measured {
        &self.told[picture].1
    }

    /// Returns the measurement of the automatic segmentation.
    pub(super) fn by_itself(&self, picture: usize) -> &Measured {
        &self.found[picture]
    }
}

fn extract(extractor: &mut Extractor, shown: &Shown, measured: Option<&mut Measured>) {
    extractor.reset();
    let image = shown.picture.image();
    let start = Instant::now();
    let (mut last, mut step, mut ns) = (start, 0, [0.0; 5]);
    let scene = extractor.extract_observed(&image, &mut |_| {
        let now = Instant::now();
        ns[step] = (now - last).as_secs_f64() * 1e9;
        (last, step) = (now, step + 1);
    });
    ns[4] = start.elapsed().as_secs_f64() * 1e9;
    let Some(measured) = measured else {
        return;
    };
    for (samples, ns) in measured.ns.iter_mut().zip(ns) {
        samples.push(ns);
    }
    let longest = scene
        .curves
        .iter()
        .max_by(|a, b| a.length_px.total_cmp(&b.length_px));
    measured.points.clear();
    measured
        .points
        .extend(longest.iter().flat_map(|c| &c.points));
}
