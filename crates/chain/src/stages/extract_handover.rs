//! Extract's handover state: its last message, encoded as in a recording, and the state that goes
//! with it.

use lariat_record::Record;
use lariat_wire::{Centerlines, Status};

use super::handover::{DoubleBuffer, Handover};
use crate::pipeline::Past;

/// Number of bytes before the message.
const HEAD: usize = 20;

/// The state of a predecessor.
pub(super) struct Restored {
    pub(super) past: Past,
    pub(super) last: Box<Centerlines>,
}

/// Reads the state that the previous extract process left, if there is one and it is complete.
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

/// Returns the number of visible ropes in the last message.
pub(crate) fn ropes_seen(handover: &Handover) -> usize {
    let left = read(handover);
    let last = left.as_ref().map(|left| left.last.curves());
    let seen = last.unwrap_or_default().iter();
    seen.filter(|curve| curve.status() != Some(Status::Lost))
        .count()
}

/// Writes the state. Only copying the message happens before it is sent. Encoding and writing
/// follow afterwards, so that sending is not delayed.
pub(super) struct HandoverWriter {
    last: Box<Centerlines>,
    message: Vec<u8>,
    bytes: Vec<u8>,
}

impl Default for HandoverWriter {
    fn default() -> Self {
        // Reserve room for the largest message, so that nothing is allocated later.
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

    /// Writes the state that was kept.
    pub(super) fn leave(&mut self, past: Past, left: &DoubleBuffer) {
        self.last.encode(&mut self.message);
        self.bytes.clear();
        self.bytes.extend(past.exposed_ns.to_le_bytes());
        for number in [past.size[0], past.size[1], past.tracks] {
            self.bytes.extend(number.to_le_bytes());
        }
        self.bytes.extend(&self.message);
        // If the state is too large, the previous one remains.
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
