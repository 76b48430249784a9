//! A rope's points in space.

mod ends;
mod reading;
mod unsure;

use super::image::DepthImage;
use super::pair::DepthCamera;
use reading::Reading;
use thiserror::Error;

/// Points between those at which a rope is looked for along the whole ray.
const ANCHOR_STEP: usize = 6;
/// A rope rises no more steeply than this against the ray's side, mm ahead for each aside.
const STEEPEST: f64 = 4.0;
/// A rope is thinner than can be told if fewer depth pixels than this lie across it.
const THINNEST_PX: f64 = 3.0;

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
    /// Whether its first and its last end are seen: not where it leaves the image, or goes on under something.
    pub ends: [bool; 2],
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
    /// The same before an end was cut off.
    before: Vec<SpacePoint>,
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
            samples: Vec::new(),
            places: Vec::new(),
            before: Vec::new(),
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
        self.cut_ends(rope.ends);
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

fn length(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// The pixel nearest to a place; far to the left or above, none of the image. Without the call that `round` is.
#[inline]
fn pixel(place: f64) -> isize {
    (place + 4096.5) as isize - 4096
}
