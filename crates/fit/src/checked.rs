//! Validates requests.

use crate::basis::{Basis, MAX_CONTROL_POINTS};
use crate::error::FitterError;
use crate::options::{MAX_ORDER, MAX_POINTS, Options, Rho, Weights};

/// Checks that sizes are in range, that there are enough points, and that the options apply to the
/// basis.
pub(crate) fn check(options: &Options) -> Result<(), FitterError> {
    let Options { basis, points, .. } = *options;
    sizes(basis)?;
    if !(2..=MAX_POINTS).contains(&points) {
        return Err(FitterError::Points { points });
    }
    if points < basis.control_points() {
        return Err(FitterError::TooFewPoints {
            points,
            basis,
            nearest: std::iter::successors(basis.smaller(), |basis| basis.smaller())
                .find(|smaller| smaller.control_points() <= points),
        });
    }
    if !(options.ridge >= 0.0 && options.ridge.is_finite()) {
        return Err(FitterError::Ridge {
            ridge: options.ridge,
        });
    }
    useful(options)
}

fn sizes(basis: Basis) -> Result<(), FitterError> {
    let within = |what, given, low, high| {
        if (low..=high).contains(&given) {
            Ok(())
        } else {
            Err(FitterError::Size {
                what,
                given,
                low,
                high,
            })
        }
    };
    match basis {
        Basis::Bezier { order } | Basis::RationalBezier { order } => {
            within("order", order, 1, MAX_ORDER)
        }
        Basis::BSpline {
            degree,
            control_points,
            ..
        } => {
            within(
                "so many control points:",
                control_points,
                2,
                MAX_CONTROL_POINTS,
            )?;
            within("degree", degree, 1, control_points - 1)
        }
        Basis::Fourier { harmonics } => within(
            "so many harmonics:",
            harmonics,
            1,
            (MAX_CONTROL_POINTS - 1) / 2,
        ),
        Basis::FeaturePoints { count } => {
            within("so many feature points:", count, 2, MAX_CONTROL_POINTS)
        }
        Basis::CenterOfMass => Ok(()),
    }
}

fn useful(options: &Options) -> Result<(), FitterError> {
    let basis = options.basis;
    let refuse = |option, why| Err(FitterError::Option { basis, option, why });
    let regression = !matches!(basis, Basis::FeaturePoints { .. } | Basis::CenterOfMass);
    let rational = matches!(basis, Basis::RationalBezier { .. });
    if options.pin_ends && !basis.has_ends() {
        return refuse(
            "pinned ends",
            "it has no outer control points; leave them free",
        );
    }
    if options.ridge > 0.0 && (!regression || rational) {
        return refuse("a ridge", "choose bezier, bspline or fourier, or no ridge");
    }
    if options.choose_size && (!regression || rational) {
        return refuse(
            "a size chosen for it",
            "choose bezier, bspline or fourier, or name the size",
        );
    }
    if options.weights != Weights::Even && (!regression || rational) {
        return refuse(
            "weights",
            "choose bezier, bspline or fourier, or leave it out",
        );
    }
    if options.rho == Rho::Measured && (!regression || rational) {
        return refuse(
            "measured arc lengths",
            "choose bezier, bspline or fourier, or give points in even steps",
        );
    }
    Ok(())
}
