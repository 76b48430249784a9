//! Converts pixels to quantized frequencies and back, in floats.

use std::f64::consts::PI;
use std::sync::LazyLock;

/// Position in the block of each frequency, in coding order.
pub(super) const ZIGZAG: [usize; 64] = {
    let (mut order, mut k, mut diagonal) = ([0; 64], 0, 0);
    while diagonal < 15 {
        let mut step = 0;
        while step <= diagonal {
            // Up and to the right on even diagonals, down on odd ones.
            let (across, down) = if diagonal % 2 == 0 {
                (step, diagonal - step)
            } else {
                (diagonal - step, step)
            };
            if across < 8 && down < 8 {
                order[k] = 8 * down + across;
                k += 1;
            }
            step += 1;
        }
        diagonal += 1;
    }
    order
};

/// The cosine of each frequency at each sample, orthonormal.
static COSINES: LazyLock<[[f64; 8]; 8]> = LazyLock::new(|| {
    std::array::from_fn(|u| {
        let scale = if u == 0 { 0.125f64 } else { 0.25 }.sqrt();
        std::array::from_fn(|x| scale * ((2 * x + 1) as f64 * u as f64 * PI / 16.0).cos())
    })
});

/// One channel at its own sampling, in whole blocks.
pub(super) struct Channel {
    samples: Vec<f64>,
    width: usize,
    /// Pixels of the image per sample, horizontally and vertically.
    of: [usize; 2],
}

impl Channel {
    /// Samples channel `c` of YUV: each sample is the mean of its pixels. The image is extended
    /// past its edge with the edge pixels.
    pub(super) fn sample(
        rgb: &[u8],
        size: [usize; 2],
        units: [usize; 2],
        most: [usize; 2],
        factors: [usize; 2],
        c: usize,
    ) -> Self {
        let [width, height] = [0, 1].map(|axis| 8 * units[axis] * factors[axis]);
        let of = [0, 1].map(|axis| most[axis] / factors[axis]);
        let pixel = |x: usize, y: usize| {
            let at = 3 * (y.min(size[1] - 1) * size[0] + x.min(size[0] - 1));
            let [r, g, b] = [0, 1, 2].map(|k| f64::from(rgb[at + k]));
            let luma = 0.299 * r + 0.587 * g + 0.114 * b;
            [luma, 128.0 + (b - luma) / 1.772, 128.0 + (r - luma) / 1.402][c]
        };
        let mut samples = Vec::with_capacity(width * height);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let inside = (0..of[1]).flat_map(|dy| (0..of[0]).map(move |dx| (dx, dy)));
            let sum: f64 = inside
                .map(|(dx, dy)| pixel(of[0] * x + dx, of[1] * y + dy))
                .sum();
            samples.push(sum / (of[0] * of[1]) as f64);
        }
        Self { samples, width, of }
    }

    /// Quantizes a block, and replaces it by the decoded levels.
    pub(super) fn quantize(&mut self, [column, row]: [usize; 2], by: &[u8; 64]) -> [i32; 64] {
        let place = |k: usize| (8 * row + k / 8) * self.width + 8 * column + k % 8;
        let block = std::array::from_fn(|k| self.samples[place(k)] - 128.0);
        // In both directions, because the transform is its own inverse except for the order of the
        // sums.
        let frequencies = transformed(&block, |u, x| COSINES[u][x]);
        let levels: [i32; 64] =
            std::array::from_fn(|k| (frequencies[k] / f64::from(by[k])).round() as i32);
        let block = std::array::from_fn(|k| f64::from(levels[k]) * f64::from(by[k]));
        let block = transformed(&block, |x, u| COSINES[u][x]);
        for (k, value) in block.into_iter().enumerate() {
            let at = place(k);
            self.samples[at] = (value + 128.0).round().clamp(0.0, 255.0);
        }
        levels
    }

    /// Value at a pixel of the image, interpolated between samples at the centers of their pixels.
    /// If a sample covers more than two pixels along a side, decoders use the nearest one.
    fn at(&self, pixel: [usize; 2]) -> f64 {
        let sides = [self.width, self.samples.len() / self.width];
        let [x, y] = [0, 1].map(|axis| {
            let (of, last) = (self.of[axis], sides[axis] - 1);
            if of > 2 {
                return (pixel[axis] / of, 0, 0.0);
            }
            let place = (pixel[axis] as f64 + 0.5) / of as f64 - 0.5;
            let place = place.clamp(0.0, last as f64);
            let first = place as usize;
            (first, (first + 1).min(last), place - first as f64)
        });
        let sample = |x: usize, y: usize| self.samples[y * self.width + x];
        let across = |row: usize| sample(x.0, row) * (1.0 - x.2) + sample(x.1, row) * x.2;
        across(y.0) * (1.0 - y.2) + across(y.1) * y.2
    }
}

fn transformed(block: &[f64; 64], factor: impl Fn(usize, usize) -> f64) -> [f64; 64] {
    let rows: [f64; 64] = std::array::from_fn(|k| {
        (0..8)
            .map(|i| factor(k % 8, i) * block[8 * (k / 8) + i])
            .sum()
    });
    std::array::from_fn(|k| (0..8).map(|i| factor(k / 8, i) * rows[8 * i + k % 8]).sum())
}

/// Converts the channels to RGB, or to gray if there is only one.
pub(super) fn pixels(channels: &[Channel], [width, height]: [usize; 2]) -> Vec<u8> {
    let byte = |value: f64| value.round().clamp(0.0, 255.0) as u8;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    match channels {
        [luma, u, v] => places
            .flat_map(|at| {
                let [y, u, v] = [luma.at(at), u.at(at) - 128.0, v.at(at) - 128.0];
                let green = y - 0.344_136 * u - 0.714_136 * v;
                [y + 1.402 * v, green, y + 1.772 * u].map(byte)
            })
            .collect(),
        _ => places.map(|at| byte(channels[0].at(at))).collect(),
    }
}
