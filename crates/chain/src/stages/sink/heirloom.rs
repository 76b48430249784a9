//! What a sink leaves to the one that comes after it: a file that outlives both, as the chain keeps it open.
//!
//! ```text
//! from      what                    written
//! 0         progress                as of every stage
//! 4 KiB     counts   } in turns     with each round of messages
//! 8 KiB     counts   }
//! 12 KiB    tally    } in turns     once a second
//! +16 MiB   tally    }
//!
//! each:  number 8 bytes, length 8 bytes (both little-endian), and as many bytes as lariat_sink makes, with their check
//! ```
//!
//! Of two, the one of the higher number holds, if it is whole: a sink that is killed while it writes leaves the other. The file
//! has holes; of its 32 MiB some hundred kilobytes are there.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

use anyhow::Context;
use lariat_sink::{Options, RestoreError, Tally};

/// Number and length.
const HEAD: usize = 16;
/// Where the counts stand, and how long they may be.
const COUNTS: [u64; 2] = [4 << 10, 8 << 10];
const MOST_COUNTS: u64 = 4 << 10;
/// Where the tallies stand. Every bucket of every histogram in use would take some 2 MB.
const TALLIES: [u64; 2] = [12 << 10, (12 << 10) + MOST_TALLY];
const MOST_TALLY: u64 = 16 << 20;

/// The two places of one kind.
pub(super) struct Turns {
    file: File,
    places: [u64; 2],
    most: u64,
    /// Of what is written next.
    number: u64,
    buffer: Vec<u8>,
}

impl Turns {
    fn new(file: File, places: [u64; 2], most: u64, room: usize) -> Self {
        Self {
            file,
            places,
            most,
            number: 1,
            buffer: Vec::with_capacity(room),
        }
    }

    /// Writes what `save` puts behind the head. Allocates nothing where that is no longer than before.
    pub(super) fn write(&mut self, save: impl FnOnce(&mut Vec<u8>)) -> io::Result<()> {
        self.buffer.clear();
        self.buffer.extend([0; HEAD]);
        save(&mut self.buffer);
        let length = (self.buffer.len() - HEAD) as u64;
        if self.buffer.len() as u64 > self.most {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        self.buffer[..8].copy_from_slice(&self.number.to_le_bytes());
        self.buffer[8..HEAD].copy_from_slice(&length.to_le_bytes());
        let place = self.places[(self.number % 2) as usize];
        self.file.write_all_at(&self.buffer, place)?;
        self.number += 1;
        Ok(())
    }

    /// The newest that `restore` takes; the cause of the last refusal if there are some and it takes none.
    fn newest<T>(
        &mut self,
        mut restore: impl FnMut(&[u8]) -> Result<T, RestoreError>,
    ) -> io::Result<Result<Option<T>, RestoreError>> {
        let mut found = Ok(None);
        let mut heads = [self.head(0)?, self.head(1)?];
        heads.sort_by_key(|&[number, ..]| std::cmp::Reverse(number));
        for [number, place, length] in heads.into_iter().filter(|&[number, ..]| number > 0) {
            // The next one is written over the other.
            let mut bytes = vec![0; length.min(self.most) as usize];
            let read = self.file.read_exact_at(&mut bytes, place + HEAD as u64);
            match read
                .map_err(|_| RestoreError::Damaged)
                .and_then(|()| restore(&bytes))
            {
                Ok(whole) => {
                    self.number = number.saturating_add(1);
                    return Ok(Ok(Some(whole)));
                }
                Err(cause) => found = Err(cause),
            }
        }
        Ok(found)
    }

    /// Number, place and length of what stands in one of the places; a number of 0 where nothing does.
    fn head(&self, turn: usize) -> io::Result<[u64; 3]> {
        let place = self.places[turn];
        let mut head = [0; HEAD];
        match self.file.read_exact_at(&mut head, place) {
            Err(cause) if cause.kind() == io::ErrorKind::UnexpectedEof => {}
            read => read?,
        }
        let [number, length] = [0, 8].map(|at| {
            let bytes = head[at..].first_chunk();
            u64::from_le_bytes(*bytes.expect("the head has 16 bytes"))
        });
        Ok([number, place, length])
    }
}

/// What the sink before this one left, and where this one leaves its own.
pub(super) struct Heirloom {
    pub(super) counts: Turns,
    pub(super) tally: Turns,
    is_inherited: bool,
}

impl Heirloom {
    /// One that is in a file.
    ///
    /// # Errors
    /// It cannot be read.
    pub(super) fn new(file: File) -> io::Result<Self> {
        Ok(Self {
            is_inherited: file.metadata()?.len() > COUNTS[0],
            counts: Turns::new(file.try_clone()?, COUNTS, MOST_COUNTS, MOST_COUNTS as usize),
            tally: Turns::new(file, TALLIES, MOST_TALLY, 0),
        })
    }

