//! Judges what was found on the machine: takes the text of the kernel's files, returns findings.

mod rig;

use std::fmt;

use serde::Serialize;

pub(super) use rig::{leftover, rights, versions};

use lariat_chain::layout::{self, hanging};
use lariat_chain::load::Load;
use lariat_chain::stages::arrangement::core_list;

/// Verdict on one check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Verdict {
    /// As it should be, or irrelevant here.
    Ok,
    /// lariat works, but could be faster or steadier.
    CouldBeBetter,
    /// lariat does not work.
    Bad,
}

/// Result of one check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Finding {
    pub(super) name: &'static str,
    pub(super) verdict: Verdict,
    /// State of the machine.
    pub(super) found: String,
    /// Advice, with the command to type.
    pub(super) advice: Option<String>,
}

/// Prints the state, and below it the advice, wrapped to the width of the terminal.
impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let width = layout::width();
        let verdict = match self.verdict {
            Verdict::Ok => "ok",
            Verdict::CouldBeBetter => "could be better",
            Verdict::Bad => "bad",
        };
        const INDENT: usize = 17;
        let found = hanging(&format!("{}: {}", self.name, self.found), INDENT, width);
        let advice = self.advice.as_ref().map(|advice| {
            let lines = hanging(&format!("→ {advice}"), INDENT + 2, width);
            format!("{:INDENT$}{lines}\n", "")
        });
        write!(f, "{verdict:<15}  {found}\n{}", advice.unwrap_or_default())
    }
}

fn ok(name: &'static str, found: impl Into<String>) -> Finding {
    Finding {
        name,
        verdict: Verdict::Ok,
        found: found.into(),
        advice: None,
    }
}

fn better(name: &'static str, found: impl Into<String>, advice: impl Into<String>) -> Finding {
    Finding {
        verdict: Verdict::CouldBeBetter,
        advice: Some(advice.into()),
        ..ok(name, found)
    }
}

fn bad(name: &'static str, found: impl Into<String>, advice: impl Into<String>) -> Finding {
    Finding {
        verdict: Verdict::Bad,
        ..better(name, found, advice)
    }
}

/// Judges the load of the machine; `None` if the kernel does not report it.
pub(super) fn load(load: Option<Load>) -> Finding {
    const NAME: &str = "load";
    let Some(load) = load else {
        return ok(NAME, "the kernel does not report it");
    };
    let idle = || ok(NAME, format!("{load}: a core is idle"));
    load.warning().map_or_else(idle, |warning| {
        better(
            NAME,
            warning,
            "end what else runs here before anything is measured: `top` shows it",
        )
    })
}

/// Shared memory of one rig's channels at 640×480 and three bytes a pixel: 60 MB, measured.
const RIG_BYTES: u64 = 58 << 20;
/// Shared memory of one rig's channels at 1920×1080, which has seven times the pixels.
const LARGE_RIG_BYTES: u64 = 170 << 20;

/// Judges `/dev/shm` by its size and its free space, in bytes; `None` if it does not exist.
pub(super) fn shared_memory(space: Option<(u64, u64)>) -> Finding {
    const NAME: &str = "shared memory";
    let Some((size, free)) = space else {
        return bad(
            NAME,
            "there is no /dev/shm",
            "mount it: `sudo mount -t tmpfs -o size=1G tmpfs /dev/shm` (in a container: `docker run --shm-size=1g`)",
        );
    };
    let mb = |bytes: u64| bytes / 1_000_000;
    // A file system without a limit reports no size.
    if size == 0 {
        return ok(NAME, "/dev/shm has no limit");
    }
    let found = format!("/dev/shm has {} of {} MB free", mb(free), mb(size));
    let advice = "`sudo mount -o remount,size=1G /dev/shm` (in a container: `docker run --shm-size=1g`), or remove what \
                  lies there";
    if free < RIG_BYTES {
        let need = format!("{found}; a rig needs {} at 640×480", mb(RIG_BYTES));
        bad(NAME, need, advice)
    } else if free < LARGE_RIG_BYTES {
        let need = format!("{found}; a rig needs {} at 1920×1080", mb(LARGE_RIG_BYTES));
        better(NAME, need, advice)
    } else {
        ok(NAME, found)
    }
}

