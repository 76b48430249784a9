//! A sealed datagram: its sender, its kind, its count among the datagrams of this kind, and its
//! content.
//!
//! ```text
//!  0  'l' 'b'      2  version 3      3  kind      4  hash of the messages' versions
//!  8  the sender's random number (u64)            16  count of this kind, with this one (u64)
//! 24  content …                                   then a tag of 16 bytes (ChaCha20-Poly1305)
//! ```
//!
//! Numbers are little endian. The tag authenticates head and content. The nonce consists of kind
//! and count, and the key belongs to this sender alone, so no nonce occurs twice. Counts only grow,
//! so replays are detected. To learn whether a sender is alive or a recording is replayed, the
//! receiver has to ask it.

use std::sync::atomic::{AtomicU64, Ordering};

use lariat_wire::{Centerlines, Command, Descriptors, Descriptors3, Rig};
use thiserror::Error;

use crate::key::{Key, Seal, Side};

const MAGIC: [u8; 3] = *b"lb\x03";
/// Length in bytes of the head of a datagram.
pub(crate) const HEAD: usize = 24;
/// Bytes of a datagram in addition to its content.
#[cfg(test)]
pub(crate) const OVERHEAD: usize = HEAD + crate::key::TAG;
/// Maximum number of senders known at a time.
const SENDERS: usize = 16;

/// Kind of a datagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// From the far side: asks for the time.
    Ask = 0,
    /// From the near side: answers with the time.
    Answer = 1,
    /// From the near side, like the next two kinds.
    Descriptors = 2,
    Centerlines = 3,
    Truth = 4,
    /// From the far side.
    Command = 5,
    /// From the near side: part of a frame.
    Picture = 6,
    /// From the near side, before the descriptors of the same frame.
    Descriptors3 = 7,
    /// From the near side: part of a mask.
    Mask = 8,
    /// From the near side: part of a datagram that is larger than UDP can carry.
    Part = 9,
}

impl Kind {
    const ALL: [Self; 10] = [
        Self::Ask,
        Self::Answer,
        Self::Descriptors,
        Self::Centerlines,
        Self::Truth,
        Self::Command,
        Self::Picture,
        Self::Descriptors3,
        Self::Mask,
        Self::Part,
    ];
    /// Messages of the rig's channels. Each answer reports how many were sent.
    pub(crate) const COUNTED: [Self; 4] = [
        Self::Descriptors,
        Self::Descriptors3,
        Self::Centerlines,
        Self::Truth,
    ];
}

/// Why a datagram is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub(crate) enum Refused {
    #[error("something else than a bridge sends there")]
    Foreign,
    #[error("the other side is of another release of lariat: use the same on both")]
    Release,
    #[error(
        "what comes is sealed with another key or none, for another rig, or was changed on its way: give both sides the same \
         --key FILE and --rig"
    )]
    Seal,
    #[error(
        "a message makes no sense, and is not passed on: use the same release of lariat on both sides"
    )]
    Nonsense,
}

/// Returns the versions of all messages, as one number.
fn versions() -> u32 {
    let names = [
        Descriptors::LAYOUT.type_name,
        Descriptors3::LAYOUT.type_name,
        Centerlines::LAYOUT.type_name,
        Command::LAYOUT.type_name,
    ];
    // FNV-1a.
    let bytes = names.iter().flat_map(|name| name.bytes());
    bytes.fold(0x811c_9dc5, |hash, byte| {
        (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193)
    })
}

fn nonce(kind: u8, count: [u8; 8]) -> [u8; 12] {
    let mut nonce = [0; 12];
    nonce[0] = kind;
    nonce[4..].copy_from_slice(&count);
    nonce
}

/// Writes the datagrams of this process.
pub(crate) struct Outgoing {
    process: u64,
    seal: Seal,
    sent: [AtomicU64; Kind::ALL.len()],
}

