//! What each clue weighs: made by `cargo run --release -p lariat-lab -- calibrate-confidence`, which says how true the
//! confidence is on pictures that it was not fitted to: expected calibration error 0.035 and 0.029. They were fitted before curves
//! found by shape were dropped below 0.1, which leaves such out of the next fit.

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
    0.000, // likely by the network
    0.000, // unlikely by the network in part
];
/// Where the network did.
#[rustfmt::skip]
pub(super) const NETWORK: [f32; CLUES] = [
    -6.021, // constant
    0.128, // edges on both sides
    -2.125, // an edge on a side at least
    4.319, // contrast in levels
    -1.339, // contrast over texture
    -1.858, // edges where the width says
    -0.515, // unevenness of the width
    -1.773, // unlikeness of colour along the curve
    -0.081, // unlikeness of the two sides
    -0.412, // unlikeness of the ground along the curve
    -1.045, // like the ground in less light
    8.391, // length in widths
    -2.657, // thinness
    0.194, // bends
    -1.212, // straight through the picture
    -2.098, // ends that go on
    -0.257, // hidden share
    -1.222, // seen in part
    -1.733, // its own doubt
    0.180, // the mask's notice
    -2.003, // a stretch without edges
    2.273, // nothing against it
    -0.116, // likely by the network
    -2.195, // unlikely by the network in part
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
    0.000, // likely by the network
    0.000, // unlikely by the network in part
];
