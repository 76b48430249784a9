//! A plane of one byte per pixel: its difference from the table.

use std::ops::Range;

/// One byte per pixel, row after row.
#[derive(Debug, Default)]
pub(crate) struct GrayPlane {
    bytes: Vec<u8>,
    width: usize,
    height: usize,
    /// True if a block may hold anything but zeros. Blocks are stored strip by strip, each strip
    /// eight rows high.
    written: Vec<bool>,
}

/// Rows of a block, and pixels in each of its rows.
const BLOCK: [usize; 2] = [8, 64];

impl GrayPlane {
    /// Sets the size and reuses the memory. The bytes keep whatever values they had.
    pub(crate) fn resize(&mut self, width: usize, height: usize) {
        if (self.width, self.height) == (width, height) {
            return;
        }
        (self.width, self.height) = (width, height);
        self.bytes.resize(width * height, 0);
        let blocks = height.div_ceil(BLOCK[0]) * width.div_ceil(BLOCK[1]);
        self.written.clear();
        self.written.resize(blocks, true);
    }

    /// The `written` flags of the strip of eight rows that contains row `top`, one per 64 pixels.
    fn written_mut(&mut self, top: usize) -> &mut [bool] {
        let blocks = self.width.div_ceil(BLOCK[1]);
        &mut self.written[top / BLOCK[0] * blocks..][..blocks]
    }

    /// Clears all blocks of a strip that are not `kept`, and returns the strip's rows so that the
    /// kept blocks can be written. The strip has up to eight rows from `top`, a multiple of eight.
    pub(crate) fn keep_blocks(&mut self, top: usize, kept: &[bool]) -> &mut [u8] {
        let (width, end) = (self.width, (top + BLOCK[0]).min(self.height));
        let written = top / BLOCK[0] * kept.len();
        let written = &mut self.written[written..][..kept.len()];
        let rows = &mut self.bytes[width * top..width * end];
        for (k, (written, &kept)) in written.iter_mut().zip(kept).enumerate() {
            if *written && !kept {
                let from = BLOCK[1] * k;
                let to = (from + BLOCK[1]).min(width);
                rows.chunks_exact_mut(width)
                    .for_each(|row| row[from..to].fill(0));
            }
            *written = kept;
        }
        rows
    }

    /// Copies the size and bytes of another plane.
    pub(crate) fn copy_from(&mut self, other: &GrayPlane) {
        self.resize(other.width, other.height);
        self.bytes.copy_from_slice(&other.bytes);
        self.written.copy_from_slice(&other.written);
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    pub(crate) fn height(&self) -> usize {
        self.height
    }

    /// All rows, one after the other.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    pub(crate) fn row(&self, y: usize) -> &[u8] {
        &self.bytes[y * self.width..][..self.width]
    }

    pub(crate) fn row_mut(&mut self, y: usize) -> &mut [u8] {
        self.written_mut(y).fill(true);
        &mut self.bytes[y * self.width..][..self.width]
    }

    /// Some rows, one after the other.
    pub(crate) fn rows_mut(&mut self, rows: Range<usize>) -> &mut [u8] {
        for top in rows.clone().step_by(BLOCK[0]) {
            self.written_mut(top).fill(true);
        }
        self.written_mut(rows.end.saturating_sub(1)).fill(true);
        &mut self.bytes[self.width * rows.start..self.width * rows.end]
    }

    /// Returns whether the position is between the outermost pixels' centers.
    #[inline]
    pub(crate) fn holds(&self, [x, y]: [f32; 2]) -> bool {
        let (right, bottom) = (self.width as f32 - 1.0, self.height as f32 - 1.0);
        x >= 0.0 && y >= 0.0 && x <= right && y <= bottom
    }

    /// Share of the line from `from`, which is inside the plane, to `to` that is within the plane's
    /// border.
    pub(crate) fn part_within(&self, from: [f32; 2], to: [f32; 2]) -> f32 {
        let limits = [(self.width - 1) as f32, (self.height - 1) as f32];
        let share = |c: usize| {
            let (from, to) = (from[c], to[c]);
            let border = to.clamp(0.0, limits[c]);
            if to == border {
                1.0
            } else {
                (border - from) / (to - from)
            }
        };
        share(0).min(share(1)).clamp(0.0, 1.0)
    }

    /// Value at a position between pixels, bilinear. Past the edge, the edge's value continues.
    #[inline]
    pub(crate) fn sample(&self, [x, y]: [f32; 2]) -> f32 {
        let x = x.clamp(0.0, (self.width - 1) as f32);
        let y = y.clamp(0.0, (self.height - 1) as f32);
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(self.width - 1), (y0 + 1).min(self.height - 1));
        let (fx, fy) = (x - x0 as f32, y - y0 as f32);
        let at = |x: usize, y: usize| f32::from(self.bytes[y * self.width + x]);
        let top = at(x0, y0) + fx * (at(x1, y0) - at(x0, y0));
        let bottom = at(x0, y1) + fx * (at(x1, y1) - at(x0, y1));
        top + fy * (bottom - top)
    }

    /// Values at the distances `far_px` along a line.
    pub(crate) fn sample_each<const N: usize>(
        &self,
        from: [f32; 2],
        along: [f32; 2],
        far_px: [f32; N],
    ) -> [f32; N] {
        far_px.map(|far| self.sample([from[0] + far * along[0], from[1] + far * along[1]]))
    }
}
