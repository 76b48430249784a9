//! Finds objects that are far too wide for a rope, such as an arm or a board, from a grid of
//! places. They are removed before the mask is thinned. Thinning them would take as many passes as
//! they are wide and give no lines.

use crate::bitmap::bits::BitPlane;
use crate::bitmap::edge_distance::half_width;
use crate::bitmap::morphology::Morphology;
use crate::bitmap::spread::{spread, spread_along};
use crate::bitmap::strips::Strips;

/// Step of the grid, in half-widths of the widest rope. At the place nearest to the middle of
/// something wider, that object's half-width is at least `NEAREST`: the middle of a square of
/// places is at most 0.47 from its corners.
const STEP: f32 = 2.0 / 3.0;
const NEAREST: f32 = 0.5;
/// Distance around a wide place within which everything is removed, in half-widths. It includes the
/// corners of a square.
const AROUND: f32 = 0.5;
/// Maximum number of places that are reported.
const MOST: usize = 8;

/// A pixel and its distance to the edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) at: [u16; 2],
    pub(crate) half_px: f32,
}

/// Memory and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Wide {
    grid: Vec<Place>,
    /// The widest places.
    pub(crate) places: Vec<Place>,
    opened: Strips,
    /// Everything connected with what is too wide.
    pieces: BitPlane,
    limits: BitPlane,
    /// The mask without what is too wide.
    pub(crate) rest: Strips,
    morphology: Morphology,
}

impl Wide {
    /// Reserves the buffers for masks of this one's shape.
    pub(crate) fn reserve(&mut self, mask: &Strips, widest_half: u32) {
        let step = step(widest_half);
        let (columns, rows) = (mask.shape.width() / step, mask.shape.height() / step);
        self.grid.reserve((columns + 1) * (rows + 1));
        self.places.reserve(MOST);
        self.opened.resize(&mask.shape);
        self.rest.resize(&mask.shape);
        let size = (mask.shape.width(), mask.shape.height());
        self.pieces.resize(size.0, size.1);
        self.limits.resize(size.0, size.1);
        self.morphology.reserve(mask);
    }

    /// Searches for anything wider than ropes of half-width `widest_half`, and returns whether
    /// there is any. If so, `rest` is what is left of `mask`. `rows` is the same mask row by row.
    pub(crate) fn find(&mut self, mask: &Strips, rows: &BitPlane, widest_half: u32) -> bool {
        self.places.clear();
        self.look(mask, rows, widest_half);
        for _ in 0..MOST {
            let places = self.grid.iter().enumerate();
            let widest = places.max_by(|a, b| a.1.half_px.total_cmp(&b.1.half_px));
            let Some((i, _)) = widest else { break };
            let widest = climb(rows, self.grid.swap_remove(i), widest_half);
            self.grid.retain(|place| !widest.covers(place));
            if widest.half_px >= widest_half as f32 {
                self.places.push(widest);
            }
        }
        if self.places.is_empty() {
            return false;
        }
        self.opened.copy_from(mask);
        self.morphology
            .open(&mut self.opened, 2 * widest_half as usize + 1);
        let around = (AROUND * widest_half as f32) as usize;
        self.morphology.dilate(&mut self.opened, around);
        self.rest.copy_from(mask);
        self.rest
            .zip_within(&self.opened, mask, |m, wide, _| m & !wide);
        self.rest.tighten();
        true
    }

    /// Also removes everything that is connected with something too wide: fingers and keys are not
    /// ropes.
    pub(crate) fn leave_pieces_out(&mut self, rows: &BitPlane) {
        let (pieces, limits) = (&mut self.pieces, &mut self.limits);
        pieces.resize(rows.width(), rows.height());
        self.opened.put(pieces);
        limits.copy_from(rows);
        for y in 0..rows.height() {
            let words = pieces.row_mut(y).iter_mut().zip(rows.row(y));
            words.for_each(|(word, own)| *word &= own);
            spread_along(pieces.row_mut(y), rows.row(y));
        }
        spread(
            (&mut *pieces, limits),
            0..rows.height(),
            f32::INFINITY,
            |_, _| {},
        );
        for y in 0..rows.height() {
            let words = limits.row_mut(y).iter_mut().zip(pieces.row(y));
            words.for_each(|(word, piece)| *word &= !piece);
        }
        self.rest.take(limits);
    }

