//! Commanded positions of the grippers at every moment of the last second or so: the integral of
//! the velocities.
//!
//! An image shows the past. Its exposure time determines the matching `r`. A Jacobian is therefore
//! not learned from a shape and a pose of different moments, and an error that has been half
//! corrected since is not corrected twice.

use crate::{Coordinates, INPUTS};

/// Number of knots kept. Between them, the path is treated as straight.
const KNOTS: usize = 1024;

#[derive(Debug, Clone, Copy)]
struct Knot {
    at_ns: u64,
    r: Coordinates,
}

/// The grippers' path.
#[derive(Debug, Clone)]
pub(crate) struct History {
    /// A ring whose newest knot is before `next`.
    knots: Box<[Knot]>,
    next: usize,
    kept: usize,
    /// Minimum time between two knots, so that the ring covers the whole span.
    spacing_ns: u64,
    end: Knot,
    /// Velocity since `end`.
    velocity: Coordinates,
}

impl History {
    /// Creates a history of grippers that have always been at `start`. It remembers `span_s`
    /// seconds.
    pub(crate) fn new(start: Coordinates, span_s: f64) -> Self {
        let knot = Knot { at_ns: 0, r: start };
        Self {
            knots: vec![knot; KNOTS].into_boxed_slice(),
            next: 0,
            kept: 0,
            // Two knots fewer than the ring has: the newest may be just before the end, and the
            // oldest may just have been overwritten.
            spacing_ns: (span_s * 1e9) as u64 / (KNOTS as u64 - 2) + 1,
            end: knot,
            velocity: [0.0; INPUTS],
        }
    }

    /// Sets where the grippers have always been. Only valid before the first command.
    pub(crate) fn stand_at(&mut self, r: Coordinates) {
        self.end.r = r;
    }

    /// Sets the velocity from this time on. A time before the last one is treated as the last one.
    pub(crate) fn drive(&mut self, now_ns: u64, velocity: Coordinates) {
        self.advance(now_ns);
        self.velocity = velocity;
    }

    /// Returns the position at a time. A future position assumes that the velocity continues.
    /// Returns `None` if the time is no longer remembered.
    pub(crate) fn at(&self, at_ns: u64) -> Option<Coordinates> {
        if at_ns >= self.end.at_ns {
            return Some(along(&self.end, &self.velocity, at_ns));
        }
        let mut later = self.end;
        for back in 1..=self.kept {
            let knot = self.knots[(self.next + KNOTS - back) % KNOTS];
            if knot.at_ns <= at_ns {
                return Some(between(&knot, &later, at_ns));
            }
            later = knot;
        }
        // No knot has been overwritten, so this is before the first command, when the grippers
        // stood still.
        (self.kept < KNOTS).then_some(later.r)
    }

    /// Corrects the position at a time to a measured one, and shifts all later positions by the
    /// same amount.
    pub(crate) fn correct(&mut self, at_ns: u64, measured: Coordinates) {
        self.advance(at_ns);
        let Some(believed) = self.at(at_ns) else {
            return;
        };
        let shift = |r: &mut Coordinates| {
            for ((r, measured), believed) in r.iter_mut().zip(measured).zip(believed) {
                *r += measured - believed;
            }
        };
        shift(&mut self.end.r);
        for knot in self.knots.iter_mut().filter(|knot| knot.at_ns >= at_ns) {
            shift(&mut knot.r);
        }
    }

    fn advance(&mut self, now_ns: u64) {
        if self.kept == 0 {
            self.end.at_ns = now_ns;
            self.push();
        } else if now_ns > self.end.at_ns {
            self.end = Knot {
                at_ns: now_ns,
                r: along(&self.end, &self.velocity, now_ns),
            };
            let newest = self.knots[(self.next + KNOTS - 1) % KNOTS];
            if now_ns - newest.at_ns >= self.spacing_ns {
                self.push();
            }
        }
    }

