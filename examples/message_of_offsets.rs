//! Writes a message of descriptors in which every number is its own offset, for authors of readers
//! in other languages.
//!
//! ```sh
//! cargo run --release --example message_of_offsets -- --rig layout &
//! ```
//!
//! An integer is its own offset in the message, in bytes; a floating-point number is its offset
//! plus a half. For example, `unit` at offset 100 is 100, and the `rms` of the first rope at offset
//! 136 is 136.5. The table is in docs/messages.md. The message does not describe a rope, and a
//! reader that validates its input says so; read the message itself. The program sends it ten times
//! a second until standard input ends, and prints "sent" after the first one.

use std::io::Read;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use lariat_wire::fields::{Message, Place};
use lariat_wire::{DESCRIPTORS, Delivery, Descriptors, Domain, Rig, Writer};

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

/// Makes the message.
pub(crate) fn message() -> Box<Descriptors> {
    let mut message = Box::new(Descriptors::EMPTY);
    fill(&mut *message, 0);
    message
}

/// Fills in a message that begins at this offset.
fn fill(message: &mut dyn Message, at: usize) {
    message.visit_mut(&mut |field, place| {
        let at = at + field.offset;
        // This is exact, because no offset has more than 18 bits.
        match place {
            Place::U32(word) => *word = at as u32,
            Place::U64(word) => *word = at as u64,
            Place::F32(number) => *number = at as f32 + 0.5,
            Place::F64(number) => *number = at as f64 + 0.5,
            Place::Point([x, y]) => (*x, *y) = (at as f32 + 0.5, at as f32 + 4.5),
            Place::F32s(numbers, _) => {
                for (i, number) in numbers.iter_mut().enumerate() {
                    *number = (at + 4 * i) as f32 + 0.5;
                }
            }
            Place::F64s(numbers, _) => {
                for (i, number) in numbers.iter_mut().enumerate() {
                    *number = (at + 8 * i) as f64 + 0.5;
                }
            }
            Place::Hidden(words) => {
                for (i, word) in words.iter_mut().enumerate() {
                    *word = (at + 4 * i) as u32;
                }
            }
            Place::Message(inner) => fill(inner, at),
            Place::Messages(room) => {
                for i in 0..room.size() {
                    let inner = room.at_mut(i);
                    let size = inner.layout().size;
                    fill(inner, at + i * size);
                }
            }
        }
    });
}
