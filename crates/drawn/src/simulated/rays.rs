//! Tubes in front of a camera, fast enough for a camera's frame rate: only pixels near a tube are
//! traced, by a few rays each.

use crate::space::{End, Eye, dot};

/// A round tube along a line of closely spaced points, cut off square at its ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tube<'a> {
    pub(super) line: &'a [[f64; 3]],
    pub(super) radius_mm: f64,
}

/// First hit of a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    /// Depth, mm.
    pub(super) depth_mm: f32,
    /// Light at the hit, 0 to 1; 1 for the table.
    pub(super) light: f32,
    /// Number of the tube; `None` for the table.
    pub(super) tube: Option<u8>,
}

/// Hits of the rays of all pixels near a tube: `SIDE` × `SIDE` rays per pixel, with `SIDE` at
/// most 3.
#[derive(Debug)]
pub(super) struct Rays<const SIDE: usize> {
    eye: Eye,
    /// Direction to the light, in the camera's frame.
    light: [f64; 3],
    /// Pixels near a tube.
    near: Vec<u32>,
    /// Index of each pixel among these; `FAR` if it is not near a tube.
    place: Vec<u32>,
    /// Hits of each of these pixels, row by row.
    hits: Vec<Hit>,
}

const FAR: u32 = u32::MAX;
/// Direction to the light, in the table's frame.
const LIGHT: [f64; 3] = [-0.36, 0.48, 0.8];

impl<const SIDE: usize> Rays<SIDE> {
    /// Number of rays per pixel.
    pub(super) const EACH: usize = SIDE * SIDE;

    pub(super) fn new(eye: &Eye) -> Self {
        let [width, height] = eye.size;
        Self {
            eye: *eye,
            light: [0, 1, 2].map(|k| dot(eye.rotation[k], LIGHT)),
            near: Vec::new(),
            place: vec![FAR; width * height],
            hits: Vec::new(),
        }
    }

    /// Returns the pixels near a tube, with the hits of their rays.
    pub(super) fn pixels(&self) -> impl Iterator<Item = (usize, &[Hit])> {
        let hits = self.hits.chunks_exact(Self::EACH);
        self.near.iter().map(|&pixel| pixel as usize).zip(hits)
    }

    /// Removes all tubes.
    pub(super) fn clear(&mut self) {
        for &pixel in &self.near {
            self.place[pixel as usize] = FAR;
        }
        self.near.clear();
        self.hits.clear();
    }

    /// Adds a tube with this number.
    pub(super) fn trace(&mut self, number: u8, tube: Tube) {
        let [first, second, .., before, last] = tube.line else {
            return;
        };
        let eye = self.eye;
        let ends = [End::of(*first, *second), End::of(*last, *before)].map(|end| end.seen_by(&eye));
        for &point in tube.line {
            let center = eye.see(point);
            if center[2] <= 2.0 * tube.radius_mm {
                continue;
            }
            let end = ends
                .iter()
                .find(|end| end.is_within(tube.radius_mm, center));
            self.ball(number, center, tube.radius_mm, end);
        }
    }

    /// Adds a ball, which is a piece of a tube.
    fn ball(&mut self, number: u8, center: [f64; 3], radius: f64, end: Option<&End>) {
        let [width, height] = self.eye.size;
        let at = self.eye.pixel(center);
        // The image of a ball off the axis is slightly longer than wide; half the diagonal of a
        // pixel is added.
        let reach = 1.05 * self.eye.focal_px[0] * radius / (center[2] - radius) + 0.75;
        let range = |at: f64, side: usize| {
            let [low, high] = [at - reach, at + reach + 1.0].map(|c| c.clamp(0.0, side as f64));
            low as usize..high as usize
        };
        let out = dot(center, center) - radius * radius;
        // Rays of the pixel (0, 0), and the step from one pixel's ray to the next one's.
        let begin: [[f64; 2]; 9] = std::array::from_fn(|k| {
            let [x, y, _] = ray::<SIDE>(&self.eye, 0, 0, k);
            [x, y]
        });
        let step = self.eye.focal_px.map(|focal| 1.0 / focal);
        for row in range(at[1], height) {
            for column in range(at[0], width) {
                let [dx, dy] = [column as f64 - at[0], row as f64 - at[1]];
                if dx * dx + dy * dy > reach * reach {
                    continue;
                }
                let first = self.rays_of(column, row);
                let moved = [column as f64 * step[0], row as f64 * step[1]];
                for (k, begin) in begin.iter().enumerate().take(Self::EACH) {
                    let [x, y] = [begin[0] + moved[0], begin[1] + moved[1]];
                    // |t ray − center|² = radius², the nearer one.
                    let along = x * center[0] + y * center[1] + center[2];
                    let square = x * x + y * y + 1.0;
                    let inside = along * along - square * out;
                    if inside < 0.0 {
                        continue;
                    }
                    let ray = [x, y, 1.0];
                    let root = inside.sqrt();
                    let near = (along - root) / square;
                    let mut depth = near;
                    if let Some(end) = end {
                        match end.cut(ray, [near, (along + root) / square]) {
                            Some(left) => depth = left,
                            None => continue,
                        }
                    }
                    let hit = &mut self.hits[first + k];
                    if depth as f32 >= hit.depth_mm {
                        continue;
                    }
                    let normal = match end {
                        Some(end) if depth > near => end.outward,
                        _ => [0, 1, 2].map(|k| (depth * ray[k] - center[k]) / radius),
                    };
                    *hit = Hit {
                        depth_mm: depth as f32,
                        light: dot(normal, self.light).max(0.0) as f32,
                        tube: Some(number),
                    };
                }
            }
        }
    }

    /// Index of the first ray of a pixel.
    fn rays_of(&mut self, column: usize, row: usize) -> usize {
        let pixel = row * self.eye.size[0] + column;
        if self.place[pixel] == FAR {
            self.place[pixel] = self.near.len() as u32;
            self.near.push(pixel as u32);
            for k in 0..Self::EACH {
                let ray = ray::<SIDE>(&self.eye, column, row, k);
                self.hits.push(Hit {
                    depth_mm: self.eye.table_depth(ray) as f32,
                    light: 1.0,
                    tube: None,
                });
            }
        }
        self.place[pixel] as usize * Self::EACH
    }
}

/// Ray number k of a pixel.
fn ray<const SIDE: usize>(eye: &Eye, column: usize, row: usize, k: usize) -> [f64; 3] {
    let within = |k: usize| (k as f64 + 0.5) / SIDE as f64 - 0.5;
    eye.ray([
        column as f64 + within(k % SIDE),
        row as f64 + within(k / SIDE),
    ])
}
