//! A square picture in floating-point levels and its drawing operations: noise, surfaces cut out by
//! signed distances, blur.

use lariat_portable::SplitMix64;

/// Red, green and blue, 0 to 255.
pub(crate) type Rgb = [f32; 3];
/// A position or a direction, in pixels.
pub(crate) type Vec2 = [f32; 2];

/// One value per pixel of a square picture.
#[derive(Clone)]
pub(crate) struct Field<T> {
    pub(crate) side: usize,
    pub(crate) values: Vec<T>,
}

pub(crate) type Canvas = Field<Rgb>;

impl<T: Copy> Field<T> {
    pub(crate) fn of(side: usize, value: T) -> Self {
        Self {
            side,
            values: vec![value; side * side],
        }
    }

    /// Iterates over all values with the positions of their pixels.
    pub(crate) fn places(&mut self) -> impl Iterator<Item = (Vec2, &mut T)> {
        let side = self.side;
        let place = move |i| [(i % side) as f32, (i / side) as f32];
        let values = self.values.iter_mut().enumerate();
        values.map(move |(i, value)| (place(i), value))
    }
}

pub(crate) fn mix(from: Rgb, to: Rgb, share: f32) -> Rgb {
    [0, 1, 2].map(|k| from[k] + share * (to[k] - from[k]))
}

pub(crate) fn scaled(rgb: Rgb, by: f32) -> Rgb {
    rgb.map(|value| value * by)
}

pub(crate) fn dot(a: Vec2, b: Vec2) -> f32 {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn minus(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] - b[0], a[1] - b[1]]
}

/// Returns the unit vector of an angle in radians.
pub(crate) fn direction(angle: f32) -> Vec2 {
    [libm::cosf(angle), libm::sinf(angle)]
}

/// Returns the share of a pixel on the inner side of an edge, given the signed distance of its
/// center.
pub(crate) fn covered(distance_px: f32) -> f32 {
    (0.5 - distance_px).clamp(0.0, 1.0)
}

impl Canvas {
    /// Blends a color over each position. `at` returns the coverage and the color.
    pub(crate) fn lay(&mut self, mut at: impl FnMut(Vec2) -> (f32, Rgb)) {
        for (place, pixel) in self.places() {
            let (share, rgb) = at(place);
            if share > 0.0 {
                *pixel = mix(*pixel, rgb, share);
            }
        }
    }

    /// Removes a share of the light.
    pub(crate) fn darken(&mut self, shares: &Field<f32>, by: f32) {
        for (pixel, share) in self.values.iter_mut().zip(&shares.values) {
            *pixel = scaled(*pixel, 1.0 - by * share);
        }
    }
}

/// Gaussian blur by three box filters (W. M. Wells, 1986). Pixels outside equal those at the
/// border.
pub(crate) fn blur<const N: usize>(field: &mut Field<[f32; N]>, sigma_px: f32) {
    // Below 0.6 pixels a box is too coarse, so three taps are used.
    if sigma_px < 0.6 {
        let side = 0.5 * sigma_px * sigma_px;
        passes(field, |row, out| tap(row, side, out));
        return;
    }
    // A box of radius r, with its last taps weighted by the fraction, has this variance.
    let variance = sigma_px * sigma_px / 3.0;
    let radius = 0.5 * ((12.0 * variance + 1.0).sqrt() - 1.0);
    for _ in 0..3 {
        passes(field, |row, out| average(row, radius, out));
    }
}

fn tap<const N: usize>(row: &[[f32; N]], side: f32, out: &mut [[f32; N]]) {
    let last = row.len() - 1;
    for (i, out) in out.iter_mut().enumerate() {
        let (a, b, c) = (row[i.saturating_sub(1)], row[i], row[(i + 1).min(last)]);
        *out = std::array::from_fn(|k| side * (a[k] + c[k]) + (1.0 - 2.0 * side) * b[k]);
    }
}

fn average<const N: usize>(row: &[[f32; N]], radius: f32, out: &mut [[f32; N]]) {
    let (whole, last) = (radius as isize, row.len() as isize - 1);
    let part = radius - whole as f32;
    let at = |i: isize| row[i.clamp(0, last) as usize];
    let mut sum = [0.0; N];
    for i in -whole..=whole {
        let value = at(i);
        sum = std::array::from_fn(|k| sum[k] + value[k]);
    }
    for (i, out) in out.iter_mut().enumerate() {
        let i = i as isize;
        let (before, after) = (at(i - whole - 1), at(i + whole + 1));
        *out = std::array::from_fn(|k| {
            (sum[k] + part * (before[k] + after[k])) / (2.0 * radius + 1.0)
        });
        let first = at(i - whole);
        sum = std::array::from_fn(|k| sum[k] + after[k] - first[k]);
    }
}

/// Applies a filter to every row and then to every column.
fn passes<const N: usize>(
    field: &mut Field<[f32; N]>,
    mut pass: impl FnMut(&[[f32; N]], &mut [[f32; N]]),
) {
    let side = field.side;
    let (mut row, mut out) = (vec![[0.0; N]; side], vec![[0.0; N]; side]);
    for [step, stride] in [[side, 1], [1, side]] {
        for k in 0..side {
            for (i, value) in row.iter_mut().enumerate() {
                *value = field.values[k * step + i * stride];
            }
            pass(&row, &mut out);
            for (i, value) in out.iter().enumerate() {
                field.values[k * step + i * stride] = *value;
            }
        }
    }
}

