//! The simulated world and its cameras: a rope on a table under a camera, or a lifted rope in front
//! of a color and a depth camera.

use lariat_drawn::{Scene, SpaceScene};
use lariat_message::{Centerlines, Command, Descriptors3, MAX_GRIPPERS};
use lariat_simulation::{OptionsError, Simulation, SpaceSimulation};

use super::SimulatedOptions;

pub(super) enum World {
    Flat(Box<(Simulation, Scene)>),
    Lifted(Box<(SpaceSimulation, SpaceScene)>),
}

impl World {
    pub(super) fn new(options: &SimulatedOptions) -> Result<Self, OptionsError> {
        if options.lifted {
            if options.hand.is_some() {
                let what = "no hand where it is lifted: leave hand_at_s out".to_owned();
                return Err(OptionsError::OutOfRange { what });
            }
            let simulation = SpaceSimulation::new(&options.simulation)?;
            let scene = SpaceScene::new(&simulation, options.noise);
            return Ok(Self::Lifted(Box::new((simulation, scene))));
        }
        let simulation = Simulation::new(&options.simulation)?;
        let scene = Scene::new(&simulation, options.noise, options.hand);
        Ok(Self::Flat(Box::new((simulation, scene))))
    }

    pub(super) fn steps(&self) -> u64 {
        match self {
            Self::Flat(of) => of.0.steps(),
            Self::Lifted(of) => of.0.steps(),
        }
    }

    pub(super) fn step(&mut self) {
        match self {
            Self::Flat(of) => of.0.step(),
            Self::Lifted(of) => of.0.step(),
        }
    }

    pub(super) fn command(&mut self, command: &Command) {
        let asked = command.velocities();
        match self {
            Self::Flat(of) => {
                let mut in_plane = [[0.0; 3]; MAX_GRIPPERS];
                for (to, &[x, y, .., turn]) in in_plane.iter_mut().zip(asked) {
                    *to = [x, y, turn];
                }
                of.0.command(&in_plane[..asked.len()]);
            }
            Self::Lifted(of) => of.0.command(asked),
        }
    }

    /// Draws the world, `time_s` after the first frame.
    pub(super) fn draw(&mut self, time_s: f64) {
        match self {
            Self::Flat(of) => of.1.draw(&of.0, time_s),
            Self::Lifted(of) => of.1.draw(&of.0),
        }
    }

    pub(super) fn size(&self) -> [u32; 2] {
        match self {
            Self::Flat(of) => of.1.size(),
            Self::Lifted(of) => of.1.size(),
        }
    }

    pub(super) fn write(&self, sequence: u64, pixels: &mut [u8]) {
        match self {
            Self::Flat(of) => of.1.write(sequence, pixels),
            Self::Lifted(of) => of.1.write(sequence, pixels),
        }
    }

    pub(super) fn truth(&self, points: usize, truth: &mut Centerlines) -> bool {
        match self {
            Self::Flat(of) => of.1.truth(&of.0, points, truth),
            Self::Lifted(of) => of.1.truth(points, truth),
        }
    }

    pub(super) fn depth_size(&self) -> Option<[u32; 2]> {
        match self {
            Self::Flat(_) => None,
            Self::Lifted(of) => Some(of.1.depth_size()),
        }
    }

    pub(super) fn write_depth(&self, sequence: u64, units: &mut [u8]) {
        if let Self::Lifted(of) = self {
            of.1.write_depth(sequence, units);
        }
    }

    pub(super) fn truth_in_space(&self, points: usize, truth: &mut Descriptors3) -> bool {
        match self {
            Self::Flat(_) => false,
            Self::Lifted(of) => of.1.truth_in_space(points, truth),
        }
    }
}
