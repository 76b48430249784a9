//! The network: what it has learned, ready to run.

use std::sync::{Arc, LazyLock};

use lariat_portable::{Convolution, ConvolutionKernels};

use crate::file::{self, NetworkError};
use crate::layers::LAYERS;
use crate::output;
use crate::run::Run;
use crate::size::{self, Maps, Picture, SizeError};
use crate::workspace::Workspace;

/// What a layer has learned.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers {
    /// `((row · side + column) · inputs + input) · outputs + output`.
    pub weights: Vec<i8>,
    /// Of each output channel.
    pub bias: Vec<i32>,
    /// Of each output channel.
    pub scale: Vec<f32>,
}

/// A network with its weights.
#[derive(Clone, Debug)]
pub struct Network {
    numbers: Vec<Numbers>,
    /// In the order of [`LAYERS`].
    pub(crate) convolutions: [Convolution; LAYERS.len()],
    /// Of each signed byte of the last layer.
    pub(crate) probabilities: [u8; 256],
}

impl Network {
    /// The picture's sides are filled up to multiples of it.
    pub const MULTIPLE: usize = 16;

    /// The one that lariat brings along: trained on drawn ropes, as `bench/training/README.md` says.
    pub fn ropes() -> Arc<Self> {
        static ROPES: LazyLock<Arc<Network>> = LazyLock::new(|| {
            let bytes = include_bytes!("../ropes.weights");
            Arc::new(
                Network::from_bytes(bytes)
                    .expect("the weights are those of this model: a test reads them"),
            )
        });
        Arc::clone(&ROPES)
    }

    /// From the bytes of a file.
    ///
    /// # Errors
    ///
    /// Where they are not a file of this version, undamaged, of this model, with numbers in their bounds.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, NetworkError> {
        Self::new(file::read(bytes)?)
    }

    /// The bytes of its file.
    pub fn to_bytes(&self) -> Vec<u8> {
        file::write(&self.numbers)
    }

    /// Of all [`LAYERS`], in their order.
    pub fn numbers(&self) -> &[Numbers] {
        &self.numbers
    }

    pub(crate) fn new(numbers: Vec<Numbers>) -> Result<Self, NetworkError> {
        let mut convolutions = Vec::new();
        for (layer, of) in LAYERS.iter().zip(&numbers) {
            let made =
                Convolution::new(layer.shape, &of.weights, &of.bias, &of.scale, layer.finish);
            let name = layer.name;
            convolutions.push(made.map_err(|error| NetworkError::Numbers { layer: name, error })?);
        }
        Ok(Self {
            numbers,
            convolutions: convolutions.try_into().expect("one for each layer"),
            probabilities: output::probabilities(),
        })
    }

    /// Looks at a picture.
    ///
    /// # Errors
    ///
    /// Where the picture has no pixel or its rows, or those of a map, are not all there.
    pub fn run(
        &self,
        workspace: &mut Workspace,
        picture: Picture,
        maps: Maps,
    ) -> Result<(), SizeError> {
        self.run_observed(ConvolutionKernels::new(), workspace, picture, maps, |_| ())
    }

    /// As [`run`](Self::run), by these kernels, and tells after each piece of work which it was: a layer's name, or `picture`,
    /// `skips`, `maps`. For measuring, and for tests that hold kernels equal.
    ///
    /// # Errors
    ///
    /// As [`run`](Self::run).
    pub fn run_observed(
        &self,
        kernels: ConvolutionKernels,
        workspace: &mut Workspace,
        picture: Picture,
        maps: Maps,
        done: impl FnMut(&'static str),
    ) -> Result<(), SizeError> {
        size::check(&picture, &maps)?;
        workspace.reserve(picture.width, picture.height);
        let mut run = Run::new(self, kernels, done);
        run.down(workspace, picture);
        run.deep(workspace);
        run.up(workspace, picture, maps);
        Ok(())
    }
}
