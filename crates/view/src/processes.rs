//! The CPU time and memory that a rig's stages use, from `/proc`.

use std::collections::HashMap;
use std::fs;

use lariat_wire::Member;

use super::view::StageRow;

/// The stages in the order of the pipeline; others come after them.
const ORDER: [&str; 4] = lariat_chain::settings::STAGES;

/// Measures the processes of a rig about once per second.
#[derive(Debug, Default)]
pub(crate) struct Processes {
    /// Time of the last measurement.
    then_ns: u64,
    /// CPU time of each stage until then, by process and name.
    before: HashMap<(u32, String), u64>,
}

impl Processes {
    /// Returns the rig's processes. Their CPU use is that since the last measurement.
    pub(crate) fn look(&mut self, members: &[Member], rig: &str, now_ns: u64) -> Vec<StageRow> {
        let mut of_rig: Vec<&Member> = members.iter().filter(|one| one.rig == rig).collect();
        of_rig.sort_by_key(|one| {
            ORDER
                .iter()
                .position(|name| *name == one.stage)
                .unwrap_or(4)
        });
        let mut on_core = HashMap::new();
        let mut rows = Vec::new();
        for member in &of_rig {
            let is_fused = of_rig
                .iter()
                .filter(|other| other.pid == member.pid)
                .count()
                > 1;
            // Stages that share a process are threads with their names.
            let ns = on_core_ns(member.pid, is_fused.then_some(member.stage.as_str()));
            let key = (member.pid, member.stage.clone());
            let elapsed_ns = now_ns.saturating_sub(self.then_ns);
            let used_ns = self
                .before
                .get(&key)
                .zip(ns)
                .map(|(before, ns)| ns.saturating_sub(*before));
            let cpu_percent = used_ns
                .filter(|_| elapsed_ns > 0)
                .map(|used_ns| used_ns as f64 / elapsed_ns as f64 * 100.0);
            if let Some(ns) = ns {
                on_core.insert(key, ns);
            }
            let status = fs::read_to_string(format!("/proc/{}/status", member.pid));
            rows.push(StageRow {
                stage: member.stage.clone(),
                pid: member.pid,
                cpu_percent,
                own_mb: status.ok().and_then(|text| own_mb(&text)),
                frames_per_s: None,
            });
        }
        (self.then_ns, self.before) = (now_ns, on_core);
        rows
    }
}

/// Returns the CPU time of a process, or of its threads with this name, in ns.
fn on_core_ns(pid: u32, thread: Option<&str>) -> Option<u64> {
    let tasks = fs::read_dir(format!("/proc/{pid}/task")).ok()?;
    let of_task = |task: &fs::DirEntry| {
        let file = |name: &str| fs::read_to_string(task.path().join(name)).unwrap_or_default();
        if thread.is_some_and(|name| file("comm").trim_end() != name) {
            return 0;
        }
        let schedstat = file("schedstat");
        let first = schedstat.split_whitespace().next();
        first.and_then(|ns| ns.parse().ok()).unwrap_or(0)
    };
    Some(tasks.flatten().map(|task| of_task(&task)).sum())
}

/// Returns the resident memory without shared memory, from `/proc/<pid>/status`. (Each process's
/// share of shared memory would have to be counted page by page, which delays that process.)
fn own_mb(status: &str) -> Option<f64> {
    let kib = |name: &str| -> Option<f64> {
        let line = status.lines().find_map(|line| line.strip_prefix(name))?;
        line.split_whitespace().next()?.parse().ok()
    };
    Some((kib("VmRSS:")? - kib("RssShmem:").unwrap_or(0.0)) * 1024.0 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn member(stage: &str) -> Member {
        Member {
            rig: "left".into(),
            stage: stage.into(),
            pid: std::process::id(),
            version: String::new(),
            folder: "/".into(),
            settings: String::new(),
        }
    }

    #[test]
    fn a_rigs_stages_stand_in_the_order_of_the_way_with_what_they_use() {
        let mut processes = Processes::default();
        let members = [member("record"), member("fit"), member("capture")];
        let first = processes.look(&members, "left", 1_000);
        let stages: Vec<&str> = first.iter().map(|row| row.stage.as_str()).collect();
        assert_eq!(stages, ["capture", "fit", "record"]);
        assert!(
            first
                .iter()
                .all(|row| row.own_mb > Some(0.1) && row.cpu_percent.is_none())
        );
        let next = processes.look(&members, "left", 1_000_000_000);
        assert!(next.iter().all(|row| row.cpu_percent >= Some(0.0)));
        assert!(processes.look(&members, "right", 2_000_000_000).is_empty());
    }

    #[test]
    fn a_thread_is_told_from_others_by_its_name() {
        let id = std::process::id();
        let whole = on_core_ns(id, None).expect("this process lives");
        assert_eq!(on_core_ns(id, Some("no such thread")), Some(0));
        assert!(whole > 0);
        assert_eq!(on_core_ns(u32::MAX, None), None);
    }

    #[test]
    fn what_is_shared_is_not_a_processes_own() {
        let status = "VmRSS:\t   12000 kB\nRssAnon: 5000 kB\nRssShmem:\t    2000 kB\n";
        assert_eq!(own_mb(status), Some(10.24));
        assert_eq!(own_mb("Name: kthread\n"), None);
    }
}
