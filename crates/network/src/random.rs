//! Untrained networks with random weights.

use lariat_portable::SplitMix64;

use crate::layers::LAYERS;
use crate::network::{Network, Numbers};

impl Network {
    /// Creates a network with random weights whose activations are neither all 0 nor all 127. It is
    /// for tests and measurements and cannot find ropes.
    pub fn random(seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let numbers = LAYERS.map(|layer| {
            let outs = layer.shape.out_channels;
            let weights = Vec::from_iter(
                (0..layer.weights()).map(|_| (random.below(255) as i32 - 127) as i8),
            );
            // A sum of n products has a standard deviation of 73·√n times the activations' size,
            // where 73 is the standard deviation of the weights.
            let products = (layer.weights() / outs) as f32;
            let scale = 1.0 / (73.0 * products.sqrt());
            Numbers {
                weights,
                bias: (0..outs)
                    .map(|_| (random.uniform_f32(-10.0, 30.0) / scale) as i32)
                    .collect(),
                scale: (0..outs)
                    .map(|_| scale * random.uniform_f32(0.7, 1.3))
                    .collect(),
            }
        });
        Self::new(numbers.into()).expect("the numbers are within bounds")
    }
}
