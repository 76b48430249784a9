//! The help of all commands, fitted to the terminal's width.
//!
//! clap wraps by a feature that brings another crate and asks standard output alone; so the texts are wrapped here, by what
//! wraps all else.

use clap::{Arg, ArgAction, Command};
use lariat_chain::layout::wrapped;

/// Where a line of `--help` begins below its flag, and the least room for a line of `-h` beside it.
const LONG_INDENT: usize = 10;
const LEAST: usize = 30;

/// The command with the texts of its help, and of all commands under it, wrapped.
pub(super) fn fitted(command: Command, width: usize) -> Command {
    let of_all = widest(&command);
    fitted_below(command, width, width, of_all)
}

/// `listed`: the room for what it says of itself among its neighbours. `of_all`: the widest flag that every command has.
fn fitted_below(command: Command, width: usize, listed: usize, of_all: usize) -> Command {
    let has_long = command
        .get_arguments()
        .any(|arg| arg.get_long_help().is_some());
    let widest = widest(&command).max(of_all);
    let beside = width.saturating_sub(widest + 4).max(LEAST);
    let below = width.saturating_sub(LONG_INDENT);
    let about = wrapped(&text(command.get_about()), listed);
    let long_about = command.get_long_about().map(ToString::to_string);
    // What had to be folded in the list has its full width in the command's own help.
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

/// How wide a flag is with what follows it, where `-h` shows it: `    --source <PATH>...`.
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

/// Default and possible values, where clap knows them.
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

/// Text whose paragraphs are apart by empty lines, each wrapped.
fn paragraphs(text: &str, width: usize) -> String {
    let each = text
        .split("\n\n")
        .map(|paragraph| wrapped(paragraph, width));
    each.collect::<Vec<_>>().join("\n\n")
}
