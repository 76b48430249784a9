//! `lariat topic hz`: the rate of messages, its regularity, and losses.
//!
//! All figures come from the senders' stamps and counters, not from the time of reading. A reader
//! that is late or misses some messages finds the same rate.

use std::time::Duration;

use anyhow::Result;
use lariat_sink::{Arrival, Figure, Ledger, Lost};
use lariat_wire::{Descriptors, FitQuality, Rig, Status, Trace};
use serde::Serialize;

use super::ChannelName;
use super::Titled;
use super::probe::Any;
use super::watch::Meter;
use crate::versioned::Versioned;

/// Counter and stamp that the channel's writer gives its messages.
fn count_and_stamp(channel: ChannelName, trace: &Trace) -> (u64, u64) {
    match channel {
        // A mask and a depth image carry the counter and stamp of their frame.
        ChannelName::Frames
        | ChannelName::Masks
        | ChannelName::Depth
        | ChannelName::Truth
        | ChannelName::Truth3 => (trace.captured, trace.captured_ns),
        ChannelName::Centerlines => (trace.extracted, trace.extracted_ns),
        ChannelName::Descriptors | ChannelName::Descriptors3 => (trace.fitted, trace.fitted_ns),
    }
}

/// Advance of a writer's counter and clock from one message read to the next.
#[derive(Debug, Default)]
pub(super) struct Pace(Option<(u64, u64)>);

impl Pace {
    /// Number of messages sent since the last one, including this one, and the nanoseconds between
    /// the two. `None` for the first message, and after a restart of the stage.
    pub(super) fn step(&mut self, channel: ChannelName, trace: &Trace) -> Option<(u64, u64)> {
        let (count, stamp_ns) = count_and_stamp(channel, trace);
        let (count_before, before_ns) = self.0.replace((count, stamp_ns))?;
        if count <= count_before || stamp_ns <= before_ns {
            return None;
        }
        // There may be frames without a mask, and masks are not counted.
        let sent = match channel {
            ChannelName::Masks | ChannelName::Depth => 1,
            _ => count - count_before,
        };
        Some((sent, stamp_ns - before_ns))
    }
}

/// Returns a trace that ends with this channel. A ledger then counts what was sent but not read
/// here as lost after the last stage.
fn ended_here(channel: ChannelName, trace: &Trace, received: u64) -> Trace {
    if matches!(channel, ChannelName::Masks | ChannelName::Depth) {
        // A mask that was not made cannot be distinguished from a mask that was not read.
        let count = received + 1;
        return Trace {
            sequence: count,
            captured: count,
            extracted: count,
            fitted: count,
            fitted_ns: trace.captured_ns,
            ..*trace
        };
    }
    let (count, stamp_ns) = count_and_stamp(channel, trace);
    let extracted = match channel {
        ChannelName::Centerlines | ChannelName::Descriptors | ChannelName::Descriptors3 => {
            trace.extracted
        }
        _ => count,
    };
    Trace {
        extracted,
        fitted: count,
        fitted_ns: stamp_ns,
        ..*trace
    }
}

/// Figures since the last report.
pub(super) struct Rate {
    channel: ChannelName,
    ledger: Ledger,
    /// Frames lost before the last report.
    lost_before: Lost,
    pace: Pace,
    table: Titled,
    interval: Intervals,
}

#[derive(Default)]
struct Intervals {
    messages: u64,
    /// Advance of the writer's counter and of its clock.
    sent: u64,
    span_ns: u64,
    /// Intervals between consecutive messages that were both read: number, sum and sum of squares
    /// (s).
    count: u64,
    sum_s: f64,
    squares_s2: f64,
    shortest_ns: Option<u64>,
    longest_ns: Option<u64>,
    unsure: Unsure,
}

/// Number of ropes in descriptors that a control loop should not use.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct Unsure {
    /// Ropes with a curve that does not fit their points.
    coarse: u64,
    /// Ropes that may be false.
    doubtful: u64,
}

impl Unsure {
    fn add(&mut self, shapes: &Descriptors) {
        for rope in shapes.curves() {
            self.coarse += u64::from(rope.fit() == Some(FitQuality::Coarse));
            self.doubtful += u64::from(rope.status() == Some(Status::Doubtful));
        }
    }

    /// Formats a line; empty if all ropes are good.
    fn line(self) -> String {
        match self {
            Self {
                coarse: 0,
                doubtful: 0,
            } => String::new(),
            Self { coarse, doubtful } => {
                format!(
                    "           ropes in these: {coarse} with a coarse curve, {doubtful} doubtful\n"
                )
            }
        }
    }
}

impl Rate {
    pub(super) fn new(channel: ChannelName) -> Self {
        Self {
            channel,
            ledger: Ledger::new(false),
            lost_before: Lost::default(),
            pace: Pace::default(),
            table: Titled::new([
                "messages\n/s",
                "mean\nms",
                "min\nms",
                "max\nms",
                "jitter\nms",
                "lost:\nsource",
                "\ncapture",
                "\nextract",
                "\nbridge",
                "\nhere",
            ]),
            interval: Intervals::default(),
        }
    }

