//! What a lens does to the normalized coordinates of a point (tangents of its angle to the axis), and how that is undone.
//!
//! **Where a model may be asked.** Far from the middle a polynomial turns round and folds the picture over itself: then several
//! rays are seen at one pixel, and `cv2.undistortPoints` gives any of them or none. Where the symmetric part of the
//! derivative is positive definite throughout a convex region, the map is one-to-one there: the way from `f(a)` to `f(b)` then
//! has a positive component along `b − a`, `(b − a)ᵀ(f(b) − f(a)) = ∫ (b − a)ᵀ J (b − a) > 0`. So a lens is used within the
//! largest disc about its axis in which that holds, looked for when it is made, and a pixel whose ray would lie outside of it is
//! refused. For radial distortion that is exactly up to the fold.
//!
//! **How it is undone.** By Newton's method from the distorted point, each step shortened until it comes nearer and stays in
//! the disc, to the last bits.

use crate::brown::Brown;
use crate::fisheye::Fisheye;
use crate::jacobian::{self, IDENTITY, Place, determinant, is_monotone, times};

/// Rays farther from the axis than this are never asked for: their tangent, and so their place on any plane square to the
/// axis, is out of proportion to anything that is measured.
const WIDEST_DEG: f64 = 89.0;
/// Steps of the search for the disc, and directions looked at for each.
const RINGS: usize = 712;
const SPOKES: usize = 64;
/// Steps of Newton's method, and of shortening one, at most: near the fold it takes some 10, elsewhere 3 to 5.
const STEPS: usize = 48;
const HALVINGS: usize = 24;
/// A normalized coordinate is right when the ray it means is seen this near: 10⁻⁹ px at a focal length of 10 000 px.
const NEAR: f64 = 1e-13;

/// A lens: how it bends, and how far from its axis it may be asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    model: Model,
    /// The radius of the disc in which the model is one-to-one, as a tangent.
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

    /// Brown–Conrady, from at most 14 coefficients in OpenCV's order: k₁ k₂ p₁ p₂ k₃ k₄ k₅ k₆ s₁ s₂ s₃ s₄ τₓ τᵧ. Those left out
    /// are 0. `None` if there are more, if one is not a finite number, or if they leave no region in which the lens is
    /// one-to-one.
    pub fn brown_conrady(coefficients: &[f64]) -> Option<Self> {
        let sound = coefficients.len() <= 14 && coefficients.iter().all(|c| c.is_finite());
        sound.then_some(())?;
        if coefficients.iter().all(|&c| c == 0.0) {
            return Some(Self::IDEAL);
        }
        Self::of(Model::Brown(Brown::new(coefficients)?))
    }

    /// Kannala–Brandt's fisheye, k₁ to k₄. `None` as for the other.
    pub fn fisheye(coefficients: [f64; 4]) -> Option<Self> {
        coefficients.iter().all(|c| c.is_finite()).then_some(())?;
        Self::of(Model::Fisheye(Fisheye(coefficients)))
    }

    fn of(model: Model) -> Option<Self> {
        let widest = widest(&model);
        // Less than a degree is no picture.
        (widest > 0.02).then_some(Self { model, widest })
    }

    /// The model by its name in ROS's `sensor_msgs/CameraInfo`, and its coefficients in OpenCV's order.
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

    /// How far from the axis the model may be asked, degrees.
    pub fn widest_deg(&self) -> f64 {
        libm::atan(self.widest).to_degrees()
    }

    /// Where a ray with these tangents is seen. `None` outside of the disc in which the model is one-to-one.
    pub fn distort(&self, ideal: [f64; 2]) -> Option<Place> {
        // Not `>`: what is not a number is nowhere.
        (libm::hypot(ideal[0], ideal[1]) <= self.widest).then_some(())?;
        match &self.model {
            Model::Ideal => Some(Place::itself(ideal)),
            Model::Brown(brown) => brown.tilted(brown.bend(ideal)?),
            Model::Fisheye(fisheye) => Some(fisheye.bend(ideal)),
        }
    }

    /// The ray that is seen here; with the derivative by where it is seen. `None` where no ray of the disc is.
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

/// The ideal point that the lens bends to `seen`, with the derivative *of the bend* there.
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
            // One more step costs little and leaves rounding alone.
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

/// The radius of the largest disc about the axis in which the model is one-to-one, as far as rings and spokes show it.
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
