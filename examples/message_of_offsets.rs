//! Writes a message of descriptors in which every number says where it lies: for whoever writes a reader in another language.
//!
//! ```sh
//! cargo run --release --example message_of_offsets -- --rig layout &
//! ```
//!
//! An integer is its own offset in the message, in bytes; a floating-point number is its offset and a half. So `unit`, at
//! offset 92, is 92, and the first rope's `rms`, at offset 128, is 128.5. The table is in ARCHITECTURE.md, "The contract".
//! It is no rope, and a reader that checks what it reads says so: read the message itself. It is sent ten times a second until
//! standard input ends, and "sent" is printed after the first.

use std::io::Read;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use lariat_wire::{
    CenterlinePoints, DESCRIPTORS, Delivery, Descriptor, Descriptors, Domain, Rig, Trace, Writer,
};

#[allow(dead_code, reason = "a test has the message alone")]
fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let rig = arguments.windows(2).find(|pair| pair[0] == "--rig");
    let rig = rig.map_or(Ok(Rig::default()), |pair| pair[1].parse())?;
    let domain = Domain::open()?;
    let writer = Writer::<Descriptors>::create(&domain, &rig, &DESCRIPTORS, &Delivery::NewestWins)?;
    let (ended, end) = channel::<()>();
    std::thread::spawn(move || {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        drop(ended);
    });
    let message = message();
    let mut said = false;
    loop {
        let mut slot = writer.slot()?;
        *slot = *message;
        slot.send()?;
        if !said {
            println!("sent");
            said = true;
        }
        match end.recv_timeout(Duration::from_millis(100)) {
            Err(RecvTimeoutError::Timeout) => {}
            _ => return Ok(()),
        }
    }
}

/// The message, by the offsets that are documented, whatever the compiler makes of the types.
pub(crate) fn message() -> Box<Descriptors> {
    let mut message = Box::new(Descriptors::EMPTY);
    message.trace = Trace {
        sequence: 0,
        captured: 8,
        extracted: 16,
        fitted: 24,
        exposed_ns: 32,
        captured_ns: 40,
        extract_started_ns: 48,
        extracted_ns: 56,
        fit_started_ns: 64,
        fitted_ns: 72,
    };
    (message.width, message.height) = (80, 84);
    (message.count, message.unit) = (88, 92);
    for (i, rope) in message.curves.iter_mut().enumerate() {
        fill(rope, 96 + 2408 * i as u32);
    }
    for (i, points) in message.centerlines.iter_mut().enumerate() {
        fill_points(points, 96 + 8 * 2408 + 3112 * i as u32);
    }
    message
}

/// A rope that begins at this offset.
fn fill(rope: &mut Descriptor, at: u32) {
    let half = |offset: u32| f64::from(at + offset) + 0.5;
    for (offset, field) in [
        (0, &mut rope.track),
        (4, &mut rope.status),
        (8, &mut rope.basis),
        (12, &mut rope.order),
        (16, &mut rope.count),
        (20, &mut rope.samples),
        (24, &mut rope.closed),
        (28, &mut rope.border),
        (88, &mut rope.hidden),
        (92, &mut rope.filtered),
        (96, &mut rope.fit),
        (100, &mut rope.reserved),
    ] {
        *field = at + offset;
    }
    for (offset, field) in [
        (32, &mut rope.rms),
        (40, &mut rope.max),
        (48, &mut rope.residual_variance),
        (56, &mut rope.condition),
        (64, &mut rope.length),
        (72, &mut rope.width),
    ] {
        *field = half(offset);
    }
    rope.age_ns = (at + 80).into();
    for j in 0..32u32 {
        let i = j as usize;
        rope.control_points[i] = [0, 8].map(|axis| half(104 + 16 * j + axis));
        rope.weights[i] = half(616 + 8 * j);
        rope.covariances[i] = [0, 8, 16].map(|entry| half(872 + 24 * j + entry));
        rope.velocities[i] = [0, 8].map(|axis| half(1640 + 16 * j + axis));
        rope.knots[i] = half(2152 + 8 * j);
    }
}

/// A centerline that begins at this offset.
fn fill_points(points: &mut CenterlinePoints, at: u32) {
    // Exact, as no offset has more than 16 bits.
    let half = |offset: u32| (at + offset) as f32 + 0.5;
    (points.count, points.closed) = (at, at + 4);
    for (offset, word) in (8..).step_by(4).zip(&mut points.hidden) {
        *word = at + offset;
    }
    for i in 0..256 {
        let place = i as usize;
        points.points[place] = [0, 4].map(|axis| half(40 + 8 * i + axis));
        points.widths[place] = half(2088 + 4 * i);
    }
}
