//! The machine on which the figures were measured. Without it, they mean little.

use serde::Serialize;
use std::fs::read_to_string;
use std::thread::available_parallelism;

/// Properties of the machine on which latencies depend. Unreadable ones are `None`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// Name of the processor.
    pub cpu: Option<String>,
    /// Number of cores that this process may use.
    pub cores: Option<usize>,
    /// Name and release of the kernel.
    pub kernel: String,
    /// Frequency governor of the first core.
    pub governor: Option<String>,
    /// Main memory, in MB of 10⁶ bytes.
    pub memory_mb: Option<u64>,
}

impl Machine {
    /// Reads the properties of this machine from `/proc`, `/sys` and `uname`.
    pub fn this() -> Self {
        let uname = rustix::system::uname();
        let governor = "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor";
        Self {
            cpu: read_to_string("/proc/cpuinfo")
                .ok()
                .and_then(|info| cpu_name(&info))
                .or_else(|| Some(uname.machine().to_string_lossy().into_owned())),
            cores: available_parallelism().ok().map(Into::into),
            kernel: format!(
                "{} {}",
                uname.sysname().to_string_lossy(),
                uname.release().to_string_lossy()
            ),
            governor: read_to_string(governor)
                .ok()
                .map(|name| name.trim().to_owned())
                .filter(|name| !name.is_empty()),
            memory_mb: read_to_string("/proc/meminfo")
                .ok()
                .and_then(|info| memory_mb(&info)),
        }
    }
}

/// Returns the name of the processor. The key in `/proc/cpuinfo` depends on the architecture and
/// may be missing.
fn cpu_name(cpuinfo: &str) -> Option<String> {
    ["model name", "Model", "Hardware", "cpu model", "uarch"]
        .iter()
        .find_map(|key| value(cpuinfo, key))
        .map(|name| name.split_whitespace().collect::<Vec<_>>().join(" "))
        .filter(|name| !name.is_empty())
}

/// Converts the memory to MB. `/proc/meminfo` counts in kB of 1024 bytes.
fn memory_mb(meminfo: &str) -> Option<u64> {
    let kib: u64 = value(meminfo, "MemTotal")?
        .split_whitespace()
        .next()?
        .parse()
        .ok()?;
    Some(kib.saturating_mul(1024) / 1_000_000)
}

/// Returns the value of the first `key : value` line with this key.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    text.lines().find_map(|line| {
        let (name, value) = line.split_once(':')?;
        (name.trim() == key).then(|| value.trim())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_is_named_on_x86_and_on_arm() {
        assert_eq!(
            cpu_name("processor\t: 0\nmodel name\t: AMD EPYC  7B13\nMHz : 1\n").as_deref(),
            Some("AMD EPYC 7B13")
        );
        assert_eq!(
            cpu_name("processor : 0\nBogoMIPS : 108.00\n\nModel : Raspberry Pi 5 Model B\n")
                .as_deref(),
            Some("Raspberry Pi 5 Model B")
        );
        assert_eq!(cpu_name("processor : 0\n"), None);
    }

    #[test]
    fn memory_is_counted_in_megabytes() {
        assert_eq!(
            memory_mb("MemTotal:       16384000 kB\nMemFree: 1 kB\n"),
            Some(16_777)
        );
        assert_eq!(memory_mb("nothing of the kind"), None);
    }

    #[test]
    fn this_machine_has_a_kernel_and_cores() {
        let machine = Machine::this();
        assert!(!machine.kernel.trim().is_empty());
        assert!(machine.cores.is_none_or(|cores| cores > 0));
    }
}
