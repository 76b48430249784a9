//! Dilation, erosion, opening and closing of a bit plane, 64 pixels at a time.
//!
//! The structuring element is an [`octagon`](super::octagon). Outside the image, dilation sees
//! nothing and erosion sees only rope. A rope that the image's border cuts is therefore not treated
//! as thin.

use super::neighbors::step;
use super::octagon::{Cross, Square, is_square};
#[cfg(test)]
use super::octagon::{ToBottomRight, ToTopLeft};
use super::strips::{BLOCK, Blocks, Strips};
use super::tiles::Tiles;

/// Memory of the steps.
#[derive(Debug)]
pub(crate) struct Morphology {
    /// Output of a dilation step.
    next: Strips,
    /// Unset pixels, and the output of an erosion step.
    bare: Strips,
    next_bare: Strips,
    wider: Blocks,
    tiles: Tiles,
}

impl Default for Morphology {
    fn default() -> Self {
        Self {
            next: Strips::default(),
            bare: Strips::of_ground(),
            next_bare: Strips::of_ground(),
            wider: Blocks::default(),
            tiles: Tiles::default(),
        }
    }
}

impl Morphology {
    /// Reserves memory for planes of this one's shape.
    pub(crate) fn reserve(&mut self, plane: &Strips) {
        for own in [&mut self.next, &mut self.bare, &mut self.next_bare] {
            own.resize(&plane.shape);
        }
        self.wider.resize(&plane.shape);
        self.tiles.reserve(plane);
    }

    /// Sets all pixels within `radius` of a set pixel.
    pub(crate) fn dilate(&mut self, plane: &mut Strips, radius: usize) {
        for _ in 0..radius.div_ceil(BLOCK) {
            self.wider.beside(&plane.shape, &plane.used);
            plane.used.copy_from(&self.wider);
        }
        self.dilate_within(plane, radius);
    }

    /// As [`dilate`](Self::dilate), but only in the blocks marked as used.
    pub(crate) fn dilate_within(&mut self, plane: &mut Strips, radius: usize) {
        steps(plane, &mut self.next, radius);
    }

    /// Clears all pixels within `radius` of an unset pixel. Pixels outside the image do not count
    /// as unset.
    pub(crate) fn erode(&mut self, plane: &mut Strips, radius: usize) {
        self.bare.complement(plane);
        steps(&mut self.bare, &mut self.next_bare, radius);
        plane.complement(&self.bare);
    }

    /// Keeps only what a disc `across` pixels wide covers while it stays inside the set pixels.
    pub(crate) fn open(&mut self, plane: &mut Strips, across: usize) {
        self.tiles.open(plane, across);
    }

    /// As [`open`](Self::open), step by step: its definition.
    #[cfg(test)]
    pub(crate) fn open_in_place(&mut self, plane: &mut Strips, across: usize) {
        let radius = across.saturating_sub(1) / 2;
        self.erode(plane, radius);
        if across > 0 && across.is_multiple_of(2) {
            self.bare.complement(plane);
            step(ToTopLeft, &mut self.bare, &mut self.next_bare);
            plane.complement(&self.bare);
            step(ToBottomRight, plane, &mut self.next);
        }
        // An opening sets no pixel that was unset before, so the used blocks suffice.
        self.dilate_within(plane, radius);
    }

    /// Sets pixels that a disc of this radius cannot reach without touching a set pixel. Only
    /// blocks marked as used are processed, so the result is valid from twice the radius inside
    /// their border.
    pub(crate) fn close_within(&mut self, plane: &mut Strips, radius: usize) {
        self.dilate_within(plane, radius);
        self.erode(plane, radius);
    }
}

