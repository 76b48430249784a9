//! What a servo knows, told to others, and what others know, told to it.

use super::Phase;
use super::Servo;
use super::sight::FARTHEST_PX;
use crate::INPUTS;
use crate::error::ServoError;
use crate::estimator::NONE;

/// A Jacobian that is handed over is right to a fifth: of a rope that is held a little otherwise.
const KNOWN_VARIANCE: f64 = 0.04;

impl<const A: usize> Servo<A> {
    /// The robot says where its grippers were at a moment of the last second or so: what was commanded since then counts from
    /// there. Without it they are where the commands have led them. Values that are not finite, and moments that are not yet, are passed over.
    pub fn robot_is_at(&mut self, poses: &[[f64; A]; 2], at_ns: u64) {
        let near = |c: &f64| c.abs() <= FARTHEST_PX;
        if !poses.as_flattened().iter().all(near) {
            return;
        }
        let measured = self.limits.gather(poses);
        match self.commanded {
            None => self.history.stand_at(measured),
            Some(last) if at_ns <= last.at_ns.saturating_add(1_000_000_000) => {
                let at_ns = at_ns.saturating_sub(self.delay_ns());
                self.history.correct(at_ns, measured);
            }
            Some(_) => {}
        }
    }

    /// Where the grippers are by the commands so far: x px, y px, θ rad; in space mm, and turns.
    pub fn poses(&self, now_ns: u64) -> [[f64; A]; 2] {
        let at_ns = now_ns.saturating_sub(self.delay_ns());
        self.limits.spread(&self.history.at(at_ns).unwrap_or(NONE))
    }

    /// What is known of `∂s/∂r`: the answer of coordinate `feature` of the shape to each coordinate of each gripper, in px/px, px/px,
    /// px/rad, of a row of `A`. `None` while it is explored, and for a coordinate that is not there.
    pub fn jacobian(&self, feature: usize) -> Option<[[f64; A]; 2]> {
        if self.phase == Phase::Exploring || feature >= self.size {
            return None;
        }
        let row = self.jacobian.columns.map(|column| column[feature]);
        Some(self.limits.spread_row(&row))
    }

    /// Takes `∂s/∂r` for known, of another run with the same rope held alike: a row for each coordinate of the shape, as
    /// [`jacobian`](Self::jacobian) has them. It steers from the first image on.
    ///
    /// # Errors
    /// Another number of rows than the target has coordinates, or entries that are no numbers.
    pub fn know(&mut self, rows: &[[[f64; A]; 2]]) -> Result<(), ServoError> {
        let finite = rows
            .as_flattened()
            .as_flattened()
            .iter()
            .all(|c| c.abs() <= FARTHEST_PX);
        if rows.len() != self.size || !finite {
            return Err(ServoError::NotAJacobian {
                given: rows.len(),
                expected: self.size,
            });
        }
        let movable = self.limits.movable();
        for (feature, row) in rows.iter().enumerate() {
            let row = self.limits.gather_row(row);
            for input in (0..INPUTS).filter(|input| movable[*input]) {
                self.jacobian.columns[input][feature] = row[input];
            }
        }
        for input in (0..INPUTS).filter(|input| movable[*input]) {
            self.learner.measured(input, KNOWN_VARIANCE);
        }
        self.phase = Phase::Steering;
        Ok(())
    }
}