impl Outgoing {
    /// Creates a writer. `process` is this process's random number.
    pub(crate) fn new(process: u64, key: &Key, side: Side, rig: &Rig) -> Self {
        Self {
            process,
            seal: key.of(process, side, rig),
            sent: Default::default(),
        }
    }

    /// Returns this process's random number.
    pub(crate) fn process(&self) -> u64 {
        self.process
    }

    /// Returns the number of datagrams of a kind that were sent.
    pub(crate) fn sent(&self, kind: Kind) -> u64 {
        self.sent[kind as usize].load(Ordering::Relaxed)
    }

    /// Makes the next datagram of a kind. `say` appends the content.
    pub(crate) fn write(&self, kind: Kind, datagram: &mut Vec<u8>, say: impl FnOnce(&mut Vec<u8>)) {
        let count = (1 + self.sent[kind as usize].fetch_add(1, Ordering::Relaxed)).to_le_bytes();
        datagram.clear();
        datagram.extend(MAGIC);
        datagram.push(kind as u8);
        datagram.extend(versions().to_le_bytes());
        datagram.extend(self.process.to_le_bytes());
        datagram.extend(count);
        say(datagram);
        self.seal.close(nonce(kind as u8, count), datagram, HEAD);
    }
}

/// A datagram from a sender that has the key.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Datagram<'d> {
    /// The sender's random number.
    pub(crate) process: u64,
    pub(crate) kind: Kind,
    /// Number of datagrams of this kind that the sender had sent, including this one.
    pub(crate) count: u64,
    pub(crate) says: &'d [u8],
}

/// Reads the datagrams that the processes of the other side send.
pub(crate) struct Incoming {
    key: Key,
    from: Side,
    rig: Rig,
    /// The seals of known senders, the most recently heard first.
    seals: Vec<(u64, Seal)>,
}

impl Incoming {
    pub(crate) fn new(key: Key, from: Side, rig: &Rig) -> Self {
        Self {
            key,
            from,
            rig: rig.clone(),
            seals: Vec::with_capacity(SENDERS),
        }
    }

