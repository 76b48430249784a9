//! The families of curves at an equal number of parameters: the paper's, those it allows, and the
//! rivals it names.
//!
//! Each control point counts as two numbers. Each weight of a rational curve counts as one number,
//! except for one weight, because only the ratios of the weights matter.

use lariat_fit::{Basis, Fit, Fitter, Options};

use crate::PaperError;
use crate::curves::{bspline, curve};
use crate::shapes::POINTS;

/// Number of parameters at the paper's best order: nine control points of two numbers each.
pub(crate) const PAPERS_NUMBERS: usize = 18;

/// A way to describe a centerline by few numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    Bezier,
    BSpline,
    Rational,
    /// A Fourier series once along the rope and straight back to its start, as for a contour.
    Fourier,
    /// A Fourier series along the rope and back along it. It consists of cosines alone, without a
    /// jump.
    Cosines,
    FeaturePoints,
    CenterOfMass,
}

impl Family {
    pub(crate) const ALL: [Self; 7] = [
        Self::Bezier,
        Self::BSpline,
        Self::Rational,
        Self::Fourier,
        Self::Cosines,
        Self::FeaturePoints,
        Self::CenterOfMass,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Bezier => "Bezier",
            Self::BSpline => "cubic B-spline",
            Self::Rational => "rational Bezier",
            Self::Fourier => "Fourier, closed",
            Self::Cosines => "Fourier, there and back",
            Self::FeaturePoints => "feature points",
            Self::CenterOfMass => "center of mass",
        }
    }

    /// Returns whether the paper names this family as inferior to its method.
    pub(crate) fn is_rival(self) -> bool {
        matches!(
            self,
            Self::Fourier | Self::Cosines | Self::FeaturePoints | Self::CenterOfMass
        )
    }

    /// Returns the family's largest basis with at most `numbers` parameters, and their actual
    /// number. Returns `None` if even its smallest basis has more.
    fn basis(self, numbers: usize) -> Option<(Basis, usize)> {
        let points = numbers / 2;
        let two_each = |basis: Basis| (basis, 2 * basis.control_points());
        match self {
            Self::Bezier => (points >= 2).then(|| two_each(Basis::Bezier { order: points - 1 })),
            Self::BSpline => (points >= 4).then(|| two_each(bspline(points))),
            Self::Rational => {
                // Order k has 2 (k + 1) + k numbers.
                let order = numbers.checked_sub(2)? / 3;
                (order >= 2).then_some((Basis::RationalBezier { order }, 3 * order + 2))
            }
            Self::Fourier => {
                let harmonics = points.checked_sub(1)? / 2;
                (harmonics >= 1).then(|| two_each(Basis::Fourier { harmonics }))
            }
            Self::Cosines => {
                let harmonics = points.checked_sub(1)?;
                // The sines of a series along the rope and back are not free parameters.
                (1..=15)
                    .contains(&harmonics)
                    .then_some((Basis::Fourier { harmonics }, 2 * points))
            }
            Self::FeaturePoints => {
                (points >= 2).then(|| two_each(Basis::FeaturePoints { count: points }))
            }
            Self::CenterOfMass => (points == 1).then_some((Basis::CenterOfMass, 2)),
        }
    }
}

/// A family's curves of one size, ready to be fitted.
pub(crate) struct Fitting {
    pub(crate) family: Family,
    /// Number of parameters of a curve.
    pub(crate) numbers: usize,
    fitter: Fitter,
    there_and_back: Vec<[f64; 2]>,
}

impl Fitting {
    /// Creates a fitting for the family's largest curves with at most `numbers` parameters.
    pub(crate) fn of(family: Family, numbers: usize) -> Result<Option<Self>, PaperError> {
        let Some((basis, numbers)) = family.basis(numbers) else {
            return Ok(None);
        };
        let points = match family {
            Family::Cosines => 2 * POINTS,
            _ => POINTS,
        };
        let fitter = Fitter::new(Options::default().basis(basis).points(points))?;
        Ok(Some(Self {
            family,
            numbers,
            fitter,
            there_and_back: Vec::with_capacity(points),
        }))
    }

    pub(crate) fn fit(&mut self, points: &[[f64; 2]]) -> Result<&Fit, PaperError> {
        // Otherwise the weights of a rational curve would start at those of the last rope.
        self.fitter.forget();
        self.fit_again(points)
    }

    /// Fits like [`fit`](Self::fit), but starts from the previous fit, as for a rope that moves in
    /// front of a camera.
    pub(crate) fn fit_again(&mut self, points: &[[f64; 2]]) -> Result<&Fit, PaperError> {
        if self.family != Family::Cosines {
            return Ok(self.fitter.fit(points)?);
        }
        self.there_and_back.clear();
        self.there_and_back.extend_from_slice(points);
        self.there_and_back.extend(points.iter().rev());
        Ok(self.fitter.fit(&self.there_and_back)?)
    }

    /// Returns the root mean square distance of the points of `reference` from the last fit's
    /// curve, px.
    pub(crate) fn off_px(&self, reference: &[[f64; 2]]) -> Result<f64, PaperError> {
        let curve = curve(self.fitter.last())?;
        let rho = |i: usize| match self.family {
            Family::Cosines => i as f64 / (2 * reference.len()) as f64,
            _ => curve.basis().even_rho(i, reference.len()),
        };
        let placed = reference.iter().enumerate().map(|(i, &p)| (p, rho(i)));
        Ok(curve.distance_to_at(placed).rms)
    }
}

impl Fitting {
    /// Returns N points along the last fit's curve, one at the ρ of each of the N points.
    pub(crate) fn sampled(&self) -> Result<Vec<[f64; 2]>, PaperError> {
        let curve = curve(self.fitter.last())?;
        let rho = |i: usize| match self.family {
            Family::Cosines => i as f64 / (2 * POINTS) as f64,
            _ => curve.basis().even_rho(i, POINTS),
        };
        Ok((0..POINTS).map(|i| curve.point(rho(i))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eighteen_numbers_are_nine_points_of_any_family() {
        for family in Family::ALL {
            let fitting = Fitting::of(family, PAPERS_NUMBERS).unwrap();
            match family {
                Family::CenterOfMass => assert!(fitting.is_none()),
                Family::Rational => assert_eq!(fitting.unwrap().numbers, 17),
                _ => assert_eq!(fitting.unwrap().numbers, 18, "{family:?}"),
            }
        }
    }

    #[test]
    fn there_and_back_a_line_has_no_leap() {
        let bow: Vec<[f64; 2]> = (0..POINTS)
            .map(|i| {
                let u = i as f64 / (POINTS - 1) as f64;
                [400.0 * u, 120.0 * (std::f64::consts::PI * u).sin()]
            })
            .collect();
        let off = |family| {
            let mut fitting = Fitting::of(family, PAPERS_NUMBERS).unwrap().unwrap();
            fitting.fit(&bow).unwrap();
            fitting.off_px(&bow).unwrap()
        };
        assert!(off(Family::Cosines) < 0.2 * off(Family::Fourier));
        assert!(off(Family::Bezier) < off(Family::Cosines));
    }
}
