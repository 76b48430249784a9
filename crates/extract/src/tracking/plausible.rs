//! Curves that may not be ropes, judged by the table around them and by the other ropes.
//!
//! A rope is long, bends, and is on the table, which continues unchanged on both sides of it. A
//! curve may instead be:
//!
//! - an edge, if it is straight with a different surface on each side, or fills a strip at the
//!   image's border;
//! - a rim, if it is an ellipse and the surface inside differs from that outside, or if it is
//!   unlike the other ropes;
//! - a pen or print, if it is straight and short, or small, and unlike a rope that is far longer;
//! - a shadow, if the table is dimmer there.
//!
//! A curve alone on a plain table is a rope.

use super::track::Appearance;
use crate::bitmap::bits::BitPlane;
use crate::image::{Image, color};
use crate::mask::background::Background;
use crate::mask::shadow;
use crate::notice::Notice;
use crate::occlusion::ends::ALIKE;
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Maximum distance of a straight object from its chord, in widths. A rope's own stiffness leaves
/// more.
const STRAIGHT: f32 = 0.12;
/// Maximum length of a pen, in widths.
const PEN_WIDTHS: f32 = 24.0;
/// Maximum length of a small mark, in widths.
const SMALL_WIDTHS: f32 = 16.0;
/// Minimum length of a rope, relative to a short object next to it.
const LONGER: f32 = 1.8;
/// Same relative to a small mark or a thin shadow.
const SMALL: f32 = 4.0;
/// Maximum length of a straight object that is doubted next to any longer rope, in widths.
const STUB_WIDTHS: f32 = 10.0;
/// Minimum length of a rope, relative to a straight line from border to border, for the line to be
/// an edge.
const SHORTER: f32 = 0.6;
/// Number of similar small objects that are print.
const MARKS: usize = 3;
/// Maximum length of each of them, relative to the rope.
const LONGEST_MARK: f32 = 0.25;
/// Maximum deviation of a rim from an ellipse, as a share of its radius.
const ROUND: f32 = 0.015;
/// Maximum ratio of the ellipse's axes.
const OBLONG: f32 = 3.0;
/// Share of places, on both sides of a curve's middle, that may be shadow. Above it, the curve is a
/// shadow or includes one.
const PALE: f32 = 0.3;
/// Distances from a curve's edge at which the table is sampled, in widths. They are beyond a shadow
/// next to it.
const BESIDE_WIDTHS: [f32; 3] = [1.2, 2.2, 3.2];
/// Maximum slant of a strip along the image's border.
const SLANT: f32 = 0.3;
/// Maximum distance of the strip's middle from the border, in widths plus pixels.
const BORDER: (f32, f32) = (0.6, 2.0);
/// Number of places along a curve at which its sides are sampled.
const ASKED: usize = 24;
/// Minimum share of these places with table on both sides.
const SHOWN: f32 = 0.5;
/// Minimum difference of two surfaces, in levels, and as a factor of the table's noise.
const SURFACES: (f32, f32) = (7.0, 2.5);

/// Data for judging an image's curves.
pub(crate) struct Surroundings<'a> {
    pub(crate) image: &'a Image<'a>,
    pub(crate) background: &'a Background,
    pub(crate) mask: &'a BitPlane,
    /// Pixels that may be the ropes' shadow, if there are any.
    pub(crate) maybe_shadow: Option<&'a BitPlane>,
}

