//! Distances from a true centerline.

use crate::truth::is_seen;
use lariat_message::{Centerlines, MAX_CURVES, MAX_POINTS};

/// A point, `[x, y]` in pixels.
pub(crate) type Point = [f64; 2];

/// Several centerlines, stored one after the other in memory that is allocated once.
#[derive(Debug, Clone)]
pub(crate) struct Polylines {
    points: Vec<[f32; 2]>,
    ends: [usize; MAX_CURVES],
    closed: [bool; MAX_CURVES],
    count: usize,
}

impl Default for Polylines {
    fn default() -> Self {
        Self {
            // Only the pages in use become resident.
            points: Vec::with_capacity(MAX_CURVES * MAX_POINTS),
            ends: [0; MAX_CURVES],
            closed: [false; MAX_CURVES],
            count: 0,
        }
    }
}

impl Polylines {
    /// Copies the visible curves of a message whose coordinates are all finite.
    pub(crate) fn set(&mut self, message: &Centerlines) {
        self.points.clear();
        self.count = 0;
        for curve in message.curves() {
            let points = curve.points();
            if is_seen(curve.status())
                && !points.is_empty()
                && points.as_flattened().iter().all(|x| x.is_finite())
            {
                self.points.extend_from_slice(points);
                self.ends[self.count] = self.points.len();
                self.closed[self.count] = curve.closed != 0;
                self.count += 1;
            }
        }
    }

    /// Returns the number of centerlines.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Returns one of the centerlines.
    pub(crate) fn get(&self, index: usize) -> Polyline<'_> {
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        Polyline {
            points: &self.points[start..self.ends[index]],
            closed: self.closed[index],
        }
    }

    /// Returns all centerlines in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Polyline<'_>> {
        (0..self.count).map(|index| self.get(index))
    }
}

/// One centerline: at least one point, at equal steps of arc length.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Polyline<'a> {
    pub(crate) points: &'a [[f32; 2]],
    pub(crate) closed: bool,
}

impl Polyline<'_> {
    /// Returns the point of this index, or the first one past the end.
    fn vertex(&self, index: usize) -> Point {
        let point = self.points.get(index).unwrap_or(&self.points[0]);
        point.map(f64::from)
    }

    fn segments(&self) -> usize {
        self.points.len() - usize::from(!self.closed)
    }

    /// Returns the longest step between neighboring points, as [`distance`](Self::distance) needs
    /// it.
    pub(crate) fn longest_step(&self) -> f64 {
        (0..self.segments())
            .map(|i| between(self.vertex(i), self.vertex(i + 1)))
            .fold(0.0, f64::max)
    }

    /// Returns the distance of a point from the polyline.
    ///
    /// No position within arc length s of a vertex is nearer than the vertex's distance minus s.
    /// From a distant vertex, the search can therefore leap along the line, like a sphere tracer
    /// along its ray, and still finds the minimum. It begins with the segment at `hint`; a good
    /// hint makes all leaps long.
    pub(crate) fn distance(&self, point: Point, longest_step: f64, hint: usize) -> f64 {
        let segments = self.segments();
        if segments == 0 {
            return between(point, self.vertex(0));
        }
        let to_segment = |i| to_segment(point, self.vertex(i), self.vertex(i + 1));
        let mut nearest = to_segment(hint.min(segments - 1));
        let steps_per_px = 1.0 / longest_step;
        let mut i = 0;
        while i < segments {
            let leap = (between(point, self.vertex(i)) - nearest) * steps_per_px;
            if leap >= 1.0 {
                i = i.saturating_add(leap as usize);
            } else {
                nearest = nearest.min(to_segment(i));
                i += 1;
            }
        }
        nearest
    }

    /// Returns the point at the normalized arc length `rho` in [0, 1] of an open polyline.
    pub(crate) fn at(&self, rho: f64) -> Point {
        let place = rho * (self.points.len() - 1) as f64;
        let i = (place as usize).min(self.points.len().saturating_sub(2));
        let (a, b, t) = (self.vertex(i), self.vertex(i + 1), place - i as f64);
        if self.points.len() == 1 {
            return a;
        }
        [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
    }
}

/// Returns the distance between two points.
pub(crate) fn between(a: Point, b: Point) -> f64 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sqrt()
}

/// Returns the distance of a point from the segment a b.
fn to_segment(point: Point, a: Point, b: Point) -> f64 {
    let (ab, ap) = (
        [b[0] - a[0], b[1] - a[1]],
        [point[0] - a[0], point[1] - a[1]],
    );
    let length_squared = ab[0] * ab[0] + ab[1] * ab[1];
    let t = if length_squared > 0.0 {
        ((ap[0] * ab[0] + ap[1] * ab[1]) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    between(point, [a[0] + t * ab[0], a[1] + t * ab[1]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns the distance by definition: the minimum over all segments.
    fn distance_by_definition(line: &Polyline, point: Point) -> f64 {
        (0..line.segments())
            .map(|i| to_segment(point, line.vertex(i), line.vertex(i + 1)))
            .fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #[test]
        fn leaping_along_the_line_finds_the_nearest_place(
            points in prop::collection::vec([0.0f32..100.0, 0.0f32..100.0], 2..60),
            point in [-50.0f64..150.0, -50.0f64..150.0],
            closed: bool,
            hint in 0usize..80,
        ) {
            let line = Polyline { points: &points, closed };
            let found = line.distance(point, line.longest_step(), hint);
            prop_assert!((found - distance_by_definition(&line, point)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_line_of_one_point_is_that_point() {
        let line = Polyline {
            points: &[[3.0, 4.0]],
            closed: false,
        };
        assert_eq!(line.distance([0.0, 0.0], line.longest_step(), 0), 5.0);
        assert_eq!(line.at(0.7), [3.0, 4.0]);
    }

    #[test]
    fn points_that_coincide_do_not_stop_the_search() {
        let line = Polyline {
            points: &[[1.0, 0.0]; 5],
            closed: false,
        };
        assert_eq!(line.distance([0.0, 0.0], line.longest_step(), 2), 1.0);
    }

    #[test]
    fn a_closed_line_has_a_last_segment_back_to_its_first_point() {
        let square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        let open = Polyline {
            points: &square,
            closed: false,
        };
        let closed = Polyline {
            points: &square,
            closed: true,
        };
        assert_eq!(open.distance([0.0, 4.0], open.longest_step(), 0), 4.0);
        assert_eq!(closed.distance([0.0, 4.0], closed.longest_step(), 0), 0.0);
    }
}