/// Judges whether the transport's domain can be joined. `fault`: why it cannot.
pub(super) fn domain(fault: Option<String>) -> Finding {
    const NAME: &str = "transport";
    match fault {
        None => ok(NAME, "the domain can be joined"),
        Some(fault) => bad(
            NAME,
            fault,
            "run all of a rig as one user, or in another domain: `export LARIAT_DOMAIN=NAME`",
        ),
    }
}

/// Judges the number of cores that lariat may use.
pub(super) fn cores(usable: usize) -> Finding {
    const NAME: &str = "cores";
    match usable {
        0 | 1 => better(
            NAME,
            "one core is all that lariat may use",
            "two let a frame be made while the last one is worked off: `taskset -p $$` and the container's cpuset say who \
             holds back the others",
        ),
        more => ok(NAME, format!("{more} may be used")),
    }
}

/// Returns a soft limit of `/proc/self/limits`; `None` if it is unlimited or missing.
fn limit(limits: &str, name: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Returns whether the process has this capability, according to `/proc/self/status`.
fn is_capable(status: &str, bit: u32) -> bool {
    let line = status.lines().find_map(|line| line.strip_prefix("CapEff:"));
    line.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|mask| mask >> bit & 1 == 1)
}

/// Judges whether a process may open as many files as a reader or a stage of lariat does.
pub(super) fn open_files(limits: &str) -> Finding {
    const NAME: &str = "open files";
    /// A stage has 40 files open, plus one for each process at the other end of its channels.
    const ENOUGH: u64 = 128;
    match limit(limits, "Max open files") {
        Some(most) if most < ENOUGH => better(
            NAME,
            format!(
                "a process may have {most} open, and a stage with many readers has up to {ENOUGH}"
            ),
            "`ulimit -n 1024` in this shell, before lariat is started",
        ),
        Some(most) => ok(NAME, format!("a process may have {most}")),
        None => ok(NAME, "unlimited"),
    }
}

/// Describes how to raise a user's limit.
fn raise(limit: &str, value: &str) -> String {
    format!(
        "`echo \"$USER - {limit} {value}\" | sudo tee -a /etc/security/limits.d/lariat.conf`, then log in again (a systemd \
         unit: Limit{}={})",
        if limit == "rtprio" {
            "RTPRIO"
        } else {
            "MEMLOCK"
        },
        if value == "unlimited" {
            "infinity"
        } else {
            value
        },
    )
}

/// Highest realtime priority that `--realtime` uses by default, which is sink's.
const HIGHEST_PRIORITY: u64 = 43;

/// Judges whether `--realtime` may use FIFO scheduling.
pub(super) fn realtime_priority(limits: &str, status: &str) -> Finding {
    const NAME: &str = "realtime priority";
    /// `CAP_SYS_NICE`.
    const SYS_NICE: u32 = 23;
    if is_capable(status, SYS_NICE) {
        return ok(NAME, "this user may have any");
    }
    match limit(limits, "Max realtime priority") {
        Some(most) if most < HIGHEST_PRIORITY => {
            let found = format!("rtprio is {most}, and --realtime takes up to {HIGHEST_PRIORITY}");
            better(NAME, found, raise("rtprio", "99"))
        }
        Some(most) => ok(NAME, format!("rtprio is {most}")),
        None => ok(NAME, "rtprio is unlimited"),
    }
}

