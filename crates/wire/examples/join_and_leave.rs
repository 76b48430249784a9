//! A reader that joins a rig, looks for a message, and leaves: what `tests/kills/kills.py` kills in between.

use std::time::{Duration, Instant};

use lariat_wire::{Reader, WireError};

fn main() -> Result<(), WireError> {
    let mut reader = Reader::open("default")?;
    reader.wait(Instant::now() + Duration::from_millis(2))?;
    Ok(())
}
