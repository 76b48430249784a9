//! Resource use of processes, from `/proc`: time on a core, and memory with shared pages counted
//! once.

use std::fs;

/// Returns the processes and all their descendants.
pub(super) fn family(roots: &[u32]) -> Vec<u32> {
    let mut found = roots.to_vec();
    let mut next = 0;
    // Some kernels are built without lists of children.
    let listed = fs::exists("/proc/thread-self/children").unwrap_or(false);
    while let Some(&id) = found.get(next) {
        next += 1;
        if !listed {
            found.extend(
                entries("/proc")
                    .into_iter()
                    .filter(|&other| parent(other) == Some(id)),
            );
            continue;
        }
        for task in entries(&format!("/proc/{id}/task")) {
            let path = format!("/proc/{id}/task/{task}/children");
            let text = fs::read_to_string(path).unwrap_or_default();
            found.extend(
                text.split_whitespace()
                    .filter_map(|word| word.parse::<u32>().ok()),
            );
        }
    }
    found
}

/// Returns a process's parent: the second field after its name, which is in parentheses.
fn parent(id: u32) -> Option<u32> {
    let text = fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    text.rsplit(')')
        .next()?
        .split_whitespace()
        .nth(1)?
        .parse()
        .ok()
}

/// Returns the nanoseconds that all threads of these processes have been on a core.
pub(super) fn on_core_ns(processes: &[u32]) -> u64 {
    let of_task = |id: u32, task: u32| {
        let text = fs::read_to_string(format!("/proc/{id}/task/{task}/schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<u64>().ok()
    };
    let of = |&id: &u32| -> u64 {
        let tasks = entries(&format!("/proc/{id}/task"));
        tasks.into_iter().filter_map(|task| of_task(id, task)).sum()
    };
    processes.iter().map(of).sum()
}

/// Returns the resident memory of these processes in MB of 10⁶ bytes. A page that n processes share
/// counts as 1/n for each of them. Returns `None` if the kernel does not report it.
pub(super) fn resident_mb(processes: &[u32]) -> Option<f64> {
    let of = |id: &u32| {
        let text = fs::read_to_string(format!("/proc/{id}/smaps_rollup")).ok()?;
        pss_kib(&text)
    };
    let kib: Vec<f64> = processes.iter().filter_map(of).collect();
    (!kib.is_empty()).then(|| kib.iter().sum::<f64>() * 1024.0 / 1e6)
}

fn pss_kib(rollup: &str) -> Option<f64> {
    let line = rollup.lines().find_map(|line| line.strip_prefix("Pss:"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Returns the numeric names in a folder.
fn entries(folder: &str) -> Vec<u32> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_process_is_its_own_family_and_uses_something() {
        let id = std::process::id();
        let family = family(&[id]);
        assert_eq!(family[0], id);
        assert!(on_core_ns(&family) > 0);
        assert_eq!(
            parent(id),
            rustix::process::getppid().map(|id| id.as_raw_pid() as u32)
        );
        assert_eq!(on_core_ns(&[]), 0);
    }

    #[test]
    fn shared_pages_are_read_from_the_proportional_set() {
        let text = "55d0 ---p 0 00:00 0 [rollup]\nRss:  9000 kB\nPss:  1500 kB\nPss_Anon: 700 kB\n";
        assert_eq!(pss_kib(text), Some(1500.0));
        assert_eq!(pss_kib("Rss: 1 kB"), None);
    }
}