    fn figures<'a>(&self, rig: &'a Rig) -> Figures<'a> {
        let seen = &self.interval;
        let lost = self.ledger.lost();
        let before = self.lost_before;
        let mean_s = (seen.count > 0).then(|| seen.sum_s / seen.count as f64);
        let variance = mean_s.map(|mean| seen.squares_s2 / seen.count as f64 - mean * mean);
        let ms = |ns: u64| ns as f64 / 1e6;
        Figures {
            rig: rig.as_str(),
            channel: self.channel.as_str(),
            messages: seen.messages,
            hz: (seen.span_ns > 0).then(|| seen.sent as f64 * 1e9 / seen.span_ns as f64),
            interval_ms: Spread {
                mean: mean_s.map(|mean| mean * 1e3),
                min: seen.shortest_ns.map(ms),
                max: seen.longest_ns.map(ms),
                jitter: variance.map(|variance| variance.max(0.0).sqrt() * 1e3),
            },
            lost: LostHere {
                source: lost.source - before.source,
                capture: lost.capture - before.capture,
                extract: lost.extract - before.extract,
                bridge: lost.bridge - before.bridge,
                here: lost.fit - before.fit,
            },
            ropes: (self.channel == ChannelName::Descriptors).then_some(seen.unsure),
        }
    }
}

#[derive(Serialize)]
struct Figures<'a> {
    rig: &'a str,
    channel: &'static str,
    /// Number of messages read here.
    messages: u64,
    /// Messages sent per second.
    hz: Option<f64>,
    interval_ms: Spread,
    lost: LostHere,
    #[serde(skip_serializing_if = "Option::is_none")]
    ropes: Option<Unsure>,
}

/// Statistics of the intervals between messages.
#[derive(Serialize)]
struct Spread {
    mean: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
    /// Standard deviation of the intervals.
    jitter: Option<f64>,
}

/// Frames lost: at the source, after capture, after extract, on the way from another machine, and
/// between the channel and this reader.
#[derive(Serialize)]
struct LostHere {
    source: u64,
    capture: u64,
    extract: u64,
    bridge: u64,
    here: u64,
}

