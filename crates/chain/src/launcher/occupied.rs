//! Refuses a rig that another chain uses, before any camera or file is opened.

use std::fmt;
use std::fs;
use std::time::Duration;

use anyhow::{Result, bail};
use lariat_wire::{Member, members};
use rustix::param::clock_ticks_per_second;

use super::Part;
use crate::settings::Settings;

/// Refuses the rig if one of the channels that this chain will write already has a writer.
///
/// # Errors
/// Returns an error that names the process and its running time, or an error if `LARIAT_DOMAIN` is
/// invalid.
pub(super) fn check(settings: &Settings, parts: impl Iterator<Item = Part>) -> Result<()> {
    let rig = &settings.run.rig;
    let writers = [Part::Capture, Part::Extract, Part::Fit];
    let own: Vec<_> = parts.filter(|part| writers.contains(part)).collect();
    let is_in_the_way =
        |member: &&Member| member.rig == *rig && own.iter().any(|part| part.name() == member.stage);
    let members = members()?;
    let Some(member) = members.iter().find(is_in_the_way) else {
        return Ok(());
    };
    let who = Process::that_started(member.pid)
        .map_or_else(|| format!("process {}", member.pid), |who| who.to_string());
    bail!(
        "rig {rig} is in use by {who}: stop that process, or start this chain on a rig of its own (--rig NAME)"
    );
}

/// A process as the kernel describes it.
#[derive(Debug, PartialEq)]
struct Process {
    pid: u32,
    name: String,
    parent: u32,
    age: Duration,
}

impl Process {
    /// Returns the chain that a stage belongs to: the parent if it is the same program, otherwise
    /// the stage itself.
    fn that_started(stage: u32) -> Option<Self> {
        let stage = Self::read(stage)?;
        let parent = Self::read(stage.parent).filter(|parent| parent.name == stage.name);
        Some(parent.unwrap_or(stage))
    }

    fn read(pid: u32) -> Option<Self> {
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        let uptime = fs::read_to_string("/proc/uptime").ok()?;
        Self::of(&stat, &uptime, clock_ticks_per_second())
    }

    /// Parses the process's `stat` file and `/proc/uptime` (proc(5)).
    fn of(stat: &str, uptime: &str, ticks_per_s: u64) -> Option<Self> {
        // The name is in parentheses and may contain any character.
        let (pid, rest) = stat.split_once(" (")?;
        let (name, rest) = rest.rsplit_once(") ")?;
        let mut fields = rest.split_ascii_whitespace();
        // The state, then the parent. The start time is field 22 of the file, which is number 20
        // after the name.
        let parent = fields.nth(1)?.parse().ok()?;
        let started_ticks: u64 = fields.nth(17)?.parse().ok()?;
        let up_s: f64 = uptime.split_ascii_whitespace().next()?.parse().ok()?;
        let age_s = up_s - started_ticks as f64 / ticks_per_s as f64;
        Some(Self {
            pid: pid.parse().ok()?,
            name: name.to_owned(),
            parent,
            age: Duration::try_from_secs_f64(age_s).unwrap_or_default(),
        })
    }
}

impl fmt::Display for Process {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { pid, name, age, .. } = self;
        write!(
            f,
            "process {pid} ({name}), which has run for {}",
            Rough(*age)
        )
    }
}

/// A duration in its two largest units: `2 h 5 min`.
struct Rough(Duration);

impl fmt::Display for Rough {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let all_s = self.0.as_secs();
        let (days, hours, minutes) = (all_s / 86400, all_s / 3600 % 24, all_s / 60 % 60);
        match (days, hours, minutes) {
            (0, 0, 0) => write!(f, "{all_s} s"),
            (0, 0, _) => write!(f, "{minutes} min {} s", all_s % 60),
            (0, ..) => write!(f, "{hours} h {minutes} min"),
            _ => write!(f, "{days} d {hours} h"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_is_read_whatever_its_name() {
        let stat = "71 (a) b (c) S 70 71 70 0 -1 4194560 1 0 0 0 1 2 0 0 20 0 5 0 12300 9 9 9";
        let process = Process::of(stat, "133.50 200.00\n", 100).unwrap();
        assert_eq!(
            process.to_string(),
            "process 71 (a) b (c), which has run for 10 s"
        );
        assert_eq!(process.parent, 70);
        for cut in 0..stat.len() - " 12300 9 9 9".len() {
            assert_eq!(Process::of(&stat[..cut], "133.50 200.00", 100), None);
        }
    }

    #[test]
    fn this_process_is_found_in_the_table_of_the_kernel() {
        let this = Process::read(std::process::id()).unwrap();
        assert_eq!(this.pid, std::process::id());
    }

    #[test]
    fn a_time_is_given_in_its_two_largest_units() {
        let rough = |s| Rough(Duration::from_secs(s)).to_string();
        assert_eq!(rough(59), "59 s");
        assert_eq!(rough(125), "2 min 5 s");
        assert_eq!(rough(7500), "2 h 5 min");
        assert_eq!(rough(90_000), "1 d 1 h");
    }
}
