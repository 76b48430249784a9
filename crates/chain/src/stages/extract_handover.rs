//! What extract leaves to its successor: what it said last, as a recording has it, and what it knew beside.

use lariat_record::Record;
use lariat_wire::{Centerlines, Status};

use super::handover::{DoubleBuffer, Handover};
use crate::pipeline::Past;

/// Bytes before the message.
const HEAD: usize = 20;

/// What was left.
pub(super) struct Restored {
    pub(super) past: Past,
    pub(super) last: Box<Centerlines>,
}

/// What the extract before left, if there was one and it is whole.
pub(super) fn read(handover: &Handover) -> Option<Restored> {
    let bytes = handover.state()?.newest_first().next()?;
    let (&moment, rest) = bytes.split_first_chunk()?;
    let (&numbers, message) = rest.split_first_chunk::<12>()?;
    let [width, height, tracks] = [0, 4, 8].map(|at| {
        let number: [u8; 4] = std::array::from_fn(|i| numbers[at + i]);
        u32::from_le_bytes(number)
    });
    let mut last = Box::new(Centerlines::EMPTY);
    last.decode(message).ok()?;
    let past = Past {
        exposed_ns: u64::from_le_bytes(moment),
        size: [width, height],
        tracks,
    };
    Some(Restored { past, last })
}

/// How many ropes the last message has that are seen.
pub(crate) fn ropes_seen(handover: &Handover) -> usize {
    let left = read(handover);
    let last = left.as_ref().map(|left| left.last.curves());
    let seen = last.unwrap_or_default().iter();
    seen.filter(|curve| curve.status() != Some(Status::Lost))
        .count()
}

/// How it is written: the message is copied while it is here, and the rest is done when it was sent, out of its way.
pub(super) struct HandoverWriter {
    last: Box<Centerlines>,
    message: Vec<u8>,
    bytes: Vec<u8>,
}

impl Default for HandoverWriter {
    fn default() -> Self {
        // As large as a message can be: nothing is allocated later.
        let room = HEAD + 2 * size_of::<Centerlines>();
        Self {
            last: Box::new(Centerlines::EMPTY),
            message: Vec::with_capacity(room),
            bytes: Vec::with_capacity(room),
        }
    }
}

impl HandoverWriter {
    pub(super) fn keep(&mut self, last: &Centerlines) {
        self.last.copy_meant(last);
    }

    /// Leaves what was kept.
    pub(super) fn leave(&mut self, past: Past, left: &DoubleBuffer) {
        self.last.encode(&mut self.message);
        self.bytes.clear();
        self.bytes.extend(past.exposed_ns.to_le_bytes());
        for number in [past.size[0], past.size[1], past.tracks] {
            self.bytes.extend(number.to_le_bytes());
        }
        self.bytes.extend(&self.message);
        // One that is too large for it leaves the one before.
        let _ = left.write(&self.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::status::Sent;

    #[test]
    fn what_was_left_comes_back() {
        let mut last = Box::new(Centerlines::EMPTY);
        (last.width, last.height, last.count) = (640, 480, 2);
        last.curves[1].track = 7;
        last.curves[1].count = 3;
        last.curves[1].points[2] = [3.5, -1.0];
        let past = Past {
            exposed_ns: 1 << 40,
            size: [640, 480],
            tracks: 8,
        };
        let mut handover = Handover::make("test").unwrap();
        assert!(read(&handover).is_none());
        let buffers = handover.state().unwrap();
        let mut writer = HandoverWriter::default();
        writer.keep(&last);
        writer.leave(past, &buffers);
        let sent = Sent {
            count: 5,
            last_sequence: 5,
        };
        handover.note(sent, 5);
        let left = read(&handover).unwrap();
        assert_eq!((left.past, left.last), (past, last));
        buffers.write(b"what another release may leave").unwrap();
        assert!(read(&handover).is_none());
    }
}
