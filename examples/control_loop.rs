//! A control loop: steers the middle of the rope to the middle of the image.
//!
//! ```sh
//! lariat run --filter &
//! cargo run --release --example control_loop
//! ```
//!
//! What stands for the robot here prints. Flags: `--rig NAME`, and `--frames N` to end after so many.

use std::io::Write;
use std::time::{Duration, Instant};

use lariat_wire::{Reader, Rope, Seen, now_ns};

/// The robot holds still when the newest image is older.
const MAX_AGE: Duration = Duration::from_millis(100);

#[allow(dead_code, reason = "a test runs `follow` alone")]
fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |flag| arguments.windows(2).find(|pair| pair[0] == flag);
    let rig = value("--rig").map_or("default", |pair| &pair[1]);
    let frames = value("--frames").map_or(Ok(u64::MAX), |pair| pair[1].parse())?;
    follow(Reader::open(rig)?, frames, &mut std::io::stdout())
}

/// The loop, for so many frames. It sends what it would have the robot do to `robot`.
pub(crate) fn follow(
    mut reader: Reader,
    mut frames: u64,
    robot: &mut impl Write,
) -> anyhow::Result<()> {
    while frames > 0 {
        let frame = reader.wait(Instant::now() + Duration::from_millis(50))?;
        frames -= u64::from(frame.is_new());
        match frame.only_rope(MAX_AGE) {
            Seen::Fresh(rope) => steer(&rope, 1.0, robot)?,
            // What is bridged may be wrong: slowly, and only where the rope is seen for the most part.
            Seen::Partial(rope) if rope.hidden() < 0.3 => steer(&rope, 0.2, robot)?,
            // A curve that misses the rope, a rope that may be none, and all that is not seen now: it says which.
            seen => writeln!(robot, "hold: {seen}")?,
        }
    }
    Ok(())
}

/// A proportional law: the velocity (px/s) that takes the rope's middle to the goal, as fast as `gain` says.
fn steer(rope: &Rope, gain: f64, robot: &mut impl Write) -> anyhow::Result<()> {
    const GOAL: [f64; 2] = [320.0, 240.0];
    // Where the rope is when the robot moves, not where it was when the image was taken.
    let ahead = rope.predict(now_ns()).ok();
    let shape = match &ahead {
        Some(ahead) => ahead.shape(),
        None => rope.shape()?,
    };
    let [x, y] = shape.point_at(0.5);
    let [xx, _, yy] = shape.covariance_at(0.5);
    let velocity = [gain * (GOAL[0] - x), gain * (GOAL[1] - y)];
    writeln!(
        robot,
        "move {velocity:.1?} px/s: rope {} is at {x:.1}, {y:.1} ± {:.2} px, {} µs old",
        rope.track(),
        (xx + yy).sqrt(),
        rope.age().as_micros(),
    )?;
    Ok(())
}
