//! The cases of a study. Each varies one property of the default chain.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use lariat_simulation::{Options, Simulation, SpaceSimulation, TargetShape};
use serde::Deserialize;

use super::episode::{Driven, Episode};
use super::job::{Features, Job, Learner, RAW_POINTS, Robot, SpaceRobot, Wanted};
use super::judge::Outcome;
use super::report::{Group, Row};
use lariat_chain::exit::wrong_use;
use lariat_chain::stop::Stop;

/// Number of points of a target.
const TARGET_POINTS: usize = 120;
/// Speed limits of a gripper: px/s, px/s, rad/s. The robot allows both axes at once.
const SPEEDS: [f64; 3] = [100.0, 100.0, 1.5];
/// Speed limits in 3-D: mm/s along each axis, rad/s about each axis across the rope. The robot
/// allows all at once.
const SPACE_SPEEDS: [f64; 2] = [85.0, 1.0];
/// Maximum distance between the grippers as a share of the rope between them, so that it is never
/// pulled taut.
const SLACK: f64 = 0.998;
/// λ of the control law, 1/s.
const GAIN: f64 = 3.0;
/// Segments the rope by its color. Hands and grippers have other colors and are not confused with
/// it.
const EXTRACT: &str =
    "[extract]\nmask = [{ hue_deg = [190, 250], saturation = [0.3, 1], value = [0.1, 1] }]\n";
/// Fixes the number of control points, because the controller compares a constant number of
/// features. This is the paper's curve, unless a case sets another.
const FIT: &str = "[fit]\ncontrol_points = 9\n";
/// Name of the B-spline basis.
const BSPLINE: &str = "bspline";
/// Time at which a hand appears, s. The rope is then on its way to the target, which most ropes
/// reach after 3 s.
const HAND_AT_S: f64 = 2.5;

/// Target shape of the rope.
#[derive(Debug, Clone)]
pub(super) enum Target {
    /// A shape that the rope takes in the simulation, different for each seed.
    Named(TargetShape),
    /// A curve through points, px.
    Points(Vec<[f64; 2]>),
}

#[derive(Deserialize)]
struct Line {
    points: Vec<[f64; 2]>,
}

impl Target {
    /// Returns the target of this name, or the one in a file of this name.
    pub(super) fn named(name: &str) -> Result<Self> {
        if let Ok(shape) = name.parse() {
            return Ok(Self::Named(shape));
        }
        let path = Path::new(name);
        if !path.exists() {
            wrong_use!(
                "`{name}` is not a target: say u, s, line, or a file with {{\"points\":[[x,y],…]}}"
            );
        }
        let text =
            std::fs::read_to_string(path).with_context(|| format!("{name} could not be read"))?;
        let line: Line = serde_json::from_str(text.lines().next().unwrap_or_default())
            .with_context(|| {
                format!("{name} is not a target: {{\"points\":[[x,y],…]}} in one line is")
            })?;
        let is_place = |point: &[f64; 2]| point.iter().all(|at| at.is_finite());
        if line.points.len() < 2 || !line.points.iter().all(is_place) {
            bail!("{name} is not a target: a curve takes two points at least");
        }
        Ok(Self::Points(line.points))
    }

    /// Returns whether the target is only for a rope on the table.
    pub(super) fn is_in_picture(&self) -> bool {
        matches!(self, Self::Points(_))
    }

    /// Returns the target for the rope of these options, and its robot.
    fn wanted(&self, options: &Options, lifted: bool) -> Result<Wanted> {
        Ok(match self {
            Self::Named(shape) if lifted => Wanted::InSpace {
                target: shape.reached_in_space(options, TARGET_POINTS)?.points,
                robot: space_robot(options)?,
            },
            Self::Named(shape) => Wanted::InPlane {
                target: shape.reached(options, TARGET_POINTS)?.points,
                robot: robot(options)?,
            },
            Self::Points(points) => Wanted::InPlane {
                target: points.clone(),
                robot: robot(options)?,
            },
        })
    }
}