/// Grows `plane` by an octagon.
fn steps(plane: &mut Strips, next: &mut Strips, radius: usize) {
    for i in 0..radius {
        if is_square(i) {
            step(Square, plane, next);
        } else {
            step(Cross, plane, next);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bitmap::bits::BitPlane;
    use proptest::prelude::*;

    /// Definition of dilation and erosion, one pixel at a time.
    fn scalar(plane: &BitPlane, radius: usize, dilate: bool) -> BitPlane {
        let mut plane = plane.clone();
        for step in 0..radius {
            let old = plane.clone();
            let (width, height) = (old.width() as i32, old.height() as i32);
            for y in 0..height {
                for x in 0..width {
                    let reaches = |dx: i32, dy: i32| is_square(step) || dx == 0 || dy == 0;
                    let mut around = (-1..=1)
                        .flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)))
                        .filter(|&(dx, dy)| reaches(dx, dy))
                        .filter(|&(dx, dy)| {
                            (0..width).contains(&(x + dx)) && (0..height).contains(&(y + dy))
                        });
                    let value = if dilate {
                        around.any(|(dx, dy)| old.get(x + dx, y + dy))
                    } else {
                        around.all(|(dx, dy)| old.get(x + dx, y + dy))
                    };
                    plane.fill(y as usize, x as usize, x as usize + 1, value);
                }
            }
        }
        plane
    }

    /// Definition of an opening.
    fn open_scalar(plane: &BitPlane, across: usize) -> BitPlane {
        let radius = across.saturating_sub(1) / 2;
        let mut opened = scalar(plane, radius, false);
        if across > 0 && across.is_multiple_of(2) {
            let old = opened.clone();
            let (width, height) = (old.width() as i32, old.height() as i32);
            // A 2×2 square fits here if none of its pixels is unset. Pixels outside the image are
            // not unset.
            let fits = |x: i32, y: i32| {
                (0..4).all(|k| {
                    let (x, y) = (x + k % 2, y + k / 2);
                    x >= width || y >= height || old.get(x, y)
                })
            };
            for y in 0..height {
                for x in 0..width {
                    let covered = (0..4).any(|k| {
                        let (x, y) = (x - k % 2, y - k / 2);
                        x >= 0 && y >= 0 && fits(x, y)
                    });
                    opened.fill(y as usize, x as usize, x as usize + 1, covered);
                }
            }
        }
        scalar(&opened, radius, true)
    }

    proptest! {
        #[test]
        fn words_at_a_time_equal_the_scalar_twin(
            width in 1usize..150, height in 1usize..16,
            words in proptest::collection::vec(any::<u64>(), 48),
            radius in 0usize..5, dense: bool,
        ) {
            let mut plane = BitPlane::default();
            plane.resize(width, height);
            for y in 0..height {
                for x in 0..width {
                    let bits = |k: usize| words[(3 * y + x / 64 + k) % 48] >> (x % 64) & 1 == 1;
                    // 7 of 8 pixels are set, or 1 of 8.
                    let set = if dense {
                        bits(0) || bits(7) || bits(13)
                    } else {
                        bits(0) && bits(7) && bits(13)
                    };
                    plane.fill(y, x, x + 1, set);
                }
            }
            let mut morphology = Morphology::default();
            for dilate in [true, false] {
                let mut fast = Strips::default();
                fast.take(&plane);
                if dilate {
                    morphology.dilate(&mut fast, radius);
                } else {
                    morphology.erode(&mut fast, radius);
                }
                prop_assert_eq!(fast.plane(), scalar(&plane, radius, dilate));
            }
            for across in [2 * radius, 2 * radius + 1] {
                let mut fast = Strips::default();
                fast.take(&plane);
                morphology.open(&mut fast, across);
                prop_assert_eq!(fast.plane(), open_scalar(&plane, across));
            }
        }
    }

    #[test]
    fn a_disc_is_as_wide_along_the_diagonals_as_along_the_axes() {
        for radius in 2..16 {
            let mut plane = BitPlane::default();
            plane.resize(64, 64);
            plane.fill(32, 32, 33, true);
            let mut strips = Strips::default();
            strips.take(&plane);
            Morphology::default().dilate(&mut strips, radius);
            plane = strips.plane();
            let along = |dx: i32, dy: i32| {
                (0..32)
                    .take_while(|k| plane.get(32 + k * dx, 32 + k * dy))
                    .count()
                    - 1
            };
            assert_eq!(along(1, 0), radius);
            // Equal to within a pixel, which is √2 long along the diagonal.
            let pixel = std::f32::consts::SQRT_2;
            let diagonal = along(1, 1) as f32 * pixel;
            assert!(
                (diagonal - radius as f32).abs() < pixel,
                "{radius}: {diagonal}"
            );
        }
    }
}