impl Surroundings<'_> {
    /// Fills `doubts` with what each curve may be instead of a rope. `is_known` returns whether a
    /// curve is known to be a rope.
    ///
    /// A curve is judged by itself first, then against the longest other curve that is undoubted
    /// and differs in color or width. If that one is known to be a rope, it counts as infinitely
    /// long.
    pub(crate) fn doubt(
        &self,
        (curves, appearances): (&[Curve], &[Appearance]),
        is_known: impl Fn(&Curve) -> bool,
        doubts: &mut Vec<Option<Notice>>,
    ) {
        doubts.clear();
        doubts.extend(curves.iter().map(|curve| self.by_itself(curve)));
        let yuv = color::is_yuv(self.image.format());
        let are_alike = |a: usize, b: usize| {
            let levels = color::distance(appearances[a].color, appearances[b].color, yuv);
            let width = curves[a].width_px / curves[b].width_px;
            levels <= ALIKE.0 && width.max(1.0 / width) <= ALIKE.1
        };
        for i in 0..curves.len() {
            if doubts[i].is_some() {
                continue;
            }
            // The longest curves come first, so this is the one that is most likely a rope.
            let mut ropes = (0..curves.len()).filter(|&k| k != i && doubts[k].is_none());
            let Some(rope) = ropes.find(|&k| !are_alike(k, i)) else {
                continue;
            };
            let times = match is_known(&curves[rope]) {
                true => f32::INFINITY,
                false => curves[rope].length_px / curves[i].length_px,
            };
            let is_small = |k: usize| LONGEST_MARK * curves[rope].length_px > curves[k].length_px;
            let marks = (0..curves.len()).filter(|&k| is_small(k) && are_alike(k, i));
            let is_thin = ALIKE.1 * curves[i].width_px < curves[rope].width_px;
            doubts[i] = match is_thin && times > SMALL && self.is_dim(&curves[i]) {
                true => Some(Notice::MaybeShadow),
                false => looks_like(&curves[i], times, marks.count()),
            };
        }
    }

    /// Judges a curve regardless of the others: what it may be instead of a rope.
    fn by_itself(&self, curve: &Curve) -> Option<Notice> {
        if self.maybe_shadow.is_some_and(|plane| is_pale(curve, plane)) {
            return Some(Notice::MaybeShadow);
        }
        if self.is_strip(curve) {
            return Some(Notice::LikeAnEdge);
        }
        let is_line = !curve.closed && is_straight(curve);
        let is_rim = curve.closed && is_round(curve);
        if !(is_line || is_rim) || !self.parts_surfaces(curve) {
            return None;
        }
        Some(if is_rim {
            Notice::LikeARim
        } else {
            Notice::LikeAnEdge
        })
    }

    /// Returns whether the curve runs along the image's border and reaches it.
    fn is_strip(&self, curve: &Curve) -> bool {
        let size = [self.image.width(), self.image.height()].map(|side| side as f32);
        let beside = curve
            .points
            .windows(2)
            .zip(&curve.widths_px)
            .filter(|(pair, width_px)| {
                let along = vec2::unit_or(vec2::sub(pair[1], pair[0]), [1.0, 0.0]);
                (0..2).any(|k| {
                    let to_px = pair[0][k].min(size[k] - 1.0 - pair[0][k]);
                    along[k].abs() < SLANT && to_px < BORDER.0 * **width_px + BORDER.1
                })
            });
        2 * beside.count() > curve.points.len()
    }

    /// Returns whether most of the curve inside the image is the table in less light.
    fn is_dim(&self, curve: &Curve) -> bool {
        let size = [self.image.width(), self.image.height()].map(|side| side as f32);
        let is_within = |at: &&Vec2| (0..2).all(|k| (0.0..size[k]).contains(&at[k]));
        let is_dim = |at: &&Vec2| {
            let light = shadow::light_left(self.image, self.background, at.map(|c| c as usize));
            light.is_some_and(|light| light < 1.0)
        };
        let asked = || {
            let stride = (curve.points.len() / ASKED).max(1);
            curve.points.iter().step_by(stride).filter(is_within)
        };
        4 * asked().filter(is_dim).count() > 3 * asked().count()
    }

    /// Returns whether the table differs between the two sides of the curve.
    fn parts_surfaces(&self, curve: &Curve) -> bool {
        let points = &curve.points;
        let stride = (points.len() / ASKED).max(1);
        let mut means = [[0.0f32; 3]; BESIDE_WIDTHS.len()];
        let (mut count, mut asked) = (0.0, 0.0);
        for i in (stride..points.len().saturating_sub(stride)).step_by(stride) {
            asked += 1.0;
            let along = vec2::sub(
                points[i + stride.min(points.len() - 1 - i)],
                points[i - stride],
            );
            let along = vec2::unit_or(along, [1.0, 0.0]);
            let normal = [-along[1], along[0]];
            let Some(steps) = self.steps_across(points[i], normal, curve.widths_px[i]) else {
                continue;
            };
            count += 1.0;
            for (mean, step) in means.iter_mut().zip(&steps) {
                *mean = std::array::from_fn(|c| mean[c] + step[c]);
            }
        }
        if count < SHOWN * asked || count < 4.0 {
            return false;
        }
        let yuv = color::is_yuv(self.image.format());
        let least = SURFACES.0.max(SURFACES.1 * self.background.noise);
        let steps = means.iter().map(|mean| mean.map(|c| c / count));
        // The difference must be the same at each distance.
        let middle = means[1].map(|c| c / count);
        steps.into_iter().all(|step| {
            color::distance(step, [0.0; 3], yuv) > least
                && color::distance(step, middle, yuv) < 0.5 * color::distance(middle, [0.0; 3], yuv)
        })
    }

    /// Difference between the right and the left of a place, each relative to the estimated table,
    /// at the distances `BESIDE_WIDTHS`. `None` where no table is visible.
    fn steps_across(
        &self,
        at: Vec2,
        normal: Vec2,
        width_px: f32,
    ) -> Option<[[f32; 3]; BESIDE_WIDTHS.len()]> {
        let mut steps = [[0.0; 3]; BESIDE_WIDTHS.len()];
        for (step, beside) in steps.iter_mut().zip(BESIDE_WIDTHS) {
            let away = vec2::scale(normal, (0.5 + beside) * width_px);
            let right = self.off_table(vec2::add(at, away))?;
            let left = self.off_table(vec2::sub(at, away))?;
            *step = std::array::from_fn(|c| right[c] - left[c]);
        }
        Some(steps)
    }

    /// Difference of a place from the estimated table, or `None` on a rope or outside of the image.
    fn off_table(&self, at: Vec2) -> Option<[f32; 3]> {
        let [x, y] = at.map(|c| c as i32);
        let is_inside = at[0] >= 1.0
            && at[1] >= 1.0
            && at[0] < self.image.width() as f32 - 1.0
            && at[1] < self.image.height() as f32 - 1.0;
        if !is_inside || self.mask.get(x, y) {
            return None;
        }
        let own = color::between(self.image, at);
        let table = self.background.at(x as usize, y as usize);
        Some(std::array::from_fn(|c| own[c] - table[c]))
    }
}

