//! Activations of an image with a border.

/// Activations with channels last, inside a border of zeros (or of another byte) on all four sides.
#[derive(Clone, Debug, Default)]
pub struct Plane {
    width: usize,
    height: usize,
    bytes: usize,
    border: usize,
    data: Vec<u8>,
}

impl Plane {
    /// Creates an empty plane for pixels of this many bytes and this border; see
    /// [`resize`](Self::resize).
    pub fn new(bytes: usize, border: usize) -> Self {
        Self {
            bytes,
            border,
            ..Self::default()
        }
    }

    /// Sets the size, and fills the plane with `fill` if the size changes. Allocates only if the
    /// plane was never this large.
    pub fn resize(&mut self, width: usize, height: usize, fill: u8) {
        if (self.width, self.height) == (width, height) {
            return;
        }
        (self.width, self.height) = (width, height);
        // After the last row: data that a block of 16 windows, two pixels apart, may read but not
        // use.
        let behind = (2 * 16 + 2 * self.border) * self.bytes;
        let rows = height + 2 * self.border;
        self.data.clear();
        self.data.resize(rows * self.stride() + behind, fill);
    }

    /// Pixels per row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
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

    /// Returns the data from `reach` pixels left of row `y` to the end, which
    /// [`Convolution::row`](crate::Convolution::row) reads. The rows above and below the image are
    /// the border.
    ///
    /// # Panics
    ///
    /// If `y` or `reach` is outside the border.
    pub fn windows(&self, y: isize, reach: usize) -> &[u8] {
        assert!(reach <= self.border);
        &self.data[self.start(y) - reach * self.bytes..]
    }

    /// The pixels of row `y`.
    ///
    /// # Panics
    ///
    /// If the row does not exist.
    pub fn row(&self, y: usize) -> &[u8] {
        assert!(y < self.height);
        &self.data[self.start(y as isize)..][..self.width * self.bytes]
    }

    /// The pixels of row `y`.
    ///
    /// # Panics
    ///
    /// If the row does not exist.
    pub fn row_mut(&mut self, y: usize) -> &mut [u8] {
        assert!(y < self.height);
        let start = self.start(y as isize);
        &mut self.data[start..][..self.width * self.bytes]
    }
}
