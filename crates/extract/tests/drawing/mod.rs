//! Ropes drawn with a known truth: antialiased strips along a curve over a lit, noisy table.
#![allow(dead_code, reason = "each test binary uses a part of it")]

pub(crate) mod formats;
pub(crate) mod shaded;

use lariat_extract::{Curve, Extractor, Image, Options, PixelFormat, Scene};
use lariat_portable::SplitMix64;

pub(crate) type Vec2 = [f32; 2];

/// A rope to draw: its finely sampled centerline, width and color.
#[derive(Clone)]
pub(crate) struct Rope {
    pub points: Vec<Vec2>,
    pub width_px: f32,
    pub color: [f32; 3],
    pub closed: bool,
}

impl Rope {
    /// A rope along `curve` for t from 0 to 1.
    pub(crate) fn along(width_px: f32, color: [f32; 3], curve: impl Fn(f32) -> Vec2) -> Self {
        let points = (0..=1500).map(|i| curve(i as f32 / 1500.0)).collect();
        Self {
            points,
            width_px,
            color,
            closed: false,
        }
    }

    /// `n` true points at equal arc lengths.
    pub(crate) fn truth(&self, n: usize) -> Vec<Vec2> {
        let mut lengths = vec![0.0f64];
        for pair in self.points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + f64::from(distance(pair[0], pair[1])));
        }
        let total = lengths[lengths.len() - 1];
        let intervals = if self.closed { n } else { n - 1 };
        (0..n)
            .map(|k| {
                let goal = total * k as f64 / intervals as f64;
                let i = lengths
                    .partition_point(|&l| l <= goal)
                    .clamp(1, self.points.len() - 1);
                let span = (lengths[i] - lengths[i - 1]).max(1e-9);
                let t = ((goal - lengths[i - 1]) / span) as f32;
                let (a, b) = (self.points[i - 1], self.points[i]);
                [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
            })
            .collect()
    }
}

/// A table with ropes on it.
pub(crate) struct Table {
    pub width: usize,
    pub height: usize,
    pub color: [f32; 3],
    /// Relative change of the light from one corner to the opposite one.
    pub gradient: f32,
    /// Standard deviation of the noise, in levels.
    pub noise: f32,
    /// Share of light that a rope's sides lack compared with its middle; 0 for a strip of one
    /// color.
    pub round: f32,
    pub seed: u64,
}

impl Table {
    pub(crate) fn new(width: usize, height: usize, color: [f32; 3]) -> Self {
        Self {
            width,
            height,
            color,
            gradient: 0.0,
            noise: 0.0,
            round: 0.35,
            seed: 1,
        }
    }

    /// The same table with ropes as strips of one color, for tests that need their exact colors or
    /// edges.
    pub(crate) fn flat(self) -> Self {
        Self { round: 0.0, ..self }
    }

    /// The picture as RGB bytes.
    pub(crate) fn draw(&self, ropes: &[Rope]) -> Vec<u8> {
        let (w, h) = (self.width, self.height);
        let mut picture = vec![self.color; w * h];
        for rope in ropes {
            let half_px = 0.5 * rope.width_px;
            for (pixel, (share, off_px)) in picture.iter_mut().zip(cover(rope, w, h)) {
                let off = (off_px / half_px).min(1.0);
                let light = 1.0 + self.round * (1.0 / 3.0 - off * off);
                for (p, c) in pixel.iter_mut().zip(rope.color) {
                    *p += share * (light * c - *p);
                }
            }
        }
        let mut random = SplitMix64::new(self.seed);
        let mut bytes = Vec::with_capacity(3 * w * h);
        for (i, pixel) in picture.iter().enumerate() {
            let across = (i % w) as f32 / w as f32 + (i / w) as f32 / h as f32 - 1.0;
            let light = 1.0 + 0.5 * self.gradient * across;
            bytes.extend(pixel.map(|p| {
                let noise = if self.noise == 0.0 {
                    0.0
                } else {
                    normal(&mut random)
                };
                (p * light + self.noise * noise + 0.5).clamp(0.0, 255.0) as u8
            }));
        }
        bytes
    }
}

/// Returns how much of each pixel the rope covers, 0 to 1, and the pixel's distance from the rope's
/// middle.
fn cover(rope: &Rope, width: usize, height: usize) -> impl Iterator<Item = (f32, f32)> {
    let half = rope.width_px / 2.0;
    let mut cover = vec![0.0f32; width * height];
    let mut off = vec![f32::INFINITY; width * height];
    for pair in rope.points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let along = [b[0] - a[0], b[1] - a[1]];
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        if length < 1e-6 {
            continue;
        }
        let span = |c: usize, side: usize| {
            let low = (a[c].min(b[c]) - half - 1.0).floor().max(0.0) as usize;
            let high = (a[c].max(b[c]) + half + 2.0).max(0.0) as usize;
            low..high.min(side)
        };
        for y in span(1, height) {
            for x in span(0, width) {
                let d = [x as f32 - a[0], y as f32 - a[1]];
                let ahead = (d[0] * along[0] + d[1] * along[1]) / length;
                let aside = (d[0] * along[1] - d[1] * along[0]) / length;
                let beyond = (-ahead).max(ahead - length);
                // Segments overlap like beads. The tips are cut straight below.
                let out = beyond.max(0.0);
                let off_px = (aside * aside + out * out).sqrt();
                let share = (half - off_px + 0.5).clamp(0.0, 1.0);
                let i = y * width + x;
                cover[i] = cover[i].max(share);
                off[i] = off[i].min(off_px);
            }
        }
    }
    if !rope.closed {
        let points = &rope.points;
        cut_end(points.iter(), half, &mut cover, width, height);
        cut_end(points.iter().rev(), half, &mut cover, width, height);
    }
    cover.into_iter().zip(off)
}

