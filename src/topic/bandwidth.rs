//! `lariat topic bw`: megabytes per second on a channel.

use std::time::Duration;

use anyhow::Result;
use lariat_sink::Figure;
use lariat_wire::Rig;
use serde::Serialize;

use super::ChannelName;
use super::Titled;
use super::probe::Any;
use super::rate::Pace;
use super::watch::Meter;
use crate::versioned::Versioned;

/// Figures since the last report.
pub(super) struct Bandwidth {
    channel: ChannelName,
    pace: Pace,
    table: Titled,
    messages: u64,
    bytes: u64,
    least: Option<usize>,
    most: Option<usize>,
    /// Advance of the writer's counter and of its clock.
    sent: u64,
    span_ns: u64,
}

impl Bandwidth {
    pub(super) fn new(channel: ChannelName) -> Self {
        Self {
            channel,
            pace: Pace::default(),
            table: Titled::new(["MB/s", "messages/s", "mean kB", "min kB", "max kB"]),
            messages: 0,
            bytes: 0,
            least: None,
            most: None,
            sent: 0,
            span_ns: 0,
        }
    }
}

#[derive(Serialize)]
struct Figures<'a> {
    rig: &'a str,
    channel: &'static str,
    /// Number of messages read here.
    messages: u64,
    /// Data rate of the writer, in 10⁶ bytes per second.
    mb_per_s: Option<f64>,
    /// Messages sent per second.
    hz: Option<f64>,
    message_bytes: Size,
}

#[derive(Serialize)]
struct Size {
    mean: Option<f64>,
    min: Option<usize>,
    max: Option<usize>,
}

impl Meter for Bandwidth {
    fn is_woken(&self) -> bool {
        false
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_secs(1))
    }

    fn see(&mut self, message: Any, _now_ns: u64) -> Result<String> {
        let bytes = message.bytes();
        self.messages += 1;
        self.bytes += bytes as u64;
        self.least = Some(self.least.map_or(bytes, |least| least.min(bytes)));
        self.most = Some(self.most.map_or(bytes, |most| most.max(bytes)));
        if let Some((sent, ns)) = self.pace.step(self.channel, message.trace()) {
            self.sent += sent;
            self.span_ns += ns;
        }
        Ok(String::new())
    }

    fn report(&mut self, rig: &Rig, json: bool) -> Result<String> {
        let mean = (self.messages > 0).then(|| self.bytes as f64 / self.messages as f64);
        let hz = (self.span_ns > 0).then(|| self.sent as f64 * 1e9 / self.span_ns as f64);
        let mb_per_s = mean.zip(hz).map(|(mean, hz)| mean * hz / 1e6);
        let text = if json {
            let figures = Figures {
                rig: rig.as_str(),
                channel: self.channel.as_str(),
                messages: self.messages,
                mb_per_s,
                hz,
                message_bytes: Size {
                    mean,
                    min: self.least,
                    max: self.most,
                },
            };
            serde_json::to_string(&Versioned::first(figures))? + "\n"
        } else {
            let kb = |bytes: Option<usize>| bytes.map(|bytes| bytes as f64 / 1e3);
            let figures = [
                Some(mb_per_s.unwrap_or(0.0)),
                Some(hz.unwrap_or(0.0)),
                mean.map(|mean| mean / 1e3),
                kb(self.least),
                kb(self.most),
            ];
            self.table
                .lines(figures.map(|figure| Figure(figure).to_string()))
        };
        let table = std::mem::replace(&mut self.table, Titled::new([]));
        *self = Self {
            pace: std::mem::take(&mut self.pace),
            table,
            ..Self::new(self.channel)
        };
        Ok(text)
    }
}
