//! The losses of baseline JPEG compression. Quantization tables are those of ITU-T T.81, Annex K,
//! scaled by quality as the Independent JPEG Group does; color has half the picture's resolution.
//! The steps after quantization are lossless and are left out.

use std::array::from_fn;

use crate::rendered::portable::cos_turns;

/// Number of values on a block's side.
const SIDE: usize = 8;
/// Quantization steps of a block's frequencies at quality 50, row by row: for luma and for chroma.
const LIGHT: [u8; SIDE * SIDE] = [
    16, 11, 10, 16, 24, 40, 51, 61, 12, 12, 14, 19, 26, 58, 60, 55, 14, 13, 16, 24, 40, 57, 69, 56,
    14, 17, 22, 29, 51, 87, 80, 62, 18, 22, 37, 56, 68, 109, 103, 77, 24, 35, 55, 64, 81, 104, 113,
    92, 49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99,
];
const COLOR: [u8; SIDE * SIDE] = [
    17, 18, 24, 47, 99, 99, 99, 99, 18, 21, 26, 66, 99, 99, 99, 99, 24, 26, 56, 99, 99, 99, 99, 99,
    47, 66, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99,
    99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99,
];

/// One of the picture's three planes.
struct Plane {
    values: Vec<f32>,
    width: usize,
    height: usize,
}

/// Applies the loss of a JPEG of this quality (1 to 50) to a picture of three bytes per pixel.
pub(super) fn keep(rgb: &mut [u8], [width, height]: [usize; 2], quality: u16) {
    let plane = |of: [f32; 3], level: f32| {
        let light = |p: &[u8]| level + (0..3).map(|k| of[k] * f32::from(p[k])).sum::<f32>();
        Plane {
            values: rgb.chunks_exact(3).map(light).collect(),
            width,
            height,
        }
    };
    let mut light = plane([0.299, 0.587, 0.114], 0.0);
    let blue = plane([-0.168_736, -0.331_264, 0.5], 128.0);
    let red = plane([0.5, -0.418_688, -0.081_312], 128.0);
    let mut colors = [blue.halved(), red.halved()];
    let rounding = |table: [u8; SIDE * SIDE]| {
        let scale = 5000 / u32::from(quality);
        table.map(|step| ((u32::from(step) * scale + 50) / 100).clamp(1, 255) as f32)
    };
    let waves = waves();
    light.round(&waves, &rounding(LIGHT));
    for color in &mut colors {
        color.round(&waves, &rounding(COLOR));
    }
    for (i, pixel) in rgb.chunks_exact_mut(3).enumerate() {
        let at = [i % width, i / width];
        let [blue, red] = colors.each_ref().map(|color| color.doubled(at) - 128.0);
        let y = light.values[i];
        let seen = [
            y + 1.402 * red,
            y - 0.344_136 * blue - 0.714_136 * red,
            y + 1.772 * blue,
        ];
        for (byte, value) in pixel.iter_mut().zip(seen) {
            *byte = (value + 0.5).clamp(0.0, 255.0) as u8;
        }
    }
}

/// Rows of the discrete cosine transform, one per frequency.
fn waves() -> [[f32; SIDE]; SIDE] {
    from_fn(|k| {
        let scale = if k == 0 { (0.125f64).sqrt() } else { 0.5 };
        from_fn(|i| (scale * cos_turns(((2 * i + 1) * k) as f64 / 32.0)) as f32)
    })
}

impl Plane {
    /// Value at a pixel; outside the image, that of the border.
    fn at(&self, x: isize, y: isize) -> f32 {
        let x = x.clamp(0, self.width as isize - 1) as usize;
        let y = y.clamp(0, self.height as isize - 1) as usize;
        self.values[y * self.width + x]
    }

