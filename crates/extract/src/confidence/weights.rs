//! The weight of each clue, fitted to the examples of `lariat-bench calibrate-confidence --seeds 24 --labelled DIR`. DIR is what
//! `lariat-scenes --labelled DIR --seed 900000 --count 1400 --side 480` draws (`bench/training/`).

use super::CLUES;

/// For masks that the extractor makes of the table.
#[rustfmt::skip]
pub(super) const OWN: [f32; CLUES] = [
    -2.194, // constant
    -5.333, // unevenness of the width
    -4.464, // unlikeness of colour along the curve
    -5.211, // unlikeness of the two sides
    8.263, // length in widths
    -5.067, // thinness
    -0.856, // bends
    -8.310, // straight and flat
    -5.053, // an arc of a circle
    -4.035, // not shown by the picture
    -5.059, // a stretch without edges
    0.000, // light and shade across it
    -3.117, // ends that go on
    -3.865, // tips at a strand
    -2.747, // tips that continue beyond a gap
    -0.689, // ends at the border
    -1.951, // crossings
    -2.108, // left out of the mask
    -0.596, // seen in part
    -2.816, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];
/// For masks of colour ranges.
#[rustfmt::skip]
pub(super) const COLOR: [f32; CLUES] = [
    -3.640, // constant
    -4.955, // unevenness of the width
    -6.410, // unlikeness of colour along the curve
    -2.993, // unlikeness of the two sides
    9.160, // length in widths
    -5.593, // thinness
    -4.959, // bends
    -6.317, // straight and flat
    -2.053, // an arc of a circle
    -0.755, // not shown by the picture
    -0.950, // a stretch without edges
    0.000, // light and shade across it
    -3.372, // ends that go on
    -3.755, // tips at a strand
    -3.935, // tips that continue beyond a gap
    1.298, // ends at the border
    -1.964, // crossings
    -0.773, // left out of the mask
    -0.991, // seen in part
    0.000, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];
/// For masks of the network.
#[rustfmt::skip]
pub(super) const NETWORK: [f32; CLUES] = [
    -3.888, // constant
    -3.297, // unevenness of the width
    -3.764, // unlikeness of colour along the curve
    -0.519, // unlikeness of the two sides
    4.561, // length in widths
    -4.767, // thinness
    -4.656, // bends
    -4.375, // straight and flat
    -5.338, // an arc of a circle
    -4.226, // not shown by the picture
    -1.360, // a stretch without edges
    2.148, // light and shade across it
    -2.431, // ends that go on
    -1.401, // tips at a strand
    -5.391, // tips that continue beyond a gap
    -0.262, // ends at the border
    -1.258, // crossings
    -0.630, // left out of the mask
    -1.348, // seen in part
    -1.250, // its own doubt
    2.681, // surely seen by the network
    -2.333, // seen by the network beyond its tips
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