/// One way to drive ropes.
#[derive(Debug, Clone)]
pub(super) struct Case {
    group: Group,
    name: String,
    value: Option<f64>,
    fps: f64,
    delay_ms: f64,
    look_ahead: bool,
    features: Features,
    learner: Learner,
    /// Flags of the chain other than its source.
    flags: Vec<String>,
    /// Content of `[simulation]`.
    simulation: String,
    /// True if the rope is lifted and also seen by a depth camera.
    lifted: bool,
}

impl Case {
    /// Returns the case that varies nothing.
    fn as_it_is(fps: f64, lifted: bool) -> Self {
        Self {
            group: Group::AsItIs,
            name: "as it is".into(),
            value: None,
            fps,
            delay_ms: 0.0,
            look_ahead: true,
            features: Features::Descriptor,
            learner: Learner::Kalman,
            flags: Vec::new(),
            simulation: String::new(),
            lifted,
        }
    }

    /// Returns the default case and, for a study, the cases of the group whose name starts with
    /// `study`. An empty `study` selects all groups.
    pub(super) fn asked(fps: f64, lifted: bool, study: Option<&str>) -> Result<Vec<Self>> {
        let mut cases = Self::all(fps, lifted);
        cases.retain(|case| !lifted || case.is_in_space());
        match study {
            None => cases.truncate(1),
            Some("") => {}
            Some(name) => {
                cases.retain(|case| {
                    case.group == Group::AsItIs || case.group.title().starts_with(name)
                });
                if cases.len() == 1 {
                    let of = if lifted { " of a lifted rope" } else { "" };
                    wrong_use!("`{name}` is not a group of a study{of}: see `lariat servo --help`");
                }
            }
        }
        Ok(cases)
    }

    /// Returns whether the case applies to a lifted rope. With a lifted rope, no hand appears, and
    /// the features are always a Bezier curve's control points without added latency.
    fn is_in_space(&self) -> bool {
        match self.group {
            Group::AsItIs | Group::FrameRate | Group::Noise | Group::Estimator => true,
            Group::CurveAndBasis => !self.flags.iter().any(|flag| flag == BSPLINE),
            Group::Latency | Group::LatencyTaken | Group::Occlusion | Group::Features => false,
        }
    }

    /// Returns the default case and all variations.
    fn all(fps: f64, lifted: bool) -> Vec<Self> {
        let base = Self::as_it_is(fps, lifted);
        let varied = |group, name: String, value| Self {
            group,
            name,
            value,
            ..base.clone()
        };
        let mut cases = vec![base.clone()];
        for (group, look_ahead) in [(Group::Latency, true), (Group::LatencyTaken, false)] {
            for delay_ms in [0.0, 10.0, 30.0, 100.0, 300.0] {
                cases.push(Self {
                    delay_ms,
                    look_ahead,
                    ..varied(group, format!("{delay_ms:.0} ms later"), Some(delay_ms))
                });
            }
        }
        for rate in [15.0, 30.0, 60.0, 120.0, 500.0] {
            let varied = varied(Group::FrameRate, format!("{rate:.0} frames/s"), Some(rate));
            cases.push(Self {
                fps: rate,
                ..varied
            });
        }
        let noise = |level: f64| format!("noise = {level:.1}\n");
        for (name, value, simulation) in [
            ("no noise", 0.0, noise(0.0)),
            ("2.5 levels", 2.5, noise(2.5)),
            ("4 levels", 4.0, noise(4.0)),
        ] {
            let varied = varied(Group::Noise, name.into(), Some(value));
            cases.push(Self {
                simulation,
                ..varied
            });
        }
        let hand = format!("hand_at_s = {HAND_AT_S:.1}\nhand_for_s = 1.0\n");
        cases.push(Self {
            simulation: hand,
            ..varied(Group::Occlusion, "a hand for a second".into(), None)
        });
        for (name, flags) in [
            ("Bezier, 5 control points", &["--control-points", "5"][..]),
            ("Bezier, 7 control points", &["--control-points", "7"]),
            ("Bezier, 9 control points", &["--control-points", "9"]),
            ("Bezier, 13 control points", &["--control-points", "13"]),
            ("B-spline", &["--basis", BSPLINE]),
        ] {
            let varied = varied(Group::CurveAndBasis, name.into(), None);
            let flags = flags.iter().map(|&flag| flag.to_owned()).collect();
            cases.push(Self { flags, ..varied });
        }
        cases.push(Self {
            features: Features::Points,
            ..varied(
                Group::Features,
                format!("{RAW_POINTS} points of the centerline"),
                None,
            )
        });
        cases.push(Self {
            learner: Learner::Broyden,
            ..varied(Group::Estimator, "Broyden's rule".into(), None)
        });
        cases
    }

