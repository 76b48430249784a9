//! Where a point of a curve is, where the curve goes there, and how it bends.

use super::Curve;
use crate::basis::Basis;

impl<const D: usize> Curve<'_, D> {
    /// The point at `rho`, in the control points' unit (px).
    pub fn point(&self, rho: f64) -> [f64; D] {
        let [point] = self.jet(rho);
        point
    }

    /// The `k`-th derivative by ρ at `rho`, `k` from 0 (the point itself) to 3; `NaN` for higher ones. Where
    /// pieces of a B-spline or feature points meet, that of the piece that begins.
    pub fn derivative(&self, rho: f64, k: usize) -> [f64; D] {
        let jet: [_; 4] = self.jet(rho);
        jet.get(k).copied().unwrap_or([f64::NAN; D])
    }

    /// The direction in which the curve goes at `rho`, of length 1.
    ///
    /// Where the first derivative vanishes (a cusp, or control points one upon the other), it is the direction
    /// in which the curve goes on, and at its end the one in which it arrives: from the lowest derivative, up
    /// to the third, that does not vanish. `None` if all do, as of a curve that is a point.
    pub fn tangent(&self, rho: f64) -> Option<[f64; D]> {
        let jet: [_; 4] = self.jet(rho);
        let rounding = self.rounding();
        // A step of this curve by ρ, and the next ones, grow with order and pieces; so does their rounding.
        let growth = 2.0 * self.highest_rate();
        let mut noise = rounding;
        let arrives = rho >= 1.0 && !self.basis.is_closed();
        let mut sign = 1.0;
        for derivative in &jet[1..] {
            noise *= growth;
            let length = norm(derivative);
            if length > noise {
                return Some(derivative.map(|c| sign * c / length));
            }
            if arrives {
                sign = -sign;
            }
        }
        None
    }

    /// How much of a coordinate can be rounding.
    pub(crate) fn rounding(&self) -> f64 {
        let largest = self.control_points.iter().flatten();
        let largest = largest.fold(0.0f64, |size, c| size.max(c.abs()));
        8.0 * f64::EPSILON * self.control_points.len() as f64 * largest
    }

    /// How much larger a derivative can be than the one before.
    fn highest_rate(&self) -> f64 {
        let order = self.basis.order() as f64;
        match self.basis {
            Basis::Fourier { .. } => order * std::f64::consts::PI,
            Basis::CenterOfMass => 1.0,
            _ => {
                let lengths = self.pieces().map(|piece| piece.to - piece.from);
                let shortest = lengths.fold(1.0, f64::min);
                order.max(1.0) / shortest
            }
        }
    }

    /// `|κ|`, or none where the curve stands still.
    fn bending(&self, rho: f64) -> Option<f64> {
        let [_, velocity, acceleration] = self.jet(rho);
        let squared = dot(&velocity, &velocity);
        if squared <= (2.0 * self.highest_rate() * self.rounding()).powi(2) {
            return None;
        }
        let along = dot(&velocity, &acceleration) / squared;
        let across: [f64; D] =
            std::array::from_fn(|axis| acceleration[axis] - along * velocity[axis]);
        Some(norm(&across) / squared)
    }
}

impl Curve<'_, 2> {
    /// One by the radius of the circle that the curve follows at `rho` (1/px), positive where it turns from the
    /// x axis towards the y axis: in an image, whose y points down, to the right of its way. `None` where the
    /// first derivative vanishes.
    pub fn curvature(&self, rho: f64) -> Option<f64> {
        let [_, velocity, acceleration] = self.jet(rho);
        let turning = velocity[0] * acceleration[1] - velocity[1] * acceleration[0];
        self.bending(rho).map(|size| size.copysign(turning))
    }
}

impl Curve<'_, 3> {
    /// One by the radius of the circle that the curve follows at `rho`; never negative, as in space there is
    /// no side to turn to. `None` where the first derivative vanishes.
    pub fn curvature(&self, rho: f64) -> Option<f64> {
        self.bending(rho)
    }
}

pub(crate) fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|axis| a[axis] * b[axis]).sum()
}

pub(crate) fn norm<const D: usize>(v: &[f64; D]) -> f64 {
    dot(v, v).sqrt()
}

pub(crate) fn minus<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}
