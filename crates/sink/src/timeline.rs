//! The timeline of the last frames as a trace in Chrome's event format, for Perfetto
//! (ui.perfetto.dev) and `chrome://tracing`. It has a row for each stage, and arrows from stage to
//! stage for each frame.

use std::io::{self, Write};

use crate::passage::Passage;
use crate::saved::{RestoreError, Saved, Saving, sound};

/// Number of frames kept.
const KEPT: usize = 1000;

/// The rows, in the order of the data.
const STAGES: [&str; 4] = ["capture", "extract", "fit", "sink"];

/// The last 1,000 frames. Adding another frame allocates nothing.
#[derive(Debug, Clone)]
pub(crate) struct Timeline {
    passages: Vec<Passage>,
    /// Index of the oldest frame, once all places are taken.
    oldest: usize,
}

impl Timeline {
    pub(crate) fn new() -> Self {
        Self {
            passages: Vec::with_capacity(KEPT),
            oldest: 0,
        }
    }

    pub(crate) fn add(&mut self, passage: Passage) {
        if self.passages.len() < KEPT {
            self.passages.push(passage);
        } else {
            self.passages[self.oldest] = passage;
            self.oldest = (self.oldest + 1) % KEPT;
        }
    }

    /// Returns the frames, oldest first.
    fn passages(&self) -> impl Iterator<Item = &Passage> + Clone {
        let (newer, older) = self.passages.split_at(self.oldest);
        older.iter().chain(newer)
    }

    pub(crate) fn save(&self, to: &mut Saving) {
        to.number(self.passages.len() as u64);
        self.passages().for_each(|passage| passage.save(to));
    }

    pub(crate) fn restore(from: &mut Saved) -> Result<Self, RestoreError> {
        let mut timeline = Self::new();
        let count = sound(from.number()?, |&count| count <= KEPT as u64)?;
        for _ in 0..count {
            timeline.add(Passage::restore(from)?);
        }
        Ok(timeline)
    }

    /// Writes the events as JSON. Times are in microseconds since the oldest frame's exposure.
    pub(crate) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let passages = self.passages();
        let start_ns = passages.clone().map(Passage::begin_ns).min().unwrap_or(0);
        write!(out, "{{\"displayTimeUnit\":\"ns\",\"traceEvents\":[")?;
        for (row, stage) in STAGES.iter().enumerate() {
            let comma = if row > 0 { "," } else { "" };
            write!(
                out,
                "{comma}\n{{\"ph\":\"M\",\"name\":\"thread_name\",\"pid\":1,\"tid\":{row},\
                 \"args\":{{\"name\":\"{stage}\"}}}}"
            )?;
        }
        // Slices of a row must not overlap: a frame that was due before the previous one was done
        // begins after it.
        let mut done_ns = [0; STAGES.len()];
        for passage in passages {
            passage.write(start_ns, &mut done_ns, out)?;
        }
        writeln!(out, "\n]}}")
    }
}

impl Passage {
    /// Returns when each stage began and ended its work on the frame. Unknown stamps yield no
    /// slice.
    fn slices(&self) -> [Option<(u64, u64)>; STAGES.len()] {
        let trace = &self.trace;
        let known = |from: u64, to: u64| (from != 0 && to >= from).then_some((from, to));
        [
            known(trace.exposed_ns, trace.captured_ns),
            known(trace.extract_started_ns, trace.extracted_ns),
            known(trace.fit_started_ns, trace.fitted_ns),
            known(self.received_ns, self.received_ns),
        ]
    }

    fn begin_ns(&self) -> u64 {
        let begins = self.slices().into_iter().flatten().map(|(from, _)| from);
        begins.min().unwrap_or(self.received_ns)
    }