    /// Reads a datagram, and decrypts it in place.
    ///
    /// # Errors
    /// Fails with the reason why the datagram is refused.
    pub(crate) fn read<'d>(&mut self, datagram: &'d mut [u8]) -> Result<Datagram<'d>, Refused> {
        let Some((head, _)) = datagram.split_first_chunk::<HEAD>() else {
            return Err(Refused::Foreign);
        };
        let number = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| head[at + i]));
        let (process, count) = (number(8), number(16));
        let kind = Kind::ALL.into_iter().find(|kind| *kind as u8 == head[3]);
        let is_ours = head[4..8] == versions().to_le_bytes();
        if head[..2] != MAGIC[..2] {
            return Err(Refused::Foreign);
        }
        let (Some(kind), true, true) = (kind, head[2] == MAGIC[2], is_ours) else {
            return Err(Refused::Release);
        };
        let known = self.seals.iter().position(|(known, _)| *known == process);
        let (seal, is_new) = match known {
            Some(at) => (self.seals.remove(at).1, false),
            None => (self.key.of(process, self.from, &self.rig), true),
        };
        let says = seal.open(nonce(kind as u8, count.to_le_bytes()), datagram, HEAD);
        // A sender without the key must not evict one with the key.
        if says.is_some() || !is_new {
            self.seals.truncate(SENDERS - 1);
            self.seals.insert(0, (process, seal));
        }
        let says = says.ok_or(Refused::Seal)?;
        Ok(Datagram {
            process,
            kind,
            count,
            says,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn rig() -> Rig {
        "cell".parse().expect("a name")
    }

    fn key(name: &str) -> (Key, Key) {
        let path: PathBuf =
            std::env::temp_dir().join(format!("lariat-datagram-{name}-{}", std::process::id()));
        Key::make(&path).expect("made");
        let [one, other] = [0, 1].map(|_| Key::read(&path).expect("read"));
        std::fs::remove_file(path).expect("it is ours");
        (one, other)
    }

    #[test]
    fn a_datagram_says_who_sent_it_and_the_how_many_th_it_is() {
        let (ours, theirs) = key("says");
        for (ours, theirs) in [(Key::NONE, Key::NONE), (ours, theirs)] {
            let outgoing = Outgoing::new(77, &ours, Side::Near, &rig());
            let mut incoming = Incoming::new(theirs, Side::Near, &rig());
            let mut bytes = Vec::new();
            for count in 1..=3 {
                outgoing.write(Kind::Descriptors, &mut bytes, |to| to.extend(b"rope"));
                let read = incoming.read(&mut bytes).expect("ours");
                assert_eq!(
                    read,
                    Datagram {
                        process: 77,
                        kind: Kind::Descriptors,
                        count,
                        says: b"rope"
                    }
                );
            }
            assert_eq!(
                (outgoing.sent(Kind::Descriptors), outgoing.sent(Kind::Truth)),
                (3, 0)
            );
        }
    }

    #[test]
    fn what_is_not_ours_is_refused_and_said_why() {
        let (ours, theirs) = key("refused");
        let (other, _) = key("other");
        let mut bytes = Vec::new();
        let sealed = Outgoing::new(1, &ours, Side::Near, &rig());
        let open = Outgoing::new(1, &Key::NONE, Side::Near, &rig());
        let mut with_key = Incoming::new(theirs, Side::Near, &rig());
        let mut without = Incoming::new(Key::NONE, Side::Near, &rig());
        open.write(Kind::Ask, &mut bytes, |_| {});
        assert_eq!(with_key.read(&mut bytes), Err(Refused::Seal));
        sealed.write(Kind::Ask, &mut bytes, |_| {});
        assert_eq!(without.read(&mut bytes.clone()), Err(Refused::Seal));
        assert_eq!(
            Incoming::new(other, Side::Near, &rig()).read(&mut bytes.clone()),
            Err(Refused::Seal)
        );
        assert!(with_key.read(&mut bytes.clone()).is_ok());
        // It is too short to be a datagram.
        assert_eq!(with_key.read(&mut [0; 7]), Err(Refused::Foreign));
        // Every flipped bit is detected, even without a key.
        let mut plain = Vec::new();
        open.write(Kind::Descriptors, &mut plain, |to| to.extend(b"rope"));
        for (reader, bytes) in [(&mut with_key, &bytes), (&mut without, &plain)] {
            for bit in 0..8 * bytes.len() {
                let mut changed = bytes.clone();
                changed[bit / 8] ^= 1 << (bit % 8);
                assert!(reader.read(&mut changed).is_err(), "{bit}");
            }
        }
        open.write(Kind::Ask, &mut bytes, |_| {});
        bytes[2] += 1;
        assert_eq!(without.read(&mut bytes), Err(Refused::Release));
        open.write(Kind::Ask, &mut bytes, |_| {});
        bytes[4] ^= 1;
        assert_eq!(without.read(&mut bytes), Err(Refused::Release));
        for length in 0..HEAD {
            assert_eq!(without.read(&mut vec![b'l'; length]), Err(Refused::Foreign));
        }
    }

    #[test]
    fn as_many_senders_as_like_are_read_by_turns() {
        let (ours, theirs) = key("many");
        let mut incoming = Incoming::new(theirs, Side::Far, &rig());
        let senders: Vec<_> = (0..40)
            .map(|i| Outgoing::new(i, &ours, Side::Far, &rig()))
            .collect();
        let mut bytes = Vec::new();
        for count in 1..=3 {
            for sender in &senders {
                sender.write(Kind::Command, &mut bytes, |to| to.push(9));
                let read = incoming.read(&mut bytes).expect("ours");
                assert_eq!(
                    (read.process, read.count, read.says),
                    (sender.process(), count, &[9][..])
                );
            }
        }
        assert!(incoming.seals.len() <= SENDERS);
    }
}
