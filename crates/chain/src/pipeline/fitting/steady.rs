//! The curve of each rope: open or closed, of a size that stays its own.

use super::ropes::Ropes;
use crate::settings;
use lariat_fit::{FitError, Fitter, FitterError, Judged, Line, Point, SteadySize, Tolerance};

/// A rope as fitting needs to know it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rope {
    pub(super) track: u32,
    pub(super) closed: bool,
    /// In the unit of its points, and how long a pixel is there.
    pub(super) width: f64,
    pub(super) unit_per_px: f64,
    /// The standard deviation of its points in the worst direction, where that may be more than a pixel's: with it no curve is asked
    /// to follow noise. 0 in the picture's plane.
    pub(super) noise: f64,
    /// When it was seen so.
    pub(super) seen_ns: u64,
}

/// Fitters of open and of closed curves, and which size each rope's has.
pub(super) struct RopeFitter<const D: usize = 2> {
    settings: settings::Fit,
    pub(super) open: Fitter<D>,
    pub(super) closed: Fitter<D>,
    /// Of each rope's open and closed curves.
    sizes: Ropes<[SteadySize; 2]>,
    /// The rope that the last open curve was of.
    last_track: Option<u32>,
}

impl<const D: usize> RopeFitter<D>
where
    [f64; D]: Point<D>,
{
    /// # Errors
    /// As [`Fitter::new`].
    pub(super) fn new(settings: &settings::Fit, points: usize) -> Result<Self, FitterError> {
        Ok(Self {
            open: Fitter::in_dimensions(settings.options(points, false))?,
            closed: Fitter::in_dimensions(settings.options(points, true))?,
            settings: settings.clone(),
            sizes: Ropes::new(|place| {
                Ok::<_, FitterError>([SteadySize::of(place), SteadySize::of(place)])
            })?,
            last_track: None,
        })
    }

    /// How many points the fitters are for.
    pub(super) fn points(&self) -> usize {
        self.open.options().points
    }

    /// The fitter of such curves.
    pub(super) fn fitter(&mut self, closed: bool) -> &mut Fitter<D> {
        if closed {
            &mut self.closed
        } else {
            &mut self.open
        }
    }

    /// The ropes that come are others.
    pub(super) fn forget(&mut self) {
        self.sizes.forget();
        self.last_track = None;
    }

    /// Fits a rope; the fit is the last of its fitter.
    ///
    /// # Errors
    /// As [`Fitter::fit`].
    pub(super) fn fit(&mut self, rope: Rope, line: &Line<D>) -> Result<Judged, FitError> {
        if !rope.closed && self.last_track.replace(rope.track) != Some(rope.track) {
            self.open.forget();
        }
        let Rope { track, seen_ns, .. } = rope;
        let tolerance = Tolerance {
            noise: rope.noise,
            ..self.settings.tolerance(rope.width, rope.unit_per_px)
        };
        let sizes = self.sizes.of_track(track, seen_ns, |sizes| {
            sizes.iter_mut().for_each(SteadySize::forget)
        });
        let size = &mut sizes[usize::from(rope.closed)];
        let fitter = if rope.closed {
            &mut self.closed
        } else {
            &mut self.open
        };
        match size.fit(fitter, line, tolerance, seen_ns) {
            // Where what is seen does not determine the curve, what extraction bridged must do.
            Err(_) if line.weights.is_some() => {
                let bridged = Line {
                    weights: None,
                    ..*line
                };
                size.fit(fitter, &bridged, tolerance, seen_ns)
            }
            judged => judged,
        }
    }
}
