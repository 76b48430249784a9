//! Writes images of a topic as the frames of a rig whose chain was started with `--source
//! external`.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;

use lariat_wire::{FrameHeader, FrameWriter, PixelFormat, Stamp, WriteError, now_ns};
use ros2_client::MessageInfo;
use ros2_client::gid::Gid;

use super::pixels::{Pixels, decode};
use super::received::{Picture, TakePicture};
use super::stamps::{Originals, Stamps};
use super::trouble::{Tally, Trouble, TroubleReporter};

/// Maximum age of an image. An older one comes from a recording or another clock, and must not be
/// used for steering.
const OLDEST_NS: u64 = 10_000_000_000;
/// Number of frames for which a mask may still arrive: two seconds at 30 fps.
const KNOWN: usize = 64;
/// Number of publishers whose last message number is stored.
const MOST_PUBLISHERS: usize = 8;

/// The newest frames by their stamps, for pairing with masks.
#[derive(Default)]
pub(super) struct Sent(VecDeque<(u64, FrameHeader)>);

impl Sent {
    pub(super) fn of(&self, stamp_ns: u64) -> Option<&FrameHeader> {
        let mut newest_first = self.0.iter().rev();
        let found = newest_first.find(|(known, _)| *known == stamp_ns);
        found.map(|(_, header)| header)
    }

    fn add(&mut self, stamp_ns: u64, header: FrameHeader) {
        if self.0.len() == KNOWN {
            self.0.pop_front();
        }
        self.0.push_back((stamp_ns, header));
    }
}

/// The rig's frames.
pub(super) struct Frames {
    topic: String,
    writer: FrameWriter,
    /// The image file to be decoded next.
    file: Vec<u8>,
    is_file: bool,
    stamps: Stamps,
    numbers: Numbers,
    originals: Originals,
    sent: Rc<RefCell<Sent>>,
    tally: Arc<Tally>,
    reporter: TroubleReporter,
}

impl Frames {
    pub(super) fn new(
        topic: &str,
        is_file: bool,
        writer: FrameWriter,
        stamps: Stamps,
        originals: Originals,
        tally: Arc<Tally>,
    ) -> Self {
        Self {
            topic: topic.to_owned(),
            writer,
            file: Vec::new(),
            is_file,
            stamps,
            numbers: Numbers::default(),
            originals,
            sent: Rc::default(),
            tally,
            reporter: TroubleReporter::default(),
        }
    }

    pub(super) fn sent(&self) -> Rc<RefCell<Sent>> {
        self.sent.clone()
    }

    /// Sends the image that was read. Returns its stamp if it became a frame.
    pub(super) fn send(&mut self, taken: Result<u64, Trouble>, info: &MessageInfo) -> Option<u64> {
        let (sequence, lost) = self
            .numbers
            .next(info.publisher_gid(), info.sequence_number());
        self.tally.lose(lost);
        let arrived_ns = now_ns();
        let sent = taken.and_then(|stamp_ns| {
            self.send_as(stamp_ns, sequence, arrived_ns)?;
            Ok(stamp_ns)
        });
        match sent {
            Ok(stamp_ns) => {
                self.tally.take();
                Some(stamp_ns)
            }
            Err(trouble) => {
                self.refuse(&trouble);
                None
            }
        }
    }

    /// Counts a message that could not even be parsed.
    pub(super) fn refuse_unread(&mut self, trouble: &Trouble) {
        self.numbers.unread += 1;
        self.refuse(trouble);
    }

    /// Counts an invalid image. Its number is skipped, so that the chain counts a frame lost at the
    /// source.
    fn refuse(&mut self, trouble: &Trouble) {
        self.tally.refuse();
        self.reporter.report(&self.topic, trouble);
    }

