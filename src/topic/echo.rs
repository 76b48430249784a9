//! `lariat topic echo`: prints the messages of a channel as text, or as JSON with every field
//! except a frame's pixels.

mod json;
mod text;

use std::io::IsTerminal;
use std::time::Duration;

use anyhow::Result;
use lariat_chain::layout;
use lariat_wire::Rig;

use super::ChannelName;
use super::probe::Any;
use super::watch::Meter;

/// Prints messages.
pub(super) struct Echo {
    channel: ChannelName,
    json: bool,
    /// Number of messages still to print; `None` for no limit.
    left: Option<u64>,
    /// True if low confidence is printed in yellow.
    has_colours: bool,
}

impl Echo {
    pub(super) fn new(channel: ChannelName, json: bool, most: Option<u64>) -> Self {
        Self {
            channel,
            json,
            left: most,
            has_colours: layout::has_colours(std::io::stdout().is_terminal()),
        }
    }
}

impl Meter for Echo {
    /// A line must appear together with its message, and an idle rig wakes nobody.
    fn is_woken(&self) -> bool {
        true
    }

    fn period(&self) -> Option<Duration> {
        None
    }

    fn see(&mut self, message: Any, _now_ns: u64) -> Result<String> {
        if let Some(left) = &mut self.left {
            *left = left.saturating_sub(1);
        }
        if self.json {
            json::line(self.channel.as_str(), message)
        } else {
            let channel = self.channel.as_str();
            Ok(text::paragraph(channel, message, self.has_colours))
        }
    }

    fn is_done(&self) -> bool {
        self.left == Some(0)
    }

    fn report(&mut self, _rig: &Rig, _json: bool) -> Result<String> {
        Ok(String::new())
    }
}

#[cfg(test)]
mod tests;
