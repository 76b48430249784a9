//! The weight of each clue for each class besides a rope, in the order of `Class::OTHERS`. They are fitted to the examples of
//! `lariat-bench calibrate-confidence --seeds 24 --labelled DIR`. DIR is what
//! `lariat-scenes --labelled DIR --seed 900000 --count 1400 --side 480` draws (`bench/training/`).

use super::CLUES;

#[rustfmt::skip]
pub(super) const OWN: [[f32; CLUES]; 6] = [
    // Fragment
    [
        -2.336, // constant
        6.032, // unevenness of the width
        3.843, // unlikeness of colour along the curve
        4.296, // unlikeness of the two sides
        -3.517, // length in widths
        2.620, // thinness
        0.839, // bends
        0.000, // straight
        0.000, // an arc of a circle
        0.000, // straight or an arc, and flat
        0.619, // along the border
        3.177, // not shown by the picture
        2.662, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        1.071, // a copy of the ropes in less light
        2.394, // unlike a longer one
        1.523, // small things alike
        3.870, // ends that go on
        4.271, // tips at a strand
        3.783, // tips that continue beyond a gap
        0.637, // ends at the border
        2.198, // crossings
        2.123, // left out of the mask
        0.804, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Shadow
    [
        -1.306, // constant
        4.688, // unevenness of the width
        2.900, // unlikeness of colour along the curve
        2.427, // unlikeness of the two sides
        -8.229, // length in widths
        2.403, // thinness
        0.316, // bends
        0.000, // straight
        0.000, // an arc of a circle
        5.667, // straight or an arc, and flat
        0.295, // along the border
        1.914, // not shown by the picture
        4.874, // a stretch without edges
        0.000, // light and shade across it
        3.740, // the table in less light
        8.589, // a copy of the ropes in less light
        3.245, // unlike a longer one
        0.000, // small things alike
        0.355, // ends that go on
        2.649, // tips at a strand
        5.264, // tips that continue beyond a gap
        -3.329, // ends at the border
        2.066, // crossings
        2.644, // left out of the mask
        1.576, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Pen
    [
        -4.260, // constant
        0.693, // unevenness of the width
        1.726, // unlikeness of colour along the curve
        5.317, // unlikeness of the two sides
        -5.528, // length in widths
        0.000, // thinness
        0.000, // bends
        5.214, // straight
        0.000, // an arc of a circle
        5.889, // straight or an arc, and flat
        0.000, // along the border
        0.000, // not shown by the picture
        0.000, // a stretch without edges
        0.000, // light and shade across it
        0.242, // the table in less light
        0.000, // a copy of the ropes in less light
        2.691, // unlike a longer one
        0.000, // small things alike
        2.197, // ends that go on
        0.000, // tips at a strand
        0.000, // tips that continue beyond a gap
        -0.177, // ends at the border
        1.521, // crossings
        2.124, // left out of the mask
        4.014, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Mark
    [
        1.364, // constant
        5.928, // unevenness of the width
        1.685, // unlikeness of colour along the curve
        5.328, // unlikeness of the two sides
        -9.719, // length in widths
        4.719, // thinness
        2.763, // bends
        0.000, // straight
        0.000, // an arc of a circle
        2.972, // straight or an arc, and flat
        4.871, // along the border
        2.055, // not shown by the picture
        4.061, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        2.043, // unlike a longer one
        0.000, // small things alike
        2.974, // ends that go on
        1.661, // tips at a strand
        0.000, // tips that continue beyond a gap
        -0.304, // ends at the border
        2.408, // crossings
        2.180, // left out of the mask
        1.590, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Edge
    [
        -8.262, // constant
        1.189, // unevenness of the width
        0.049, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        -1.526, // length in widths
        5.019, // thinness
        0.000, // bends
        5.236, // straight
        0.000, // an arc of a circle
        4.097, // straight or an arc, and flat
        0.126, // along the border
        0.000, // not shown by the picture
        0.294, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        0.000, // unlike a longer one
        3.467, // small things alike
        0.000, // ends that go on
        4.584, // tips at a strand
        0.000, // tips that continue beyond a gap
        3.877, // ends at the border
        0.000, // crossings
        0.000, // left out of the mask
        0.182, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Rim
    [
        -8.962, // constant
        0.500, // unevenness of the width
        0.279, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        -0.401, // length in widths
        3.616, // thinness
        0.000, // bends
        0.000, // straight
        6.484, // an arc of a circle
        5.457, // straight or an arc, and flat
        0.000, // along the border
        0.000, // not shown by the picture
        0.000, // a stretch without edges
        0.000, // light and shade across it
        0.695, // the table in less light
        0.000, // a copy of the ropes in less light
        3.225, // unlike a longer one
        0.000, // small things alike
        0.000, // ends that go on
        5.130, // tips at a strand
        0.000, // tips that continue beyond a gap
        2.810, // ends at the border
        2.155, // crossings
        0.000, // left out of the mask
        0.000, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
];

#[rustfmt::skip]
pub(super) const COLOR: [[f32; CLUES]; 1] = [
    // Fragment
    [
        0.363, // constant
        6.234, // unevenness of the width
        6.394, // unlikeness of colour along the curve
        3.600, // unlikeness of the two sides
        -6.248, // length in widths
        4.157, // thinness
        5.246, // bends
        0.730, // straight
        0.306, // an arc of a circle
        6.547, // straight or an arc, and flat
        0.803, // along the border
        0.925, // not shown by the picture
        3.534, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        2.070, // unlike a longer one
        1.044, // small things alike
        4.088, // ends that go on
        3.482, // tips at a strand
        4.255, // tips that continue beyond a gap
        -0.687, // ends at the border
        1.766, // crossings
        0.771, // left out of the mask
        0.745, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
];

#[rustfmt::skip]
pub(super) const NETWORK: [[f32; CLUES]; 6] = [
    // Fragment
    [
        0.322, // constant
        3.540, // unevenness of the width
        5.125, // unlikeness of colour along the curve
        2.062, // unlikeness of the two sides
        -3.170, // length in widths
        4.485, // thinness
        4.797, // bends
        0.000, // straight
        0.000, // an arc of a circle
        0.052, // straight or an arc, and flat
        2.494, // along the border
        2.932, // not shown by the picture
        2.475, // a stretch without edges
        -1.177, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        1.038, // unlike a longer one
        1.868, // small things alike
        2.264, // ends that go on
        1.615, // tips at a strand
        4.215, // tips that continue beyond a gap
        -0.137, // ends at the border
        1.366, // crossings
        1.052, // left out of the mask
        1.410, // seen in part
        -1.712, // surely seen by the network
        2.113, // seen by the network beyond its tips
    ],
    // Shadow
    [
        -1.009, // constant
        1.011, // unevenness of the width
        0.228, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        -0.730, // length in widths
        1.874, // thinness
        2.375, // bends
        0.000, // straight
        0.000, // an arc of a circle
        4.927, // straight or an arc, and flat
        0.000, // along the border
        1.859, // not shown by the picture
        0.000, // a stretch without edges
        -4.208, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        4.031, // unlike a longer one
        0.000, // small things alike
        2.804, // ends that go on
        0.574, // tips at a strand
        0.000, // tips that continue beyond a gap
        -2.371, // ends at the border
        3.361, // crossings
        1.899, // left out of the mask
        0.208, // seen in part
        -4.211, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Pen
    [
        -3.159, // constant
        3.590, // unevenness of the width
        0.000, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        -4.548, // length in widths
        0.000, // thinness
        0.000, // bends
        5.523, // straight
        0.000, // an arc of a circle
        3.528, // straight or an arc, and flat
        0.000, // along the border
        1.938, // not shown by the picture
        0.000, // a stretch without edges
        -3.470, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        5.009, // unlike a longer one
        0.000, // small things alike
        2.884, // ends that go on
        0.000, // tips at a strand
        3.763, // tips that continue beyond a gap
        -3.475, // ends at the border
        0.000, // crossings
        0.000, // left out of the mask
        1.198, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Mark
    [
        2.626, // constant
        5.760, // unevenness of the width
        2.862, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        -1.944, // length in widths
        4.068, // thinness
        5.538, // bends
        0.972, // straight
        1.250, // an arc of a circle
        2.399, // straight or an arc, and flat
        0.000, // along the border
        2.419, // not shown by the picture
        1.690, // a stretch without edges
        -5.624, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        3.232, // unlike a longer one
        1.439, // small things alike
        2.008, // ends that go on
        1.295, // tips at a strand
        3.916, // tips that continue beyond a gap
        -0.465, // ends at the border
        0.083, // crossings
        0.275, // left out of the mask
        0.764, // seen in part
        -3.628, // surely seen by the network
        0.546, // seen by the network beyond its tips
    ],
    // Edge
    [
        -4.504, // constant
        0.000, // unevenness of the width
        0.000, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        0.000, // length in widths
        5.377, // thinness
        0.000, // bends
        7.251, // straight
        0.000, // an arc of a circle
        1.980, // straight or an arc, and flat
        0.432, // along the border
        0.000, // not shown by the picture
        1.513, // a stretch without edges
        -4.220, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        0.000, // unlike a longer one
        4.559, // small things alike
        0.689, // ends that go on
        0.000, // tips at a strand
        0.000, // tips that continue beyond a gap
        2.598, // ends at the border
        2.359, // crossings
        0.000, // left out of the mask
        2.468, // seen in part
        -3.354, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Rim
    [
        -6.025, // constant
        5.545, // unevenness of the width
        3.270, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        -3.454, // length in widths
        9.174, // thinness
        0.000, // bends
        0.000, // straight
        10.689, // an arc of a circle
        5.265, // straight or an arc, and flat
        0.000, // along the border
        4.268, // not shown by the picture
        0.000, // a stretch without edges
        -4.375, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        2.974, // unlike a longer one
        0.000, // small things alike
        2.235, // ends that go on
        0.000, // tips at a strand
        1.887, // tips that continue beyond a gap
        2.151, // ends at the border
        1.999, // crossings
        0.385, // left out of the mask
        0.410, // seen in part
        -0.172, // surely seen by the network
        2.160, // seen by the network beyond its tips
    ],
];

#[rustfmt::skip]
pub(super) const ELSEWHERE: [[f32; CLUES]; 1] = [
    // Fragment
    [
        -1.496, // constant
        2.361, // unevenness of the width
        4.919, // unlikeness of colour along the curve
        0.995, // unlikeness of the two sides
        -2.340, // length in widths
        0.954, // thinness
        5.402, // bends
        0.000, // straight
        0.107, // an arc of a circle
        0.000, // straight or an arc, and flat
        2.656, // along the border
        6.379, // not shown by the picture
        2.374, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        0.363, // unlike a longer one
        1.857, // small things alike
        4.261, // ends that go on
        2.581, // tips at a strand
        8.801, // tips that continue beyond a gap
        -0.967, // ends at the border
        1.418, // crossings
        1.248, // left out of the mask
        1.579, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
];
