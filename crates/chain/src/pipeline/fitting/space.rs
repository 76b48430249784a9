//! Fits curves in 3-D to centerlines, with the help of depth images or the view of a second camera.
//!
//! `lariat_camera` computes the 3-D points of a centerline, their distances and the variances of
//! the distances, with `RopeDepth` or `RopeViews`. The points are resampled at equal steps in space
//! and fitted as in the picture's plane, with three columns instead of two.
//!
//! **Covariances.** The error of a point is an ellipsoid: across the ray it comes from the pixel
//! noise, along the ray from the variance of the depth. If residuals are larger, all ellipsoids
//! grow by the same factor. With `filter`, each ellipsoid keeps its shape and shrinks in proportion
//! to the filter's own variance. Bridged points count in the fit like measured ones; their variance
//! is that of the bridge.
//!
//! **Hidden points.** The depth of a crossing's lower strand is unknown within the width of the
//! upper strand (`covered`). If the order of the strands is unknown, both depths are. A rope that
//! is lost keeps its last position.

mod covered;
mod finder;

use super::Warned;
use super::filters::Filters;
use super::ropes::Ropes;
use super::steady::{Rope, RopeFitter};
use crate::calibrated::Calibrated;
use crate::settings::{self, Settings};
use anyhow::Result;
pub use finder::Companion;
use finder::{Finder, Shown};
use lariat_camera::Pose;
use lariat_fit::{Fit, Judged, Line, Prediction, Resampler, Spread, Square};
use lariat_wire::{
    Axes, Centerlines, Curve, Descriptor3, Descriptors3, FitQuality, MAX_CONTROL_POINTS,
    MAX_POINTS, Place, Status,
};

/// Number of neighboring points whose errors are correlated, because the picture is smoothed and
/// the depth camera's noise is shared.
const ALIKE: f64 = 2.0;
/// Standard deviation of a centerline point in the picture, px. The first value is for a rope one
/// pixel wide and falls with the square root of the width, because more pixels show the rope. The
/// second value is the floor. `END_BESIDE_PX` is the deviation of an end across the rope, which
/// also falls with the square root of the width.
const PIXEL_SIGMA: [f64; 2] = [0.3, 0.05];
const END_BESIDE_PX: f64 = 0.5;
/// Standard deviation of an end along the rope in the picture, px: For drawn ropes it is 0.3 to
/// 0.8, so that 95 of 100 ends lie within twice that. A rope that runs along the ray shifts its end
/// by up to half its width times the cosine of the angle. `SLOPE_SHARE` is the standard deviation
/// as a share of this shift.
const END_SIGMA_PX: f64 = 0.6;
const SLOPE_SHARE: f64 = 0.4;
/// Number of points over which the slope of an end is measured.
const STEEP_OVER: usize = 4;

/// Fits curves of ropes in 3-D.
pub struct SpaceFitter {
    settings: settings::Fit,
    finder: Finder,
    /// Pose from the color camera's frame to the frame of the output.
    pose: Option<Pose>,
    fitter: RopeFitter<3>,
    filters: Option<Filters<3>>,
    line: Resampler<3>,
    points: Box<[[f64; 3]; MAX_POINTS]>,
    /// The points at equal steps in space.
    even: Box<[[f64; 3]; MAX_POINTS]>,
    squares: Box<[Square<3>; MAX_POINTS]>,
    even_squares: Box<[Square<3>; MAX_POINTS]>,
    /// Covariances of the errors that neighboring points share over the reach of a control point.
    doubts: Box<[Square<3>; MAX_POINTS]>,
    even_doubts: Box<[Square<3>; MAX_POINTS]>,
    sigmas: Box<[f64; MAX_POINTS]>,
    by_size: Box<[f64; MAX_POINTS]>,
    measured: Box<[bool; MAX_POINTS]>,
    hidden: Box<[bool; MAX_POINTS]>,
    covariances: Box<[Square<3>; MAX_CONTROL_POINTS]>,
    /// The curve of each rope when it was last visible.
    before: Ropes<Box<Descriptor3>>,
    unreadable: Warned,
    unplaced: Warned,
}

