//! A rope's points in space.

use super::image::DepthImage;
use super::pair::DepthCamera;
use thiserror::Error;

/// Points between those at which a rope is looked for along the whole ray.
const ANCHOR_STEP: usize = 6;
/// A rope rises no more steeply than this against the ray's side, mm ahead for each aside.
const STEEPEST: f64 = 4.0;
/// Of a rope's half width, how much is read; and an edge's pixels, which see both sides of it, px.
const INNER: f64 = 0.8;
const EDGE_PX: f64 = 0.8;
/// Depth pixels across and along that are read at a point, at most.
const ACROSS: usize = 9;
const ALONG: usize = 8;
/// A rope is thinner than can be told if fewer depth pixels than this lie across it.
const THINNEST_PX: f64 = 3.0;
/// How far off depth may be, in mm, for each mm from where it was measured last.
const ASTRAY: f64 = 0.12;
/// The share of pixels that are read by one sample alone: places a pixel apart along the rope fall on the same one here and there.
const READ_ONCE: f64 = 0.75;
/// So many third differences are needed to judge noise by; their median is this where they are normal, of variance 1; and noise is taken for
/// at most so many times what the sensor's model says.
const LEAST_TO_DOUBT: usize = 10;
const MEDIAN_OF_NORMAL: f64 = 0.6745;
const MOST_DOUBT: f64 = 8.0;
/// Of the radius: how much of it is taken for wrong, as widths are.
const RADIUS_ERROR: f64 = 0.02;

/// A rope in the colour image.
#[derive(Debug, Clone, Copy)]
pub struct SeenRope<'a> {
    /// Points of its centerline in their order, px.
    pub points: &'a [[f32; 2]],
    /// Its width at each, px.
    pub widths_px: &'a [f32],
    /// Whether something else is seen at each of them: another strand, or a hand.
    pub hidden: &'a [bool],
    /// Whether the first comes after the last.
    pub closed: bool,
}

/// A point of a rope's axis in space, in the colour camera's frame: x right, y down, z ahead, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpacePoint {
    /// Where it is.
    pub point: [f64; 3],
    /// Its derivative by the pixel, mm/px.
    pub by_pixel: [[f64; 2]; 3],
    /// Its derivative by the depth: along the ray.
    pub ray: [f64; 3],
    /// The variance of the depth, mm².
    pub variance: f64,
    /// Whether it was measured here; otherwise it is bridged from where it was.
    pub is_measured: bool,
    /// The rope's width there, mm.
    pub width_mm: f64,
}

/// Why a rope has no place in space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NoDepth {
    /// Points or widths are missing, or too few.
    #[error("a rope in space needs 8 points or more, each with its width and whether it is hidden")]
    Points,
    /// A point lies where the lens's model ends.
    #[error("a point of the rope lies where the colour camera's lens model is not one-to-one")]
    Lens,
    /// Too little of it was measured.
    #[error(
        "of the rope's {points} points {measured} have a depth, too few for the others: look whether the depth camera sees it, whether \
         its range fits, and whether its pose beside the colour camera is right"
    )]
    Unmeasured {
        /// How many were measured.
        measured: usize,
        /// Of how many.
        points: usize,
    },
    /// It is too thin.
    #[error(
        "the rope is {pixels} depth pixels wide, too thin to tell it from what is behind: go nearer"
    )]
    Thin {
        /// Whole pixels.
        pixels: usize,
    },
}

/// What is known of a point on the way.
#[derive(Debug, Clone, Copy, Default)]
struct Axis {
    /// The ray in the colour camera's frame, its derivative by the pixel, and the ray in the depth camera's frame.
    ray: [f64; 3],
    by_pixel: [[f64; 2]; 2],
    turned: [f64; 3],
    /// The colour camera's depth of the axis.
    depth: f64,
    /// Half of the width in the colour image by the focal length: times the depth it is the radius.
    slim: f64,
    /// Where the axis is in the depth image, and how far ahead there.
    at: [f64; 2],
    ahead: f64,
    variance: f64,
    is_measured: bool,
}

/// Finds ropes in depth images; keeps its room.
#[derive(Debug, Clone)]
pub struct RopeDepth {
    camera: DepthCamera,
    axes: Vec<Axis>,
    anchors: Vec<(usize, f64)>,
    /// For the best chain through the anchors: how many are in it up to each, and the one before.
    chain: Vec<(usize, usize)>,
    row: Vec<f64>,
    samples: Vec<f64>,
    places: Vec<SpacePoint>,
}

