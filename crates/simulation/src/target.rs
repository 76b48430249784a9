//! Shapes to drive the rope to. Each is one that the rope has taken, so that it can be reached.

use std::f64::consts::{FRAC_PI_2, PI};
use std::str::FromStr;

use crate::gripper::{Pose, SpacePose};
use crate::options::{Options, OptionsError};
use crate::shape::{at_equal_steps, lay, poses};
use crate::simulation::Simulation;
use crate::space::{SpaceSimulation, lifted};
use lariat_portable::SplitMix64;

/// The shapes that have names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TargetShape {
    /// Both ends upwards.
    U,
    /// Bent to one side, then to the other.
    S,
    /// All but straight. A rope between two ends as far apart as it is long has no shape of its own: it moves by many
    /// times as much as a gripper does, to either side. So this one hangs by a twentieth of its length.
    Line,
}

/// An unknown name.
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

/// How high the ends of a target in space are held, mm, and by how much the rope leaves them upwards or downwards, rad.
const LIFTED_MM: [f64; 2] = [60.0, 110.0];
const TILTED_RAD: f64 = 0.35;

/// A shape, and how the rope was brought there.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// The poses that the grippers went to.
    pub poses: [Pose; 2],
    /// The part of the rope between the jaws, at equal steps of arc length, in pixels.
    pub points: Vec<[f64; 2]>,
}

/// A shape in space, and how the rope was brought there.
#[derive(Debug, Clone, PartialEq)]
pub struct SpaceTarget {
    /// The poses that the grippers went to.
    pub poses: [SpacePose; 2],
    /// The part of the rope between the jaws, at equal steps of arc length, in millimetres.
    pub points: Vec<[f64; 3]>,
}

impl TargetShape {
    /// Heading along the free part of the rope, in radians.
    fn heading(self, share: f64) -> f64 {
        match self {
            Self::U => FRAC_PI_2 * libm::cos(PI * share),
            // What a rod does whose ends are turned by as much to the same side and neither pulled nor pushed: with a push it
            // could as well take other shapes.
            Self::S => 1.25 * (1.0 - 6.0 * share * (1.0 - share)),
            Self::Line => 0.15 * libm::cos(PI * share),
        }
    }

    /// The poses for a rope of these options: the shape's own, a little moved and turned by the seed.
    fn poses(self, options: &Options) -> [Pose; 2] {
        let random = &mut SplitMix64::of_stream(options.seed, 2);
        let turn = random.uniform(-0.08, 0.08);
        let middle = options.middle([(); 2].map(|()| random.uniform(-0.03, 0.03)));
        let heading = |share: f64| turn + self.heading(share);
        let line = lay(options.nodes, options.segment_px(), middle, heading);
        poses(&line, heading)
    }

    /// The shape as the rope of these options takes it, when it is taken there slowly from its start: so many points.
    ///
    /// # Errors
    /// Options out of their ranges, or a single gripper.
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

    /// The same as a lifted rope takes it: seen from above it is the shape, its ends held at heights and tilts of the seed, and what
    /// is between hangs.
    ///
    /// # Errors
    /// As [`reached`](Self::reached).
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
