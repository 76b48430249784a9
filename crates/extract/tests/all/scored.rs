//! An extractor's curves as drawn scenes score them.

use lariat_drawn::scenes::SeenCurve;
use lariat_extract::Curve;

/// What was seen, to be held against what was drawn.
pub(crate) fn scored<'a>(curves: impl IntoIterator<Item = &'a Curve>) -> Vec<SeenCurve<'a>> {
    let curves = curves.into_iter().map(|curve| SeenCurve {
        points: &curve.points,
        width_px: curve.width_px,
        closed: curve.closed,
    });
    curves.collect()
}
