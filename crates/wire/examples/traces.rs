//! A reader that prints the times and settings of each frame it receives. `tests/soak` uses it for
//! its measurements.
//!
//! Prints one line per frame: number; times of exposure, fit and receipt (ns of the monotonic
//! clock); settings version; restarts of capture, extract and fit; and the ropes visible now.

use std::io::Write;
use std::time::{Duration, Instant};

use lariat_wire::{Reader, now_ns};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut reader = Reader::open("default")?;
    let mut out = std::io::stdout().lock();
    loop {
        let frame = reader.wait(Instant::now() + Duration::from_millis(50))?;
        let in_hand = now_ns();
        let Some(message) = frame.message().filter(|_| frame.is_new()) else {
            continue;
        };
        let trace = &message.trace;
        let [capture, extract, fit] = trace.restarts();
        let seen = message.curves().iter().filter(|rope| rope.age_ns == 0);
        writeln!(
            out,
            "{} {} {} {in_hand} {} {capture} {extract} {fit} {}",
            trace.fitted,
            trace.exposed_ns,
            trace.fitted_ns,
            trace.settings,
            seen.count()
        )?;
    }
}
