//! The weight of each clue for each class besides a rope, in the order of `Class::OTHERS`. They are fitted to the examples of
//! `lariat-bench calibrate-confidence --seeds 24 --labelled DIR`. DIR is what
//! `lariat-scenes --labelled DIR --seed 900000 --count 1400 --side 480` draws (`bench/training/`).

use super::CLUES;

#[rustfmt::skip]
pub(super) const OWN: [[f32; CLUES]; 6] = [
    // Fragment
    [
        -2.651, // constant
        6.229, // unevenness of the width
        3.451, // unlikeness of colour along the curve
        4.858, // unlikeness of the two sides
        -3.550, // length in widths
        3.117, // thinness
        0.000, // bends
        0.000, // straight
        0.000, // an arc of a circle
        0.000, // straight or an arc, and flat
        1.155, // along the border
        2.548, // not shown by the picture
        2.889, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        1.127, // a copy of the ropes in less light
        2.171, // unlike a longer one
        1.145, // small things alike
        3.181, // ends that go on
        4.913, // tips at a strand
        5.005, // tips that continue beyond a gap
        0.498, // ends at the border
        2.661, // crossings
        1.980, // left out of the mask
        0.319, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Shadow
    [
        2.380, // constant
        6.575, // unevenness of the width
        4.230, // unlikeness of colour along the curve
        4.400, // unlikeness of the two sides
        -10.421, // length in widths
        2.376, // thinness
        0.000, // bends
        0.000, // straight
        0.000, // an arc of a circle
        7.189, // straight or an arc, and flat
        0.000, // along the border
        3.250, // not shown by the picture
        7.103, // a stretch without edges
        0.000, // light and shade across it
        0.968, // the table in less light
        8.434, // a copy of the ropes in less light
        2.470, // unlike a longer one
        0.000, // small things alike
        1.334, // ends that go on
        1.981, // tips at a strand
        3.413, // tips that continue beyond a gap
        -3.045, // ends at the border
        3.597, // crossings
        1.320, // left out of the mask
        1.392, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Pen
    [
        -2.261, // constant
        0.467, // unevenness of the width
        0.591, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        -6.527, // length in widths
        0.000, // thinness
        0.000, // bends
        3.605, // straight
        0.000, // an arc of a circle
        6.561, // straight or an arc, and flat
        0.000, // along the border
        0.000, // not shown by the picture
        0.000, // a stretch without edges
        0.000, // light and shade across it
        1.034, // the table in less light
        0.000, // a copy of the ropes in less light
        3.682, // unlike a longer one
        0.000, // small things alike
        0.477, // ends that go on
        0.000, // tips at a strand
        0.000, // tips that continue beyond a gap
        -0.375, // ends at the border
        0.000, // crossings
        0.000, // left out of the mask
        3.483, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Mark
    [
        -2.258, // constant
        0.000, // unevenness of the width
        0.507, // unlikeness of colour along the curve
        3.634, // unlikeness of the two sides
        -6.141, // length in widths
        0.333, // thinness
        1.179, // bends
        0.000, // straight
        0.000, // an arc of a circle
        0.000, // straight or an arc, and flat
        7.317, // along the border
        0.633, // not shown by the picture
        0.000, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        0.369, // unlike a longer one
        0.000, // small things alike
        0.000, // ends that go on
        1.395, // tips at a strand
        0.000, // tips that continue beyond a gap
        2.188, // ends at the border
        0.000, // crossings
        4.597, // left out of the mask
        0.000, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Edge
    [
        -8.024, // constant
        1.251, // unevenness of the width
        0.050, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        -1.572, // length in widths
        4.088, // thinness
        0.000, // bends
        5.331, // straight
        0.057, // an arc of a circle
        3.718, // straight or an arc, and flat
        0.000, // along the border
        0.000, // not shown by the picture
        0.000, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        0.000, // unlike a longer one
        3.520, // small things alike
        0.000, // ends that go on
        5.024, // tips at a strand
        0.000, // tips that continue beyond a gap
        3.913, // ends at the border
        0.000, // crossings
        0.000, // left out of the mask
        0.000, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Rim
    [
        -9.032, // constant
        4.101, // unevenness of the width
        3.753, // unlikeness of colour along the curve
        5.448, // unlikeness of the two sides
        -1.125, // length in widths
        6.945, // thinness
        1.969, // bends
        1.851, // straight
        5.977, // an arc of a circle
        5.380, // straight or an arc, and flat
        0.000, // along the border
        1.019, // not shown by the picture
        2.977, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        2.099, // unlike a longer one
        0.000, // small things alike
        4.293, // ends that go on
        3.342, // tips at a strand
        0.000, // tips that continue beyond a gap
        1.532, // ends at the border
        2.040, // crossings
        0.159, // left out of the mask
        2.337, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
];

#[rustfmt::skip]
pub(super) const COLOR: [[f32; CLUES]; 1] = [
    // Fragment
    [
        -0.024, // constant
        6.432, // unevenness of the width
        6.662, // unlikeness of colour along the curve
        3.558, // unlikeness of the two sides
        -5.947, // length in widths
        4.127, // thinness
        5.665, // bends
        1.326, // straight
        1.881, // an arc of a circle
        6.922, // straight or an arc, and flat
        1.285, // along the border
        0.929, // not shown by the picture
        4.052, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        1.866, // unlike a longer one
        1.136, // small things alike
        3.908, // ends that go on
        3.655, // tips at a strand
        4.211, // tips that continue beyond a gap
        -0.476, // ends at the border
        2.046, // crossings
        0.802, // left out of the mask
        0.631, // seen in part
        0.000, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
];

#[rustfmt::skip]
pub(super) const NETWORK: [[f32; CLUES]; 6] = [
    // Fragment
    [
        0.163, // constant
        3.507, // unevenness of the width
        6.080, // unlikeness of colour along the curve
        2.069, // unlikeness of the two sides
        -3.153, // length in widths
        4.281, // thinness
        4.506, // bends
        0.000, // straight
        0.000, // an arc of a circle
        0.551, // straight or an arc, and flat
        2.294, // along the border
        3.522, // not shown by the picture
        2.673, // a stretch without edges
        -1.313, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        1.047, // unlike a longer one
        2.215, // small things alike
        2.377, // ends that go on
        1.584, // tips at a strand
        3.856, // tips that continue beyond a gap
        -0.226, // ends at the border
        1.579, // crossings
        1.242, // left out of the mask
        1.561, // seen in part
        -1.528, // surely seen by the network
        2.155, // seen by the network beyond its tips
    ],
    // Shadow
    [
        2.236, // constant
        5.492, // unevenness of the width
        6.414, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        0.000, // length in widths
        1.029, // thinness
        4.118, // bends
        0.000, // straight
        0.000, // an arc of a circle
        3.944, // straight or an arc, and flat
        0.000, // along the border
        1.736, // not shown by the picture
        0.000, // a stretch without edges
        -8.668, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        3.258, // unlike a longer one
        0.000, // small things alike
        2.356, // ends that go on
        1.544, // tips at a strand
        2.588, // tips that continue beyond a gap
        -1.587, // ends at the border
        1.430, // crossings
        1.697, // left out of the mask
        1.154, // seen in part
        -5.131, // surely seen by the network
        0.749, // seen by the network beyond its tips
    ],
    // Pen
    [
        1.301, // constant
        4.797, // unevenness of the width
        0.000, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        -8.391, // length in widths
        3.556, // thinness
        8.256, // bends
        1.784, // straight
        0.000, // an arc of a circle
        5.999, // straight or an arc, and flat
        0.000, // along the border
        0.000, // not shown by the picture
        0.000, // a stretch without edges
        0.000, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        3.071, // unlike a longer one
        0.000, // small things alike
        3.278, // ends that go on
        0.039, // tips at a strand
        1.377, // tips that continue beyond a gap
        -3.180, // ends at the border
        0.000, // crossings
        0.000, // left out of the mask
        1.347, // seen in part
        -0.951, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Mark
    [
        -2.462, // constant
        4.111, // unevenness of the width
        0.000, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        0.000, // length in widths
        6.141, // thinness
        4.324, // bends
        0.811, // straight
        0.000, // an arc of a circle
        5.182, // straight or an arc, and flat
        0.000, // along the border
        0.000, // not shown by the picture
        3.054, // a stretch without edges
        -2.522, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        4.586, // unlike a longer one
        0.000, // small things alike
        0.000, // ends that go on
        1.550, // tips at a strand
        4.476, // tips that continue beyond a gap
        0.653, // ends at the border
        0.000, // crossings
        0.000, // left out of the mask
        0.000, // seen in part
        -3.924, // surely seen by the network
        0.000, // seen by the network beyond its tips
    ],
    // Edge
    [
        -3.429, // constant
        0.000, // unevenness of the width
        0.000, // unlikeness of colour along the curve
        0.000, // unlikeness of the two sides
        0.000, // length in widths
        6.528, // thinness
        3.895, // bends
        4.956, // straight
        6.677, // an arc of a circle
        2.187, // straight or an arc, and flat
        0.000, // along the border
        0.000, // not shown by the picture
        0.116, // a stretch without edges
        -3.775, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        0.427, // unlike a longer one
        3.263, // small things alike
        0.000, // ends that go on
        0.000, // tips at a strand
        0.000, // tips that continue beyond a gap
        3.237, // ends at the border
        2.067, // crossings
        0.000, // left out of the mask
        1.573, // seen in part
        -3.284, // surely seen by the network
        1.344, // seen by the network beyond its tips
    ],
    // Rim
    [
        0.164, // constant
        9.027, // unevenness of the width
        6.901, // unlikeness of colour along the curve
        0.323, // unlikeness of the two sides
        -3.158, // length in widths
        4.019, // thinness
        0.000, // bends
        1.824, // straight
        6.900, // an arc of a circle
        0.700, // straight or an arc, and flat
        0.000, // along the border
        5.260, // not shown by the picture
        0.000, // a stretch without edges
        -8.595, // light and shade across it
        0.000, // the table in less light
        0.000, // a copy of the ropes in less light
        2.939, // unlike a longer one
        5.226, // small things alike
        2.195, // ends that go on
        0.722, // tips at a strand
        4.377, // tips that continue beyond a gap
        -2.334, // ends at the border
        0.000, // crossings
        0.000, // left out of the mask
        1.341, // seen in part
        0.000, // surely seen by the network
        0.811, // seen by the network beyond its tips
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
