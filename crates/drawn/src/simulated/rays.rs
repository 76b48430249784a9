//! Tubes before a camera, fast enough for a camera's rate: only pixels near a tube are looked at, by a few rays each.

use crate::space::{End, Eye, dot};

/// A round tube along a line whose points lie close to each other, cut off square at its ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tube<'a> {
    pub(super) line: &'a [[f64; 3]],
    pub(super) radius_mm: f64,
}

/// What a ray meets first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    /// How far ahead, mm.
    pub(super) depth_mm: f32,
    /// How much light falls there, 0 to 1; of the table 1.
    pub(super) light: f32,
    /// Which tube it is; `None` for the table.
    pub(super) tube: Option<u8>,
}

/// What the rays of all pixels near a tube meet: `SIDE` × `SIDE` rays a pixel, 3 at most.
#[derive(Debug)]
pub(super) struct Rays<const SIDE: usize> {
    eye: Eye,
    /// From where light comes, in the camera's frame.
    light: [f64; 3],
    /// The pixels near a tube.
    near: Vec<u32>,
    /// Of each pixel, its place among these; `FAR` if it is none.
    place: Vec<u32>,
    /// Of each of these its rays, row by row.
    hits: Vec<Hit>,
}

const FAR: u32 = u32::MAX;
/// From where light comes, in the table's frame.
const LIGHT: [f64; 3] = [-0.36, 0.48, 0.8];

impl<const SIDE: usize> Rays<SIDE> {
    /// How many rays a pixel has.
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

    /// The pixels near a tube, and what their rays meet.
    pub(super) fn pixels(&self) -> impl Iterator<Item = (usize, &[Hit])> {
        let hits = self.hits.chunks_exact(Self::EACH);
        self.near.iter().map(|&pixel| pixel as usize).zip(hits)
    }

    /// Forgets all tubes.
    pub(super) fn clear(&mut self) {
        for &pixel in &self.near {
            self.place[pixel as usize] = FAR;
        }
        self.near.clear();
        self.hits.clear();
    }

    /// Adds a tube, under this number.
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

    /// A piece of a tube is a ball.
    fn ball(&mut self, number: u8, center: [f64; 3], radius: f64, end: Option<&End>) {
        let [width, height] = self.eye.size;
        let at = self.eye.pixel(center);
        // A ball beside the axis is seen a little longer than wide; and half a pixel's diagonal.
        let reach = 1.05 * self.eye.focal_px[0] * radius / (center[2] - radius) + 0.75;
        let range = |at: f64, side: usize| {
            let [low, high] = [at - reach, at + reach + 1.0].map(|c| c.clamp(0.0, side as f64));
            low as usize..high as usize
        };
        let out = dot(center, center) - radius * radius;
        // The rays of the pixel (0, 0), and the way from a pixel's to the next one's.
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

    /// Where a pixel's rays begin.
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

/// The k-th ray of a pixel.
fn ray<const SIDE: usize>(eye: &Eye, column: usize, row: usize, k: usize) -> [f64; 3] {
    let within = |k: usize| (k as f64 + 0.5) / SIDE as f64 - 0.5;
    eye.ray([
        column as f64 + within(k % SIDE),
        row as f64 + within(k / SIDE),
    ])
}
