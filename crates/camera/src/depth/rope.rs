//! Locates a rope's points in 3-D by a depth image.

mod anchors;
mod floats;
mod glance;
mod inside;
mod places;
mod reading;
mod relief;
mod sections;
mod unsure;

use super::image::DepthImage;
use super::pair::DepthCamera;
use crate::space::{SeenRope, Sight, SpacePoint, cut_ends, length, sight};
use inside::Pixels;
use lariat_portable::Arch;
use reading::{SECTION_STEP, Sampling};
use sections::Course;
use thiserror::Error;

/// Maximum slope of a rope, in mm ahead per mm to the side of the ray.
const STEEPEST: f64 = 4.0;
/// The places that are read must be centered on the rope to within this share of its half width. If
/// they are off by more, the centerline may be off by `ASIDE` times the excess.
const NOT_ASIDE: f64 = 0.15;
const ASIDE: f64 = 2.0;
/// Maximum relative difference between a rope's radius and its median.
const UNEVEN: f64 = 0.1;
/// If too little of a rope is measured, it is reported as too thin below this width, in depth
/// pixels.
const THINNEST_PX: f64 = 3.0;

/// Why a rope could not be located in 3-D.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NoDepth {
    /// Points or widths are missing or too few.
    #[error("a rope in space needs 8 points or more, each with its width and whether it is hidden")]
    Points,
    /// A point is beyond the lens model.
    #[error("a point of the rope lies where the colour camera's lens model is not one-to-one")]
    Lens,
    /// Too few points were measured.
    #[error(
        "of the rope's {points} points {measured} have a depth, too few for the others: look whether the depth camera sees it, whether \
         its range fits, and whether its pose beside the colour camera is right"
    )]
    Unmeasured {
        /// Number of measured points.
        measured: usize,
        /// Number of all points.
        points: usize,
    },
    /// The depth image does not show the rope.
    #[error(
        "the depth image shows no rope where the colour image has one, only what it lies on: look whether it is of the same moment, \
         and whether the depth camera sees this rope at all (black and shiny ones it may not)"
    )]
    Flat,
    /// The rope is too thin.
    #[error(
        "the rope is {pixels} depth pixels wide, too thin to tell it from what is behind: go nearer"
    )]
    Thin {
        /// Width in whole pixels.
        pixels: usize,
    },
}

/// Data of a point on the rope.
#[derive(Debug, Clone, Copy, Default)]
struct Axis {
    /// Ray in the depth camera's frame.
    turned: [f64; 3],
    /// Depth of the axis in the color camera's frame.
    depth: f64,
    /// Half of the rope's width divided by its depth. Multiplied by a depth, it is the radius.
    slim: f64,
    variance: f64,
    is_measured: bool,
    /// Distance from the middle of the rope in the depth image, in half widths of the rope.
    beside: f64,
}

/// Locates ropes in depth images, and reuses its buffers.
#[derive(Debug, Clone)]
pub struct RopeDepth {
    camera: DepthCamera,
    sights: Vec<Sight>,
    axes: Vec<Axis>,
    anchors: Vec<(usize, f64)>,
    /// The best chain that ends at each anchor: its number of anchors, and the anchor before its
    /// last.
    chain: Vec<(usize, usize)>,
    row: Vec<f64>,
    /// Points around which the depth image is read.
    sections: Vec<usize>,
    course: Course,
    pixels: Box<Pixels>,
    arch: Arch,
    /// The depth camera's focal length, px: the geometric mean of its two.
    focal_px: f64,
    places: Vec<SpacePoint>,
    /// The points before an end was cut off.
    before: Vec<SpacePoint>,
}

impl RopeDepth {
    /// Creates a finder for a pair of cameras.
    pub fn new(camera: DepthCamera) -> Self {
        let [x, y] = camera.depth.focal_px();
        Self {
            focal_px: (x * y).sqrt(),
            camera,
            sights: Vec::new(),
            axes: Vec::new(),
            anchors: Vec::new(),
            chain: Vec::new(),
            row: Vec::new(),
            sections: Vec::new(),
            course: Course::default(),
            pixels: Box::new(Pixels::NONE),
            arch: Arch::new(),
            places: Vec::new(),
            before: Vec::new(),
        }
    }

