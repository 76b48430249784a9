//! Arbitrary bytes are refused, or read as far as possible, without further harm.

use crate::made;

use lariat_record::{Entry, Record, Recording, Span};
use mcap::Compression;
use proptest::prelude::*;

/// Reads everything possible. Returns the encoded centerlines.
fn read(bytes: Vec<u8>) -> Vec<Vec<u8>> {
    let mut seen = Vec::new();
    let Ok(recording) = Recording::from_bytes(bytes) else {
        return seen;
    };
    let _ = recording.frames();
    let names: Vec<_> = recording.attachments().map(str::to_owned).collect();
    for name in names {
        let _ = recording.attachment(&name);
    }
    let Ok(mut messages) = recording.messages(Span::default()) else {
        return seen;
    };
    loop {
        match messages.next() {
            Ok(Some(Entry::Centerlines(message))) => {
                let mut cdr = Vec::new();
                message.encode(&mut cdr);
                seen.push(cdr);
            }
            Ok(Some(_)) | Err(_) => {}
            Ok(None) => return seen,
        }
    }
}

fn compressions() -> impl Strategy<Value = Option<Compression>> {
    prop::sample::select(vec![None, Some(Compression::Lz4), Some(Compression::Zstd)])
}

proptest! {
    #[test]
    fn with_bits_flipped_no_message_is_read_that_was_not_written(
        compression in compressions(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0u8..8), 1..6),
    ) {
        let mut bytes = made::rig(compression, 3, 2);
        let length = bytes.len();
        for (place, bit) in flips {
            bytes[place.index(length)] ^= 1 << bit;
        }
        let written: Vec<_> = (1..=6)
            .map(|sequence| {
                let mut cdr = Vec::new();
                made::centerlines(sequence).encode(&mut cdr);
                cdr
            })
            .collect();
        for message in read(bytes) {
            prop_assert!(written.contains(&message));
        }
    }

    #[test]
    fn lengths_of_any_size_do_no_harm(
        compression in compressions(),
        place in any::<prop::sample::Index>(),
        length in prop::sample::select(vec![0u64, 1, 0xffff, 1 << 31, (1 << 32) - 1, 1 << 40, u64::MAX - 8, u64::MAX]),
        wide: bool,
    ) {
        let mut bytes = made::rig(compression, 2, 1);
        let at = place.index(bytes.len() - 8);
        let width = if wide { 8 } else { 4 };
        bytes[at..at + width].copy_from_slice(&length.to_le_bytes()[..width]);
        read(bytes);
    }

    #[test]
    fn any_bytes_behind_the_magic_are_read_without_harm(
        bytes in prop::collection::vec(any::<u8>(), 0..400),
        kinds in prop::collection::vec(1u8..16, 0..8),
    ) {
        let mut file = b"\x89MCAP0\r\n".to_vec();
        for (i, part) in bytes.chunks(40).enumerate() {
            if let Some(kind) = kinds.get(i) {
                file.push(*kind);
                file.extend((part.len() as u64).to_le_bytes());
            }
            file.extend(part);
        }
        read(file.clone());
        file.extend(b"\x89MCAP0\r\n");
        read(file);
    }
}
