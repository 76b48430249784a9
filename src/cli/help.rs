//! Help of all commands, wrapped to the terminal's width.
//!
//! Wrapping in clap needs another crate and considers standard output only. The code that wraps all
//! other output wraps the help, too.

use clap::{Arg, ArgAction, Command};
use lariat_chain::exit;
use lariat_chain::layout::wrapped;

/// Indentation of a line of `--help` below its flag, and the minimum width of a `-h` text next to
/// its flag.
const LONG_INDENT: usize = 10;
const LEAST: usize = 30;

/// Commands grouped by purpose, each with a short description.
pub(super) const GROUPS: [(&str, &[(&str, &str)]); 5] = [
    (
        "Run",
        &[
            ("run", "the whole chain, on a camera or on files"),
            ("capture, extract, fit, sink", "one of its stages alone"),
            ("set, restart", "change a running chain; restart a stage"),
            (
                "service, ros2, bridge",
                "by systemd; in ROS 2; on another machine",
            ),
        ],
    ),
    (
        "Look",
        &[
            ("top, view", "a running chain in the terminal or browser"),
            ("topic", "the messages on its channels"),
            (
                "trace, snapshot",
                "the ropes in pictures; a frame of a camera",
            ),
        ],
    ),
    (
        "Record",
        &[
            (
                "record, replay",
                "record a chain; compute a recording again",
            ),
            ("export, info", "its contents as a table, JSON or video"),
        ],
    ),
    (
        "Set up",
        &[
            (
                "doctor, devices",
                "what slows this machine down; its cameras",
            ),
            ("pick, calibrate", "the ropes' colours; the table's place"),
            (
                "config, completions",
                "the file lariat.toml; completion in shells",
            ),
        ],
    ),
    (
        "Measure",
        &[
            ("bench, compare", "latency on this machine; two results"),
            ("paper, servo", "the paper's experiments; a closed loop"),
        ],
    ),
];

/// Help of `lariat` itself, which fits a terminal of 80 columns and 24 lines.
pub(super) fn overview() -> String {
    let mut text = "\
lariat sees ropes, cables and hoses through a camera, and gives a control loop
their shape through shared memory. Without a command it shows a drawn rope.

Usage: lariat [OPTIONS] [COMMAND or SOURCE]

"
    .to_owned();
    for (group, commands) in GROUPS {
        let titles = std::iter::once(group).chain(std::iter::repeat(""));
        for (title, (names, about)) in titles.zip(commands) {
            text += &format!("{title:<8} {names:<28} {about}\n");
        }
    }
    text += "
Options: -q, --quiet; -v, --verbose (-vv: everything); -V, --version; -h, --help
`lariat COMMAND --help` explains a command and its options.
";
    text += exit::CODES;
    text.push('\n');
    text
}

/// Gives the command the overview as its help, and wraps the help of all subcommands.
pub(super) fn fitted(command: Command, width: usize) -> Command {
    let of_all = widest(&command);
    fitted_below(command, width, width, of_all).override_help(overview())
}

/// Wraps a command's help. `listed`: width of its description in the list of its parent. `of_all`:
/// widest flag that every command has.
fn fitted_below(command: Command, width: usize, listed: usize, of_all: usize) -> Command {
    let has_long = command
        .get_arguments()
        .any(|arg| arg.get_long_help().is_some());
    let widest = widest(&command).max(of_all);
    let beside = width.saturating_sub(widest + 4).max(LEAST);
    let below = width.saturating_sub(LONG_INDENT);
    let about = wrapped(&text(command.get_about()), listed);
    let long_about = command.get_long_about().map(ToString::to_string);
    // A description that is folded in the list has its full width in the command's own help.
    let long_about = long_about.or_else(|| about.contains('\n').then(|| about.clone()));
    let names = command
        .get_subcommands()
        .map(|command| command.get_name().len());
    let listed = width
        .saturating_sub(4 + names.max().unwrap_or(0))
        .max(LEAST);
    let mut command = command.mut_args(|arg| {
        let choices = choices(&arg);
        let short = format!("{}{choices}", text(arg.get_help()));
        let long = arg
            .get_long_help()
            .map_or(short.clone(), |long| format!("{long}{choices}"));
        let arg = match arg.get_action().takes_values() {
            true => arg.hide_default_value(true).hide_possible_values(true),
            false => arg,
        };
        let arg = arg.help(wrapped(&short, beside));
        match has_long {
            true => arg.long_help(paragraphs(&long, below)),
            false => arg,
        }
    });
    if let Some(long) = long_about {
        command = command.long_about(paragraphs(&long, width));
    }
    command
        .about(about)
        .mut_subcommands(|command| fitted_below(command, width, listed, of_all))
}

fn text(text: Option<&clap::builder::StyledStr>) -> String {
    text.map_or(String::new(), ToString::to_string)
}

fn widest(command: &Command) -> usize {
    command.get_arguments().map(spec).max().unwrap_or(0)
}

/// Width of a flag and its value, as `-h` shows them: `    --source <PATH>...`.
fn spec(arg: &Arg) -> usize {
    let flag = arg.get_long().map_or(0, |long| "    --".len() + long.len());
    let action = arg.get_action();
    let value = match action.takes_values() {
        true => {
            let names = arg.get_value_names().unwrap_or_default();
            let longest = names.iter().map(|name| name.len()).max();
            " <>".len() + longest.unwrap_or(arg.get_id().as_str().len())
        }
        false => 0,
    };
    let more = matches!(action, ArgAction::Append | ArgAction::Count);
    flag + value + if more { "...".len() } else { 0 }
}

/// Default and possible values, if clap knows them.
fn choices(arg: &Arg) -> String {
    let mut text = String::new();
    let takes_values = arg.get_action().takes_values();
    let defaults: Vec<_> = arg
        .get_default_values()
        .iter()
        .map(|value| value.to_string_lossy())
        .collect();
    if takes_values && !defaults.is_empty() {
        text += &format!(" [default: {}]", defaults.join(" "));
    }
    let possible = arg.get_possible_values();
    if takes_values && !possible.is_empty() {
        let names: Vec<_> = possible.iter().map(|value| value.get_name()).collect();
        text += &format!(" [possible values: {}]", names.join(", "));
    }
    text
}

/// Wraps paragraphs, which are separated by empty lines.
fn paragraphs(text: &str, width: usize) -> String {
    let each = text
        .split("\n\n")
        .map(|paragraph| wrapped(paragraph, width));
    each.collect::<Vec<_>>().join("\n\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_overview_fits_a_terminal_of_24_lines_of_80_columns() {
        let text = overview();
        // The prompt needs the last line.
        assert!(text.lines().count() < 24, "{text}");
        for line in text.lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
    }

    #[test]
    fn the_overview_lists_each_command_once() {
        let listed = |group: &[(&'static str, &str)]| -> Vec<&str> {
            let names = group.iter().flat_map(|(names, _)| names.split(", "));
            names.collect()
        };
        let mut all: Vec<&str> = GROUPS.iter().flat_map(|(_, group)| listed(group)).collect();
        all.sort_unstable();
        let cli = <super::super::Cli as clap::CommandFactory>::command();
        let visible = cli
            .get_subcommands()
            .filter(|command| !command.is_hide_set());
        let mut visible: Vec<&str> = visible.map(Command::get_name).collect();
        // Measurements are a separate program, which may be missing.
        let (_, measure) = GROUPS[GROUPS.len() - 1];
        visible.extend(listed(measure));
        visible.sort_unstable();
        visible.dedup();
        assert_eq!(all, visible);
    }
}
