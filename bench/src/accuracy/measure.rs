//! One photograph: extracted, timed, and compared with its label.

use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use image::DynamicImage;
use lariat_extract::{Crossing, Curve, Extractor, Image, Method, Options, PixelFormat, Step};

use super::causes::{self, Disagreement, Found};
use super::coverage::{Coverage, coverage};
use super::dataset::Pair;
use super::drawing::draw;
use super::labels::Labels;
use super::overlap::overlap;
use super::photo;
use super::spline;
use super::whole;
use crate::mask::Mask;

/// Times for one image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Times {
    /// Reading and decoding the file. Not part of the extraction.
    pub(super) decode: Duration,
    /// Mask, skeleton, graph, points.
    pub(super) steps: [Duration; 4],
}

impl Times {
    /// Returns the time from the image to its curves.
    pub(super) fn extract(&self) -> Duration {
        self.steps.iter().sum()
    }
}

/// All measurements of one image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measured {
    pub(super) name: String,
    /// Number of ropes in the label.
    pub(super) ropes: usize,
    pub(super) curves: Vec<Curve>,
    pub(super) crossings: Vec<Crossing>,
    /// Mean DICE over the ropes, and that of each labeled rope.
    pub(super) dice: f64,
    pub(super) rope_dice: Vec<f64>,
    pub(super) coverage: Coverage,
    /// For each curve, true if it is one whole labeled rope.
    pub(super) is_whole: Vec<bool>,
    /// True if the extraction reported that it is unsure of the picture.
    pub(super) has_notice: bool,
    pub(super) disagreement: Disagreement,
    /// Number of labeled pixels.
    pub(super) area: usize,
    pub(super) times: Times,
}

impl Measured {
    /// Returns whether the number of curves differs from the number of ropes.
    pub(super) fn is_miscounted(&self) -> bool {
        self.curves.len() != self.ropes
    }

    /// Returns whether every rope has a whole curve of its own and no curve is left over.
    pub(super) fn is_right(&self) -> bool {
        !self.is_miscounted() && self.is_whole.iter().all(|&is_whole| is_whole)
    }
}

/// An extractor for unrelated photographs.
pub(super) struct Bench {
    extractor: Extractor,
    prepared: (usize, usize),
}

impl Bench {
    /// Creates an extractor with default options apart from these two. If these have their default
    /// values too, the figures are those of an unconfigured lariat.
    pub(super) fn new(method: Method, mask: Mask) -> Result<Self> {
        Ok(Self {
            extractor: Extractor::new(Options::default().method(method).mask(mask.into()))?,
            prepared: (0, 0),
        })
    }

    /// Extracts a photograph and compares the result with its label.
    ///
    /// # Errors
    /// A file cannot be read, or photograph and label differ in size.
    pub(super) fn measure(&mut self, pair: &Pair) -> Result<Measured> {
        let label = Labels::load(&pair.label)?;
        let start = Instant::now();
        let photo = photo::load(&pair.image)?;
        let decode = start.elapsed();
        let size = (photo.width() as usize, photo.height() as usize);
        if size != (label.width, label.height) {
            bail!(
                "{} is {}×{} pixels and its label {}×{}: a label must be as large as the picture (upright, if the \
                 picture has an EXIF orientation)",
                pair.image.display(),
                size.0,
                size.1,
                label.width,
                label.height
            );
        }
        let mut measured = self
            .extract(&photo, &label)
            .with_context(|| format!("cannot extract {}", pair.image.display()))?;
        measured.name.clone_from(&pair.name);
        measured.times.decode = decode;
        Ok(measured)
    }

    /// Does the same as [`measure`](Self::measure) for pictures in memory.
    pub(super) fn extract(&mut self, photo: &DynamicImage, label: &Labels) -> Result<Measured> {
        let size = (label.width, label.height);
        let rgb;
        let (bytes, channels, format) = match photo {
            DynamicImage::ImageLuma8(grey) => (grey.as_raw(), 1, PixelFormat::Gray8),
            DynamicImage::ImageRgb8(color) => (color.as_raw(), 3, PixelFormat::Rgb8),
            other => {
                rgb = other.to_rgb8();
                (rgb.as_raw(), 3, PixelFormat::Rgb8)
            }
        };
        let image = Image::new(bytes, size.0, size.1, channels * size.0, format)?;
        if self.prepared != size {
            // Otherwise the first photograph would take longer than the rest.
            self.extractor.prepare(size.0, size.1);
            self.prepared = size;
        }
        self.extractor.reset();
        let mut times = Times::default();
        let mut last = Instant::now();
        let scene = self.extractor.extract_observed(&image, &mut |step| {
            let now = Instant::now();
            times.steps[index(step)] += now - last;
            last = now;
        });
        let (curves, crossings) = (scene.curves.to_vec(), scene.crossings.to_vec());
        let has_notice = scene.notice.is_some();
        Ok(Measured {
            has_notice,
            ..compare(label, curves, crossings, times)
        })
    }
}