/// Classifies a curve that is unlike another rope. `times` is the rope's length relative to the
/// curve's, and `marks` is the number of small objects like the curve.
fn looks_like(curve: &Curve, times: f32, marks: usize) -> Option<Notice> {
    let widths = curve.length_px / curve.width_px;
    if curve.closed {
        return is_round(curve).then_some(Notice::LikeARim);
    }
    let is_free = curve.border == [false; 2];
    let is_whole = curve.border == [true; 2];
    let is_stub = !is_whole && widths < STUB_WIDTHS && marks < MARKS;
    if times < LONGER {
        return match is_straight(curve) {
            true if is_whole && times > SHORTER => Some(Notice::LikeAnEdge),
            true if is_stub && times > 1.0 => Some(Notice::LikeAPen),
            _ => None,
        };
    }
    match is_straight(curve) {
        true if is_whole => Some(Notice::LikeAnEdge),
        true if is_stub || is_free && widths < PEN_WIDTHS && marks < MARKS => {
            Some(Notice::LikeAPen)
        }
        _ if is_free && (widths < SMALL_WIDTHS && times > SMALL || marks >= MARKS) => {
            Some(Notice::LikeAMark)
        }
        _ => None,
    }
}

/// Returns whether a curve is as straight as a rigid object.
fn is_straight(curve: &Curve) -> bool {
    let (Some(&from), Some(&to)) = (curve.points.first(), curve.points.last()) else {
        return false;
    };
    let along = vec2::unit_or(vec2::sub(to, from), [1.0, 0.0]);
    let off_px = |at: &Vec2| {
        let way = vec2::sub(*at, from);
        (way[0] * along[1] - way[1] * along[0]).abs()
    };
    let farthest_px = curve.points.iter().map(off_px).fold(0.0, f32::max);
    farthest_px <= (STRAIGHT * curve.width_px).max(1.0)
}

/// Returns whether a closed curve is an ellipse, by a least-squares fit of a x² + b xy + c y² = 1
/// about its middle.
fn is_round(curve: &Curve) -> bool {
    let count = curve.points.len() as f32;
    let sum = curve
        .points
        .iter()
        .fold([0.0; 2], |sum, &at| vec2::add(sum, at));
    let middle = vec2::scale(sum, 1.0 / count);
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
        return false;
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
    rms <= ROUND && oblong <= OBLONG
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

/// Returns whether the curve is a possible shadow, or a rope with its shadow.
fn is_pale(curve: &Curve, plane: &BitPlane) -> bool {
    let along = curve.points.windows(2).zip(&curve.widths_px);
    let sides = along.flat_map(|(pair, width_px)| {
        let along = vec2::unit_or(vec2::sub(pair[1], pair[0]), [1.0, 0.0]);
        let aside = vec2::scale([-along[1], along[0]], 0.25 * width_px);
        [vec2::add(pair[0], aside), vec2::sub(pair[0], aside)]
    });
    let pale = sides.filter(|at| plane.get(at[0] as i32, at[1] as i32));
    pale.count() as f32 > PALE * 2.0 * curve.points.len() as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::PixelFormat;

    const SIDE: usize = 64;

    #[test]
    fn what_lies_outside_of_the_image_does_not_say_whether_a_curve_is_shadow() {
        let [light, dim] = [200, 120].map(|level| vec![level; 3 * SIDE * SIDE]);
        let [light, dim] = [&light, &dim].map(|bytes| {
            let image = Image::new(bytes, SIDE, SIDE, 3 * SIDE, PixelFormat::Rgb8);
            image.expect("a whole image")
        });
        let mut background = Background::default();
        background.estimate(&light);
        let curve = |first: i32| Curve {
            points: (first..first + 64)
                .map(|x| [x as f32, 70.0 - x as f32])
                .collect(),
            ..Curve::default()
        };
        let is_dim = |image: &Image, first| {
            let surroundings = Surroundings {
                image,
                background: &background,
                mask: &BitPlane::default(),
                maybe_shadow: None,
            };
            surroundings.is_dim(&curve(first))
        };
        for first in [-30, 30] {
            assert!(is_dim(&dim, first) && !is_dim(&light, first), "{first}");
        }
    }
}
