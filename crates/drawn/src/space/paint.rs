//! Ray tracing of a tube and its table: first hits, and the picture in color.

use super::eye::{Eye, dot};
use super::rope::LiftedRope;
use crate::rendered::mottling::Mottling;
use lariat_portable::SplitMix64;

/// Number of rays along a pixel's side, in color.
const RAYS: usize = 4;
/// Direction to the light, in the table's frame.
const LIGHT: [f64; 3] = [0.36, 0.48, 0.8];

/// First hit of a ray: its depth in mm and, if the hit is on the rope, the light there from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    pub depth: f64,
    pub light: Option<f32>,
}

/// Hits of the rays through the pixels.
pub(super) struct Hits {
    /// Number of rays along a pixel's side.
    rays: usize,
    eye: Eye,
    /// Index of the first ray of each pixel near the rope; the rays follow row by row.
    places: Vec<Option<u32>>,
    hits: Vec<Hit>,
}

impl Hits {
    /// Makes the hits of a table without a rope.
    pub(super) fn new(eye: &Eye, rays: usize) -> Self {
        Self {
            rays,
            eye: *eye,
            places: vec![None; eye.size[0] * eye.size[1]],
            hits: Vec::new(),
        }
    }

    /// Returns the hits of a pixel's rays; `None` if the rope is not near them.
    pub(super) fn near_rope(&self, [x, y]: [usize; 2]) -> Option<&[Hit]> {
        let place = self.places[y * self.eye.size[0] + x]? as usize;
        Some(&self.hits[place..place + self.rays * self.rays])
    }

    /// Returns the hits of a pixel's rays without a rope.
    pub(super) fn of_table(&self, [x, y]: [usize; 2]) -> Vec<Hit> {
        let rays = self.rays;
        let ray = |k: usize| self.ray([rays * x + k % rays, rays * y + k / rays]);
        (0..rays * rays).map(|k| self.table(ray(k))).collect()
    }

    /// Returns the hit of a ray near a rope.
    fn of(&mut self, [column, row]: [usize; 2]) -> &mut Hit {
        let rays = self.rays;
        let [x, y] = [column / rays, row / rays];
        let pixel = y * self.eye.size[0] + x;
        let place = match self.places[pixel] {
            Some(place) => place as usize,
            None => {
                let place = self.hits.len();
                let table = self.of_table([x, y]);
                self.hits.extend(table);
                self.places[pixel] = Some(place as u32);
                place
            }
        };
        &mut self.hits[place + row % rays * rays + column % rays]
    }

    /// Ray at a column and a row of rays.
    fn ray(&self, place: [usize; 2]) -> [f64; 3] {
        let pixel = |k: usize| (k as f64 + 0.5) / self.rays as f64 - 0.5;
        self.eye.ray(place.map(pixel))
    }

    fn table(&self, ray: [f64; 3]) -> Hit {
        Hit {
            depth: self.eye.table_depth(ray),
            light: None,
        }
    }
}

/// Computes the hits of `rays` × `rays` rays for each pixel.
pub(super) fn hits(rope: &LiftedRope, eye: &Eye, rays: usize) -> Hits {
    let [width, height] = eye.size.map(|side| side * rays);
    let mut hits = Hits::new(eye, rays);
    let light = [0, 1, 2].map(|k| dot(eye.rotation[k], LIGHT));
    let radius = rope.radius_mm;
    let ends = rope.ends().map(|end| end.seen_by(eye));
    for &point in &rope.points {
        let center = eye.see(point);
        // The end is cut off square.
        let end = ends.iter().find(|end| end.is_within(radius, center));
        let at = eye.pixel(center);
        let reach = 1.05 * eye.focal_px[0] * radius / (center[2] - radius) + 1.0;
        let range = |at: f64, side: usize| {
            let ray = |px: f64| ((px + 0.5) * rays as f64).clamp(0.0, side as f64) as usize;
            ray(at - reach)..ray(at + reach)
        };
        for row in range(at[1], height) {
            for column in range(at[0], width) {
                let ray = hits.ray([column, row]);
                // |t ray − center|² = radius², the nearer one.
                let (along, square) = (dot(ray, center), dot(ray, ray));
                let inside = along * along - square * (dot(center, center) - radius * radius);
                if inside < 0.0 {
                    continue;
                }
                let near = (along - inside.sqrt()) / square;
                let mut depth = near;
                if let Some(end) = end {
                    let far = (along + inside.sqrt()) / square;
                    match end.cut(ray, [near, far]) {
                        Some(left) => depth = left,
                        None => continue,
                    }
                }
                let hit = hits.of([column, row]);
                if depth < hit.depth {
                    let normal = match end {
                        Some(end) if depth > near => end.outward,
                        _ => [0, 1, 2].map(|k| (depth * ray[k] - center[k]) / radius),
                    };
                    hit.depth = depth;
                    hit.light = Some(dot(normal, light).max(0.0) as f32);
                }
            }
        }
    }
    hits
}

