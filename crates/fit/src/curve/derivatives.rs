//! Points, tangents and curvatures of a curve.

use super::Curve;
use crate::basis::Basis;

impl<const D: usize> Curve<'_, D> {
    /// The point at `rho`, in the control points' unit (px).
    pub fn point(&self, rho: f64) -> [f64; D] {
        let [point] = self.jet(rho);
        point
    }

    /// The `k`-th derivative with respect to ρ at `rho`, `k` from 0 (the point itself) to 3; `NaN`
    /// for higher ones. At a junction of two pieces, it is that of the later piece.
    pub fn derivative(&self, rho: f64, k: usize) -> [f64; D] {
        let jet: [_; 4] = self.jet(rho);
        jet.get(k).copied().unwrap_or([f64::NAN; D])
    }

    /// The direction of the curve at `rho`, of length 1.
    ///
    /// If the first derivative vanishes (a cusp, or coincident control points), this is the
    /// direction in which the curve continues or, at its end, arrives. It is computed from the
    /// lowest derivative, up to the third, that does not vanish. `None` if all vanish, as for a
    /// curve that is a point.
    pub fn tangent(&self, rho: f64) -> Option<[f64; D]> {
        let jet: [_; 4] = self.jet(rho);
        let rounding = self.rounding();
        // Derivatives with respect to ρ grow with order and pieces, and so does their rounding
        // error.
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

    /// Upper bound of a coordinate's rounding error.
    pub(crate) fn rounding(&self) -> f64 {
        let largest = self.control_points.iter().flatten();
        let largest = largest.fold(0.0f64, |size, c| size.max(c.abs()));
        8.0 * f64::EPSILON * self.control_points.len() as f64 * largest
    }

    /// Maximum ratio of a derivative to the previous one.
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

    /// `|κ|`; `None` if the first derivative vanishes.
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
    /// Curvature at `rho`: the reciprocal radius of the osculating circle (1/px). It is positive if
    /// the curve turns from the x axis towards the y axis: to the right in an image, where y points
    /// down. `None` if the first derivative vanishes.
    pub fn curvature(&self, rho: f64) -> Option<f64> {
        let [_, velocity, acceleration] = self.jet(rho);
        let turning = velocity[0] * acceleration[1] - velocity[1] * acceleration[0];
        self.bending(rho).map(|size| size.copysign(turning))
    }
}

impl Curve<'_, 3> {
    /// Curvature at `rho`: the reciprocal radius of the osculating circle. It is never negative,
    /// because a turn in 3-D has no side. `None` if the first derivative vanishes.
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
