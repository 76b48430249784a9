//! Maps a curve's points through the lens and onto the plane, at equal steps of arc length there.
//!
//! **Equal steps** (`crates/fit/src/resample.rs`). Equal steps in the picture are unequal on a
//! tilted table, and ρ is the arc length on the table. The points are therefore resampled at equal
//! steps along cubics through them, so that the precomputed matrix for even steps still applies.
//! The alternative, a fit with measured ρ, is far more expensive. On a straight line, the steps are
//! equal except for rounding. On a bend of radius r with steps h, the relative error of the length
//! is h²/24r².
//!
//! **Fit and filter** are the same as in pixels. `acceleration_px_s2` stays in image pixels and is
//! converted with the length of a pixel in the middle of the image.
//!
//! **Noise.** Pixel noise is independent, with variance σ² in each coordinate of each point. A
//! mapping with the derivative J turns it into the covariance `σ² JJᵀ`, an ellipse that differs
//! from point to point. Each control point therefore has its own covariance of three numbers
//! instead of one. `crates/fit/src/noise.rs` contains the derivation. A point that slides along the
//! rope changes nothing but the ends, so the noise along the rope is far smaller than across it. σ²
//! is therefore estimated from the residuals across the rope. `crates/fit/tests/all/propagation.rs`
//! checks each variance to within a tenth against 4,000 noisy ropes on a tilted plane. The
//! propagation is of first order: it holds while the noise is small relative to the steps between
//! points. With weights, measured ρ or rational curves, the ellipses of the even fit are scaled by
//! the fit's own variances.
//!
//! **The truth** of rendered ropes is in pixels. Centerlines are compared with it, but curves in
//! another unit are not. In JSON, `lariat trace` gives `points`, `length_px`, `width_px` and
//! crossings in image pixels. The `unit` (`px`, `mm`, `ideal px`) in `descriptor` applies to
//! everything in it. `lariat fit` accepts points in any unit and answers in the same unit.

use crate::calibrated::Calibrated;
use anyhow::Result;
use lariat_camera::Mapping;
use lariat_fit::{Fitter, Resampler, Square};
use lariat_wire::{Curve, Descriptor, MAX_CONTROL_POINTS, MAX_POINTS, Unit};

/// Maps curves of frames of one size to the plane.
pub(super) struct Placer {
    calibrated: Calibrated,
    /// The mapping for the frame size, once that is known and matches the calibration.
    mapping: Option<Mapping>,
    line: Resampler,
    points: Box<[[f64; 2]; MAX_POINTS]>,
    /// `JJᵀ` of the mapping at each point.
    squares: Box<[Square<2>; MAX_POINTS]>,
    /// The rope's width at each point, in the unit.
    widths: Box<[f64; MAX_POINTS]>,
    by_size: Box<[f64; MAX_POINTS]>,
    /// Median width of the last curve, in the unit.
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

    /// Returns the mapping for the frame size, once that is known and matches the calibration.
    pub(super) fn mapping(&self) -> Option<&Mapping> {
        self.mapping.as_ref()
    }

    /// Prepares for frames of this size. Returns true if the size has changed.
    ///
    /// # Errors
    /// Returns an error if the calibration is for another image size.
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

    /// Returns the length of a pixel in the middle of the frame. If the table is not visible there,
    /// uses the middle of the lower half, then the bottom edge.
    pub(super) fn unit_per_px(&self) -> Option<f64> {
        let mapping = self.mapping.as_ref()?;
        let [width, height] = mapping.size().map(f64::from);
        let places = [0.5, 0.75, 1.0].map(|share| [0.5 * width, share * height]);
        places
            .into_iter()
            .find_map(|at| mapping.unit_per_px(at).ok())
    }

    /// Returns the mean length of a pixel along the last curve.
    pub(super) fn unit_per_px_along(&self, curve: &Curve) -> f64 {
        let mean = self.line.length() / f64::from(curve.length_px);
        if mean.is_finite() {
            mean
        } else {
            self.unit_per_px().unwrap_or(1.0)
        }
    }

    /// Maps the curve's points to the plane and resamples them at equal steps.
    ///
    /// # Errors
    /// Returns an error if a point does not lie on the plane.
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
            // Width across the mapped rope: the area of a step of the rope divided by the length of
            // the step.
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

    /// Returns true if the `k`-th resampled point is next to a hidden point of the curve.
    pub(super) fn is_hidden(&self, curve: &Curve, k: usize) -> bool {
        self.line.between(k).into_iter().any(|i| curve.is_hidden(i))
    }

    /// Returns the rope's width at the `k`-th resampled point.
    pub(super) fn width_at(&self, k: usize) -> f64 {
        self.line.carry(k, &self.widths[..])
    }

    /// Writes length, width and covariances of the last curve in the unit, after the fit.
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

/// Returns the unit direction of a line at point `i`, or the x axis if the direction is undefined.
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
