//! The command line: its commands and flags, and their dispatch.

mod help;

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::ExitCode;

use anyhow::Result;
use clap::error::ErrorKind;
use clap::{ArgAction, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;
use lariat_capture::names_a_camera;
use tracing::Level;

use crate::beside::{self, Words};
use crate::calibrate::{self, CalibrateArgs};
use crate::config_command::{self, ConfigArgs};
use crate::devices::{self, DevicesArgs};
use crate::doctor::{self, DoctorArgs};
use crate::export::{self, ExportArgs};
use crate::fit_lines::{self, FitArgs};
use crate::info::{self, InfoArgs};
use crate::man::{self, ManArgs};
use crate::pick::{self, PickArgs};
use crate::record::{self, RecordArgs};
use crate::replay::{self, ReplayArgs};
use crate::service::{self, ServiceArgs};
use crate::set::{self, RestartArgs, SetArgs};
use crate::snapshot::{self, SnapshotArgs};
use crate::topic::{self, TopicArgs};
use crate::trace::{self, TraceArgs};
use crate::version;
use crate::view::{self, ViewArgs};
use lariat_chain::settings::{Flags, Settings, nearest};
use lariat_chain::stages::Supervision;
use lariat_chain::stop::Stop;
use lariat_chain::{exit, launcher, layout, messages, output, stages};

/// Find ropes, cables and hoses in camera frames, and give a control loop their shape through shared memory
///
/// Without a command, `lariat` runs the whole chain on a rendered rope for 10 seconds. `lariat SOURCE` is `lariat run SOURCE`.
#[derive(Parser)]
#[command(name = "lariat", version, long_version = version::long(), after_help = exit::CODES)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    verbosity: Verbosity,
}

/// Verbosity on standard error, for the command and all processes that it starts.
#[derive(clap::Args)]
struct Verbosity {
    /// Print more messages; -vv prints all
    #[arg(short, long, global = true, action = ArgAction::Count, conflicts_with = "quiet")]
    verbose: u8,
    /// Print only warnings, errors and results
    #[arg(short, long, global = true)]
    quiet: bool,
}

/// Arguments of `lariat run`: the flags of a chain, and whether to show its page.
#[derive(clap::Args)]
struct RunArgs {
    /// Also show the chain in the browser, as `lariat view` does; prints the page's address
    #[arg(long, help_heading = "Run")]
    view: bool,
    #[command(flatten)]
    flags: Flags,
}

const SET_EXAMPLES: &str = "Examples:
  lariat set fit.control_points=7              change the rig default
  lariat set --rig cell extract.ropes=2 capture.fps=60
  lariat set                                   print the current settings";

const RUN_EXAMPLES: &str = "Examples:
  lariat run rope.png --loop --duration 10s    show one picture repeatedly
  lariat run /dev/video0 --record run.mcap     record a camera";

const COMPLETIONS_EXAMPLES: &str = "Examples:
  lariat completions bash > ~/.local/share/bash-completion/completions/lariat
  lariat completions zsh > ~/.zfunc/_lariat
  lariat completions fish > ~/.config/fish/completions/lariat.fish";

