//! One driven rope: the chain on a simulated rope, its controller, and a judge that knows the
//! truth.

use std::env;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use lariat_wire::{
    Centerlines, DESCRIPTORS, Descriptors, Descriptors3, Domain, Receiver, Rig, TRUTH, TRUTH3,
    Trace,
};

use super::camera::{Camera, Truth};
use super::job::{Job, Wanted};
use super::judge::{Judge, Moment, Outcome, REACHED_PX};
use crate::latency::guard::Guarded;
use crate::program;
use lariat_chain::stop::Stop;

/// Time for which the rope must stay at its target before the case ends.
const STAYS_S: f64 = 1.5;
/// Time limit for the chain's first image.
const STARTS_WITHIN: Duration = Duration::from_secs(30);
/// Time limit for a process to end.
const ENDS_WITHIN: Duration = Duration::from_secs(20);
/// Maximum interval at which the judge checks for a signal.
const BEAT: Duration = Duration::from_millis(100);

/// A case with one rope.
pub(super) struct Episode<'a> {
    pub(super) seed: u64,
    pub(super) rig: String,
    /// Arguments of the chain other than its rig.
    pub(super) chain: Vec<String>,
    pub(super) job: Job,
    /// Domain of the controller, if it differs from the chain's.
    pub(super) controller_domain: Option<&'a str>,
    /// Time limit of the case.
    pub(super) time: Duration,
    /// Folder for its files.
    pub(super) folder: &'a Path,
    /// True to film the case.
    pub(super) filmed: bool,
}

/// Result of a case.
pub(super) struct Driven {
    pub(super) outcome: Outcome,
    /// Times from exposure to descriptor for each image, ms.
    pub(super) latencies_ms: Vec<f64>,
    /// The film as a GIF.
    pub(super) film: Option<Vec<u8>>,
}

/// The judge's sources.
struct Sights {
    witness: Witness,
    descriptors: Receiver<Descriptors>,
    camera: Option<Camera>,
    latencies_ms: Vec<f64>,
}

/// Source of the ground truth.
enum Witness {
    InPlane(Receiver<Centerlines>, Judge<2>),
    InSpace(Receiver<Descriptors3>, Judge<3>),
}

/// Position of the true rope in an image, and its distance from the target.
struct Judged {
    trace: Trace,
    error_px: f64,
    truth: Truth,
}

impl Witness {
    fn open(domain: &Domain, rig: &Rig, wanted: &Wanted) -> Result<Self> {
        Ok(match wanted {
            Wanted::InPlane { target, .. } => Self::InPlane(
                Receiver::create(domain, rig, &TRUTH, None)?,
                Judge::new(target),
            ),
            Wanted::InSpace { target, .. } => Self::InSpace(
                Receiver::create(domain, rig, &TRUTH3, None)?,
                Judge::new(target),
            ),
        })
    }

    fn sleep(&self, deadline: Instant) -> Result<()> {
        match self {
            Self::InPlane(truth, _) => truth.sleep(Some(deadline), None)?,
            Self::InSpace(truth, _) => truth.sleep(Some(deadline), None)?,
        }
        Ok(())
    }

    /// Judges the oldest waiting image. Returns `None` if there is none.
    fn next(&self) -> Result<Option<Judged>> {
        Ok(match self {
            Self::InPlane(truth, judge) => truth.next()?.map(|message| {
                let curve = message.curves().first();
                let points = exact(curve.map_or(&[][..], |curve| curve.points()));
                Judged {
                    trace: message.trace,
                    error_px: judge.error_px(&points),
                    truth: Truth::InPlane(points),
                }
            }),
            Self::InSpace(truth, judge) => truth.next()?.map(|message| {
                let curve = message.curves().first();
                let points = exact(curve.map_or(&[][..], |curve| curve.points()));
                Judged {
                    trace: message.trace,
                    error_px: judge.error_px(&points),
                    truth: Truth::InSpace(points),
                }
            }),
        })
    }
}

