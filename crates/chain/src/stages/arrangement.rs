//! Arranges a stage on the machine before it reports that it is ready: core, scheduling class and
//! locked memory.
//!
//! # How it works
//!
//! All three belong to the calling thread. Stages start no thread later, and threads that were
//! started before, such as those that decode pictures, are unaffected. A core that does not exist
//! is an error before anything starts. A missing permission is not an error: stages report
//! `lacks …` on their status line, the chain prints one sentence, and the stages run without the
//! resource.
//!
//! *By default*, the kernel chooses the cores, scheduling is ordinary, and readers are woken by
//! events. *`--realtime`* selects FIFO scheduling and locks memory as it is touched. If FIFO is
//! granted, all four stages share one core: the last isolated one, or the last one. `lariat bench`
//! measures four processes in each arrangement. The reasons for these choices:
//!
//! - A wake on one core costs about half as much as a wake across cores, and a message finds its
//!   data in the cache. One core is therefore best wherever the stages are sure to get it.
//!   Overlapping work gains less.
//! - Without FIFO, a pinned stage waits behind any other program on its core and cannot move. If
//!   the waker's core is idle, the kernel places the woken thread there anyway, which is as good as
//!   pinning on an idle machine. Therefore nothing is pinned by default, and `--realtime` pins only
//!   stages that have FIFO.
//! - FIFO without pinning has a worse median than ordinary scheduling without pinning, because the
//!   kernel spreads FIFO threads, so that every wake crosses cores.
//! - Priorities increase along the chain (40, 41, 42, 43), so a frame in progress comes before the
//!   next one. They are below the kernel's 50 for interrupt threads.
//! - If the stages' work fills most of the period (`--fps max`, or 1000 frames/s under load), a
//!   single core is too little. Use `cpus = [0, 1, 1, 1]`.
//! - `wake = "spin"` polls before it sleeps and before it clears the notifier. A pending
//!   notification need not be sent again, so writer and reader both avoid the kernel. This mode
//!   needs a core for each stage. With fewer cores the chain warns; it refuses two neighboring
//!   stages on one core.
//!
//! **A stage never takes over the machine.** Under FIFO it rests for 1 ms when it has not slept for
//! 100 ms ([`Rest`]). With too many frames it would otherwise never sleep. It spins for at most 10
//! ms before it sleeps. In addition, `RLIMIT_RTTIME` makes the kernel end a stage that runs for 2 s
//! without sleeping, whatever the fault, and the chain reports it. The kernel's own reserve for
//! other programs (`sched_rt_runtime_us`) is left unchanged; `lariat doctor` checks it.
//!
//! Memory is locked when it is touched (`MCL_ONFAULT`), because locking everything that is mapped
//! would multiply the memory in use. Memory is not locked if the limit is too close: a later
//! mapping that fails is worse than an unlocked page.

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

/// Memory that a stage may map after locking: channels of future readers, or frames of other sizes.
/// With a limit below that, a later mapping would fail, which is worse than an unlocked page.
const ROOM_BYTES: u64 = 256 << 20;

/// Time without sleep after which a stage rests.
const LONGEST_RUN: Duration = Duration::from_millis(100);
/// Length of a rest. It is long enough for programs that wait for the core to run, and takes a
/// hundredth of the time.
const REST: Duration = Duration::from_millis(1);
/// Time without sleep after which the kernel ends a stage of realtime priority. It spans twenty
/// missed rests, and no frame takes as long.
const KILLED_AFTER: Duration = Duration::from_secs(2);

/// Requested resources that a stage does not have.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Lacks {
    /// FIFO scheduling.
    pub priority: bool,
    /// Locked memory.
    pub memory: bool,
    /// The chosen core.
    pub core: bool,
}

impl Lacks {
    /// Returns the resources that at least one of the two lacks.
    pub fn and(self, other: Self) -> Self {
        Self {
            priority: self.priority || other.priority,
            memory: self.memory || other.memory,
            core: self.core || other.core,
        }
    }

    /// Returns true if anything is missing.
    pub fn any(self) -> bool {
        self != Self::default()
    }

    /// Returns the words for the status line.
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

