//! How a stage arranges itself on the machine before it says that it is ready: its core, its memory, its priority.
//!
//! All three are of the thread that asks, so that threads made before (those that decode pictures) stay as they were, and
//! stages make none later. What a user may not have is no fault: it is said, once for the whole chain, and the stage runs
//! without it. Only a core that is not there is one.
//!
//! A stage of realtime priority must not take the machine away. It never waits by looking for longer than
//! `spin_us`; with more work than it can do it rests a hundredth of the time ([`Rest`]); and if a fault of lariat makes it
//! run on and on, the kernel ends it (`RLIMIT_RTTIME`), which needs nothing of the stage.
//!
//! # How it works
//!
//! Each stage takes its place on the machine by itself, before it says `ready` (`src/stages/arrangement.rs`): core,
//! scheduling class, locked memory. All three are of the one thread that asks, and stages make no thread later, so that the
//! thread that decodes pictures stays an ordinary one. A core that is not there is an error before anything starts; what the
//! user may not have is not: stages say `lacks …` on their status line, and the chain says it in one sentence.
//!
//! *The default* is the kernel's own choice of cores, ordinary scheduling, waking by event. *`--realtime`* is FIFO, memory
//! locked as it is touched, and, where FIFO is granted, all four stages on one core: the last isolated one, or the last. Why,
//! from one interleaved run on two cores that others used too (µs, medians of two to three rounds of 2 s; only the ratios
//! count, and p99 of the default is mostly the other programs'):
//!
//! | p50 / p99, 640×480 | anywhere | all on one core | capture / the rest | FIFO anywhere | FIFO, one core | FIFO, capture / the rest |
//! |---|---:|---:|---:|---:|---:|---:|
//! | 30 frames/s | 293 / 4743 | 285 / 4825 | 347 / 3293 | 331 / 1320 | **212 / 683** | 269 / 1014 |
//! | 120 | 163 / 1707 | 153 / 1039 | 186 / 1044 | 196 / 699 | **149 / 603** | 162 / 630 |
//! | 500 | 109 / 687 | 108 / 1114 | 149 / 697 | 222 / 734 | **118 / 650** | 146 / 629 |
//! | 1000 | 131 / 751 | 109 / 964 | 146 / 638 | 172 / 608 | **96 / 610** | 147 / 688 |
//! | `max` | 87 / 1127 | 50 / 794 | 102 / 1114 | 118 / 704 | **43 / 484** | 83 / 876 |
//! | 120, both cores busy | 398 / 16099 | 120 / 15348 | 2340 / 10658 | 182 / 627 | **87 / 496** | 135 / 536 |
//! | 1000, both cores busy | falls behind | falls behind | falls behind, loses 22 % | 150 / 528 | **84** / 3017 | 108 / **963** |
//!
//! - A wake on one core costs half of a wake across cores, and a message finds its data in the cache: one core wins wherever
//!   the stages are sure to have it. Work that overlaps is worth less: at `max` two cores do 30 % more frames.
//! - Without FIFO a pinned stage waits behind whatever program is on its core, and cannot flee. The kernel's own choice puts
//!   the woken on the waker's core anyway where that is idle, and is as good as any pinning of an idle machine. So nothing is
//!   pinned by default, and by `--realtime` only what has FIFO.
//! - FIFO without a core is worse at the median than neither: the kernel pushes FIFO threads apart, so that every wake
//!   crosses cores.
//! - Priorities rise along the chain (40, 41, 42, 43): a frame on its way goes before the making of the next. They are below
//!   the kernel's 50 for interrupt threads.
//! - Where the stages' work fills most of the period (`--fps max`, 1000 frames/s under load), one core has no room left:
//!   `cpus = [0, 1, 1, 1]`.
//! - `wake = "spin"` looks before it sleeps, before the bell is emptied: a bell that is still rung need not be rung again, so
//!   that writer and reader are both spared the kernel. It wants a core for each stage, is said to where there are fewer, and
//!   refused for neighbours on one core.
//!
//! **A stage never takes the machine away.** Under FIFO it rests 1 ms when it has not slept for 100 ms (with more frames
//! than it can do, it would not otherwise); it looks for at most 10 ms before it sleeps; and beside that `RLIMIT_RTTIME` has
//! the kernel end a stage that ran for 2 s without sleeping, whatever fault of lariat's it was, which the chain then says. The
//! kernel's own share for others (`sched_rt_runtime_us`) is left as it is; `lariat doctor` looks at it.
//!
//! Locked is what is touched (`MCL_ONFAULT`): locking all that is mapped would make 71 MB of 26. Locking is left alone
//! where the limit is too near: a later mapping that fails is worse than a page that is not locked.
//!
//! | measured | |
//! |---|---|
//! | resident, five processes, shared memory once, 640×480 | 27 MB; with every slot of every channel, used or not, 50 MB |
//! | from `exec` of `lariat run` to all stages ready | 57 ms (56 ms with `--realtime`; 135 ms at 1920×1080); the first descriptor comes with the first frame, a latency later |