/// Judges whether `--realtime` may lock memory.
pub(super) fn locked_memory(limits: &str, status: &str) -> Finding {
    const NAME: &str = "locked memory";
    /// `CAP_IPC_LOCK`.
    const IPC_LOCK: u32 = 14;
    /// Memory that a stage maps, or may map later.
    const ENOUGH_BYTES: u64 = 1 << 30;
    if is_capable(status, IPC_LOCK) {
        return ok(NAME, "this user may lock any");
    }
    match limit(limits, "Max locked memory") {
        Some(most) if most < ENOUGH_BYTES => {
            let found = format!("memlock is {} kB, too little for --realtime", most >> 10);
            better(NAME, found, raise("memlock", "unlimited"))
        }
        Some(most) => ok(NAME, format!("memlock is {} MB", most / 1_000_000)),
        None => ok(NAME, "memlock is unlimited"),
    }
}

/// Judges the share of a core that realtime tasks may take: `sched_rt_runtime_us`.
pub(super) fn realtime_share(runtime_us: &str) -> Finding {
    const NAME: &str = "realtime share";
    match runtime_us.trim().parse::<i64>() {
        Ok(-1) => better(
            NAME,
            "realtime priority may take a core for ever, so that a fault of any such program can hang it",
            "`sudo sysctl kernel.sched_rt_runtime_us=950000` (a stage of lariat rests by itself)",
        ),
        Ok(us) if us > 0 => ok(NAME, format!("{} % of a core", us / 10_000)),
        Ok(_) => better(
            NAME,
            "realtime priority is switched off",
            "`sudo sysctl kernel.sched_rt_runtime_us=950000`",
        ),
        Err(_) => ok(NAME, "not reported by this kernel"),
    }
}

/// Judges the kernel's preemption model.
pub(super) fn preemption(version: &str, realtime: &str, command_line: &str) -> Finding {
    const NAME: &str = "kernel preemption";
    let chosen = command_line
        .split_whitespace()
        .find_map(|word| word.strip_prefix("preempt="));
    if version.contains("PREEMPT_RT") || realtime.trim() == "1" {
        return ok(NAME, "PREEMPT_RT");
    }
    match chosen {
        Some("full") => ok(NAME, "full"),
        Some(other) => better(
            NAME,
            format!("the kernel was started with preempt={other}"),
            "add preempt=full to the kernel's command line",
        ),
        None if version.contains("PREEMPT_DYNAMIC") => better(
            NAME,
            "PREEMPT_DYNAMIC, as the distribution chose",
            "add preempt=full to the kernel's command line, or take a kernel with PREEMPT_RT",
        ),
        None if version.contains("PREEMPT") => ok(NAME, "PREEMPT"),
        None => better(
            NAME,
            "the kernel is not preempted",
            "take a kernel with PREEMPT_RT, or one with PREEMPT_DYNAMIC started with preempt=full",
        ),
    }
}

/// Judges the frequency governor of each core; empty if there is none.
pub(super) fn governor(governors: &[String]) -> Finding {
    const NAME: &str = "CPU governor";
    let slow = governors.iter().filter(|name| name.trim() != "performance");
    match (governors.first(), slow.clone().next()) {
        (None, _) => ok(NAME, "the frequency is not this system's to choose"),
        (_, None) => ok(NAME, "performance"),
        (_, Some(name)) => better(
            NAME,
            format!("{} on {} cores", name.trim(), slow.count()),
            "`sudo cpupower frequency-set -g performance`",
        ),
    }
}

/// Judges the wake-up time of an idle core. Each idle state has a name, a latency (µs) and a
/// disabled flag.
pub(super) fn idle_states(states: &[[String; 3]]) -> Finding {
    const NAME: &str = "idle states";
    /// About as long as a wake-up across cores takes anyway.
    const LONG_US: u64 = 20;
    let slowest = states
        .iter()
        .filter(|[_, _, off]| off.trim() != "1")
        .filter_map(|[name, latency_us, _]| {
            Some((latency_us.trim().parse::<u64>().ok()?, name.trim()))
        })
        .max();
    match slowest {
        Some((us, name)) if us > LONG_US => better(
            NAME,
            format!("a core in {name} takes {us} µs to wake"),
            format!("`sudo cpupower idle-set -D {LONG_US}` while the robot runs"),
        ),
        Some((us, name)) => ok(NAME, format!("the deepest, {name}, takes {us} µs to wake")),
        None => ok(NAME, "not this system's to choose"),
    }
}

