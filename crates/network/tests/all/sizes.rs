//! Sizes, strides and rectangles.

use lariat_network::{Maps, Network, Picture, SizeError, Workspace};
use proptest::prelude::*;

use crate::picture::{draw, maps};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn a_rectangle_s_maps_are_those_of_a_picture_of_it(
        width in 1usize..70, height in 1usize..50, left in 0usize..20, top in 0usize..20, seed: u64,
    ) {
        let whole = [width + left + 3, height + top + 2];
        let rgb = draw(whole[0], whole[1], seed);
        let network = Network::random(seed);
        let rows = (top..top + height).map(|y| &rgb[3 * (y * whole[0] + left)..][..3 * width]);
        let cut = Vec::from_iter(rows.flatten().copied());
        let expected = maps(&network, &mut Workspace::new(), &cut, [width, height]);

        // The workspace has seen another picture, and the maps have padding between rows.
        let mut workspace = Workspace::new();
        maps(&network, &mut workspace, &rgb, whole);
        let stride = width + 5;
        let (mut rope, mut seam) = (vec![7; stride * height], vec![7; stride * height]);
        let picture = Picture {
            rgb: &rgb[3 * (top * whole[0] + left)..],
            width,
            height,
            stride: 3 * whole[0],
        };
        let to = Maps { rope: &mut rope, seam: &mut seam, stride };
        prop_assert_eq!(network.run(&mut workspace, picture, to), Ok(()));
        for (found, expected) in [rope, seam].iter().zip(&expected) {
            for (found, expected) in found.chunks(stride).zip(expected.chunks(width)) {
                prop_assert_eq!(&found[..width], expected);
                prop_assert!(found[width..].iter().all(|byte| *byte == 7));
            }
        }
    }
}

#[test]
fn what_has_no_room_is_refused_in_words() {
    let network = Network::random(1);
    let run = |width: usize, height: usize, bytes: usize, strides: [usize; 2], room: [usize; 2]| {
        let (mut rope, mut seam) = (vec![0; room[0]], vec![0; room[1]]);
        let picture = Picture {
            rgb: &vec![0; bytes],
            width,
            height,
            stride: strides[0],
        };
        let maps = Maps {
            rope: &mut rope,
            seam: &mut seam,
            stride: strides[1],
        };
        let done = network.run(&mut Workspace::new(), picture, maps);
        done.map_err(|error: SizeError| error.to_string())
    };
    assert_eq!(run(4, 3, 36, [12, 4], [12, 12]), Ok(()));
    // The last row needs only its pixels, not a full stride.
    assert_eq!(run(4, 3, 2 * 20 + 12, [20, 6], [16, 16]), Ok(()));
    let cases = [
        (
            run(0, 3, 36, [12, 4], [12, 12]),
            "A picture of 0 × 3 pixels",
        ),
        (run(4, 0, 36, [12, 4], [12, 12]), "from 1 to 16384"),
        (run(4, 1 << 40, 36, [12, 4], [12, 12]), "from 1 to 16384"),
        (run(4, 3, 35, [12, 4], [12, 12]), "A picture of 35 bytes"),
        (run(4, 3, 36, [11, 4], [12, 12]), "11 bytes apart"),
        (
            run(4, 3, 36, [usize::MAX, 4], [12, 12]),
            "rows that do not overlap",
        ),
        (run(4, 3, 36, [12, 4], [11, 12]), "A map of 11 bytes"),
        (run(4, 3, 36, [12, 4], [12, 11]), "at least 12 bytes"),
        (
            run(4, 3, 36, [12, 3], [12, 12]),
            "hold no 3 rows of 4 bytes",
        ),
    ];
    for (found, expected) in cases {
        let found = found.expect_err(expected);
        assert!(found.contains(expected), "{found:?} has no {expected:?}");
    }
}
