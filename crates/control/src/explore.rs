//! Finds the first Jacobian. Each input moves a short way out and back while the others stand
//! still. Its column is the slope of the shape over the input, by least squares over all images
//! taken during its motion (the exploratory motions of K. Hosoda, M. Asada, IROS 1994; H. Sutanto,
//! R. Sharma, V. Varma, ICRA 1997).
//!
//! Each image is assigned the input's position at its exposure, so neither delay nor a hold does
//! harm. A rope lags by the same amount out and back, in opposite directions, so the slope is
//! between the two.

use crate::estimator::{Learner, NONE};
use crate::jacobian::Jacobian;
use crate::limits::Limits;
use crate::options::Exploring;
use crate::pairs::Frame;
use crate::{Coordinates, Features, INPUTS, MAX_FEATURES};

/// Time that an input rests at home, s, so that the next motion begins with a rope at rest. The
/// rest is extended until an image has been exposed after this time.
const REST_S: f64 = 0.05;

/// An input turns around once it is within `OUT` times its reach of the far end, and counts as home
/// within `HOME` times its reach. The slope uses the input's actual position.
const OUT: f64 = 0.1;
const HOME: f64 = 0.04;

/// Rate at which a motion slows down towards its end, 1/s. It is lower if commands are so
/// infrequent that the input would overshoot.
const APPROACH: f64 = 30.0;

/// The motions of all inputs in turn.
#[derive(Debug, Clone)]
pub(crate) struct Explorer {
    exploring: Exploring,
    /// The input that is moving, or will move next.
    input: usize,
    leg: Option<Leg>,
}

/// Motion of one input.
#[derive(Debug, Clone)]
struct Leg {
    begun_ns: u64,
    home: f64,
    sign: f64,
    way: Way,
    /// Time spent on this part of the motion, s, without holds.
    moving_s: f64,
    second_try: bool,
    slope: Slope,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    Out,
    Back,
    Rest { until_ns: u64 },
}

impl Explorer {
    pub(crate) fn new(exploring: Exploring) -> Self {
        Self {
            exploring,
            input: 0,
            leg: None,
        }
    }

    /// Adds an image. After the last image of a leg, stores the input's column.
    pub(crate) fn take(&mut self, frame: &Frame, jacobian: &mut Jacobian, learner: &mut Learner) {
        let Some(leg) = &mut self.leg else {
            return;
        };
        if frame.at_ns < leg.begun_ns {
            return;
        }
        leg.slope.add(frame.r[self.input] - leg.home, frame);
        if !matches!(leg.way, Way::Rest { until_ns } if frame.at_ns >= until_ns) {
            return;
        }
        if leg.slope.most - leg.slope.least > 0.3 * self.exploring.reach_px {
            let (column, variance) = leg.slope.fit();
            jacobian.columns[self.input] = column;
            learner.measured(self.input, variance);
        } else if !leg.second_try {
            // There were too few images, or a border is in the way. Try the other direction.
            let (home, sign) = (leg.home, -leg.sign);
            *leg = Leg::new(frame.at_ns, home, sign);
            leg.second_try = true;
            return;
        }
        self.leg = None;
        self.input += 1;
    }

    /// Returns the input that moves now, and the velocities. Returns `None` when all have moved.
    pub(crate) fn drive(
        &mut self,
        now_ns: u64,
        dt_s: f64,
        r: &Coordinates,
        limits: &Limits,
    ) -> Option<(usize, Coordinates)> {
        let movable = limits.movable();
        while self.input < INPUTS && !movable[self.input] {
            self.input += 1;
        }
        let input = self.input;
        if input == INPUTS {
            return None;
        }
        let Exploring {
            reach_px,
            speed_px_s,
            ..
        } = self.exploring;
        let leg = self.leg.get_or_insert_with(|| {
            let mut out = *r;
            out[input] += reach_px;
            Leg::new(
                now_ns,
                r[input],
                if limits.allow(&out) { 1.0 } else { -1.0 },
            )
        });
        leg.moving_s += dt_s;
        let speed = speed_px_s.min(limits.speed(input));
        // After three times the expected duration, the input must be at a border.
        let late = leg.moving_s > 3.0 * reach_px / speed + 1.0;
        let mut velocity = NONE;
        let (goal, near) = match leg.way {
            Way::Out => (leg.home + leg.sign * reach_px, OUT * reach_px),
            Way::Back => (leg.home, HOME * reach_px),
            Way::Rest { .. } => return Some((input, velocity)),
        };
        let missing = goal - r[input];
        if missing.abs() <= near || late {
            leg.moving_s = 0.0;
            leg.way = match leg.way {
                Way::Out => Way::Back,
                _ => Way::Rest {
                    until_ns: now_ns.saturating_add((REST_S * 1e9) as u64),
                },
            };
            return Some((input, velocity));
        }
        let approach = APPROACH.min(0.5 / dt_s);
        let speed = speed.min(limits.stops_within(input, missing.abs()));
        velocity[input] = (approach * missing).clamp(-speed, speed);
        Some((input, velocity))
    }
}

