//! The weight of each clue, fitted to the examples of `lariat-bench calibrate-confidence --seeds 24 --labelled DIR`. DIR is what
//! `lariat-scenes --labelled DIR --seed 900000 --count 1400 --side 480` draws (`bench/training/`).

use super::CLUES;

/// For masks that the extractor makes of the table.
#[rustfmt::skip]
pub(super) const OWN: [f32; CLUES] = [
    -2.313, // constant
    -5.302, // unevenness of the width
    -4.464, // unlikeness of colour along the curve
    -5.297, // unlikeness of the two sides
    8.407, // length in widths
    -5.111, // thinness
    -0.817, // bends
    -8.332, // straight and flat
    -5.071, // an arc of a circle
    -4.037, // not shown by the picture
    -5.101, // a stretch without edges
    0.000, // light and shade across it
    -3.071, // ends that go on
    -3.880, // tips at a strand
    -2.758, // tips that continue beyond a gap
    -0.706, // ends at the border
    -1.875, // crossings
    -2.079, // left out of the mask
    -0.622, // seen in part
    -2.741, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];
/// For masks of colour ranges.
#[rustfmt::skip]
pub(super) const COLOR: [f32; CLUES] = [
    -3.602, // constant
    -4.947, // unevenness of the width
    -4.939, // unlikeness of colour along the curve
    -3.538, // unlikeness of the two sides
    9.411, // length in widths
    -5.475, // thinness
    -4.736, // bends
    -8.427, // straight and flat
    -2.183, // an arc of a circle
    -0.757, // not shown by the picture
    -4.281, // a stretch without edges
    0.000, // light and shade across it
    -3.717, // ends that go on
    -3.519, // tips at a strand
    -4.057, // tips that continue beyond a gap
    1.178, // ends at the border
    -2.572, // crossings
    -0.673, // left out of the mask
    -0.913, // seen in part
    0.000, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];
/// For masks of the network.
#[rustfmt::skip]
pub(super) const NETWORK: [f32; CLUES] = [
    -3.893, // constant
    -3.302, // unevenness of the width
    -3.770, // unlikeness of colour along the curve
    -0.511, // unlikeness of the two sides
    4.565, // length in widths
    -4.777, // thinness
    -4.618, // bends
    -4.360, // straight and flat
    -5.336, // an arc of a circle
    -4.227, // not shown by the picture
    -1.358, // a stretch without edges
    2.161, // light and shade across it
    -2.422, // ends that go on
    -1.406, // tips at a strand
    -5.388, // tips that continue beyond a gap
    -0.266, // ends at the border
    -1.269, // crossings
    -0.637, // left out of the mask
    -1.345, // seen in part
    -1.247, // its own doubt
    2.675, // surely seen by the network
    -2.345, // seen by the network beyond its tips
];
/// For masks that are given.
#[rustfmt::skip]
pub(super) const ELSEWHERE: [f32; CLUES] = [
    1.093, // constant
    -2.977, // unevenness of the width
    -4.738, // unlikeness of colour along the curve
    -1.056, // unlikeness of the two sides
    2.820, // length in widths
    -1.192, // thinness
    -5.595, // bends
    0.000, // straight and flat
    -1.146, // an arc of a circle
    -6.874, // not shown by the picture
    -1.892, // a stretch without edges
    0.000, // light and shade across it
    -4.104, // ends that go on
    -2.792, // tips at a strand
    -6.257, // tips that continue beyond a gap
    0.897, // ends at the border
    -1.541, // crossings
    -1.411, // left out of the mask
    -1.644, // seen in part
    0.000, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];
