//! Picture files as frames: their order, their pixels, and the handling of broken files.

use std::fs;
use std::path::{Path, PathBuf};

use image::{DynamicImage, GrayImage, ImageBuffer, Luma, LumaA, Rgb, RgbImage, Rgba};
use lariat_capture::{FileOptions, Frame, FrameSource, RenderOptions, Source, SourceError, open};
use lariat_message::{PixelFormat, SourceKind};
use tempfile::TempDir;

type Opened = Result<Box<dyn FrameSource>, SourceError>;

fn open_paths(paths: &[PathBuf], looped: bool) -> Opened {
    let options = FileOptions {
        looped,
        ..FileOptions::default()
    };
    open(&Source::named(paths, options, RenderOptions::default()))
}

fn folder() -> TempDir {
    TempDir::new().expect("the system has a folder for temporary files")
}

/// Writes a picture of a single gray level, which identifies it.
fn write_grey(path: &Path, grey: u8) {
    GrayImage::from_pixel(5, 4, Luma([grey]))
        .save(path)
        .unwrap();
}

/// The next frame's pixels, written over a pattern so that unwritten bytes show.
pub(crate) fn next_pixels(source: &mut dyn FrameSource) -> Option<(Frame, Vec<u8>)> {
    let frame = source.next().unwrap()?;
    assert!(frame.bytes() <= source.largest_frame_bytes());
    let mut pixels = vec![0xA5; frame.bytes()];
    source.write(&mut pixels);
    Some((frame, pixels))
}

/// Sequence number and first byte of the next frames.
fn firsts(source: &mut dyn FrameSource, most: usize) -> Vec<(u64, u8)> {
    std::iter::from_fn(|| next_pixels(source))
        .take(most)
        .map(|(frame, pixels)| (frame.sequence, pixels[0]))
        .collect()
}

fn warnings(source: &mut dyn FrameSource) -> Vec<String> {
    std::iter::from_fn(|| source.take_warning()).collect()
}

fn refusal(opened: Opened) -> String {
    opened.err().expect("it is refused").to_string()
}

#[test]
fn a_folder_is_shown_in_natural_order_and_other_files_are_counted() {
    let folder = folder();
    for (name, grey) in [("img10.png", 10), ("img2.PNG", 2), ("img1.png", 1)] {
        let path = folder.path().join(name);
        let picture = GrayImage::from_pixel(5, 4, Luma([grey]));
        picture
            .save_with_format(path, image::ImageFormat::Png)
            .unwrap();
    }
    fs::write(folder.path().join("notes.txt"), "no picture").unwrap();
    fs::write(folder.path().join("._img1.png"), "no picture").unwrap();
    fs::create_dir(folder.path().join("more.png")).unwrap();
    let mut source = open_paths(&[folder.path().to_owned()], false).unwrap();
    assert_eq!(source.kind(), SourceKind::Files);
    assert!(!source.has_truth());
    assert_eq!(source.native_fps(), None);
    assert_eq!(firsts(&mut *source, 9), [(1, 1), (2, 2), (3, 10)]);
    assert_eq!(source.next().unwrap(), None);
    let said = warnings(&mut *source);
    assert_eq!(said.len(), 1);
    assert!(said[0].contains("left out 2 files"), "{said:?}");
}

#[test]
fn paths_are_shown_in_the_order_given() {
    let folder = folder();
    let paths: Vec<PathBuf> = ["b.png", "a.png"].map(|n| folder.path().join(n)).to_vec();
    write_grey(&paths[0], 20);
    write_grey(&paths[1], 10);
    let mut source = open_paths(&paths, false).unwrap();
    assert_eq!(firsts(&mut *source, 9), [(1, 20), (2, 10)]);
}

/// Saves a picture as PNG and decodes it through the source.
fn through_png(picture: impl Into<DynamicImage>) -> (Frame, Vec<u8>) {
    let folder = folder();
    let path = folder.path().join("picture.png");
    picture.into().save(&path).unwrap();
    next_pixels(&mut *open_paths(&[path], false).unwrap()).unwrap()
}

#[test]
fn colour_comes_through_exactly() {
    let picture = RgbImage::from_fn(7, 3, |x, y| Rgb([x as u8, y as u8, (x * y) as u8]));
    let (frame, pixels) = through_png(picture.clone());
    let expected = Frame {
        sequence: 1,
        width: 7,
        height: 3,
        stride: 21,
        format: PixelFormat::Rgb8,
        exposed_ns: None,
        slot: None,
    };
    assert_eq!(frame, expected);
    assert_eq!(pixels, picture.into_raw());
}

