//! Masks by the network.

use std::sync::Arc;

use crate::drawing::{Rope, Table};
use crate::scored::scored;
use lariat_drawn::scenes::{self, Class, score};
use lariat_extract::{Extractor, Image, Mask, Network, Options, PixelFormat};
use lariat_test_support::allocations;

fn extractor() -> Extractor {
    let options = Options::default().mask(Mask::Network);
    Extractor::new(options).expect("the options are valid")
}

fn image(rgb: &[u8], width: usize, height: usize) -> Image<'_> {
    Image::new(rgb, width, height, 3 * width, PixelFormat::Rgb8).expect("a whole image")
}

/// A rope across a table of one color.
fn plain(seed: u64) -> Vec<u8> {
    let mut table = Table::new(640, 480, [190.0, 170.0, 140.0]);
    table.noise = 2.0;
    table.seed = seed;
    table.draw(&[Rope::along(14.0, [30.0, 50.0, 130.0], |t| {
        [60.0 + 500.0 * t, 240.0 + 120.0 * (5.0 * t).sin()]
    })])
}

#[test]
fn ropes_are_found_whatever_they_lie_on() {
    let mut extractor = extractor();
    let mut right = 0;
    for seed in 0..12 {
        let still = scenes::draw(Class::OnTexture, seed, 640, 480).expect("there is room");
        let scene = extractor.extract(&image(&still.rgb, 640, 480));
        let score = score(&still.truth, &scored(scene.curves), &[]);
        let width_px = still.truth.ropes[0].width_px;
        right += usize::from(!score.is_miscounted() && score.mean_px() < 0.25 * width_px);
        extractor.reset();
    }
    assert!(right >= 6, "{right} of 12");
}

#[test]
fn where_no_rope_is_none_is_found() {
    let mut extractor = extractor();
    for level in [0, 128, 255] {
        let rgb = vec![level; 3 * 320 * 240];
        assert_eq!(extractor.extract(&image(&rgb, 320, 240)).curves, []);
    }
}

#[test]
fn a_larger_picture_is_seen_smaller_and_its_rope_where_it_is() {
    let rgb = plain(1);
    let mut large = Vec::with_capacity(4 * rgb.len());
    for row in rgb.chunks_exact(3 * 640) {
        let row: Vec<u8> = row
            .chunks_exact(3)
            .flat_map(|pixel| [pixel, pixel].concat())
            .collect();
        large.extend([&row[..], &row[..]].concat());
    }
    let (mut first, mut second) = (extractor(), extractor());
    let scene = first.extract(&image(&rgb, 640, 480));
    let twice = second.extract(&image(&large, 1280, 960));
    assert_eq!((scene.curves.len(), twice.curves.len()), (1, 1));
    for (a, b) in scene.curves[0].points.iter().zip(&twice.curves[0].points) {
        let off = [0, 1].map(|k| b[k] - (2.0 * a[k] + 0.5));
        assert!(off[0].hypot(off[1]) < 3.0, "{a:?} {b:?}");
    }
}

#[test]
fn pictures_of_any_size_and_format_are_seen() {
    let mut extractor = extractor();
    for (width, height) in [(1, 1), (3, 2), (17, 1), (1, 33), (4097, 3), (63, 65)] {
        let bytes = vec![77; 4 * width * height];
        for (format, bytes_a_pixel) in [
            (PixelFormat::Gray8, 1),
            (PixelFormat::Gray16, 2),
            (PixelFormat::Rgb8, 3),
            (PixelFormat::Bgr8, 3),
            (PixelFormat::Bgra8, 4),
        ] {
            let stride = width * bytes_a_pixel;
            let image = Image::new(&bytes, width, height, stride, format).expect("a whole image");
            assert_eq!(
                extractor.extract(&image).curves,
                [],
                "{width}×{height} {format:?}"
            );
        }
    }
}

#[test]
fn blue_green_red_is_seen_as_red_green_blue() {
    let rgb = plain(2);
    let bgr: Vec<u8> = rgb
        .chunks_exact(3)
        .flat_map(|p| [p[2], p[1], p[0]])
        .collect();
    let (mut first, mut second) = (extractor(), extractor());
    let a = first.extract(&image(&rgb, 640, 480));
    let b = Image::new(&bgr, 640, 480, 3 * 640, PixelFormat::Bgr8).expect("a whole image");
    assert_eq!(a.curves, second.extract(&b).curves);
    assert_eq!(a.curves.len(), 1);
}

#[test]
fn no_frame_allocates_once_prepared() {
    let frames: Vec<Vec<u8>> = (0..4).map(plain).collect();
    let mut extractor = extractor();
    extractor.prepare(640, 480);
    let before = allocations();
    for rgb in &frames {
        assert_eq!(extractor.extract(&image(rgb, 640, 480)).curves.len(), 1);
        extractor.reset();
    }
    assert_eq!(allocations() - before, 0);
}

#[test]
fn weights_that_have_learned_nothing_are_no_reason_to_stop() {
    let mut extractor = extractor()
        .with_network(Arc::new(Network::random(5)))
        .expect("it is asked");
    let _ = extractor.extract(&image(&plain(3), 640, 480));
}
