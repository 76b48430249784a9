//! Small pictures from a fuzzer's bytes: the bytes themselves as pixels, or strokes drawn on a
//! table, so that some shapes pass the mask and reach the later steps.

use arbitrary::Arbitrary;
use lariat_extract::PixelFormat;

/// Maximum length of a side: enough pixels for several strands and a crossing, few enough for many
/// runs a second.
const LONGEST_SIDE: usize = 96;

/// Size, format and content of a picture.
#[derive(Arbitrary, Clone, Debug)]
pub(crate) struct Picture {
    width: u8,
    height: u8,
    format: Format,
    /// Number of bytes between the end of one row and the start of the next.
    gap: u8,
    content: Content,
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Format {
    Gray8,
    Rgb8,
    Bgr8,
    Yuyv,
    Uyvy,
    Nv12,
    Bgra8,
    Gray16,
    BayerRggb8,
    BayerBggr8,
    BayerGrbg8,
    BayerGbrg8,
}

#[derive(Arbitrary, Clone, Debug)]
enum Content {
    /// These bytes, repeated.
    Raw(Vec<u8>),
    Drawn(Drawing),
}

#[derive(Arbitrary, Clone, Debug)]
struct Drawing {
    table: [u8; 3],
    /// Change in level from the left edge to the right one.
    slope: i8,
    /// Side of the squares of a checkered table, in pixels; 0 for a plain table.
    cell: u8,
    /// Amplitude of the noise, in levels.
    noise: u8,
    strokes: Vec<Stroke>,
}

/// Parabolic arc as thick as a rope, in 256ths of the picture.
#[derive(Arbitrary, Clone, Debug)]
struct Stroke {
    from: [u8; 2],
    by: [u8; 2],
    to: [u8; 2],
    thickness: u8,
    color: [u8; 3],
}

/// Bytes of a picture and their format.
pub(crate) struct Pixels {
    pub(crate) bytes: Vec<u8>,
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) stride: usize,
    pub(crate) format: PixelFormat,
}

impl Picture {
    pub(crate) fn pixels(&self) -> Pixels {
        let (width, height) = (side(self.width), side(self.height));
        let format = match self.format {
            Format::Gray8 => PixelFormat::Gray8,
            Format::Rgb8 => PixelFormat::Rgb8,
            Format::Bgr8 => PixelFormat::Bgr8,
            Format::Yuyv => PixelFormat::Yuyv,
            Format::Uyvy => PixelFormat::Uyvy,
            Format::Nv12 => PixelFormat::Nv12,
            Format::Bgra8 => PixelFormat::Bgra8,
            Format::Gray16 => PixelFormat::Gray16,
            Format::BayerRggb8 => PixelFormat::BayerRggb8,
            Format::BayerBggr8 => PixelFormat::BayerBggr8,
            Format::BayerGrbg8 => PixelFormat::BayerGrbg8,
            Format::BayerGbrg8 => PixelFormat::BayerGbrg8,
        };
        let row = format.row_bytes(width);
        let stride = row + usize::from(self.gap);
        let rows = format.rows(height);
        let mut pixels = Pixels {
            bytes: vec![0; stride * rows],
            width,
            height,
            stride,
            format,
        };
        match &self.content {
            Content::Raw(bytes) if bytes.is_empty() => {}
            Content::Raw(bytes) => {
                let again = bytes.iter().cycle();
                pixels
                    .bytes
                    .iter_mut()
                    .zip(again)
                    .for_each(|(to, from)| *to = *from);
            }
            Content::Drawn(drawing) => drawing.draw(&mut pixels),
        }
        pixels
    }

    /// Returns the same picture as a mask for a picture of this size, in `Gray8`.
    pub(crate) fn mask_of_size(&self, width: usize, height: usize) -> Pixels {
        let mut mask = self.clone();
        mask.format = Format::Gray8;
        (mask.width, mask.height) = ((width - 1) as u8, (height - 1) as u8);
        mask.pixels()
    }
}