impl RopeDepth {
    /// For a pair of cameras.
    pub fn new(camera: DepthCamera) -> Self {
        Self {
            camera,
            axes: Vec::new(),
            anchors: Vec::new(),
            chain: Vec::new(),
            row: Vec::new(),
            samples: Vec::with_capacity(ACROSS * ALONG),
            places: Vec::new(),
        }
    }

    /// Where the points of a rope are.
    ///
    /// # Errors
    /// They are nowhere, or too few of them are known.
    pub fn locate(
        &mut self,
        image: &DepthImage,
        rope: &SeenRope,
    ) -> Result<&[SpacePoint], NoDepth> {
        let count = rope.points.len();
        if count < 8 || rope.widths_px.len() != count || rope.hidden.len() != count {
            return Err(NoDepth::Points);
        }
        self.aim(rope)?;
        self.find(image, rope);
        if self.anchors.len() < 2 {
            return Err(self.unmeasured());
        }
        self.join();
        self.read(image, rope, Reading::Glance);
        self.settle();
        self.read(image, rope, Reading::Whole);
        let measured = self.axes.iter().filter(|axis| axis.is_measured).count();
        if 3 * measured < count {
            let wide = self.axes.iter().map(|axis| self.half_width_px(axis));
            let pixels = 2.0 * wide.sum::<f64>() / count as f64;
            return Err(match pixels < THINNEST_PX {
                true => NoDepth::Thin {
                    pixels: pixels as usize,
                },
                false => self.unmeasured(),
            });
        }
        self.doubt();
        self.bridge();
        self.write();
        Ok(&self.places)
    }

    fn unmeasured(&self) -> NoDepth {
        NoDepth::Unmeasured {
            measured: self.axes.iter().filter(|axis| axis.is_measured).count(),
            points: self.axes.len(),
        }
    }

    /// The rays of the points.
    fn aim(&mut self, rope: &SeenRope) -> Result<(), NoDepth> {
        let focal = self.camera.color.focal_px();
        let focal = (focal[0] * focal[1]).sqrt();
        self.axes.clear();
        for (pixel, width) in rope.points.iter().zip(rope.widths_px) {
            let (ray, by_pixel) = self.camera.ray(pixel.map(f64::from)).ok_or(NoDepth::Lens)?;
            self.axes.push(Axis {
                ray,
                by_pixel,
                turned: self.camera.turned(ray),
                slim: 0.5 * f64::from(*width) / focal,
                ..Axis::default()
            });
        }
        // Widths err by themselves; a rope's does not change from one point to the next.
        let count = self.axes.len();
        self.row.clear();
        self.row.extend(self.axes.iter().map(|axis| axis.slim));
        for i in 0..count {
            let around = &self.row[i.saturating_sub(4)..(i + 5).min(count)];
            self.axes[i].slim = around.iter().sum::<f64>() / around.len() as f64;
        }
        Ok(())
    }

    /// Walks some of the rays, and keeps the longest chain of what is found that a rope can be.
    fn find(&mut self, image: &DepthImage, rope: &SeenRope) {
        self.anchors.clear();
        for i in (ANCHOR_STEP / 2..self.axes.len()).step_by(ANCHOR_STEP) {
            if !rope.hidden[i]
                && let Some(depth) = self.walk(image, &self.axes[i])
            {
                self.anchors.push((i, depth));
            }
        }
        self.chain.clear();
        for k in 0..self.anchors.len() {
            let before = (0..k).filter(|&j| self.can_follow(self.anchors[j], self.anchors[k]));
            let best = before.max_by_key(|&j| self.chain[j].0);
            self.chain
                .push(best.map_or((1, usize::MAX), |j| (self.chain[j].0 + 1, j)));
        }
        let Some(mut at) = (0..self.chain.len()).max_by_key(|&k| self.chain[k].0) else {
            return;
        };
        let mut kept = self.chain[at].0;
        let whole = kept;
        while kept > 0 {
            kept -= 1;
            self.anchors[kept] = self.anchors[at];
            at = self.chain[at].1;
        }
        self.anchors.truncate(whole);
    }

