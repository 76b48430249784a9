//! A picture, its maps, and the check that their sizes match.

use thiserror::Error;

/// A picture, or a rectangle of one.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Red, green and blue of each pixel, starting at the first row's first byte.
    pub rgb: &'a [u8],
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Bytes from the start of one row to the next.
    pub stride: usize,
}

/// Output maps, one byte per pixel, where 255 is certain.
#[derive(Debug)]
pub struct Maps<'a> {
    /// Probability of a rope.
    pub rope: &'a mut [u8],
    /// Probability of a seam between adjacent ropes.
    pub seam: &'a mut [u8],
    /// Bytes from the start of one row to the next, in both maps.
    pub stride: usize,
}

/// Reason why a picture or a map was refused.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum SizeError {
    /// A side is zero or too long.
    #[error("A picture of {width} × {height} pixels: give one with sides from 1 to {most}.")]
    Sides {
        /// Pixels per row.
        width: usize,
        /// Number of rows.
        height: usize,
        /// The longest side allowed.
        most: usize,
    },
    /// Rows overlap, or the buffer is too short.
    #[error(
        "{what} of {found} bytes, rows {stride} bytes apart, hold no {height} rows of {row} bytes: give at least {needed} bytes and rows that do not overlap."
    )]
    Memory {
        /// The picture or a map.
        what: &'static str,
        /// Bytes available.
        found: usize,
        /// Bytes from the start of one row to the next.
        stride: usize,
        /// Number of rows.
        height: usize,
        /// Bytes per row.
        row: usize,
        /// Bytes required.
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