/// Judges the cores that are isolated from other programs and from the scheduler's tick.
pub(super) fn isolated_cores(isolated: &str, nohz_full: &str, usable: usize) -> Finding {
    const NAME: &str = "isolated cores";
    let (isolated, quiet) = (core_list(isolated), core_list(nohz_full));
    if isolated.is_empty() {
        return if usable < 4 {
            ok(NAME, "none, and too few cores to keep any from others")
        } else {
            better(
                NAME,
                "none",
                format!(
                    "add isolcpus={0} nohz_full={0} to the kernel's command line; --realtime takes isolated cores by itself",
                    usable - 1
                ),
            )
        };
    }
    let numbers: Vec<String> = isolated.iter().map(usize::to_string).collect();
    let found = numbers.join(", ");
    if isolated.iter().all(|core| quiet.contains(core)) {
        ok(NAME, format!("{found}, without the scheduler's tick"))
    } else {
        better(
            NAME,
            format!("{found}, with the scheduler's tick"),
            format!(
                "add nohz_full={} to the kernel's command line",
                numbers.join(",")
            ),
        )
    }
}

/// Judges whether memory may be paged out.
pub(super) fn swap(swaps: &str, swappiness: &str) -> Finding {
    const NAME: &str = "swap";
    if swaps.lines().count() < 2 {
        return ok(NAME, "there is none");
    }
    match swappiness.trim().parse::<u32>() {
        Ok(eager) if eager > 10 => better(
            NAME,
            format!("memory may be paged out, and vm.swappiness is {eager}"),
            "`sudo sysctl vm.swappiness=10`, or run with --realtime, which locks it",
        ),
        _ => ok(NAME, format!("vm.swappiness is {}", swappiness.trim())),
    }
}

/// Judges whether the kernel forms huge pages without being asked.
pub(super) fn huge_pages(enabled: &str) -> Finding {
    const NAME: &str = "huge pages";
    if enabled.contains("[always]") {
        return better(
            NAME,
            "the kernel joins pages of every program, which holds it up meanwhile",
            "`echo madvise | sudo tee /sys/kernel/mm/transparent_hugepage/enabled`",
        );
    }
    ok(NAME, "only for programs that ask")
}

/// Judges the clock source.
pub(super) fn clock(source: &str) -> Finding {
    const NAME: &str = "clock";
    match source.trim() {
        slow @ ("hpet" | "acpi_pm" | "jiffies") => better(
            NAME,
            format!("{slow}: each look costs a microsecond, and a frame has ten"),
            "add tsc=reliable to the kernel's command line, if the machine's cores agree on the time",
        ),
        "" => ok(NAME, "not reported by this kernel"),
        source => ok(NAME, source),
    }
}

/// Judges how late a timer may fire. Capture sets its own timer slack to the minimum.
pub(super) fn timer_slack(ns: &str) -> Finding {
    const NAME: &str = "timer slack";
    match ns.trim().parse::<u64>() {
        Ok(ns) => ok(
            NAME,
            format!("{} µs for others; capture has none", ns / 1000),
        ),
        Err(_) => ok(NAME, "not reported by this kernel; capture has none"),
    }
}

/// Judges whether this is a virtual machine.
pub(super) fn virtual_machine(cpuinfo: &str) -> Finding {
    const NAME: &str = "virtual machine";
    let flags = cpuinfo.lines().find(|line| line.starts_with("flags"));
    if flags.is_some_and(|flags| flags.split_whitespace().any(|flag| flag == "hypervisor")) {
        return better(
            NAME,
            "yes: a wake takes several times as long, and another machine may take the core",
            "run on the metal what moves a robot",
        );
    }
    ok(NAME, "no")
}

#[cfg(test)]
mod tests;
