//! One measurement of the plan, and the function that makes it.

use std::time::Duration;

use anyhow::Result;

use super::chain::{self, Setup};
use super::figures::Outcome;
use super::floors::{self, Pass, Sleep};
use super::relay::{self, Arrangement};
use super::rivals::{self, Script};
use super::workplace::Workplace;

/// A measurement.
pub(super) struct Job {
    /// Index of the item.
    pub(super) item: usize,
    pub(super) what: What,
    pub(super) time: Duration,
    /// True if its failure does not end the bench.
    pub(super) optional: bool,
}

/// Kinds of measurements.
pub(super) enum What {
    Pass(Pass, [u32; 2]),
    Arithmetic,
    Wake(Sleep, [usize; 2]),
    /// Lateness of a timer: on this core under FIFO, if a core is given.
    Timer(Option<usize>),
    Relay(Arrangement, f64),
    Chain(Setup),
    Start(Setup),
    Idle,
    Threads([u32; 2], f64),
    Sockets([u32; 2], f64),
    Script(Script, [u32; 2], f64),
}

impl Job {
    pub(super) fn measure(&self, workplace: &Workplace) -> Result<Outcome> {
        let time = self.time;
        match &self.what {
            What::Pass(pass, size) => Ok(floors::pass(*pass, *size, time)),
            What::Arithmetic => Ok(floors::arithmetic(time)),
            What::Wake(sleep, cores) => {
                floors::wake(*sleep, *cores, (time.as_secs_f64() * 2e4) as usize)
            }
            What::Timer(fifo_on) => {
                let (period, count) = (Duration::from_millis(1), time.as_millis() as usize);
                floors::timer(&workplace.stop, period, count, *fifo_on)
            }
            What::Relay(arrangement, fps) => relay::measure(workplace, *arrangement, *fps, time),
            What::Chain(setup) => chain::measure(workplace, setup, time),
            What::Start(setup) => chain::start(workplace, setup),
            What::Idle => chain::idle(workplace, time),
            What::Threads(size, fps) => rivals::threads(workplace, *size, *fps, time),
            What::Sockets(size, fps) => rivals::sockets(workplace, *size, *fps, time),
            What::Script(script, size, fps) => {
                rivals::script(workplace, *script, *size, *fps, time)
            }
        }
    }
}
