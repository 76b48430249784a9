//! Commands in the documents, for tests that all of them are understood.

use std::fs;
use std::path::{Path, PathBuf};

/// A command in a document.
#[derive(Debug, Clone, PartialEq)]
pub struct Command {
    /// Text of the command, on one line.
    pub text: String,
    /// Words of the command, from the program's name up to a comment or a pipe.
    pub words: Vec<String>,
}

/// Returns the commands in README.md, CONTRIBUTING.md, ARCHITECTURE.md and all of `docs/`, except
/// those with parts left out.
///
/// # Panics
/// Panics if a document cannot be read.
pub fn commands() -> Vec<Command> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let entries = fs::read_dir(root.join("docs")).expect("the folder of documents");
    let files = entries.map(|entry| entry.expect("readable").path());
    let documents = files.filter(|path| path.extension().is_some_and(|ending| ending == "md"));
    let first = ["README.md", "CONTRIBUTING.md", "ARCHITECTURE.md"].map(|name| root.join(name));
    let read = |path: PathBuf| fs::read_to_string(path).expect("a readable document");
    let texts = first.into_iter().chain(documents).map(read);
    texts.flat_map(|text| commands_in(&text)).collect()
}

/// Returns the commands in a document's text: `lariat …` or `lariat-bench …` in backquotes, or at
/// the start of a line in a code block.
pub fn commands_in(text: &str) -> Vec<Command> {
    let quoted = text.split('`').skip(1).step_by(2);
    let blocks = text.split("```").skip(1).step_by(2);
    let lines = blocks.flat_map(str::lines);
    let lines = lines.map(|line| line.trim_start().trim_start_matches("$ "));
    let all = quoted.chain(lines);
    let programs = ["lariat ", "lariat-"];
    let commands = all.filter(|text| programs.iter().any(|name| text.starts_with(name)));
    let command = |text: &str| {
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let words = words(&text)?;
        Some(Command { text, words })
    };
    commands.filter_map(command).collect()
}

/// Splits a command into words, up to a comment or a pipe; `None` if parts are left out.
fn words(command: &str) -> Option<Vec<String>> {
    let mut words = Vec::new();
    for (place, part) in command.split('"').enumerate() {
        match place % 2 {
            0 => words.extend(
                part.split(' ')
                    .filter(|word| !word.is_empty())
                    .map(str::to_owned),
            ),
            _ => words.push(part.to_owned()),
        }
    }
    let is_end = |word: &String| ["#", "|", ">", "&"].iter().any(|end| word.starts_with(end));
    let end = words.iter().position(is_end).unwrap_or(words.len());
    words.truncate(end);
    words
        .iter()
        .all(|word| !word.contains(['…', '[', '(', '{', '<']))
        .then_some(words)
}
