//! The model as a table of layers.

use lariat_portable::{ConvolutionShape, Finish};

use crate::Network;

/// A layer of the network.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// The layer's name.
    pub name: &'static str,
    /// The convolution's shape.
    pub shape: ConvolutionShape,
    /// The function that turns sums into outputs.
    pub finish: Finish,
    /// Downsampling of the output: one output pixel covers `scale` × `scale` picture pixels.
    pub scale: usize,
}

impl Layer {
    /// Returns the number of weights.
    pub const fn weights(&self) -> usize {
        let shape = &self.shape;
        shape.side * shape.side * shape.in_channels * shape.out_channels
    }

    /// Returns the number of multiply-adds for a picture of this size.
    pub fn multiply_adds(&self, width: usize, height: usize) -> u64 {
        let pixels = |size: usize| size.next_multiple_of(Network::MULTIPLE) / self.scale;
        (pixels(width) * pixels(height) * self.weights()) as u64
    }
}

const fn layer(
    name: &'static str,
    [in_channels, out_channels]: [usize; 2],
    [side, stride, dilation]: [usize; 3],
    finish: Finish,
    scale: usize,
) -> Layer {
    let shape = ConvolutionShape {
        in_channels,
        out_channels,
        side,
        stride,
        dilation,
    };
    Layer {
        name,
        shape,
        finish,
        scale,
    }
}

/// All layers, in the order of the file and of computation.
pub const LAYERS: [Layer; 15] = {
    use Finish::{Relu, Signed};
    [
        layer("stem", [3, 16], [3, 2, 1], Relu, 2),
        layer("d1", [16, 32], [3, 2, 1], Relu, 4),
        layer("d2", [32, 48], [3, 2, 1], Relu, 8),
        layer("e2a", [48, 48], [3, 1, 1], Relu, 8),
        layer("e2b", [48, 48], [3, 1, 1], Relu, 8),
        layer("d3", [48, 64], [3, 2, 1], Relu, 16),
        layer("e3a", [64, 64], [3, 1, 2], Relu, 16),
        layer("e3b", [64, 64], [3, 1, 1], Relu, 16),
        layer("e3c", [64, 64], [3, 1, 4], Relu, 16),
        layer("e3d", [64, 64], [3, 1, 1], Relu, 16),
        layer("u2", [64, 48], [1, 1, 1], Signed, 16),
        layer("f2", [48, 48], [3, 1, 1], Relu, 8),
        layer("u1", [48, 32], [1, 1, 1], Signed, 8),
        layer("f1", [32, 32], [3, 1, 1], Relu, 4),
        layer("out", [32, 32], [1, 1, 1], Signed, 4),
    ]
};

/// A layer's index in [`LAYERS`].
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    Stem,
    D1,
    D2,
    E2a,
    E2b,
    D3,
    E3a,
    E3b,
    E3c,
    E3d,
    U2,
    F2,
    U1,
    F1,
    Out,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_the_table() {
        use Place::*;
        let places = [
            Stem, D1, D2, E2a, E2b, D3, E3a, E3b, E3c, E3d, U2, F2, U1, F1, Out,
        ];
        for (at, (place, layer)) in places.iter().zip(&LAYERS).enumerate() {
            assert_eq!(*place as usize, at);
            assert_eq!(format!("{place:?}").to_lowercase(), layer.name);
        }
        assert_eq!(places.len(), LAYERS.len());
    }

    #[test]
    fn a_picture_of_640_by_480_takes_905_million_multiply_adds() {
        let all = LAYERS.iter().map(|layer| layer.multiply_adds(640, 480));
        assert_eq!(all.sum::<u64>(), 904_396_800);
        // A side that is not a multiple of 16 is rounded up to one.
        assert_eq!(LAYERS[0].multiply_adds(1, 17), 8 * 16 * 432);
    }
}
