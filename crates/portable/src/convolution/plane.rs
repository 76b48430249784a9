//! Activations of a picture, within a border.

/// Activations with their channels last, within a border of zeros (or of another byte) on all four sides.
#[derive(Clone, Debug, Default)]
pub struct Plane {
    width: usize,
    height: usize,
    bytes: usize,
    border: usize,
    data: Vec<u8>,
}

impl Plane {
    /// Nothing yet, for pixels of so many bytes and so wide a border; see [`resize`](Self::resize).
    pub fn new(bytes: usize, border: usize) -> Self {
        Self {
            bytes,
            border,
            ..Self::default()
        }
    }

    /// Makes it so large, and fills it with `fill` if it was of another size. Allocates only where it was never as large before.
    pub fn resize(&mut self, width: usize, height: usize, fill: u8) {
        if (self.width, self.height) == (width, height) {
            return;
        }
        (self.width, self.height) = (width, height);
        // Behind the last row there is what a block of 16 windows two pixels apart may read, and no more than reads.
        let behind = (2 * 16 + 2 * self.border) * self.bytes;
        let rows = height + 2 * self.border;
        self.data.clear();
        self.data.resize(rows * self.stride() + behind, fill);
    }

    /// Pixels of a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    fn stride(&self) -> usize {
        (self.width + 2 * self.border) * self.bytes
    }

    fn start(&self, y: isize) -> usize {
        let row = y + self.border as isize;
        assert!(row >= 0 && row < (self.height + 2 * self.border) as isize);
        row as usize * self.stride() + self.border * self.bytes
    }

    /// From `reach` pixels left of row `y` on, as far as the memory goes: what [`Convolution::row`](crate::Convolution::row)
    /// reads. The rows above and below the picture are the border.
    ///
    /// # Panics
    ///
    /// Where `y` or `reach` is outside the border.
    pub fn windows(&self, y: isize, reach: usize) -> &[u8] {
        assert!(reach <= self.border);
        &self.data[self.start(y) - reach * self.bytes..]
    }

    /// The pixels of row `y`.
    ///
    /// # Panics
    ///
    /// Where there is none.
    pub fn row(&self, y: usize) -> &[u8] {
        assert!(y < self.height);
        &self.data[self.start(y as isize)..][..self.width * self.bytes]
    }

    /// The pixels of row `y`.
    ///
    /// # Panics
    ///
    /// Where there is none.
    pub fn row_mut(&mut self, y: usize) -> &mut [u8] {
        assert!(y < self.height);
        let start = self.start(y as isize);
        &mut self.data[start..][..self.width * self.bytes]
    }
}
