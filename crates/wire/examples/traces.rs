//! A reader that says when each frame that it sees was made and by whom: what `tests/soak` measures by.
//!
//! A line for each: its number, exposed, fitted and in hand (ns of the monotonic clock), which settings made it, how often
//! capture, extract and fit had been restarted, and its ropes that are seen now.

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
