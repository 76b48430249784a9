//! Reads and writes the weights file. The reader trusts nothing in the file. The crate's front page
//! describes the layout.

use lariat_portable::{ConvolutionError, ConvolutionShape};
use thiserror::Error;

use crate::layers::LAYERS;
use crate::network::Numbers;
use crc32fast::hash as crc32;

const MAGIC: &[u8; 8] = b"LARIATN1";
const VERSION: u32 = 1;

/// Reason why bytes were rejected as a network.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum NetworkError {
    /// The file does not begin with the magic bytes.
    #[error(
        "These are not weights of lariat's network, which begin with LARIATN1: give the file that training has written."
    )]
    Magic,
    /// This lariat cannot read the file's version.
    #[error(
        "The weights are of version {0}, and this lariat reads version 1: take the lariat that they were made for, or train again."
    )]
    Version(u32),
    /// The checksum does not match the bytes.
    #[error(
        "The weights are damaged or cut off: their check sum is not that of their bytes. Copy the file again."
    )]
    Damaged,
    /// The layers differ from this network's.
    #[error(
        "The weights are those of another network: {found} where this lariat has {expected}. Train with the model of this version."
    )]
    Model {
        /// The model in the file.
        found: String,
        /// The expected model.
        expected: String,
    },
    /// A layer's numbers are out of bounds.
    #[error("Layer {layer} cannot be computed. {error}")]
    Numbers {
        /// The layer's name.
        layer: &'static str,
        /// The cause.
        error: ConvolutionError,
    },
}

/// Reads the numbers of each layer.
pub(crate) fn read(bytes: &[u8]) -> Result<Vec<Numbers>, NetworkError> {
    let behind_magic = bytes.strip_prefix(MAGIC).ok_or(NetworkError::Magic)?;
    let version = Rest(behind_magic).u32().ok_or(NetworkError::Damaged)?;
    if version != VERSION {
        return Err(NetworkError::Version(version));
    }
    let (checked, sum) = bytes.split_last_chunk().ok_or(NetworkError::Damaged)?;
    if u32::from_le_bytes(*sum) != crc32(checked) {
        return Err(NetworkError::Damaged);
    }
    let mut rest = Rest(checked.get(12..).ok_or(NetworkError::Damaged)?);
    let count = rest.u32().ok_or(NetworkError::Damaged)?;
    if count as usize != LAYERS.len() {
        return Err(model(
            format!("{count} layers"),
            format!("{} of them", LAYERS.len()),
        ));
    }
    let mut numbers = Vec::new();
    for layer in &LAYERS {
        let shape = rest.shape().ok_or(NetworkError::Damaged)?;
        if shape != Some(layer.shape) {
            let found = shape.map_or_else(|| "something else".to_owned(), words);
            return Err(model(
                found,
                format!("{} ({})", words(layer.shape), layer.name),
            ));
        }
        numbers.push(rest.numbers(layer.shape).ok_or(NetworkError::Damaged)?);
    }
    if !rest.0.is_empty() {
        let found = format!("{} bytes behind the last layer", rest.0.len());
        return Err(model(found, "none".to_owned()));
    }
    Ok(numbers)
}

fn model(found: String, expected: String) -> NetworkError {
    NetworkError::Model { found, expected }
}

fn words(shape: ConvolutionShape) -> String {
    let ConvolutionShape {
        in_channels,
        out_channels,
        side,
        stride,
        dilation,
    } = shape;
    format!(
        "{side}×{side} from {in_channels} to {out_channels} channels, stride {stride}, dilation {dilation}"
    )
}

/// Returns the bytes of a file.
pub(crate) fn write(numbers: &[Numbers]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((LAYERS.len() as u32).to_le_bytes());
    for (layer, numbers) in LAYERS.iter().zip(numbers) {
        let shape = layer.shape;
        bytes.extend((shape.in_channels as u16).to_le_bytes());
        bytes.extend((shape.out_channels as u16).to_le_bytes());
        bytes.extend([
            shape.side as u8,
            shape.stride as u8,
            shape.dilation as u8,
            0,
        ]);
        bytes.extend(numbers.weights.iter().map(|w| w.cast_unsigned()));
        bytes.extend(numbers.bias.iter().flat_map(|b| b.to_le_bytes()));
        bytes.extend(numbers.scale.iter().flat_map(|s| s.to_le_bytes()));
    }
    bytes.extend(crc32(&bytes).to_le_bytes());
    bytes
}

/// The bytes not yet read.
struct Rest<'a>(&'a [u8]);

impl Rest<'_> {
    fn take(&mut self, count: usize) -> Option<&[u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(*self.take(4)?.first_chunk()?))
    }

    /// Reads a layer's shape. Returns `Some(None)` if its last byte is not 0.
    fn shape(&mut self) -> Option<Option<ConvolutionShape>> {
        let &[a, b, c, d, side, stride, dilation, zero] = self.take(8)?.first_chunk()?;
        let shape = ConvolutionShape {
            in_channels: usize::from(u16::from_le_bytes([a, b])),
            out_channels: usize::from(u16::from_le_bytes([c, d])),
            side: usize::from(side),
            stride: usize::from(stride),
            dilation: usize::from(dilation),
        };
        Some((zero == 0).then_some(shape))
    }

    /// Reads the numbers of a layer, given its shape from the table.
    fn numbers(&mut self, shape: ConvolutionShape) -> Option<Numbers> {
        let weights = shape.side * shape.side * shape.in_channels * shape.out_channels;
        let weights = self
            .take(weights)?
            .iter()
            .map(|b| b.cast_signed())
            .collect();
        let mut fours = || {
            let bytes = self.take(4 * shape.out_channels)?;
            Some(bytes.as_chunks::<4>().0.to_vec())
        };
        let (bias, scale) = (fours()?, fours()?);
        Some(Numbers {
            weights,
            bias: bias.into_iter().map(i32::from_le_bytes).collect(),
            scale: scale.into_iter().map(f32::from_le_bytes).collect(),
        })
    }
}
