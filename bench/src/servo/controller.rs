//! The controller as a process: it reads descriptors through the public reader and sends
//! velocities. It knows its robot and its target. Its only knowledge of the rope comes from the
//! camera.

mod observer;
mod space;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use clap::Args;
use lariat_control::{
    Command as Wish, Doing, Estimator, Metric, Observation, Options, Robot, Servo, Weights, Why,
    Workspace,
};
use lariat_wire::{COMMANDS, Command, Delivery, Domain, Writer, now_ns};

use super::job::{Job, Learner, Robot as Known, Wanted};
use lariat_chain::output::print;
use lariat_chain::settings::{Flags, Settings};
use lariat_chain::stop::Stop;
use observer::{Observer, Sight};

/// Maximum time between two commands, so that the robot's watchdog does not stop it.
const BEAT: Duration = Duration::from_millis(20);
/// Distance from the target, in the controller's own metric, at which the rope has arrived.
const TOLERANCE_PX: f64 = 1.5;
/// Number of rows of a curve's basis that the metric is computed from.
const METRIC_ROWS: usize = 64;

/// Arguments of the controller.
#[derive(Debug, Args)]
pub(crate) struct ControllerArgs {
    /// File that describes the job
    #[arg(long, value_name = "FILE")]
    job: PathBuf,
    /// The chain that it reads.
    #[command(flatten)]
    chain: Flags,
}

/// Steers until a signal arrives.
pub(crate) fn run(args: &ControllerArgs) -> Result<ExitCode> {
    let job = Job::read(&args.job)?;
    let settings = Settings::resolve(&args.chain)?;
    let stop = Stop::on_signals()?;
    let domain = Domain::open()?;
    let rig = settings.run.rig.parse().context("the rig has no name")?;
    let mut link = Link {
        robot: Writer::<Command>::create(&domain, &rig, &COMMANDS, &Delivery::NewestWins)?,
        count: 0,
        said: None,
    };
    match &job.wanted {
        Wanted::InSpace { target, robot } => {
            let mut pilot = space::Pilot::open(&settings, &job, target, robot)?;
            while !stop.asked() {
                let (wish, exposed_ns) = pilot.decide(Instant::now() + BEAT)?;
                let twists = pilot.twists(&wish);
                link.tell(twists, exposed_ns, robot.start.len(), wish.doing)?;
            }
        }
        Wanted::InPlane { target, robot } => {
            let mut observer = Observer::open(&settings, &job, target)?;
            let options = options(&job, robot, observer.metric()?);
            let mut servo = Servo::new(options, observer.target())?;
            while !stop.asked() {
                let sight = observer.look(Instant::now() + BEAT)?;
                let exposed_ns = sight.exposed_ns().unwrap_or(0);
                let wish = decide(&mut servo, &sight);
                let twists = (wish.velocities).map(|[x, y, turn]| [x, y, 0.0, 0.0, 0.0, turn]);
                link.tell(twists, exposed_ns, robot.start.len(), wish.doing)?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The connection to the robot and to the parent process.
struct Link {
    robot: Writer<Command>,
    count: u64,
    said: Option<Doing>,
}

impl Link {
    fn tell(
        &mut self,
        velocities: [[f64; 6]; 2],
        exposed_ns: u64,
        grippers: usize,
        doing: Doing,
    ) -> Result<()> {
        self.count += 1;
        let mut slot = self.robot.slot()?;
        *slot = Command {
            count: self.count,
            sent_ns: now_ns(),
            exposed_ns,
            grippers: grippers as u32,
            reserved: 0,
            velocities,
        };
        slot.send()?;
        // Prints a line whenever the state changes. The parent process reads the last one.
        if self.said.replace(doing) != Some(doing) {
            print(&format!("{doing}\n"))?;
        }
        Ok(())
    }
}

fn decide(servo: &mut Servo, sight: &Sight) -> Wish {
    let now_ns = now_ns();
    match sight {
        Sight::Shape(shape) => {
            let weights = match &shape.covariances[..] {
                [] => Weights::Even,
                covariances => Weights::Covariances(covariances),
            };
            let seen = Observation {
                features: shape.features.as_flattened(),
                weights,
                exposed_ns: shape.exposed_ns,
                partial: shape.partial,
            };
            servo.see(seen, now_ns)
        }
        Sight::Lost => servo.hold(Why::Lost, now_ns),
        Sight::Stale => servo.hold(Why::Stale, now_ns),
        Sight::Absent => servo.hold(Why::Absent, now_ns),
    }
}

fn options(job: &Job, robot: &Known, metric: Metric) -> Options {
    let mut start = [[0.0; 3]; 2];
    start
        .iter_mut()
        .zip(&robot.start)
        .for_each(|(to, from)| *to = *from);
    let [x, y] = robot.workspace_px;
    let workspace = Workspace {
        least: [x[0], y[0], f64::NEG_INFINITY],
        most: [x[1], y[1], f64::INFINITY],
    };
    ways(job)
        .robot(
            Robot::default()
                .grippers(robot.start.len())
                .start(start)
                .speeds(robot.speeds)
                .workspaces([workspace; 2])
                .longest_apart_px(robot.longest_apart_px),
        )
        .metric(metric)
        .tolerance_px(TOLERANCE_PX)
}

/// Returns the control options that do not depend on the robot.
fn ways<const A: usize>(job: &Job) -> Options<A> {
    Options::default()
        .gain(job.gain)
        .look_ahead(job.look_ahead)
        .oldest_image_s(0.5 + job.delay_ms / 1e3)
        .estimator(match job.learner {
            Learner::Kalman => Estimator::default(),
            Learner::Broyden => Estimator::BROYDEN,
        })
}