#[derive(Subcommand)]
enum Command {
    /// Run the whole chain: capture, extract, fit and sink, each in its own process
    #[command(after_help = RUN_EXAMPLES)]
    Run(RunArgs),
    /// Run the first stage alone: send a source's frames
    Capture(Flags),
    /// Run the second stage alone: frames in, centerlines out
    Extract(Flags),
    /// Run the third stage alone; or fit curves to centerlines, line by line
    Fit(FitArgs),
    /// Run the last stage alone: count and time the results, and report at the end
    Sink(Flags),
    /// Change settings of a running chain, between two frames if possible
    #[command(after_help = SET_EXAMPLES)]
    Set(SetArgs),
    /// Restart a stage of a running chain; the others and all readers continue
    Restart(RestartArgs),
    /// Record the frames and results of a running chain, as an MCAP file
    Record(RecordArgs),
    /// The recorder that `run --record` starts
    #[command(hide = true)]
    Recorder(Flags),
    /// Recompute a recording, to check it or to try other settings
    Replay(Box<ReplayArgs>),
    /// Export a recording as a table, JSON lines, a video or pictures
    Export(ExportArgs),
    /// Describe a recording
    Info(InfoArgs),
    /// Find the ropes in pictures and fit curves to them
    Trace(TraceArgs),
    /// Pick the colors of a picture's ropes, as a mask for lariat.toml
    Pick(PickArgs),
    /// Calibrate the table's plane from points with known positions
    Calibrate(CalibrateArgs),
    /// List this machine's cameras: formats, sizes, rates and controls
    Devices(DevicesArgs),
    /// Save one frame of a camera or another source as PNG
    Snapshot(SnapshotArgs),
    /// Show a running chain live on the terminal (program lariat-top)
    #[command(disable_help_flag = true)]
    Top(Words),
    /// Show a running chain live in the browser and in Foxglove
    View(ViewArgs),
    /// Inspect the channels of a running chain
    Topic(TopicArgs),
    /// Connect a rig with a ROS 2 graph (program lariat-ros2)
    Ros2(Words),
    /// Carry a rig to another machine (program lariat-bridge)
    Bridge(Words),
    /// Write, check and show lariat.toml
    Config(ConfigArgs),
    /// Check this machine: what slows lariat down, and how to fix it
    Doctor(DoctorArgs),
    /// Run a chain as a systemd service
    Service(ServiceArgs),
    /// Print a completion script for a shell
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Write the manual pages, for packages
    #[command(hide = true)]
    Man(ManArgs),
    /// Repeat the experiments of the paper that lariat is built on
    #[command(disable_help_flag = true)]
    Paper(Words),
    /// Drive a simulated rope to a shape through the whole chain, and measure how well
    #[command(disable_help_flag = true)]
    Servo(Words),
    /// Measure end-to-end latency, its lower bounds, and other systems
    #[command(disable_help_flag = true)]
    Bench(Words),
    /// Compare two summary.json files: changes that exceed the noise
    #[command(disable_help_flag = true)]
    Compare(Words),
}

/// Flags of the chain that runs when no command is given.
const SHOW: [&str; 1] = ["--duration=10s"];

