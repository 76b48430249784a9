//! Simulates a rope in real time, held by grippers that take commands, and draws it as a camera
//! would see it.
//!
//! As with a camera, a frame shows the scene at the frame's moment. The simulation runs up to that
//! moment, and each command takes effect at the time when it was sent. Between frames, the
//! simulation follows slightly behind the clock, so that little work remains when the moment comes.

mod world;

use std::collections::VecDeque;

use lariat_drawn::HandOptions;
use lariat_message::{
    Centerlines, Command, Descriptors3, MAX_POINTS, PixelFormat, SourceKind, now_ns,
};
use lariat_simulation::{OptionsError, STEP_NS};

use crate::pace::{Pace, Pacer};
use crate::source::{Frame, FrameSource, Next, SourceError};
use crate::until::{Until, Woken};
use world::World;

/// Interval at which commands are read between two frames. Even at 1000 commands per second, fewer
/// arrive in this time than the queue holds.
const LOOK_NS: u64 = 4_000_000;
/// Lag behind the clock between frames. A command thus arrives before the simulation reaches the
/// time when it was sent.
const BEHIND_NS: u64 = 3_000_000;
/// Maximum lead of a command's time over the clock. A command with a later time counts as sent now.
const FARTHEST_NS: u64 = 1_000_000_000;
/// Maximum number of commands kept; older ones are dropped.
const MOST_COMMANDS: usize = 64;

/// Source of commands. Returns the oldest one that waits, or `None`. Never blocks.
pub type Commands = Box<dyn FnMut() -> Option<Command> + Send>;

/// Options of the simulation and its camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulatedOptions {
    /// The rope, the table and the robot. The picture's width and height are integers from 200 to
    /// 8192 pixels.
    pub simulation: lariat_simulation::Options,
    /// True if the rope is lifted and is also seen by a depth camera. A pixel is then a millimeter
    /// of the table.
    pub lifted: bool,
    /// Rate at which the camera takes pictures.
    pub pace: Pace,
    /// Standard deviation of the camera's noise, in 8-bit levels, 0 to 4.
    pub noise: f64,
    /// A hand that covers the rope.
    pub hand: Option<HandOptions>,
    /// Number of points on the true centerline, 2 to 256.
    pub truth_points: u32,
}

impl Default for SimulatedOptions {
    fn default() -> Self {
        Self {
            simulation: lariat_simulation::Options::default(),
            lifted: false,
            pace: Pace::Fps(30.0),
            noise: 2.5,
            hand: None,
            truth_points: 120,
        }
    }
}

/// Opens a simulated rope that is moved by commands. Without commands it rests.
///
/// # Errors
/// An option is out of range.
pub fn open_simulated(
    options: &SimulatedOptions,
    commands: Commands,
) -> Result<Box<dyn FrameSource>, SourceError> {
    Ok(Box::new(Simulated::new(options, commands)?))
}

pub(crate) struct Simulated {
    world: World,
    commands: Commands,
    /// Commands whose moment has not come.
    waiting: VecDeque<Command>,
    pacer: Pacer,
    /// Moment of the first frame, at which the simulation starts.
    start_ns: Option<u64>,
    /// The moment of the next frame.
    due_ns: Option<u64>,
    sequence: u64,
    truth_points: usize,
}

impl Simulated {
    pub(crate) fn new(options: &SimulatedOptions, commands: Commands) -> Result<Self, SourceError> {
        if !(2..=MAX_POINTS as u32).contains(&options.truth_points) {
            let what = format!(
                "2 to {MAX_POINTS} points of truth, not {}",
                options.truth_points
            );
            return Err(OptionsError::OutOfRange { what }.into());
        }
        if !(0.0..=4.0).contains(&options.noise) {
            let what = format!("noise from 0 to 4, not {}", options.noise);
            return Err(OptionsError::OutOfRange { what }.into());
        }
        let pacer = Pacer::new(options.pace).map_err(|error| OptionsError::OutOfRange {
            what: format!("a camera's rate, but {error}"),
        })?;
        Ok(Self {
            world: World::new(options)?,
            commands,
            waiting: VecDeque::with_capacity(MOST_COMMANDS),
            pacer,
            start_ns: None,
            due_ns: None,
            sequence: 0,
            truth_points: options.truth_points as usize,
        })
    }