impl Leg {
    fn new(begun_ns: u64, home: f64, sign: f64) -> Self {
        Self {
            begun_ns,
            home,
            sign,
            way: Way::Out,
            moving_s: 0.0,
            second_try: false,
            slope: Slope::EMPTY,
        }
    }
}

/// Sums for fitting a line through all images.
#[derive(Debug, Clone)]
struct Slope {
    count: f64,
    r: f64,
    rr: f64,
    s: Features,
    rs: Features,
    noise_px2: f64,
    least: f64,
    most: f64,
}

impl Slope {
    const EMPTY: Self = Self {
        count: 0.0,
        r: 0.0,
        rr: 0.0,
        s: [0.0; MAX_FEATURES],
        rs: [0.0; MAX_FEATURES],
        noise_px2: 0.0,
        least: 0.0,
        most: 0.0,
    };

    fn add(&mut self, r: f64, frame: &Frame) {
        if self.count == 0.0 {
            (self.least, self.most) = (r, r);
        }
        self.count += 1.0;
        self.r += r;
        self.rr += r * r;
        for (k, feature) in frame.features.iter().enumerate() {
            self.s[k] += feature;
            self.rs[k] += r * feature;
        }
        self.noise_px2 += frame.noise_px2;
        self.least = self.least.min(r);
        self.most = self.most.max(r);
    }

    /// Returns the slope of each coordinate, and the variance that noise causes in the slope, over
    /// the shape.
    fn fit(&self) -> (Features, f64) {
        let spread = self.rr - self.r * self.r / self.count;
        let slope =
            std::array::from_fn(|k| (self.rs[k] - self.r * self.s[k] / self.count) / spread);
        (slope, self.noise_px2 / self.count / spread)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::features;
    use crate::{Estimator, Robot};
    use lariat_portable::SplitMix64;

    /// Commands and images at 50/s, with images 100 ms late. The columns equal the map's up to
    /// noise, and all inputs return home.
    #[test]
    fn out_and_back_each_column_is_found_whatever_the_delay() {
        let robot: Robot<6> = Robot {
            grippers: 2,
            ..Robot::default()
        };
        let limits = Limits::new(&robot);
        let mut random = SplitMix64::new(5);
        let truth = Jacobian {
            columns: [(); INPUTS].map(|()| features(&mut random, 12)),
        };
        let mut explorer = Explorer::new(Exploring::default());
        let mut learner = Learner::new(Estimator::default());
        let mut jacobian = Jacobian::ZERO;
        let mut way = vec![NONE];
        let sigma = 0.2;
        for step in 0.. {
            let now_ns = step as u64 * 20_000_000;
            let then = step.max(5) - 5;
            let mut features = truth.times(&way[then]);
            features[..12]
                .iter_mut()
                .for_each(|s| *s += 300.0 + sigma * random.normal());
            let frame = Frame {
                features,
                r: way[then],
                at_ns: then as u64 * 20_000_000,
                noise_px2: 2.0 * sigma * sigma,
            };
            explorer.take(&frame, &mut jacobian, &mut learner);
            let r = way[step];
            let Some((_, velocity)) = explorer.drive(now_ns, 0.02, &r, &limits) else {
                break;
            };
            way.push(std::array::from_fn(|i| r[i] + 0.02 * velocity[i]));
            assert!(step < 1000, "{explorer:?}");
        }
        for (found, column) in jacobian.columns.iter().zip(&truth.columns) {
            for (found, entry) in found.iter().zip(column) {
                // Some 40 images over 13 px have a spread of more than 600 px². The bound is five
                // standard deviations.
                assert!(
                    (found - entry).abs() < 5.0 * sigma / 600f64.sqrt(),
                    "{found} {entry}"
                );
            }
        }
        assert!(
            way.last()
                .is_some_and(|r| r.iter().all(|r| r.abs() <= HOME * 13.0))
        );
    }
}
