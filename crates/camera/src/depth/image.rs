//! Depth images in the formats of cameras.

use thiserror::Error;

/// Format of a pixel in a depth image.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum DepthKind {
    /// A little-endian 16-bit integer in units of `unit_mm`; 0 if unknown (`Z16`, `16UC1`).
    Whole {
        /// Millimeters per unit: 1 for ROS's `16UC1`.
        unit_mm: f64,
    },
    /// Meters as a little-endian 32-bit float; NaN or not positive if unknown (ROS's `32FC1`).
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

/// Why bytes are not a depth image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{bytes} bytes make no depth image of {width}×{height} pixels with rows of {stride} bytes")]
pub struct DepthImageError {
    bytes: usize,
    width: usize,
    height: usize,
    stride: usize,
}

/// If an integer below 4 million in absolute value is added to this number, the lowest bits of the
/// resulting float are that integer.
const WHOLE: f32 = 12_582_912.0;
/// Offset of a pixel outside of the image: past the end of all bytes.
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
    /// Borrows a depth image. `stride`: bytes from one row's start to the next.
    ///
    /// # Errors
    /// There are too few bytes.
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

    /// Returns the depth at a pixel in mm, along the camera's axis. `None` if it is unknown, or
    /// outside of the image.
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

    /// Returns the offsets of pixels with these columns and rows, which are non-negative integers.
    /// An offset outside of the image is arbitrary.
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

    /// Reads the pixels at these offsets, in mm; 0 if unknown or past the end.
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
        // A separate loop, so that it is vectorized.
        for (to, pixels) in to.iter_mut().zip(&pixels) {
            for (to, &pixel) in to.iter_mut().zip(pixels) {
                *to = depth(pixel);
            }
        }
    }

    /// Width and height, in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Width and height within the first 4 billion bytes; no current image is larger.
    #[inline]
    pub(super) fn sides(&self) -> [f32; 2] {
        let most = u32::MAX as usize / self.stride;
        [self.width, self.height.min(most)].map(|side| side as f32)
    }

    /// Standard deviation from rounding to integers, mm.
    pub(super) fn rounding_mm(&self) -> f64 {
        match self.kind {
            DepthKind::Whole { unit_mm } => unit_mm / 12f64.sqrt(),
            DepthKind::Metres => 0.0,
        }
    }
}
