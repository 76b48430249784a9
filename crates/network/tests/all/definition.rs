//! The network against its definition, written for clarity rather than speed: whole pictures, with
//! a bounds check for every pixel of a window.

use std::collections::HashMap;

use lariat_network::{LAYERS, Layer, Network, Numbers, Workspace};
use lariat_portable::Finish;

use crate::picture::{draw, maps};

/// Activations by channel, column and row. Pixels outside are `outside`.
#[derive(Clone)]
struct Picture {
    size: [usize; 2],
    channels: usize,
    values: Vec<i32>,
    outside: i32,
}

impl Picture {
    fn new(size: [usize; 2], channels: usize, value: impl Fn(usize, usize, usize) -> i32) -> Self {
        let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        let places = places.flat_map(|(x, y)| (0..channels).map(move |c| (x, y, c)));
        Self {
            size,
            channels,
            values: places.map(|(x, y, c)| value(x, y, c)).collect(),
            outside: 0,
        }
    }

    fn at(&self, x: isize, y: isize, channel: usize) -> i32 {
        let [width, height] = self.size.map(|s| s as isize);
        if (0..width).contains(&x) && (0..height).contains(&y) {
            self.values[(y * width + x) as usize * self.channels + channel]
        } else {
            self.outside
        }
    }
}

fn convolved(input: &Picture, layer: &Layer, numbers: &Numbers) -> Picture {
    let shape = layer.shape;
    let before = if shape.side == 3 && shape.stride == 1 {
        shape.dilation as isize
    } else {
        0
    };
    let size = input.size.map(|s| s / shape.stride);
    Picture::new(size, shape.out_channels, |x, y, o| {
        let mut sum = numbers.bias[o];
        for (ky, kx) in (0..shape.side).flat_map(|ky| (0..shape.side).map(move |kx| (ky, kx))) {
            let at = |place: usize, k: usize| {
                (place * shape.stride + k * shape.dilation) as isize - before
            };
            for i in 0..shape.in_channels {
                let tap = (ky * shape.side + kx) * shape.in_channels + i;
                let weight = i32::from(numbers.weights[tap * shape.out_channels + o]);
                sum += weight * input.at(at(x, kx), at(y, ky), i);
            }
        }
        let value = (sum as f32 * numbers.scale[o]).round_ties_even() as i32;
        match layer.finish {
            Finish::Relu => value,
            Finish::Signed => value.clamp(-128, 127),
        }
    })
}

fn activated(sums: Picture, residual: Option<&Picture>, shrunk: usize) -> Picture {
    Picture::new(sums.size, sums.channels, |x, y, c| {
        let add = residual.map_or(0, |r| r.at((x / shrunk) as isize, (y / shrunk) as isize, c));
        (sums.at(x as isize, y as isize, c) + add).clamp(0, 127)
    })
}

fn expected(network: &Network, rgb: &[u8], [width, height]: [usize; 2]) -> [Vec<u8>; 2] {
    let numbers: HashMap<_, _> = LAYERS
        .iter()
        .map(|l| l.name)
        .zip(network.numbers())
        .collect();
    let layers: HashMap<_, _> = LAYERS.iter().map(|l| (l.name, l)).collect();
    let sums = |name: &str, input: &Picture| convolved(input, layers[name], numbers[name]);
    let plain = |name: &str, input: &Picture| activated(sums(name, input), None, 1);
    let size = [width, height].map(|s| s.next_multiple_of(16));
    let mut input = Picture::new(size, 3, |x, y, c| {
        if x < width && y < height {
            i32::from(rgb[3 * (y * width + x) + c] >> 1)
        } else {
            64
        }
    });
    input.outside = 64;
    let b = plain("d1", &plain("stem", &input));
    let d2 = plain("d2", &b);
    let d = activated(sums("e2b", &plain("e2a", &d2)), Some(&d2), 1);
    let d3 = plain("d3", &d);
    let e3b = activated(sums("e3b", &plain("e3a", &d3)), Some(&d3), 1);
    let e3d = activated(sums("e3d", &plain("e3c", &e3b)), Some(&e3b), 1);
    let f2 = plain("f2", &activated(d, Some(&sums("u2", &e3d)), 2));
    let f1 = plain("f1", &activated(b, Some(&sums("u1", &f2)), 2));
    let out = sums("out", &f1);
    [0, 1].map(|map| {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let bytes = places.map(|(x, y)| {
            let channel = 16 * map + 4 * (y % 4) + x % 4;
            let logit = f64::from(out.at((x / 4) as isize, (y / 4) as isize, channel)) / 16.0;
            (255.0 / (1.0 + libm::exp(-logit))).round() as u8
        });
        bytes.collect()
    })
}

#[test]
fn the_maps_are_those_of_the_definition() {
    let mut workspace = Workspace::new();
    for (seed, size) in [[64, 48], [1, 1], [17, 33], [50, 16], [3, 70]]
        .into_iter()
        .enumerate()
    {
        let network = Network::random(seed as u64);
        let rgb = draw(size[0], size[1], seed as u64);
        let found = maps(&network, &mut workspace, &rgb, size);
        let expected = expected(&network, &rgb, size);
        assert!(found == expected, "{size:?}");
        // The output of the random network is not trivial.
        let told = found
            .iter()
            .flatten()
            .filter(|b| (1..255).contains(*b))
            .count();
        assert!(told * 20 > 2 * size[0] * size[1], "{told} of {size:?}");
    }
}