fn side(byte: u8) -> usize {
    usize::from(byte) % LONGEST_SIDE + 1
}

impl Drawing {
    fn draw(&self, pixels: &mut Pixels) {
        let (width, height) = (pixels.width, pixels.height);
        let mut colors = vec![[0; 3]; width * height];
        let mut state = 1u32;
        for (i, color) in colors.iter_mut().enumerate() {
            let (x, y) = (i % width, i / width);
            let mut light = i32::from(self.slope) * x as i32 / width as i32;
            if self.cell > 0 {
                let cell = usize::from(self.cell);
                light += 60 * ((x / cell + y / cell) % 2) as i32;
            }
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            light += (state >> 24) as i32 * i32::from(self.noise % 64) / 256;
            *color = self
                .table
                .map(|level| i32::from(level).saturating_add(light).clamp(0, 255) as u8);
        }
        // More strokes than this would cover each other.
        for stroke in self.strokes.iter().take(24) {
            stroke.draw(&mut colors, width, height);
        }
        for y in 0..height {
            for x in 0..width {
                pixels.set(x, y, colors[y * width + x]);
            }
        }
    }
}

impl Stroke {
    fn draw(&self, colors: &mut [[u8; 3]], width: usize, height: usize) {
        let place = |[x, y]: [u8; 2]| {
            let on = |c: u8, side: usize| f32::from(c) / 256.0 * side as f32;
            [on(x, width), on(y, height)]
        };
        let (a, b, c) = (place(self.from), place(self.by), place(self.to));
        let half = 0.5 + f32::from(self.thickness % 32) / 4.0;
        let steps = 2 * width.max(height);
        for step in 0..=steps {
            let t = step as f32 / steps as f32;
            let along = |i: usize| {
                let (p, q) = (a[i] + t * (b[i] - a[i]), b[i] + t * (c[i] - b[i]));
                p + t * (q - p)
            };
            let (x, y) = (along(0), along(1));
            let reach = |at: f32, side: usize| {
                (at - half).max(0.0) as usize..((at + half) as usize + 1).min(side)
            };
            for row in reach(y, height) {
                for column in reach(x, width) {
                    if (column as f32 - x).hypot(row as f32 - y) <= half {
                        colors[row * width + column] = self.color;
                    }
                }
            }
        }
    }
}

impl Pixels {
    /// Writes the three levels as they are, whatever they mean in the format.
    fn set(&mut self, x: usize, y: usize, [a, b, c]: [u8; 3]) {
        let row = y * self.stride;
        match self.format {
            PixelFormat::Gray8 => self.bytes[row + x] = a,
            PixelFormat::Rgb8 | PixelFormat::Bgr8 => {
                self.bytes[row + 3 * x..][..3].copy_from_slice(&[a, b, c]);
            }
            PixelFormat::Yuyv => {
                let pair = row + 4 * (x / 2);
                self.bytes[pair + 2 * (x % 2)] = a;
                (self.bytes[pair + 1], self.bytes[pair + 3]) = (b, c);
            }
            PixelFormat::Uyvy => {
                let pair = row + 4 * (x / 2);
                self.bytes[pair + 2 * (x % 2) + 1] = a;
                (self.bytes[pair], self.bytes[pair + 2]) = (b, c);
            }
            PixelFormat::Nv12 => {
                self.bytes[row + x] = a;
                let pair = (self.height + y / 2) * self.stride + 2 * (x / 2);
                self.bytes[pair..pair + 2].copy_from_slice(&[b, c]);
            }
            PixelFormat::Bgra8 => {
                self.bytes[row + 4 * x..][..3].copy_from_slice(&[a, b, c]);
            }
            PixelFormat::Gray16 => self.bytes[row + 2 * x..][..2].fill(a),
            PixelFormat::BayerRggb8
            | PixelFormat::BayerBggr8
            | PixelFormat::BayerGrbg8
            | PixelFormat::BayerGbrg8 => {
                self.bytes[row + x] = [[a, b], [b, c]][y % 2][x % 2];
            }
        }
    }
}
