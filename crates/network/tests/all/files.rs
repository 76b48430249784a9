//! A file is read as it was written, and anything else is refused with a message.

use lariat_network::{Network, NetworkError};
use proptest::prelude::*;

/// Replaces the checksum by the correct one, so that the checks after it run.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.truncate(bytes.len() - 4);
    let mut crc = !0u32;
    for byte in &bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xEDB8_8320 * (crc & 1));
        }
    }
    bytes.extend((!crc).to_le_bytes());
    bytes
}

fn refused(bytes: &[u8]) -> String {
    match Network::from_bytes(bytes) {
        Ok(_) => "not refused".to_owned(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_file_is_read_as_it_was_written() {
    let network = Network::random(3);
    let bytes = network.to_bytes();
    let again = Network::from_bytes(&bytes).expect("it was just written");
    assert_eq!(again.numbers(), network.numbers());
    assert_eq!(again.to_bytes(), bytes);
    assert!(bytes.len() < 500_000, "{}", bytes.len());
}

#[test]
fn what_is_no_file_of_weights_is_refused_in_words() {
    let bytes = Network::random(3).to_bytes();
    let with = |at: usize, new: &[u8]| {
        let mut bytes = bytes.clone();
        bytes[at..at + new.len()].copy_from_slice(new);
        bytes
    };
    let mut longer = bytes.clone();
    longer.extend([0; 4]);
    // Offsets of the stem: 16 bytes of header and 8 of shape, then 432 weights, 16 biases and 16
    // scales.
    let (stem_weight, stem_bias, stem_scale) = (24, 24 + 432, 24 + 432 + 64);
    let cases: [(&[u8], &str); 14] = [
        (b"", "begin with LARIATN1"),
        (b"LARIATN2", "begin with LARIATN1"),
        (b"LARIATN1", "damaged or cut off"),
        (b"LARIATN1\x01\0\0\0", "damaged or cut off"),
        (&bytes[..bytes.len() - 1], "damaged or cut off"),
        (&with(8, &[2]), "of version 2"),
        (&with(100, &[bytes[100] ^ 4]), "Copy the file again"),
        (
            &sealed(with(12, &[14])),
            "14 layers where this lariat has 15",
        ),
        (&sealed(with(16, &[4])), "3×3 from 4 to 16 channels"),
        (&sealed(with(23, &[1])), "something else where"),
        (&sealed(longer), "4 bytes behind the last layer"),
        (
            &sealed(with(stem_weight, &[128])),
            "Layer stem cannot be computed. A weight of −128",
        ),
        (
            &sealed(with(stem_bias + 3, &[127])),
            "The sums of output channel 0",
        ),
        (
            &sealed(with(stem_scale, &[0, 0, 192, 127])),
            "A scale of NaN",
        ),
    ];
    for (bytes, expected) in cases {
        let found = refused(bytes);
        assert!(found.contains(expected), "{found:?} has no {expected:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn no_byte_changed_and_no_end_cut_off_makes_it_fall(
        changes in prop::collection::vec((0usize..1 << 19, any::<u8>()), 1..4),
        in_the_head: bool,
        kept in 0usize..1 << 19,
        is_sealed: bool,
    ) {
        let mut bytes = Network::random(3).to_bytes();
        let original = bytes.clone();
        let range = if in_the_head { 600 } else { bytes.len() };
        for (at, byte) in changes {
            bytes[at % range] = byte;
        }
        if kept % 3 == 0 {
            bytes.truncate(kept % original.len());
        }
        if is_sealed && bytes.len() >= 4 {
            bytes = sealed(bytes);
        }
        // A change is refused, unless it only changes numbers within their bounds and the checksum
        // is correct.
        match Network::from_bytes(&bytes) {
            Ok(network) => prop_assert!(network.to_bytes() == bytes && (is_sealed || bytes == original)),
            Err(NetworkError::Damaged) => prop_assert!(!is_sealed || bytes.len() < original.len()),
            Err(error) => prop_assert!(error.to_string().ends_with('.')),
        }
    }
}
