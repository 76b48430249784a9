//! What each clue weighs: made by `cargo run --release -p lariat-lab -- calibrate-confidence`, which says how true the
//! confidence is on pictures that it was not fitted to: expected calibration error 0.035 of one's own masks, 0.044 of the network's, 0.029 of
//! those from elsewhere.

use super::CLUES;

/// Where the extractor made the mask.
#[rustfmt::skip]
pub(super) const OWN: [f32; CLUES] = [
    -6.553, // constant
    -0.429, // edges on both sides
    -2.853, // an edge on a side at least
    6.110, // contrast in levels
    -1.054, // contrast over texture
    -0.808, // edges where the width says
    -0.295, // unevenness of the width
    -1.828, // unlikeness of colour along the curve
    0.122, // unlikeness of the two sides
    0.377, // unlikeness of the ground along the curve
    -0.826, // like the ground in less light
    7.119, // length in widths
    -2.487, // thinness
    0.026, // bends
    -2.531, // straight through the picture
    -1.390, // ends that go on
    -0.141, // hidden share
    -2.437, // seen in part
    -1.803, // its own doubt
    -0.466, // the mask's notice
    -2.111, // a stretch without edges
    2.892, // nothing against it
    0.000, // an arc of a circle
    0.000, // likely by the network
    0.000, // unlikely by the network in part
];
/// Where the network did.
#[rustfmt::skip]
pub(super) const NETWORK: [f32; CLUES] = [
    -16.782, // constant
    1.675, // edges on both sides
    -5.280, // an edge on a side at least
    10.215, // contrast in levels
    -1.921, // contrast over texture
    -2.198, // edges where the width says
    1.178, // unevenness of the width
    -2.761, // unlikeness of colour along the curve
    2.799, // unlikeness of the two sides
    1.354, // unlikeness of the ground along the curve
    -2.515, // like the ground in less light
    11.225, // length in widths
    -4.173, // thinness
    -1.685, // bends
    -3.827, // straight through the picture
    -1.916, // ends that go on
    -1.446, // hidden share
    -1.402, // seen in part
    -2.125, // its own doubt
    -0.046, // the mask's notice
    -1.895, // a stretch without edges
    1.875, // nothing against it
    -7.557, // an arc of a circle
    7.118, // likely by the network
    1.739, // unlikely by the network in part
];
/// Where somebody else did.
#[rustfmt::skip]
pub(super) const ELSEWHERE: [f32; CLUES] = [
    -10.374, // constant
    1.913, // edges on both sides
    0.300, // an edge on a side at least
    2.242, // contrast in levels
    -3.479, // contrast over texture
    0.397, // edges where the width says
    0.367, // unevenness of the width
    -2.730, // unlikeness of colour along the curve
    0.672, // unlikeness of the two sides
    0.405, // unlikeness of the ground along the curve
    -0.514, // like the ground in less light
    10.122, // length in widths
    -1.570, // thinness
    -0.742, // bends
    0.000, // straight through the picture
    -5.290, // ends that go on
    0.120, // hidden share
    -0.152, // seen in part
    0.000, // its own doubt
    0.000, // the mask's notice
    -0.626, // a stretch without edges
    2.191, // nothing against it
    0.000, // an arc of a circle
    0.000, // likely by the network
    0.000, // unlikely by the network in part
];