    /// Locates the points of a rope.
    ///
    /// # Errors
    /// The points cannot be located, or too few of them are measured.
    pub fn locate(
        &mut self,
        image: &DepthImage,
        rope: &SeenRope,
    ) -> Result<&[SpacePoint], NoDepth> {
        let count = rope.points.len();
        if !rope.is_whole() {
            return Err(NoDepth::Points);
        }
        self.aim(rope)?;
        self.divide(rope);
        self.find(image, rope);
        if self.anchors.len() < 2 {
            return Err(self.unmeasured());
        }
        self.join();
        self.read(image, rope, Sampling::Glance);
        self.settle();
        self.steady_radius();
        self.read(image, rope, Sampling::Whole);
        self.read_again(image, rope);
        self.drop_strays(rope.closed);
        self.fill(rope);
        let measured = self.axes.iter().filter(|axis| axis.is_measured).count();
        if 3 * measured < count {
            let sections = self.sections.iter();
            let wide = sections.map(|&i| self.half_width_px(&self.axes[i]));
            let pixels = 2.0 * wide.sum::<f64>() / self.sections.len() as f64;
            return Err(match pixels < THINNEST_PX {
                true => NoDepth::Thin {
                    pixels: pixels as usize,
                },
                false => self.unmeasured(),
            });
        }
        if self.is_flat(image, rope) {
            return Err(NoDepth::Flat);
        }
        self.doubt();
        self.bridge();
        self.write(rope);
        cut_ends(&mut self.places, rope.ends, &mut self.before);
        Ok(&self.places)
    }

    fn unmeasured(&self) -> NoDepth {
        NoDepth::Unmeasured {
            measured: self.axes.iter().filter(|axis| axis.is_measured).count(),
            points: self.axes.len(),
        }
    }

    /// Computes the rays of the points.
    fn aim(&mut self, rope: &SeenRope) -> Result<(), NoDepth> {
        let aimed = sight::aim(&self.camera.color, rope, &mut self.row, &mut self.sights);
        aimed.ok_or(NoDepth::Lens)?;
        self.axes.clear();
        let camera = &self.camera;
        self.axes.extend(self.sights.iter().map(|sight| Axis {
            turned: camera.turned(sight.ray),
            slim: sight.slim,
            ..Axis::default()
        }));
        Ok(())
    }

    /// Returns the point at this depth of the color camera along a point's ray, in the depth
    /// camera's frame.
    fn place(&self, axis: &Axis, depth: f64) -> [f64; 3] {
        let ([x, y, z], [right, down, ahead]) = (axis.turned, self.camera.translation);
        [depth * x + right, depth * y + down, depth * z + ahead]
    }

    /// Converts a distance ahead of the depth camera, along a point's ray, to the color camera's
    /// depth.
    fn depth(&self, axis: &Axis, ahead: f64) -> f64 {
        (ahead - self.camera.translation[2]) / axis.turned[2]
    }

    /// Interpolates depths between the anchors.
    fn join(&mut self) {
        let mut begin = 0;
        let last = self.axes.len();
        let ends = (self.anchors[1..self.anchors.len() - 1].iter()).map(|&(to, _)| to + 1);
        for (pair, end) in self.anchors.windows(2).zip(ends.chain([last])) {
            let [(from, a), (to, b)] = [pair[0], pair[1]];
            let step = (b - a) / (to - from) as f64;
            for (i, axis) in self.axes[begin..end].iter_mut().enumerate() {
                let steps = (begin + i).clamp(from, to) - from;
                axis.depth = a + steps as f64 * step;
            }
            begin = end;
        }
    }

