//! A lifted rope in two views: as seen by the camera, and below it from the side, which shows its
//! height.

use lariat_drawn::SpaceCameras;
use lariat_drawn::space::Eye;
use lariat_simulation::RADIUS_MM;
use lariat_wire::{Rope, Shape};

use super::{DRAWN_POINTS, ends};
use crate::servo::film::Sketch;

/// Height of the side view, and height of the table within it, px. One pixel is 1 mm.
const SIDE_PX: usize = 200;
const TABLE_PX: usize = 16;
const AIR: u8 = 246;
const TABLE: u8 = 190;
/// Squared radius that contains 95 % of a standard normal distribution with two degrees of freedom.
const CHI_SQUARED_95: f64 = 5.991;
/// Number of line segments of an ellipse.
const SIDES: u32 = 24;
/// Half the step of the finite differences of a view, mm.
const STEP_MM: f64 = 0.5;

/// The two views as pixels of one image: the camera's view, and the side view below it.
pub(super) struct Views {
    eye: Eye,
    size: [usize; 2],
}

impl Views {
    /// Creates the views of a camera with images of this size.
    pub(super) fn new(size: [usize; 2]) -> Self {
        Self {
            eye: SpaceCameras::color_eye(size.map(|side| side as u32)),
            size,
        }
    }

    /// Returns width and height of both views together.
    pub(super) fn size(&self) -> [usize; 2] {
        let [width, height] = self.size;
        [width, height + SIDE_PX]
    }

    /// Appends the background of the side view below the camera's image.
    pub(super) fn add_side(&self, rgb: &mut Vec<u8>) {
        let row = 3 * self.size[0];
        rgb.resize(rgb.len() + row * (SIDE_PX - TABLE_PX), AIR);
        rgb.resize(rgb.len() + row * TABLE_PX, TABLE);
    }

    /// Projects points of the robot's frame into each view.
    pub(super) fn lines(&self, points: &[[f64; 3]]) -> [Vec<[f64; 2]>; 2] {
        [0, 1].map(|view| points.iter().map(|&p| self.place(view, p)).collect())
    }

    /// Returns the sketch of a rope.
    pub(super) fn sketch(
        &self,
        rope: Option<&Rope>,
        truth: &[[f64; 3]],
        velocities: &[[f64; 6]],
    ) -> Sketch {
        let [_, side] = self.lines(truth);
        let mut sketch = Sketch {
            rope: side,
            rope_px: 2.0 * RADIUS_MM,
            ..Sketch::default()
        };
        for view in 0..2 {
            let both = ends(truth).zip(velocities);
            let moves = both.map(|(end, &velocity)| self.moved(view, end, velocity));
            sketch.grippers.extend(moves);
        }
        let Some(descriptor) = rope.and_then(|rope| rope.descriptor3().ok()) else {
            return sketch;
        };
        let Ok(shape) = Shape::in_space(descriptor) else {
            return sketch;
        };
        sketch.seen = self.lines(&shape.points::<DRAWN_POINTS>()).to_vec();
        sketch.control_points = self.lines(shape.control_points()).concat();
        for view in 0..2 {
            let points = shape.control_points().iter().zip(descriptor.covariances());
            let around = points.map(|(&p, covariance)| self.ellipse(view, p, covariance));
            sketch.ellipses.extend(around);
        }
        sketch
    }

    /// Projects a point of the robot's frame into the camera's image or into the side view. The
    /// side view has x to the right and z up from the table.
    fn place(&self, view: usize, point: [f64; 3]) -> [f64; 2] {
        let [width, height] = self.size.map(|side| side as f64);
        match view {
            0 => self.eye.pixel(self.eye.see(point)),
            _ => {
                let table = height + (SIDE_PX - TABLE_PX) as f64 - 0.5;
                [0.5 * (width - 1.0) + point[0], table - point[2]]
            }
        }
    }

    /// Returns the derivative of a projected position with respect to the point.
    fn derivative(&self, view: usize, point: [f64; 3]) -> [[f64; 3]; 2] {
        let by_axis = [0, 1, 2].map(|k| {
            let [to, from] = [STEP_MM, -STEP_MM].map(|step| {
                let mut moved = point;
                moved[k] += step;
                self.place(view, moved)
            });
            [0, 1].map(|axis| (to[axis] - from[axis]) / (2.0 * STEP_MM))
        });
        [0, 1].map(|axis| by_axis.map(|by| by[axis]))
    }

