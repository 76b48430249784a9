//! `lariat view`: shows a rig in the browser and in Foxglove ([`lariat_view`]).

use std::net::{IpAddr, Ipv4Addr};
use std::os::fd::AsFd;
use std::os::unix::process::CommandExt as _;
use std::path::PathBuf;
use std::process::{Child, ExitCode};

use anyhow::{Context, Result};
use clap::Args;
use lariat_chain::itself;
use lariat_chain::messages::Intake;
use lariat_chain::stop::Stop;
use lariat_view::{Options, Server, Shown};
use lariat_wire::Rig;
use rustix::process::{Pid, Signal, getppid, kill_process, set_parent_process_death_signal};

/// Default port, if it is free.
const PORT: u16 = 8765;

/// Arguments of `lariat view`.
#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    /// Recording to show instead of a chain
    #[arg(value_name = "FILE.mcap", conflicts_with = "rig")]
    file: Option<PathBuf>,
    /// Image topic, if the recording has several cameras
    #[arg(long, value_name = "TOPIC", requires = "file")]
    topic: Option<String>,
    /// Chain to show (default: `default`, or the first one)
    #[arg(long, value_name = "NAME")]
    rig: Option<Rig>,
    /// Address to listen on, for other machines: one of this machine's, or 0.0.0.0 for all. The
    /// page's address then has a token; whoever knows it can see and change everything
    #[arg(long, value_name = "ADDR", default_value_t = Ipv4Addr::LOCALHOST.into(), hide_default_value = true)]
    listen: IpAddr,
    /// Port of the page (default: 8765, or any that is free)
    #[arg(long, value_name = "NUMBER")]
    port: Option<u16>,
    /// Process of the chain that started the page; the page ends with it
    #[arg(long, value_name = "PID", hide = true)]
    beside: Option<i32>,
}

/// Runs `lariat view` until Ctrl-C or SIGTERM.
///
/// # Errors
/// Returns an error if it cannot listen on this address.
pub(crate) fn run(args: &ViewArgs) -> Result<ExitCode> {
    let stop = Stop::on_signals()?;
    if let Some(chain) = args.beside {
        set_parent_process_death_signal(Some(Signal::TERM))
            .context("the chain cannot be asked to stop")?;
        if getppid().map(Pid::as_raw_pid) != Some(chain) {
            return Ok(ExitCode::SUCCESS);
        }
    }
    let options = Options {
        shown: match &args.file {
            Some(file) => Shown::Recording {
                path: file.clone(),
                topic: args.topic.clone(),
            },
            None => Shown::Rig(args.rig.clone()),
        },
        listen: args.listen,
        port: args.port.unwrap_or(PORT),
    };
    let server = match Server::bind(&options) {
        Err(_) if args.port.is_none() => Server::bind(&Options { port: 0, ..options })?,
        server => server?,
    };
    eprintln!("lariat: the page is at {}", server.url());
    tracing::debug!(
        "for pages of other sites, as Foxglove: {}",
        server.url_with_token()
    );
    server.run(stop.as_fd())?;
    Ok(ExitCode::SUCCESS)
}

/// A `lariat view` process that shows a chain. Dropping it ends the process.
pub(crate) struct Beside {
    process: Child,
    messages: Option<Intake>,
}

impl Beside {
    /// Starts the page of a rig.
    ///
    /// # Errors
    /// Returns an error if the process cannot be started.
    pub(crate) fn start(rig: &str) -> Result<Self> {
        let mut command = itself::command();
        command
            .args(["view", "--rig", rig, "--beside"])
            .arg(std::process::id().to_string())
            // Only the chain gets Ctrl-C; the page still shows its last frames.
            .process_group(0);
        let mut process = Intake::prepare(&mut command)
            .spawn()
            .context("the page cannot be served")?;
        let messages = process.stderr.take().map(Intake::of).transpose()?;
        Ok(Self { process, messages })
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        let pid = i32::try_from(self.process.id()).ok();
        if let Some(pid) = pid.and_then(Pid::from_raw) {
            let _ = kill_process(pid, Signal::TERM);
        }
        let _ = self.process.wait();
        if let Some(messages) = self.messages.take() {
            messages.finish();
        }
    }
}