    /// Whether the rope can rise from one place to the other.
    fn can_follow(&self, (i, a): (usize, f64), (j, b): (usize, f64)) -> bool {
        let way = |k: usize| self.axes[k].ray;
        let aside = length(way(i)[0] - way(j)[0], way(i)[1] - way(j)[1]) * a.min(b);
        (a - b).abs() < STEEPEST * aside + 6.0 * self.camera.sigma_mm(a.max(b))
    }

    /// The first place along a ray where what is measured is where the ray is: the colour camera's depth of the rope's axis.
    fn walk(&self, image: &DepthImage, axis: &Axis) -> Option<f64> {
        let [near, far] = self.camera.range_mm;
        let ends = [near, far].map(|depth| self.camera.pixel(self.place(axis, depth)));
        let [Some(first), Some(last)] = ends else {
            return None;
        };
        let steps = length(first[0] - last[0], first[1] - last[1])
            .ceil()
            .max(1.0);
        let step = (1.0 / near - 1.0 / far) / steps;
        for k in 0..=steps as usize {
            let depth = 1.0 / (1.0 / near - k as f64 * step);
            let place = self.place(axis, depth);
            let Some([x, y]) = self.camera.pixel(place) else {
                continue;
            };
            let Some(measured) = image.at(pixel(x), pixel(y)) else {
                continue;
            };
            // Of one step a ray looks along all its depths where it is a point in the image.
            let reach = match steps as usize {
                1 => far,
                _ => 0.75 * step * depth * depth,
            };
            if (measured - place[2]).abs() < reach + 3.0 * self.camera.sigma_mm(measured) {
                let depth = self.depth(axis, measured);
                return Some(depth * (1.0 + axis.slim));
            }
        }
        None
    }

    /// What is at such a depth of the colour camera along a point's ray, in the depth camera's frame.
    fn place(&self, axis: &Axis, depth: f64) -> [f64; 3] {
        [0, 1, 2].map(|k| depth * axis.turned[k] + self.camera.translation[k])
    }

    /// The colour camera's depth of what is so far ahead of the depth camera along a point's ray.
    fn depth(&self, axis: &Axis, ahead: f64) -> f64 {
        (ahead - self.camera.translation[2]) / axis.turned[2]
    }

    /// Depths between the anchors.
    fn join(&mut self) {
        let mut k = 0;
        for i in 0..self.axes.len() {
            while k + 2 < self.anchors.len() && self.anchors[k + 1].0 < i {
                k += 1;
            }
            let [(from, a), (to, b)] = [self.anchors[k], self.anchors[k + 1]];
            let share = (i as f64 - from as f64) / (to - from) as f64;
            self.axes[i].depth = a + share.clamp(0.0, 1.0) * (b - a);
        }
    }

    /// Takes the medians of five neighbors for the depths.
    fn settle(&mut self) {
        let count = self.axes.len();
        self.row.clear();
        self.row.extend(self.axes.iter().map(|axis| axis.depth));
        for i in 2..count - 2 {
            let mut five: [f64; 5] = std::array::from_fn(|k| self.row[i + k - 2]);
            five.sort_unstable_by(f64::total_cmp);
            self.axes[i].depth = five[2];
        }
    }

    /// Half of the rope's width in the depth image.
    fn half_width_px(&self, axis: &Axis) -> f64 {
        let focal = self.camera.depth.focal_px();
        axis.slim * (focal[0] * focal[1]).sqrt() * axis.depth / axis.ahead.max(1.0)
    }

    /// Reads the depth image around each point, where it is known roughly.
    fn read(&mut self, image: &DepthImage, rope: &SeenRope, reading: Reading) {
        let count = self.axes.len();
        for i in 0..count {
            let place = self.place(&self.axes[i], self.axes[i].depth);
            let axis = &mut self.axes[i];
            axis.ahead = place[2];
            // Outside of its image nothing is read.
            axis.at = self.camera.pixel(place).unwrap_or([-1e6; 2]);
        }
        for i in 0..count {
            let found = match rope.hidden[i] {
                true => None,
                false => self.around(image, rope, i, reading),
            };
            let axis = &mut self.axes[i];
            axis.is_measured = found.is_some();
            if let Some((ahead, variance)) = found {
                let turned = axis.turned[2];
                axis.depth = (ahead - self.camera.translation[2]) / turned;
                axis.variance = variance / (turned * turned);
            }
        }
    }