    /// Means of two by two pixels.
    fn halved(&self) -> Self {
        let [width, height] = [self.width, self.height].map(|side| side.div_ceil(2));
        let mean = |i: usize| {
            let [x, y] = [2 * (i % width) as isize, 2 * (i / width) as isize];
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
            0.25 * four.map(|(u, v)| self.at(x + u, y + v)).iter().sum::<f32>()
        };
        Self {
            values: (0..width * height).map(mean).collect(),
            width,
            height,
        }
    }

    /// Value at a pixel of a picture of twice the size, interpolated along each axis with a weight
    /// of ¾ for the nearest value.
    fn doubled(&self, [x, y]: [usize; 2]) -> f32 {
        let [columns, rows] = [x, y].map(|c| {
            let near = (c / 2) as isize;
            [near, if c % 2 == 0 { near - 1 } else { near + 1 }]
        });
        let row = |y: isize| 0.75 * self.at(columns[0], y) + 0.25 * self.at(columns[1], y);
        0.75 * row(rows[0]) + 0.25 * row(rows[1])
    }

    /// Rounds the frequencies of each block to multiples of the table's values.
    fn round(&mut self, waves: &[[f32; SIDE]; SIDE], table: &[f32; SIDE * SIDE]) {
        for top in (0..self.height).step_by(SIDE) {
            for left in (0..self.width).step_by(SIDE) {
                let block: [[f32; SIDE]; SIDE] = from_fn(|y| {
                    from_fn(|x| self.at((left + x) as isize, (top + y) as isize) - 128.0)
                });
                let mut kept = transform(waves, &block, false);
                for (k, value) in kept.iter_mut().flatten().enumerate() {
                    *value = libm::roundf(*value / table[k]) * table[k];
                }
                let block = transform(waves, &kept, true);
                for (y, row) in block.iter().enumerate().take(self.height - top) {
                    let to = &mut self.values[(top + y) * self.width + left..];
                    let count = SIDE.min(self.width - left);
                    for (to, value) in to[..count].iter_mut().zip(row) {
                        *to = value + 128.0;
                    }
                }
            }
        }
    }
}

/// Returns the frequencies of a block or, with `back`, the block with these frequencies.
fn transform(
    waves: &[[f32; SIDE]; SIDE],
    block: &[[f32; SIDE]; SIDE],
    back: bool,
) -> [[f32; SIDE]; SIDE] {
    let wave = |k: usize, i: usize| if back { waves[i][k] } else { waves[k][i] };
    let rows: [[f32; SIDE]; SIDE] =
        from_fn(|y| from_fn(|k| (0..SIDE).map(|x| wave(k, x) * block[y][x]).sum()));
    from_fn(|k| from_fn(|x| (0..SIDE).map(|y| wave(k, y) * rows[y][x]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_give_the_block_they_were_taken_of() {
        let block = from_fn(|y| from_fn(|x| ((31 * x + 57 * y) % 97) as f32));
        let back = transform(&waves(), &transform(&waves(), &block, false), true);
        for (row, expected) in back.iter().zip(&block) {
            for (value, expected) in row.iter().zip(expected) {
                assert!((value - expected).abs() < 1e-3, "{value} for {expected}");
            }
        }
    }

    #[test]
    fn a_plain_picture_stays_as_it_is_and_a_fine_pattern_is_lost() {
        let (width, height) = (37, 22);
        let mut plain = [90, 140, 60].repeat(width * height);
        keep(&mut plain, [width, height], 30);
        let off = |p: &[u8]| (0..3).map(|k| p[k].abs_diff([90, 140, 60][k])).max();
        assert!(plain.chunks_exact(3).all(|p| off(p) <= Some(12)));
        assert!(plain.chunks_exact(3).all(|p| p == &plain[..3]));
        let checkered = |i: usize| [100, 112][(i % width + i / width) % 2];
        let mut fine: Vec<u8> = (0..width * height)
            .flat_map(|i| [checkered(i); 3])
            .collect();
        keep(&mut fine, [width, height], 30);
        let middle = &fine[3 * (8 * width + 8)..][..3 * 8];
        assert!(middle.iter().all(|&v| v.abs_diff(106) <= 3), "{middle:?}");
    }
}
