//! The result does not depend on the byte order: Uyvy gives the same bits as Yuyv.

use crate::drawing;

use drawing::formats::formats;
use drawing::{Rope, Table};
use lariat_extract::{Extractor, HsvRange, Image, Mask, Options, PixelFormat, mask_of, pick};
use proptest::prelude::*;

fn swapped(yuyv: &[u8]) -> Vec<u8> {
    yuyv.as_chunks()
        .0
        .iter()
        .flat_map(|&[y, c]| [c, y])
        .collect()
}

/// The complete results for a few consecutive frames.
fn told(
    mask: &Mask,
    frames: &[Vec<u8>],
    [width, height, stride]: [usize; 3],
    format: PixelFormat,
) -> Vec<String> {
    let options = Options::default().mask(mask.clone());
    let mut extractor = Extractor::new(options).expect("valid options");
    let mut told = Vec::new();
    for bytes in frames {
        let image = Image::new(bytes, width, height, stride, format).expect("a whole image");
        // A float is printed with enough digits to distinguish it from all others.
        told.push(format!("{:?}", extractor.extract(&image)));
        told.push(format!("{:?}", mask_of(&image, mask)));
        told.push(format!("{:?}", pick(&image, &[])));
    }
    told
}

fn blue() -> Mask {
    Mask::Hsv(vec![HsvRange {
        hue_deg: [200.0, 250.0],
        saturation: [0.3, 1.0],
        value: [0.1, 1.0],
    }])
}

#[test]
fn a_film_in_uyvy_is_the_film_in_yuyv() {
    // An odd width: half of a row's last pair is outside.
    let (width, height) = (319, 239);
    let mut table = Table::new(width, height, [215.0, 212.0, 205.0]);
    (table.noise, table.gradient) = (2.0, 0.2);
    let frames: Vec<Vec<u8>> = (0..6)
        .map(|frame| {
            table.seed = frame;
            let sway = frame as f32 / 15.0;
            let rope = Rope::along(8.0, [30.0, 60.0, 130.0], |t| {
                let a = -3.2 + 6.4 * t;
                let (x, y) = (34.0 * a - 62.0 * a.sin(), 52.0 * a.cos());
                [160.0 + x + 4.0 * sway, 128.0 + y + 9.0 * sway * t]
            });
            let mut formats = formats(&table.draw(&[rope]), width, height).into_iter();
            let yuyv = formats.find(|(format, ..)| *format == PixelFormat::Yuyv);
            yuyv.expect("one of all formats").1
        })
        .collect();
    let others: Vec<Vec<u8>> = frames.iter().map(|frame| swapped(frame)).collect();
    let size = [width, height, 2 * width.next_multiple_of(2)];
    for mask in [Mask::Auto, blue()] {
        let expected = told(&mask, &frames, size, PixelFormat::Yuyv);
        assert!(expected[0].contains("status: Ok"), "{}", expected[0]);
        assert_eq!(told(&mask, &others, size, PixelFormat::Uyvy), expected);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_in_uyvy_are_the_same_in_yuyv(
        width in 1usize..90, height in 1usize..60, padding in 0usize..4, block in 1usize..20, seed: u64,
    ) {
        let stride = 2 * width.next_multiple_of(2) + 2 * padding;
        let bytes: Vec<u8> = (0..stride * height)
            .map(|i| {
                let cell = ((i / stride / block) * 977 + (i % stride) / (4 * block) * 3 + i % 4) as u64;
                let mixed = (cell ^ seed).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                ((mixed ^ (mixed >> 29)) >> 40) as u8
            })
            .collect();
        let (frames, size) = ([bytes], [width, height, stride]);
        let others = [swapped(&frames[0])];
        for mask in [Mask::Auto, blue()] {
            let expected = told(&mask, &frames, size, PixelFormat::Yuyv);
            prop_assert_eq!(told(&mask, &others, size, PixelFormat::Uyvy), expected);
        }
    }
}
