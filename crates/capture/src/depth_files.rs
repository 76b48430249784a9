//! Depth images beside the pictures of a folder: PNG or TIFF of 16 bits a pixel, one for each picture, in the same order.

use std::fs::File;
use std::io::{Cursor, Read};
use std::path::PathBuf;

use image::{ColorType, ImageDecoder, ImageReader};

use crate::open::FileOptions;
use crate::picture::LARGEST_BYTES;
use crate::pictures::chosen;
use crate::source::SourceError;

/// Depth images as files.
#[derive(Debug)]
pub struct DepthFiles {
    files: Vec<PathBuf>,
    looped: bool,
    size: [u32; 2],
    file: Vec<u8>,
}

impl DepthFiles {
    /// Finds them: files and folders in the order given, a folder's in natural order, and of them the same part as of the pictures.
    ///
    /// # Errors
    /// A path that does not exist, a folder without pictures, or no depth image in the first file.
    pub fn open(paths: &[PathBuf], options: &FileOptions) -> Result<Self, SourceError> {
        let (files, _) = chosen(paths, options)?;
        let mut images = Self {
            files,
            looped: options.looped,
            size: [0; 2],
            file: Vec::new(),
        };
        let broken = |reason| SourceError::Picture { reason };
        images.size = images.decode(0, None).map_err(broken)?;
        Ok(images)
    }

    /// Width and height of the first.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Bytes of each.
    pub fn bytes(&self) -> usize {
        2 * self.size[0] as usize * self.size[1] as usize
    }

    /// Writes the depth image of the picture of this number, from 1: whole numbers of 16 bits in the machine's own order.
    ///
    /// # Errors
    /// A sentence: there is none, it cannot be decoded, or has another size than the first.
    pub fn write(&mut self, sequence: u64, pixels: &mut [u8]) -> Result<(), String> {
        let count = self.files.len() as u64;
        let place = sequence.saturating_sub(1);
        let place = if self.looped { place % count } else { place };
        if place >= count {
            return Err(format!(
                "picture {sequence} has no depth image: there are only {count}"
            ));
        }
        self.decode(place as usize, Some(pixels)).map(|_| ())
    }

    /// Its size; and its pixels, where they are wanted.
    fn decode(&mut self, place: usize, pixels: Option<&mut [u8]>) -> Result<[u32; 2], String> {
        let path = &self.files[place];
        let broken = |why: String| format!("the depth image {} {why}", path.display());
        let cannot = |error: &dyn std::fmt::Display| broken(format!("cannot be decoded ({error})"));
        self.file.clear();
        File::open(path)
            .and_then(|open| open.take(LARGEST_BYTES).read_to_end(&mut self.file))
            .map_err(|error| cannot(&error))?;
        let reader = ImageReader::new(Cursor::new(&self.file[..])).with_guessed_format();
        let reader = reader.map_err(|error| cannot(&error))?;
        let decoder = reader.into_decoder().map_err(|error| cannot(&error))?;
        if decoder.color_type() != ColorType::L16 {
            return Err(broken(format!(
                "has {:?} pixels, not one number of 16 bits each",
                decoder.color_type()
            )));
        }
        let (width, height) = decoder.dimensions();
        let Some(pixels) = pixels else {
            return Ok([width, height]);
        };
        if [width, height] != self.size {
            let [first, second] = self.size;
            return Err(broken(format!(
                "has {width}×{height} pixels, and the first has {first}×{second}"
            )));
        }
        decoder.read_image(pixels).map_err(|error| cannot(&error))?;
        Ok([width, height])
    }
}