impl SpaceFitter {
    /// Precomputes the fit for the number of points in the settings. Returns `None` if they name
    /// neither a depth camera nor a second color camera.
    ///
    /// # Errors
    /// Returns an error if a file that the settings name cannot be read.
    pub fn new(settings: &Settings) -> Result<Option<Self>> {
        let size = settings.capture.likely_size();
        let Some((beside, pose)) = Calibrated::beside(&settings.camera, size)? else {
            return Ok(None);
        };
        Ok(Some(Self {
            finder: Finder::new(beside),
            fitter: RopeFitter::new(&settings.fit, settings.extract.points)?,
            settings: settings.fit.clone(),
            pose,
            filters: None,
            line: Resampler::in_dimensions(),
            points: Box::new([[0.0; 3]; MAX_POINTS]),
            even: Box::new([[0.0; 3]; MAX_POINTS]),
            squares: Box::new([[[0.0; 3]; 3]; MAX_POINTS]),
            even_squares: Box::new([[[0.0; 3]; 3]; MAX_POINTS]),
            doubts: Box::new([[[0.0; 3]; 3]; MAX_POINTS]),
            even_doubts: Box::new([[[0.0; 3]; 3]; MAX_POINTS]),
            sigmas: Box::new([0.0; MAX_POINTS]),
            by_size: Box::new([0.0; MAX_POINTS]),
            measured: Box::new([false; MAX_POINTS]),
            hidden: Box::new([false; MAX_POINTS]),
            covariances: Box::new([[[0.0; 3]; 3]; MAX_CONTROL_POINTS]),
            before: Ropes::new(|_| anyhow::Ok(Box::new(Descriptor3::EMPTY)))?,
            unreadable: Warned::default(),
            unplaced: Warned::default(),
        }))
    }

    /// Writes the curves of a frame's ropes into a message. The message's trace is left unchanged.
    /// A rope of unknown position comes without a curve, but with a reason. `companion` is the
    /// frame's depth image or second view, `None` if it did not arrive.
    pub fn answer(
        &mut self,
        seen: &Centerlines,
        companion: Option<Companion>,
        message: &mut Descriptors3,
    ) {
        message.axes = match self.pose {
            Some(_) => Axes::Robot,
            None => Axes::Camera,
        } as u32;
        let shown = companion.map(|companion| self.finder.look(seen, companion));
        let shown = (shown.transpose()).map_err(|cause| self.unreadable.once(&cause));
        // Read the curves once, because shared memory may change at any moment.
        let curves = seen.curves();
        message.count = curves.len() as u32;
        for (i, (curve, to)) in curves.iter().zip(&mut message.curves).enumerate() {
            let place = match (curve.status(), &shown) {
                (Some(Status::Lost), _) => self.as_before(curve, to),
                (_, Err(())) => Place::Unreadable,
                (_, Ok(None)) => Place::NoPartner,
                (_, Ok(Some(shown))) => self.place(seen, (i, curve), shown, to),
            };
            write_rope(curve, to);
            to.place = place as u32;
            if !matches!(place, Place::Known | Place::Before) {
                (to.count, to.samples, to.measured, to.filtered) = (0, 0, 0, 0);
            }
            if place == Place::Known {
                let exposed_ns = seen.trace.exposed_ns;
                let before = self.before.of_track(curve.track, exposed_ns, |_| {});
                before.copy_meant(to);
            }
        }
    }

    /// Describes a lost rope by its last known curve.
    fn as_before(&mut self, curve: &Curve, to: &mut Descriptor3) -> Place {
        let before = (self.before).of_known(curve.track);
        match before {
            Some(before) => {
                to.copy_meant(before);
                to.filtered = 0;
                Place::Before
            }
            None => Place::Unmeasured,
        }
    }

    /// Determines the position of a rope and fits its curve.
    fn place(
        &mut self,
        seen: &Centerlines,
        curve: (usize, &Curve),
        shown: &Shown,
        to: &mut Descriptor3,
    ) -> Place {
        match self.describe(seen, curve, shown, to) {
            Ok(_) => Place::Known,
            Err(cause) => {
                self.unplaced.once(&cause);
                finder::place_of(&cause)
            }
        }
    }

