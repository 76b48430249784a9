//! Lower bounds for every chain on this machine: reading and copying the frame, waking a thread,
//! waking on time, and the steadiness of the machine.

use std::hint::black_box;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::ReadPass;
use anyhow::{Context, Result, ensure};
use lariat_sink::Times;
use lariat_wire::now_ns;
use rustix::event::{EventfdFlags, eventfd};
use rustix::thread::futex;

use super::figures::Outcome;
use lariat_chain::stages::arrangement::{pin, precise_timer, run_before_others};
use lariat_chain::stop::Stop;

/// Wakes that are not counted, while threads start and caches fill.
const WARM_UP: usize = 20;
/// Minimum number of timed passes over a frame, even if other programs use the core.
const LEAST_PASSES: u64 = 100;

/// Kinds of passes over a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pass {
    Read,
    Copy,
}

/// Times passes over an RGB frame that is in the cache as far as it fits.
pub(super) fn pass(pass: Pass, [width, height]: [u32; 2], time: Duration) -> Outcome {
    let frame = vec![7u8; 3 * width as usize * height as usize];
    let mut copy = frame.clone();
    let read = ReadPass::default();
    let mut times = Times::default();
    let end = Instant::now() + time;
    while Instant::now() < end || times.count() < LEAST_PASSES {
        let start = Instant::now();
        match pass {
            Pass::Read => drop(black_box(read.sum(black_box(&frame)))),
            Pass::Copy => black_box(&mut copy).copy_from_slice(black_box(&frame)),
        }
        times.add(start.elapsed().as_nanos() as u64);
    }
    Outcome::of_times(times)
}

/// Additions and multiplications of one round of [`arithmetic`], which takes a tenth of a
/// millisecond.
const ROUND: u32 = 40_000;

/// Times the same arithmetic in registers repeatedly. A longer round means that the machine was
/// slower or another program had the core.
pub(super) fn arithmetic(time: Duration) -> Outcome {
    let mut times = Times::default();
    let end = Instant::now() + time;
    while Instant::now() < end || times.count() < LEAST_PASSES {
        let start = Instant::now();
        let sum = (0..ROUND).fold(black_box(1.0f32), |sum, _| sum * 0.999 + 0.001);
        black_box(sum);
        times.add(start.elapsed().as_nanos() as u64);
    }
    Outcome::of_times(times)
}

/// The mechanism a thread sleeps on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sleep {
    Futex,
    Eventfd,
}

/// A signal that wakes a thread.
struct Bell {
    how: Sleep,
    word: AtomicU32,
    descriptor: OwnedFd,
}

impl Bell {
    fn new(how: Sleep) -> Result<Self> {
        let descriptor = eventfd(0, EventfdFlags::CLOEXEC).context("no eventfd could be made")?;
        Ok(Self {
            how,
            word: AtomicU32::new(0),
            descriptor,
        })
    }

    fn ring(&self) {
        match self.how {
            Sleep::Futex => {
                self.word.store(1, Ordering::Release);
                let _ = futex::wake(&self.word, futex::Flags::PRIVATE, 1);
            }
            // The eventfd holds at most one signal, so the write does not block.
            Sleep::Eventfd => drop(rustix::io::write(&self.descriptor, &1u64.to_ne_bytes())),
        }
    }

    fn wait(&self) {
        match self.how {
            Sleep::Futex => {
                while self.word.swap(0, Ordering::Acquire) == 0 {
                    let _ = futex::wait(&self.word, futex::Flags::PRIVATE, 0, None);
                }
            }
            Sleep::Eventfd => drop(rustix::io::read(&self.descriptor, &mut [0u8; 8])),
        }
    }
}

/// Times a wake from one thread's call until the other's return. The threads are on their own cores
/// and wake each other in turn.
pub(super) fn wake(how: Sleep, cores: [usize; 2], count: usize) -> Result<Outcome> {
    let (there, back) = (Bell::new(how)?, Bell::new(how)?);
    let sent_ns = AtomicU64::new(0);
    let times = std::thread::scope(|scope| {
        let woken = scope.spawn(|| -> Result<Times> {
            let seated = pin(cores[1]);
            let mut times = Times::default();
            for k in 0..WARM_UP + count {
                there.wait();
                let woken_ns = now_ns();
                if k >= WARM_UP {
                    times.add(woken_ns.saturating_sub(sent_ns.load(Ordering::Acquire)));
                }
                back.ring();
            }
            seated.map(|()| times)
        });
        // A separate thread, so that the core of the bench itself does not change.
        let waker = scope.spawn(|| -> Result<()> {
            let seated = pin(cores[0]);
            for _ in 0..WARM_UP + count {
                sent_ns.store(now_ns(), Ordering::Release);
                there.ring();
                back.wait();
            }
            seated
        });
        waker
            .join()
            .map_err(|_| anyhow::anyhow!("a thread broke off"))??;
        woken
            .join()
            .map_err(|_| anyhow::anyhow!("a thread broke off"))?
    })?;
    Ok(Outcome::of_times(times))
}

/// Times how late a thread wakes from a sleep until a given time, as in capture. If a core is
/// named, the thread runs on it under FIFO. No program on this machine can be more punctual than
/// that. The lateness that remains is due to the kernel, and on a virtual machine also to the host.
pub(super) fn timer(
    stop: &Stop,
    period: Duration,
    count: usize,
    fifo_on: Option<usize>,
) -> Result<Outcome> {
    let times = std::thread::scope(|scope| {
        let sleeper = scope.spawn(|| -> Result<Times> {
            precise_timer();
            if let Some(core) = fifo_on {
                pin(core)?;
                ensure!(run_before_others(1), "FIFO scheduling was refused");
            }
            let mut times = Times::default();
            let start_ns = now_ns();
            for k in 1..=count as u64 {
                let due_ns = start_ns + k * period.as_nanos() as u64;
                if stop.sleep_until(due_ns) {
                    times.add(now_ns().saturating_sub(due_ns));
                }
            }
            Ok(times)
        });
        sleeper
            .join()
            .map_err(|_| anyhow::anyhow!("a thread broke off"))?
    })?;
    ensure!(!stop.asked(), "a signal stopped the measurement");
    Ok(Outcome::of_times(times))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_wake_is_timed() {
        for how in [Sleep::Futex, Sleep::Eventfd] {
            let core = rustix::thread::sched_getcpu();
            let outcome = wake(how, [core, core], 50).expect("two threads");
            assert_eq!(outcome.times.map(|times| times.count()), Some(50));
        }
    }

    #[test]
    fn every_pass_is_timed() {
        for what in [Pass::Read, Pass::Copy] {
            let outcome = pass(what, [64, 48], Duration::from_millis(1));
            assert!(outcome.times.is_some_and(|times| times.count() > 0));
        }
        let outcome = arithmetic(Duration::ZERO);
        assert!(
            outcome
                .times
                .is_some_and(|times| times.count() >= LEAST_PASSES)
        );
    }
}
