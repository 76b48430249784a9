//! The trained network, ready to run.

use std::sync::{Arc, LazyLock};

use lariat_portable::{Convolution, ConvolutionKernels};

use crate::file::{self, NetworkError};
use crate::layers::LAYERS;
use crate::output;
use crate::run::Run;
use crate::size::{self, Maps, Picture, SizeError};
use crate::workspace::Workspace;

/// Trained parameters of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers {
    /// Weights, indexed by `((row · side + column) · inputs + input) · outputs + output`.
    pub weights: Vec<i8>,
    /// Bias of each output channel.
    pub bias: Vec<i32>,
    /// Scale of each output channel.
    pub scale: Vec<f32>,
}

/// A network with its weights.
#[derive(Clone, Debug)]
pub struct Network {
    numbers: Vec<Numbers>,
    /// Convolutions in the order of [`LAYERS`].
    pub(crate) convolutions: [Convolution; LAYERS.len()],
    /// Probability for each signed byte of the last layer.
    pub(crate) probabilities: [u8; 256],
}

impl Network {
    /// The picture's sides are padded to multiples of this.
    pub const MULTIPLE: usize = 16;

    /// Returns lariat's built-in network, trained on drawn ropes (see `bench/training/README.md`).
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

    /// Reads a network from the bytes of a file.
    ///
    /// # Errors
    ///
    /// Fails if the bytes are damaged, are not a file of this version and model, or contain numbers
    /// out of bounds.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, NetworkError> {
        Self::new(file::read(bytes)?)
    }

    /// Returns the bytes of the network's file.
    pub fn to_bytes(&self) -> Vec<u8> {
        file::write(&self.numbers)
    }

    /// Parameters of all [`LAYERS`], in their order.
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

    /// Computes both maps of a picture.
    ///
    /// # Errors
    ///
    /// Fails if the picture has no pixels, or if the buffer of the picture or of a map is too
    /// short.
    pub fn run(
        &self,
        workspace: &mut Workspace,
        picture: Picture,
        maps: Maps,
    ) -> Result<(), SizeError> {
        self.run_observed(ConvolutionKernels::new(), workspace, picture, maps, |_| ())
    }

    /// Runs like [`run`](Self::run) with the given kernels, and calls back after each step. The
    /// callback receives a layer's name, or `picture`, `skips` or `maps`. Used to measure, and to
    /// test that all kernels agree.
    ///
    /// # Errors
    ///
    /// Fails as [`run`](Self::run) does.
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
