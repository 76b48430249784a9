//! A test picture, and the network's maps of it.

use lariat_network::{Maps, Network, Picture, Workspace};
use lariat_portable::SplitMix64;

/// Draws smooth waves and noise, 3 bytes per pixel.
pub(crate) fn draw(width: usize, height: usize, seed: u64) -> Vec<u8> {
    let mut random = SplitMix64::new(seed);
    let slopes: [u64; 3] = std::array::from_fn(|_| random.next_u64() % 9);
    let bytes = (0..height).flat_map(|y| (0..3 * width).map(move |k| (k / 3, y, k % 3)));
    let bytes = bytes.map(|(x, y, c)| {
        let wave = (x as u64 * slopes[c] + y as u64 * slopes[(c + 1) % 3]) % 256;
        (wave as u8) ^ (random.next_u64() % 32) as u8
    });
    bytes.collect()
}

/// Computes both maps of a picture without padding between rows.
pub(crate) fn maps(
    network: &Network,
    workspace: &mut Workspace,
    rgb: &[u8],
    [width, height]: [usize; 2],
) -> [Vec<u8>; 2] {
    let (mut rope, mut seam) = (vec![7; width * height], vec![9; width * height]);
    let picture = Picture {
        rgb,
        width,
        height,
        stride: 3 * width,
    };
    let maps = Maps {
        rope: &mut rope,
        seam: &mut seam,
        stride: width,
    };
    let done = network.run(workspace, picture, maps);
    done.expect("picture and maps are of one size");
    [rope, seam]
}