/// Removes what the beads near the first of `points` cover beyond it.
fn cut_end<'a>(
    mut points: impl Iterator<Item = &'a Vec2>,
    half: f32,
    cover: &mut [f32],
    width: usize,
    height: usize,
) {
    let Some(&tip) = points.next() else { return };
    // The direction is that of the last pixel of the rope.
    let Some(&inner) = points.find(|&&p| distance(p, tip) > 1.0) else {
        return;
    };
    let length = distance(tip, inner).max(1e-6);
    let out = [(tip[0] - inner[0]) / length, (tip[1] - inner[1]) / length];
    let near = |c: usize, side: usize| around(tip[c], half + 2.0, side);
    for y in near(1, height) {
        for x in near(0, width) {
            let d = [x as f32 - tip[0], y as f32 - tip[1]];
            let ahead = d[0] * out[0] + d[1] * out[1];
            if d[0].hypot(d[1]) < half + 2.0 && ahead > -0.5 {
                let cell = &mut cover[y * width + x];
                *cell = cell.min((0.5 - ahead).clamp(0.0, 1.0));
            }
        }
    }
}

/// The pixels of a row or column within `reach_px` of a place on it.
pub(crate) fn around(at: f32, reach_px: f32, side: usize) -> std::ops::Range<usize> {
    let [low, high] = [at - reach_px, at + reach_px + 1.0].map(|end| end.max(0.0) as usize);
    low..high.min(side)
}

/// Approximately normal: the sum of twelve uniform numbers.
pub(crate) fn normal(random: &mut SplitMix64) -> f32 {
    (0..12).map(|_| random.uniform_f32(-0.5, 0.5)).sum()
}

pub(crate) fn distance(a: Vec2, b: Vec2) -> f32 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Distance from `p` to the polyline.
pub(crate) fn distance_to(p: Vec2, line: &[Vec2]) -> f32 {
    line.windows(2)
        .map(|pair| {
            let (a, b) = (pair[0], pair[1]);
            let d = [b[0] - a[0], b[1] - a[1]];
            let square = (d[0] * d[0] + d[1] * d[1]).max(1e-12);
            let t = (((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / square).clamp(0.0, 1.0);
            distance(p, [a[0] + t * d[0], a[1] + t * d[1]])
        })
        .fold(f32::INFINITY, f32::min)
}

/// Deviation of a curve from the truth.
#[derive(Debug)]
pub(crate) struct Error {
    /// Mean distance of the curve's points from the true centerline.
    pub mean_px: f32,
    /// Maximum distance between a point and the true point with the same index.
    pub correspondence_px: f32,
    /// Error of the worse of the two ends.
    pub ends_px: f32,
}

/// Compares an open curve with the rope it should be, in the better direction.
pub(crate) fn error(curve: &Curve, rope: &Rope) -> Error {
    let mut truth = rope.truth(curve.points.len());
    let n = truth.len();
    let apart = |truth: &[Vec2]| -> f32 {
        curve
            .points
            .iter()
            .zip(truth)
            .map(|(&a, &b)| distance(a, b))
            .sum()
    };
    let ahead = apart(&truth);
    truth.reverse();
    if ahead < apart(&truth) {
        truth.reverse();
    }
    let pairs = || {
        curve
            .points
            .iter()
            .zip(&truth)
            .map(|(&a, &b)| distance(a, b))
    };
    let sum: f32 = curve
        .points
        .iter()
        .map(|&p| distance_to(p, &rope.points))
        .sum();
    Error {
        mean_px: sum / n as f32,
        correspondence_px: pairs().fold(0.0, f32::max),
        ends_px: distance(curve.points[0], truth[0])
            .max(distance(curve.points[n - 1], truth[n - 1])),
    }
}

/// Extracts from RGB bytes.
pub(crate) fn see<'a>(extractor: &'a mut Extractor, rgb: &[u8], table: &Table) -> Scene<'a> {
    let image = Image::new(
        rgb,
        table.width,
        table.height,
        3 * table.width,
        PixelFormat::Rgb8,
    );
    extractor.extract(&image.expect("the bytes are made for this size"))
}

pub(crate) fn extractor() -> Extractor {
    Extractor::new(Options::default()).expect("the default options are valid")
}
