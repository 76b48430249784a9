//! The size of a curve: the fewest control points that keep it within a tolerance of its points, and that size kept while
//! the rope moves.

use crate::basis::{Basis, Knots};
use crate::error::FitError;
use crate::fitter::{Fit, Fitter, Size};
use crate::options::Rho;
use crate::placed;
use crate::point::Point;
use crate::tolerance::Tolerance;

/// How much nearer a curve must be when its size is chosen: so much may the rope bend more before the size has to
/// change. A cubic spline's error goes with the fourth power of the steps between its knots, so half the tolerance costs
/// a fifth more control points.
const MARGIN: f64 = 0.5;

/// So long does a curve not fit before its size changes.
const PATIENCE_NS: u64 = 1_000_000_000;

/// A centerline to be fitted.
#[derive(Debug, Clone, Copy)]
pub struct Line<'a, const D: usize = 2> {
    /// In order, evenly spaced by arc length unless it is measured.
    pub points: &'a [[f64; D]],
    /// How much each point counts, if the fitter was made for it.
    pub weights: Option<&'a [f64]>,
    /// Which points nobody saw; what is left out was seen.
    pub hidden: &'a [bool],
}

impl<'a, const D: usize> Line<'a, D> {
    /// One that is seen whole, and all of whose points count the same.
    pub fn of(points: &'a [[f64; D]]) -> Self {
        Self {
            points,
            weights: None,
            hidden: &[],
        }
    }
}

/// How the curve of a rope does as the rope moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Judged {
    /// Whether the last fit lies on its points.
    pub is_good: bool,
    /// Whether it has another size than the rope's curve had before.
    pub is_resized: bool,
    /// Whether it has not fitted for a second, and no size does; said again each second.
    pub is_hopeless: bool,
}

/// The size of one rope's curve over time. It is chosen when the rope is first seen, with some margin, and stays: a control
/// loop must not see its vector change length. Only when the curve has not fitted for a second is it chosen again.
#[derive(Debug, Clone, Default)]
pub struct SteadySize {
    /// Which of the fitter's places for ropes of their own knots is this one's.
    place: usize,
    size: Option<usize>,
    misfit_since_ns: Option<u64>,
}

impl SteadySize {
    /// That of the `place`-th of several ropes that share a fitter.
    pub fn of(place: usize) -> Self {
        Self {
            place,
            ..Self::default()
        }
    }

    /// Makes it another rope's.
    pub fn forget(&mut self) {
        *self = Self::of(self.place);
    }

    /// Fits the rope as it was at `exposed_ns` with a curve of its own size; the fit is the fitter's last. Allocates nothing,
    /// but where the rope is given knots of its own.
    ///
    /// # Errors
    /// As [`Fitter::fit`] and [`Fitter::fit_weighted`].
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

    /// [`SteadySize::fit`].
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
            // Time that went back is another film's.
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
                // Its own place is not gone to again but with other knots.
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

/// The least size that fits with some margin; else the least that fits; else the largest, with knots where the rope bends.
/// Where there is a size already, and none fits, it is given up only for one that is much better.
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

/// A size that a rope has, and how much nearer it would have to be.
#[derive(Clone, Copy)]
struct Now {
    size: usize,
    excess: f64,
}

impl<const D: usize> Fitter<D>
where
    [f64; D]: Point<D>,
{
    /// The smallest size whose curve lies within the tolerance of these points, and `true`; or the largest and `false`.
    /// Allocates nothing.
    ///
    /// # Errors
    /// As [`Fitter::fit`] and [`Fitter::fit_weighted`], where that holds for every size.
    pub fn least_size(
        &mut self,
        line: &Line<D>,
        tolerance: Tolerance,
    ) -> Result<(usize, bool), FitError> {
        <[f64; D]>::least_size(self, line, tolerance)
    }

    /// The curve of this size, counted from 0, the smallest; the largest for a number beyond all. Allocates nothing.
    ///
    /// # Errors
    /// As [`Fitter::fit`] and [`Fitter::fit_weighted`].
    pub fn fit_at(&mut self, size: usize, line: &Line<D>) -> Result<&Fit<D>, FitError> {
        <[f64; D]>::fit_at(self, size, line)
    }

    /// Whether the curve of the last fit, which was of these points, lies within the tolerance of those that were seen.
    pub fn lies_on(&mut self, line: &Line<D>, tolerance: Tolerance) -> bool {
        <[f64; D]>::lies_on(self, line, tolerance)
    }
}

impl<const D: usize> Fitter<D> {
    /// How many sizes there are: 1 unless they are to be chosen from.
    pub fn sizes(&self) -> usize {
        self.choosable
    }

    /// Makes a size of the largest curves whose knots lie where this rope bends, if the fitter's are chosen and may, and that
    /// leaves the points no farther off than enough.
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

    /// [`Fitter::least_size`].
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

    /// [`Fitter::fit_at`].
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

    /// [`Fitter::lies_on`].
    pub(crate) fn is_within(&mut self, line: &Line<D>, tolerance: Tolerance) -> bool {
        // All points are near: mostly there is no need to look at each.
        self.fit.max_px.powi(2) <= tolerance.squared()[0]
            || self.lies_at(self.shown, line, tolerance)
    }

    /// By how much the tolerance would have to be larger for the last fit, which was of these points.
    fn excess(&mut self, line: &Line<D>, tolerance: Tolerance) -> f64 {
        self.measure(self.shown, line);
        tolerance.excess(&mut self.squared, line.hidden)
    }

    fn lies_at(&mut self, size: usize, line: &Line<D>, tolerance: Tolerance) -> bool {
        self.measure(size, line);
        tolerance.holds(&self.squared, line.hidden)
    }

    /// The squared distance of each point from the curve of this size.
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
