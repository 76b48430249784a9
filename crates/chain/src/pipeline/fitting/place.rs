//! A curve's points taken to where they lie: through the lens and onto the plane, at equal steps there.
//!
//! **Equal steps** (`crates/fit/src/resample.rs`). Equal steps in the picture are not equal on a tilted table, and ρ is arc length
//! on the table: the points are set again at equal steps along cubics through them, so that the precomputed
//! matrix of the even grid serves as before (measured ρ, the other way, costs 60 times the fit). A straight line has points
//! equal to rounding, a bend of radius r and steps h to h²/24r² of its length.
//!
//! **Fit and filter**, the same as in pixels. `acceleration_px_s2` stays in pixels of the image, and is turned into the unit by
//! the length of a pixel at its middle.
//!
//! **Noise.** A pixel's noise is independent, of variance σ² in each coordinate of each point, as in pixels. A map with the
//! derivative J makes `σ² JJᵀ` of it: an ellipse, another at each point. So a control point has a covariance of its own, three
//! numbers, where one did before. The derivation stands at the head of `crates/fit/src/noise.rs`; what it says is that a point that
//! slides along the rope changes nothing but the ends, so that the noise along the rope is far less than across it, and that σ²
//! is to be told from the residuals across. `crates/fit/tests/all/propagation.rs` holds it against 4,000 noisy ropes on a plane
//! seen at a slant, to a tenth of each variance. It is the first order: right where noise is small against the steps between points.
//! With weights, measured ρ and rational curves the even fit's ellipses are scaled by the fit's own variances.
//!
//! **The truth** of rendered ropes is in pixels: curves in another unit are not held against it, centerlines are. JSON keys:
//! `lariat trace` gives `points`, `length_px`, `width_px` and crossings in pixels of the image, and in `descriptor` the
//! `unit` (`px`, `mm`, `ideal px`) of everything in it; `lariat fit` takes points in whatever unit they are and answers in it.

use crate::calibrated::Calibrated;
use anyhow::Result;
use lariat_camera::Mapping;
use lariat_fit::{Fitter, Resampler, Square};
use lariat_wire::{Curve, Descriptor, MAX_CONTROL_POINTS, MAX_POINTS, Unit};

/// Takes curves of frames of one size to their plane.
pub(super) struct Placer {
    calibrated: Calibrated,
    /// For the frames' size, once that is known and fits.
    mapping: Option<Mapping>,
    line: Resampler,
    points: Box<[[f64; 2]; MAX_POINTS]>,
    /// `JJᵀ` of the way to each.
    squares: Box<[Square<2>; MAX_POINTS]>,
    /// The width at each, in the unit.
    widths: Box<[f64; MAX_POINTS]>,
    by_size: Box<[f64; MAX_POINTS]>,
    /// The last curve's: median width, in the unit.
    pub(super) width: f64,
    covariances: Box<[Square<2>; MAX_CONTROL_POINTS]>,
}

impl Placer {
    pub(super) fn new(calibrated: Calibrated) -> Self {
        Self {
            calibrated,
            mapping: None,
            line: Resampler::new(),
            points: Box::new([[0.0; 2]; MAX_POINTS]),
            squares: Box::new([[[0.0; 2]; 2]; MAX_POINTS]),
            widths: Box::new([0.0; MAX_POINTS]),
            by_size: Box::new([0.0; MAX_POINTS]),
            width: 0.0,
            covariances: Box::new([[[0.0; 2]; 2]; MAX_CONTROL_POINTS]),
        }
    }

    pub(super) fn unit(&self) -> Unit {
        self.calibrated.unit()
    }

    /// The way for the frames' size, once that is known and fits.
    pub(super) fn mapping(&self) -> Option<&Mapping> {
        self.mapping.as_ref()
    }

    /// Turns to frames of this size; `true` if they are of another than the last.
    ///
    /// # Errors
    /// The calibration is for other images.
    pub(super) fn turn_to(&mut self, size: [u32; 2]) -> Result<bool> {
        if self
            .mapping
            .as_ref()
            .is_some_and(|mapping| mapping.size() == size)
        {
            return Ok(false);
        }
        self.mapping = None;
        self.mapping = Some(self.calibrated.mapping(size)?);
        Ok(true)
    }