    fn send_as(&mut self, stamp_ns: u64, sequence: u64, arrived_ns: u64) -> Result<(), Trouble> {
        if self.is_file {
            let decoded = decode(&self.file)?;
            let slot = self
                .writer
                .loan(decoded.width, decoded.height, decoded.format)
                .map_err(not_written)?;
            slot.copy_from_slice(&decoded.bytes);
        }
        let (exposed_ns, trouble) = self.stamps.moment(stamp_ns, arrived_ns, OLDEST_NS)?;
        if let Some(trouble) = trouble {
            self.tally.restamp();
            self.reporter.report(&self.topic, &trouble);
        }
        let stamp = Stamp {
            exposed_ns: Some(exposed_ns),
            sequence: Some(sequence),
        };
        // This happens before the frame is sent, because messages about it may follow soon.
        if stamp_ns != 0 {
            self.originals.add(exposed_ns, stamp_ns);
        }
        self.writer.send(stamp).map_err(not_written)?;
        self.sent
            .borrow_mut()
            .add(stamp_ns, *self.writer.last_sent());
        Ok(())
    }
}

impl TakePicture for Frames {
    type Taken = Result<u64, Trouble>;

    fn take(&mut self, picture: Picture) -> Self::Taken {
        match picture {
            Picture::Raw(image) => {
                let pixels = Pixels::of(&image)?;
                let (width, height) = (pixels.width, pixels.height);
                let format: PixelFormat = pixels.format;
                let slot = self.writer.loan(width, height, format);
                pixels.copy_to(slot.map_err(not_written)?);
                Ok(image.header.stamp_ns())
            }
            Picture::File(image) => {
                self.file.clear();
                self.file.extend_from_slice(image.data);
                Ok(image.header.stamp_ns())
            }
        }
    }
}

fn not_written(cause: WriteError) -> Trouble {
    match cause {
        WriteError::Backwards { behind_ns } => Trouble::Backwards { behind_ns },
        cause => Trouble::NotWritten(cause.to_string()),
    }
}

/// Numbers of frames, derived from the publishers' message numbers. A lost message leaves a gap.
#[derive(Default)]
struct Numbers {
    last: u64,
    /// Number of unparsable messages since the last valid one. Their own numbers are unknown, and
    /// they are not gaps.
    unread: u64,
    /// Each publisher with its last number, the most recent one at the end.
    publishers: VecDeque<(Gid, i64)>,
}

impl Numbers {
    /// Returns the frame's number and how many messages of its publisher were lost before it.
    fn next(&mut self, publisher: Gid, number: i64) -> (u64, u64) {
        let known = self
            .publishers
            .iter()
            .position(|(gid, _)| *gid == publisher);
        let before = known.and_then(|place| self.publishers.remove(place));
        let lost = before.map_or(0, |(_, last)| {
            let between = number.saturating_sub(last).saturating_sub(1);
            // A larger gap cannot be a number of images.
            u32::try_from(between.max(0)).unwrap_or(0)
        });
        if self.publishers.len() == MOST_PUBLISHERS {
            self.publishers.pop_front();
        }
        self.publishers.push_back((publisher, number));
        let lost = u64::from(lost);
        self.last = self.last.saturating_add(1 + lost);
        let unread = std::mem::take(&mut self.unread);
        (self.last, lost.saturating_sub(unread))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn publisher(number: u8) -> Gid {
        Gid::from([number; 16])
    }

    #[test]
    fn what_did_not_come_of_a_publisher_is_a_gap_and_another_publisher_is_none() {
        let mut numbers = Numbers::default();
        let [a, b] = [1, 2].map(publisher);
        assert_eq!(numbers.next(a, 40), (1, 0));
        assert_eq!(numbers.next(a, 41), (2, 0));
        assert_eq!(numbers.next(a, 44), (5, 2));
        assert_eq!(numbers.next(b, 1), (6, 0));
        assert_eq!(numbers.next(a, 45), (7, 0));
        assert_eq!(numbers.next(b, 3), (9, 1));
        numbers.unread = 1;
        assert_eq!(numbers.next(b, 6), (12, 1));
        // A number that goes backwards or jumps far ahead does not count as a gap.
        assert_eq!(numbers.next(b, 2), (13, 0));
        assert_eq!(numbers.next(b, i64::MAX), (14, 0));
    }
}
