//! The distortion of a point's normalized coordinates (tangents of its angle to the axis) by a
//! lens, and the inverse.
//!
//! **Domain of a model.** Far from the center, a polynomial turns back and folds the image over
//! itself. Several rays are then seen at one pixel, and `cv2.undistortPoints` returns any of them
//! or none. If the symmetric part of the derivative is positive definite throughout a convex
//! region, the map is one-to-one there: the vector from `f(a)` to `f(b)` then has a positive
//! component along `b − a`, `(b − a)ᵀ(f(b) − f(a)) = ∫ (b − a)ᵀ J (b − a) > 0`. A lens is therefore
//! used within the largest disc around its axis in which that holds. The disc is determined when
//! the lens is created, and a pixel whose ray would be outside of it is refused. For radial
//! distortion, the disc ends exactly at the fold.
//!
//! **Inverse.** Newton's method starts at the distorted point. It shortens each step until it gets
//! closer and stays in the disc, and converges to rounding errors.

use crate::brown::Brown;
use crate::fisheye::Fisheye;
use crate::jacobian::{self, IDENTITY, Place, determinant, is_monotone, times};

/// Maximum angle of a ray to the axis. The tangent of a larger angle is out of proportion to any
/// measurement. So is the place of such a ray on a plane perpendicular to the axis.
const WIDEST_DEG: f64 = 89.0;
/// Number of rings in the search for the disc, and of directions on each.
const RINGS: usize = 712;
const SPOKES: usize = 64;
/// Maximum number of Newton steps, and of halvings of a step. Near the fold, the method takes about
/// 10 steps; elsewhere, 3 to 5.
const STEPS: usize = 48;
const HALVINGS: usize = 24;
/// Tolerance of the inverse: maximum distance of the distorted result from the given point, in
/// normalized coordinates. 10⁻⁹ px at a focal length of 10 000 px.
const NEAR: f64 = 1e-13;

/// A lens: its distortion, and how far from its axis it can be used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    model: Model,
    /// Radius of the disc in which the model is one-to-one, as a tangent.
    widest: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one of it, and boxed it would be no plain value"
)]
enum Model {
    Ideal,
    Brown(Brown),
    Fisheye(Fisheye),
}

impl Lens {
    /// A lens that does not distort.
    pub const IDEAL: Self = Self {
        model: Model::Ideal,
        widest: f64::INFINITY,
    };

    /// Creates a Brown–Conrady lens from at most 14 coefficients in OpenCV's order: k₁ k₂ p₁ p₂ k₃
    /// k₄ k₅ k₆ s₁ s₂ s₃ s₄ τₓ τᵧ. Missing ones are 0. Returns `None` if there are more, if one is
    /// not finite, or if they leave no region in which the lens is one-to-one.
    pub fn brown_conrady(coefficients: &[f64]) -> Option<Self> {
        let sound = coefficients.len() <= 14 && coefficients.iter().all(|c| c.is_finite());
        sound.then_some(())?;
        if coefficients.iter().all(|&c| c == 0.0) {
            return Some(Self::IDEAL);
        }
        Self::of(Model::Brown(Brown::new(coefficients)?))
    }

    /// Creates a Kannala–Brandt fisheye lens from k₁ to k₄. Returns `None` as
    /// [`brown_conrady`](Self::brown_conrady) does.
    pub fn fisheye(coefficients: [f64; 4]) -> Option<Self> {
        coefficients.iter().all(|c| c.is_finite()).then_some(())?;
        Self::of(Model::Fisheye(Fisheye(coefficients)))
    }

    fn of(model: Model) -> Option<Self> {
        let widest = widest(&model);
        // A field of about a degree is not usable.
        (widest > 0.02).then_some(Self { model, widest })
    }

    /// Name of the model in ROS's `sensor_msgs/CameraInfo`, and its coefficients in OpenCV's order.
    pub fn model(&self) -> (&'static str, Vec<f64>) {
        match &self.model {
            Model::Ideal => ("plumb_bob", vec![0.0; 5]),
            Model::Brown(brown) => {
                let coefficients = brown.coefficients();
                let is_plain = coefficients.len() == 5;
                let name = if is_plain {
                    "plumb_bob"
                } else {
                    "rational_polynomial"
                };
                (name, coefficients)
            }
            Model::Fisheye(fisheye) => ("equidistant", fisheye.0.to_vec()),
        }
    }

    /// Maximum angle to the axis at which the model can be used, in degrees.
    pub fn widest_deg(&self) -> f64 {
        libm::atan(self.widest).to_degrees()
    }

