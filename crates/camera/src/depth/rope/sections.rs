//! Sections of a rope in the depth image, one per vector lane, and how to read each.

use super::floats::{Floats, LANES, Lanes};
use lariat_portable::{Simd, WithSimd};
use std::ops::{Mul, Range, Sub};

/// Share of a rope's half width that is read; and width of the band of pixels at an edge that see
/// both sides of it, px.
const INNER: f32 = 0.8;
const EDGE_PX: f32 = 0.8;
/// If at most this width is left on each side of the axis, px, each pixel is tested for whether it
/// is on the rope. The test takes into account the pixel's extent toward the rope's side and the
/// error of the axis (`AXIS_OFF_PX`).
const NARROW_PX: f32 = 0.5;
const AXIS_OFF_PX: f32 = 0.1;
/// If less than this width is left, px, almost no pixel is entirely on the rope, and the section is
/// not read.
const LEAST_PX: f32 = 0.1;
/// Maximum extent of a section on each side of its point, in half widths of the rope: the length
/// over which the rope is straight.
const LONGEST: f32 = 1.5;

/// The sections of a rope in order, each around one of its points. One point is added before the
/// first and one after the last. For a closed rope these are the last and the first point,
/// otherwise copies of the first and the last. Padding at the end lets a vector start at any
/// section.
#[derive(Debug, Clone, Default)]
pub(super) struct Course {
    /// Positions of the points in the depth image, px, and in the depth camera's frame, mm.
    at: [Vec<f32>; 2],
    place: [Vec<f32>; 3],
    /// Radius of the rope at each section, mm; 0 where it is hidden.
    radius: Vec<f32>,
    /// Shares of the distances to the previous and to the next point that belong to a section.
    share: [Vec<f32>; 2],
    count: usize,
    closed: bool,
}

impl Course {
    /// Prepares `count` sections that are not placed yet.
    pub(super) fn begin(&mut self, count: usize, closed: bool) {
        (self.count, self.closed) = (count, closed);
        let numbers = self
            .at
            .iter_mut()
            .chain(&mut self.place)
            .chain(&mut self.share);
        for numbers in numbers.chain([&mut self.radius]) {
            numbers.resize(count + 1 + LANES, 0.0);
        }
    }

    /// Sets the shares of the `k`-th section.
    pub(super) fn share(&mut self, k: usize, share: [f32; 2]) {
        (self.share[0][k], self.share[1][k]) = (share[0], share[1]);
    }

    /// Places the `k`-th section.
    pub(super) fn set_out(&mut self, k: usize, at: [f64; 2], place: [f64; 3], radius: f64) {
        let last = self.count - 1;
        self.put(k + 1, at, place);
        if k == 0 {
            self.put(if self.closed { last + 2 } else { 0 }, at, place);
        }
        if k == last {
            self.put(if self.closed { 0 } else { last + 2 }, at, place);
        }
        self.radius[k] = radius as f32;
    }

    fn put(&mut self, k: usize, at: [f64; 2], place: [f64; 3]) {
        for (to, number) in self.at.iter_mut().zip(at) {
            to[k] = number as f32;
        }
        for (to, number) in self.place.iter_mut().zip(place) {
            to[k] = number as f32;
        }
    }
}

/// Computes how to read some sections of a course.
pub(super) struct Outline<'a> {
    pub(super) course: &'a Course,
    /// At most as many as there are lanes.
    pub(super) which: Range<usize>,
    /// The depth camera's focal length, px; the standard deviation of a depth z, divided by z²,
    /// 1/mm; and the standard deviation due to rounding to integers, mm.
    pub(super) focal_px: f32,
    pub(super) noise: f32,
    pub(super) rounding_mm: f32,
}

/// How to read sections.
pub(super) struct Sections {
    /// Positions of their points, px, and distances ahead of the depth camera, mm.
    pub(super) at: [Lanes; 2],
    pub(super) ahead: Lanes,
    /// Unit direction along the rope in the image. `slope` and `tilt` are increases in distance
    /// ahead: of the axis per pixel along the rope, and of the rope's side per pixel across.
    pub(super) along: [Lanes; 2],
    pub(super) slope: Lanes,
    pub(super) tilt: Lanes,
    /// Extent of the part that is read, along the rope and to each side, px. `inner` is 0 for
    /// sections that are too thin or lack a direction in the depth image.
    pub(super) ends: [Lanes; 2],
    pub(super) inner: Lanes,
    pub(super) mm_per_px: Lanes,
    /// Distance at which a ray passes the axis, per pixel to the side.
    pub(super) beside_per_px: Lanes,
    /// Radius of the rope, mm.
    pub(super) radius: Lanes,
    /// Increase of a ray's distance from the axis per millimeter ahead.
    pub(super) sine: Lanes,
    /// Standard deviation of a pixel, mm.
    pub(super) sigma: Lanes,
}

