//! The flags that overrule the file, as the table of settings has them: the command line, its help, and what was given.

use crate::settings::keys::{self, KEYS, Key};
use crate::settings::kind::Takes;
use crate::settings::{STAGES, Settings, change, renamed};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use toml::Value;

/// The flag of a setting.
pub(super) struct Flag {
    /// As the help shows it: `--rig NAME`.
    pub(super) usage: &'static str,
    /// The commands that have it, beside `run` and those that take all that `run` does.
    pub(super) of: &'static str,
    /// One of [`HEADINGS`].
    pub(super) heading: &'static str,
    /// A line for `-h`; `--help` has what the table of settings says.
    pub(super) help: &'static str,
}

/// Commands that take every flag: those that run a whole chain, and those that it starts.
const TAKE_ALL: [&str; 4] = ["run", "recorder", "controller", "show"];

/// In the order of the help.
const HEADINGS: [&str; 9] = [
    "Source",
    "Camera",
    "Rope",
    "Curve",
    "Millimetres",
    "Run",
    "Report",
    "Recording",
    "Real time",
];

/// The flags that were given. Which there are depends on the command whose arguments they become, by its name.
#[derive(Debug, Clone, Default)]
pub struct Flags {
    /// Settings file (`--config`).
    pub config: Option<PathBuf>,
    given: Vec<Given>,
}

#[derive(Debug, Clone)]
struct Given {
    flag: &'static str,
    /// Which of [`KEYS`] it sets.
    key: usize,
    /// What was typed behind it; nothing behind a switch.
    typed: Vec<String>,
    /// As the file would have it.
    value: Value,
}

/// What was typed behind a flag, and the value that it is.
#[derive(Clone)]
struct Typed(String, Value);

impl Flags {
    /// Those of one settings file alone.
    pub fn of_file(path: PathBuf) -> Self {
        Self {
            config: Some(path),
            given: Vec::new(),
        }
    }

    /// Whether there are any.
    pub fn is_given(&self) -> bool {
        self.config.is_some() || !self.given.is_empty()
    }

    /// Whether this one is among them.
    pub fn has(&self, flag: &str) -> bool {
        self.given.iter().any(|given| given.flag == flag)
    }

    /// All but these.
    pub fn without(&self, flags: &[&str]) -> Self {
        let given = self.given.iter();
        let others = given.filter(|given| !flags.contains(&given.flag));
        Self {
            config: self.config.clone(),
            given: others.cloned().collect(),
        }
    }

    /// These, and a source.
    pub fn with_source(&self, path: &Path) -> Self {
        let mut flags = self.clone();
        let path = path.to_string_lossy().into_owned();
        let source = keys::position("capture", "source").map(|key| Given {
            flag: "--source",
            key,
            typed: vec![path.clone()],
            value: Value::Array(vec![Value::String(path)]),
        });
        flags.given.extend(source);
        flags
    }

    /// These, and a change that is written as `section.name=value`, which overrules them.
    ///
    /// # Errors
    /// There is no such setting, or nothing that could be a value.
    pub fn with_change(&self, text: &str) -> anyhow::Result<Self> {
        let (key, value) = change::parse(text)?;
        let mut flags = self.clone();
        flags.given.push(Given {
            // By what it is called there: it may have no flag.
            flag: KEYS[key].name,
            key,
            typed: Vec::new(),
            value,
        });
        Ok(flags)
    }

    /// Returns true if they set this.
    pub(super) fn set(&self, section: &str, name: &str) -> bool {
        let key = keys::position(section, name);
        self.given.iter().any(|given| Some(given.key) == key)
    }

    /// Whether they set anything of a section.
    pub fn set_any_of(&self, section: &str) -> bool {
        self.given
            .iter()
            .any(|given| KEYS[given.key].section == section)
    }

    /// As words of a command line, for the processes of a chain.
    pub fn words(&self) -> Vec<OsString> {
        let mut words = Vec::new();
        if let Some(path) = &self.config {
            words.extend(["--config".into(), path.into()]);
        }
        for Given { flag, typed, .. } in &self.given {
            if typed.is_empty() {
                words.push(flag.into());
            }
            words.extend(typed.iter().map(|text| format!("{flag}={text}").into()));
        }
        words
    }

    /// Each flag, with its setting's place in the table of settings.
    pub(super) fn given(&self) -> impl Iterator<Item = (&'static str, usize, &Value)> {
        self.given
            .iter()
            .map(|given| (given.flag, given.key, &given.value))
    }

    fn take(&mut self, key: usize, flag: &Flag, matches: &ArgMatches) {
        let mut give = |typed, value| {
            self.given.push(Given {
                flag: flag.name(),
                key,
                typed,
                value,
            });
        };
        let id = &flag.name()[2..];
        // A command that has no such flag was not given it.
        let of = |id| {
            let values = matches.try_get_many::<Typed>(id).ok().flatten();
            values.into_iter().flatten().cloned()
        };
        match (KEYS[key].takes)() {
            Takes::Nothing => {
                if let Ok(Some(true)) = matches.try_get_one(id).map(|yes| yes.copied()) {
                    give(Vec::new(), Value::Boolean(true));
                }
            }
            Takes::Paths => {
                let all = of(BARE_SOURCE).chain(of(id));
                let (typed, paths): (Vec<_>, Vec<_>) =
                    all.map(|Typed(text, value)| (text, value)).unzip();
                if !paths.is_empty() {
                    give(typed, Value::Array(paths));
                }
            }
            Takes::Positions => {
                let typed: Vec<_> = of(id).map(|Typed(text, _)| text).collect();
                if !typed.is_empty() {
                    let text = typed.join(",");
                    give(vec![text.clone()], Value::String(text));
                }
            }
            _ => of(id).for_each(|Typed(text, value)| give(vec![text], value)),
        }
    }
}

