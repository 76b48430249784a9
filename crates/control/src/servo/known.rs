//! Exchange of knowledge with the caller: poses of the grippers, and the Jacobian.

use super::Phase;
use super::Servo;
use super::sight::FARTHEST_PX;
use crate::INPUTS;
use crate::error::ServoError;
use crate::estimator::NONE;

/// Variance of a Jacobian that the caller provides. Its entries are assumed accurate to a fifth, as
/// for a rope that is held slightly differently.
const KNOWN_VARIANCE: f64 = 0.04;

impl<const A: usize> Servo<A> {
    /// Reports where the grippers were at a time within the last second or so. The servo adds the
    /// commands given since then. Without this report, it assumes that the grippers have followed
    /// the commands. It ignores values that are not finite and times in the future.
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

    /// Returns the grippers' poses according to the commands so far: x px, y px, θ rad; in 3-D, mm
    /// and turns.
    pub fn poses(&self, now_ns: u64) -> [[f64; A]; 2] {
        let at_ns = now_ns.saturating_sub(self.delay_ns());
        self.limits.spread(&self.history.at(at_ns).unwrap_or(NONE))
    }

    /// Returns the known row of `∂s/∂r` for coordinate `feature` of the shape: its response to each
    /// coordinate of each gripper, in px/px, px/px, px/rad. Returns `None` during exploration, and
    /// if there is no such coordinate.
    pub fn jacobian(&self, feature: usize) -> Option<[[f64; A]; 2]> {
        if self.phase == Phase::Exploring || feature >= self.size {
            return None;
        }
        let row = self.jacobian.columns.map(|column| column[feature]);
        Some(self.limits.spread_row(&row))
    }

    /// Sets `∂s/∂r` from another run with the same rope, held in the same way. There is one row for
    /// each coordinate of the shape, as returned by [`jacobian`](Self::jacobian). The servo then
    /// steers from the first image on.
    ///
    /// # Errors
    /// Fails if the number of rows is not the number of the target's coordinates, or if an entry is
    /// not finite.
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