    fn write(
        &self,
        start_ns: u64,
        done_ns: &mut [u64; STAGES.len()],
        out: &mut impl Write,
    ) -> io::Result<()> {
        let sequence = self.trace.sequence;
        let us = |ns: u64| ns.saturating_sub(start_ns) as f64 / 1e3;
        for (row, slice) in self.slices().into_iter().enumerate() {
            let Some((from, to)) = slice else { continue };
            let to = to.max(done_ns[row]);
            let from = from.max(done_ns[row]);
            done_ns[row] = to;
            let at = format_args!("\"pid\":1,\"tid\":{row},\"ts\":{:.3}", us(from));
            write!(
                out,
                ",\n{{\"ph\":\"X\",\"name\":\"{} {sequence}\",{at},\"dur\":{:.3}}}",
                STAGES[row],
                us(to) - us(from),
            )?;
            // The arrow starts in the first row and is bound to the slices of the others.
            let (phase, bound) = match row {
                0 => ("s", ""),
                _ if row + 1 == STAGES.len() => ("f", ",\"bp\":\"e\""),
                _ => ("t", ",\"bp\":\"e\""),
            };
            write!(
                out,
                ",\n{{\"ph\":\"{phase}\",\"name\":\"frame\",\"cat\":\"frame\",\"id\":{sequence},{at}{bound}}}"
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_message::Trace;
    use serde_json::Value;

    fn frame(sequence: u64) -> Trace {
        let at = |us: u64| 1_000_000 + 100_000 * sequence + 1_000 * us;
        Trace {
            sequence,
            exposed_ns: at(0),
            captured_ns: at(10),
            extract_started_ns: at(20),
            extracted_ns: at(50),
            fit_started_ns: at(55),
            fitted_ns: at(60),
            ..Trace::default()
        }
    }

    /// Returns a passage received `after_ns` nanoseconds after it was fitted.
    fn passed(trace: Trace, after_ns: u64) -> Passage {
        let received_ns = trace.fitted_ns + after_ns;
        Passage { trace, received_ns }
    }

    fn events(timeline: &Timeline) -> Vec<Value> {
        let mut bytes = Vec::new();
        timeline.write(&mut bytes).unwrap();
        let json: Value = serde_json::from_slice(&bytes).unwrap();
        json["traceEvents"].as_array().unwrap().clone()
    }

    fn slices(events: &[Value], row: u64) -> Vec<&Value> {
        let of_row = |event: &&Value| event["ph"] == "X" && event["tid"] == row;
        events.iter().filter(of_row).collect()
    }

    #[test]
    fn each_stage_has_a_slice_of_its_work_in_its_row() {
        let mut timeline = Timeline::new();
        timeline.add(passed(frame(1), 7_000));
        let events = events(&timeline);
        let expected = [
            ("capture 1", 0.0, 10.0),
            ("extract 1", 20.0, 30.0),
            ("fit 1", 55.0, 5.0),
            ("sink 1", 67.0, 0.0),
        ];
        for (row, (name, ts, dur)) in (0..).zip(expected) {
            let slices = slices(&events, row);
            assert_eq!(slices.len(), 1);
            assert_eq!(slices[0]["name"], name);
            assert_eq!(
                (&slices[0]["ts"], &slices[0]["dur"]),
                (&ts.into(), &dur.into())
            );
        }
        let arrows: Vec<_> = events
            .iter()
            .filter(|event| event["cat"] == "frame")
            .collect();
        let phases: Vec<_> = arrows
            .iter()
            .map(|arrow| arrow["ph"].as_str().unwrap())
            .collect();
        assert_eq!(phases, ["s", "t", "t", "f"]);
    }

    #[test]
    fn only_the_last_thousand_frames_are_kept_in_their_order() {
        let mut timeline = Timeline::new();
        for sequence in 1..=2500 {
            timeline.add(passed(frame(sequence), 1));
        }
        let events = events(&timeline);
        let extract = slices(&events, 1);
        assert_eq!(extract.len(), KEPT);
        assert_eq!(extract[0]["name"], "extract 1501");
        assert_eq!(extract[KEPT - 1]["name"], "extract 2500");
    }

    #[test]
    fn slices_of_one_row_never_overlap() {
        let mut timeline = Timeline::new();
        // The second frame was due while the first was still being captured.
        let mut second = frame(2);
        second.exposed_ns = frame(1).captured_ns - 5_000;
        timeline.add(passed(frame(1), 1));
        timeline.add(passed(second, 1));
        let events = events(&timeline);
        let capture = slices(&events, 0);
        let end = capture[0]["ts"].as_f64().unwrap() + capture[0]["dur"].as_f64().unwrap();
        assert!(capture[1]["ts"].as_f64().unwrap() >= end);
    }

    #[test]
    fn a_stage_whose_stamps_are_not_known_has_no_slice() {
        let mut timeline = Timeline::new();
        let trace = Trace {
            exposed_ns: 0,
            ..frame(1)
        };
        timeline.add(passed(trace, 0));
        let events = events(&timeline);
        assert!(slices(&events, 0).is_empty());
        assert_eq!(slices(&events, 2).len(), 1);
    }

    #[test]
    fn a_run_without_a_frame_is_an_empty_trace() {
        assert_eq!(events(&Timeline::new()).len(), STAGES.len());
    }
}
