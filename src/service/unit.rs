//! Text of the unit.

use std::path::Path;

use anyhow::Result;
use lariat_chain::exit::wrong_use;
use lariat_wire::Rig;

/// File name of the template; the rig's name follows the `@`.
pub(super) const NAME: &str = "lariat@.service";

/// First line, which identifies a unit of lariat.
pub(super) const HEAD: &str = "# Written by `lariat service install`, which writes it again.";

/// Name of a rig's chain in systemd.
pub(super) fn instance(rig: &Rig) -> String {
    format!("lariat@{rig}")
}

/// Rig of the chain with this unit name.
pub(super) fn rig_of(name: &str) -> Option<&str> {
    name.strip_prefix("lariat@")?.strip_suffix(".service")
}

/// Returns the text of the template. `run_as`: user of a service of the whole machine; `None` for a
/// user's own service.
pub(super) fn text(program: &Path, run_as: Option<&str>) -> Result<String> {
    let Some(program) = program
        .to_str()
        .filter(|path| !path.contains(['\n', '"', '\\']))
    else {
        wrong_use!(
            "{} cannot be written to a unit: move lariat to a folder of a plain name",
            program.display()
        );
    };
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    if let Some(user) = run_as.filter(|user| user.is_empty() || !user.chars().all(is_plain)) {
        wrong_use!("{user:?} is not a user name: it has letters, digits, `_`, `-` and `.`");
    }
    // systemd's own specifiers and variables begin with these characters.
    let program = program.replace('%', "%%").replace('$', "$$");
    let program = match program.contains(' ') {
        true => format!("\"{program}\""),
        false => program,
    };
    let user = run_as.map(|user| MACHINE_USER.replace("USER", user));
    let fences = run_as.map_or("", |_| MACHINE_FENCES);
    let target = run_as.map_or("default.target", |_| "multi-user.target");
    let user = user.unwrap_or_default();
    Ok(format!(
        "{HEAD} Changes of yours go into a drop-in:
# systemctl edit lariat@.service

[Unit]
Description=lariat, rig %i
Documentation=man:lariat(1)
# A camera may be away for hours: it is tried as often as it must be.
StartLimitIntervalSec=0

[Service]
Type=notify
NotifyAccess=main
# Fed while frames come or a camera is waited for.
WatchdogSec=30
ExecStart={program} run --config %E/lariat/%i.toml --rig %i --daemon
Restart=on-failure
RestartSec=1
# The settings make no sense: the next time they would not either.
RestartPreventExitStatus=2
# The chain ends its stages itself, the first one first, so that nothing is lost; what is left then is killed.
KillMode=mixed
TimeoutStopSec=75
# Reports and recordings with a relative path.
StateDirectory=lariat/%i
WorkingDirectory=%S/lariat/%i
{user}
# For `realtime = true`.
LimitRTPRIO=99
LimitMEMLOCK=infinity

# Processes find each other in /tmp and /dev/shm: with a /tmp of its own the chain would be alone.
PrivateTmp=no
{fences}NoNewPrivileges=yes
UMask=0077
# A chain has some thirty threads, and needs 0.1 to 1 GB by the size of its pictures.
TasksMax=256
MemoryMax=75%
RestrictAddressFamilies=AF_UNIX
RestrictNamespaces=yes
RestrictSUIDSGID=yes
LockPersonality=yes
MemoryDenyWriteExecute=yes
SystemCallArchitectures=native
SystemCallFilter=@system-service
SystemCallErrorNumber=EPERM

[Install]
WantedBy={target}
"
    ))
}

const MACHINE_USER: &str = "
# Who reads the rig must be this user too.
User=USER
SupplementaryGroups=video
";

/// Restrictions that a user's own systemd has no right to set.
const MACHINE_FENCES: &str = "\
ReadWritePaths=/tmp
ProtectSystem=strict
ProtectHome=read-only
ProtectProc=invisible
ProtectClock=yes
ProtectControlGroups=yes
ProtectHostname=yes
ProtectKernelLogs=yes
ProtectKernelModules=yes
ProtectKernelTunables=yes
CapabilityBoundingSet=
IPAddressDeny=any
# Cameras, also those that are plugged in later.
DevicePolicy=closed
DeviceAllow=char-81 rw
";
