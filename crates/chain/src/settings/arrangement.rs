//! Arrangement of the stages on the machine: their cores, their scheduling class, and how they are
//! woken.

use crate::settings::meaning;
use std::time::Duration;
use toml::Value;

/// A stage of the chain, in the order of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Sends frames.
    Capture,
    /// Finds centerlines in frames.
    Extract,
    /// Fits descriptors to centerlines.
    Fit,
    /// Counts and times the messages that arrive.
    Sink,
}

impl Stage {
    /// Returns the name used in the file, on the command line and by other processes.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Capture => "capture",
            Self::Extract => "extract",
            Self::Fit => "fit",
            Self::Sink => "sink",
        }
    }
}

/// Names of the stages, in the order of the data.
pub const STAGES: [&str; 4] = [
    Stage::Capture.name(),
    Stage::Extract.name(),
    Stage::Fit.name(),
    Stage::Sink.name(),
];

/// Largest core number that fits into Linux's own set of cores.
const MAX_CORE: i64 = 1023;
/// Maximum priority of capture. Extract, fit and sink have one, two and three more, and Linux's
/// maximum is 99.
pub(super) const MAX_PRIORITY: u8 = 96;
/// Maximum time that a reader spins before it sleeps. It is longer than any wait in a chain, and
/// too short to delay anything else.
const MAX_SPIN: Duration = Duration::from_millis(10);

/// The part of `[run]` that concerns the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrangement {
    /// Use realtime priority, locked memory and dedicated cores, as far as they are available.
    pub realtime: bool,
    /// Cores of the stages.
    pub cpus: Cpus,
    /// Scheduling class of the stages.
    pub scheduling: Scheduling,
    /// Capture's priority under FIFO scheduling; each later stage has one more.
    pub priority: u8,
    /// True if the stages' memory is locked in RAM.
    pub lock_memory: bool,
    /// How a reader waits.
    pub wake: Wake,
    /// Time that a reader spins before it sleeps, with [`Wake::Spin`].
    pub spin: Duration,
}

impl Default for Arrangement {
    fn default() -> Self {
        Self {
            realtime: false,
            cpus: Cpus::Auto,
            scheduling: Scheduling::Other,
            // Below 50, the priority of the kernel's interrupt threads, so that a camera's
            // interrupt comes before the stages that wait for it.
            priority: 40,
            lock_memory: false,
            wake: Wake::Event,
            // The cost of a wake across cores. Spinning for this long at most doubles that cost.
            spin: Duration::from_micros(50),
        }
    }
}

impl Arrangement {
    /// Returns true if stages should have realtime priority.
    pub fn is_fifo(&self) -> bool {
        self.realtime || self.scheduling == Scheduling::Fifo
    }

    /// Returns true if stages should lock their memory in RAM.
    pub fn locks_memory(&self) -> bool {
        self.realtime || self.lock_memory
    }

    /// Returns the time that readers spin before they sleep.
    pub fn spin(&self) -> Duration {
        match self.wake {
            Wake::Event => Duration::ZERO,
            Wake::Spin => self.spin,
        }
    }

    /// Returns the reason if these settings contradict each other.
    pub(super) fn contradiction(&self) -> Option<String> {
        let Cpus::Cores(cores) = &self.cpus else {
            return None;
        };
        if self.wake == Wake::Event {
            return None;
        }
        let place = (1..STAGES.len())
            .find(|&place| cores[place].is_some() && cores[place] == cores[place - 1])?;
        Some(format!(
            "wake = \"spin\" lets {} look for what {} sends, and on one core the one keeps the other from sending it: \
             give them different cores, or write wake = \"event\"",
            STAGES[place],
            STAGES[place - 1]
        ))
    }
}

/// Assignment of stages to cores.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cpus {
    /// The kernel chooses. With realtime priority, lariat uses the assignment that measured best.
    Auto,
    /// The kernel chooses.
    Anywhere,
    /// The core of each stage. For `None` the kernel chooses.
    Cores([Option<usize>; STAGES.len()]),
}

