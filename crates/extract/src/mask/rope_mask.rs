//! The result of the step: a mask with its origin.

use super::cast::Cast;
use crate::bitmap::bits::BitPlane;
use crate::bitmap::strips::{Shape, Strips};
use crate::image::gray::GrayPlane;
use crate::notice::Notice;
use std::ops::Range;

/// Origin of a mask.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum MaskSource {
    /// The pixels that differ from the table.
    Table {
        /// Minimum difference of a rope pixel.
        cut: u8,
        /// True if the picture was smoothed first, because noise hides the ropes in single pixels.
        is_smoothed: bool,
    },
    /// The pixels whose color is in the user's ranges.
    Color,
    /// The network, asked by the automatic mask or by the user.
    Network,
    /// Another program.
    #[default]
    External,
}

impl MaskSource {
    /// True if the mask is made of how the image differs from the table.
    pub(crate) fn is_table(self) -> bool {
        matches!(self, Self::Table { .. })
    }

    /// True if the mask was requested from the network.
    pub(crate) fn is_network(self) -> bool {
        self == Self::Network
    }

    /// True if the mask shows only ropes, and nothing that lies on them.
    pub(crate) fn is_of_ropes_alone(self) -> bool {
        matches!(self, Self::Network | Self::External)
    }

    /// True if the user chose the ropes' pixels, by color or by another program.
    pub(crate) fn is_of_user(self) -> bool {
        matches!(self, Self::Color | Self::External)
    }
}

/// A mask of the ropes in an image.
#[derive(Debug, Default)]
pub(crate) struct RopeMask {
    pub(crate) source: MaskSource,
    /// Difference of each pixel from the table. With color ranges, it is 255 and 0; from the
    /// network or another program, it is the mask's own bytes. It is 0 where nothing within eight
    /// pixels exceeds the table's noise, unless the mask is in doubt.
    pub(crate) difference: GrayPlane,
    /// One bit per pixel, row by row and in strips.
    pub(crate) bits: BitPlane,
    pub(crate) strips: Strips,
    /// The rope's width in pixels, estimated from the area and outline of the mask.
    pub(crate) width_px: f32,
    /// Columns and rows that contain everything that differs from the table, before anything is
    /// removed.
    pub(super) differs: Option<[Range<usize>; 2]>,
    /// State of the ropes' own shadow in the mask.
    pub(crate) cast: Cast,
    /// Doubt about the mask, if any.
    pub(crate) notice: Option<Notice>,
}

impl RopeMask {
    /// True if nothing is rope.
    pub(crate) fn is_empty(&self) -> bool {
        self.strips.used.is_empty()
    }

    /// Removes all pixels.
    pub(super) fn empty(&mut self) {
        self.bits.resize(self.bits.width(), self.bits.height());
        self.strips.resize(&Shape::of(&self.bits));
    }

    /// Reserves the memory of a mask of this size.
    pub(crate) fn reserve(&mut self, width: usize, height: usize) {
        self.difference.resize(width, height);
        self.bits.resize(width, height);
        self.strips.resize(&Shape::of(&self.bits));
    }
}
