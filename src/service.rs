//! `lariat service`: a chain that systemd starts, supervises and restarts. It writes a template
//! unit (`lariat@RIG.service`) for all rigs, and the settings of one rig. The user starts the
//! chain, because the settings must name a camera first.

mod place;
mod unit;

use std::fs;
use std::path::PathBuf;
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context, Result, bail};
use clap::{Args, Subcommand};
use lariat_chain::exit::wrong_use;
use lariat_chain::output::{Existing, Output, print};
use lariat_chain::settings::template;
use lariat_wire::Rig;
use place::Place;
use rustix::process::geteuid;

/// Run a chain as a systemd service
#[derive(Debug, Args)]
pub(crate) struct ServiceArgs {
    #[command(subcommand)]
    command: ServiceCommand,
}

#[derive(Debug, Subcommand)]
enum ServiceCommand {
    /// Install the unit, and default settings for a rig without any
    Install(PlaceArgs),
    /// Stop and disable a rig's chain, and remove the unit with the last one. Keep the settings
    Uninstall(PlaceArgs),
    /// Print the unit that `install` would write
    Show(PlaceArgs),
}

#[derive(Debug, Args)]
struct PlaceArgs {
    /// Camera chain
    #[arg(long, value_name = "NAME", default_value_t = Rig::default())]
    rig: Rig,
    /// For the current user only, in ~/.config, without root
    #[arg(long, conflicts_with_all = ["run_as", "root"])]
    user: bool,
    /// User of the service; readers of the rig must run as the same user
    #[arg(
        id = "run_as",
        long = "as",
        value_name = "USER",
        default_value = "lariat"
    )]
    run_as: String,
    /// For packages: install below this folder instead of /, with /usr/bin/lariat, without touching this machine
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
}

/// Runs `lariat service`.
///
/// # Errors
/// Returns an error if rights are missing, the user does not exist, or files cannot be written or
/// are not lariat's.
pub(crate) fn run(args: ServiceArgs) -> Result<ExitCode> {
    match args.command {
        ServiceCommand::Install(args) => install(&args)?,
        ServiceCommand::Uninstall(args) => uninstall(&args)?,
        ServiceCommand::Show(args) => print(&args.unit()?)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn install(args: &PlaceArgs) -> Result<()> {
    let place = args.place()?;
    let unit = args.unit()?;
    let mut said = String::new();
    let mut notes = String::new();
    if args.is_of_this_machine() {
        args.require_root()?;
        if !args.user {
            notes = place::require_user_can_run(&args.run_as, &place.program)?;
        }
    }
    if place
        .of_package
        .as_deref()
        .is_some_and(|path| holds(path, &unit))
    {
        said += "the package's unit is as it should be\n";
    } else {
        require_ours(&place.unit)?;
        write(&place.unit, Existing::Replace, &unit)?;
        said += &format!("wrote {}\n", place.unit.display());
    }
    let settings = place.settings(&args.rig);
    if settings.exists() {
        said += &format!("kept {}\n", settings.display());
    } else {
        write(&settings, Existing::Keep, &template())?;
        said += &format!("wrote {}: name the camera there\n", settings.display());
    }
    if args.is_of_this_machine() {
        args.systemctl(&["daemon-reload"])?;
        let (sudo, flag) = args.words();
        let name = unit::instance(&args.rig);
        said += &notes;
        said += &format!(
            "start it, now and with the machine: {sudo}systemctl {flag}enable --now {name}\n"
        );
        said += &format!("what it says: journalctl {flag}-fu {name}\n");
    }
    print(&said)
}

fn uninstall(args: &PlaceArgs) -> Result<()> {
    let place = args.place()?;
    let is_of_package = place
        .of_package
        .as_deref()
        .is_some_and(std::path::Path::exists);
    if args.is_of_this_machine() {
        args.require_root()?;
    }
    if !place.unit.exists() && !is_of_package {
        bail!("there is no {}: nothing to take away", place.unit.display());
    }
    require_ours(&place.unit)?;
    if args.is_of_this_machine() {
        args.systemctl(&["disable", "--now", &unit::instance(&args.rig)])?;
    }
    let mut said = String::new();
    let others = place.enabled(&args.rig);
    if !others.is_empty() {
        said += &format!("kept the unit, as it serves {} too\n", others.join(", "));
    } else if place.unit.exists() {
        fs::remove_file(&place.unit)
            .with_context(|| format!("{} cannot be removed", place.unit.display()))?;
        said += &format!("removed {}\n", place.unit.display());
        if args.is_of_this_machine() {
            args.systemctl(&["daemon-reload"])?;
        }
    } else {
        said += "kept the unit, which is the package's\n";
    }
    let settings = place.settings(&args.rig);
    if settings.exists() {
        said += &format!("kept {}\n", settings.display());
    }
    print(&said)
}

impl PlaceArgs {
    fn place(&self) -> Result<Place> {
        match &self.root {
            Some(root) => Ok(Place::of_package(root)),
            None if self.user => Place::of_user(),
            None => Place::of_machine(),
        }
    }

    fn unit(&self) -> Result<String> {
        let run_as = (!self.user).then_some(self.run_as.as_str());
        unit::text(&self.place()?.program, run_as)
    }

    fn is_of_this_machine(&self) -> bool {
        self.root.is_none()
    }

    fn require_root(&self) -> Result<()> {
        if !self.user && !geteuid().is_root() {
            wrong_use!(
                "a service of the whole machine is root's to change: type sudo before it, or take --user for one of yours alone"
            );
        }
        Ok(())
    }

    /// Words before and after `systemctl`.
    fn words(&self) -> (&'static str, &'static str) {
        match self.user {
            true => ("", "--user "),
            false => ("sudo ", ""),
        }
    }

    /// Runs `systemctl`, if systemd runs this machine.
    fn systemctl(&self, words: &[&str]) -> Result<()> {
        // The same test as sd_booted(3).
        if !std::path::Path::new("/run/systemd/system").exists() {
            return Ok(());
        }
        let mut command = Command::new("systemctl");
        command.args(self.user.then_some("--user")).args(words);
        let output = command.stdin(Stdio::null()).output();
        let output = output.context("systemctl cannot be started")?;
        if !output.status.success() {
            let why = String::from_utf8_lossy(&output.stderr);
            bail!("systemctl {} failed: {}", words.join(" "), why.trim());
        }
        Ok(())
    }
}

fn holds(path: &std::path::Path, text: &str) -> bool {
    fs::read_to_string(path).is_ok_and(|found| found == text)
}

/// Returns an error if somebody else wrote the unit, which is then neither replaced nor removed.
fn require_ours(path: &std::path::Path) -> Result<()> {
    match fs::read_to_string(path) {
        Ok(text) if !text.starts_with(unit::HEAD) => bail!(
            "{} was not written by lariat: move it away first",
            path.display()
        ),
        Err(cause) if path.exists() => {
            Err(cause).with_context(|| format!("{} cannot be read", path.display()))
        }
        _ => Ok(()),
    }
}

fn write(path: &std::path::Path, existing: Existing, text: &str) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)
            .with_context(|| format!("the folder {} cannot be made", folder.display()))?;
    }
    Output::new(path, existing, [])?.write(text.as_bytes())
}
