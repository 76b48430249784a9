//! Depth images for the pictures of a folder: 16-bit PNG or TIFF files, paired by name
//! ([`depth_pairs`](crate::depth_pairs)).

use std::io::Cursor;
use std::path::PathBuf;

use image::{ColorType, ImageDecoder, ImageReader};

use crate::depth_pairs::{By, pair};
use crate::open::FileOptions;
use crate::picture::read_file;
use crate::pictures::{listed, selected};
use crate::source::SourceError;

/// Depth images that can be read from files.
pub const READ: [[&str; 2]; 2] = [
    [
        "PNG, TIFF (where it is built in)",
        "one whole number of 16 bits a pixel, `depth_unit_mm` each; 0 is not measured",
    ],
    [
        "pairing with pictures",
        "by the number or the time in the names of both, otherwise by order; a notice says which",
    ],
];

/// Depth images in files.
#[derive(Debug)]
pub struct DepthFiles {
    files: Vec<PathBuf>,
    /// Name of each picture that is shown, and the index of its depth image in `files`.
    pictures: Vec<(PathBuf, Option<usize>)>,
    notice: String,
    looped: bool,
    size: [u32; 2],
    file: Vec<u8>,
}

impl DepthFiles {
    /// Finds the depth images of these pictures. Files and folders come in the given order, and a
    /// folder's files in natural order. The options select which of the pictures are shown.
    ///
    /// # Errors
    /// A path that does not exist, a folder without pictures, names that contradict each other, or
    /// a first file without a depth image.
    pub fn open(
        paths: &[PathBuf],
        pictures: &[PathBuf],
        options: &FileOptions,
    ) -> Result<Self, SourceError> {
        let broken = |reason| SourceError::Picture { reason };
        let (files, left_out) = listed(paths)?;
        let (pictures, _) = listed(pictures)?;
        let (of, by) = pair(&pictures, &files).map_err(broken)?;
        let frames = options.range.frames(options.fps)?;
        let pictures = selected(pictures.into_iter().zip(of).collect(), frames)?;
        let mut images = Self {
            notice: notice(by, &pictures, left_out),
            files,
            pictures,
            looped: options.looped,
            size: [0; 2],
            file: Vec::new(),
        };
        images.size = images.decode(0, None).map_err(broken)?;
        Ok(images)
    }

    /// A sentence that says how depth images and pictures were paired.
    pub fn notice(&self) -> &str {
        &self.notice
    }

    /// Width and height of the first depth image, in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Size of each depth image, in bytes.
    pub fn bytes(&self) -> usize {
        2 * self.size[0] as usize * self.size[1] as usize
    }

    /// Writes the depth image of the picture with this number, from 1, as native-endian 16-bit
    /// integers.
    ///
    /// # Errors
    /// A sentence: the image is missing, cannot be decoded, shows nothing, or differs in size from
    /// the first.
    pub fn write(&mut self, sequence: u64, pixels: &mut [u8]) -> Result<(), String> {
        let count = self.pictures.len() as u64;
        let place = sequence.saturating_sub(1);
        let place = if self.looped { place % count } else { place };
        let picture = usize::try_from(place)
            .ok()
            .and_then(|place| self.pictures.get(place));
        let Some((name, image)) = picture else {
            return Err(format!(
                "there are only {count} pictures, and none is the {sequence}th"
            ));
        };
        let Some(image) = *image else {
            let name = name.display();
            return Err(format!(
                "the picture {name} (frame {sequence}) has no depth image"
            ));
        };
        self.decode(image, Some(pixels))?;
        let mut depths = pixels.chunks_exact(2);
        let first = depths.next();
        if depths.all(|depth| Some(depth) == first) {
            let value = first.map_or(0, |pair| u16::from_ne_bytes([pair[0], pair[1]]));
            return Err(format!(
                "the depth image {} shows nothing: all its pixels are {value}",
                self.files[image].display()
            ));
        }
        Ok(())
    }

    /// Returns the size of a depth image, and decodes it if `pixels` is given.
    fn decode(&mut self, place: usize, pixels: Option<&mut [u8]>) -> Result<[u32; 2], String> {
        let path = &self.files[place];
        let broken = |why: String| format!("the depth image {} {why}", path.display());
        let cannot = |error: &dyn std::fmt::Display| broken(format!("cannot be decoded ({error})"));
        self.file.clear();
        read_file(path, &mut self.file).map_err(|error| cannot(&error))?;
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

fn notice(by: By, pictures: &[(PathBuf, Option<usize>)], left_out: Vec<String>) -> String {
    let with = pictures.iter().filter(|(_, image)| image.is_some()).count();
    let how = match by {
        By::Number => "by the number in their names",
        By::Time => "by the time in their names",
        By::Order => "by their order, as their names have no number or time in common",
    };
    let mut notice = format!(
        "depth images are paired with pictures {how}: {with} of {} pictures have one",
        pictures.len()
    );
    for sentence in left_out {
        notice.push_str("; ");
        notice.push_str(&sentence);
    }
    notice
}