/// Runs the command on the command line.
pub(crate) fn run() -> Result<ExitCode> {
    let words = with_a_command(std::env::args_os().collect());
    // The signal handlers come before all other work, so that an early Ctrl-C also ends a chain in
    // order.
    let stop = starts_a_chain(&words).then(Stop::on_signals).transpose()?;
    let chain_stop = || stop.map_or_else(Stop::on_signals, Ok);
    let command = help::fitted(Cli::command(), layout::width());
    let matches = command.try_get_matches_from(&words);
    let cli = matches.and_then(|matches| Cli::from_arg_matches(&matches));
    let Cli { command, verbosity } = cli.unwrap_or_else(|error| refuse(&error, &words));
    log_to_stderr(verbosity.level());
    match command {
        None => {
            let settings = Settings::of_chain(&Flags::default())?;
            settings.check_frames()?;
            let words = [&SHOW.map(OsString::from)[..], &verbosity.words()].concat();
            launcher::run(&Flags::default(), &words, settings, &chain_stop()?)
        }
        Some(Command::Run(RunArgs { view, flags })) => {
            // Resolved here too, so that a mistake is reported once and not by four processes.
            let settings = Settings::of_chain(&flags)?;
            settings.check_frames()?;
            let _page = match view {
                true => Some(view::Beside::start(&settings.run.rig)?),
                false => None,
            };
            launcher::run(&flags, &verbosity.words(), settings, &chain_stop()?)
        }
        Some(Command::Capture(flags)) => stage(&flags, stages::capture::run),
        Some(Command::Extract(flags)) => stage(&flags, stages::extract::run),
        Some(Command::Fit(args)) if fit_lines::is_line_filter(&args) => fit_lines::run(args),
        Some(Command::Fit(args)) => stage(&args.flags, stages::fit::run),
        Some(Command::Sink(flags)) => {
            let mut settings = Settings::of_stage(&flags)?;
            settings.sink.live &= !verbosity.quiet;
            stages::sink::run(&settings, Supervision::of_this_process()?)
                .map(|()| ExitCode::SUCCESS)
        }
        Some(Command::Set(args)) => set::run(&args),
        Some(Command::Restart(args)) => set::restart(&args),
        Some(Command::Record(args)) => record::run(args),
        Some(Command::Recorder(flags)) => record::run_for_chain(&flags),
        Some(Command::Replay(args)) => replay::run(*args),
        Some(Command::Export(args)) => export::run(args),
        Some(Command::Info(args)) => info::run(args),
        Some(Command::Trace(args)) => trace::run(args),
        Some(Command::Pick(args)) => pick::run(args),
        Some(Command::Calibrate(args)) => calibrate::run(args),
        Some(Command::Devices(args)) => devices::run(args),
        Some(Command::Snapshot(args)) => snapshot::run(args),
        Some(Command::Top(words)) => beside::run("top", &words),
        Some(Command::View(args)) => view::run(&args),
        Some(Command::Topic(args)) => topic::run(args),
        Some(Command::Ros2(words)) => beside::run("ros2", &words),
        Some(Command::Bridge(words)) => beside::run("bridge", &words),
        Some(Command::Config(args)) => config_command::run(args),
        Some(Command::Doctor(args)) => doctor::run(args),
        Some(Command::Service(args)) => service::run(args),
        Some(Command::Completions { shell }) => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Cli::command(), "lariat", &mut script);
            output::print(&String::from_utf8_lossy(&script))?;
            Ok(ExitCode::SUCCESS)
        }
        Some(Command::Man(args)) => man::run(&args, Cli::command()),
        Some(Command::Paper(words)) => beside::measure("paper", &words),
        Some(Command::Servo(words)) => beside::measure("servo", &words),
        Some(Command::Bench(words)) => beside::measure("latency", &words),
        Some(Command::Compare(words)) => beside::measure("compare", &words),
    }
}

fn stage(flags: &Flags, run: fn(&Settings, Supervision) -> Result<()>) -> Result<ExitCode> {
    run(&Settings::of_stage(flags)?, Supervision::of_this_process()?).map(|()| ExitCode::SUCCESS)
}

/// Returns the words of the command line, with `run` inserted if a source is in the place of a
/// command.
fn with_a_command(mut words: Vec<OsString>) -> Vec<OsString> {
    if let Some(place) = place_of_command(&words)
        && is_a_source(&words[place])
    {
        words.insert(place, "run".into());
    }
    words
}

/// Returns true if these words, with `run` before a bare source, start a chain.
fn starts_a_chain(words: &[OsString]) -> bool {
    place_of_command(words).is_none_or(|place| words[place] == "run")
}

fn place_of_command(words: &[OsString]) -> Option<usize> {
    let is_flag = |word: &OsString| word.as_encoded_bytes().starts_with(b"-") && word != "-";
    (1..words.len()).find(|&place| !is_flag(&words[place]))
}

/// Returns true if the word names a source of frames and not a command.
fn is_a_source(word: &OsStr) -> bool {
    let path = Path::new(word);
    // The most frequent command comes first, because the table of commands takes milliseconds to
    // build.
    let is_command = ["run", "help"].iter().any(|name| word == *name)
        || Cli::command().find_subcommand(word).is_some();
    let is_named = ["rendered", "simulated", "external", "-"]
        .iter()
        .any(|name| word == *name);
    !is_command && (is_named || names_a_camera(path) || path.exists())
}

