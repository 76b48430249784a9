//! The weight of each clue, fitted to the examples of `lariat-bench calibrate-confidence --seeds 24 --labelled DIR`. DIR is what
//! `lariat-scenes --labelled DIR --seed 900000 --count 1400 --side 480` draws (`bench/training/`).

use super::CLUES;

/// For masks that the extractor makes of the table.
#[rustfmt::skip]
pub(super) const OWN: [f32; CLUES] = [
    -3.288, // constant
    -4.047, // unevenness of the width
    -2.395, // unlikeness of colour along the curve
    -4.038, // unlikeness of the two sides
    8.631, // length in widths
    -4.320, // thinness
    0.000, // bends
    0.000, // straight
    -4.402, // an arc of a circle
    -2.507, // not shown by the picture
    -4.764, // a stretch without edges
    0.000, // light and shade across it
    -2.359, // ends that go on
    -3.105, // tips at a strand
    -1.926, // tips that continue beyond a gap
    -0.543, // ends at the border
    -1.997, // crossings
    -1.760, // left out of the mask
    -1.888, // seen in part
    -3.752, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];
/// For masks of colour ranges.
#[rustfmt::skip]
pub(super) const COLOR: [f32; CLUES] = [
    -4.694, // constant
    -2.986, // unevenness of the width
    -5.067, // unlikeness of colour along the curve
    -2.368, // unlikeness of the two sides
    9.556, // length in widths
    -5.409, // thinness
    -3.123, // bends
    0.000, // straight
    -1.844, // an arc of a circle
    -1.334, // not shown by the picture
    0.000, // a stretch without edges
    0.000, // light and shade across it
    -3.324, // ends that go on
    -2.699, // tips at a strand
    -3.827, // tips that continue beyond a gap
    1.125, // ends at the border
    -1.800, // crossings
    -1.209, // left out of the mask
    -0.865, // seen in part
    0.000, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];
/// For masks of the network.
#[rustfmt::skip]
pub(super) const NETWORK: [f32; CLUES] = [
    -4.448, // constant
    -3.337, // unevenness of the width
    -4.491, // unlikeness of colour along the curve
    -0.200, // unlikeness of the two sides
    4.246, // length in widths
    -4.690, // thinness
    -5.014, // bends
    -0.858, // straight
    -5.463, // an arc of a circle
    -4.318, // not shown by the picture
    -1.274, // a stretch without edges
    3.500, // light and shade across it
    -2.249, // ends that go on
    -1.916, // tips at a strand
    -5.603, // tips that continue beyond a gap
    -0.165, // ends at the border
    -0.981, // crossings
    -0.599, // left out of the mask
    -1.367, // seen in part
    -0.982, // its own doubt
    2.575, // surely seen by the network
    -1.584, // seen by the network beyond its tips
];
/// For masks that are given.
#[rustfmt::skip]
pub(super) const ELSEWHERE: [f32; CLUES] = [
    1.230, // constant
    -3.232, // unevenness of the width
    -4.984, // unlikeness of colour along the curve
    -0.463, // unlikeness of the two sides
    2.862, // length in widths
    -1.063, // thinness
    -5.841, // bends
    0.000, // straight
    -1.257, // an arc of a circle
    -6.898, // not shown by the picture
    -1.716, // a stretch without edges
    0.000, // light and shade across it
    -3.915, // ends that go on
    -2.122, // tips at a strand
    -6.138, // tips that continue beyond a gap
    0.584, // ends at the border
    -1.574, // crossings
    -1.259, // left out of the mask
    -1.656, // seen in part
    0.000, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];
