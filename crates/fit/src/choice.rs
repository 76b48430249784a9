//! Chooses the size of a curve: the fewest control points that keep it within a tolerance of its
//! points. Keeps that size while the rope moves.

use crate::basis::{Basis, Knots};
use crate::error::FitError;
use crate::fitter::{Fit, Fitter, Size};
use crate::options::Rho;
use crate::placed;
use crate::point::Point;
use crate::tolerance::Tolerance;

/// Factor on the tolerance when a size is chosen. The rope may then bend more before the size has
/// to change. A cubic spline's error is proportional to the fourth power of the steps between its
/// knots, so half the tolerance costs a fifth more control points.
const MARGIN: f64 = 0.5;

/// Time for which a curve may fail to fit before its size changes.
const PATIENCE_NS: u64 = 1_000_000_000;

/// A centerline to be fitted.
#[derive(Debug, Clone, Copy)]
pub struct Line<'a, const D: usize = 2> {
    /// Points in order, evenly spaced by arc length unless the fitter measures arc length.
    pub points: &'a [[f64; D]],
    /// Weight of each point, if the fitter was made for weights.
    pub weights: Option<&'a [f64]>,
    /// True for points that were not visible. Missing entries mean visible.
    pub hidden: &'a [bool],
}

impl<'a, const D: usize> Line<'a, D> {
    /// Creates a line that is completely visible, and whose points all count the same.
    pub fn of(points: &'a [[f64; D]]) -> Self {
        Self {
            points,
            weights: None,
            hidden: &[],
        }
    }
}

/// Quality of a rope's curve while the rope moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Judged {
    /// True if the last fit is within the tolerance of its points.
    pub is_good: bool,
    /// True if its size or its knots have changed.
    pub is_resized: bool,
    /// True if the curve has not fitted for a second, and no other size fits. Reported again each
    /// second.
    pub is_hopeless: bool,
}

/// The size of one rope's curve over time. It is chosen when the rope is first seen, with some
/// margin, and kept: a control loop needs a vector of constant length. It is chosen again only when
/// the curve has not fitted for a second.
#[derive(Debug, Clone, Default)]
pub struct SteadySize {
    /// Index of this rope among the fitter's ropes with individual knots.
    place: usize,
    size: Option<usize>,
    misfit_since_ns: Option<u64>,
}

impl SteadySize {
    /// Creates the size of the `place`-th of several ropes that share a fitter.
    pub fn of(place: usize) -> Self {
        Self {
            place,
            ..Self::default()
        }
    }

    /// Resets the size for another rope.
    pub fn forget(&mut self) {
        *self = Self::of(self.place);
    }

    /// Fits the rope as it was at `exposed_ns` with a curve of its own size. The result is the
    /// fitter's last fit. Does not allocate, unless the rope is given individual knots.
    ///
    /// # Errors
    /// Fails as [`Fitter::fit`] and [`Fitter::fit_weighted`] do.
    pub fn fit<const D: usize>(
        &mut self,
        fitter: &mut Fitter<D>,
        line: &Line<D>,
        tolerance: Tolerance,
        exposed_ns: u64,
    ) -> Result<Judged, FitError>
    where
        [f64; D]: Point<D>,
    {
        <[f64; D]>::fit_steadily(self, fitter, line, tolerance, exposed_ns)
    }

    /// Implements [`SteadySize::fit`].
    pub(crate) fn fit_steadily<const D: usize>(
        &mut self,
        fitter: &mut Fitter<D>,
        line: &Line<D>,
        tolerance: Tolerance,
        exposed_ns: u64,
    ) -> Result<Judged, FitError> {
        let size = match self.size.filter(|&size| size < fitter.sizes.len()) {
            Some(size) => size,
            None => {
                self.misfit_since_ns = None;
                *self
                    .size
                    .insert(choose(fitter, line, tolerance, self.place, None)?)
            }
        };
        fitter.fit_of_size(size, line)?;
        let is_good = fitter.is_within(line, tolerance);
        let since = match self.misfit_since_ns {
            // If time goes back, another recording has started.
            Some(since) if since <= exposed_ns => since,
            _ => exposed_ns,
        };
        self.misfit_since_ns = (!is_good).then_some(since);
        if !is_good && exposed_ns - since >= PATIENCE_NS {
            self.misfit_since_ns = Some(exposed_ns);
            let excess = fitter.excess(line, tolerance);
            let now = Some(Now { size, excess });
            let other = choose(fitter, line, tolerance, self.place, now)?;
            self.size = Some(other);
            fitter.fit_of_size(other, line)?;
            let is_good = fitter.is_within(line, tolerance);
            return Ok(Judged {
                is_good,
                // The same index of individual knots means that the knots have changed.
                is_resized: other != size || (is_good && other >= fitter.sizes()),
                is_hopeless: !is_good,
            });
        }
        Ok(Judged {
            is_good,
            is_resized: false,
            is_hopeless: false,
        })
    }
}

/// Chooses the smallest size that fits with some margin, or else the smallest that fits, or else
/// the largest with knots where the rope bends. This last choice replaces an existing size only if
/// it is much better.
fn choose<const D: usize>(
    fitter: &mut Fitter<D>,
    line: &Line<D>,
    tolerance: Tolerance,
    place: usize,
    now: Option<Now>,
) -> Result<usize, FitError> {
    if let (size, true) = fitter.size_for(line, tolerance.times(MARGIN))? {
        return Ok(size);
    }
    let (largest, fits) = fitter.size_for(line, tolerance)?;
    if fits {
        return Ok(largest);
    }
    let enough = now.map_or(f64::INFINITY, |now| (MARGIN * now.excess).max(1.0));
    let placed = fitter.place(place, line, tolerance, enough);
    Ok(placed.unwrap_or(now.map_or(largest, |now| now.size)))
}