impl Meter for Rate {
    fn is_woken(&self) -> bool {
        false
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_secs(1))
    }

    fn see(&mut self, message: Any, now_ns: u64) -> Result<String> {
        let trace = message.trace();
        let counted = ended_here(self.channel, trace, self.ledger.received_count());
        if self.ledger.received(&counted, now_ns) == Arrival::Stale {
            return Ok(String::new());
        }
        let step = self.pace.step(self.channel, trace);
        let seen = &mut self.interval;
        seen.messages += 1;
        if let Any::Descriptors(shapes) = message {
            seen.unsure.add(shapes);
        }
        if let Some((sent, ns)) = step {
            seen.sent += sent;
            seen.span_ns += ns;
            // A message that was not read leaves no interval.
            if sent == 1 {
                let s = ns as f64 / 1e9;
                seen.count += 1;
                seen.sum_s += s;
                seen.squares_s2 += s * s;
                seen.shortest_ns = Some(seen.shortest_ns.map_or(ns, |least| least.min(ns)));
                seen.longest_ns = Some(seen.longest_ns.map_or(ns, |most| most.max(ns)));
            }
        }
        Ok(String::new())
    }

    fn report(&mut self, rig: &Rig, json: bool) -> Result<String> {
        let figures = self.figures(rig);
        let text = if json {
            serde_json::to_string(&Versioned::first(figures))? + "\n"
        } else {
            let Spread {
                mean,
                min,
                max,
                jitter,
            } = figures.interval_ms;
            let LostHere {
                source,
                capture,
                extract,
                bridge,
                here,
            } = figures.lost;
            let hz = Some(figures.hz.unwrap_or(0.0));
            let spread = [hz, mean, min, max, jitter].map(|figure| Figure(figure).to_string());
            let lost = [source, capture, extract, bridge, here].map(|count| count.to_string());
            self.table.lines(spread.into_iter().chain(lost)) + &self.interval.unsure.line()
        };
        self.lost_before = self.ledger.lost();
        self.interval = Intervals::default();
        Ok(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_wire::Centerlines;

    /// Time at which all of these messages have come.
    const LATER_NS: u64 = 1_000_000_000;

    fn shape(
        sequence: u64,
        captured: u64,
        extracted: u64,
        fitted: u64,
        ms: u64,
    ) -> Box<Descriptors> {
        let mut message = Box::new(Descriptors::EMPTY);
        message.trace = Trace {
            sequence,
            captured,
            extracted,
            fitted,
            fitted_ns: ms * 1_000_000,
            ..Trace::EMPTY
        };
        message
    }

    fn figures(rate: &Rate) -> serde_json::Value {
        serde_json::to_value(rate.figures(&Rig::default())).expect("JSON")
    }

    #[test]
    fn the_rate_is_the_writers_however_many_of_its_messages_are_read() {
        let mut rate = Rate::new(ChannelName::Descriptors);
        // Messages come every 10 ms; one is not read here, and one came 2 ms late.
        for (fitted, ms) in [(5, 100), (6, 110), (8, 130), (9, 142), (10, 150)] {
            let message = shape(fitted, fitted, fitted, fitted, ms);
            rate.see(Any::Descriptors(&message), LATER_NS)
                .expect("seen");
        }
        let found = figures(&rate);
        assert_eq!(
            (&found["messages"], &found["hz"]),
            (&5.into(), &100.0.into())
        );
        assert_eq!(found["lost"]["here"], 1);
        let interval = &found["interval_ms"];
        assert_eq!(
            (&interval["min"], &interval["max"]),
            (&8.0.into(), &12.0.into())
        );
        // Intervals of 10, 12 and 8 ms; the gap does not count as one.
        let jitter = interval["jitter"].as_f64().expect("a figure");
        assert!((jitter - (8.0_f64 / 3.0).sqrt()).abs() < 1e-6, "{jitter}");
    }

    #[test]
    fn what_was_lost_is_told_by_the_link_and_each_time_only_since_the_last() {
        let mut rate = Rate::new(ChannelName::Descriptors);
        let mut messages = [shape(1, 1, 1, 1, 10), shape(10, 8, 5, 4, 40)];
        for (message, bridged) in messages.iter_mut().zip([7, 9]) {
            message.trace.bridged = bridged;
        }
        for message in messages {
            rate.see(Any::Descriptors(&message), LATER_NS)
                .expect("seen");
        }
        let lost = &figures(&rate)["lost"];
        let counts =
            ["source", "capture", "extract", "bridge", "here"].map(|link| lost[link].as_u64());
        assert_eq!(counts, [2, 3, 1, 1, 1].map(Some));
        rate.report(&Rig::default(), true).expect("JSON");
        assert_eq!(figures(&rate)["lost"]["source"], 0);
    }

    #[test]
    fn coarse_curves_and_doubtful_ropes_are_counted_until_the_report() {
        let mut rate = Rate::new(ChannelName::Descriptors);
        let mut message = shape(1, 1, 1, 1, 10);
        message.count = 2;
        message.curves[0].fit = FitQuality::Coarse as u32;
        message.curves[1].status = Status::Doubtful as u32;
        rate.see(Any::Descriptors(&message), LATER_NS)
            .expect("seen");
        message.trace = shape(2, 2, 2, 2, 20).trace;
        message.count = 1;
        rate.see(Any::Descriptors(&message), LATER_NS)
            .expect("seen");
        assert_eq!(figures(&rate)["ropes"]["doubtful"], 1);
        let text = rate.report(&Rig::default(), false).expect("text");
        assert!(
            text.ends_with("2 with a coarse curve, 1 doubtful\n"),
            "{text}"
        );
        let text = rate.report(&Rig::default(), false).expect("text");
        assert!(!text.contains("coarse"), "{text}");
    }

    #[test]
    fn a_channel_in_the_middle_is_counted_by_its_own_stage() {
        let mut rate = Rate::new(ChannelName::Centerlines);
        let mut message = Box::new(Centerlines::EMPTY);
        for (number, ms) in [(1, 10), (2, 20), (4, 40)] {
            message.trace = Trace {
                sequence: number + 1,
                captured: number + 1,
                extracted: number,
                extracted_ns: ms * 1_000_000,
                ..Trace::EMPTY
            };
            rate.see(Any::Centerlines(&message), LATER_NS)
                .expect("seen");
        }
        let found = figures(&rate);
        assert_eq!(
            (&found["messages"], &found["hz"]),
            (&3.into(), &100.0.into())
        );
        assert_eq!(
            (&found["lost"]["here"], &found["lost"]["capture"]),
            (&1.into(), &0.into())
        );
    }

    #[test]
    fn masks_are_counted_as_they_come_as_not_every_frame_has_one() {
        let mut rate = Rate::new(ChannelName::Masks);
        for frame in [3, 6, 9] {
            let header = lariat_wire::FrameHeader {
                trace: Trace {
                    sequence: frame,
                    captured: frame,
                    captured_ns: frame * 10_000_000,
                    ..Trace::EMPTY
                },
                ..lariat_wire::FrameHeader::default()
            };
            rate.see(Any::Image(&header, &[]), LATER_NS).expect("seen");
        }
        let found = figures(&rate);
        let hz = found["hz"].as_f64().expect("a figure");
        assert!((hz - 100.0 / 3.0).abs() < 1e-9, "{hz}");
        assert_eq!(
            (&found["messages"], &found["lost"]["here"]),
            (&3.into(), &0.into())
        );
    }
}