    fn push(&mut self) {
        self.knots[self.next] = self.end;
        self.next = (self.next + 1) % KNOTS;
        self.kept = (self.kept + 1).min(KNOTS);
    }
}

fn along(from: &Knot, velocity: &Coordinates, at_ns: u64) -> Coordinates {
    let seconds = (at_ns - from.at_ns) as f64 * 1e-9;
    std::array::from_fn(|i| from.r[i] + seconds * velocity[i])
}

fn between(a: &Knot, b: &Knot, at_ns: u64) -> Coordinates {
    let share = (at_ns - a.at_ns) as f64 / (b.at_ns - a.at_ns).max(1) as f64;
    std::array::from_fn(|i| a.r[i] + share * (b.r[i] - a.r[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::coordinates;
    use lariat_portable::SplitMix64;

    const START: Coordinates = [
        1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0,
    ];

    fn near(a: Option<Coordinates>, b: Coordinates, px: f64) {
        let a = a.expect("remembered");
        for (a, b) in a.into_iter().zip(b) {
            assert!((a - b).abs() <= px, "{a} is not {b}");
        }
    }

    #[test]
    fn the_way_is_the_integral_of_the_velocities_at_every_moment() {
        let mut history = History::new(START, 0.6);
        let mut random = SplitMix64::new(7);
        let mut way = vec![(1_000_000_000u64, START, [0.0; INPUTS])];
        for _ in 0..2000 {
            let velocity = coordinates(&mut random).map(|v| 100.0 * v);
            let &(t_ns, r, before) = way.last().expect("not empty");
            let next_ns = t_ns + 200_000 + (8_000_000.0 * random.unit()) as u64;
            let seconds = (next_ns - t_ns) as f64 * 1e-9;
            let r = std::array::from_fn(|i| r[i] + seconds * before[i]);
            way.push((next_ns, r, velocity));
            history.drive(next_ns, velocity);
            for _ in 0..3 {
                let at_ns = next_ns - (600_000_000.0 * random.unit()) as u64;
                let after = way.partition_point(|(t_ns, ..)| *t_ns <= at_ns);
                let wanted = match after.checked_sub(1) {
                    None => START,
                    Some(last) => {
                        let (t_ns, r, velocity) = way[last];
                        let seconds = (at_ns - t_ns) as f64 * 1e-9;
                        std::array::from_fn(|i| r[i] + seconds * velocity[i])
                    }
                };
                // Between knots, 0.6 ms apart, a velocity may change by 200 px/s.
                near(history.at(at_ns), wanted, 0.12);
            }
        }
    }

    #[test]
    fn what_is_forgotten_is_not_made_up() {
        let mut history = History::new(START, 0.5);
        assert_eq!(history.at(0), Some(START));
        for ms in 0..3000u64 {
            history.drive(ms * 1_000_000, [1.0; INPUTS]);
        }
        assert!(history.at(2_400_000_000).is_some());
        assert_eq!(history.at(100_000_000), None);
    }

    #[test]
    fn a_measured_place_moves_all_since() {
        let mut history = History::new([0.0; INPUTS], 0.5);
        for ms in 0..100u64 {
            history.drive(ms * 1_000_000, [1000.0; INPUTS]);
        }
        history.correct(50_000_000, [60.0; INPUTS]);
        near(history.at(20_000_000), [20.0; INPUTS], 1e-6);
        near(history.at(50_000_000), [60.0; INPUTS], 1e-6);
        near(history.at(99_000_000), [109.0; INPUTS], 1e-6);
        near(history.at(101_000_000), [111.0; INPUTS], 1e-6);
    }

    #[test]
    fn time_that_goes_back_moves_nothing() {
        let mut history = History::new(START, 0.5);
        history.drive(1_000_000_000, [50.0; INPUTS]);
        history.drive(500_000_000, [0.0; INPUTS]);
        near(history.at(2_000_000_000), START, 0.0);
    }
}