    /// Replaces the depth of each section by the median of five neighboring sections.
    fn settle(&mut self) {
        self.row.clear();
        let depths = self.sections.iter().map(|&i| self.axes[i].depth);
        self.row.extend(depths);
        for (five, &i) in self.row.windows(5).zip(&self.sections[2..]) {
            // The median is the third value, clamped to the middle two of the other four.
            let [a, b, c, d] = [five[0], five[1], five[3], five[4]];
            let (low, high) = (a.min(b).max(c.min(d)), a.max(b).min(c.max(d)));
            self.axes[i].depth = five[2].max(low.min(high)).min(low.max(high));
        }
    }

    /// Limits the radius of the rope to near its median, because a width in the image may be that
    /// of two strands.
    fn steady_radius(&mut self) {
        self.row.clear();
        let radii = self.sections.iter().map(|&i| &self.axes[i]);
        self.row.extend(radii.map(|axis| axis.slim * axis.depth));
        let middle = self.row.len() / 2;
        let (_, &mut radius, _) = self.row.select_nth_unstable_by(middle, f64::total_cmp);
        for axis in &mut self.axes {
            let own = axis.slim * axis.depth;
            let likely = own.clamp((1.0 - UNEVEN) * radius, (1.0 + UNEVEN) * radius);
            axis.slim = likely / axis.depth;
        }
    }

    /// Interpolates depths between two measured sections: on the cubic through four sections, or
    /// linearly.
    fn fill(&mut self, rope: &SeenRope) {
        let axes = &mut self.axes;
        for i in (1..axes.len() - 1).step_by(SECTION_STEP) {
            let (a, b) = (&axes[i - 1], &axes[i + 1]);
            let is_measured = a.is_measured && b.is_measured && !rope.hidden[i];
            let depth = match (i.checked_sub(3).map(|k| &axes[k]), axes.get(i + 3)) {
                (Some(before), Some(after)) if before.is_measured && after.is_measured => {
                    (9.0 * (a.depth + b.depth) - before.depth - after.depth) / 16.0
                }
                _ => 0.5 * (a.depth + b.depth),
            };
            let variance = 0.5 * (a.variance + b.variance);
            let beside = 0.5 * (a.beside + b.beside);
            let axis = &mut axes[i];
            axis.is_measured = is_measured;
            if is_measured {
                (axis.depth, axis.variance, axis.beside) = (depth, variance, beside);
            }
        }
    }

    /// Half of the rope's width in the depth image, px.
    fn half_width_px(&self, axis: &Axis) -> f64 {
        let ahead = self.place(axis, axis.depth)[2];
        axis.slim * self.focal_px * axis.depth / ahead.max(1.0)
    }

    fn write(&mut self, rope: &SeenRope) {
        self.places.clear();
        let (widths, hidden) = (rope.widths_px.iter(), rope.hidden.iter());
        let points = self.axes.iter().zip(&self.sights).zip(widths).zip(hidden);
        let places = points.map(|(((axis, sight), &width), &hidden)| {
            let depth = axis.depth;
            let ([x, y, ahead], [by_x, by_y]) = (sight.ray, sight.by_pixel);
            let beside = match (axis.is_measured, hidden) {
                (true, _) => ASIDE * (axis.beside.abs() - NOT_ASIDE).max(0.0),
                (false, true) => 0.0,
                (false, false) => 1.0,
            };
            SpacePoint {
                point: [depth * x, depth * y, depth * ahead],
                by_pixel: [
                    [depth * by_x[0], depth * by_x[1]],
                    [depth * by_y[0], depth * by_y[1]],
                    [0.0; 2],
                ],
                ray: sight.ray,
                variance: axis.variance,
                in_common: if axis.is_measured { 0.0 } else { 1.0 },
                is_measured: axis.is_measured,
                doubt_px: 0.5 * f64::from(width) * beside,
                doubt_mm: 0.0,
                width_mm: 2.0 * axis.slim * depth,
            }
        });
        self.places.extend(places);
    }
}