impl Episode<'_> {
    /// Drives the rope. Returns `None` if a signal arrived.
    pub(super) fn run(&self, stop: &Stop) -> Result<Option<Driven>> {
        let domain = Domain::open()?;
        let rig = self.rig.parse()?;
        let camera = || Camera::open(&domain, &rig, &self.job.wanted);
        // Opened before the chain starts, so that the first image is judged too.
        let mut sights = Sights {
            witness: Witness::open(&domain, &rig, &self.job.wanted)?,
            descriptors: Receiver::create_unwoken(&domain, &rig, &DESCRIPTORS, None)?,
            camera: self.filmed.then(camera).transpose()?,
            latencies_ms: Vec::new(),
        };
        let job = self.folder.join("job.json");
        self.job.write(&job)?;
        let mut controller = Process::start(
            env::current_exe().context("lariat-bench cannot find its own executable")?,
            "controller",
            &self.controller(&job),
            self.controller_domain,
            self.folder,
        )?;
        let mut chain = Process::start(
            program::lariat()?,
            "run",
            &self.chain_arguments(),
            None,
            self.folder,
        )?;
        let errors = self.judge(&mut sights, &mut [&mut chain, &mut controller], stop)?;
        let doing = controller.end();
        chain.end();
        let Some(errors) = errors else {
            return Ok(None);
        };
        Ok(Some(Driven {
            outcome: Outcome {
                seed: self.seed,
                errors,
                doing: doing.lines().last().unwrap_or_default().to_owned(),
            },
            latencies_ms: sights.latencies_ms,
            film: sights.camera.map(Camera::finish).transpose()?,
        }))
    }

    fn chain_arguments(&self) -> Vec<String> {
        // A time limit for the chain itself, in case this process is killed.
        let longest_s = (self.time + STARTS_WITHIN).as_secs();
        let own = ["--rig", &self.rig, "--duration", &format!("{longest_s}s")].map(str::to_owned);
        [&own[..], &self.chain].concat()
    }

    fn controller(&self, job: &Path) -> Vec<String> {
        let job = job.display().to_string();
        let own = ["--job", &job, "--rig", &self.rig].map(str::to_owned);
        [&own[..], &self.chain].concat()
    }

    /// Watches the true rope until it stays at its target or the time is over. Returns `None` if a
    /// signal arrived.
    fn judge(
        &self,
        sights: &mut Sights,
        processes: &mut [&mut Process],
        stop: &Stop,
    ) -> Result<Option<Vec<Moment>>> {
        let begun = Instant::now();
        let mut errors: Vec<Moment> = Vec::new();
        let mut first_ns = None;
        let mut there_since_s = None;
        loop {
            if stop.asked() {
                return Ok(None);
            }
            for process in &mut *processes {
                process.check()?;
            }
            sights.witness.sleep(Instant::now() + BEAT)?;
            sights.time()?;
            while let Some(judged) = sights.witness.next()? {
                let Judged {
                    trace,
                    error_px,
                    truth,
                } = judged;
                let at_ns = trace.exposed_ns;
                let at_s = at_ns.saturating_sub(*first_ns.get_or_insert(at_ns)) as f64 / 1e9;
                errors.push(Moment { at_s, error_px });
                if let Some(camera) = &mut sights.camera {
                    camera.take(&trace, &truth, (at_s, error_px))?;
                }
                if error_px > REACHED_PX {
                    there_since_s = None;
                } else if at_s - *there_since_s.get_or_insert(at_s) >= STAYS_S {
                    return Ok(Some(errors));
                }
            }
            let last_s = errors.last().map_or(0.0, |moment| moment.at_s);
            if last_s >= self.time.as_secs_f64() {
                return Ok(Some(errors));
            }
            if errors.is_empty() && begun.elapsed() > STARTS_WITHIN {
                bail!("the chain sent no image in {} s", STARTS_WITHIN.as_secs());
            }
        }
    }
}

impl Sights {
    /// Records the latencies of descriptors.
    fn time(&mut self) -> Result<()> {
        while let Some(message) = self.descriptors.next()? {
            let trace = &message.trace;
            let took_ns = trace.fitted_ns.saturating_sub(trace.exposed_ns);
            self.latencies_ms.push(took_ns as f64 / 1e6);
        }
        Ok(())
    }
}

/// A process that runs alongside this one and ends with it.
struct Process {
    name: &'static str,
    program: Guarded,
    said: PathBuf,
    complained: PathBuf,
}

impl Process {
    fn start(
        program: PathBuf,
        name: &'static str,
        arguments: &[String],
        domain: Option<&str>,
        folder: &Path,
    ) -> Result<Self> {
        let starting = || format!("`{} {name}` could not be started", program.display());
        let said = folder.join(format!("{name}.out"));
        let complained = folder.join(format!("{name}.err"));
        let guarded = Guarded::start(
            Command::new(&program)
                .arg(name)
                .args(arguments)
                .envs(domain.map(|name| ("LARIAT_DOMAIN", name)))
                .stdin(Stdio::null())
                .stdout(File::create(&said).with_context(starting)?)
                .stderr(File::create(&complained).with_context(starting)?),
        )
        .with_context(starting)?;
        Ok(Self {
            name,
            program: guarded,
            said,
            complained,
        })
    }

    /// Checks that the process is still running.
    ///
    /// # Errors
    /// The process has ended.
    fn check(&mut self) -> Result<()> {
        match self.program.ended() {
            None => Ok(()),
            Some(status) => bail!(
                "`{}` ended ({status}): {}",
                self.name,
                text(&self.complained)
            ),
        }
    }

    /// Ends the process and returns its output.
    fn end(&mut self) -> String {
        self.program.end(ENDS_WITHIN);
        text(&self.said)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.program.end(ENDS_WITHIN);
    }
}

fn text(path: &Path) -> String {
    let mut text = String::new();
    if let Ok(mut file) = File::open(path) {
        let _ = file.read_to_string(&mut text);
    }
    text.trim().to_owned()
}

fn exact<const D: usize>(points: &[[f32; D]]) -> Vec<[f64; D]> {
    points.iter().map(|p| p.map(f64::from)).collect()
}
