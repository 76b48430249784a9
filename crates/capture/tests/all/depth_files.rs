//! Depth images as files: which one belongs to which picture, and which files are rejected.

use std::fs;
use std::path::{Path, PathBuf};
use std::slice::from_ref;

use image::{ImageBuffer, Luma, RgbImage};
use lariat_capture::{DepthFiles, FileOptions, Position, Range};
use tempfile::TempDir;

/// Creates a folder of pictures and one of depth images, with these names and depths.
fn folders(pictures: &[&str], depths: &[(&str, u16)]) -> (TempDir, [PathBuf; 2]) {
    let folder = TempDir::new().unwrap();
    let [color, depth] = ["color", "depth"].map(|name| folder.path().join(name));
    fs::create_dir(&color).unwrap();
    fs::create_dir(&depth).unwrap();
    for name in pictures {
        RgbImage::new(4, 2).save(color.join(name)).unwrap();
    }
    for &(name, mm) in depths {
        write_depth(&depth.join(name), mm, 1);
    }
    (folder, [color, depth])
}

/// Writes an image with depth `mm`, whose first pixel is closer by `nearer`.
fn write_depth(path: &Path, mm: u16, nearer: u16) {
    let mut image = ImageBuffer::<Luma<u16>, _>::from_pixel(4, 2, Luma([mm]));
    image.put_pixel(0, 0, Luma([mm - nearer]));
    image.save(path).unwrap();
}

fn open(folders: &[PathBuf; 2], options: FileOptions) -> DepthFiles {
    let [color, depth] = folders;
    DepthFiles::open(from_ref(depth), from_ref(color), &options).unwrap()
}

/// The depth that each picture gets.
fn depths(images: &mut DepthFiles, count: u64) -> Vec<Result<u16, String>> {
    let mut pixels = vec![0; images.bytes()];
    let of = |sequence| {
        let written = images.write(sequence, &mut pixels);
        written.map(|()| u16::from_ne_bytes([pixels[2], pixels[3]]))
    };
    (1..=count).map(of).collect()
}

#[test]
fn depth_images_belong_to_the_pictures_of_their_numbers() {
    let pictures = [
        "frame_000.png",
        "frame_001.png",
        "frame_002.png",
        "frame_003.png",
    ];
    let of = [
        ("frame_001.png", 501),
        ("frame_002.png", 502),
        ("frame_003.png", 503),
    ];
    let (_folder, folders) = folders(&pictures, &of);
    let mut images = open(&folders, FileOptions::default());
    let notice = images.notice();
    assert!(
        notice.contains("by the number in their names: 3 of 4 pictures"),
        "{notice}"
    );
    let found = depths(&mut images, 4);
    let refused = found[0].as_ref().unwrap_err();
    assert!(
        refused.contains("frame_000.png (frame 1) has no depth image"),
        "{refused}"
    );
    assert_eq!(found[1..], [Ok(501), Ok(502), Ok(503)]);
    // A range of the pictures has the depth images of that range.
    let range = Range {
        from: Some(Position::Frame(3)),
        ..Range::default()
    };
    let mut images = open(
        &folders,
        FileOptions {
            range,
            ..FileOptions::default()
        },
    );
    assert_eq!(depths(&mut images, 2), [Ok(502), Ok(503)]);
    let looped = FileOptions {
        looped: true,
        range,
        ..FileOptions::default()
    };
    assert_eq!(
        depths(&mut open(&folders, looped), 4),
        [Ok(502), Ok(503), Ok(502), Ok(503)]
    );
}

#[test]
fn a_depth_image_that_shows_nothing_is_told_of() {
    let (_folder, folders) = folders(&["1.png", "2.png"], &[("1.png", 500)]);
    write_depth(&folders[1].join("2.png"), 0, 0);
    let found = depths(&mut open(&folders, FileOptions::default()), 2);
    assert_eq!(found[0], Ok(500));
    let refused = found[1].as_ref().unwrap_err();
    assert!(
        refused.contains("2.png shows nothing: all its pixels are 0"),
        "{refused}"
    );
}

#[test]
fn names_without_numbers_go_by_order_and_the_notice_says_so() {
    let (_folder, folders) = folders(&["a.png", "b.png"], &[("x.png", 500), ("y.png", 501)]);
    let mut images = open(&folders, FileOptions::default());
    assert!(
        images.notice().contains("by their order"),
        "{}",
        images.notice()
    );
    assert_eq!(depths(&mut images, 2), [Ok(500), Ok(501)]);
}

#[test]
fn folders_that_contradict_each_other_are_refused() {
    let (_folder, [color, depth]) = folders(&["1.png", "2.png"], &[("11.png", 500)]);
    let refused = DepthFiles::open(&[depth], &[color], &FileOptions::default()).unwrap_err();
    assert!(
        refused.to_string().contains("no number or time in common"),
        "{refused}"
    );
}