    /// Describes the `i`-th curve of a frame.
    ///
    /// # Errors
    /// Returns an error if the rope's position is unknown or the curve cannot be fitted.
    fn describe(
        &mut self,
        seen: &Centerlines,
        (i, curve): (usize, &Curve),
        shown: &Shown,
        to: &mut Descriptor3,
    ) -> Result<Judged> {
        super::check_points(seen, curve)?;
        let count = curve.points().len();
        if count != self.fitter.points() {
            self.fitter = RopeFitter::new(&self.settings, count)?;
            self.filters = None;
        }
        let noise = self.locate(seen, (i, curve), shown)?;
        let width = median(&mut self.by_size[..count]);
        let closed = curve.closed != 0;
        let even = self.line.resample(&self.points[..count], closed)?;
        self.even[..count].copy_from_slice(even);
        let unit_per_px = self.line.length() / f64::from(curve.length_px).max(1.0);
        for (k, hidden) in self.hidden[..count].iter_mut().enumerate() {
            *hidden = self.line.between(k).iter().any(|&i| !self.measured[i]);
        }
        let rope = Rope {
            track: curve.track,
            closed,
            width,
            unit_per_px,
            noise,
            seen_ns: seen.trace.exposed_ns,
        };
        let line = Line {
            points: &self.even[..count],
            weights: None,
            hidden: &self.hidden[..count],
        };
        let judged = self.fitter.fit(rope, &line)?;
        for k in 0..count {
            let [i, _] = self.line.between(k);
            self.even_squares[k] = self.squares[i];
            self.even_doubts[k] = self.doubts[i];
        }
        for end in [0, count - 1] {
            let beside = if closed {
                0.0
            } else {
                self.beside_end(end, width)
            };
            for (axis, row) in self.even_squares[end].iter_mut().enumerate() {
                row[axis] += beside * beside / ALIKE;
            }
        }
        for (k, point) in self.even[..count].iter().enumerate() {
            to.points[k] = point.map(|c| c as f32);
            to.sigmas[k] = self.line.carry(k, &self.sigmas[..]) as f32;
        }
        to.samples = count as u32;
        to.measured = self.measured[..count].iter().filter(|&&m| m).count() as u32;
        (to.length, to.width) = (self.line.length(), width);
        to.fit = match judged.is_good {
            true => FitQuality::Good,
            false => FitQuality::Coarse,
        } as u32;
        self.write_curve(closed, count, to);
        self.filter(seen.trace.exposed_ns, closed, unit_per_px, curve.track, to)?;
        Ok(judged)
    }

    /// Determines the 3-D points of the `i`-th curve. Returns the median of their standard
    /// deviations along the rays, mm.
    fn locate(
        &mut self,
        seen: &Centerlines,
        (i, curve): (usize, &Curve),
        shown: &Shown,
    ) -> Result<f64> {
        let count = curve.points().len();
        let focal_px = self.finder.focal_px();
        let [of_a_pixel, least] = PIXEL_SIGMA.map(|sigma| sigma * sigma);
        let places = self.finder.locate(seen, (i, curve), shown)?;
        for (k, place) in places.iter().enumerate() {
            let (mut ray, mut across) = (place.ray, transposed(place.by_pixel));
            self.points[k] = place.point;
            if let Some(pose) = &self.pose {
                self.points[k] = pose.point(place.point);
                ray = pose.way(ray);
                across = across.map(|way| pose.way(way));
            }
            let width_px = (focal_px * place.width_mm / place.point[2]).max(1.0);
            let pixel = of_a_pixel / width_px + least;
            let doubt_px = place.doubt_px * place.doubt_px;
            let bridged = place.in_common * place.variance;
            let shifted = place.doubt_mm * place.doubt_mm;
            let own = place.variance - bridged;
            let (square, doubt) = (&mut self.squares[k], &mut self.doubts[k]);
            for a in 0..3 {
                for b in a..3 {
                    let aside = across[0][a] * across[0][b] + across[1][a] * across[1][b];
                    let along = ray[a] * ray[b];
                    square[a][b] = pixel * aside + own * along;
                    doubt[a][b] = doubt_px * aside + (bridged + shifted) * along;
                    (square[b][a], doubt[b][a]) = (square[a][b], doubt[a][b]);
                }
            }
            let squared_length = ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2];
            self.sigmas[k] = ((place.variance + shifted) * squared_length).sqrt();
            self.measured[k] = place.is_measured;
            self.by_size[k] = (place.variance * squared_length).sqrt();
        }
        let noise = median(&mut self.by_size[..count]);
        for (to, place) in self.by_size.iter_mut().zip(places) {
            *to = place.width_mm;
        }
        Ok(noise)
    }

    fn write_curve(&mut self, closed: bool, samples: usize, to: &mut Descriptor3) {
        let fitter = self.fitter.fitter(closed);
        let fit = fitter.last();
        let count = fit.control_points.len().min(MAX_CONTROL_POINTS);
        to.basis = super::basis(fit.basis) as u32;
        to.degree = fit.basis.order() as u32;
        to.count = count as u32;
        (to.rms, to.max, to.filtered) = (fit.rms_px, fit.max_px, 0);
        to.control_points[..count].copy_from_slice(&fit.control_points[..count]);
        match fit.weights.get(..count) {
            Some(weights) => to.weights[..count].copy_from_slice(weights),
            None => to.weights[..count].fill(1.0),
        }
        to.velocities[..count].fill([0.0; 3]);
        if let lariat_fit::Basis::BSpline { degree, .. } = fit.basis {
            let inner = &fit.knots[degree + 1..count];
            to.knots[..inner.len()].copy_from_slice(inner);
        }
        let spread = Spread {
            squares: &self.even_squares[..samples],
            in_common: &self.even_doubts[..samples],
            ends: [0, samples - 1].map(|end| self.end_sigma(end, samples, to.width)),
            alike: ALIKE,
        };
        let points = &self.even[..samples];
        let fitter = self.fitter.fitter(closed);
        fitter.spread(points, &spread, &mut self.covariances);
        for (to, c) in to.covariances[..count].iter_mut().zip(&*self.covariances) {
            *to = [c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]];
        }
    }

    /// Returns the standard deviation of an end across the rope, mm.
    fn beside_end(&self, end: usize, width: f64) -> f64 {
        let mm_per_px = self.mm_per_px(self.even[end]);
        END_BESIDE_PX * mm_per_px / (width / mm_per_px).max(1.0).sqrt()
    }

    /// Returns the size of a pixel at this distance from the first camera.
    fn mm_per_px(&self, at: [f64; 3]) -> f64 {
        let ray = self.ray(at);
        dot(ray, ray).sqrt() / self.finder.focal_px()
    }

    /// Returns the ray from the first camera to a point.
    fn ray(&self, at: [f64; 3]) -> [f64; 3] {
        between(at, self.pose.map_or([0.0; 3], |pose| pose.point([0.0; 3])))
    }

    /// Returns the standard deviation of an end along the rope, mm. It results from the pixel noise
    /// and from the slope of the rope, which shifts its end.
    fn end_sigma(&self, end: usize, samples: usize, width: f64) -> f64 {
        let inner = match end {
            0 => STEEP_OVER.min(samples - 1),
            last => last.saturating_sub(STEEP_OVER),
        };
        let at = self.even[end];
        let (ray, way) = (self.ray(at), between(at, self.even[inner]));
        let cosine = dot(ray, way) / (dot(ray, ray) * dot(way, way)).sqrt();
        if !cosine.is_finite() {
            return width;
        }
        let sine = (1.0 - cosine * cosine).max(0.01).sqrt();
        let by_pixels = END_SIGMA_PX * self.mm_per_px(at);
        let by_slope = SLOPE_SHARE * 0.5 * width * cosine;
        (by_pixels * by_pixels + by_slope * by_slope).sqrt() / sine
    }

    fn filter(
        &mut self,
        exposed_ns: u64,
        closed: bool,
        unit_per_px: f64,
        track: u32,
        to: &mut Descriptor3,
    ) -> Result<()> {
        if !self.settings.filter {
            return Ok(());
        }
        let filters = match &mut self.filters {
            Some(filters) => filters,
            none => {
                let fitters = [&self.fitter.open, &self.fitter.closed];
                none.insert(Filters::new(&self.settings, fitters, unit_per_px)?)
            }
        };
        let fitter = self.fitter.fitter(closed);
        let Some(now) = filters.take_in(exposed_ns, track, fitter) else {
            return Ok(());
        };
        write_filtered(now, fitter.last(), to);
        Ok(())
    }
}