/// All flags in the order of the help, each with its setting's place in the table.
fn flags() -> Vec<(usize, &'static Flag)> {
    let keys = KEYS.iter().enumerate();
    let mut flags: Vec<_> = keys
        .filter_map(|(key, known)| Some((key, known.flag.as_ref()?)))
        .collect();
    flags.sort_by_key(|(_, flag)| HEADINGS.iter().position(|heading| *heading == flag.heading));
    flags
}

/// The sources that stand without a flag before them.
const BARE_SOURCE: &str = "SOURCE";

/// Whether a chain started this process: its stages are given all of the chain's flags, and take what concerns them.
fn is_started_by_a_chain() -> bool {
    std::env::var_os(crate::stages::status::STATUS_FD).is_some()
}

impl Args for Flags {
    fn augment_args(command: Command) -> Command {
        let name = command.get_name().to_owned();
        let takes_all =
            TAKE_ALL.contains(&&name[..]) || is_started_by_a_chain() && STAGES.contains(&&name[..]);
        let offered = |flag: &Flag| takes_all || flag.of.split(' ').any(|of| of == name);
        let mut command = flags()
            .into_iter()
            .filter(|(_, flag)| offered(flag))
            .fold(command, |command, (key, flag)| {
                command.arg(flag.arg(&KEYS[key]))
            });
        if command
            .get_arguments()
            .any(|arg| arg.get_id() == "control-points")
        {
            command = command.arg(renamed_order());
        }
        if ["run", "show", "capture"].contains(&&name[..]) {
            let bare = Arg::new(BARE_SOURCE)
                .num_args(1..)
                .action(ArgAction::Append)
                .value_parser(|text: &str| typed(&Takes::Paths, text))
                .help("Source of the frames, as with --source");
            command = command.arg(bare);
        }
        command.arg(
            Arg::new("config")
                .long("config")
                .value_name("FILE")
                .value_parser(clap::value_parser!(PathBuf))
                .help("Settings file [default: lariat.toml, if there]"),
        )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Flags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut flags = Self {
            config: matches.get_one("config").cloned(),
            given: Vec::new(),
        };
        if let Ok(Some(order)) = matches.try_get_one::<String>(renamed::ORDER) {
            let why = format!("--order: {order}: {}\n", renamed::refused_flag(order));
            return Err(clap::Error::raw(ErrorKind::ValueValidation, why));
        }
        for (key, flag) in self::flags() {
            flags.take(key, flag, matches);
        }
        Ok(flags)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Flag {
    /// With its dashes.
    fn name(&self) -> &'static str {
        self.usage.split(' ').next().unwrap_or_default()
    }

    fn arg(&self, key: &'static Key) -> Arg {
        let name = &self.name()[2..];
        let takes = (key.takes)();
        let arg = Arg::new(name)
            .long(name)
            .help(self.help)
            .long_help(long_help(key, &takes))
            .help_heading(self.heading);
        let Some((_, value_name)) = self.usage.split_once(' ') else {
            return arg.action(ArgAction::SetTrue);
        };
        let arg = arg.value_name(value_name).allow_hyphen_values(matches!(
            takes,
            Takes::Whole | Takes::Number | Takes::Numbers | Takes::Positions
        ));
        let arg = match takes {
            Takes::Paths => arg.num_args(1..).action(ArgAction::Append),
            Takes::Control | Takes::Positions => arg.action(ArgAction::Append),
            _ => arg.action(ArgAction::Set),
        };
        arg.value_parser(move |text: &str| typed(&takes, text))
    }
}

/// The flag that named a curve by its order: it says what to write now.
fn renamed_order() -> Arg {
    Arg::new(renamed::ORDER)
        .long(renamed::ORDER)
        .hide(true)
        .allow_hyphen_values(true)
        .value_name("N")
}

fn typed(takes: &Takes, text: &str) -> Result<Typed, String> {
    Ok(Typed(text.to_owned(), takes.value(text)?))
}

/// What the table of settings says: what it does, what it is if nobody says anything, what there is to choose from.
fn long_help(key: &Key, takes: &Takes) -> String {
    let mut text = key.about.replace('\n', " ");
    match (key.get)(&Settings::default()) {
        None | Some(Value::Boolean(_)) => {}
        Some(Value::String(word)) => text += &format!(" [default: {word}]"),
        Some(value) => text += &format!(" [default: {}]", takes.shown(&value)),
    }
    if let Takes::Name(names) = takes {
        text += &format!(" [possible values: {}]", names.join(", "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The commands that take some of the flags, and ask for them by their own name.
    const TAKE_SOME: [&str; 8] = [
        "capture", "extract", "fit", "sink", "record", "snapshot", "trace", "replay",
    ];

    #[test]
    fn every_flag_is_of_commands_that_there_are_and_stands_under_a_heading_that_there_is() {
        for flag in KEYS.iter().filter_map(|key| key.flag.as_ref()) {
            assert!(HEADINGS.contains(&flag.heading), "{}", flag.usage);
            for command in flag.of.split_whitespace() {
                assert!(TAKE_SOME.contains(&command), "{}: {command}", flag.usage);
            }
        }
    }
}
