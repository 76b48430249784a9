//! The part of the mask that no line runs through, although it is connected to one. It may be a tip
//! or a strand that was left out, or strands that were treated as one. It is also evidence that the
//! rest was misread.

use crate::bitmap::bits::BitPlane;
use crate::bitmap::spread::spread;
use crate::centerline::line::Line;
use crate::scene::Curve;
use crate::vec2::{self, Vec2};

/// Distance from a line's middle, in widths plus pixels, within which the mask is the line's own.
const OWN: (f32, f32) = (0.8, 0.5);
/// Distance, in widths, between the places on a line that are read. Halfway between two of them,
/// their discs still cover 0.62 widths to either side.
const STEP: f32 = 1.0;
/// Distance from a curve, in pixels beyond its own part of the mask, within which a remainder is
/// connected to it.
const BESIDE_PX: f32 = 1.5;

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Remainder {
    /// The remaining pixels.
    left: BitPlane,
    /// Their area, in squares of the ropes' width.
    squares: f32,
    /// Those of them that are found to be connected to a line.
    grown: BitPlane,
}

impl Remainder {
    /// Makes room for masks of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        for plane in [&mut self.left, &mut self.grown] {
            plane.resize(width, height);
        }
    }

    /// Resets the remainder to nothing.
    pub(crate) fn clear(&mut self) {
        self.squares = 0.0;
    }

    /// Finds the part of `mask` that `lines`, of ropes up to this width, leave uncovered.
    pub(crate) fn find(&mut self, mask: &BitPlane, lines: &[Line], width_px: f32) {
        self.clear();
        let width_px = width_px.max(1.0);
        let own_px = OWN.0 * width_px + OWN.1;
        self.left.copy_from(mask);
        self.grown.resize(mask.width(), mask.height());
        for at in lines.iter().flat_map(|line| apart(line, STEP * width_px)) {
            for_each_run(at, own_px, mask, |y, from, to| {
                self.left.fill(y, from, to, false);
            });
        }
        let has_some = |y: &usize| self.left.row(*y).iter().any(|&word| word != 0);
        let rows = (0..mask.height()).find(has_some);
        let Some(first) = rows else {
            return;
        };
        let last = (first..mask.height()).rfind(has_some).unwrap_or(first);
        // Something that is not connected is another object.
        for y in first..=last {
            self.seed(mask, y);
        }
        let planes = (&mut self.grown, &mut self.left);
        spread(planes, first..last + 1, f32::INFINITY, |_, _| ());
        for y in first..=last {
            self.left.row_mut(y).copy_from_slice(self.grown.row(y));
        }
        let area = (first..=last).map(|y| ones(self.left.row(y)));
        self.squares = area.sum::<u32>() as f32 / (width_px * width_px);
    }

    /// Fills row `y` of the grown pixels with the remaining ones next to a line's own part.
    fn seed(&mut self, mask: &BitPlane, y: usize) {
        let words = mask.words_per_row();
        let left = &self.left;
        let own = |y: usize, i: usize| mask.row(y)[i] & !left.row(y)[i];
        for (i, grown) in self.grown.row_mut(y).iter_mut().enumerate() {
            let here = own(y, i);
            let mut near = here << 1 | here >> 1;
            if i > 0 {
                near |= own(y, i - 1) >> 63;
            }
            if i + 1 < words {
                near |= own(y, i + 1) << 63;
            }
            if y > 0 {
                near |= own(y - 1, i);
            }
            if y + 1 < mask.height() {
                near |= own(y + 1, i);
            }
            *grown = near & left.row(y)[i];
        }
    }

    /// The remaining area, in squares of the ropes' width.
    pub(crate) fn squares(&self) -> f32 {
        self.squares
    }

    /// The remainder, if it is next to a curve, in squares of the ropes' width; otherwise 0.
    pub(crate) fn beside(&self, curve: &Curve) -> f32 {
        if self.squares > 0.0 && self.is_beside(curve) {
            self.squares
        } else {
            0.0
        }
    }

    /// Returns whether the remainder is connected to the curve.
    fn is_beside(&self, curve: &Curve) -> bool {
        let reach_px = OWN.0 * curve.width_px + OWN.1 + BESIDE_PX;
        let step_px = (STEP * curve.width_px).max(1.0);
        let mut places = curve.points.windows(2).flat_map(|piece| {
            let way = vec2::sub(piece[1], piece[0]);
            let count = libm::ceilf(vec2::norm(way) / step_px).max(1.0) as usize;
            (0..=count).map(move |k| vec2::along(piece[0], way, k as f32 / count as f32))
        });
        places.any(|at| {
            let mut any = false;
            for_each_run(at, reach_px, &self.left, |y, from, to| {
                any |= (from..to).step_by(64).any(|x| {
                    let bits = self.left.bits_from(x as i32, y as i32);
                    bits << (64 - (to - x).min(64)) != 0
                });
            });
            any
        })
    }
}