    /// How far ahead of the depth camera the axis is at a point, by what is measured around it; and its variance.
    fn around(
        &mut self,
        image: &DepthImage,
        rope: &SeenRope,
        i: usize,
        reading: Reading,
    ) -> Option<(f64, f64)> {
        let count = self.axes.len();
        let [before, after] = match rope.closed {
            true => [(i + count - 1) % count, (i + 1) % count],
            false => [i.saturating_sub(1), (i + 1).min(count - 1)],
        };
        let (a, b, axis) = (&self.axes[before], &self.axes[after], &self.axes[i]);
        let way = [b.at[0] - a.at[0], b.at[1] - a.at[1]];
        let far = length(way[0], way[1]);
        if !(far > 1e-3 && far < 1e3) {
            return None;
        }
        let along = way.map(|c| c / far);
        let slope = (b.ahead - a.ahead) / far;
        let steps = if before == i || after == i { 1.0 } else { 2.0 };
        let half_step = 0.5 * far / steps;
        let focal = self.camera.depth.focal_px();
        let mm_per_px = axis.ahead / (focal[0] * focal[1]).sqrt();
        let radius = axis.slim * axis.depth;
        let half = radius / mm_per_px;
        // At least the pixel on the axis; but of a rope that is no wider than that there is none without an edge.
        let inner = (INNER * half).min(half - EDGE_PX);
        if inner < 0.5 * (THINNEST_PX - 2.0 * EDGE_PX) - 0.5 || half < 0.5 * THINNEST_PX {
            return None;
        }
        let inner = inner.max(0.5);
        // The rope goes as far ahead as it goes along: its direction against the ray.
        let (ahead_way, aside) = (b.ahead - a.ahead, far * mm_per_px);
        let sine = aside / length(ahead_way, aside);
        let sigma = length(self.camera.sigma_mm(axis.ahead), image.rounding_mm());
        let gate = match reading {
            Reading::Glance => 6.0 * radius + 5.0 * sigma + STEEPEST * 3.0 * half_step * mm_per_px,
            Reading::Whole => radius + 5.0 * sigma,
        };
        let (across, lengthwise) = match reading {
            Reading::Glance => (1, 1),
            Reading::Whole => (
                (inner as usize).min(ACROSS / 2),
                (2.0 * half_step).round().clamp(1.0, ALONG as f64) as usize,
            ),
        };
        // At a tip only the rope's side is read.
        let (first, last) = match (rope.closed, i) {
            (false, 0) => (0.5, half_step + 1.0),
            (false, _) if i + 1 == count => (-half_step - 1.0, -0.5),
            _ => (-half_step, half_step),
        };
        self.samples.clear();
        let mut previous = [isize::MIN; 2];
        for step in 0..lengthwise {
            let share = (step as f64 + 0.5) / lengthwise as f64;
            let on = first + share * (last - first);
            for beside in 0..=2 * across {
                let off = beside as f64 - across as f64;
                let wanted = [
                    axis.at[0] + on * along[0] - off * along[1],
                    axis.at[1] + on * along[1] + off * along[0],
                ];
                let pixel = wanted.map(pixel);
                if pixel == previous {
                    continue;
                }
                previous = pixel;
                let from = [0, 1].map(|k| pixel[k] as f64 - axis.at[k]);
                let off = from[1] * along[0] - from[0] * along[1];
                let on = from[0] * along[0] + from[1] * along[1];
                if off.abs() > inner {
                    continue;
                }
                let Some(measured) = image.at(pixel[0], pixel[1]) else {
                    continue;
                };
                let beside_mm = off * mm_per_px;
                let rise = (radius * radius - beside_mm * beside_mm).max(0.0).sqrt() / sine;
                let ahead = measured + rise - slope * on;
                if (ahead - axis.ahead).abs() < gate {
                    self.samples.push(ahead);
                }
            }
        }
        middle(&mut self.samples, sigma).map(|(ahead, variance)| {
            let off = RADIUS_ERROR * radius / sine;
            (ahead, variance + off * off)
        })
    }

