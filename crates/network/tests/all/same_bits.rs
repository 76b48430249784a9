//! The maps have the same bits with every instruction set and on every machine.

use lariat_network::{Maps, Network, Picture, Workspace};
use lariat_portable::{Arch, ConvolutionKernels};

use crate::picture::{draw, maps};

/// FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3);
    bytes.iter().fold(0xCBF2_9CE4_8422_2325, step)
}

/// Hashes of a random network's maps. They change with the network, the drawn picture and the
/// arithmetic.
const EXPECTED: (u64, u64) = (10_924_765_985_122_882_579, 12_913_875_111_644_284_762);

#[test]
fn every_kind_of_registers_gives_the_same_maps() {
    let network = Network::random(7);
    let size = [161, 120];
    let rgb = draw(size[0], size[1], 7);
    for arch in Arch::all() {
        arch.keep_to();
        let [rope, seam] = maps(&network, &mut Workspace::new(), &rgb, size);
        let found = (hash(&rope), hash(&seam));
        assert_eq!(found, EXPECTED, "{arch:?}");
    }
    // This includes kernels that are not used normally, because there is a faster one for the same
    // instruction set.
    for kernels in ConvolutionKernels::all() {
        let [mut rope, mut seam] = [(); 2].map(|()| vec![0; size[0] * size[1]]);
        let picture = Picture {
            rgb: &rgb,
            width: size[0],
            height: size[1],
            stride: 3 * size[0],
        };
        let to = Maps {
            rope: &mut rope,
            seam: &mut seam,
            stride: size[0],
        };
        let done = network.run_observed(kernels, &mut Workspace::new(), picture, to, |_| ());
        assert_eq!(done, Ok(()));
        assert_eq!((hash(&rope), hash(&seam)), EXPECTED, "{}", kernels.name());
    }
}