/// Returns the index of a step in [`Times::steps`]. `Follow` counts as mask: the extractor is reset
/// before each image, so it never tracks.
fn index(step: Step) -> usize {
    match step {
        Step::Follow | Step::Mask => 0,
        Step::Skeleton => 1,
        Step::Graph => 2,
        Step::Points => 3,
    }
}

/// Compares the result with the label.
fn compare(label: &Labels, curves: Vec<Curve>, crossings: Vec<Crossing>, times: Times) -> Measured {
    let splines: Vec<_> = curves.iter().map(spline::through).collect();
    let drawn = draw(&curves, &crossings, (label.width, label.height));
    let overlap = overlap(label, &drawn, curves.len());
    let found = Found {
        curves: &curves,
        crossings: &crossings,
        splines: &splines,
        drawn: &drawn,
    };
    let disagreement = causes::sort(label, &found, &overlap);
    Measured {
        name: String::new(),
        ropes: overlap.ropes.len(),
        dice: overlap.dice,
        rope_dice: overlap.ropes.iter().map(|rope| rope.2).collect(),
        coverage: coverage(label, &splines),
        is_whole: whole::curves(label, &curves, &splines),
        has_notice: false,
        disagreement,
        area: label.area(),
        times,
        curves,
        crossings,
    }
}

#[cfg(test)]
pub(in crate::accuracy) mod tests {
    use super::*;
    use crate::accuracy::drawing::tests::curve;
    use image::{Rgb, RgbImage};

    /// Returns a picture of dark ropes on a light table, and its label.
    pub(in crate::accuracy) fn picture(curves: &[Curve]) -> (DynamicImage, Labels) {
        let label = draw(curves, &[], (240, 160));
        let photo = RgbImage::from_fn(240, 160, |x, y| {
            Rgb(match label.at(i64::from(x), i64::from(y)) {
                0 => [210, 205, 200],
                _ => [40, 50, 90],
            })
        });
        (DynamicImage::ImageRgb8(photo), label)
    }

    fn bars() -> [Curve; 2] {
        [50.0, 110.0].map(|y| curve(&[[30.0, y], [120.0, y + 4.0], [210.0, y]], 11.0))
    }

    #[test]
    fn ropes_that_are_plain_to_see_are_found_and_drawn_well() {
        let (photo, label) = picture(&bars());
        let measured = Bench::new(Method::Skeleton, Mask::Auto)
            .unwrap()
            .extract(&photo, &label)
            .unwrap();
        assert_eq!((measured.ropes, measured.is_miscounted()), (2, false));
        assert!(measured.dice > 0.97, "{}", measured.dice);
        assert_eq!(measured.coverage, Coverage::default());
        assert!(measured.times.extract() > Duration::ZERO);
    }

    #[test]
    fn a_wrong_count_is_counted() {
        let (photo, _) = picture(&bars());
        let (_, label) = picture(&bars()[..1]);
        let measured = Bench::new(Method::Skeleton, Mask::Auto)
            .unwrap()
            .extract(&photo, &label)
            .unwrap();
        assert!(measured.is_miscounted());
        assert!((0.4..0.5).contains(&measured.dice), "{}", measured.dice);
    }

    #[test]
    fn each_photograph_is_a_scene_of_its_own() {
        let mut bench = Bench::new(Method::Skeleton, Mask::Auto).unwrap();
        let (photo, label) = picture(&bars());
        let first = bench.extract(&photo, &label).unwrap();
        let (empty, no_label) = picture(&[]);
        assert!(bench.extract(&empty, &no_label).unwrap().curves.is_empty());
        assert_eq!(bench.extract(&photo, &label).unwrap().curves, first.curves);
    }
}
