//! A run allocates only for a picture larger than all before it.

use lariat_network::{Maps, Network, Picture, Workspace};

use crate::picture::draw;

#[test]
fn nothing_is_allocated_once_the_largest_picture_has_been_seen() {
    let network = Network::random(1);
    let mut workspace = Workspace::new();
    let rgb = draw(96, 80, 1);
    let (mut rope, mut seam) = (vec![0; 96 * 80], vec![0; 96 * 80]);
    let mut counts = Vec::with_capacity(8);
    for (width, height) in [(96, 80), (96, 80), (33, 16), (1, 1), (96, 80)] {
        let before = lariat_test_support::allocations();
        let picture = Picture {
            rgb: &rgb,
            width,
            height,
            stride: 3 * 96,
        };
        let maps = Maps {
            rope: &mut rope,
            seam: &mut seam,
            stride: 96,
        };
        let done = network.run(&mut workspace, picture, maps);
        assert_eq!(done, Ok(()));
        counts.push(lariat_test_support::allocations() - before);
    }
    assert!(counts[0] > 0);
    assert_eq!(counts[1..], [0, 0, 0, 0]);
}
