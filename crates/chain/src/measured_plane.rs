//! Computes a plane from measured points, the errors of the points, and a grid to show the plane in
//! the picture.

use anyhow::{Context, Result, bail};
use lariat_camera::{Camera, LEAST_MM, Mapping, Pair, Plane};

use crate::plane_file;

/// Approximate maximum number of grid lines along the longer side.
const LINES: f64 = 16.0;
/// Margin of the grid around the points, as a fraction of their span.
const BEYOND: f64 = 0.5;
/// Number of points on each grid line, which a lens bends.
const BENDS: usize = 24;

/// A plane and the points that it was computed from.
#[derive(Debug, Clone)]
pub struct MeasuredPlane {
    pairs: Vec<Pair>,
    plane: Plane,
    camera: Option<Camera>,
    mapping: Mapping,
}

/// Error of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Off {
    /// Distance on the plane; NaN if the pixel does not show the plane.
    pub mm: f64,
    /// Distance in the picture; NaN if the point is not visible.
    pub px: f64,
}

/// Lines of equal coordinates on the plane, as they appear in the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Distance between neighboring lines.
    pub step_mm: f64,
    /// Points of each line, px.
    pub lines: Vec<Vec<[f64; 2]>>,
}

impl MeasuredPlane {
    /// Computes the plane from points in images of this size, taken through this lens.
    ///
    /// # Errors
    /// Returns an error if the points do not determine a plane, or if the lens is for another image
    /// size.
    pub fn of(pairs: &[Pair], camera: Option<&Camera>, size: [u32; 2]) -> Result<Self> {
        let lens =
            Mapping::new(camera, None, size).context("the calibration does not fit the images")?;
        let ideal = pairs.iter().enumerate().map(|(index, pair)| {
            let place = lens
                .place(pair.pixel)
                .with_context(|| format!("point {}", index + 1))?;
            Ok(Pair {
                pixel: place.point,
                ..*pair
            })
        });
        let ideal = ideal.collect::<Result<Vec<Pair>>>()?;
        let mut plane = Plane::from_pairs(&ideal)?.in_images_of(size);
        check_unit(pairs)?;
        if let Some(camera) = camera {
            let ([fx, fy], [cx, cy]) = (camera.focal_px(), camera.center_px());
            plane = plane.undistorted_by([fx, fy, cx, cy]);
        }
        Ok(Self {
            pairs: pairs.to_vec(),
            mapping: Mapping::new(camera, Some(&plane), size)?,
            camera: camera.copied(),
            plane,
        })
    }

    /// Returns the mapping from image pixels to the plane.
    pub fn mapping(&self) -> &Mapping {
        &self.mapping
    }

    /// Returns the error of each point, in the order of the points.
    pub fn off(&self) -> impl Iterator<Item = Off> {
        let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        self.pairs.iter().map(move |Pair { pixel, plane_mm }| Off {
            mm: self
                .mapping
                .place(*pixel)
                .map_or(f64::NAN, |place| apart(place.point, *plane_mm)),
            px: self
                .mapping
                .pixel(*plane_mm)
                .map_or(f64::NAN, |seen| apart(seen, *pixel)),
        })
    }

    /// Returns the root mean square and the maximum error in mm. Returns `None` for four points,
    /// which fit a plane exactly.
    pub fn error_mm(&self) -> Option<[f64; 2]> {
        let count = self.pairs.len();
        let squares: f64 = self.off().map(|off| off.mm * off.mm).sum();
        let most = self.off().map(|off| off.mm).fold(0.0, f64::max);
        (count > 4).then(|| [(squares / count as f64).sqrt(), most])
    }

    /// Returns a grid around the points.
    pub fn grid(&self) -> Grid {
        let spans = [0, 1].map(|axis| {
            let along = self.pairs.iter().map(|pair| pair.plane_mm[axis]);
            let (from, to) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), mm| {
                (from.min(mm), to.max(mm))
            });
            [from, to]
        });
        let longest = spans.iter().map(|[from, to]| to - from).fold(0.0, f64::max);
        let step_mm = round_step(longest * (1.0 + 2.0 * BEYOND) / LINES);
        let beyond = BEYOND * longest;
        let ends = spans.map(|[from, to]| {
            let outward = [
                ((from - beyond) / step_mm).floor(),
                ((to + beyond) / step_mm).ceil(),
            ];
            outward.map(|steps| steps * step_mm)
        });
        let mut lines = Vec::new();
        for across in [0, 1] {
            let [from, to] = ends[across];
            let [begin, end] = ends[1 - across];
            let count = ((to - from) / step_mm).round() as usize;
            for line in 0..=count {
                let at = from + line as f64 * step_mm;
                let points = (0..=BENDS).map(|bend| {
                    let along = begin + (end - begin) * bend as f64 / BENDS as f64;
                    let mut point = [along; 2];
                    point[across] = at;
                    self.seen(point)
                });
                let points: Vec<_> = points.collect();
                let parts = points.split(Option::is_none);
                let parts = parts.map(|part| part.iter().copied().flatten().collect());
                lines.extend(parts.filter(|part: &Vec<_>| part.len() > 1));
            }
        }
        Grid { step_mm, lines }
    }

    /// Returns the pixel of a point on the plane, unless it is far outside the picture.
    fn seen(&self, point: [f64; 2]) -> Option<[f64; 2]> {
        let seen = self.mapping.pixel(point)?;
        let sides = self.mapping.size().map(f64::from);
        let is_near = (0..2).all(|axis| (-sides[axis]..2.0 * sides[axis]).contains(&seen[axis]));
        is_near.then_some(seen)
    }

    /// Returns the text of the plane's file.
    pub fn file_text(&self, made_by: &str) -> String {
        let about = format!("From {} points, by {made_by}.", self.pairs.len());
        let (matrix, size) = (self.plane.homography(), self.mapping.size());
        plane_file::text(matrix, size, self.camera.as_ref(), &about)
    }
}