    /// Reads the commands that have arrived.
    fn hear(&mut self) {
        while let Some(mut command) = (self.commands)() {
            let now_ns = now_ns();
            if command.sent_ns > now_ns.saturating_add(FARTHEST_NS) {
                // Otherwise, later commands would wait for its moment.
                command.sent_ns = now_ns;
            }
            if self.waiting.len() == MOST_COMMANDS {
                self.waiting.pop_front();
            }
            self.waiting.push_back(command);
        }
    }

    /// Simulates up to a moment.
    fn go_on_to(&mut self, moment_ns: u64) {
        let Some(start_ns) = self.start_ns else {
            return;
        };
        loop {
            let now_ns = start_ns + self.world.steps() * STEP_NS;
            if now_ns + STEP_NS > moment_ns {
                return;
            }
            while let Some(command) = self.waiting.front().filter(|next| next.sent_ns <= now_ns) {
                self.world.command(command);
                self.waiting.pop_front();
            }
            self.world.step();
        }
    }

    /// Waits for a frame's moment and simulates meanwhile. Returns `false` if the wait ended early.
    fn wait_for(&mut self, due_ns: u64, until: &Until) -> bool {
        loop {
            self.hear();
            let now_ns = now_ns();
            if now_ns >= due_ns {
                return true;
            }
            self.go_on_to(now_ns.saturating_sub(BEHIND_NS));
            let look_ns = due_ns.min(now_ns + LOOK_NS);
            if until.wait(None, Some(look_ns)) == Woken::Interrupted {
                return false;
            }
        }
    }

    fn frame(&self, exposed_ns: u64) -> Frame {
        let [width, height] = self.world.size();
        Frame {
            sequence: self.sequence,
            width,
            height,
            stride: 3 * width,
            format: PixelFormat::Rgb8,
            exposed_ns: Some(exposed_ns),
            slot: None,
        }
    }
}

impl FrameSource for Simulated {
    fn kind(&self) -> SourceKind {
        SourceKind::Rendered
    }

    fn largest_frame_bytes(&self) -> usize {
        self.frame(0).bytes()
    }

    fn has_truth(&self) -> bool {
        true
    }

    fn advance(&mut self, until: &Until) -> Result<Next, SourceError> {
        let now_ns = now_ns();
        let due_ns = match self.due_ns {
            Some(due_ns) => due_ns,
            None => {
                // A camera takes its next picture even if the reader is late for this one.
                self.sequence += 1 + self.pacer.give_up(now_ns);
                self.pacer.next_due_ns(now_ns)
            }
        };
        self.due_ns = Some(due_ns);
        let start_ns = *self.start_ns.get_or_insert(due_ns);
        if !self.wait_for(due_ns, until) {
            return Ok(Next::Nothing);
        }
        self.due_ns = None;
        self.go_on_to(due_ns);
        let time_s = (due_ns - start_ns) as f64 * 1e-9;
        self.world.draw(time_s);
        Ok(Next::Frame(self.frame(due_ns)))
    }

    fn write(&mut self, pixels: &mut [u8]) {
        self.world.write(self.sequence, pixels);
    }

    fn truth(&self, message: &mut Centerlines) -> bool {
        self.world.truth(self.truth_points, message)
    }

    fn depth_size(&self) -> Option<[u32; 2]> {
        self.world.depth_size()
    }

    fn write_depth(&mut self, units: &mut [u8]) {
        self.world.write_depth(self.sequence, units);
    }

    fn truth_in_space(&self, message: &mut Descriptors3) -> bool {
        self.world.truth_in_space(self.truth_points, message)
    }
}