use std::fmt;
use std::fs;
use std::time::Duration;

use anyhow::Context;
use lariat_wire::{now_ns, take_short_slices};
use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use rustix::thread::{CapabilitySet, CpuSet, capabilities, sched_getaffinity, sched_setaffinity};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

use crate::settings::{Arrangement, Cpus, STAGES, Stage, Wake};

/// Memory that a stage may come to map after it has locked what it has: the channels of readers yet to come, other sizes
/// of frames. With a limit below that a later mapping would fail, which is worse than a page that is not locked.
const ROOM_BYTES: u64 = 256 << 20;

/// A stage that has run for so long without sleeping rests …
const LONGEST_RUN: Duration = Duration::from_millis(100);
/// … for so long: enough for what waits on its core to be run, and a hundredth of the time.
const REST: Duration = Duration::from_millis(1);
/// The kernel ends a stage of realtime priority that has run for so long without sleeping: twenty of its own rests were
/// missed then, and no frame takes as long.
const KILLED_AFTER: Duration = Duration::from_secs(2);

/// What a stage does not have of what was wanted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Lacks {
    /// FIFO scheduling.
    pub priority: bool,
    /// Locked memory.
    pub memory: bool,
    /// The core that was chosen for it.
    pub core: bool,
}

impl Lacks {
    /// What either lacks.
    pub fn and(self, other: Self) -> Self {
        Self {
            priority: self.priority || other.priority,
            memory: self.memory || other.memory,
            core: self.core || other.core,
        }
    }

    /// Whether anything is lacking.
    pub fn any(self) -> bool {
        self != Self::default()
    }

    /// As it stands on the status line.
    pub fn words(self) -> String {
        let named = [
            (self.priority, "priority"),
            (self.memory, "memory"),
            (self.core, "core"),
        ];
        let words = named
            .into_iter()
            .filter_map(|(lacks, word)| lacks.then_some(word));
        words.collect::<Vec<_>>().join(" ")
    }

    /// As [`words`](Self::words) says it; none of other words.
    pub fn of_words(words: &str) -> Option<Self> {
        let mut lacks = Self::default();
        for word in words.split_ascii_whitespace() {
            match word {
                "priority" => lacks.priority = true,
                "memory" => lacks.memory = true,
                "core" => lacks.core = true,
                _ => return None,
            }
        }
        Some(lacks)
    }
}

/// One sentence.
impl fmt::Display for Lacks {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let limit = |resource| match getrlimit(resource).current {
            Some(bytes) => bytes.to_string(),
            None => "unlimited".to_owned(),
        };
        let mut parts = Vec::new();
        if self.priority {
            parts.push(format!(
                "FIFO scheduling (its limit rtprio is {})",
                limit(Resource::Rtprio)
            ));
        }
        if self.memory {
            parts.push(format!(
                "locked memory (its limit memlock is {} bytes)",
                limit(Resource::Memlock)
            ));
        }
        if self.core {
            parts.push("cores of its own (the kernel refused them)".to_owned());
        }
        write!(
            f,
            "this user may not have {}, and the chain runs without: `lariat doctor` says what to type",
            parts.join(", nor ")
        )
    }
}

/// Whether the cores that the settings name are there, for the chain to know before it starts its stages.
pub fn check(wanted: &Arrangement) -> anyhow::Result<()> {
    let before =
        sched_getaffinity(None).context("the kernel did not name the cores that lariat may use")?;
    if let Cpus::Cores(cores) = wanted.cpus {
        let outcome = cores.into_iter().flatten().try_for_each(pin);
        // As it was: the stages are children, and would have it from here.
        sched_setaffinity(None, &before).context("the kernel does not give a core back")?;
        outcome?;
    }
    if wanted.wake == Wake::Spin && count(&before) < STAGES.len() {
        tracing::warn!(
            "wake = \"spin\" is for machines with a core for each of the {} stages, and here are {}: a reader that looks \
             keeps the writer it waits for from its core",
            STAGES.len(),
            count(&before)
        );
    }
    Ok(())
}

