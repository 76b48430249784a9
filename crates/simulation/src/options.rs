//! Parameters of the simulation, and limits of the robot.

/// Maximum number of grippers.
pub const MAX_GRIPPERS: usize = 2;

/// Parameters of the rope, the table and the robot. One pixel corresponds to one millimeter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Seed that selects the rope's start position.
    pub seed: u64,
    /// Number of grippers that hold the rope: 1 or 2.
    pub grippers: usize,
    /// Length of the rope from end to end in pixels: at least 100, and at most two thirds of the
    /// smaller of the picture's width and 4/3 of its height.
    pub length_px: f64,
    /// Number of nodes of the rope, 21 to 201. Their spacing is half the length of the jaws.
    pub nodes: usize,
    /// Bending stiffness divided by the mass per length, in m⁴/s²: 0.01 to 1. A cable of 30 g/m
    /// with 3 mN m² has 0.1.
    pub stiffness: f64,
    /// Coefficient of friction with the table, 0 to 1.
    pub friction: f64,
    /// Width and height of the picture in pixels, each 200 to 8192. The rope starts in the middle
    /// of the picture.
    pub picture_px: [f64; 2],
    /// Limits of the robot.
    pub limits: Limits,
}

/// Limits of a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Maximum speed of a gripper, in px/s: above 0, at most 300.
    pub speed_px_s: f64,
    /// Maximum turn rate of a gripper, in rad/s: above 0, at most 3.
    pub turn_rad_s: f64,
    /// Time for which the robot keeps moving without a new command, in seconds.
    pub watchdog_s: f64,
    /// Minimum distance of a gripper from the picture's edge, in pixels: less than a quarter of the
    /// picture.
    pub margin_px: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            speed_px_s: 150.0,
            turn_rad_s: 1.5,
            watchdog_s: 0.25,
            margin_px: 30.0,
        }
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            seed: 1,
            grippers: 2,
            length_px: 390.0,
            nodes: 61,
            stiffness: 0.1,
            friction: 0.2,
            picture_px: [640.0, 480.0],
            limits: Limits::default(),
        }
    }
}

/// Reason why a simulation is impossible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OptionsError {
    /// A number out of its range.
    #[error("the simulated rope needs {what}")]
    OutOfRange {
        /// What is required, and what was requested.
        what: String,
    },
    /// The shape needs two grippers.
    #[error("one gripper cannot give a rope a shape: take two")]
    OneGripper,
}

impl Options {
    /// Length of a segment.
    pub(crate) fn segment_px(&self) -> f64 {
        self.length_px / (self.nodes - 1) as f64
    }

    /// Range of the grippers: minimum and maximum of x and of y.
    pub(crate) fn workspace_px(&self) -> [[f64; 2]; 2] {
        let margin_px = self.limits.margin_px;
        self.picture_px.map(|size| [margin_px, size - margin_px])
    }

    /// Middle of the picture, offset by these shares of the picture.
    pub(crate) fn middle(&self, aside: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|axis| {
            let size = self.picture_px[axis];
            size / 2.0 + aside[axis] * size
        })
    }

    pub(crate) fn check(&self) -> Result<(), OptionsError> {
        let [width, height] = self.picture_px;
        let longest_px = (2.0 / 3.0) * width.min(4.0 / 3.0 * height);
        let smallest = width.min(height);
        let limits = self.limits;
        within("1 or 2 grippers", self.grippers as f64, 1.0, 2.0)?;
        within("a picture 200 to 8192 px wide", width, 200.0, 8192.0)?;
        within("a picture 200 to 8192 px high", height, 200.0, 8192.0)?;
        let length = format!("a length of 100 to {longest_px:.0} px in this picture");
        within(&length, self.length_px, 100.0, longest_px)?;
        within("21 to 201 nodes", self.nodes as f64, 21.0, 201.0)?;
        within("a stiffness of 0.01 to 1 m⁴/s²", self.stiffness, 0.01, 1.0)?;
        within("a friction of 0 to 1", self.friction, 0.0, 1.0)?;
        let (speed, turn) = (limits.speed_px_s, limits.turn_rad_s);
        within("a robot of up to 300 px/s", speed, 1e-3, 300.0)?;
        within("a robot of up to 3 rad/s", turn, 1e-3, 3.0)?;
        within(
            "a watchdog of up to an hour",
            limits.watchdog_s,
            0.0,
            3600.0,
        )?;
        let margin = limits.margin_px;
        within(
            "a margin below a quarter of the picture",
            margin,
            0.0,
            smallest / 4.0,
        )
    }
}

fn within(what: &str, value: f64, low: f64, high: f64) -> Result<(), OptionsError> {
    // Also false for NaN.
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(OptionsError::OutOfRange {
        what: format!("{what}, not {value}"),
    })
}
