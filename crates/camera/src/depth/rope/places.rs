//! Places in a depth image, one per vector lane.

use super::floats::{Floats, LANES};
use crate::depth::image::{DepthImage, NOWHERE};
use lariat_portable::Simd;

/// Locates and reads the pixels of a depth image.
#[derive(Clone, Copy)]
pub(super) struct Places<'a, S: Simd> {
    simd: S,
    image: &'a DepthImage<'a>,
    /// The image's center, and half of its size.
    middle: [Floats<S>; 2],
    half: [Floats<S>; 2],
}

impl<'a, S: Simd> Places<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, image: &'a DepthImage<'a>) -> Self {
        let [width, height] = image.sides();
        let splat = [
            0.5 * (width - 1.0),
            0.5 * (height - 1.0),
            0.5 * width,
            0.5 * height,
        ];
        let [x, y, half_width, half_height] = splat.map(|number| Floats::splat(simd, number));
        Self {
            simd,
            image,
            middle: [x, y],
            half: [half_width, half_height],
        }
    }

    /// Returns the offsets of pixels with these integer columns and rows; `nowhere` outside of the
    /// image.
    #[inline(always)]
    pub(super) fn starts(self, column: Floats<S>, row: Floats<S>) -> Floats<S> {
        let starts = self.image.starts(&column.lanes(), &row.lanes());
        let starts = Floats::of(self.simd, &starts.map(f32::from_bits));
        let nowhere = Self::nowhere(self.simd);
        let starts = starts.where_less((column - self.middle[0]).abs(), self.half[0], nowhere);
        starts.where_less((row - self.middle[1]).abs(), self.half[1], nowhere)
    }

    /// The offset of a pixel outside of the image, in every lane.
    #[inline(always)]
    pub(super) fn nowhere(simd: S) -> Floats<S> {
        Floats::splat(simd, f32::from_bits(NOWHERE))
    }

    /// Reads the pixels at these offsets, in mm; 0 if unknown.
    #[inline(always)]
    pub(super) fn read(self, starts: Floats<S>) -> Floats<S> {
        let mut read = [[0.0; LANES]];
        (self.image).read(&[starts.lanes().map(f32::to_bits)], &mut read);
        Floats::of(self.simd, &read[0])
    }
}