/// Scheduling class of the stages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheduling {
    Other,
    Fifo,
}

/// How a reader learns of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wake {
    /// It sleeps until it is woken.
    Event,
    /// It spins for a while and then sleeps.
    Spin,
}

pub(super) const SCHEDULING: [(&str, Scheduling); 2] =
    [("other", Scheduling::Other), ("fifo", Scheduling::Fifo)];

pub(super) const WAKES: [(&str, Wake); 2] = [("event", Wake::Event), ("spin", Wake::Spin)];

pub(super) fn cpus(value: &Value) -> Result<Cpus, String> {
    let why = || {
        format!(
            "write \"auto\", \"none\", the core of each stage ([0, 0, 1, 1] for {}; as a flag 0,0,1,1), or of some of them \
             ({{ extract = 1 }})",
            STAGES.join(", ")
        )
    };
    match value {
        Value::String(text) if text == "auto" => Ok(Cpus::Auto),
        Value::String(text) if text == "none" => Ok(Cpus::Anywhere),
        Value::String(text) => {
            let cores: Option<Vec<Value>> = text
                .split(',')
                .map(|core| core.trim().parse().map(Value::Integer).ok())
                .collect();
            cpus(&Value::Array(cores.ok_or_else(why)?))
        }
        Value::Array(list) if list.len() == STAGES.len() => {
            let mut cores = [None; STAGES.len()];
            for (core, value) in cores.iter_mut().zip(list) {
                *core = Some(self::core(value)?);
            }
            Ok(Cpus::Cores(cores))
        }
        Value::Array(list) if list.iter().all(Value::is_integer) => Err(format!(
            "there are {} stages ({}), and here {} cores: name one for each, be it the same",
            STAGES.len(),
            STAGES.join(", "),
            list.len()
        )),
        Value::Table(table) if !table.is_empty() => {
            let mut cores = [None; STAGES.len()];
            for (name, value) in table {
                let Some(place) = STAGES.iter().position(|stage| stage == name) else {
                    let guess = meaning::nearest(name, STAGES.into_iter())
                        .map_or(String::new(), |near| format!("Did you mean {near}? "));
                    return Err(format!(
                        "there is no stage \"{name}\". {guess}There are {}",
                        STAGES.join(", ")
                    ));
                };
                cores[place] = Some(core(value)?);
            }
            Ok(Cpus::Cores(cores))
        }
        _ => Err(why()),
    }
}

fn core(value: &Value) -> Result<usize, String> {
    let number = meaning::whole(value, 0, MAX_CORE).map_err(|why| format!("a core: {why}"))?;
    Ok(number.unsigned_abs() as usize)
}

pub(super) fn cpus_value(cpus: &Cpus) -> Value {
    let core = |core: usize| Value::Integer(core as i64);
    match cpus {
        Cpus::Auto => Value::String("auto".to_owned()),
        Cpus::Anywhere => Value::String("none".to_owned()),
        Cpus::Cores(cores) if cores.iter().all(Option::is_some) => {
            Value::Array(cores.iter().flatten().copied().map(core).collect())
        }
        Cpus::Cores(cores) => {
            let named = STAGES.iter().zip(cores);
            let entries = named.filter_map(|(stage, at)| Some(((*stage).to_owned(), core((*at)?))));
            Value::Table(entries.collect())
        }
    }
}

pub(super) fn spin(value: &Value) -> Result<Duration, String> {
    let time = meaning::time(value, 1e-6, "microseconds")?;
    if time > MAX_SPIN {
        return Err(format!(
            "a reader looks for at most {} µs before it sleeps",
            MAX_SPIN.as_micros()
        ));
    }
    Ok(time)
}

pub(super) fn spin_value(spin: &Duration) -> Value {
    meaning::number_value(spin.as_nanos() as f64 / 1e3)
}