    /// Raises the variances to what third differences along the rope show: the noise of a depth image's neighbors is not
    /// independent, and no model says by how much. A rope's own shape has next to none.
    fn doubt(&mut self) {
        self.row.clear();
        for seven in self.axes.windows(7) {
            // Every second point, as those beside each other share pixels' noise.
            let four = [0, 2, 4, 6].map(|k| &seven[k]);
            if four.iter().all(|axis| axis.is_measured) {
                let weights = [-1.0, 3.0, -3.0, 1.0];
                let sum = |of: fn(&Axis, f64) -> f64| -> f64 {
                    four.iter().zip(weights).map(|(axis, w)| of(axis, w)).sum()
                };
                let difference = sum(|axis, w| w * axis.depth);
                let variance = sum(|axis, w| w * w * axis.variance);
                self.row.push(difference.abs() / variance.sqrt());
            }
        }
        let count = self.row.len();
        if count < LEAST_TO_DOUBT {
            return;
        }
        let (_, median, _) = self.row.select_nth_unstable_by(count / 2, f64::total_cmp);
        let off = (*median / MEDIAN_OF_NORMAL).clamp(1.0, MOST_DOUBT);
        for axis in &mut self.axes {
            axis.variance *= off * off;
        }
    }

    /// Depth where it was not measured: straight between, and on from, where it was.
    fn bridge(&mut self) {
        let count = self.axes.len();
        let mut i = 0;
        while i < count {
            if self.axes[i].is_measured {
                i += 1;
                continue;
            }
            let end = (i..count)
                .find(|&k| self.axes[k].is_measured)
                .unwrap_or(count);
            let before = (0..i).rev().find(|&k| self.axes[k].is_measured);
            let after = (end < count).then_some(end);
            for k in i..end {
                let (depth, variance) = match (before, after) {
                    (Some(a), Some(b)) => {
                        let share = (k - a) as f64 / (b - a) as f64;
                        let [a, b] = [&self.axes[a], &self.axes[b]];
                        let way = self.aside(a, k).min(self.aside(b, k));
                        (
                            a.depth + share * (b.depth - a.depth),
                            a.variance.max(b.variance) + ASTRAY * ASTRAY * way * way,
                        )
                    }
                    (Some(a), None) | (None, Some(a)) => {
                        let axis = &self.axes[a];
                        let way = 2.0 * self.aside(axis, k);
                        (axis.depth, axis.variance + ASTRAY * ASTRAY * way * way)
                    }
                    (None, None) => return,
                };
                (self.axes[k].depth, self.axes[k].variance) = (depth, variance);
            }
            i = end;
        }
    }

    /// How far point `k` is aside of another, mm.
    fn aside(&self, axis: &Axis, k: usize) -> f64 {
        let other = self.axes[k].ray;
        length(axis.ray[0] - other[0], axis.ray[1] - other[1]) * axis.depth
    }

    fn write(&mut self) {
        self.places.clear();
        self.places.extend(self.axes.iter().map(|axis| {
            let [x, y] = axis.by_pixel;
            SpacePoint {
                point: axis.ray.map(|c| axis.depth * c),
                by_pixel: [
                    x.map(|d| axis.depth * d),
                    y.map(|d| axis.depth * d),
                    [0.0; 2],
                ],
                ray: axis.ray,
                variance: axis.variance,
                is_measured: axis.is_measured,
                width_mm: 2.0 * axis.slim * axis.depth,
            }
        }));
    }
}

/// How closely a depth image is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reading {
    /// A few pixels at each point, wherever they are within reach.
    Glance,
    /// All of the rope's inside.
    Whole,
}

fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// The pixel nearest to a place; far to the left or above, none of the image. Without the call that `round` is.
#[inline]
fn pixel(place: f64) -> isize {
    (place + 4096.5) as isize - 4096
}

/// The middle of what is measured, and its variance; none of nothing.
fn middle(samples: &mut [f64], sigma: f64) -> Option<(f64, f64)> {
    let count = samples.len();
    if count == 0 {
        return None;
    }
    let (_, &mut median, _) = samples.select_nth_unstable_by(count / 2, f64::total_cmp);
    let near = || {
        samples
            .iter()
            .filter(|&&s| (s - median).abs() < 2.5 * sigma)
    };
    let inside = near().count().max(1) as f64;
    let mean = near().sum::<f64>() / inside;
    let mean = if near().count() == 0 { median } else { mean };
    let spread = near().map(|s| (s - mean) * (s - mean)).sum::<f64>() / (inside - 1.0).max(1.0);
    Some((mean, spread.max(sigma * sigma) / (READ_ONCE * inside)))
}
