//! Fits each rope's curve, open or closed, and keeps the size of the curve steady.

use super::ropes::Ropes;
use crate::settings;
use lariat_fit::{FitError, Fitter, FitterError, Judged, Line, Point, SteadySize, Tolerance};

/// The properties of a rope that fitting needs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rope {
    pub(super) track: u32,
    pub(super) closed: bool,
    /// The rope's width in the unit of its points. `unit_per_px` is the length of a pixel there.
    pub(super) width: f64,
    pub(super) unit_per_px: f64,
    /// Standard deviation of its points in the worst direction, if that may exceed a pixel's noise.
    /// It keeps the curve from following noise. It is 0 in the picture's plane.
    pub(super) noise: f64,
    /// Time of this observation of the rope.
    pub(super) seen_ns: u64,
}

/// Fitters of open and closed curves, and the size of each rope's curve.
pub(super) struct RopeFitter<const D: usize = 2> {
    settings: settings::Fit,
    pub(super) open: Fitter<D>,
    pub(super) closed: Fitter<D>,
    /// Sizes of each rope's open and closed curves.
    sizes: Ropes<[SteadySize; 2]>,
    /// The rope of the last open curve.
    last_track: Option<u32>,
}

impl<const D: usize> RopeFitter<D>
where
    [f64; D]: Point<D>,
{
    /// Creates the fitters for this number of points.
    ///
    /// # Errors
    /// Fails like [`Fitter::new`].
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

    /// Returns the number of points that the fitters expect.
    pub(super) fn points(&self) -> usize {
        self.open.options().points
    }

    /// Returns the fitter of closed or open curves.
    pub(super) fn fitter(&mut self, closed: bool) -> &mut Fitter<D> {
        if closed {
            &mut self.closed
        } else {
            &mut self.open
        }
    }

    /// Forgets all ropes, because the next frame shows others.
    pub(super) fn forget(&mut self) {
        self.sizes.forget();
        self.last_track = None;
    }

    /// Fits a rope. The result is the last fit of its fitter.
    ///
    /// # Errors
    /// Fails like [`Fitter::fit`].
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
            // The visible points do not determine the curve, so use the bridged ones as well.
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