/// Arranges this thread as a stage; says what it does not have of it.
///
/// # Errors
/// The settings name a core that is not there.
pub fn apply(wanted: &Arrangement, stage: Stage) -> anyhow::Result<Lacks> {
    let mut lacks = Lacks {
        priority: wanted.is_fifo() && !run_before_others(wanted.priority + stage as u8),
        memory: wanted.locks_memory() && !lock_memory(),
        core: false,
    };
    match wanted.cpus {
        Cpus::Cores(cores) => {
            if let Some(core) = cores[stage as usize] {
                pin(core)?;
            }
        }
        Cpus::Auto if wanted.realtime && !lacks.priority && wanted.wake == Wake::Event => {
            lacks.core = !join_stages();
        }
        Cpus::Auto | Cpus::Anywhere => {}
    }
    Ok(lacks)
}

/// Keeps this thread, and all that it starts, from the cores that the stages may have to themselves, if it is left others.
pub fn keep_apart(wanted: &Arrangement) {
    let theirs: Vec<usize> = match wanted.cpus {
        Cpus::Cores(cores) => cores.into_iter().flatten().collect(),
        Cpus::Auto if wanted.realtime && wanted.wake == Wake::Event => {
            chosen_core().into_iter().collect()
        }
        Cpus::Auto | Cpus::Anywhere => Vec::new(),
    };
    let Ok(mut left) = sched_getaffinity(None) else {
        return;
    };
    theirs.into_iter().for_each(|core| left.unset(core));
    if count(&left) > 0 {
        // Not to be had is no fault: an ordinary thread makes way for one of realtime priority anyway.
        let _ = sched_setaffinity(None, &left);
    }
}

/// Has this thread, of realtime priority, run on the core of all stages, where a wake costs half of one across cores; whether that was to be had.
/// Without the priority another program on that core would hold it up.
pub fn join_stages() -> bool {
    chosen_core().is_none_or(|core| pin(core).is_ok())
}

/// The core that was measured to be best for the stages: one for all (see above).
fn chosen_core() -> Option<usize> {
    let isolated = fs::read_to_string("/sys/devices/system/cpu/isolated").unwrap_or_default();
    let usable = match sched_getaffinity(None) {
        Ok(set) => (0..CpuSet::MAX_CPU)
            .filter(|&core| set.is_set(core))
            .collect(),
        Err(_) => Vec::new(),
    };
    last_core(&core_list(&isolated), &usable)
}

/// The last core that is kept from others, or the last there is: the first serves interrupts unless told otherwise.
fn last_core(isolated: &[usize], usable: &[usize]) -> Option<usize> {
    isolated.last().or(usable.last()).copied()
}

/// Core numbers as the kernel writes them: `0-2,5`.
pub fn core_list(text: &str) -> Vec<usize> {
    let range = |range: &str| {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        Some(first.trim().parse().ok()?..=last.trim().parse().ok()?)
    };
    text.trim().split(',').filter_map(range).flatten().collect()
}

fn count(cores: &CpuSet) -> usize {
    cores.count() as usize
}

/// Keeps this thread on a core.
pub fn pin(core: usize) -> anyhow::Result<()> {
    let mut only = CpuSet::new();
    only.set(core);
    sched_setaffinity(None, &only).with_context(|| {
        let online = fs::read_to_string("/sys/devices/system/cpu/online").unwrap_or_default();
        format!(
            "cpus: a stage cannot run on core {core}: this machine has cores {}, and a container may have fewer",
            online.trim()
        )
    })
}

/// Keeps all memory of this process from being paged out, now and later.
fn lock_memory() -> bool {
    let unbounded = capabilities(None)
        .is_ok_and(|of_this_thread| of_this_thread.effective.contains(CapabilitySet::IPC_LOCK));
    if let (false, Some(most)) = (unbounded, getrlimit(Resource::Memlock).current) {
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mapped_bytes = status
            .lines()
            .find_map(|line| line.strip_prefix("VmSize:")?.trim().strip_suffix("kB"))
            .and_then(|kb| kb.trim().parse::<u64>().ok())
            .map_or(u64::MAX, |kb| kb << 10);
        if mapped_bytes.saturating_add(ROOM_BYTES) > most {
            return false;
        }
    }
    // What is never touched stays unmade: with it the chain would be half as large again. What a stage works with it has
    // touched in its rehearsal, and the pages of channels were made with them.
    let wanted = MlockAllFlags::CURRENT | MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT;
    mlockall(wanted).is_ok()
}

