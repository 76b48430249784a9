//! The shape of a curve: how straight, round or sharply bent it is, and where it runs.

use crate::bitmap::bits::BitPlane;
use crate::scene::Curve;
use crate::statistics::grade;
use crate::vec2::{self, Vec2};

/// Distance of the farthest point from the chord at which a curve is not straight, and at which it
/// is as straight as a rigid object, in widths. A rope's own stiffness leaves more.
const STRAIGHT: (f32, f32) = (0.36, 0.12);
/// The same for thin curves, in pixels.
const STRAIGHT_PX: (f32, f32) = (3.0, 1.0);
/// Turn of an arc, in radians, at which it begins to count as a circle and at which it counts
/// fully.
const ARC: (f32, f32) = (2.5, 4.0);
/// Deviation from a circle or ellipse, as a share of the radius, at which a curve is not round and
/// at which it is.
const EXACT: (f32, f32) = (0.03, 0.01);
/// Maximum ratio of an ellipse's axes. A round rim seen from 20° above the table has this ratio.
const OBLONG: f32 = 3.0;
/// Maximum slant of a strip along the image's border.
const SLANT: f32 = 0.3;
/// Maximum distance of the strip's middle from the border, in widths plus pixels.
const BORDER: (f32, f32) = (0.6, 2.0);

/// Sharpness of the curve's sharpest bend. A rope's stiffness keeps the radius above its width.
pub(super) fn bends(curve: &Curve) -> f32 {
    let points = &curve.points;
    let step_px = curve.length_px / points.len().max(2) as f32;
    let reach = (libm::ceilf(1.5 * curve.width_px / step_px.max(0.1)) as usize).max(1);
    let mut sharpest = 0.0f32;
    for i in reach..points.len().saturating_sub(reach) {
        let before = vec2::unit_or(vec2::sub(points[i], points[i - reach]), [1.0, 0.0]);
        let after = vec2::unit_or(vec2::sub(points[i + reach], points[i]), [1.0, 0.0]);
        sharpest = sharpest.max(1.0 - vec2::dot(before, after));
    }
    0.5 * sharpest
}

/// How straight an open curve is: 1 for a rigid object.
pub(super) fn straightness(curve: &Curve) -> f32 {
    let (Some(&from), Some(&to)) = (curve.points.first(), curve.points.last()) else {
        return 0.0;
    };
    if curve.closed {
        return 0.0;
    }
    let along = vec2::unit_or(vec2::sub(to, from), [1.0, 0.0]);
    let off_px = |at: &Vec2| {
        let way = vec2::sub(*at, from);
        (way[0] * along[1] - way[1] * along[0]).abs()
    };
    let farthest_px = curve.points.iter().map(off_px).fold(0.0, f32::max);
    let limit_px = |widths: f32, least_px: f32| (widths * curve.width_px).max(least_px);
    grade(
        farthest_px,
        limit_px(STRAIGHT.0, STRAIGHT_PX.0),
        limit_px(STRAIGHT.1, STRAIGHT_PX.1),
    )
}

/// The curve's resemblance to a rim: a closed ellipse, or an arc of a circle.
pub(super) fn roundness(curve: &Curve) -> f32 {
    match curve.closed {
        true => ellipse(curve),
        false => circle(curve),
    }
}

/// An open curve's resemblance to a circle: its turn and its deviation from the least-squares
/// circle (Kåsa, 1976).
fn circle(curve: &Curve) -> f32 {
    let share = 1.0 / curve.points.len().max(1) as f32;
    let middle = mean(curve);
    let places = || curve.points.iter().map(move |&at| vec2::sub(at, middle));
    let (mut xx, mut xy, mut yy, mut xz, mut yz) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for [x, y] in places() {
        let z = x * x + y * y;
        (xx, xy, yy) = (xx + share * x * x, xy + share * x * y, yy + share * y * y);
        (xz, yz) = (xz + share * x * z, yz + share * y * z);
    }
    let determinant = 2.0 * (xx * yy - xy * xy);
    if determinant <= 1e-3 * (xx + yy) * (xx + yy) {
        return 0.0;
    }
    let middle = [
        (xz * yy - yz * xy) / determinant,
        (yz * xx - xz * xy) / determinant,
    ];
    let radius_px = (vec2::dot(middle, middle) + xx + yy).sqrt();
    let off = places().map(|at| {
        let off_px = vec2::distance(at, middle) - radius_px;
        share * off_px * off_px
    });
    let off = off.sum::<f32>().sqrt() / radius_px;
    let turn = curve.length_px / radius_px;
    grade(turn, ARC.0, ARC.1) * grade(off, EXACT.0, EXACT.1)
}

