//! `lariat record`: writes a rig's messages to an MCAP file, or keeps the last seconds in memory
//! until they are requested.

mod about;
mod channels;
mod looks;
mod report;
mod stage;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use clap::Args;
use lariat_wire::members;
use rustix::process::{Pid, Signal, kill_process};

use lariat_chain::exit::wrong_use;
use lariat_chain::settings::{Flags, Settings};
use lariat_chain::stages::Supervision;

/// Stage name of a recorder on a rig.
const STAGE: &str = "record";

/// Arguments of `lariat record`.
#[derive(Debug, Args)]
pub(crate) struct RecordArgs {
    /// The recording
    #[arg(
        long,
        value_name = "FILE.mcap",
        required_unless_present = "flush",
        conflicts_with = "flush"
    )]
    out: Option<PathBuf>,
    /// Tell the rig's recorder, started with --ring, to write the frames that it holds
    #[arg(long)]
    flush: bool,
    #[command(flatten)]
    flags: Flags,
}

/// Records a rig that is running or will start later.
pub(crate) fn run(args: RecordArgs) -> Result<ExitCode> {
    let flush = args.flush;
    let settings = Settings::resolve(&args.flags)?;
    let Some(file) = args.out.filter(|_| !flush) else {
        return ask_to_flush(&settings.run.rig);
    };
    stage::run(&settings, &file, Supervision::of_this_process()?)
}

/// Records for the chain that started this process.
pub(crate) fn run_for_chain(flags: &Flags) -> Result<ExitCode> {
    let settings = Settings::of_stage(flags)?;
    let Some(file) = settings.run.record.clone() else {
        wrong_use!("there is nothing to record into: say --record FILE.mcap");
    };
    stage::run(&settings, &file, Supervision::of_this_process()?)
}

/// Asks the recorders of a rig that keep the last seconds to write them.
fn ask_to_flush(rig: &str) -> Result<ExitCode> {
    let of_rig = members()?;
    let recorders = of_rig
        .iter()
        .filter(|member| member.rig == rig && member.stage == STAGE);
    let mut asked = 0;
    for recorder in recorders.filter(|recorder| about::keeps_a_ring(&recorder.settings)) {
        let pid = i32::try_from(recorder.pid).ok().and_then(Pid::from_raw);
        let pid = pid.context("a recorder has no valid process id")?;
        kill_process(pid, Signal::USR1)
            .with_context(|| format!("recorder {} could not be reached", recorder.pid))?;
        eprintln!(
            "lariat: told recorder {} to write what it holds",
            recorder.pid
        );
        asked += 1;
    }
    if asked == 0 {
        bail!(
            "no recorder of rig {rig} keeps the last seconds: start one with `lariat record --ring 30s --out FILE.mcap`"
        );
    }
    Ok(ExitCode::SUCCESS)
}
