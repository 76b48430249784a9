//! A picture of one byte a pixel: how unlike the table each pixel is.

use std::ops::Range;

/// One byte a pixel, rows one after the other.
#[derive(Debug, Default)]
pub(crate) struct Plane {
    bytes: Vec<u8>,
    width: usize,
    height: usize,
}

impl Plane {
    /// Takes this size, keeping the memory it has; the bytes are whatever they were.
    pub(crate) fn resize(&mut self, width: usize, height: usize) {
        (self.width, self.height) = (width, height);
        self.bytes.resize(width * height, 0);
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
        &mut self.bytes[y * self.width..][..self.width]
    }

    /// Some rows, one after the other.
    pub(crate) fn rows_mut(&mut self, rows: Range<usize>) -> &mut [u8] {
        &mut self.bytes[self.width * rows.start..self.width * rows.end]
    }

    /// Whether the position lies between the outermost pixels' centers.
    #[inline]
    pub(crate) fn holds(&self, [x, y]: [f32; 2]) -> bool {
        let (right, bottom) = (self.width as f32 - 1.0, self.height as f32 - 1.0);
        x >= 0.0 && y >= 0.0 && x <= right && y <= bottom
    }

    /// The share of the way from a position that the plane holds to one that it does not, up to its border.
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

    /// The value at a position between pixels, bilinear; past the edge the edge's value goes on.
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

    /// The values at some distances along a line.
    pub(crate) fn sample_each<const N: usize>(
        &self,
        from: [f32; 2],
        along: [f32; 2],
        far_px: [f32; N],
    ) -> [f32; N] {
        far_px.map(|far| self.sample([from[0] + far * along[0], from[1] + far * along[1]]))
    }
}