    /// Parses [`words`](Self::words). Returns `None` for other words.
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

/// Writes the missing resources as a single sentence.
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

/// Checks that the cores in the settings exist, before the chain starts its stages.
pub fn check(wanted: &Arrangement) -> anyhow::Result<()> {
    let before =
        sched_getaffinity(None).context("the kernel did not name the cores that lariat may use")?;
    if let Cpus::Cores(cores) = wanted.cpus {
        let outcome = cores.into_iter().flatten().try_for_each(pin);
        // Restore the cores, because the stages inherit them.
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

/// Arranges this thread as a stage, and returns the resources that it does not get.
///
/// # Errors
/// Returns an error if the settings name a core that does not exist.
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

/// Keeps this thread and all threads that it starts off the cores that the stages use, if other
/// cores are left.
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
        // A failure is harmless: an ordinary thread gives way to realtime priority anyway.
        let _ = sched_setaffinity(None, &left);
    }
}

/// Moves this realtime thread to the core that all stages share, where a wake costs half as much as
/// a wake across cores. Returns true on success. Without the priority, other programs on that core
/// would delay the thread.
pub fn join_stages() -> bool {
    chosen_core().is_none_or(|core| pin(core).is_ok())
}

/// Returns the core that all stages share (see above).
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

/// Returns the last isolated core, or the last core of all. The first core serves interrupts by
/// default.
fn last_core(isolated: &[usize], usable: &[usize]) -> Option<usize> {
    isolated.last().or(usable.last()).copied()
}

/// Parses core numbers as the kernel writes them: `0-2,5`.
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

/// Pins this thread to a core.
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

/// Locks all present and future memory of this process.
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
    // Untouched memory stays unallocated; allocating it would make the chain half as large again.
    // The stage has touched its working memory in its rehearsal, and the pages of channels were
    // allocated when they were created.
    let wanted = MlockAllFlags::CURRENT | MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT;
    mlockall(wanted).is_ok()
}

/// Makes waits end on time. By default the kernel may delay them by 50 µs. Errors are ignored.
pub fn precise_timer() {
    let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1));
}

/// Lowers the priority of this thread, which renders pictures for display. A more urgent thread
/// gets the core within a tenth of a millisecond after it wakes. On a loaded machine, this thread
/// still gets some time.
pub fn give_way() {
    // If this fails, other threads are only delayed. On Linux, `nice` affects a single thread.
    let _ = rustix::process::nice(15);
    take_short_slices();
}

/// Gives this thread realtime priority, and limits the time that it may run without sleeping.
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
    // Without the limit, realtime priority is too dangerous.
    setrlimit(Resource::Rttime, bounded).is_ok()
        && set_thread_priority_and_policy(
            thread_native_id(),
            priority,
            ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
        )
        .is_ok()
}

/// Makes a realtime stage sleep from time to time. With more frames than it can process, it would
/// never release its core.
#[derive(Debug)]
pub struct Rest {
    is_needed: bool,
    /// Longest wait without a sleep: a longer wait included a sleep, and a shorter one was only
    /// spinning.
    looks_ns: u64,
    awake_since_ns: u64,
}

impl Rest {
    /// Creates a rest for this arrangement.
    pub fn new(wanted: &Arrangement) -> Self {
        Self {
            is_needed: wanted.is_fifo(),
            // Falling asleep and waking up takes some microseconds.
            looks_ns: wanted.spin().as_nanos() as u64 + 20_000,
            awake_since_ns: now_ns(),
        }
    }

    /// Waits, and notes whether the thread slept.
    pub fn while_waiting<T>(&mut self, wait: impl FnOnce() -> T) -> T {
        if !self.is_needed {
            return wait();
        }
        let began_ns = now_ns();
        let outcome = wait();
        self.has_waited(now_ns() - began_ns);
        outcome
    }

    /// Notes that a wait of this duration has just ended.
    pub fn has_waited(&mut self, waited_ns: u64) {
        if self.is_needed && waited_ns > self.looks_ns {
            self.awake_since_ns = now_ns();
        }
    }

    /// Sleeps for a moment if a rest is due. The stage has work to do; `now_ns` is the current
    /// time.
    pub fn if_due(&mut self, now_ns: u64) {
        let run_ns = now_ns.saturating_sub(self.awake_since_ns);
        if self.is_needed && u128::from(run_ns) > LONGEST_RUN.as_nanos() {
            // Sleep although there is work, so that ordinary programs get the core.
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