/// Draws a rope and a table in color, three bytes per pixel. The seed determines their colors and
/// the noise.
pub fn picture(rope: &LiftedRope, eye: &Eye, seed: u64) -> Vec<u8> {
    Painter::new(seed).picture(rope, eye)
}

/// Table and rope color for a series of pictures, which differ in the rope's shape and in the
/// noise.
#[derive(Debug, Clone)]
pub struct Painter {
    ground: [f32; 3],
    colour: [f32; 3],
    mottling: Mottling<32>,
    random: SplitMix64,
    /// Color of the table at each pixel, as this camera sees it.
    table: Option<(Eye, Vec<[f32; 3]>)>,
    /// Noise of the first picture. Later pictures use the same noise from a random start.
    noise: Vec<[f32; 3]>,
}

impl Painter {
    /// Makes the colors of a seed.
    pub fn new(seed: u64) -> Self {
        let mut random = SplitMix64::of_stream(seed, 1);
        let (ground, colour) = colours(&mut random);
        Self {
            ground,
            colour,
            mottling: Mottling::new(&mut random),
            random,
            table: None,
            noise: Vec::new(),
        }
    }

    /// Draws the next picture, three bytes per pixel.
    pub fn picture(&mut self, rope: &LiftedRope, eye: &Eye) -> Vec<u8> {
        let [width, height] = eye.size;
        let hits = hits(rope, eye, RAYS);
        let share = 1.0 / (RAYS * RAYS) as f32;
        let mut rgb = Vec::with_capacity(3 * width * height);
        let table = match self.table.take() {
            Some((of, table)) if of == *eye => table,
            _ => self.table(eye),
        };
        let count = width * height;
        let begin = match self.noise.len() == count {
            true => self.random.below(count),
            false => {
                let normal = |_| [0; 3].map(|_| 2.0 * self.random.normal() as f32);
                self.noise = (0..count).map(normal).collect();
                0
            }
        };
        let noise = self.noise[begin..].iter().chain(&self.noise);
        let mut noise = noise.copied();
        for y in 0..height {
            for x in 0..width {
                let ground = table[y * width + x];
                let rope = |light: f32| self.colour.map(|c| c * (0.55 + 0.45 * light));
                let seen = match hits.near_rope([x, y]) {
                    Some(near) => near.iter().fold([0.0; 3], |sum: [f32; 3], hit| {
                        let seen = hit.light.map_or(ground, rope);
                        [0, 1, 2].map(|c| sum[c] + share * seen[c])
                    }),
                    None => ground,
                };
                let noise = noise.next().unwrap_or_default();
                rgb.extend([0, 1, 2].map(|c| (seen[c] + noise[c] + 0.5).clamp(0.0, 255.0) as u8));
            }
        }
        self.table = Some((*eye, table));
        rgb
    }

    /// Color of the table at each pixel.
    fn table(&self, eye: &Eye) -> Vec<[f32; 3]> {
        let [width, height] = eye.size;
        let at = |i: usize| {
            let ray = eye.ray([(i % width) as f64, (i / width) as f64]);
            let place = eye.on_table(ray, eye.table_depth(ray)).map(|c| c + 2000.0);
            let pattern = 1.0 + 0.02 * self.mottling.at(place, [1.0 / 40.0, 1.0 / 13.0]) as f32;
            self.ground.map(|c| c * pattern)
        };
        (0..width * height).map(at).collect()
    }
}

/// Colors of a light table with a dark rope, or of a dark table with a light rope.
fn colours(random: &mut SplitMix64) -> ([f32; 3], [f32; 3]) {
    let tint = |random: &mut SplitMix64, level: f32, most: f32| {
        [0; 3].map(|_| level + random.uniform_f32(-most, most))
    };
    let (light, dark) = (
        random.uniform_f32(170.0, 215.0),
        random.uniform_f32(35.0, 70.0),
    );
    if random.unit() < 0.5 {
        (tint(random, light, 12.0), tint(random, dark, 25.0))
    } else {
        (tint(random, dark, 12.0), tint(random, light, 25.0))
    }
}