/// Reports a mistake on the command line and ends the process. A request for help is not an error.
fn refuse(error: &clap::Error, words: &[OsString]) -> ! {
    let place = place_of_command(words).filter(|_| error.kind() == ErrorKind::InvalidSubcommand);
    let word = place.map(|place| words[place].to_string_lossy());
    let Some(word) = word.filter(|word| word != "help") else {
        error.exit()
    };
    eprintln!("lariat: {word} is neither a command nor a file");
    let cli = Cli::command();
    let commands = cli
        .get_subcommands()
        .filter(|command| !command.is_hide_set());
    if let Some(command) = nearest(&word, commands.map(clap::Command::get_name)) {
        eprintln!("  a command like it: lariat {command}");
    }
    if let Some(file) = file_like(Path::new(&*word)) {
        eprintln!("  a file like it:    lariat run {file}");
    }
    eprintln!("  all commands:      lariat --help");
    std::process::exit(2)
}

/// Finds the file in the same folder with the most similar name.
fn file_like(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    let entries = std::fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?;
    let names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    let like = nearest(
        path.file_name()?.to_str()?,
        names.iter().map(String::as_str),
    )?;
    Some(path.with_file_name(like).display().to_string())
}

impl Verbosity {
    /// Converts to command-line flags for the processes of a chain.
    fn words(&self) -> Vec<OsString> {
        let verbose = (0..self.verbose).map(|_| "--verbose");
        let quiet = self.quiet.then_some("--quiet");
        verbose.chain(quiet).map(OsString::from).collect()
    }

    /// Log level: from the flags, otherwise from `RUST_LOG` (a level, or `lariat=LEVEL` among
    /// others), otherwise "info".
    fn level(&self) -> Option<Level> {
        match (self.quiet, self.verbose) {
            (true, _) => return Some(Level::WARN),
            (_, 0) => {}
            (_, 1) => return Some(Level::DEBUG),
            _ => return Some(Level::TRACE),
        }
        let said = std::env::var("RUST_LOG").unwrap_or_default();
        let mut ours = said
            .split(',')
            .filter_map(|part| match part.split_once('=') {
                None => Some(part),
                Some(("lariat", level)) => Some(level),
                Some(_) => None,
            });
        match ours.next_back().unwrap_or_default() {
            "off" => None,
            level => Some(level.parse().unwrap_or(Level::INFO)),
        }
    }
}

fn log_to_stderr(level: Option<Level>) {
    tracing_subscriber::fmt()
        .with_writer(|| messages::Log)
        .without_time()
        .with_target(false)
        // Internal errors would go to the output that has just failed.
        .log_internal_errors(false)
        .with_ansi(layout::has_colours(lariat_chain::messages::is_terminal()))
        .with_max_level(level.map_or(tracing::level_filters::LevelFilter::OFF, Into::into))
        .init();
}

#[cfg(test)]
mod tests {
    use super::{Cli, ErrorKind, RUN_EXAMPLES};
    use clap::CommandFactory;
    use lariat_test_support::documents::{self, Command};

    #[test]
    fn every_command_in_the_documents_is_understood() {
        let mut count = 0;
        let examples = documents::commands_in(&format!("```{RUN_EXAMPLES}```"));
        let all = documents::commands().into_iter().chain(examples);
        for Command { text, mut words } in all.filter(|command| command.words[0] == "lariat") {
            // A source may be in the place of a command.
            if words.get(1).is_some_and(|word| word.contains('.')) {
                words.insert(1, "run".to_owned());
            }
            let parsed = Cli::command().try_get_matches_from(words);
            // A document may mention a command without its arguments.
            let is_understood = |error: &clap::Error| {
                use ErrorKind::{
                    DisplayHelp, DisplayHelpOnMissingArgumentOrSubcommand, DisplayVersion,
                    MissingRequiredArgument,
                };
                [
                    DisplayHelp,
                    DisplayVersion,
                    DisplayHelpOnMissingArgumentOrSubcommand,
                    MissingRequiredArgument,
                ]
                .contains(&error.kind())
            };
            if let Some(error) = parsed.err().filter(|error| !is_understood(error)) {
                panic!("{text}: {error}");
            }
            count += 1;
        }
        assert!(count > 50, "the documents have {count} commands only");
    }

    #[test]
    fn no_flag_is_defined_twice_nor_has_a_setting_that_is_none() {
        Cli::command().debug_assert();
    }
}
