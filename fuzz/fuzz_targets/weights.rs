//! The reader of the network's weights does not panic on any bytes, and a run with any weights that
//! it accepts ends properly. This also holds if the checksum is correct.
#![no_main]

use std::sync::LazyLock;

use arbitrary::Arbitrary;
use lariat_network::{Maps, Network, Picture, Workspace};
use libfuzzer_sys::fuzz_target;

static WHOLE: LazyLock<Vec<u8>> = LazyLock::new(|| Network::random(1).to_bytes());

/// Damage to a file.
#[derive(Arbitrary, Debug)]
enum File {
    /// The file is replaced by another one.
    Other(Vec<u8>),
    /// Some bytes are changed, and the file is longer or shorter. The checksum may have been
    /// corrected.
    Damaged {
        changed: Vec<(u32, u8)>,
        more: Vec<u8>,
        less: u32,
        is_sealed: bool,
    },
}

impl File {
    fn bytes(self) -> Vec<u8> {
        match self {
            Self::Other(bytes) => bytes,
            Self::Damaged {
                changed,
                more,
                less,
                is_sealed,
            } => {
                let mut bytes = WHOLE.clone();
                for (at, byte) in changed {
                    let at = at as usize % bytes.len();
                    bytes[at] = byte;
                }
                let kept = bytes.len() - less as usize % 64;
                bytes.truncate(kept);
                bytes.extend(more);
                if is_sealed {
                    seal(&mut bytes);
                }
                bytes
            }
        }
    }
}

/// CRC-32, bit by bit.
fn seal(bytes: &mut Vec<u8>) {
    bytes.truncate(bytes.len().saturating_sub(4));
    let mut crc = !0u32;
    for byte in bytes.iter() {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xEDB8_8320 * (crc & 1));
        }
    }
    bytes.extend((!crc).to_le_bytes());
}

fuzz_target!(|file: File| {
    let Ok(network) = Network::from_bytes(&file.bytes()) else {
        return;
    };
    let rgb: Vec<u8> = (0..3 * 20 * 20).map(|k| (k * 7) as u8).collect();
    let (mut rope, mut seam) = ([0; 400], [0; 400]);
    let picture = Picture {
        rgb: &rgb,
        width: 20,
        height: 20,
        stride: 60,
    };
    let maps = Maps {
        rope: &mut rope,
        seam: &mut seam,
        stride: 20,
    };
    assert_eq!(network.run(&mut Workspace::new(), picture, maps), Ok(()));
});