    /// Maps the tangents of a ray to the place where it is seen. `None` outside of the disc in
    /// which the model is one-to-one.
    pub fn distort(&self, ideal: [f64; 2]) -> Option<Place> {
        // Written with `<=`, so that NaN is refused.
        (libm::hypot(ideal[0], ideal[1]) <= self.widest).then_some(())?;
        match &self.model {
            Model::Ideal => Some(Place::itself(ideal)),
            Model::Brown(brown) => brown.tilted(brown.bend(ideal)?),
            Model::Fisheye(fisheye) => Some(fisheye.bend(ideal)),
        }
    }

    /// Maps a place back to the ray that is seen there, with the derivative by that place. `None`
    /// if no ray of the disc is seen there.
    pub fn undistort(&self, seen: [f64; 2]) -> Option<Place> {
        seen.iter().all(|c| c.is_finite()).then_some(())?;
        match &self.model {
            Model::Ideal => Some(Place::itself(seen)),
            Model::Brown(brown) => {
                let upright = brown.upright(seen)?;
                let ideal = newton(brown, upright.point, self.widest)?;
                let back = jacobian::inverse(&ideal.jacobian);
                Some(Place {
                    point: ideal.point,
                    jacobian: jacobian::product(&back, &upright.jacobian),
                })
            }
            Model::Fisheye(fisheye) => {
                let point = fisheye.straighten(seen, self.widest)?;
                Some(Place {
                    point,
                    jacobian: jacobian::inverse(&fisheye.bend(point).jacobian),
                })
            }
        }
    }
}

/// Finds the ideal point that the lens distorts to `seen`. The derivative is *that of the
/// distortion* there.
fn newton(brown: &Brown, seen: [f64; 2], widest: f64) -> Option<Place> {
    let away = |p: [f64; 2]| [p[0] - seen[0], p[1] - seen[1]];
    let length = |v: [f64; 2]| libm::hypot(v[0], v[1]);
    let tolerance = NEAR * (1.0 + length(seen));
    let far = length(seen);
    let inward = if far > widest {
        0.5 * widest / far
    } else {
        1.0
    };
    let mut point = seen.map(|c| c * inward);
    let mut bent = brown.bend(point)?;
    let mut miss = away(bent.point);
    for _ in 0..STEPS {
        if length(miss) <= tolerance {
            // One more step costs little and leaves only rounding errors.
            let step = times(&jacobian::inverse(&bent.jacobian), miss);
            let last = [point[0] - step[0], point[1] - step[1]];
            let better = brown
                .bend(last)
                .filter(|b| length(away(b.point)) < length(miss));
            let found = better.map_or((point, bent), |bent| (last, bent));
            return Some(Place {
                point: found.0,
                jacobian: found.1.jacobian,
            });
        }
        let step = times(&jacobian::inverse(&bent.jacobian), miss);
        let mut share = 1.0;
        let nearer = (0..HALVINGS).find_map(|_| {
            let next = [point[0] - share * step[0], point[1] - share * step[1]];
            share *= 0.5;
            let bent = brown.bend(next).filter(|_| length(next) <= widest)?;
            (length(away(bent.point)) < length(miss)).then_some((next, bent))
        });
        (point, bent) = nearer?;
        miss = away(bent.point);
    }
    None
}

/// Radius of the largest disc around the axis in which the model is one-to-one, tested on rings and
/// spokes.
fn widest(model: &Model) -> f64 {
    let is_good = |radius: f64| {
        (0..SPOKES).all(|spoke| {
            let angle = std::f64::consts::TAU * spoke as f64 / SPOKES as f64;
            let (sin, cos) = libm::sincos(angle);
            let point = [radius * cos, radius * sin];
            let jacobian = match model {
                Model::Ideal => Some(IDENTITY),
                Model::Brown(brown) => brown.bend(point).map(|bent| bent.jacobian),
                Model::Fisheye(fisheye) => Some(fisheye.bend(point).jacobian),
            };
            jacobian.is_some_and(|j| is_monotone(&j) && determinant(&j).is_finite())
        })
    };
    let at = |ring: usize| libm::tan((WIDEST_DEG * ring as f64 / RINGS as f64).to_radians());
    let Some(first_bad) = (0..=RINGS).find(|&ring| !is_good(at(ring))) else {
        return at(RINGS);
    };
    let (mut good, mut bad) = (at(first_bad.saturating_sub(1)), at(first_bad));
    if first_bad == 0 {
        return 0.0;
    }
    for _ in 0..48 {
        let middle = 0.5 * (good + bad);
        if is_good(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}