    /// Measures the places of a grid that may be in something too wide.
    fn look(&mut self, mask: &Strips, rows: &BitPlane, widest_half: u32) {
        self.grid.clear();
        let (step, least) = (step(widest_half), (NEAREST * widest_half as f32) as usize);
        let (width, height) = (rows.width(), rows.height());
        for y in (step / 2..height).step_by(step) {
            for x in (step / 2..width).step_by(step) {
                if !mask.get(x, y) {
                    continue;
                }
                let (left, right) = mask.reach_along_row([x, y], least);
                let (up, down) = (mask.reach_up([x, y], least), mask.reach_down([x, y], least));
                let reaches = [
                    (left, x),
                    (right, width - 1 - x),
                    (up, y),
                    (down, height - 1 - y),
                ];
                // An object that leaves the picture may continue outside.
                if reaches
                    .iter()
                    .all(|&(reach, border)| reach >= least.min(border))
                {
                    let half_px = half_width(rows, x as i32, y as i32);
                    let at = [x as u16, y as u16];
                    self.grid.push(Place { at, half_px });
                }
            }
        }
    }
}

impl Place {
    fn covers(&self, other: &Place) -> bool {
        let off = |k: usize| f32::from(self.at[k]) - f32::from(other.at[k]);
        off(0) * off(0) + off(1) * off(1) <= self.half_px * self.half_px
    }
}

fn step(widest_half: u32) -> usize {
    (STEP * widest_half as f32) as usize
}

/// Climbs from a place, along increasing width, to the widest place that is reached.
fn climb(rows: &BitPlane, mut place: Place, widest_half: u32) -> Place {
    let mut step = (widest_half / 4).next_power_of_two() as i32;
    while step > 0 {
        let [x, y] = place.at.map(i32::from);
        let beside = [[-1, 0], [1, 0], [0, -1], [0, 1]].map(|[i, j]| [x + step * i, y + step * j]);
        let inside = beside.into_iter().filter(|&[x, y]| rows.get(x, y));
        let beside = inside.map(|[x, y]| Place {
            at: [x as u16, y as u16],
            half_px: half_width(rows, x, y),
        });
        match beside.max_by(|a, b| a.half_px.total_cmp(&b.half_px)) {
            Some(wider) if wider.half_px > place.half_px => place = wider,
            _ => step /= 2,
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDEST_HALF: u32 = 30;

    fn found(set: impl Fn(f32, f32) -> bool) -> (Wide, BitPlane, bool) {
        let mut rows = BitPlane::default();
        rows.resize(320, 240);
        for (x, y) in (0..240).flat_map(|y| (0..320).map(move |x| (x, y))) {
            if set(x as f32, y as f32) {
                rows.fill(y, x, x + 1, true);
            }
        }
        let mut mask = Strips::default();
        mask.take(&rows);
        let mut wide = Wide::default();
        wide.reserve(&mask, WIDEST_HALF);
        let is_there = wide.find(&mask, &rows, WIDEST_HALF);
        (wide, rows, is_there)
    }

    fn is_rope(x: f32, y: f32) -> bool {
        (y - 30.0).abs() < 8.0 && (20.0..300.0).contains(&x)
    }

    #[test]
    fn what_is_too_wide_is_found_wherever_it_lies_and_leaves_the_ropes() {
        for [cx, cy] in [
            [160.0, 150.0],
            [71.0, 130.0],
            [199.0, 163.0],
            [260.0, 170.0],
        ] {
            let disc = |x: f32, y: f32| (x - cx).hypot(y - cy) < 34.0;
            let (mut wide, rows, is_there) = found(|x, y| is_rope(x, y) || disc(x, y));
            assert!(is_there, "{cx} {cy}");
            let [place] = wide.places[..] else {
                panic!("{:?}", wide.places);
            };
            assert!((place.half_px - 33.5).abs() < 1.5, "{place:?}");
            let ropes = rows.count() - wide.rest.count();
            assert!((3500..3650).contains(&ropes), "{ropes}");
            wide.leave_pieces_out(&rows);
            assert!(
                (0..240)
                    .all(|y| (0..320)
                        .all(|x| { wide.rest.get(x, y) == is_rope(x as f32, y as f32) }))
            );
        }
    }

    #[test]
    fn what_hangs_on_it_is_told_from_the_ropes_only_by_leaving_the_piece_out() {
        let hand = |x: f32, y: f32| (x - 90.0).hypot(y - 150.0) < 40.0;
        let finger = |x: f32, y: f32| (y - 150.0).abs() < 9.0 && (90.0..250.0).contains(&x);
        let (mut wide, rows, is_there) = found(|x, y| is_rope(x, y) || hand(x, y) || finger(x, y));
        assert!(is_there && wide.rest.get(220, 150));
        wide.leave_pieces_out(&rows);
        assert!(!wide.rest.get(220, 150) && wide.rest.get(220, 30));
    }

    #[test]
    fn ropes_that_cross_are_not_too_wide() {
        let cross = |x: f32, y: f32| (y - 120.0).abs() < 20.0 || (x - 160.0).abs() < 20.0;
        assert!(!found(cross).2);
    }
}
