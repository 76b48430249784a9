//! What is simulated, and how the robot is limited.

/// Most grippers.
pub const MAX_GRIPPERS: usize = 2;

/// The rope, the table and the robot. One pixel is taken to be one millimetre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Which of all starts.
    pub seed: u64,
    /// How many grippers hold the rope: 1 or 2.
    pub grippers: usize,
    /// Length of the rope from end to end in pixels: 100 to two thirds of the picture's width, and of 4/3 of its height.
    pub length_px: f64,
    /// How many nodes the rope is made of, 21 to 201. They are as far apart as the jaws are half long.
    pub nodes: usize,
    /// Bending stiffness by mass of length, in m⁴/s²: 0.01 to 1. A cable of 30 g/m that needs 3 mN m² has 0.1.
    pub stiffness: f64,
    /// Coefficient of friction with the table, 0 to 1.
    pub friction: f64,
    /// Width and height of the picture in pixels, each 200 to 8192: the rope starts in the middle of it.
    pub picture_px: [f64; 2],
    /// What the robot allows itself.
    pub limits: Limits,
}

/// What a robot allows itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The fastest that a gripper goes, in px/s: above 0, at most 300.
    pub speed_px_s: f64,
    /// The fastest that it turns, in rad/s: above 0, at most 3.
    pub turn_rad_s: f64,
    /// How long it goes on without a command, in seconds.
    pub watchdog_s: f64,
    /// How near to the picture's edge a gripper goes, in pixels: less than a quarter of the picture.
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

/// What cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OptionsError {
    /// A number out of its range.
    #[error("the simulated rope needs {what}")]
    OutOfRange {
        /// What is needed, and what was asked.
        what: String,
    },
    /// A shape that one gripper cannot give a rope.
    #[error("one gripper cannot give a rope a shape: take two")]
    OneGripper,
}

impl Options {
    /// Length of a segment.
    pub(crate) fn segment_px(&self) -> f64 {
        self.length_px / (self.nodes - 1) as f64
    }

    /// Where grippers may go: the lowest and the highest x, and y.
    pub(crate) fn workspace_px(&self) -> [[f64; 2]; 2] {
        let margin_px = self.limits.margin_px;
        self.picture_px.map(|size| [margin_px, size - margin_px])
    }

    /// The picture's middle, or what is aside of it by these shares of the picture.
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
    // Also false for what is no number.
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(OptionsError::OutOfRange {
        what: format!("{what}, not {value}"),
    })
}
