//! The table's color everywhere, from the image alone.
//!
//! A rope covers a small share of the pixels, so the table is what most of a sparse grid of pixels
//! agrees on: a quadratic surface per channel (light falls off smoothly over a table, and lenses
//! vignette), fitted by least squares again and again to the pixels that lie within a few times the
//! median residual. Up to about 40% of the samples may be rope.

use crate::Image;
use crate::color;

/// Samples along each side of the grid: enough for six coefficients and a sharp median, few enough
/// to cost less than one pass over a 640×480 image.
const GRID: usize = 64;
const ROUNDS: usize = 8;
/// Samples farther than this many median residuals from the surface are taken for rope.
const OUTLIER: f32 = 3.0;
const TERMS: usize = 6;

/// Memory of the fit and its result.
#[derive(Debug, Default)]
pub(crate) struct Background {
    samples: Vec<Sample>,
    residuals: Vec<f32>,
    coefficients: [[f32; TERMS]; 3],
    width: f32,
    height: f32,
    /// The median distance of the table's pixels from the surface, at least half a level.
    pub(crate) noise: f32,
}

#[derive(Debug)]
struct Sample {
    terms: [f32; TERMS],
    color: [f32; 3],
}

impl Background {
    /// Fits the surface to `image`.
    pub(crate) fn estimate(&mut self, image: &Image) {
        (self.width, self.height) = (image.width() as f32, image.height() as f32);
        let yuv = color::is_yuv(image.format());
        self.take_samples(image);
        self.coefficients = [[0.0; TERMS]; 3];
        for channel in 0..3 {
            self.residuals.clear();
            self.residuals
                .extend(self.samples.iter().map(|s| s.color[channel]));
            self.coefficients[channel][0] = median(&mut self.residuals);
        }
        let mut scale = self.measure(yuv);
        for _ in 0..ROUNDS {
            if !self.fit(OUTLIER * scale.max(0.7), yuv) {
                break;
            }
            let tighter = self.measure(yuv);
            if (tighter - scale).abs() < 0.02 * scale {
                scale = tighter;
                break;
            }
            scale = tighter;
        }
        self.noise = scale.max(0.5);
    }

    /// The surface along row `y`: for each x and channel the level, into `out` (three rows of width).
    pub(crate) fn row(&self, y: usize, out: [&mut [u8]; 3]) {
        for (row, c) in out.into_iter().zip(&self.coefficients) {
            let v = unit(y as f32, self.height);
            let a = c[0] + v * (c[2] + v * c[5]);
            let b = c[1] + v * c[4];
            let scale = 2.0 / self.width;
            for (x, level) in row.iter_mut().enumerate() {
                let u = (x as f32 + 0.5) * scale - 1.0;
                *level = (a + u * (b + u * c[3]) + 0.5) as u8;
            }
        }
    }

    /// The surface at one pixel.
    pub(crate) fn at(&self, x: usize, y: usize) -> [f32; 3] {
        let (u, v) = (unit(x as f32, self.width), unit(y as f32, self.height));
        self.surface(&[1.0, u, v, u * u, u * v, v * v])
    }

    fn take_samples(&mut self, image: &Image) {
        let (width, height) = (image.width(), image.height());
        self.samples.clear();
        let (columns, rows) = (GRID.min(width), GRID.min(height));
        for j in 0..rows {
            let y = (2 * j + 1) * height / (2 * rows);
            for i in 0..columns {
                let x = (2 * i + 1) * width / (2 * columns);
                let (u, v) = (unit(x as f32, self.width), unit(y as f32, self.height));
                self.samples.push(Sample {
                    terms: [1.0, u, v, u * u, u * v, v * v],
                    color: color::native(image, x, y).map(f32::from),
                });
            }
        }
    }

    fn surface(&self, terms: &[f32; TERMS]) -> [f32; 3] {
        self.coefficients
            .map(|c| c.iter().zip(terms).map(|(c, t)| c * t).sum())
    }

    /// The median distance of the samples from the surface.
    fn measure(&mut self, yuv: bool) -> f32 {
        let mut residuals = std::mem::take(&mut self.residuals);
        residuals.clear();
        residuals.extend(
            self.samples
                .iter()
                .map(|s| color::distance(s.color, self.surface(&s.terms), yuv)),
        );
        let middle = median(&mut residuals);
        self.residuals = residuals;
        middle
    }

    /// Least squares over the samples within `limit` of the surface. False when they do not
    /// determine it.
    fn fit(&mut self, limit: f32, yuv: bool) -> bool {
        let mut gram = [[0.0f64; TERMS]; TERMS];
        let mut right = [[0.0f64; TERMS]; 3];
        for sample in &self.samples {
            if color::distance(sample.color, self.surface(&sample.terms), yuv) > limit {
                continue;
            }
            for (i, row) in gram.iter_mut().enumerate() {
                let t = f64::from(sample.terms[i]);
                for (g, &u) in row.iter_mut().zip(&sample.terms) {
                    *g += t * f64::from(u);
                }
                for (r, c) in right.iter_mut().zip(sample.color) {
                    r[i] += t * f64::from(c);
                }
            }
        }
        let Some(factor) = cholesky(gram) else {
            return false;
        };
        for (c, r) in self.coefficients.iter_mut().zip(right) {
            *c = solve(&factor, r).map(|v| v as f32);
        }
        true
    }
}

/// A pixel's position on a scale from −1 to 1 across the image.
fn unit(position: f32, side: f32) -> f32 {
    (position + 0.5) * (2.0 / side) - 1.0
}

/// The middle value (of an even number the upper one); 0 of nothing.
pub(crate) fn median(values: &mut [f32]) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// The lower Cholesky factor, or nothing when the matrix is not clearly positive definite.
fn cholesky(mut a: [[f64; TERMS]; TERMS]) -> Option<[[f64; TERMS]; TERMS]> {
    let floor = 1e-6 * a[0][0];
    for i in 0..TERMS {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            let rest = a[i][j] - dot;
            if i == j {
                if rest <= floor {
                    return None;
                }
                a[i][i] = rest.sqrt();
            } else {
                a[i][j] = rest / a[j][j];
            }
        }
    }
    Some(a)
}

fn solve(factor: &[[f64; TERMS]; TERMS], mut b: [f64; TERMS]) -> [f64; TERMS] {
    for i in 0..TERMS {
        let dot: f64 = (0..i).map(|k| factor[i][k] * b[k]).sum();
        b[i] = (b[i] - dot) / factor[i][i];
    }
    for i in (0..TERMS).rev() {
        let dot: f64 = (i + 1..TERMS).map(|k| factor[k][i] * b[k]).sum();
        b[i] = (b[i] - dot) / factor[i][i];
    }
    b
}
