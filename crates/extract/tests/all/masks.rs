//! Masks that were made elsewhere: taken as they are, hard or soft.

use crate::drawing;

use drawing::{Rope, Table, error};
use lariat_extract::{Extractor, Image, Mask, MaskError, Options, PixelFormat};

const SIZE: (usize, usize) = (320, 240);

fn rope() -> Rope {
    Rope::along(9.0, [90.0, 90.0, 90.0], |t| {
        [40.0 + 240.0 * t, 120.0 + 60.0 * (5.0 * t).sin()]
    })
}

/// A checkered table, of which half is as dark as the rope: no mask by color finds the rope on it.
fn checkered() -> Vec<u8> {
    (0..SIZE.0 * SIZE.1)
        .map(|i| {
            if (i % SIZE.0 / 16 + i / SIZE.0 / 16).is_multiple_of(2) {
                90
            } else {
                210
            }
        })
        .collect()
}

/// What a network would say: how much of each pixel is rope.
fn soft_mask() -> Vec<u8> {
    let table = Table::new(SIZE.0, SIZE.1, [0.0; 3]);
    let white = Rope {
        color: [255.0; 3],
        ..rope()
    };
    let rgb = table.draw(&[white]);
    rgb.chunks_exact(3).map(|pixel| pixel[0]).collect()
}

fn gray(bytes: &[u8]) -> Image<'_> {
    Image::new(bytes, SIZE.0, SIZE.1, SIZE.0, PixelFormat::Gray8).expect("a whole image")
}

fn external() -> Extractor {
    let options = Options {
        mask: Mask::External,
        ..Options::default()
    };
    Extractor::new(options).expect("valid options")
}

#[test]
fn a_soft_mask_places_the_rope_between_pixels_and_a_hard_one_nearly_so() {
    let (table, soft) = (checkered(), soft_mask());
    let hard: Vec<u8> = soft
        .iter()
        .map(|&p| if p >= 128 { 255 } else { 0 })
        .collect();
    for (mask, mean_px, ends_px) in [(soft, 0.1, 0.5), (hard, 0.3, 1.0)] {
        let mut extractor = external();
        let scene = extractor
            .extract_masked(&gray(&table), &gray(&mask))
            .expect("a mask of the size");
        assert_eq!(scene.curves.len(), 1);
        let error = error(&scene.curves[0], &rope());
        assert!(
            error.mean_px < mean_px && error.ends_px < ends_px,
            "{error:?}"
        );
        assert!((scene.curves[0].width_px - 9.0).abs() < 0.5);
    }
}

#[test]
fn a_mask_replaces_whatever_the_extractor_would_have_taken() {
    let (table, mask) = (checkered(), soft_mask());
    let mut extractor = Extractor::new(Options::default()).expect("valid options");
    let scene = extractor
        .extract_masked(&gray(&table), &gray(&mask))
        .expect("a mask of the size");
    assert_eq!(scene.curves.len(), 1);
}

#[test]
fn without_a_mask_there_is_no_rope() {
    let (table, mask) = (vec![210u8; SIZE.0 * SIZE.1], soft_mask());
    let mut extractor = external();
    assert!(extractor.extract(&gray(&mask)).curves.is_empty());
    let nothing = vec![0u8; SIZE.0 * SIZE.1];
    let scene = extractor.extract_masked(&gray(&table), &gray(&nothing));
    assert!(scene.expect("a mask of the size").curves.is_empty());
}

#[test]
fn a_mask_of_another_size_or_format_is_refused_and_changes_nothing() {
    let (table, mask) = (checkered(), soft_mask());
    let mut extractor = external();
    let track = |extractor: &mut Extractor| {
        let scene = extractor
            .extract_masked(&gray(&table), &gray(&mask))
            .expect("a mask of the size");
        (scene.curves[0].track, scene.curves[0].points.clone())
    };
    let before = track(&mut extractor);
    let smaller = Image::new(&mask, 160, 120, 160, PixelFormat::Gray8).expect("a whole image");
    let refused = extractor.extract_masked(&gray(&table), &smaller).err();
    assert_eq!(
        refused,
        Some(MaskError::Size {
            mask: [160, 120],
            image: [320, 240]
        })
    );
    let said = refused.expect("refused").to_string();
    assert_eq!(
        said,
        "the mask is 160×120 pixels and its image 320×240: give each image a mask of its own size"
    );
    let three = vec![0u8; 3 * SIZE.0 * SIZE.1];
    let colored = Image::new(&three, SIZE.0, SIZE.1, 3 * SIZE.0, PixelFormat::Rgb8).expect("whole");
    let refused = extractor.extract_masked(&gray(&table), &colored).err();
    assert_eq!(refused, Some(MaskError::Format(PixelFormat::Rgb8)));
    assert_eq!(track(&mut extractor), before);
}
