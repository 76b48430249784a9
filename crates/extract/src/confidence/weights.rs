//! The weight of each clue, fitted to the examples of `lariat-bench calibrate-confidence --seeds 24 --labelled DIR`. DIR is what
//! `lariat-scenes --labelled DIR --seed 900000 --count 1400 --side 480` draws (`bench/training/`).

use super::CLUES;

/// For masks that the extractor makes of the table.
#[rustfmt::skip]
pub(super) const OWN: [f32; CLUES] = [
    -2.993, // constant
    -5.462, // unevenness of the width
    -4.567, // unlikeness of colour along the curve
    -5.288, // unlikeness of the two sides
    9.186, // length in widths
    -5.186, // thinness
    -0.978, // bends
    -8.316, // straight and flat
    -5.018, // an arc of a circle
    -3.992, // not shown by the picture
    -6.458, // a stretch without edges
    0.000, // light and shade across it
    -3.033, // ends that go on
    -3.824, // tips at a strand
    -2.820, // tips that continue beyond a gap
    -0.664, // ends at the border
    -1.981, // crossings
    -2.016, // left out of the mask
    -0.582, // seen in part
    -2.812, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];

/// For masks of color ranges.
#[rustfmt::skip]
pub(super) const COLOR: [f32; CLUES] = [
    -3.761, // constant
    -5.204, // unevenness of the width
    -5.182, // unlikeness of colour along the curve
    -2.944, // unlikeness of the two sides
    9.429, // length in widths
    -5.569, // thinness
    -4.647, // bends
    -4.824, // straight and flat
    -2.146, // an arc of a circle
    -0.869, // not shown by the picture
    -4.152, // a stretch without edges
    0.000, // light and shade across it
    -3.677, // ends that go on
    -3.577, // tips at a strand
    -4.028, // tips that continue beyond a gap
    1.272, // ends at the border
    -2.360, // crossings
    -0.952, // left out of the mask
    -1.032, // seen in part
    0.000, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];

/// For masks of the network.
#[rustfmt::skip]
pub(super) const NETWORK: [f32; CLUES] = [
    -4.037, // constant
    -3.308, // unevenness of the width
    -3.768, // unlikeness of colour along the curve
    -0.516, // unlikeness of the two sides
    4.749, // length in widths
    -4.792, // thinness
    -4.605, // bends
    -4.344, // straight and flat
    -5.340, // an arc of a circle
    -4.181, // not shown by the picture
    -2.373, // a stretch without edges
    2.178, // light and shade across it
    -2.430, // ends that go on
    -1.409, // tips at a strand
    -5.379, // tips that continue beyond a gap
    -0.271, // ends at the border
    -1.293, // crossings
    -0.654, // left out of the mask
    -1.345, // seen in part
    -1.230, // its own doubt
    2.655, // surely seen by the network
    -2.346, // seen by the network beyond its tips
];

/// For masks from elsewhere.
#[rustfmt::skip]
pub(super) const ELSEWHERE: [f32; CLUES] = [
    0.852, // constant
    -2.967, // unevenness of the width
    -4.650, // unlikeness of colour along the curve
    -1.068, // unlikeness of the two sides
    3.084, // length in widths
    -1.190, // thinness
    -5.563, // bends
    0.000, // straight and flat
    -1.230, // an arc of a circle
    -6.868, // not shown by the picture
    -2.438, // a stretch without edges
    0.000, // light and shade across it
    -4.102, // ends that go on
    -2.811, // tips at a strand
    -6.211, // tips that continue beyond a gap
    0.907, // ends at the border
    -1.593, // crossings
    -1.413, // left out of the mask
    -1.654, // seen in part
    0.000, // its own doubt
    0.000, // surely seen by the network
    0.000, // seen by the network beyond its tips
];
