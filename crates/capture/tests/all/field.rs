//! Files from the field: incomplete, with extra data, or with unusual samples.

use std::fs;
use std::path::{Path, PathBuf};

use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage};
use lariat_capture::{FileOptions, RenderOptions, Source, StillPicture, open};
use lariat_message::{PixelFormat, SourceKind};
use tempfile::TempDir;

use crate::jpeg::{Coding, encode, encode_in_scans, without_tables};
use crate::pictures::next_pixels;

fn folder() -> TempDir {
    TempDir::new().expect("the system has a folder for temporary files")
}

fn colors(width: u32, height: u32) -> RgbImage {
    let wave = |x: u32, by: f64| (127.0 + 100.0 * (f64::from(x) / by).sin()) as u8;
    RgbImage::from_fn(width, height, |x, y| {
        Rgb([wave(x, 9.0), wave(y, 7.0), wave(x + y, 20.0)])
    })
}

fn jpeg_of(picture: &RgbImage) -> Vec<u8> {
    let [width, height] = [picture.width(), picture.height()].map(|side| side as usize);
    crate::jpeg::by_image(picture, [width, height], false, 90)
}

fn written(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn refusal(path: &Path) -> String {
    let refused = StillPicture::load(path)
        .map(|_| ())
        .expect_err("it is refused");
    refused.to_string()
}

fn source(
    path: &Path,
) -> Result<Box<dyn lariat_capture::FrameSource>, lariat_capture::SourceError> {
    open(&Source::named(
        &[path],
        FileOptions::default(),
        RenderOptions::default(),
    ))
}

fn mean_difference(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let sum: u64 = a
        .iter()
        .zip(b)
        .map(|(a, b)| u64::from(a.abs_diff(*b)))
        .sum();
    sum as f64 / a.len() as f64
}

#[test]
fn a_jpeg_without_huffman_tables_is_read_with_the_usual_ones() {
    let folder = folder();
    let whole = jpeg_of(&colors(48, 32));
    let expected = StillPicture::load(&written(&folder, "whole.jpg", &whole)).unwrap();
    let without = written(&folder, "without.jpg", &without_tables(&whole));
    assert_eq!(StillPicture::load(&without).unwrap(), expected);
}

#[test]
fn a_jpeg_that_lacks_its_end_marker_alone_is_read() {
    let folder = folder();
    let whole = jpeg_of(&colors(160, 120));
    let expected = StillPicture::load(&written(&folder, "whole.jpg", &whole)).unwrap();
    for end in [whole.len() - 2, whole.len() - 1] {
        let open = written(&folder, "open.jpg", &whole[..end]);
        assert_eq!(StillPicture::load(&open).unwrap().pixels, expected.pixels);
    }
    for missing in [4, 5, 6, 8, 12, 30, 100, 1000] {
        let cut = written(&folder, "cut.jpg", &whole[..whole.len() - missing]);
        assert!(refusal(&cut).contains("cut off"), "{missing}");
    }
}

#[test]
fn a_jpeg_of_a_scan_for_each_channel_has_its_colours_in_every_sampling() {
    let folder = folder();
    let picture = colors(64, 48);
    for factors in [
        [[1, 1], [1, 1]],
        [[2, 1], [1, 1]],
        [[2, 2], [1, 1]],
        [[1, 2], [1, 1]],
    ] {
        let encoded = encode_in_scans(&picture, [64, 48], factors);
        let path = written(&folder, "scans.jpg", &encoded.jpeg);
        let read = StillPicture::load(&path).unwrap();
        assert_eq!(read.format, PixelFormat::Rgb8);
        let off = mean_difference(&read.pixels, &encoded.pixels);
        assert!(off < 1.0, "{factors:?}: {off}");
    }
}

#[test]
fn every_picture_of_an_mjpeg_file_is_a_frame() {
    let folder = folder();
    let pictures: Vec<Vec<u8>> = (1..=5).map(|k| jpeg_of(&colors(16 * k, 24))).collect();
    let path = written(&folder, "film.mjpeg", &pictures.concat());
    let mut film = source(&path).unwrap();
    assert_eq!(film.kind(), SourceKind::Video);
    for k in 1..=5 {
        let (frame, _) = next_pixels(&mut *film).unwrap();
        assert_eq!((frame.sequence, frame.width), (k, 16 * k as u32));
    }
    assert_eq!(film.next().unwrap(), None);
    let cut = [&pictures[0][..], &pictures[1][..200]].concat();
    let mut film = source(&written(&folder, "cut.mjpg", &cut)).unwrap();
    assert!(next_pixels(&mut *film).is_some() && film.next().unwrap().is_none());
    assert!(film.take_warning().unwrap().contains("cut off in frame 2"));
    let empty = source(&written(&folder, "none.mjpeg", b"none"))
        .err()
        .unwrap();
    assert!(empty.to_string().contains("no whole JPEG"), "{empty}");
}

#[test]
fn a_mjpg_frame_without_tables_is_read_in_a_film_too() {
    let folder = folder();
    let picture = colors(32, 16);
    let encoded = encode(&picture, [32, 16], &Coding::CAMERA);
    let path = written(
        &folder,
        "film.mjpeg",
        &[&encoded.jpeg[..], &encoded.jpeg].concat(),
    );
    let mut film = source(&path).unwrap();
    let (_, pixels) = next_pixels(&mut *film).unwrap();
    assert!(mean_difference(&pixels, &encoded.pixels) < 1.0);
}

#[test]
fn files_of_several_pictures_are_refused_with_the_way_out() {
    let folder = folder();
    let one = jpeg_of(&colors(32, 16));
    let said = refusal(&written(&folder, "two.jpg", &[&one[..], &one].concat()));
    assert!(said.contains(".mjpeg") && said.contains("ffmpeg"), "{said}");
    // A preview after the picture has another size.
    let preview = jpeg_of(&colors(16, 8));
    let path = written(&folder, "preview.jpg", &[&one[..], &preview].concat());
    assert_eq!(StillPicture::load(&path).unwrap().width, 32);

    let png = folder.path().join("moving.png");
    GrayImage::new(4, 4).save(&png).unwrap();
    let mut moving = fs::read(&png).unwrap();
    // After the 33 bytes of signature and header: 2 frames, looped endlessly. The checksum is not
    // checked.
    let frames = [
        &[0, 0, 0, 8][..],
        b"acTL",
        &[0, 0, 0, 2, 0, 0, 0, 0],
        &[0; 4],
    ]
    .concat();
    moving.splice(33..33, frames);
    let said = refusal(&written(&folder, "moving.png", &moving));
    assert!(
        said.contains("animated PNG") && said.contains("ffmpeg"),
        "{said}"
    );

    let mut webp = b"RIFF\x1e\0\0\0WEBPVP8X\x0a\0\0\0".to_vec();
    webp.extend([2, 0, 0, 0, 3, 0, 0, 3, 0, 0]);
    let said = refusal(&written(&folder, "moving.webp", &webp));
    assert!(
        said.contains("animated WebP") && said.contains("ffmpeg"),
        "{said}"
    );

    let said = refusal(&written(&folder, "gif.gif", b"GIF89a\x04\0\x04\0"));
    assert!(
        said.contains("a GIF") && said.contains("ffmpeg -i"),
        "{said}"
    );
}

/// Encodes a TIFF of a gray picture of 2 × 1 samples. There is one directory per picture, and the
/// samples follow the directories.
fn tiff(is_big: bool, pictures: &[[(u16, u32); 2]]) -> Vec<u8> {
    let (mut file, entry_bytes) = match is_big {
        false => (b"II*\0\x08\0\0\0".to_vec(), 12),
        true => (b"II+\0\x08\0\0\0\x10\0\0\0\0\0\0\0".to_vec(), 20),
    };
    let count = 10;
    let head = if is_big { 8 } else { 2 };
    let next = if is_big { 8 } else { 4 };
    let bytes = head + count * entry_bytes + next;
    let begin = file.len();
    for (index, extra) in pictures.iter().enumerate() {
        let data = (begin + pictures.len() * bytes) as u32;
        let mut tags = vec![
            (256, 2),
            (257, 1),
            (258, 8),
            (259, 1),
            (262, 1),
            (273, data),
            (277, 1),
            (278, 1),
            (279, 2),
            (339, 1),
        ];
        for &(tag, value) in extra {
            tags.retain(|&(known, _)| known != tag);
            tags.push((tag, value));
        }
        tags.sort_unstable();
        tags.truncate(count);
        assert_eq!(tags.len(), count);
        let number = |value: u64, bytes: usize| value.to_le_bytes()[..bytes].to_vec();
        file.extend(number(count as u64, head));
        for (tag, value) in tags {
            file.extend(number(tag.into(), 2));
            file.extend(number(4, 2));
            file.extend(number(1, if is_big { 8 } else { 4 }));
            file.extend(number(value.into(), if is_big { 8 } else { 4 }));
        }
        let is_last = index + 1 == pictures.len();
        let at = if is_last {
            0
        } else {
            begin + (index + 1) * bytes
        };
        file.extend(number(at as u64, next));
    }
    file.extend([7, 200]);
    file
}

#[test]
fn big_tiffs_are_read_and_kinds_that_are_not_name_the_way_out() {
    let folder = folder();
    let usual = [(262, 1), (339, 1)];
    for is_big in [false, true] {
        let one = written(&folder, "one.tif", &tiff(is_big, &[usual]));
        assert_eq!(
            StillPicture::load(&one).unwrap().pixels,
            [7, 200],
            "big: {is_big}"
        );
        for (pictures, part) in [
            (&[usual, usual, usual][..], "holds 3 pictures"),
            (&[[(258, 32), (339, 3)]], "floating-point"),
            (&[[(262, 3), (339, 1)]], "palette"),
        ] {
            let said = refusal(&written(&folder, "odd.tif", &tiff(is_big, pictures)));
            assert!(said.contains(part) && said.contains("ffmpeg"), "{said}");
        }
    }
}

#[test]
fn samples_of_10_and_12_bits_are_as_bright_as_those_of_16_and_that_is_told() {
    let folder = folder();
    let gray = GrayImage::from_fn(9, 4, |x, y| Luma([(31 * x + y) as u8]));
    for (shift, bits) in [(2, "10 bits"), (4, "12 bits")] {
        let wide = ImageBuffer::from_fn(9, 4, |x, y| {
            Luma([u16::from(gray.get_pixel(x, y).0[0]) << shift])
        });
        for ending in ["png", "tif", "pgm"] {
            let path = folder.path().join(format!("wide.{ending}"));
            DynamicImage::ImageLuma16(wide.clone()).save(&path).unwrap();
            let read = StillPicture::load(&path).unwrap();
            let off = mean_difference(&read.pixels, &gray);
            assert!(off < 1.0, "{ending} {shift}: {off}");
            let said = read.news.expect("it is told");
            assert!(said.contains(bits), "{said}");
            let mut shown = source(&path).unwrap();
            assert_eq!(next_pixels(&mut *shown).unwrap().1, read.pixels);
            assert!(shown.take_news().is_some_and(|news| news.contains(bits)));
        }
    }
}

#[test]
fn portable_maps_are_pictures() {
    let folder = folder();
    let path = written(&folder, "a.pgm", b"P5\n2 1\n255\n\x07\xc8");
    assert_eq!(StillPicture::load(&path).unwrap().pixels, [7, 200]);
    let path = written(&folder, "a.ppm", b"P6\n1 1\n255\n\x01\x02\x03");
    assert_eq!(StillPicture::load(&path).unwrap().pixels, [1, 2, 3]);
    let said = folder.path().to_owned();
    assert_eq!(source(&said).unwrap().take_warning(), None);
}

#[test]
fn pictures_that_are_not_read_are_named_with_the_way_out_alone_and_in_folders() {
    let folder = folder();
    let heic = written(&folder, "IMG_1.HEIC", b"\0\0\0\x18ftypheic");
    for said in [
        refusal(&heic),
        source(&heic).err().unwrap().to_string(),
        source(folder.path()).err().unwrap().to_string(),
    ] {
        assert!(
            said.contains("HEIC") && said.contains("ffmpeg -i"),
            "{said}"
        );
    }
    GrayImage::new(4, 4)
        .save(folder.path().join("a.png"))
        .unwrap();
    let said = source(folder.path()).unwrap().take_warning().unwrap();
    assert!(
        said.contains("left out 1 file") && said.contains("HEIC"),
        "{said}"
    );
    let video = written(&folder, "x.mp4", b"\0\0\0\x20ftypisom");
    assert!(refusal(&video).contains("yuv420p out.y4m"));
}
