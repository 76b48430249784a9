//! Depth images as cameras give them.

use thiserror::Error;

/// What a pixel of a depth image is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum DepthKind {
    /// A whole number of 16 bits, little-endian, of so many millimetres each; 0 where it is not known (`Z16`, `16UC1`).
    Whole {
        /// Millimetres a unit: 1 for ROS's `16UC1`.
        unit_mm: f64,
    },
    /// Metres as a float of 32 bits, little-endian; not a number, or not positive, where it is not known (ROS's `32FC1`).
    Metres,
}

impl DepthKind {
    const fn bytes(self) -> usize {
        match self {
            Self::Whole { .. } => 2,
            Self::Metres => 4,
        }
    }
}

/// Why bytes make no depth image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{bytes} bytes make no depth image of {width}×{height} pixels with rows of {stride} bytes")]
pub struct DepthImageError {
    bytes: usize,
    width: usize,
    height: usize,
    stride: usize,
}

/// Added to a whole number of less than 4 million in size it leaves a float whose lowest bits are that number.
const WHOLE: f32 = 12_582_912.0;
/// Where nothing begins: past the end of all bytes.
pub(super) const NOWHERE: u32 = u32::MAX;

/// A depth image, borrowed.
#[derive(Debug, Clone, Copy)]
pub struct DepthImage<'a> {
    bytes: &'a [u8],
    width: usize,
    height: usize,
    stride: usize,
    kind: DepthKind,
}

impl<'a> DepthImage<'a> {
    /// `stride`: bytes from one row's start to the next.
    ///
    /// # Errors
    /// There are fewer bytes than that asks for.
    pub fn new(
        bytes: &'a [u8],
        [width, height]: [usize; 2],
        stride: usize,
        kind: DepthKind,
    ) -> Result<Self, DepthImageError> {
        let error = DepthImageError {
            bytes: bytes.len(),
            width,
            height,
            stride,
        };
        let row = width.checked_mul(kind.bytes()).ok_or(error)?;
        let before = height
            .checked_sub(1)
            .and_then(|rows| rows.checked_mul(stride));
        let wanted = before.and_then(|before| before.checked_add(row));
        if row == 0 || stride < row || wanted.is_none_or(|wanted| wanted > bytes.len()) {
            return Err(error);
        }
        Ok(Self {
            bytes,
            width,
            height,
            stride,
            kind,
        })
    }

    /// How far what is seen at this pixel is, mm along the axis; none where that is not known, or outside of the image.
    #[inline]
    pub fn at(&self, column: isize, row: isize) -> Option<f64> {
        if column < 0 || row < 0 || column >= self.width as isize || row >= self.height as isize {
            return None;
        }
        let size = self.kind.bytes();
        let at = row as usize * self.stride + column as usize * size;
        let bytes = &self.bytes[at..at + size];
        match self.kind {
            DepthKind::Whole { unit_mm } => match u16::from_le_bytes([bytes[0], bytes[1]]) {
                0 => None,
                units => Some(f64::from(units) * unit_mm),
            },
            DepthKind::Metres => {
                let metres = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                (metres > 0.0 && metres.is_finite()).then(|| f64::from(metres) * 1000.0)
            }
        }
    }

    /// Where the pixels of some columns and rows begin, all of which are whole and at least 0. Outside of the image it is anywhere.
    #[inline(always)]
    pub(super) fn starts<const L: usize>(&self, columns: &[f32; L], rows: &[f32; L]) -> [u32; L] {
        let [stride, size] = [self.stride, self.kind.bytes()].map(|bytes| bytes as u32);
        let mut starts = [0; L];
        for (start, (&column, &row)) in starts.iter_mut().zip(columns.iter().zip(rows)) {
            let [column, row] = [column, row].map(|place| (place + WHOLE).to_bits());
            let [column, row] = [column, row].map(|bits| bits.wrapping_sub(WHOLE.to_bits()));
            *start = (row.wrapping_mul(stride)).wrapping_add(column.wrapping_mul(size));
        }
        starts
    }

    /// Reads pixels that begin at these places of its bytes, mm; 0 where that is not known, or past their end.
    #[inline(always)]
    pub(super) fn read<const L: usize, const N: usize>(
        &self,
        starts: &[[u32; L]; N],
        to: &mut [[f32; L]; N],
    ) {
        match self.kind {
            DepthKind::Whole { unit_mm } => {
                let unit_mm = unit_mm as f32;
                self.read_each(starts, to, |pixel| {
                    f32::from(u16::from_le_bytes(pixel)) * unit_mm
                });
            }
            DepthKind::Metres => self.read_each(starts, to, |pixel| {
                let metres = f32::from_le_bytes(pixel);
                match metres > 0.0 && metres.is_finite() {
                    true => 1000.0 * metres,
                    false => 0.0,
                }
            }),
        }
    }

    #[inline(always)]
    fn read_each<const L: usize, const N: usize, const BYTES: usize>(
        &self,
        starts: &[[u32; L]; N],
        to: &mut [[f32; L]; N],
        depth: impl Fn([u8; BYTES]) -> f32,
    ) {
        let mut pixels = [[[0; BYTES]; L]; N];
        let each = pixels.as_flattened_mut().iter_mut();
        for (pixel, &start) in each.zip(starts.as_flattened()) {
            let start = start as usize;
            if let Some(bytes) = self.bytes.get(start..start + BYTES) {
                pixel.copy_from_slice(bytes);
            }
        }
        // By itself, as this becomes vectors.
        for (to, pixels) in to.iter_mut().zip(&pixels) {
            for (to, &pixel) in to.iter_mut().zip(pixels) {
                *to = depth(pixel);
            }
        }
    }

    /// Width and height.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Width and height, as far as its first 4 billion bytes go: more are no image of today.
    #[inline]
    pub(super) fn sides(&self) -> [f32; 2] {
        let most = u32::MAX as usize / self.stride;
        [self.width, self.height.min(most)].map(|side| side as f32)
    }

    /// The standard deviation that whole numbers alone make, mm.
    pub(super) fn rounding_mm(&self) -> f64 {
        match self.kind {
            DepthKind::Whole { unit_mm } => unit_mm / 12f64.sqrt(),
            DepthKind::Metres => 0.0,
        }
    }
}