impl WithSimd for Outline<'_> {
    type Output = Sections;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Sections {
        let first = self.which.start;
        let course = self.course;
        let [x_before, x, x_after] = around(simd, &course.at[0][first..]);
        let [y_before, y, y_after] = around(simd, &course.at[1][first..]);
        // Sections outside of `which` are not read.
        let mut radius = [0.0; LANES];
        radius[..self.which.len()].copy_from_slice(&course.radius[self.which]);
        let (way_x, way_y) = (x_after - x_before, y_after - y_before);
        let far = (way_x * way_x + way_y * way_y).sqrt();
        let one = Floats::splat(simd, 1.0);
        let per_far = one / far;
        let (along_x, along_y) = (way_x * per_far, way_y * per_far);

        let place = Vector::of(simd, &course.place, first + 1);
        let way =
            Vector::of(simd, &course.place, first + 2) - Vector::of(simd, &course.place, first);
        let ahead = place.z;
        let per_ahead = one / ahead;
        let focal = Floats::splat(simd, self.focal_px);
        let mm_per_px = ahead * Floats::splat(simd, 1.0 / self.focal_px);
        let half = Floats::of(simd, &radius) * focal * per_ahead;

        let narrow_px = Floats::splat(simd, NARROW_PX);
        let wide = (half * Floats::splat(simd, INNER)).min(half - Floats::splat(simd, EDGE_PX));
        let reach = Floats::splat(simd, 0.5) * (along_x.abs() + along_y.abs());
        let narrow = (half - reach - Floats::splat(simd, AXIS_OFF_PX)).min(narrow_px);
        let inner = narrow.where_less(wide, narrow_px, wide);
        let zero = Floats::splat(simd, 0.0);
        let inner = zero.where_less(inner, Floats::splat(simd, LEAST_PX), inner);
        let inner = inner.where_less(Floats::splat(simd, 1e-3), far, zero);
        let inner = inner.where_less(far, Floats::splat(simd, 1e3), zero);

        let most = Floats::splat(simd, LONGEST) * half;
        let (back_x, back_y) = (x_before - x, y_before - y);
        let back = (back_x * back_x + back_y * back_y).sqrt()
            * Floats::of(simd, &course.share[0][first..]);
        let (on_x, on_y) = (x_after - x, y_after - y);
        let on = (on_x * on_x + on_y * on_y).sqrt() * Floats::of(simd, &course.share[1][first..]);

        // The ray, the rope, and the normal of both; then the normal of that normal and the rope.
        let ray = place * per_ahead;
        let rope = way * (one / way.length());
        let normal = ray.cross(rope);
        let sine = normal.length();
        let per_sine = one / sine;
        let normal = normal * per_sine;
        let up = rope.cross(normal);
        let sigma = Floats::splat(simd, self.noise) * ahead * ahead;
        let rounding = Floats::splat(simd, self.rounding_mm);
        Sections {
            at: [x.lanes(), y.lanes()],
            ahead: ahead.lanes(),
            along: [along_x.lanes(), along_y.lanes()],
            slope: (way.z * per_far).lanes(),
            tilt: (mm_per_px * per_sine * (along_y * up.x - along_x * up.y)).lanes(),
            ends: [(-back.min(most)).lanes(), on.min(most).lanes()],
            inner: inner.lanes(),
            mm_per_px: mm_per_px.lanes(),
            beside_per_px: (mm_per_px * (along_x * normal.y - along_y * normal.x)).lanes(),
            radius,
            sine: sine.lanes(),
            sigma: (sigma * sigma + rounding * rounding).sqrt().lanes(),
        }
    }
}

/// Returns the previous numbers, these, and the next.
#[inline(always)]
fn around<S: Simd>(simd: S, numbers: &[f32]) -> [Floats<S>; 3] {
    [
        Floats::of(simd, numbers),
        Floats::of(simd, &numbers[1..]),
        Floats::of(simd, &numbers[2..]),
    ]
}

/// A 3-D vector for each lane.
#[derive(Clone, Copy)]
struct Vector<S: Simd> {
    x: Floats<S>,
    y: Floats<S>,
    z: Floats<S>,
}

impl<S: Simd> Vector<S> {
    /// Loads the vectors from the `first` one on.
    #[inline(always)]
    fn of(simd: S, [x, y, z]: &[Vec<f32>; 3], first: usize) -> Self {
        Self {
            x: Floats::of(simd, &x[first..]),
            y: Floats::of(simd, &y[first..]),
            z: Floats::of(simd, &z[first..]),
        }
    }

    #[inline(always)]
    fn length(self) -> Floats<S> {
        (self.x * self.x + self.y * self.y + self.z * self.z).sqrt()
    }

    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }
}

impl<S: Simd> Sub for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }
}

impl<S: Simd> Mul<Floats<S>> for Vector<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: Floats<S>) -> Self {
        Self {
            x: self.x * by,
            y: self.y * by,
            z: self.z * by,
        }
    }
}