/// The current size of a rope, and the factor by which it exceeds the tolerance.
#[derive(Clone, Copy)]
struct Now {
    size: usize,
    excess: f64,
}

impl<const D: usize> Fitter<D>
where
    [f64; D]: Point<D>,
{
    /// Finds the smallest size whose curve is within the tolerance of these points, and returns it
    /// with `true`. If there is none, returns the largest and `false`. Does not allocate.
    ///
    /// # Errors
    /// Fails as [`Fitter::fit`] and [`Fitter::fit_weighted`] do, if every size fails.
    pub fn least_size(
        &mut self,
        line: &Line<D>,
        tolerance: Tolerance,
    ) -> Result<(usize, bool), FitError> {
        <[f64; D]>::least_size(self, line, tolerance)
    }

    /// Fits the curve of this size, where 0 is the smallest. A number beyond all sizes means the
    /// largest. Does not allocate.
    ///
    /// # Errors
    /// Fails as [`Fitter::fit`] and [`Fitter::fit_weighted`] do.
    pub fn fit_at(&mut self, size: usize, line: &Line<D>) -> Result<&Fit<D>, FitError> {
        <[f64; D]>::fit_at(self, size, line)
    }

    /// Returns whether the last fit's curve is within the tolerance of the visible points. The last
    /// fit must have been to these points.
    pub fn lies_on(&mut self, line: &Line<D>, tolerance: Tolerance) -> bool {
        <[f64; D]>::lies_on(self, line, tolerance)
    }
}

impl<const D: usize> Fitter<D> {
    /// Number of sizes: 1 unless there is a choice.
    pub fn sizes(&self) -> usize {
        self.choosable
    }

    /// Creates a size that has the maximum number of control points and knots where this rope
    /// bends. Returns `None` if the fitter does not choose sizes or cannot have such knots, or if
    /// the tolerance would have to grow by more than `enough`.
    fn place(
        &mut self,
        place: usize,
        line: &Line<D>,
        tolerance: Tolerance,
        enough: f64,
    ) -> Option<usize> {
        let Basis::BSpline {
            degree: placed::DEGREE,
            control_points,
            knots: Knots::Uniform,
        } = self.options.basis
        else {
            return None;
        };
        if !self.options.choose_size || self.options.rho == Rho::Measured {
            return None;
        }
        let (excess, knots) = placed::knots(control_points, line.points, line.hidden, tolerance)?;
        if excess > enough {
            return None;
        }
        let basis = Basis::BSpline {
            degree: placed::DEGREE,
            control_points,
            knots: Knots::Placed,
        };
        let size = self.choosable + place;
        while self.sizes.len() <= size {
            self.sizes.push(Size::new(basis, &self.options).ok()?);
        }
        self.sizes[size] = Size::on_knots(basis, knots, &self.options).ok()?;
        Some(size)
    }

    /// Implements [`Fitter::least_size`].
    pub(crate) fn size_for(
        &mut self,
        line: &Line<D>,
        tolerance: Tolerance,
    ) -> Result<(usize, bool), FitError> {
        self.check(line)?;
        let (mut largest, mut failed) = (None, None);
        for size in 0..self.choosable {
            match self.fit_size(size, line.points, line.weights) {
                Ok(_) if self.lies_at(size, line, tolerance) => return Ok((size, true)),
                Ok(_) => largest = Some(size),
                // Points that do not determine a curve of this size may determine a smaller one.
                Err(error) => failed = failed.or(Some(error)),
            }
        }
        match (largest, failed) {
            (None, Some(error)) => Err(error),
            (largest, _) => Ok((largest.unwrap_or(0), false)),
        }
    }

    /// Implements [`Fitter::fit_at`].
    pub(crate) fn fit_of_size(&mut self, size: usize, line: &Line<D>) -> Result<&Fit<D>, FitError> {
        self.check(line)?;
        let size = size.min(self.sizes.len() - 1);
        let residuals = self.fit_size(size, line.points, line.weights)?;
        self.show(size);
        self.fit.rms_px = (residuals.weighted_sum / residuals.weights).sqrt();
        self.fit.max_px = residuals.max_px;
        self.fit.residual_variance = residuals.variance;
        Ok(&self.fit)
    }

    /// Implements [`Fitter::lies_on`].
    pub(crate) fn is_within(&mut self, line: &Line<D>, tolerance: Tolerance) -> bool {
        // If all points are near, there is no need to check each one.
        self.fit.max_px.powi(2) <= tolerance.squared()[0]
            || self.lies_at(self.shown, line, tolerance)
    }

    /// Factor by which the tolerance would have to grow to accept the last fit, which must have
    /// been to these points.
    fn excess(&mut self, line: &Line<D>, tolerance: Tolerance) -> f64 {
        self.measure(self.shown, line);
        tolerance.excess(&mut self.squared, line.hidden)
    }

    fn lies_at(&mut self, size: usize, line: &Line<D>, tolerance: Tolerance) -> bool {
        self.measure(size, line);
        tolerance.holds(&self.squared, line.hidden)
    }

    /// Computes the squared distance of each point from the curve of this size.
    fn measure(&mut self, size: usize, line: &Line<D>) {
        let size = &self.sizes[size];
        let control_points = &self.fit.control_points;
        for (i, (to, point)) in self.squared.iter_mut().zip(line.points).enumerate() {
            let place = size.point(i, control_points, &self.fit.weights);
            *to = (0..D)
                .map(|axis| (point[axis] - place[axis]) * (point[axis] - place[axis]))
                .sum();
        }
    }
}