#[test]
fn gray_stays_gray() {
    let picture = GrayImage::from_fn(7, 3, |x, y| Luma([(40 * y + x) as u8]));
    let (frame, pixels) = through_png(picture.clone());
    assert_eq!((frame.format, frame.stride), (PixelFormat::Gray8, 7));
    assert_eq!(pixels, picture.into_raw());
}

#[test]
fn alpha_is_left_out_not_blended() {
    let (frame, pixels) = through_png(ImageBuffer::from_pixel(2, 2, Rgba([9u8, 8, 7, 0])));
    assert_eq!(frame.format, PixelFormat::Rgb8);
    assert_eq!(pixels, [9, 8, 7].repeat(4));
    let (frame, pixels) = through_png(ImageBuffer::from_pixel(2, 2, LumaA([9u8, 0])));
    assert_eq!(frame.format, PixelFormat::Gray8);
    assert_eq!(pixels, [9; 4]);
}

#[test]
fn sixteen_bits_become_the_nearest_eight() {
    let values = [0u16, 128, 129, 257 * 77, 257 * 77 + 129, 65535];
    let nearest = [0u8, 0, 1, 77, 78, 255];
    let line = ImageBuffer::<Luma<u16>, _>::from_raw(6, 1, values.to_vec()).unwrap();
    assert_eq!(through_png(line).1, nearest);
    let pixels = ImageBuffer::<Rgb<u16>, _>::from_raw(2, 1, values.to_vec()).unwrap();
    assert_eq!(through_png(pixels).1, nearest);
    let rgba = [&values[..3], &[9], &values[3..], &[9]].concat();
    let pixels = ImageBuffer::<Rgba<u16>, _>::from_raw(2, 1, rgba).unwrap();
    assert_eq!(through_png(pixels).1, nearest);
}

#[test]
fn a_jpeg_is_what_its_decoder_says() {
    let folder = folder();
    let path = folder.path().join("picture.jpg");
    let picture = RgbImage::from_fn(33, 17, |x, y| Rgb([(7 * x) as u8, (9 * y) as u8, 90]));
    picture.save(&path).unwrap();
    let (frame, pixels) =
        next_pixels(&mut *open_paths(std::slice::from_ref(&path), false).unwrap()).unwrap();
    assert_eq!(frame.format, PixelFormat::Rgb8);
    let decoded = image::load_from_memory(&fs::read(&path).unwrap()).unwrap();
    assert_eq!(pixels, decoded.into_rgb8().into_raw());
}

/// Adds an EXIF orientation to a JPEG file (CIPA DC-008: one TIFF entry, 0x0112).
fn with_orientation(jpeg: &[u8], orientation: u8) -> Vec<u8> {
    let mut tiff = b"Exif\0\0MM\0*\0\0\0\x08".to_vec();
    tiff.extend([0, 1, 0x01, 0x12, 0, 3, 0, 0, 0, 1, 0, orientation, 0, 0]);
    tiff.extend([0; 4]);
    let length = (tiff.len() as u16 + 2).to_be_bytes();
    let app1 = [&[0xff, 0xe1], &length[..], &tiff].concat();
    // After the start of the image.
    [&jpeg[..2], &app1, &jpeg[2..]].concat()
}

#[test]
fn a_picture_taken_sideways_is_shown_upright() {
    let folder = folder();
    let path = folder.path().join("picture.jpg");
    // Blocks of the encoder's size, each of one gray level, in a sideways picture.
    let blocks = [[10, 60, 110], [160, 210, 250]];
    GrayImage::from_fn(24, 16, |x, y| {
        Luma([blocks[y as usize / 8][x as usize / 8]])
    })
    .save(&path)
    .unwrap();
    let lying = fs::read(&path).unwrap();
    for (orientation, size, upright) in [
        (1, (24, 16), [[10, 60, 110], [160, 210, 250]].concat()),
        (3, (24, 16), [[250, 210, 160], [110, 60, 10]].concat()),
        (6, (16, 24), [[160, 10], [210, 60], [250, 110]].concat()),
        (8, (16, 24), [[110, 250], [60, 210], [10, 160]].concat()),
    ] {
        fs::write(&path, with_orientation(&lying, orientation)).unwrap();
        let mut source = open_paths(std::slice::from_ref(&path), false).unwrap();
        let (frame, pixels) = next_pixels(&mut *source).unwrap();
        assert_eq!((frame.width, frame.height), size, "{orientation}");
        let columns = frame.width as usize / 8;
        for (index, grey) in upright.into_iter().enumerate() {
            let (x, y) = (index % columns * 8 + 4, index / columns * 8 + 4);
            let shown = pixels[y * frame.stride as usize + x];
            assert!(shown.abs_diff(grey) <= 2, "{orientation} {x} {y}: {shown}");
        }
    }
}

