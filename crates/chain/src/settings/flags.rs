//! The command-line flags that override the file, built from the table of settings: their
//! arguments, their help, and the flags that were given.

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
    /// The flag as the help shows it: `--rig NAME`.
    pub(super) usage: &'static str,
    /// Commands that have the flag, in addition to `run` and the commands that take all flags of
    /// `run`.
    pub(super) of: &'static str,
    /// One of [`HEADINGS`].
    pub(super) heading: &'static str,
    /// One line for `-h`. For `--help`, the text comes from the table of settings.
    pub(super) help: &'static str,
}

/// Commands that take every flag: those that run a whole chain, and those that a chain starts.
const TAKE_ALL: [&str; 4] = ["run", "recorder", "controller", "show"];

/// Headings in the order of the help.
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

/// The flags that were given. The name of the command determines which flags exist.
#[derive(Debug, Clone, Default)]
pub struct Flags {
    /// Settings file (`--config`).
    pub config: Option<PathBuf>,
    given: Vec<Given>,
}

#[derive(Debug, Clone)]
struct Given {
    flag: &'static str,
    /// Index in [`KEYS`] of the setting.
    key: usize,
    /// Text after the flag. Empty for a switch.
    typed: Vec<String>,
    /// The value as in the file.
    value: Value,
}

/// The text after a flag, and its value.
#[derive(Clone)]
struct Typed(String, Value);

impl Flags {
    /// Creates flags that only name a settings file.
    pub fn of_file(path: PathBuf) -> Self {
        Self {
            config: Some(path),
            given: Vec::new(),
        }
    }

    /// Returns true if any flags were given.
    pub fn is_given(&self) -> bool {
        self.config.is_some() || !self.given.is_empty()
    }

    /// Returns true if this flag was given.
    pub fn has(&self, flag: &str) -> bool {
        self.given.iter().any(|given| given.flag == flag)
    }

    /// Returns the flags without these.
    pub fn without(&self, flags: &[&str]) -> Self {
        let given = self.given.iter();
        let others = given.filter(|given| !flags.contains(&given.flag));
        Self {
            config: self.config.clone(),
            given: others.cloned().collect(),
        }
    }

    /// Returns the flags with a source added.
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

    /// Returns the flags with a change written as `section.name=value`, which overrides them.
    ///
    /// # Errors
    /// Returns an error if the setting does not exist or the value is invalid.
    pub fn with_change(&self, text: &str) -> anyhow::Result<Self> {
        let (key, value) = change::parse(text)?;
        let mut flags = self.clone();
        flags.given.push(Given {
            // Use the name of the setting, which may lack a flag.
            flag: KEYS[key].name,
            key,
            typed: Vec::new(),
            value,
        });
        Ok(flags)
    }

    /// Returns true if the flags set this setting.
    pub(super) fn set(&self, section: &str, name: &str) -> bool {
        let key = keys::position(section, name);
        self.given.iter().any(|given| Some(given.key) == key)
    }

    /// Returns true if the flags set anything in a section.
    pub fn set_any_of(&self, section: &str) -> bool {
        self.given
            .iter()
            .any(|given| KEYS[given.key].section == section)
    }

    /// Returns the flags as command-line arguments for the processes of a chain.
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

    /// Returns each flag with the index of its setting in the table.
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
        // The result is empty for a command without this flag.
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

/// Returns all flags in the order of the help, each with the index of its setting in the table.
fn flags() -> Vec<(usize, &'static Flag)> {
    let keys = KEYS.iter().enumerate();
    let mut flags: Vec<_> = keys
        .filter_map(|(key, known)| Some((key, known.flag.as_ref()?)))
        .collect();
    flags.sort_by_key(|(_, flag)| HEADINGS.iter().position(|heading| *heading == flag.heading));
    flags
}

/// Id of the positional arguments that name sources without a flag.
const BARE_SOURCE: &str = "SOURCE";

/// Returns true if a chain started this process. Its stages receive all flags of the chain and use
/// those that concern them.
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
    /// Returns the name with its dashes.
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

/// The former flag that named a curve by its order. It tells the user what to write now.
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

/// Returns the help from the table of settings: the description, the default, and the possible
/// values.
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

    /// Commands that take only some of the flags. Each flag names its commands.
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