fn ones(row: &[u64]) -> u32 {
    row.iter().map(|word| word.count_ones()).sum()
}

/// Places along a line, each at least this far from the last, and the line's end.
fn apart(line: &Line, step_px: f32) -> impl Iterator<Item = Vec2> {
    let mut before: Option<Vec2> = None;
    let places = line.samples.iter().map(|sample| sample.at);
    let apart = places.filter(move |&at| {
        let is_near = before.is_some_and(|before| vec2::distance(before, at) < step_px);
        if !is_near {
            before = Some(at);
        }
        !is_near
    });
    apart.chain(line.samples.last().map(|sample| sample.at))
}

/// Calls `run` with each run of a disc's pixels within the picture: row, first pixel, and the pixel
/// after the last.
fn for_each_run(
    [x, y]: Vec2,
    radius_px: f32,
    of: &BitPlane,
    mut run: impl FnMut(usize, usize, usize),
) {
    // The first pixel after a place, at most `most`. Casts truncate, and yield 0 for a place before
    // the picture.
    let behind = |at: f32, most: usize| ((at + 1.0) as usize).min(most);
    for row in behind(y - radius_px, of.height())..behind(y + radius_px, of.height()) {
        let off_px = row as f32 - y;
        let half_px = (radius_px * radius_px - off_px * off_px).max(0.0).sqrt();
        let [first, end] = [x - half_px, x + half_px].map(|at| behind(at, of.width()));
        if first < end {
            run(row, first, end);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::centerline::line::Sample;

    /// Half a rope's width, and the height of the horizontal one.
    const HALF_PX: f32 = 4.0;
    const Y: f32 = 60.0;

    /// The line from (10, 60) to (150, 60), and its curve.
    fn told() -> (Line, Curve) {
        let mut line = Line::default();
        line.samples.extend((10..=150).map(|x| Sample {
            at: [x as f32, Y],
            weight: 1.0,
            width_px: 2.0 * HALF_PX,
            side: 0.0,
        }));
        let mut curve = Curve::default();
        curve.points.extend([[10.0, Y], [80.0, Y], [150.0, Y]]);
        curve.width_px = 2.0 * HALF_PX;
        (line, curve)
    }

    /// A mask of the pixels within `HALF_PX` of a shape.
    fn mask(distance_px: impl Fn(f32, f32) -> f32) -> BitPlane {
        let mut mask = BitPlane::default();
        mask.resize(160, 120);
        for y in 0..120 {
            for x in 0..160 {
                let is_set = distance_px(x as f32, y as f32) <= HALF_PX;
                mask.fill(y, x, x + 1, is_set);
            }
        }
        mask
    }

    fn rope(x: f32, y: f32) -> f32 {
        (x - x.clamp(10.0, 150.0)).hypot(y - Y)
    }

    /// The remainder next to the horizontal line in this mask.
    fn left(mask: &BitPlane) -> f32 {
        let (line, curve) = told();
        let mut remainder = Remainder::default();
        remainder.find(mask, &[line], curve.width_px);
        remainder.beside(&curve)
    }

    #[test]
    fn a_rope_that_is_told_leaves_nothing() {
        assert_eq!(left(&mask(rope)), 0.0);
    }

    #[test]
    fn a_strand_that_was_left_out_is_missed_by_its_squares() {
        // The strand reaches from row 20 to the rope's own part: 33 rows.
        let strand = |x: f32, y: f32| (x - 70.0).hypot(y - y.clamp(24.0, Y));
        let squares = left(&mask(|x, y| rope(x, y).min(strand(x, y))));
        assert!((3.8..4.6).contains(&squares), "{squares}");
    }

    #[test]
    fn what_lies_apart_is_another_thing() {
        let thing = |x: f32, y: f32| (x - 70.0).hypot(y - y.clamp(14.0, 40.0));
        assert_eq!(left(&mask(|x, y| rope(x, y).min(thing(x, y)))), 0.0);
    }

    #[test]
    fn another_rope_has_no_part_in_what_is_left_beside_one() {
        let strand = |x: f32, y: f32| (x - 70.0).hypot(y - y.clamp(40.0, Y));
        let other = |x: f32, y: f32| (x - x.clamp(10.0, 150.0)).hypot(y - 100.0);
        let mask = mask(|x, y| rope(x, y).min(strand(x, y)).min(other(x, y)));
        let (line, curve) = told();
        let (mut second, mut far) = told();
        second.samples.iter_mut().for_each(|s| s.at[1] = 100.0);
        far.points.iter_mut().for_each(|point| point[1] = 100.0);
        let mut remainder = Remainder::default();
        remainder.find(&mask, &[line, second], 2.0 * HALF_PX);
        assert!(remainder.beside(&curve) > 0.5);
        assert_eq!(remainder.beside(&far), 0.0);
    }
}
