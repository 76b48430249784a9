//! Time from sending a message until a waiting reader has it, next to bare iceoryx2 with 64 bytes
//! and one event.

use std::time::{Duration, Instant};

use crate::RelayReceiver;
use crate::{Samples, Table};
use anyhow::{Result, ensure};
use lariat_wire::{Domain, now_ns};

use super::Place;

/// Messages per second: frequent enough for statistics, and far enough apart that the reader is
/// always asleep.
const RATE: &str = "200";
/// Messages that are not counted, while connections are made and caches fill.
const WARM_UP: usize = 20;
const PATIENCE: Duration = Duration::from_secs(20);

/// Returns the table, after measuring both in turn in each round.
pub(super) fn measure(place: &Place, time: Duration, rounds: usize) -> Result<Table> {
    let mut ours = Vec::new();
    let mut raw = Vec::new();
    for _ in 0..rounds.max(1) {
        raw.push(relay(place, time)?);
        ours.push(reader(place, time)?);
    }
    let mut table = Table::new(&["asleep → in hand, µs", "p50", "p90", "p99", "messages"]);
    let median = |rounds: &[Samples], share: f64| {
        let each: Samples = rounds.iter().map(|round| round.percentile(share)).collect();
        each.median()
    };
    let shares = [0.5, 0.9, 0.99];
    for (name, rounds) in [("bare iceoryx2, 64 bytes", &raw), ("Reader::wait", &ours)] {
        let figures = shares.map(|share| format!("{:.1}", median(rounds, share)));
        let count: usize = rounds.iter().map(Samples::count).sum();
        table.push(
            [name.to_string()]
                .into_iter()
                .chain(figures)
                .chain([count.to_string()]),
        );
    }
    // Ratios are taken within each round, because both times drift.
    let ratios = shares.map(|share| {
        let pairs = ours.iter().zip(&raw);
        let each: Samples = pairs
            .map(|(a, b)| a.percentile(share) / b.percentile(share))
            .collect();
        format!("{:.2}×", each.median())
    });
    table.push(["ratio".to_string()].into_iter().chain(ratios));
    Ok(table)
}

fn reader(place: &Place, time: Duration) -> Result<Samples> {
    let mut reader = place.reader()?;
    let writer = place.start(&["write", "--rate", RATE])?;
    let mut samples = Samples::default();
    let mut seen = 0;
    let mut end = None;
    while end.is_none_or(|end| Instant::now() < end) {
        let frame = reader.wait(Instant::now() + PATIENCE)?;
        let now_ns = now_ns();
        let (Some(message), true) = (frame.message(), frame.is_new()) else {
            anyhow::bail!("the writer's messages did not come");
        };
        seen += 1;
        if seen > WARM_UP {
            samples.push((now_ns - message.trace.fitted_ns) as f64 / 1e3);
            end.get_or_insert_with(|| Instant::now() + time);
        }
    }
    writer.end()?;
    Ok(samples)
}

fn relay(place: &Place, time: Duration) -> Result<Samples> {
    let domain = Domain::named(&place.domain)?;
    let receiver = RelayReceiver::create(&domain, 0)?;
    let sender = place.start(&["relay", "--rate", RATE])?;
    let mut samples = Samples::default();
    let mut seen = 0;
    let mut end = None;
    while end.is_none_or(|end| Instant::now() < end) {
        let message = receiver.next(PATIENCE)?;
        let now_ns = now_ns();
        // The wake came from a late notification, whose message was already taken.
        let Some([sent_ns, ..]) = message else {
            continue;
        };
        seen += 1;
        if seen > WARM_UP {
            samples.push((now_ns - sent_ns) as f64 / 1e3);
            end.get_or_insert_with(|| Instant::now() + time);
        }
    }
    ensure!(samples.count() > 0, "the sender's messages did not come");
    sender.end()?;
    Ok(samples)
}
