//! External masks are used as they are, hard or soft.

use crate::drawing;

use drawing::{Rope, Table, error};
use lariat_extract::{Curve, Extractor, Image, Mask, MaskError, Options, PixelFormat};
use std::num::NonZeroU8;

const SIZE: (usize, usize) = (320, 240);

fn rope() -> Rope {
    Rope::along(9.0, [90.0, 90.0, 90.0], |t| {
        [40.0 + 240.0 * t, 120.0 + 60.0 * (5.0 * t).sin()]
    })
}

/// A checkered table, half of it as dark as the rope. No mask by color finds the rope on it.
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

/// A mask like a network's: how much of each pixel is rope.
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
    let options = Options::default().mask(Mask::External);
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

const TABLE: [f32; 3] = [200.0, 195.0, 190.0];
const RED: [f32; 3] = [180.0, 40.0, 40.0];

/// A straight rope of this width between two x positions, at this height.
fn bar([from, to]: [f32; 2], y: f32, width_px: f32, color: [f32; 3]) -> Rope {
    Rope::along(width_px, color, move |t| [from + (to - from) * t, y])
}

fn picture(ropes: &[Rope]) -> Vec<u8> {
    Table::new(SIZE.0, SIZE.1, TABLE).draw(ropes)
}

/// A mask of these ropes, each with its own probability.
fn mask(ropes: &[(Rope, u8)]) -> Vec<u8> {
    let mut mask = vec![0; SIZE.0 * SIZE.1];
    for (rope, probability) in ropes {
        let white = Rope {
            color: [255.0; 3],
            ..rope.clone()
        };
        let rgb = Table::new(SIZE.0, SIZE.1, [0.0; 3]).draw(&[white]);
        for (mask, pixel) in mask.iter_mut().zip(rgb.chunks_exact(3)) {
            if pixel[0] >= 128 {
                *mask = *probability;
            }
        }
    }
    mask
}

fn curves(rgb: &[u8], mask: &[u8], mask_level: Option<u8>) -> Vec<Curve> {
    let options = Options::default()
        .mask(Mask::External)
        .mask_level(mask_level.and_then(NonZeroU8::new));
    let mut extractor = Extractor::new(options).expect("valid options");
    let image = Image::new(rgb, SIZE.0, SIZE.1, 3 * SIZE.0, PixelFormat::Rgb8).expect("whole");
    let scene = extractor.extract_masked(&image, &gray(mask));
    scene.expect("a mask of the size").curves.to_vec()
}

#[test]
fn a_rope_goes_on_where_a_soft_mask_is_unsure_unless_a_level_says_otherwise() {
    let whole = [40.0, 280.0];
    let rgb = picture(&[bar(whole, 120.0, 9.0, RED)]);
    let mask = mask(&[
        (bar(whole, 120.0, 9.0, RED), 250),
        (bar([120.0, 200.0], 120.0, 12.0, RED), 60),
    ]);
    let hidden = |level| {
        let curves = curves(&rgb, &mask, level);
        assert_eq!(curves.len(), 1);
        assert!((curves[0].length_px - 240.0).abs() < 3.0);
        curves[0].hidden.iter().filter(|&&hidden| hidden).count()
    };
    assert_eq!(hidden(None), 0);
    assert_eq!(hidden(Some(40)), 0);
    // At this level, the stretch is cut out of the mask and then bridged.
    assert!(hidden(Some(128)) > 20);
}

#[test]
fn pieces_are_joined_where_the_picture_shows_the_rope_and_left_alone_on_the_table() {
    let (left, right) = ([40.0, 130.0], [190.0, 280.0]);
    let pieces = [left, right].map(|ends| bar(ends, 120.0, 9.0, RED));
    let broken = mask(&pieces.clone().map(|piece| (piece, 255)));
    let one = curves(
        &picture(&[bar([40.0, 280.0], 120.0, 9.0, RED)]),
        &broken,
        None,
    );
    assert_eq!(one.len(), 1);
    assert!((one[0].length_px - 240.0).abs() < 3.0);
    assert!(one[0].hidden.contains(&true));
    assert_eq!(curves(&picture(&pieces), &broken, None).len(), 2);
}

#[test]
fn crumbs_and_slivers_of_a_mask_are_no_ropes() {
    let rope = bar([40.0, 280.0], 120.0, 9.0, RED);
    let rgb = picture(std::slice::from_ref(&rope));
    let sliver = bar([60.0, 260.0], 130.0, 3.0, RED);
    let crumb = bar([60.0, 90.0], 60.0, 8.0, RED);
    let second = bar([60.0, 260.0], 200.0, 8.0, RED);
    let masked = mask(&[(rope, 255), (sliver, 255), (crumb, 255), (second, 255)]);
    let found = curves(&rgb, &masked, None);
    assert_eq!(found.len(), 2);
    assert!(found.iter().all(|curve| curve.length_px > 190.0));
}