    /// Returns the ellipse that contains a point in a view with 95 % probability, given its
    /// covariance `[xx, xy, xz, yy, yz, zz]`.
    fn ellipse(&self, view: usize, point: [f64; 3], covariance: &[f64; 6]) -> Vec<[f64; 2]> {
        let [xx, xy, xz, yy, yz, zz] = *covariance;
        let whole = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let by = self.derivative(view, point);
        let seen = |a: usize, b: usize| -> f64 {
            let rows = whole.iter().zip(by[a]);
            rows.map(|(row, scale)| scale * dot(row, &by[b])).sum()
        };
        // The square root of the covariance in the view, by Cholesky.
        let wide = seen(0, 0).max(0.0).sqrt();
        let aside = if wide > 0.0 { seen(0, 1) / wide } else { 0.0 };
        let high = (seen(1, 1) - aside * aside).max(0.0).sqrt();
        let [x, y] = self.place(view, point);
        let far = CHI_SQUARED_95.sqrt();
        (0..=SIDES)
            .map(|k| {
                let turn = std::f64::consts::TAU * f64::from(k) / f64::from(SIDES);
                let (sin, cos) = libm::sincos(turn);
                [x + far * wide * cos, y + far * (aside * cos + high * sin)]
            })
            .collect()
    }

    /// Projects a gripper into a view. Returns its position and its motion there: px/s, and rad/s
    /// clockwise.
    fn moved(&self, view: usize, at: [f64; 3], velocity: [f64; 6]) -> ([f64; 2], [f64; 3]) {
        let [vx, vy, vz, _, about_y, about_z] = velocity;
        let [x, y] = self
            .derivative(view, at)
            .map(|row| dot(&row, &[vx, vy, vz]));
        // From above, z points towards the viewer. From the side, y points away.
        let turn = if view == 0 { -about_z } else { about_y };
        (self.place(view, at), [x, y, turn])
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [640, 480];

    fn spans(line: &[[f64; 2]]) -> [f64; 2] {
        [0, 1].map(|k| {
            let along = || line.iter().map(|p| p[k]);
            along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min)
        })
    }

    #[test]
    fn the_side_view_shows_heights_below_the_cameras_image() {
        let views = Views::new(SIZE);
        let [camera, side] = views.lines(&[[0.0; 3], [100.0, 40.0, 60.0], [100.0, 40.0, 0.0]]);
        assert!((camera[0][0] - 319.5).abs() < 1e-9 && (camera[0][1] - 239.5).abs() < 1e-9);
        // Points nearer to the camera are farther from the picture's center.
        assert!(camera[1][0] > camera[2][0] + 2.0 && camera[2][1] < camera[0][1]);
        let mut rgb = vec![0; 3 * SIZE[0] * SIZE[1]];
        views.add_side(&mut rgb);
        let [width, height] = views.size();
        assert_eq!(rgb.len(), 3 * width * height);
        let shade = |[x, y]: [f64; 2]| rgb[3 * (y.round() as usize * width + x.round() as usize)];
        assert_eq!(shade([side[0][0], side[0][1] + 1.0]), TABLE);
        assert_eq!(shade([side[0][0], side[0][1] - 1.0]), AIR);
        assert!((side[1][0] - side[0][0] - 100.0).abs() < 1e-9);
        assert!((side[0][1] - side[1][1] - 60.0).abs() < 1e-9);
    }

    #[test]
    fn an_ellipse_is_as_wide_as_its_covariance_from_that_side() {
        let views = Views::new(SIZE);
        // The standard deviation is ten times greater in height than across.
        let covariance = [1.0, 0.0, 0.0, 1.0, 0.0, 100.0];
        let wide = 2.0 * CHI_SQUARED_95.sqrt();
        let [across, up] = spans(&views.ellipse(1, [20.0, 0.0, 50.0], &covariance));
        assert!((across - wide).abs() < 0.02 * wide && (up - 10.0 * wide).abs() < 0.2 * wide);
        // The camera looks along the height, apart from its tilt.
        let [across, up] = spans(&views.ellipse(0, [0.0; 3], &covariance));
        assert!(across < 1.1 * wide && up < 3.0 * wide, "{across} {up}");
    }

    #[test]
    fn an_ellipse_of_correlated_axes_leans() {
        let views = Views::new(SIZE);
        let ellipse = views.ellipse(1, [0.0, 0.0, 50.0], &[4.0, 0.0, 3.9, 1.0, 0.0, 4.0]);
        let [x, y] = views.place(1, [0.0, 0.0, 50.0]);
        // Points farther to the right are higher up.
        let lean: f64 = ellipse.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
        assert!(lean < 0.0, "{lean}");
    }
}
