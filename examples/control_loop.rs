//! A control loop: steers the middle of the rope to the middle of the image.
//!
//! ```sh
//! lariat run --filter &
//! cargo run --release --example control_loop
//! ```
//!
//! Instead of a robot, this example prints. Flags: `--rig NAME`, and `--frames N` to end after N
//! frames.

use std::io::Write;
use std::time::{Duration, Instant};

use lariat_wire::{Reader, Rope, Seen, now_ns};

/// Maximum age of the newest image; the robot stops if it is older.
const MAX_AGE: Duration = Duration::from_millis(100);

#[allow(dead_code, reason = "a test runs `follow` alone")]
fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |flag| arguments.windows(2).find(|pair| pair[0] == flag);
    let rig = value("--rig").map_or("default", |pair| &pair[1]);
    let frames = value("--frames").map_or(Ok(u64::MAX), |pair| pair[1].parse())?;
    follow(Reader::open(rig)?, frames, &mut std::io::stdout())
}

/// Runs the control loop for this many frames, and writes the robot's commands to `robot`.
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
            // The bridged part may be wrong, so move slowly, and only if most of the rope is
            // visible.
            Seen::Partial(rope) if rope.hidden() < 0.3 => steer(&rope, 0.2, robot)?,
            // A curve that misses the rope, a rope that may be false, or no rope at all: `seen`
            // says which.
            seen => writeln!(robot, "hold: {seen}")?,
        }
    }
    Ok(())
}

/// Proportional control: the velocity (px/s) that moves the rope's middle to the goal, with the
/// given `gain`.
fn steer(rope: &Rope, gain: f64, robot: &mut impl Write) -> anyhow::Result<()> {
    const GOAL: [f64; 2] = [320.0, 240.0];
    // Uses the position of the rope when the robot moves, not when the image was taken.
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