/// A closed curve's resemblance to an ellipse, by a least-squares fit of a x² + b xy + c y² = 1
/// about its middle.
fn ellipse(curve: &Curve) -> f32 {
    let count = curve.points.len() as f32;
    let middle = mean(curve);
    let radius_px = curve.length_px / std::f32::consts::TAU;
    let terms = || {
        curve.points.iter().map(move |&at| {
            let [x, y] = vec2::scale(vec2::sub(at, middle), 1.0 / radius_px);
            [x * x, x * y, y * y]
        })
    };
    let (mut squares, mut ones) = ([[0.0f32; 3]; 3], [0.0f32; 3]);
    for term in terms() {
        for i in 0..3 {
            ones[i] += term[i];
            for j in 0..3 {
                squares[i][j] += term[i] * term[j];
            }
        }
    }
    let Some([a, b, c]) = solve(squares, ones) else {
        return 0.0;
    };
    let off = terms().map(|t| {
        let off = a * t[0] + b * t[1] + c * t[2] - 1.0;
        off * off
    });
    // The radius follows the square root, so its relative error is half as large.
    let rms = 0.5 * (off.sum::<f32>() / count).sqrt();
    let (mean, spread) = (
        0.5 * (a + c),
        (0.25 * (a - c) * (a - c) + 0.25 * b * b).sqrt(),
    );
    let oblong = ((mean + spread) / (mean - spread).max(1e-6)).sqrt();
    match oblong <= OBLONG {
        true => grade(rms, EXACT.0, EXACT.1),
        false => 0.0,
    }
}

fn mean(curve: &Curve) -> Vec2 {
    let share = 1.0 / curve.points.len().max(1) as f32;
    (curve.points.iter()).fold([0.0; 2], |sum, &at| vec2::along(sum, at, share))
}

/// Cramer's rule.
fn solve(m: [[f32; 3]; 3], right: [f32; 3]) -> Option<[f32; 3]> {
    let det = |m: &[[f32; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let all = det(&m);
    let with = |column: usize| {
        let mut m = m;
        (0..3).for_each(|row| m[row][column] = right[row]);
        det(&m) / all
    };
    (all.abs() > 1e-6).then(|| [with(0), with(1), with(2)])
}

/// Share of a curve that runs along the border of an image of this size.
pub(super) fn along_border(curve: &Curve, size_px: [f32; 2]) -> f32 {
    let pairs = curve.points.windows(2).zip(&curve.widths_px);
    let beside = pairs.filter(|(pair, width_px)| {
        let along = vec2::unit_or(vec2::sub(pair[1], pair[0]), [1.0, 0.0]);
        (0..2).any(|k| {
            let to_px = pair[0][k].min(size_px[k] - 1.0 - pair[0][k]);
            along[k].abs() < SLANT && to_px < BORDER.0 * **width_px + BORDER.1
        })
    });
    beside.count() as f32 / curve.points.len().max(1) as f32
}

/// Share of places, on both sides of the curve's middle, that are set in `plane`.
pub(super) fn share_within(curve: &Curve, plane: &BitPlane) -> f32 {
    let along = curve.points.windows(2).zip(&curve.widths_px);
    let sides = along.flat_map(|(pair, width_px)| {
        let along = vec2::unit_or(vec2::sub(pair[1], pair[0]), [1.0, 0.0]);
        let aside = vec2::scale([-along[1], along[0]], 0.25 * width_px);
        [vec2::add(pair[0], aside), vec2::sub(pair[0], aside)]
    });
    let set = sides.filter(|at| plane.get(at[0] as i32, at[1] as i32));
    set.count() as f32 / (2.0 * curve.points.len().max(1) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(count: usize, closed: bool, at: impl Fn(f32) -> Vec2) -> Curve {
        let last = count - usize::from(!closed);
        let points: Vec<_> = (0..count).map(|k| at(k as f32 / last as f32)).collect();
        let pairs = points.iter().zip(points.iter().cycle().skip(1));
        let steps = pairs.take(last).map(|(a, b)| vec2::distance(*a, *b));
        Curve {
            length_px: steps.sum(),
            widths_px: vec![8.0; count],
            width_px: 8.0,
            points,
            closed,
            ..Curve::default()
        }
    }

    /// An arc of a circle, or of a flattened one.
    fn arc(turn: f32, flat: f32) -> Curve {
        curve(64, turn == TURN, |t| {
            let (sin, cos) = (turn * t).sin_cos();
            [100.0 + 60.0 * cos, 100.0 + flat * 60.0 * sin]
        })
    }

    #[test]
    fn a_curve_is_less_straight_the_more_it_sags() {
        let sag = |px: f32| {
            let bow = move |t: f32| [20.0 + 200.0 * t, 50.0 + 4.0 * px * t * (1.0 - t)];
            straightness(&curve(50, false, bow))
        };
        // The ropes are 8 px wide.
        assert_eq!([sag(0.0), sag(0.9), sag(4.0)], [1.0, 1.0, 0.0]);
        let between = [1.2, 1.6, 2.0, 2.4].map(sag);
        assert!(between.is_sorted_by(|a, b| a > b), "{between:?}");
    }

    #[test]
    fn a_rim_is_round_from_any_side_and_a_bend_is_not() {
        let rims = [arc(TURN, 1.0), arc(TURN, 0.5), arc(5.0, 1.0)];
        assert_eq!(rims.map(|rim| roundness(&rim)), [1.0; 3]);
        for bend in [arc(1.5, 1.0), arc(TURN, 0.2), arc(5.0, 0.6)] {
            assert_eq!(roundness(&bend), 0.0);
        }
    }

    const TURN: f32 = std::f32::consts::TAU;

    #[test]
    fn a_strip_runs_along_the_border_and_a_rope_that_crosses_it_does_not() {
        let line = |to: Vec2| curve(50, false, move |t| [3.0 + (to[0] - 3.0) * t, to[1] * t]);
        let at = |to| along_border(&line(to), [200.0, 200.0]);
        assert!(at([3.0, 199.0]) > 0.9);
        assert!(at([199.0, 199.0]) < 0.1);
    }
}
