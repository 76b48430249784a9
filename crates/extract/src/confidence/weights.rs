//! What each clue weighs: made by `lariat-bench calibrate-confidence --seeds 24 --labelled DIR`, which says
//! how true the confidence is on pictures that it was not fitted to: expected calibration error 0.035 of one's own masks (these are of an
//! earlier run), 0.022 of the network's, 0.022 of those from elsewhere. DIR is what `lariat-scenes --labelled DIR --seed 900000 --count 1400
//! --side 480 --photographs BACKGROUNDS` draws (`bench/training/`).

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
    0.000, // surely seen by the network
    0.000, // light and shade across it
    0.000, // straight
];
/// Where the network did.
#[rustfmt::skip]
pub(super) const NETWORK: [f32; CLUES] = [
    -7.037, // constant
    0.314, // edges on both sides
    0.357, // an edge on a side at least
    -0.647, // contrast in levels
    -1.601, // contrast over texture
    -0.453, // edges where the width says
    -3.299, // unevenness of the width
    -6.034, // unlikeness of colour along the curve
    0.414, // unlikeness of the two sides
    0.119, // unlikeness of the ground along the curve
    -0.420, // like the ground in less light
    6.852, // length in widths
    -4.250, // thinness
    -3.566, // bends
    1.131, // straight through the picture
    -2.251, // ends that go on
    4.205, // hidden share
    -1.379, // seen in part
    -2.187, // its own doubt
    0.041, // the mask's notice
    -1.253, // a stretch without edges
    1.662, // nothing against it
    -7.230, // an arc of a circle
    2.309, // surely seen by the network
    3.979, // light and shade across it
    -1.145, // straight
];
/// Where somebody else did.
#[rustfmt::skip]
pub(super) const ELSEWHERE: [f32; CLUES] = [
    -16.214, // constant
    1.750, // edges on both sides
    -0.565, // an edge on a side at least
    3.290, // contrast in levels
    -4.345, // contrast over texture
    2.604, // edges where the width says
    1.456, // unevenness of the width
    -3.925, // unlikeness of colour along the curve
    2.117, // unlikeness of the two sides
    2.413, // unlikeness of the ground along the curve
    0.054, // like the ground in less light
    12.120, // length in widths
    -1.475, // thinness
    -2.659, // bends
    4.525, // straight through the picture
    -4.653, // ends that go on
    2.184, // hidden share
    -0.394, // seen in part
    0.000, // its own doubt
    0.000, // the mask's notice
    -0.457, // a stretch without edges
    3.030, // nothing against it
    -4.980, // an arc of a circle
    0.000, // surely seen by the network
    3.060, // light and shade across it
    -0.588, // straight
];