/// Rounds up to 1, 2 or 5 times a power of ten.
fn round_step(step: f64) -> f64 {
    let decade = 10f64.powf(step.log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|times| times * decade);
    steps
        .into_iter()
        .find(|round| *round >= step)
        .unwrap_or(10.0 * decade)
}

/// Checks the unit of the points.
///
/// # Errors
/// Returns an error if the points are closer together than any camera is to a table. Their
/// coordinates are probably in meters.
fn check_unit(pairs: &[Pair]) -> Result<()> {
    let span = |axis: usize| {
        let places = || pairs.iter().map(|pair| pair.plane_mm[axis]);
        places().fold(f64::MIN, f64::max) - places().fold(f64::MAX, f64::min)
    };
    let span_mm = span(0).max(span(1));
    if !pairs.is_empty() && span_mm < LEAST_MM {
        bail!(
            "the points lie within {span_mm:.3} mm of each other on the table: their places are in millimetres, so multiply metres by 1000"
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(of: &[[f64; 4]]) -> Vec<Pair> {
        let pair = |&[x, y, u, v]: &[f64; 4]| Pair {
            pixel: [x, y],
            plane_mm: [u, v],
        };
        of.iter().map(pair).collect()
    }

    #[test]
    fn four_points_of_a_distorting_lens_lie_where_they_were_measured() {
        let yaml = "image_width: 1280\nimage_height: 960\nK: [1200, 0, 640, 0, 1200, 480, 0, 0, 1]\nD: [-0.3, 0.1, 0, 0]";
        let camera = Camera::from_yaml(yaml).unwrap();
        let pairs = pairs(&[
            [60.0, 50.0, 0.0, 0.0],
            [590.0, 45.0, 297.0, 0.0],
            [600.0, 430.0, 297.0, 210.0],
            [40.0, 440.0, 0.0, 210.0],
        ]);
        // The images are half as large as the calibration's.
        let measured = MeasuredPlane::of(&pairs, Some(&camera), [640, 480]).unwrap();
        assert!(measured.off().all(|off| off.mm < 1e-6 && off.px < 1e-6));
        assert_eq!(measured.error_mm(), None);
        // The same points at the calibration's own size.
        let large = Mapping::new(Some(&camera), Some(&measured.plane), [1280, 960]).unwrap();
        let corner = large
            .place([60.0, 50.0].map(|c| 2.0 * c + 0.5))
            .unwrap()
            .point;
        assert!(corner[0].hypot(corner[1]) < 1e-6, "{corner:?}");
    }

    #[test]
    fn points_in_metres_are_refused() {
        let pairs = pairs(&[
            [60.0, 50.0, 0.0, 0.0],
            [590.0, 45.0, 0.297, 0.0],
            [600.0, 430.0, 0.297, 0.21],
            [40.0, 440.0, 0.0, 0.21],
        ]);
        let refused = MeasuredPlane::of(&pairs, None, [640, 480]).unwrap_err();
        assert!(
            refused.to_string().contains("multiply metres by 1000"),
            "{refused}"
        );
    }

    #[test]
    fn a_fifth_point_tells_how_far_they_are_off() {
        let pairs = pairs(&[
            [0.0, 0.0, 0.0, 0.0],
            [100.0, 0.0, 100.0, 0.0],
            [100.0, 100.0, 100.0, 100.0],
            [0.0, 100.0, 0.0, 100.0],
            [50.0, 50.0, 52.0, 50.0],
        ]);
        let measured = MeasuredPlane::of(&pairs, None, [640, 480]).unwrap();
        let [rms, most] = measured.error_mm().unwrap();
        assert!(rms > 0.5 && rms < most && most < 2.0, "{rms} {most}");
    }

    #[test]
    fn the_grid_goes_through_round_places_and_not_beyond_the_horizon() {
        // A table seen at an angle. Its horizon is the row above the picture.
        let pairs = pairs(&[
            [220.0, 120.0, 0.0, 0.0],
            [420.0, 120.0, 300.0, 0.0],
            [620.0, 440.0, 300.0, 200.0],
            [20.0, 440.0, 0.0, 200.0],
        ]);
        let measured = MeasuredPlane::of(&pairs, None, [640, 480]).unwrap();
        let Grid { step_mm, lines } = measured.grid();
        assert_eq!(step_mm, 50.0);
        for point in lines.iter().flatten() {
            let [x, y] = measured.mapping().place(*point).unwrap().point;
            let is_round = |mm: f64| (mm / step_mm - (mm / step_mm).round()).abs() < 1e-6;
            assert!(is_round(x) || is_round(y), "{x} {y}");
        }
        let is_in_picture =
            |[x, y]: &[f64; 2]| (0.0..640.0).contains(x) && (0.0..480.0).contains(y);
        assert!(
            lines
                .iter()
                .flatten()
                .filter(|at| is_in_picture(at))
                .count()
                > 50
        );
    }
}
