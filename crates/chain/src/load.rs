//! The load of the machine. Latencies measured on a loaded machine are worse than lariat's own.

use std::fmt;
use std::fs;
use std::thread::available_parallelism;

/// The kernel's load average over the last minute, and the number of cores that share it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Average number of threads that ran or waited for a core.
    pub average: f64,
    /// Number of cores that this process may use.
    pub cores: usize,
}

impl Load {
    /// Returns the current load, or `None` if the kernel does not report it.
    pub fn now() -> Option<Self> {
        let text = fs::read_to_string("/proc/loadavg").ok()?;
        Some(Self {
            average: of_text(&text)?,
            cores: available_parallelism().map_or(1, usize::from),
        })
    }

    /// Returns true if less than one core was idle on average, so a chain that wakes up has to wait
    /// for a core. A single core counts as busy above a load of 0.5.
    pub fn is_busy(self) -> bool {
        self.average > (self.cores as f64 - 1.0).max(0.5)
    }

    /// Returns a warning if the machine is loaded: a sentence without a full stop.
    pub fn warning(self) -> Option<String> {
        let warning = || format!("{self}: figures will be worse than lariat's own");
        self.is_busy().then(warning)
    }
}

impl fmt::Display for Load {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let s = if self.cores == 1 { "" } else { "s" };
        write!(f, "load {:.1} on {} core{s}", self.average, self.cores)
    }
}

/// Returns the first number of `/proc/loadavg`, the average over the last minute.
fn of_text(text: &str) -> Option<f64> {
    text.split_ascii_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(average: f64, cores: usize) -> Load {
        Load { average, cores }
    }

    #[test]
    fn a_machine_is_busy_if_less_than_one_core_is_idle() {
        assert!(!load(0.9, 2).is_busy());
        assert!(load(1.1, 2).is_busy());
        assert!(!load(6.9, 8).is_busy());
        assert!(load(12.0, 8).is_busy());
        assert!(!load(0.4, 1).is_busy());
        assert!(load(0.6, 1).is_busy());
    }

    #[test]
    fn the_warning_names_load_and_cores() {
        let warning = load(12.0, 2).warning().expect("it is busy");
        assert_eq!(
            warning,
            "load 12.0 on 2 cores: figures will be worse than lariat's own"
        );
        assert_eq!(load(0.2, 2).warning(), None);
    }

    #[test]
    fn the_last_minute_is_the_first_number() {
        assert_eq!(of_text("0.52 0.58 0.59 1/389 12345\n"), Some(0.52));
        assert_eq!(of_text(""), None);
    }
}
