//! A picture that assigns each pixel to a rope or to the table.

use std::path::Path;

use anyhow::{Result, bail};
use image::DynamicImage;

use super::photo;

/// The rope number of each pixel, row by row. 0 is the table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Labels {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) ropes: Vec<u8>,
}

impl Labels {
    /// Returns a picture of the table alone.
    pub(super) fn empty(width: usize, height: usize) -> Self {
        let ropes = vec![0; width * height];
        Self {
            width,
            height,
            ropes,
        }
    }

    /// Reads a label picture.
    ///
    /// # Errors
    /// The picture cannot be read, or is not 8-bit gray.
    pub(super) fn load(path: &Path) -> Result<Self> {
        let DynamicImage::ImageLuma8(picture) = photo::load(path)? else {
            bail!(
                "{} is not a label: its pixels must be 8-bit grey, 0 for the table and 1… for the ropes",
                path.display()
            );
        };
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        Ok(Self {
            width,
            height,
            ropes: picture.into_raw(),
        })
    }

    /// Returns the numbers of the ropes in ascending order.
    pub(super) fn numbers(&self) -> Vec<u8> {
        let mut is_seen = [false; 256];
        for &rope in &self.ropes {
            is_seen[usize::from(rope)] = true;
        }
        (1..=255).filter(|&n| is_seen[usize::from(n)]).collect()
    }

    /// Returns the number of pixels that belong to ropes.
    pub(super) fn area(&self) -> usize {
        self.ropes.iter().filter(|&&rope| rope != 0).count()
    }

    /// Returns the rope at column x, row y. Outside the picture, returns 0.
    pub(super) fn at(&self, x: i64, y: i64) -> u8 {
        let inside = (0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y);
        if inside {
            self.ropes[y as usize * self.width + x as usize]
        } else {
            0
        }
    }
}
