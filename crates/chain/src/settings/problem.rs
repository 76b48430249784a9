//! Errors in the settings, and their origins.

use crate::settings::keys::KEYS;
use std::fmt;
use std::path::PathBuf;

/// Origin of a setting. A later variant overrides an earlier one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Origin {
    Default,
    File { path: PathBuf, line: usize },
    Flag(&'static str),
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Origin::Default => write!(f, "default"),
            Origin::File { path, line } => write!(f, "{}, line {line}", path.display()),
            Origin::Flag(flag) => write!(f, "{flag}"),
        }
    }
}

impl Origin {
    /// Quotes what the user wrote, in a form that fits into a sentence.
    pub(super) fn quote(&self, key: usize, value: &toml::Value) -> String {
        match self {
            Origin::Flag(_) => value
                .as_str()
                .map_or_else(|| value.to_string(), str::to_owned),
            _ => format!("{} = {value}", KEYS[key].name),
        }
    }
}

/// Error messages, one per line, in the order of the file's lines.
#[derive(Debug, Default)]
pub struct Problems(Vec<(Origin, String)>);

impl Problems {
    pub(super) fn add(&mut self, origin: &Origin, what: impl fmt::Display) {
        let sentence = match origin {
            Origin::Default => what.to_string(),
            _ => format!("{origin}: {what}"),
        };
        let place = self.0.partition_point(|(earlier, _)| earlier <= origin);
        self.0.insert(place, (origin.clone(), sentence));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn into_result(self) -> Result<(), Self> {
        if self.is_empty() { Ok(()) } else { Err(self) }
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sentences: Vec<_> = self.0.iter().map(|(_, text)| &text[..]).collect();
        f.write_str(&sentences.join("\n"))
    }
}

impl std::error::Error for Problems {}
