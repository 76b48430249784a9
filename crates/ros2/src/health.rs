//! State of the chain for diagnostics: whether messages arrive, their age, losses, latencies.

use lariat_sink::{Arrival, Ledger, Step, Times};
use lariat_wire::{Descriptors, FitQuality, Status as Seen, Unit};

use crate::messages::{Level, Shapes, Status};

/// Age of an image at which the chain counts as stalled.
const STALE_NS: u64 = 1_000_000_000;
/// Number of reports that share one set of latencies.
const REPORTS: u32 = 10;

/// State of the rig since this process began to read it.
pub(crate) struct Health {
    ledger: Ledger,
    lost_before: u64,
    latencies: [Times; Step::ALL.len()],
    reports: u32,
    newest: Option<Newest>,
}

/// Facts about the newest message.
#[derive(Debug, Clone, Copy)]
struct Newest {
    exposed_ns: u64,
    unit: Option<Unit>,
    ropes: usize,
    lost: usize,
    doubtful: usize,
    coarse: usize,
    /// Visible, but without a known position in space.
    unplaced: usize,
}

impl Health {
    pub(crate) fn new() -> Self {
        Self {
            ledger: Ledger::new(false),
            lost_before: 0,
            latencies: Default::default(),
            reports: 0,
            newest: None,
        }
    }

    /// Processes a message, with the positions of its ropes if known, received at `now_ns` of
    /// `CLOCK_MONOTONIC`.
    pub(crate) fn take(&mut self, message: &Descriptors, shapes: Option<Shapes>, now_ns: u64) {
        if self.ledger.received(&message.trace, now_ns) == Arrival::Stale {
            return;
        }
        if message.width > 0 {
            for (step, times) in Step::ALL.into_iter().zip(&mut self.latencies) {
                if let Some(ns) = step.ns(&message.trace, now_ns) {
                    times.add(ns);
                }
            }
        }
        let ropes = message.curves();
        let count = |status| ropes.iter().filter(|r| r.status() == Some(status)).count();
        // More likely wrong than right, whatever the status.
        let is_unsure = |rope: &&lariat_wire::Descriptor| {
            let is_seen = matches!(rope.status(), Some(Seen::Ok | Seen::Partial));
            is_seen && rope.confidence < lariat_wire::MIN_CONFIDENCE
        };
        let coarse = |rope: &&_| lariat_wire::Descriptor::fit(rope) == Some(FitQuality::Coarse);
        self.newest = Some(Newest {
            exposed_ns: message.trace.exposed_ns,
            unit: message.unit(),
            ropes: ropes.len(),
            lost: count(Seen::Lost),
            doubtful: count(Seen::Doubtful) + ropes.iter().filter(is_unsure).count(),
            coarse: ropes.iter().filter(coarse).count(),
            unplaced: shapes.map_or(ropes.len(), Shapes::unplaced),
        });
    }

    /// Returns the current diagnostics. `unsent` is the number of messages that were not sent.
    pub(crate) fn status(&mut self, rig: &str, unsent: u64, now_ns: u64) -> Status {
        let lost = self.ledger.lost();
        let lost_now = lost.source + lost.capture + lost.extract + lost.bridge + lost.fit;
        let lost_new = lost_now - std::mem::replace(&mut self.lost_before, lost_now).min(lost_now);
        let age_ns = self
            .newest
            .map(|newest| now_ns.saturating_sub(newest.exposed_ns));
        let (level, message) = self.verdict(age_ns, lost_new);
        let mut values = Vec::new();
        if let (Some(newest), Some(age_ns)) = (self.newest, age_ns) {
            values.push(("age, ms".to_owned(), format!("{:.1}", age_ns as f64 / 1e6)));
            values.push((
                "unit".to_owned(),
                newest.unit.map_or("?", Unit::name).to_owned(),
            ));
            values.push(("ropes".to_owned(), newest.ropes.to_string()));
            values.push(("ropes lost".to_owned(), newest.lost.to_string()));
            values.push(("ropes doubtful".to_owned(), newest.doubtful.to_string()));
            values.push(("curves coarse".to_owned(), newest.coarse.to_string()));
        }
        values.push((
            "frames received".to_owned(),
            self.ledger.received_count().to_string(),
        ));
        values.push(("lost at the source".to_owned(), lost.source.to_string()));
        values.push(("lost after capture".to_owned(), lost.capture.to_string()));
        values.push(("lost after extract".to_owned(), lost.extract.to_string()));
        values.push(("lost over the bridge".to_owned(), lost.bridge.to_string()));
        values.push(("lost after fit".to_owned(), lost.fit.to_string()));
        values.push(("messages not sent".to_owned(), unsent.to_string()));
        self.add_latencies(&mut values);
        self.reports += 1;
        if self.reports.is_multiple_of(REPORTS) {
            self.latencies = Default::default();
        }
        Status {
            level,
            name: format!("lariat: {rig}"),
            message,
            hardware_id: rig.to_owned(),
            values,
        }
    }

