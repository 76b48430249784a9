//! Turns a picture upright according to the EXIF orientation that cameras store with the pixels.

use image::metadata::Orientation;

/// Returns whether this orientation swaps width and height.
pub(crate) fn is_sideways(orientation: Orientation) -> bool {
    matches!(
        orientation,
        Orientation::Rotate90
            | Orientation::Rotate270
            | Orientation::Rotate90FlipH
            | Orientation::Rotate270FlipH
    )
}

/// Turns the picture `stored`, of `width` × `height` pixels with `channels` bytes each, into
/// `upright`, which has the same length.
pub(crate) fn turn(
    orientation: Orientation,
    stored: &[u8],
    (width, height): (usize, usize),
    channels: usize,
    upright: &mut [u8],
) {
    let columns = if is_sideways(orientation) {
        height
    } else {
        width
    };
    let (right, bottom) = (width.wrapping_sub(1), height.wrapping_sub(1));
    for (index, pixel) in upright.chunks_exact_mut(channels).enumerate() {
        let (x, y) = (index % columns, index / columns);
        let (x, y) = match orientation {
            Orientation::NoTransforms => (x, y),
            Orientation::FlipHorizontal => (right - x, y),
            Orientation::Rotate180 => (right - x, bottom - y),
            Orientation::FlipVertical => (x, bottom - y),
            Orientation::Rotate90FlipH => (y, x),
            Orientation::Rotate90 => (y, bottom - x),
            Orientation::Rotate270FlipH => (right - y, bottom - x),
            Orientation::Rotate270 => (right - y, x),
        };
        let from = (y * width + x) * channels;
        pixel.copy_from_slice(&stored[from..from + channels]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage, RgbImage};

    #[test]
    fn every_orientation_is_turned_as_the_image_crate_does() {
        let bytes: Vec<u8> = (0..7 * 4 * 3).collect();
        let grey = GrayImage::from_raw(7, 4, bytes[..28].to_vec()).unwrap();
        let color = RgbImage::from_raw(7, 4, bytes).unwrap();
        for (channels, picture) in [
            (1, DynamicImage::ImageLuma8(grey)),
            (3, DynamicImage::ImageRgb8(color)),
        ] {
            for orientation in (1..=8).filter_map(Orientation::from_exif) {
                let mut upright = vec![0; picture.as_bytes().len()];
                turn(
                    orientation,
                    picture.as_bytes(),
                    (7, 4),
                    channels,
                    &mut upright,
                );
                let mut expected = picture.clone();
                expected.apply_orientation(orientation);
                assert_eq!(upright, expected.as_bytes(), "{orientation:?}");
                assert_eq!(is_sideways(orientation), expected.width() == 4);
            }
        }
    }
}