/// Replaces the control points by the filtered ones. Each ellipsoid shrinks in proportion to the
/// filter's variance.
fn write_filtered(now: &Prediction<3>, fit: &Fit<3>, to: &mut Descriptor3) {
    let count = now.control_points.len();
    to.filtered = 1;
    to.control_points[..count].copy_from_slice(&now.control_points);
    to.velocities[..count].copy_from_slice(&now.velocities_px_s);
    for (j, covariance) in to.covariances[..count].iter_mut().enumerate() {
        let measured = fit.residual_variance * fit.covariance_factor[(j, j)];
        let share = now.covariance_px2[j * (count + 1)] / measured;
        if share.is_finite() {
            *covariance = covariance.map(|c| share * c);
        }
    }
}

/// Copies the properties of the rope itself.
fn write_rope(curve: &Curve, to: &mut Descriptor3) {
    (to.track, to.status) = (curve.track, curve.status);
    (to.closed, to.border) = (curve.closed, curve.border);
    (to.confidence, to.age_ns) = (curve.confidence, curve.age_ns);
}

fn between(to: [f64; 3], from: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| to[k] - from[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn transposed(by_pixel: [[f64; 2]; 3]) -> [[f64; 3]; 2] {
    [0, 1].map(|k| [0, 1, 2].map(|axis| by_pixel[axis][k]))
}

/// Returns the median, or 0 for an empty slice. Reorders the values.
fn median(values: &mut [f64]) -> f64 {
    match values.len() {
        0 => 0.0,
        count => *values.select_nth_unstable_by(count / 2, f64::total_cmp).1,
    }
}
