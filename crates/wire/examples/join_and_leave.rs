//! A reader that joins a rig, checks for a message, and leaves. `tests/kills/kills.py` kills it in
//! between.

use std::time::{Duration, Instant};

use lariat_wire::{Reader, WireError};

fn main() -> Result<(), WireError> {
    let mut reader = Reader::open("default")?;
    reader.wait(Instant::now() + Duration::from_millis(2))?;
    Ok(())
}
