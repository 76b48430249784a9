//! Pictures in other formats: WebP, TIFF and BMP.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use image::codecs::webp::WebPEncoder;
use image::{
    DynamicImage, ExtendedColorType, GrayImage, ImageBuffer, ImageEncoder, Luma, Rgb, RgbImage,
    Rgba, RgbaImage,
};
use lariat_capture::{PICTURES, StillPicture, names_a_picture};
use lariat_message::PixelFormat;
use tempfile::TempDir;

const ENDINGS: [&str; 4] = ["webp", "tif", "tiff", "bmp"];

fn folder() -> TempDir {
    TempDir::new().expect("the system has a folder for temporary files")
}

fn colors() -> RgbImage {
    RgbImage::from_fn(33, 17, |x, y| Rgb([(7 * x) as u8, (9 * y) as u8, 90]))
}

fn saved(folder: &TempDir, ending: &str, picture: impl Into<DynamicImage>) -> PathBuf {
    let path = folder.path().join(format!("picture.{ending}"));
    picture.into().save(&path).expect("it is written");
    path
}

fn load(path: &Path) -> StillPicture {
    StillPicture::load(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn colors_come_through_exactly_in_every_kind() {
    for ending in ENDINGS {
        let folder = folder();
        let path = saved(&folder, ending, colors());
        assert!(names_a_picture(&path), "{ending} of {PICTURES}");
        let picture = load(&path);
        assert_eq!((picture.width, picture.height), (33, 17));
        assert_eq!(picture.format, PixelFormat::Rgb8, "{ending}");
        assert_eq!(picture.pixels, colors().into_raw(), "{ending}");
    }
}

#[test]
fn alpha_is_left_out_and_what_a_file_is_tells_its_beginning() {
    for ending in ENDINGS {
        let folder = folder();
        let clear = RgbaImage::from_fn(9, 5, |x, y| Rgba([x as u8, y as u8, 7, (20 * x) as u8]));
        let path = saved(&folder, ending, clear);
        let renamed = folder.path().join("picture.png");
        fs::rename(path, &renamed).unwrap();
        let expected: Vec<u8> = (0..45).flat_map(|i| [i % 9, i / 9, 7]).collect();
        assert_eq!(load(&renamed).pixels, expected, "{ending}");
    }
}

#[test]
fn gray_of_16_bits_in_a_tiff_becomes_the_nearest_of_8() {
    let folder = folder();
    let gray = GrayImage::from_fn(8, 3, |x, y| Luma([(31 * x + y) as u8]));
    let picture = load(&saved(&folder, "tif", gray.clone()));
    assert_eq!(picture.format, PixelFormat::Gray8);
    assert_eq!(picture.pixels, gray.clone().into_raw());
    let wide: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_fn(8, 3, |x, y| {
        Luma([u16::from(gray.get_pixel(x, y).0[0]) * 257 + 100])
    });
    let picture = load(&saved(&folder, "tiff", DynamicImage::ImageLuma16(wide)));
    assert_eq!(picture.pixels, gray.into_raw());
}

/// An EXIF entry with the picture's orientation (CIPA DC-008: one TIFF entry, 0x0112).
fn note(orientation: u8) -> Vec<u8> {
    let mut tiff = b"MM\0*\0\0\0\x08".to_vec();
    tiff.extend([0, 1, 0x01, 0x12, 0, 3, 0, 0, 0, 1, 0, orientation, 0, 0]);
    tiff.extend([0; 4]);
    tiff
}

#[test]
fn a_webp_taken_sideways_is_shown_upright() {
    let folder = folder();
    let path = folder.path().join("sideways.webp");
    let lying = colors();
    let mut encoder = WebPEncoder::new_lossless(File::create(&path).unwrap());
    encoder
        .set_exif_metadata(note(6))
        .expect("a WebP may have notes");
    let (width, height) = lying.dimensions();
    encoder
        .write_image(&lying, width, height, ExtendedColorType::Rgb8)
        .unwrap();
    let picture = load(&path);
    assert_eq!((picture.width, picture.height), (height, width));
    let upright = image::imageops::rotate90(&lying);
    assert_eq!(picture.pixels, upright.into_raw());
}

#[test]
fn a_file_that_is_cut_off_is_refused_at_any_length() {
    for ending in ENDINGS {
        let folder = folder();
        let path = saved(&folder, ending, colors());
        let whole = fs::read(&path).unwrap();
        for percent in [1, 10, 40, 70, 95] {
            fs::write(&path, &whole[..whole.len() * percent / 100]).unwrap();
            let refused = StillPicture::load(&path).expect_err("it is cut off");
            let said = refused.to_string();
            assert!(said.contains("picture."), "{ending} {percent}: {said}");
        }
    }
}
