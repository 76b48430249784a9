//! Converts an extractor's curves for the scores of drawn scenes.

use lariat_drawn::scenes::SeenCurve;
use lariat_extract::Curve;

/// The extracted curves, to be compared with the drawn ones.
pub(crate) fn scored<'a>(curves: impl IntoIterator<Item = &'a Curve>) -> Vec<SeenCurve<'a>> {
    let curves = curves.into_iter().map(|curve| SeenCurve {
        points: &curve.points,
        width_px: curve.width_px,
        closed: curve.closed,
    });
    curves.collect()
}
