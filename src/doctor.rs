//! `lariat doctor`: finds what slows lariat down on this machine, and says what to type.
//!
//! Pure functions judge the text of the kernel's files ([`checks`]); the code here only reads those
//! files.

mod checks;

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use lariat_wire::{
    Domain, holdings, leftovers, members, remove_leftovers, shared_by_others, user_name,
};
use rustix::fs::statvfs;
use rustix::process::geteuid;
use rustix::thread::{CpuSet, sched_getaffinity};
use serde::Serialize;

use crate::versioned::Versioned;
use checks::{Finding, Verdict};
use lariat_chain::load::Load;
use lariat_chain::output::print;

/// Check this machine: what slows lariat down, and how to fix it
#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Remove what killed processes left in shared memory; files of running processes are kept
    #[arg(long)]
    clean: bool,
}

#[derive(Serialize)]
struct Diagnosis {
    works: bool,
    checks: Vec<Finding>,
}

/// Runs `lariat doctor`. The exit code reports a failure only if something keeps lariat from
/// working.
///
/// # Errors
/// Returns an error if the findings cannot be written.
pub(crate) fn run(args: DoctorArgs) -> Result<ExitCode> {
    let checks = examine(args.clean);
    let works = checks.iter().all(|found| found.verdict != Verdict::Bad);
    let text = if args.json {
        let diagnosis = Diagnosis { works, checks };
        serde_json::to_string_pretty(&Versioned::first(diagnosis))? + "\n"
    } else {
        checks.iter().map(Finding::to_string).collect()
    };
    print(&text)?;
    Ok(if works {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Runs all checks. The load comes first, because every measurement depends on it; the others
/// follow in order of importance.
fn examine(clean: bool) -> Vec<Finding> {
    // Measured before this command itself adds to it.
    let load = Load::now();
    // Both run before this process joins the domain, which sweeps it and adds files of this
    // process.
    let leftover = leftover(clean);
    let rights = rights();
    let domain = Domain::open();
    let channels = domain
        .as_ref()
        .ok()
        .and_then(|domain| domain.channels().ok());
    let space =
        statvfs("/dev/shm").map(|shm| (shm.f_blocks * shm.f_frsize, shm.f_bavail * shm.f_frsize));
    let limits = read("/proc/self/limits");
    let status = read("/proc/self/status");
    let usable = sched_getaffinity(None).map_or(1, |set: CpuSet| set.count() as usize);
    let commands = read("/proc/cmdline");
    let cpu = |file: &str| read(&format!("/sys/devices/system/cpu/{file}"));
    vec![
        checks::load(load),
        checks::shared_memory(space.ok()),
        checks::domain(domain.err().map(|cause| cause.to_string())),
        rights,
        checks::versions(
            &members().unwrap_or_default(),
            &channels.unwrap_or_default(),
            env!("CARGO_PKG_VERSION"),
        ),
        leftover,
        checks::open_files(&limits),
        checks::cores(usable),
        checks::realtime_priority(&limits, &status),
        checks::locked_memory(&limits, &status),
        checks::realtime_share(&read("/proc/sys/kernel/sched_rt_runtime_us")),
        checks::preemption(
            &read("/proc/version"),
            &read("/sys/kernel/realtime"),
            &commands,
        ),
        checks::governor(&of_each_core("cpufreq/scaling_governor")),
        checks::idle_states(&idle_states()),
        checks::isolated_cores(&cpu("isolated"), &cpu("nohz_full"), usable),
        checks::swap(&read("/proc/swaps"), &read("/proc/sys/vm/swappiness")),
        checks::huge_pages(&read("/sys/kernel/mm/transparent_hugepage/enabled")),
        checks::clock(&read(
            "/sys/devices/system/clocksource/clocksource0/current_clocksource",
        )),
        checks::timer_slack(&read("/proc/self/timerslack_ns")),
        checks::virtual_machine(&read("/proc/cpuinfo")),
    ]
}

/// Judges what dead processes left, and removes it on request.
fn leftover(clean: bool) -> Finding {
    let others: Vec<_> = shared_by_others()
        .into_iter()
        .map(|(user, (files, bytes))| (user_name(user), files, bytes))
        .collect();
    if !clean {
        return checks::leftover(&leftovers(), None, &others);
    }
    let (left, kept) = remove_leftovers();
    let told = kept
        .iter()
        .map(|(path, cause)| format!("{} ({cause})", path.display()));
    checks::leftover(&left, Some(&told.collect::<Vec<_>>()), &others)
}

/// Judges the ownership of the domain's files.
fn rights() -> Finding {
    let me = geteuid().as_raw();
    let mut others = BTreeMap::new();
    let mut own = 0;
    for path in holdings().unwrap_or_default() {
        match fs::symlink_metadata(path).map(|data| data.uid()) {
            Ok(uid) if uid == me => own += 1,
            Ok(uid) => *others.entry(user_name(uid)).or_insert(0) += 1,
            // The file has been removed in the meantime.
            Err(_) => {}
        }
    }
    checks::rights(&user_name(me), own, &others)
}

/// Returns a file's text, or an empty string if the file does not exist.
fn read(path: &str) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

/// Returns the text of a file of each core.
fn of_each_core(file: &str) -> Vec<String> {
    (0..CpuSet::MAX_CPU)
        .map(|core| read(&format!("/sys/devices/system/cpu/cpu{core}/{file}")))
        .filter(|text| !text.is_empty())
        .collect()
}

/// Name, latency (µs) and disabled flag of each idle state of the first core.
fn idle_states() -> Vec<[String; 3]> {
    let file = |state: usize, name: &str| {
        read(&format!(
            "/sys/devices/system/cpu/cpu0/cpuidle/state{state}/{name}"
        ))
    };
    (0..16)
        .map(|state| ["name", "latency", "disable"].map(|name| file(state, name)))
        .take_while(|[name, ..]| !name.is_empty())
        .collect()
}