    /// How long a pixel is at the middle of the frames, or, where no table is there, at the middle of their lower half.
    pub(super) fn unit_per_px(&self) -> Option<f64> {
        let mapping = self.mapping.as_ref()?;
        let [width, height] = mapping.size().map(f64::from);
        let places = [0.5, 0.75, 1.0].map(|share| [0.5 * width, share * height]);
        places
            .into_iter()
            .find_map(|at| mapping.unit_per_px(at).ok())
    }

    /// How long a pixel is along the last curve, in the mean.
    pub(super) fn unit_per_px_along(&self, curve: &Curve) -> f64 {
        let mean = self.line.length() / f64::from(curve.length_px);
        if mean.is_finite() {
            mean
        } else {
            self.unit_per_px().unwrap_or(1.0)
        }
    }

    /// The curve's points where they lie, at equal steps.
    ///
    /// # Errors
    /// One of them lies nowhere.
    pub(super) fn place(&mut self, curve: &Curve) -> Result<&[[f64; 2]]> {
        let Some(mapping) = &self.mapping else {
            anyhow::bail!("the calibration does not fit these frames");
        };
        let seen = curve.points();
        let count = seen.len();
        for (i, pixel) in seen.iter().enumerate() {
            let place = mapping.place(pixel.map(f64::from))?;
            let [a, b] = place.jacobian;
            let dot = |p: [f64; 2], q: [f64; 2]| p[0] * q[0] + p[1] * q[1];
            self.points[i] = place.point;
            self.squares[i] = [[dot(a, a), dot(a, b)], [dot(a, b), dot(b, b)]];
            // A width lies across the rope: the area of a step of the rope over the step's length.
            let along = direction(seen, i, curve.closed != 0);
            let step = [dot(a, along), dot(b, along)];
            let area = (a[0] * b[1] - a[1] * b[0]).abs();
            self.widths[i] = f64::from(curve.widths_px()[i]) * area / libm::hypot(step[0], step[1]);
        }
        let by_size = &mut self.by_size[..count];
        by_size.copy_from_slice(&self.widths[..count]);
        self.width = match count {
            0 => 0.0,
            _ => *by_size.select_nth_unstable_by(count / 2, f64::total_cmp).1,
        };
        Ok(self
            .line
            .resample(&self.points[..count], curve.closed != 0)?)
    }

    /// Whether the `k`-th of the placed points lies beside one that is covered.
    pub(super) fn is_hidden(&self, curve: &Curve, k: usize) -> bool {
        self.line.between(k).into_iter().any(|i| curve.is_hidden(i))
    }

    /// The rope's width at the `k`-th of the placed points.
    pub(super) fn width_at(&self, k: usize) -> f64 {
        self.line.carry(k, &self.widths[..])
    }

    /// Writes what is to be said of the last curve in the unit, once it is fitted.
    pub(super) fn describe(&mut self, fitter: &mut Fitter, descriptor: &mut Descriptor) {
        let (samples, count) = (descriptor.samples as usize, descriptor.count as usize);
        descriptor.length = self.line.length();
        descriptor.width = self.width;
        let squares = &self.squares[..samples.min(MAX_POINTS)];
        fitter.propagate(&self.line, squares, &mut self.covariances);
        for (to, [[xx, xy], [_, yy]]) in descriptor.covariances[..count]
            .iter_mut()
            .zip(&*self.covariances)
        {
            *to = [*xx, *xy, *yy];
        }
    }
}

/// The direction of a line at point `i`, of length 1; along x where it has none.
fn direction(points: &[[f32; 2]], i: usize, closed: bool) -> [f64; 2] {
    let count = points.len();
    let (before, after) = if closed {
        ((i + count - 1) % count, (i + 1) % count)
    } else {
        (i.saturating_sub(1), (i + 1).min(count - 1))
    };
    let way = [0, 1].map(|axis| f64::from(points[after][axis]) - f64::from(points[before][axis]));
    let size = libm::hypot(way[0], way[1]);
    if size > 0.0 {
        way.map(|c| c / size)
    } else {
        [1.0, 0.0]
    }
}
