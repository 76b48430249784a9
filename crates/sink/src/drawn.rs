//! Samples a descriptor's curve, for drawing or for comparison.

use lariat_fit::{self as fit, Curve, Knots, MAX_KNOTS};
use lariat_message::{self as wire, Descriptor};

/// Fills `points` with points of the descriptor's curve at even steps of ρ from 0 to 1, in its
/// message's unit. Returns `false` if this version does not know the curve.
pub fn points_along(descriptor: &Descriptor, points: &mut [[f64; 2]]) -> bool {
    let mut knots = [0.0; MAX_KNOTS];
    let Some(curve) = curve(descriptor, &mut knots) else {
        return false;
    };
    let steps = points.len().saturating_sub(1).max(1) as f64;
    for (i, point) in points.iter_mut().enumerate() {
        *point = curve.point(i as f64 / steps);
    }
    true
}

/// Returns the descriptor's curve, if it is valid. `knots` is a buffer for the knots of a B-spline.
fn curve<'a>(descriptor: &'a Descriptor, knots: &mut [f64; MAX_KNOTS]) -> Option<Curve<'a>> {
    let control_points = descriptor.control_points();
    let (count, order) = (control_points.len(), descriptor.degree as usize);
    let mut weights: &[f64] = &[];
    let mut total = 0;
    let basis = match descriptor.basis()? {
        wire::Basis::Bezier => fit::Basis::Bezier { order },
        wire::Basis::RationalBezier => {
            weights = descriptor.weights();
            fit::Basis::RationalBezier { order }
        }
        wire::Basis::BSpline => {
            for (to, knot) in knots.iter_mut().zip(descriptor.all_knots()) {
                *to = knot;
                total += 1;
            }
            fit::Basis::BSpline {
                degree: order,
                control_points: count,
                knots: Knots::Averaged,
            }
        }
        wire::Basis::Fourier => fit::Basis::Fourier { harmonics: order },
        wire::Basis::FeaturePoints => fit::Basis::FeaturePoints { count },
        wire::Basis::CenterOfMass => fit::Basis::CenterOfMass,
    };
    Curve::new(basis, control_points, weights, &knots[..total]).ok()
}
