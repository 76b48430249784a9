//! Target shapes for the rope. The rope has taken each of these shapes, so all of them can be
//! reached.

use std::f64::consts::{FRAC_PI_2, PI};
use std::str::FromStr;

use crate::gripper::{Pose, SpacePose};
use crate::options::{Options, OptionsError};
use crate::shape::{at_equal_steps, lay, poses};
use crate::simulation::Simulation;
use crate::space::{SpaceSimulation, lifted};
use lariat_portable::SplitMix64;

/// Named shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TargetShape {
    /// Both ends point up.
    U,
    /// Bent to one side, then to the other.
    S,
    /// Almost straight. A rope between two ends as far apart as it is long has no definite shape:
    /// its middle moves many times as far as a gripper does, to either side. This one therefore
    /// sags by a twentieth of its length.
    Line,
}

/// The name of the shape is unknown.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a target: choose u, s or line")]
pub struct NoTarget(String);

impl FromStr for TargetShape {
    type Err = NoTarget;

    fn from_str(name: &str) -> Result<Self, NoTarget> {
        match name {
            "u" => Ok(Self::U),
            "s" => Ok(Self::S),
            "line" => Ok(Self::Line),
            _ => Err(NoTarget(name.to_owned())),
        }
    }
}

/// Range of the heights of a 3-D target's ends, mm, and the maximum upward or downward tilt of the
/// rope there, rad.
const LIFTED_MM: [f64; 2] = [60.0, 110.0];
const TILTED_RAD: f64 = 0.35;

/// A shape, and the poses that lead to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Final poses of the grippers.
    pub poses: [Pose; 2],
    /// Part of the rope between the jaws, at equal steps of arc length, in pixels.
    pub points: Vec<[f64; 2]>,
}

/// A shape in 3-D, and the poses that lead to it.
#[derive(Debug, Clone, PartialEq)]
pub struct SpaceTarget {
    /// Final poses of the grippers.
    pub poses: [SpacePose; 2],
    /// Part of the rope between the jaws, at equal steps of arc length, in millimeters.
    pub points: Vec<[f64; 3]>,
}

impl TargetShape {
    /// Heading along the free part of the rope, in radians.
    fn heading(self, share: f64) -> f64 {
        match self {
            Self::U => FRAC_PI_2 * libm::cos(PI * share),
            // Shape of a rod whose ends are turned equally to the same side, without tension or
            // compression. With compression, other shapes would be possible.
            Self::S => 1.25 * (1.0 - 6.0 * share * (1.0 - share)),
            Self::Line => 0.15 * libm::cos(PI * share),
        }
    }

    /// Poses for a rope with these options: those of the shape, slightly moved and turned by the
    /// seed.
    fn poses(self, options: &Options) -> [Pose; 2] {
        let random = &mut SplitMix64::of_stream(options.seed, 2);
        let turn = random.uniform(-0.08, 0.08);
        let middle = options.middle([(); 2].map(|()| random.uniform(-0.03, 0.03)));
        let heading = |share: f64| turn + self.heading(share);
        let line = lay(options.nodes, options.segment_px(), middle, heading);
        poses(&line, heading)
    }

    /// Returns the shape that the rope with these options takes when it is slowly moved there from
    /// its start, as `points` points.
    ///
    /// # Errors
    /// Returns an error if an option is out of its range, or if there is a single gripper.
    pub fn reached(self, options: &Options, points: usize) -> Result<Target, OptionsError> {
        let mut simulation = Simulation::new(options)?;
        if options.grippers < 2 {
            return Err(OptionsError::OneGripper);
        }
        let poses = self.poses(options);
        simulation.drive_to(&poses);
        Ok(Target {
            poses,
            points: at_equal_steps(simulation.visible(), points),
        })
    }

    /// Returns the shape that a lifted rope takes. Seen from above, it is the same shape. Its ends
    /// are held at heights and tilts chosen by the seed, and the part between them sags.
    ///
    /// # Errors
    /// Returns the same errors as [`reached`](Self::reached).
    pub fn reached_in_space(
        self,
        options: &Options,
        points: usize,
    ) -> Result<SpaceTarget, OptionsError> {
        let mut simulation = SpaceSimulation::new(options)?;
        if options.grippers < 2 {
            return Err(OptionsError::OneGripper);
        }
        let random = &mut SplitMix64::of_stream(options.seed, 3);
        let poses = self.poses(options).map(|pose| {
            let height_mm = random.uniform(LIFTED_MM[0], LIFTED_MM[1]);
            let (sin, cos) = libm::sincos(random.uniform(-TILTED_RAD, TILTED_RAD));
            let level = lifted(options, &pose, height_mm);
            let [x, y, _] = level.along;
            SpacePose {
                along: [cos * x, cos * y, sin],
                ..level
            }
        });
        simulation.drive_to(&poses);
        Ok(SpaceTarget {
            poses,
            points: at_equal_steps(simulation.visible(), points),
        })
    }
}
