//! Distance between the curve that the chain would send and the points it is fitted to.

use std::path::Path;

use crate::{Samples, Table};
use anyhow::{Context, Result};
use lariat_extract::{Curve, Extractor, Image, Method, Options, PixelFormat};
use lariat_fit::{Basis, Fitter, Line, SteadySize, Tolerance};

use super::photo;

/// Frames per second assumed for a film whose pictures have no timestamps.
const FPS: u64 = 30;

/// Errors of a curve fitted to its points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fitted {
    control_points: usize,
    rms_px: f64,
    worst_px: f64,
    width_px: f64,
    is_good: bool,
}

/// Fitters for open and for closed ropes.
pub(super) struct Curves {
    fitters: [Fitter; 2],
    points: Vec<[f64; 2]>,
}

impl Curves {
    /// Creates fitters as the chain chooses them, or for Bezier curves of N control points. Closed
    /// ropes then get (N − 1) / 2 harmonics.
    pub(super) fn new(control_points: Option<u16>) -> Result<Self> {
        let points = Options::default().points;
        let options = |closed| {
            let auto = lariat_fit::Options::auto(points, closed);
            let order = control_points.map(|count| usize::from(count) - 1);
            let basis = match (order, closed) {
                (None, _) => return auto,
                (Some(order), false) => Basis::Bezier { order },
                (Some(order), true) => Basis::Fourier {
                    harmonics: (order / 2).max(1),
                },
            };
            auto.basis(basis).choose_size(false)
        };
        Ok(Self {
            fitters: [Fitter::new(options(false))?, Fitter::new(options(true))?],
            points: Vec::new(),
        })
    }

    /// Fits the curve of a rope that is seen for the first time.
    pub(super) fn fit(&mut self, curve: &Curve) -> Result<Fitted> {
        self.fit_steady(curve, &mut SteadySize::default(), 0)
    }

    fn fit_steady(&mut self, curve: &Curve, size: &mut SteadySize, now_ns: u64) -> Result<Fitted> {
        self.points.clear();
        let points = curve.points.iter().map(|point| point.map(f64::from));
        self.points.extend(points);
        let width_px = f64::from(curve.width_px);
        let line = Line {
            points: &self.points,
            weights: None,
            hidden: &curve.hidden,
        };
        let tolerance = Tolerance::of_width(width_px, Tolerance::WIDTHS, Tolerance::LIMIT_PX);
        let fitter = &mut self.fitters[usize::from(curve.closed)];
        let judged = size.fit(fitter, &line, tolerance, now_ns)?;
        let fit = fitter.last();
        Ok(Fitted {
            control_points: fit.control_points.len(),
            rms_px: fit.rms_px,
            worst_px: fit.max_px,
            width_px,
            is_good: judged.is_good,
        })
    }
}

/// Returns the figures of each set of curves.
pub(super) fn table<'a>(sets: impl IntoIterator<Item = (&'a str, Vec<Fitted>)>) -> String {
    let mut table = Table::new(&[
        "the curve, px",
        "ropes",
        "control points",
        "most",
        "rms p50",
        "rms max",
        "worst p50",
        "worst max",
        "within half a width",
        "coarse",
    ]);
    for (name, fits) in sets {
        let of = |value: fn(&Fitted) -> f64| {
            let mut samples = Samples::default();
            fits.iter().for_each(|fit| samples.push(value(fit)));
            [samples.percentile(0.5), samples.percentile(1.0)]
        };
        let [sizes, rms, worst] = [
            of(|fit| fit.control_points as f64),
            of(|fit| fit.rms_px),
            of(|fit| fit.worst_px),
        ];
        let near = fits.iter().filter(|fit| fit.worst_px <= 0.5 * fit.width_px);
        let share = 100.0 * near.count() as f64 / fits.len().max(1) as f64;
        let coarse = fits.iter().filter(|fit| !fit.is_good).count();
        table.push(
            [
                vec![name.to_owned(), fits.len().to_string()],
                sizes.map(|size| size.to_string()).into(),
                rms.map(|px| format!("{px:.2}")).into(),
                worst.map(|px| format!("{px:.2}")).into(),
                vec![format!("{share:.1} %"), coarse.to_string()],
            ]
            .concat(),
        );
    }
    table.to_string()
}

/// Prints the figures of a film, given as a folder of pictures. The number of control points of a
/// rope's curve is kept steady over time.
///
/// # Errors
/// A picture cannot be read.
pub(super) fn run_on_film(
    folder: &Path,
    method: Method,
    control_points: Option<u16>,
) -> Result<()> {
    let unread = || format!("cannot read the folder {}", folder.display());
    let entries = std::fs::read_dir(folder).with_context(unread)?;
    let paths: std::io::Result<Vec<_>> = entries.map(|entry| Ok(entry?.path())).collect();
    let mut paths = paths.with_context(unread)?;
    paths.retain(|path| {
        path.extension()
            .is_some_and(|end| end == "png" || end == "jpg")
    });
    paths.sort();
    let mut curves = Curves::new(control_points)?;
    let mut extractor = Extractor::new(Options::default().method(method))?;
    let (mut tracks, mut fits) = (Vec::<(u32, bool, SteadySize)>::new(), Vec::new());
    for (path, frame) in paths.iter().zip(0u64..) {
        let picture = photo::load(path)?.to_rgb8();
        let [width, height] = [picture.width() as usize, picture.height() as usize];
        let image = Image::new(&picture, width, height, 3 * width, PixelFormat::Rgb8)?;
        for curve in extractor.extract(&image).curves {
            let own = |(track, closed, _): &(u32, bool, SteadySize)| {
                (*track, *closed) == (curve.track, curve.closed)
            };
            let index = tracks.iter().position(own).unwrap_or_else(|| {
                tracks.push((curve.track, curve.closed, SteadySize::default()));
                tracks.len() - 1
            });
            let now_ns = frame * 1_000_000_000 / FPS;
            fits.push(curves.fit_steady(curve, &mut tracks[index].2, now_ns)?);
        }
    }
    print!("{}", table([("film", fits)]))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::drawing::tests::curve;

    #[test]
    fn the_share_of_curves_within_half_a_width_is_told() {
        let bent: Vec<[f64; 2]> = (0..120)
            .map(|i| [3.0 * f64::from(i), 60.0 * (0.1 * f64::from(i)).sin()])
            .collect();
        let rope = curve(&bent, 10.0);
        let row = |control_points| {
            let fitted = Curves::new(control_points).unwrap().fit(&rope).unwrap();
            table([("one", vec![fitted])])
        };
        assert!(row(None).contains("100.0 %"), "{}", row(None));
        assert!(row(Some(3)).contains(" 0.0 %"), "{}", row(Some(3)));
    }
}