    /// Returns the unit of distances.
    fn unit(&self) -> &'static str {
        if self.lifted { "mm" } else { "px" }
    }

    /// Describes one rope's outcome in a progress line.
    pub(super) fn said(&self, outcome: &Outcome) -> String {
        let Outcome { seed, doing, .. } = outcome;
        let (error_px, unit) = (outcome.final_px(), self.unit());
        let name = match self.group {
            Group::AsItIs => self.name.clone(),
            group => format!("{}, {}", group.title(), self.name),
        };
        match outcome.reached_s() {
            Some(time_s) => {
                format!(
                    "{name}, seed {seed}: there after {time_s:.1} s, {error_px:.1} {unit} in the end ({doing})"
                )
            }
            None => format!("{name}, seed {seed}: {error_px:.1} {unit} in the end ({doing})"),
        }
    }

    /// Returns this case's row of the table.
    pub(super) fn row(&self, outcomes: Vec<Outcome>) -> Row {
        Row {
            group: self.group,
            name: self.name.clone(),
            value: self.value,
            outcomes,
        }
    }

    /// Drives one rope. Returns `None` if a signal arrived.
    pub(super) fn drive(
        &self,
        seed: u64,
        target: &Target,
        time: Duration,
        filmed: bool,
        controller_domain: Option<&str>,
        stop: &Stop,
    ) -> Result<Option<Driven>> {
        let folder = tempfile::tempdir().context("no room for a rope's files")?;
        let options = Options {
            seed,
            ..Options::default()
        };
        let settings = folder.path().join("lariat.toml");
        std::fs::write(
            &settings,
            format!("{EXTRACT}{FIT}[simulation]\n{}", self.simulation),
        )
        .context("no room for a rope's settings")?;
        let own = [
            "--config",
            &settings.display().to_string(),
            "--source",
            "simulated",
            "--seed",
            &seed.to_string(),
            "--fps",
            &self.fps.to_string(),
        ];
        let depth: &[&str] = match self.lifted {
            true => &["--depth", "simulated"],
            false => &[],
        };
        let episode = Episode {
            seed,
            rig: "servo".into(),
            chain: own
                .iter()
                .chain(depth)
                .map(|&word| word.to_owned())
                .chain(self.flags.clone())
                .collect(),
            job: Job {
                wanted: target.wanted(&options, self.lifted)?,
                features: self.features,
                learner: self.learner,
                gain: GAIN,
                look_ahead: self.look_ahead,
                delay_ms: self.delay_ms,
                period_s: 1.0 / self.fps,
            },
            controller_domain,
            time,
            folder: folder.path(),
            filmed,
        };
        episode.run(stop)
    }
}

/// Returns the robot's own data.
fn robot(options: &Options) -> Result<Robot> {
    let simulation = Simulation::new(options)?;
    let poses = simulation.grippers().iter();
    let margin_px = options.limits.margin_px;
    Ok(Robot {
        start: poses
            .map(|pose| [pose.at[0], pose.at[1], pose.angle_rad])
            .collect(),
        speeds: SPEEDS,
        workspace_px: options.picture_px.map(|size| [margin_px, size - margin_px]),
        longest_apart_px: SLACK * options.length_px,
    })
}

/// Returns the data of a robot in 3-D.
fn space_robot(options: &Options) -> Result<SpaceRobot> {
    let simulation = SpaceSimulation::new(options)?;
    let poses = simulation.grippers().iter();
    Ok(SpaceRobot {
        start: poses.map(|pose| [pose.at, pose.along]).collect(),
        speeds: SPACE_SPEEDS,
        workspace_mm: SpaceSimulation::workspace_mm(options),
        longest_apart_mm: SLACK * options.length_px,
    })
}