/// Lets a wait end when it is due: the kernel otherwise takes 50 µs of leeway. Not to be had is no fault.
pub fn precise_timer() {
    let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1));
}

/// Has this thread, which makes pictures to look at, give its core to whoever wakes, within a tenth of a millisecond, and yet have some of it on a busy machine.
pub fn give_way() {
    // Without it others are only later. `nice` is of Linux a thread's own.
    let _ = rustix::process::nice(15);
    take_short_slices();
}

/// Gives this thread realtime priority, and no more of it at a time than the kernel ends it for.
pub fn run_before_others(priority: u8) -> bool {
    let before = getrlimit(Resource::Rttime);
    let most = KILLED_AFTER.as_micros() as u64;
    let most = before.maximum.map_or(most, |already| most.min(already));
    let bounded = Rlimit {
        current: Some(most),
        maximum: before.maximum,
    };
    let Ok(priority) = priority.try_into().map(ThreadPriority::Crossplatform) else {
        return false;
    };
    // Without the bound it is not wanted.
    setrlimit(Resource::Rttime, bounded).is_ok()
        && set_thread_priority_and_policy(
            thread_native_id(),
            priority,
            ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
        )
        .is_ok()
}

/// Has a stage of realtime priority sleep now and then when it has no reason to: with more frames than it can work off it
/// would keep its core from all else.
#[derive(Debug)]
pub struct Rest {
    is_needed: bool,
    /// A wait that lasts longer than this was a sleep, and not a look.
    looks_ns: u64,
    awake_since_ns: u64,
}

impl Rest {
    /// As the stages are arranged.
    pub fn new(wanted: &Arrangement) -> Self {
        Self {
            is_needed: wanted.is_fifo(),
            // To be put to sleep and woken again takes some microseconds.
            looks_ns: wanted.spin().as_nanos() as u64 + 20_000,
            awake_since_ns: now_ns(),
        }
    }

    /// Waits, and sees whether that was a sleep.
    pub fn while_waiting<T>(&mut self, wait: impl FnOnce() -> T) -> T {
        if !self.is_needed {
            return wait();
        }
        let began_ns = now_ns();
        let outcome = wait();
        self.has_waited(now_ns() - began_ns);
        outcome
    }

    /// A wait has just ended that lasted so long: whether that was a sleep.
    pub fn has_waited(&mut self, waited_ns: u64) {
        if self.is_needed && waited_ns > self.looks_ns {
            self.awake_since_ns = now_ns();
        }
    }

    /// The stage has work at hand, at this moment of [`now_ns`]: it rests if it is time.
    pub fn if_due(&mut self, now_ns: u64) {
        let run_ns = now_ns.saturating_sub(self.awake_since_ns);
        if self.is_needed && u128::from(run_ns) > LONGEST_RUN.as_nanos() {
            // Nothing is waited for: an ordinary program gets the core for so long.
            self.while_waiting(|| std::thread::sleep(REST));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lacking_comes_over_the_status_line_whole() {
        for bits in 0..8 {
            let lacks = Lacks {
                priority: bits & 1 != 0,
                memory: bits & 2 != 0,
                core: bits & 4 != 0,
            };
            assert_eq!(Lacks::of_words(&lacks.words()), Some(lacks));
            assert_eq!(lacks.any(), bits != 0);
        }
    }

    #[test]
    fn cores_are_listed_as_the_kernel_does() {
        assert_eq!(core_list("0-2,5\n"), [0, 1, 2, 5]);
        assert_eq!(core_list("3"), [3]);
        assert_eq!(core_list("\n"), [0; 0]);
        assert_eq!(core_list("(null)"), [0; 0]);
    }

    #[test]
    fn isolated_cores_are_taken_before_others() {
        assert_eq!(last_core(&[2, 3], &[0, 1]), Some(3));
        assert_eq!(last_core(&[], &[0, 1]), Some(1));
        assert_eq!(last_core(&[], &[]), None);
    }
}