#[test]
fn a_jpeg_is_whole_whatever_follows_its_end_and_cut_off_at_any_byte_before() {
    let folder = folder();
    let path = folder.path().join("picture.jpg");
    let picture = RgbImage::from_fn(40, 30, |x, y| Rgb([(91 * x) as u8, (x * y) as u8, 90]));
    picture.save(&path).unwrap();
    let whole = fs::read(&path).unwrap();
    // For example a phone's short film, with bytes that look like the start of a scan.
    fs::write(&path, [&whole[..], &[0, 0xff, 0xda, 7, 7]].concat()).unwrap();
    assert!(open_paths(std::slice::from_ref(&path), false).is_ok());
    // If only the end marker is missing, the picture is complete.
    for end in (0..whole.len() - 2).step_by(7) {
        fs::write(&path, &whole[..end]).unwrap();
        let said = refusal(open_paths(std::slice::from_ref(&path), false));
        assert!(said.contains("picture.jpg"), "{end}: {said}");
    }
}

#[test]
fn the_smallest_and_a_very_large_picture_are_fine() {
    let (frame, pixels) = through_png(GrayImage::from_pixel(1, 1, Luma([200])));
    assert_eq!((frame.width, frame.height, frame.stride), (1, 1, 1));
    assert_eq!(pixels, [200]);
    let (frame, pixels) = through_png(GrayImage::from_pixel(8000, 6000, Luma([3])));
    assert_eq!((frame.width, frame.height), (8000, 6000));
    assert_eq!(pixels.len(), 48_000_000);
    assert!(pixels.iter().all(|&value| value == 3));
}

#[test]
fn pictures_of_many_sizes_fit_in_the_largest() {
    let folder = folder();
    let sizes = [(3, 2), (50, 40), (10, 90)];
    for (i, (width, height)) in sizes.into_iter().enumerate() {
        let picture = RgbImage::from_pixel(width, height, Rgb([i as u8; 3]));
        picture
            .save(folder.path().join(format!("{i}.png")))
            .unwrap();
    }
    let mut source = open_paths(&[folder.path().to_owned()], false).unwrap();
    assert_eq!(source.largest_frame_bytes(), 50 * 40 * 3);
    for (i, size) in sizes.into_iter().enumerate() {
        let (frame, pixels) = next_pixels(&mut *source).unwrap();
        assert_eq!((frame.width, frame.height), size);
        assert!(pixels.iter().all(|&value| value == i as u8));
    }
}

/// Truncates a file to this percentage of its bytes.
fn truncate(path: &Path, percent: usize) {
    let bytes = fs::read(path).unwrap();
    fs::write(path, &bytes[..bytes.len() * percent / 100]).unwrap();
}

/// Creates five pictures. The second (its end is missing) and the fourth (it is empty) are broken.
fn partly_broken(extension: &str) -> TempDir {
    let folder = folder();
    for i in 1..=5u8 {
        let path = folder.path().join(format!("{i}.{extension}"));
        let picture = RgbImage::from_fn(64, 48, |x, y| {
            Rgb([i, (x * y) as u8, (x.wrapping_mul(y * 77) >> 3) as u8])
        });
        picture.save(&path).unwrap();
        match i {
            2 => truncate(&path, 60),
            4 => truncate(&path, 0),
            _ => {}
        }
    }
    folder
}

#[test]
fn a_broken_file_in_the_middle_is_lost_at_the_source_and_said() {
    for extension in ["png", "jpg"] {
        let folder = partly_broken(extension);
        let mut source = open_paths(&[folder.path().to_owned()], false).unwrap();
        let shown: Vec<u64> = firsts(&mut *source, 9).iter().map(|f| f.0).collect();
        assert_eq!(shown, [1, 3, 5], "{extension}");
        let said = warnings(&mut *source);
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said[0].contains("lost frame 2") && said[0].contains(&format!("2.{extension}")));
        assert!(said[1].contains("lost frame 4"), "{said:?}");
    }
}

#[test]
fn a_loop_counts_on_loses_again_and_warns_once() {
    let folder = partly_broken("png");
    let mut source = open_paths(&[folder.path().to_owned()], true).unwrap();
    assert_eq!(
        firsts(&mut *source, 8),
        [
            (1, 1),
            (3, 3),
            (5, 5),
            (6, 1),
            (8, 3),
            (10, 5),
            (11, 1),
            (13, 3)
        ]
    );
    assert_eq!(warnings(&mut *source).len(), 2);
}

