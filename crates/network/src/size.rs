//! A picture, its maps, and whether their sizes fit.

use thiserror::Error;

/// A picture, or a rectangle of one.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Red, green and blue of each pixel, from the first row's first byte on.
    pub rgb: &'a [u8],
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Bytes from one row's start to the next.
    pub stride: usize,
}

/// Where the maps go: a byte a pixel, 255 for certain.
#[derive(Debug)]
pub struct Maps<'a> {
    /// Whether there is a rope.
    pub rope: &'a mut [u8],
    /// Whether there is a seam between ropes that lie side by side.
    pub seam: &'a mut [u8],
    /// Bytes from one row's start to the next, of both.
    pub stride: usize,
}

/// Why there is no room, or nothing to look at.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum SizeError {
    /// No pixel, or too many.
    #[error("A picture of {width} × {height} pixels: give one with sides from 1 to {most}.")]
    Sides {
        /// Pixels of a row.
        width: usize,
        /// Rows.
        height: usize,
        /// The longest side.
        most: usize,
    },
    /// Rows overlap or end behind the memory.
    #[error(
        "{what} of {found} bytes, rows {stride} bytes apart, hold no {height} rows of {row} bytes: give at least {needed} bytes and rows that do not overlap."
    )]
    Memory {
        /// The picture or a map.
        what: &'static str,
        /// Bytes that there are.
        found: usize,
        /// Bytes from one row's start to the next.
        stride: usize,
        /// Rows.
        height: usize,
        /// Bytes of a row.
        row: usize,
        /// Bytes that are needed.
        needed: usize,
    },
}

/// The longest side of a picture.
const MOST: usize = 1 << 14;

pub(crate) fn check(picture: &Picture, maps: &Maps) -> Result<(), SizeError> {
    let Picture { width, height, .. } = *picture;
    if ![width, height].iter().all(|side| (1..=MOST).contains(side)) {
        return Err(SizeError::Sides {
            width,
            height,
            most: MOST,
        });
    }
    let memories = [
        ("A picture", picture.rgb.len(), picture.stride, 3 * width),
        ("A map", maps.rope.len(), maps.stride, width),
        ("A map", maps.seam.len(), maps.stride, width),
    ];
    for (what, found, stride, row) in memories {
        let needed = stride.saturating_mul(height - 1).saturating_add(row);
        if stride < row || found < needed {
            return Err(SizeError::Memory {
                what,
                found,
                stride,
                height,
                row,
                needed,
            });
        }
    }
    Ok(())
}