/// Returns a shadow: a coverage shifted by some pixels and blurred.
pub(crate) fn shadow(cover: &Field<f32>, by: Vec2, sigma_px: f32) -> Field<f32> {
    let side = cover.side;
    let mut moved = Field::of(side, [0.0]);
    let whole = by.map(|d| d.round() as isize);
    for (i, out) in moved.values.iter_mut().enumerate() {
        let x = (i % side) as isize - whole[0];
        let y = (i / side) as isize - whole[1];
        let edge = |c: isize| c.clamp(0, side as isize - 1) as usize;
        *out = [cover.values[edge(y) * side + edge(x)]];
    }
    blur(&mut moved, sigma_px);
    Field {
        side,
        values: moved.values.into_iter().map(|[value]| value).collect(),
    }
}

/// Noise of mean 0 and variance 1 in octaves from `finest_px` to `coarsest_px`. Each octave is
/// stronger than the next finer one by a factor of 2 to the power of `slope`. The noise is
/// stretched by `aspect` along an angle.
pub(crate) struct Noise {
    pub(crate) finest_px: f32,
    pub(crate) coarsest_px: f32,
    pub(crate) slope: f32,
    pub(crate) aspect: f32,
    pub(crate) angle: f32,
}

impl Noise {
    pub(crate) fn even(finest_px: f32, coarsest_px: f32, slope: f32) -> Self {
        Self {
            finest_px,
            coarsest_px,
            slope,
            aspect: 1.0,
            angle: 0.0,
        }
    }

    pub(crate) fn draw(&self, side: usize, random: &mut SplitMix64) -> Field<f32> {
        const GRID: usize = 64;
        let mut field = Field::of(side, 0.0);
        let (mut scale_px, mut height) = (self.finest_px, 1.0);
        let along = direction(self.angle);
        while scale_px <= self.coarsest_px {
            let heights: [f32; GRID * GRID] = std::array::from_fn(|_| height * normal(random));
            let step = [1.0 / (scale_px * self.aspect), 1.0 / scale_px];
            let offset = [0; 2].map(|_| random.uniform_f32(500.0, 900.0));
            for (at, value) in field.places() {
                let turned = [dot(at, along), at[1] * along[0] - at[0] * along[1]];
                let [x, y] = [0, 1].map(|k| turned[k] * step[k] + offset[k]);
                let (column, row) = (x as usize, y as usize);
                let ease = |t: f32| t * t * (3.0 - 2.0 * t);
                let (u, v) = (ease(x - column as f32), ease(y - row as f32));
                let at = |c: usize, r: usize| heights[(r % GRID) * GRID + c % GRID];
                let upper = at(column, row) * (1.0 - u) + at(column + 1, row) * u;
                let lower = at(column, row + 1) * (1.0 - u) + at(column + 1, row + 1) * u;
                *value += upper * (1.0 - v) + lower * v;
            }
            scale_px *= 2.0;
            height *= libm::powf(2.0, self.slope);
        }
        let count = field.values.len() as f32;
        let mean = field.values.iter().sum::<f32>() / count;
        let square = |value: &f32| (value - mean) * (value - mean);
        let deviation = (field.values.iter().map(square).sum::<f32>() / count).sqrt();
        let gain = 1.0 / deviation.max(1e-3);
        field
            .values
            .iter_mut()
            .for_each(|v| *v = (*v - mean) * gain);
        field
    }
}

/// Returns an approximately normal number of variance 1. A sum of four uniform numbers in [−½, ½)
/// has a variance of ⅓.
pub(crate) fn normal(random: &mut SplitMix64) -> f32 {
    let bits = random.next_u64();
    let sum: f32 = (0..4)
        .map(|k| ((bits >> (16 * k)) & 0xFFFF) as f32 / 65536.0 - 0.5)
        .sum();
    sum * 3f32.sqrt()
}

/// Returns true with this probability.
pub(crate) fn happens(random: &mut SplitMix64, probability: f32) -> bool {
    random.unit_f32() < probability
}

/// Returns a number that is uniform in its logarithm.
pub(crate) fn spread(random: &mut SplitMix64, low: f32, high: f32) -> f32 {
    low * libm::powf(high / low, random.unit_f32())
}

/// Returns a random color. Some families are more frequent, as in the paint of real objects.
pub(crate) fn color(random: &mut SplitMix64) -> Rgb {
    let kinds = [
        Paint::Any,
        Paint::Gray,
        Paint::Gray,
        Paint::Light,
        Paint::Light,
        Paint::Dark,
        Paint::Bright,
    ];
    kinds[random.below(kinds.len())].draw(random)
}

/// Families of colors.
#[derive(Clone, Copy)]
pub(crate) enum Paint {
    Any,
    Gray,
    Light,
    Dark,
    Bright,
}

impl Paint {
    pub(crate) fn draw(self, random: &mut SplitMix64) -> Rgb {
        let mut near = |low: f32, high: f32, off: f32| {
            let level = random.uniform_f32(low, high);
            [(); 3].map(|()| (level + off * normal(random)).clamp(4.0, 252.0))
        };
        match self {
            Self::Any => [(); 3].map(|()| random.uniform_f32(15.0, 245.0)),
            Self::Gray => near(15.0, 240.0, 7.0),
            Self::Light => near(150.0, 248.0, 11.0),
            Self::Dark => near(8.0, 70.0, 7.0),
            Self::Bright => {
                let hue = random.uniform_f32(0.0, 6.0);
                let strength = random.uniform_f32(0.45, 1.0);
                let value = random.uniform_f32(80.0, 250.0);
                [5.0, 3.0, 1.0].map(|shift| {
                    let k = (shift + hue) % 6.0;
                    value * (1.0 - strength * k.min(4.0 - k).clamp(0.0, 1.0))
                })
            }
        }
    }
}
