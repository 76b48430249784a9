//! Reading allocates at most once per chunk, not per message.

use lariat_record::{Recording, Span};
use lariat_test_support::allocations;
use mcap::Compression;

#[test]
fn a_message_costs_no_allocation_once_warm() {
    // lz4's decoder is created for each chunk. Everything else is reused.
    for (compression, per_chunk) in [
        (None, 0),
        (Some(Compression::Zstd), 0),
        (Some(Compression::Lz4), 2),
    ] {
        let (chunks, frames) = (6, 20);
        let recording =
            Recording::from_bytes(crate::made::rig(compression, chunks, frames)).unwrap();
        let mut messages = recording.messages(Span::default()).unwrap();
        // The first two chunks are read as a warm-up.
        let next = |messages: &mut lariat_record::Messages, count| {
            for _ in 0..count {
                assert!(messages.next().unwrap().is_some());
            }
        };
        next(&mut messages, 2 * frames * 5);
        let before = allocations();
        next(&mut messages, (chunks - 2) * frames * 5);
        let allocated = allocations() - before;
        assert!(
            allocated <= (chunks - 2) * per_chunk,
            "{compression:?}: {allocated}"
        );
    }
}