#[test]
fn a_small_loop_is_decoded_once_and_kept() {
    let folder = folder();
    for i in 1..=3 {
        write_grey(&folder.path().join(format!("{i}.png")), i);
    }
    let mut source = open_paths(&[folder.path().to_owned()], true).unwrap();
    assert_eq!(firsts(&mut *source, 4), [(1, 1), (2, 2), (3, 3), (4, 1)]);
    drop(folder);
    assert_eq!(firsts(&mut *source, 3), [(5, 2), (6, 3), (7, 1)]);
}

#[test]
fn a_large_loop_is_decoded_again_each_round() {
    let folder = folder();
    // More than 64 MB together.
    for i in 1..=3 {
        let picture = GrayImage::from_pixel(6000, 4000, Luma([i]));
        picture
            .save(folder.path().join(format!("{i}.png")))
            .unwrap();
    }
    let mut source = open_paths(&[folder.path().to_owned()], true).unwrap();
    let expected = [(1, 1), (2, 2), (3, 3), (4, 1), (5, 2), (6, 3), (7, 1)];
    assert_eq!(firsts(&mut *source, 7), expected);
    // Once its files are gone, it ends with an error.
    drop(folder);
    let error = loop {
        match source.next() {
            Ok(frame) => assert!(frame.is_some(), "an end without a word"),
            Err(error) => break error,
        }
    };
    assert!(
        error.to_string().contains("no frame can be decoded"),
        "{error}"
    );
    assert_eq!(source.next().unwrap(), None);
}

#[test]
fn what_cannot_be_shown_is_refused_before_the_first_frame() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);

    let missing = refusal(open_paths(&[at("missing.png")], false));
    assert!(missing.contains("missing.png") && missing.contains("No such file"));

    fs::create_dir(at("empty")).unwrap();
    fs::write(at("empty/readme.md"), "").unwrap();
    let empty = refusal(open_paths(&[at("empty")], false));
    assert!(
        empty.contains("holds no picture (PNG, JPEG, WebP, TIFF, BMP or PGM; but 1 other files)"),
        "{empty}"
    );

    fs::write(at("text.txt"), "words").unwrap();
    let text = refusal(open_paths(&[at("text.txt")], false));
    assert!(
        text.contains("text.txt is neither a picture (PNG, JPEG, WebP, TIFF, BMP or PGM)"),
        "{text}"
    );

    fs::write(at("text.png"), "words").unwrap();
    let disguised = refusal(open_paths(&[at("text.png")], false));
    assert!(disguised.contains("it is no PNG, JPEG"), "{disguised}");

    write_grey(&at("cut.png"), 7);
    truncate(&at("cut.png"), 70);
    let cut = refusal(open_paths(&[at("cut.png")], false));
    assert!(
        cut.contains("no frame can be decoded") && cut.contains("cut.png"),
        "{cut}"
    );

    write_grey(&at("good.png"), 7);
    let among = refusal(open_paths(&[at("good.png"), at("text.txt")], false));
    assert!(among.contains("text.txt"), "{among}");

    let unnamed = refusal(open_paths(&[], false));
    assert!(unnamed.contains("no source was named"), "{unnamed}");
}

#[test]
fn a_picture_needs_no_extension_if_it_is_named() {
    let folder = folder();
    let path = folder.path().join("snapshot");
    let picture = GrayImage::from_pixel(5, 4, Luma([3]));
    picture
        .save_with_format(&path, image::ImageFormat::Png)
        .unwrap();
    let mut source = open_paths(&[path], false).unwrap();
    assert_eq!(firsts(&mut *source, 9), [(1, 3)]);
}

#[test]
fn only_the_bare_word_is_the_rendered_rope() {
    let options = RenderOptions::default();
    assert_eq!(
        Source::named(&["rendered"], FileOptions::default(), options),
        Source::Rendered(options)
    );
    for names in [&["./rendered"][..], &["rendered", "a.png"], &[]] {
        let source = Source::named(names, FileOptions::default(), options);
        assert!(matches!(source, Source::Paths { .. }), "{source:?}");
    }
}

#[test]
fn a_source_that_is_dropped_early_leaves_quietly() {
    let folder = folder();
    for i in 1..=20 {
        write_grey(&folder.path().join(format!("{i}.png")), i);
    }
    for taken in 0..8 {
        let mut source = open_paths(&[folder.path().to_owned()], taken % 2 == 0).unwrap();
        assert_eq!(firsts(&mut *source, taken).len(), taken);
    }
}