    fn verdict(&self, age_ns: Option<u64>, lost_new: u64) -> (Level, String) {
        match (self.newest, age_ns) {
            (Some(newest), Some(age_ns)) if age_ns < STALE_NS => {
                let doubts = [
                    (newest.lost as u64, "lost"),
                    (newest.doubtful as u64, "doubtful"),
                    (newest.coarse as u64, "with a coarse curve"),
                    (newest.unplaced as u64, "not known where in space"),
                    (lost_new, "frames lost since the last report"),
                ];
                let said: Vec<String> = doubts
                    .iter()
                    .filter(|(count, _)| *count > 0)
                    .map(|(count, what)| format!("{count} {what}"))
                    .collect();
                match (newest.ropes, said.is_empty()) {
                    (0, true) => (Level::Warn, "no rope is seen".to_owned()),
                    (ropes, true) => (Level::Ok, format!("ropes: {ropes}")),
                    (ropes, false) => (Level::Warn, format!("ropes: {ropes}; {}", said.join(", "))),
                }
            }
            (Some(_), Some(age_ns)) => {
                let s = age_ns as f64 / 1e9;
                (Level::Stale, format!("the newest image is {s:.1} s old"))
            }
            _ => (Level::Stale, "nothing has come from the chain".to_owned()),
        }
    }

    fn add_latencies(&self, values: &mut Vec<(String, String)>) {
        let [received, _, steps @ ..] = &self.latencies;
        for (key, quantile) in [
            ("exposed to received here, p50, ms", 0.5),
            ("exposed to received here, p99, ms", 0.99),
        ] {
            if let Some(us) = received.quantile_us(quantile) {
                values.push((key.to_owned(), format!("{:.3}", us / 1e3)));
            }
        }
        let medians = Step::ALL[2..].iter().zip(steps);
        let medians = medians.filter_map(|(step, times)| Some((step, times.quantile_us(0.5)?)));
        if let Some((step, us)) = medians.max_by(|a, b| a.1.total_cmp(&b.1)) {
            let text = format!("{}, p50 {:.3} ms", step.label(), us / 1e3);
            values.push(("what takes longest".to_owned(), text));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_wire::{Descriptors3, Place, Trace};

    fn message(exposed_ns: u64, captured: u64) -> Box<Descriptors> {
        let mut message = Box::new(Descriptors::EMPTY);
        message.trace = Trace {
            sequence: captured,
            captured,
            extracted: captured,
            fitted: captured,
            exposed_ns,
            captured_ns: exposed_ns + 1000,
            fitted_ns: exposed_ns + 5000,
            ..Trace::EMPTY
        };
        (message.width, message.height, message.count) = (640, 480, 1);
        message.curves[0].status = Seen::Ok as u32;
        message
    }

    /// A message of a rig without a depth camera.
    fn take(health: &mut Health, message: &Descriptors, now_ns: u64) {
        health.take(message, Some(Shapes::Flat(message)), now_ns);
    }

    #[test]
    fn a_rope_of_which_it_is_not_known_where_in_space_it_is_is_told() {
        let mut health = Health::new();
        let mut space = Box::new(Descriptors3::EMPTY);
        space.count = 1;
        space.curves[0].status = Seen::Ok as u32;
        for (count, place, level) in [
            (1, Some(Place::Unmeasured), Level::Warn),
            (2, Some(Place::Known), Level::Ok),
            (3, None, Level::Warn),
        ] {
            space.curves[0].place = place.map_or(0, |place| place as u32);
            let shapes = place.map(|_| Shapes::InSpace(&space));
            health.take(
                &message(count * 1_000_000, count),
                shapes,
                count * 1_010_000,
            );
            assert_eq!(
                health.status("a", 0, count * 1_020_000).level,
                level,
                "{place:?}"
            );
        }
    }

    #[test]
    fn a_chain_that_stands_a_rope_that_is_lost_and_frames_that_are_missing_are_told() {
        let mut health = Health::new();
        assert_eq!(health.status("a", 0, 1).level, Level::Stale);
        take(&mut health, &message(1_000_000, 1), 1_010_000);
        let fine = health.status("a", 0, 2_000_000);
        assert_eq!((fine.level, &*fine.message), (Level::Ok, "ropes: 1"));

        take(&mut health, &message(3_000_000, 4), 3_010_000);
        let gap = health.status("a", 0, 4_000_000);
        assert_eq!(gap.level, Level::Warn);
        assert!(gap.message.contains("2 frames lost"), "{}", gap.message);
        assert_eq!(health.status("a", 0, 4_100_000).level, Level::Ok);

        let mut lost = message(5_000_000, 5);
        lost.curves[0].status = Seen::Lost as u32;
        take(&mut health, &lost, 5_010_000);
        assert_eq!(health.status("a", 0, 6_000_000).level, Level::Warn);
        assert_eq!(health.status("a", 0, 3_000_000_000).level, Level::Stale);
    }
}