    /// Whether there was a sink before.
    pub(super) fn is_inherited(&self) -> bool {
        self.is_inherited
    }

    /// What this sink is to go on with: what the last one left, or nothing if there was none. One that left nothing that can be
    /// read is said, and the counting begins with what comes.
    pub(super) fn tally(&mut self, options: Options) -> anyhow::Result<Tally> {
        if !self.is_inherited {
            return Ok(Tally::new(options));
        }
        let late = Options {
            from_start: false,
            ..options
        };
        match self
            .inherited(options)
            .context("cannot read what the last sink left")?
        {
            Ok(tally) => Ok(tally),
            Err(cause) => {
                tracing::warn!(
                    "sink counts from now on, as it cannot go on where the last one stopped: {cause}"
                );
                Ok(Tally::new(late))
            }
        }
    }

    fn inherited(&mut self, options: Options) -> io::Result<Result<Tally, RestoreError>> {
        let tally = self.tally.newest(|bytes| Tally::restore(options, bytes))?;
        // What is timed is of the last second; without it, what is counted holds all the same.
        let mut tally = tally.unwrap_or(None).unwrap_or_else(|| Tally::new(options));
        let counted = self.counts.newest(|bytes| tally.restore_counts(bytes))?;
        let counted = counted.and_then(|found| found.ok_or(RestoreError::Damaged));
        Ok(counted.map(|()| tally.resumed()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_sink::{Sink, Times};
    use lariat_wire::{Descriptors, Trace};

    const OPTIONS: Options = Options {
        period_ns: None,
        deadline_ns: None,
        from_start: true,
    };

    fn receive(sink: &mut Sink, number: u64) {
        let mut message = Box::new(Descriptors::EMPTY);
        message.trace = Trace {
            sequence: number,
            captured: number,
            extracted: number,
            fitted: number,
            exposed_ns: number,
            fitted_ns: number,
            ..Trace::EMPTY
        };
        message.width = 1;
        sink.descriptors(&message, number + 1);
    }

    /// A sink that has counted so many messages and saved all after each.
    fn leave(file: &File, count: u64) {
        let mut heirloom = Heirloom::new(file.try_clone().expect("a descriptor")).expect("a file");
        let mut sink = Sink::of(heirloom.tally(OPTIONS).expect("readable"));
        let before = sink.frames().received;
        for number in before + 1..=before + count {
            receive(&mut sink, number);
            let tally = sink.tally();
            heirloom
                .counts
                .write(|into| tally.save_counts(into))
                .expect("written");
            heirloom
                .tally
                .write(|into| tally.save(into))
                .expect("written");
        }
    }

    fn inherit(file: &File) -> (u64, u64, u64) {
        let mut heirloom = Heirloom::new(file.try_clone().expect("a descriptor")).expect("a file");
        let tally = heirloom.tally(OPTIONS).expect("readable");
        let report = tally.report_on(lariat_sink::Machine::this());
        let files = report.files().expect("memory takes it");
        let total = files.iter().find(|(name, _)| name == "total.hgrm");
        let (_, total) = total.expect("there is one");
        let timed = Times::from_hgrm(&String::from_utf8_lossy(total));
        (
            tally.frames().received,
            timed.expect("a histogram").count(),
            report.restarts().sink,
        )
    }

    #[test]
    fn one_sink_goes_on_where_the_other_stopped() {
        let file = tempfile::tempfile().expect("a file");
        leave(&file, 5);
        assert_eq!(inherit(&file), (5, 5, 1));
        leave(&file, 1);
        // What comes first has waited for the sink, and is not timed.
        assert_eq!(inherit(&file), (6, 5, 2));
    }

    #[test]
    fn what_is_torn_leaves_the_older_one() {
        let file = tempfile::tempfile().expect("a file");
        leave(&file, 6);
        for (places, left) in [(COUNTS, (5, 6, 1)), (TALLIES, (5, 5, 1))] {
            // The sixth of each stands in the first place.
            file.write_all_at(&[0xff; 8], places[0] + 22)
                .expect("written");
            assert_eq!(inherit(&file), left);
        }
        // The next one goes over what is torn.
        leave(&file, 1);
        assert_eq!(inherit(&file), (6, 5, 2));
    }

    #[test]
    fn without_a_whole_one_the_counting_begins_anew() {
        let file = tempfile::tempfile().expect("a file");
        leave(&file, 6);
        for place in COUNTS {
            file.write_all_at(&u64::MAX.to_le_bytes(), place + 8)
                .expect("written");
        }
        let mut heirloom = Heirloom::new(file).expect("a file");
        let mut sink = Sink::of(heirloom.tally(OPTIONS).expect("readable"));
        receive(&mut sink, 20);
        let frames = sink.frames();
        assert_eq!((frames.published, frames.received), (1, 1));
    }
}
