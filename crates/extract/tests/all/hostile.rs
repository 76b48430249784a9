//! No image makes the extractor panic, hang, or report an unlimited number of ropes.

use lariat_extract::{
    Extractor, HsvRange, Image, ImageError, Mask, Options, OptionsError, PixelFormat,
};
use proptest::prelude::*;

const FORMATS: [PixelFormat; 12] = [
    PixelFormat::Gray8,
    PixelFormat::Rgb8,
    PixelFormat::Bgr8,
    PixelFormat::Yuyv,
    PixelFormat::Uyvy,
    PixelFormat::Nv12,
    PixelFormat::Bgra8,
    PixelFormat::Gray16,
    PixelFormat::BayerRggb8,
    PixelFormat::BayerBggr8,
    PixelFormat::BayerGrbg8,
    PixelFormat::BayerGbrg8,
];

fn everything() -> Mask {
    Mask::Hsv(vec![HsvRange {
        hue_deg: [0.0, 360.0],
        saturation: [0.0, 1.0],
        value: [0.5, 1.0],
    }])
}

fn check(bytes: &[u8], width: usize, height: usize, stride: usize, format: PixelFormat) {
    let image = Image::new(bytes, width, height, stride, format).expect("enough bytes");
    for mask in [Mask::Auto, everything()] {
        let options = Options::default().mask(mask);
        let mut extractor = Extractor::new(options).expect("valid options");
        for _ in 0..2 {
            let scene = extractor.extract(&image);
            crate::methods::check(&scene, [width, height]);
            for crossing in scene.crossings {
                assert!(crossing.over < scene.curves.len() && crossing.under < scene.curves.len());
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_taken(
        width in 1usize..90, height in 1usize..60, extra in 0usize..9, format in 0usize..5,
        seed in any::<u64>(), density in 0u32..9, block in 1usize..12,
    ) {
        let format = FORMATS[format];
        let stride = 4 * width.div_ceil(2).max(1) + width + extra;
        // Blocks of equal bytes form shapes, not only noise.
        let mut bytes = vec![0u8; stride * (height + height.div_ceil(2))];
        for (i, byte) in bytes.iter_mut().enumerate() {
            let cell = ((i / stride / block) * 977 + (i % stride) / block) as u64;
            let mut state = (cell ^ seed).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            state ^= state >> 29;
            let set = (state.wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 40) % 9 < u64::from(density);
            *byte = if set { 220 } else { 30 };
        }
        check(&bytes, width, height, stride, format);
    }

    #[test]
    fn raw_noise_is_taken(
        width in 1usize..70, height in 1usize..50, format in 0usize..5,
        bytes in proptest::collection::vec(any::<u8>(), 16_384),
    ) {
        let stride = 4 * width.div_ceil(2).max(1) + width;
        prop_assume!(stride * (height + height.div_ceil(2)) <= bytes.len());
        check(&bytes, width, height, stride, FORMATS[format]);
    }
}

#[test]
fn the_smallest_images_are_taken() {
    for (width, height) in [(1, 1), (1, 200), (200, 1), (2, 3), (65, 2), (3, 64)] {
        for format in FORMATS {
            for level in [0, 128, 255] {
                let stride = 4 * width;
                check(
                    &vec![level; stride * 2 * height],
                    width,
                    height,
                    stride,
                    format,
                );
            }
        }
    }
}

#[test]
fn patterns_that_are_no_ropes_are_taken() {
    let (width, height) = (640, 480);
    let mut noise = 1u32;
    let patterns: [&mut dyn FnMut(usize, usize) -> bool; 6] = [
        &mut |_, _| true,
        &mut |x, y| (x + y) % 2 == 0,
        &mut |x, y| (x / 16 + y / 16) % 2 == 0,
        &mut |x, _| x % 3 == 0,
        &mut |x, y| x % 24 < 5 || y % 24 < 5,
        &mut |_, _| {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            noise >> 28 == 0
        },
    ];
    for pattern in patterns {
        let bytes: Vec<u8> = (0..width * height)
            .map(|i| {
                if pattern(i % width, i / width) {
                    230
                } else {
                    20
                }
            })
            .collect();
        check(&bytes, width, height, width, PixelFormat::Gray8);
    }
}

#[test]
fn the_largest_images_are_taken() {
    let (width, height) = (8000, 6000);
    let mut bytes = vec![20u8; width * height];
    for y in 2900..2960 {
        bytes[y * width + 500..y * width + 7000].fill(220);
    }
    let image = Image::new(&bytes, width, height, width, PixelFormat::Gray8).expect("enough bytes");
    let mut extractor = Extractor::new(Options::default()).expect("valid options");
    let scene = extractor.extract(&image);
    assert_eq!(scene.curves.len(), 1);
    assert!((scene.curves[0].length_px - 6500.0).abs() < 8.0);
    bytes.fill(220);
    check(&bytes, width, height, width, PixelFormat::Gray8);
}

#[test]
fn what_is_no_image_is_refused() {
    let bytes = [0; 100];
    let new = |w, h, stride, format| Image::new(&bytes, w, h, stride, format).err();
    assert_eq!(
        new(0, 5, 5, PixelFormat::Gray8),
        Some(ImageError::Empty {
            width: 0,
            height: 5
        })
    );
    assert!(matches!(
        new(6, 2, 5, PixelFormat::Gray8),
        Some(ImageError::Stride { .. })
    ));
    assert!(matches!(
        new(11, 10, 11, PixelFormat::Gray8),
        Some(ImageError::TooShort { .. })
    ));
    assert!(matches!(
        new(10, 10, 10, PixelFormat::Nv12),
        Some(ImageError::TooShort { .. })
    ));
    assert!(matches!(
        new(99_999, 1, 99_999, PixelFormat::Gray8),
        Some(ImageError::TooLarge { .. })
    ));
    assert_eq!(new(10, 10, 10, PixelFormat::Gray8), None);
}

#[test]
fn options_that_make_no_sense_are_refused() {
    let new = |options| Extractor::new(options).err();
    let with_mask = |hue_deg, saturation| {
        Options::default().mask(Mask::Hsv(vec![HsvRange {
            hue_deg,
            saturation,
            value: [0.0, 1.0],
        }]))
    };
    assert_eq!(
        new(Options::default().points(1)),
        Some(OptionsError::Points(1))
    );
    assert_eq!(
        new(Options::default().ropes(0)),
        Some(OptionsError::Ropes(0))
    );
    assert_eq!(
        new(Options::default().mask(Mask::Hsv(vec![]))),
        Some(OptionsError::NoRange)
    );
    assert!(matches!(
        new(with_mask([0.0, 400.0], [0.0, 1.0])),
        Some(OptionsError::Bound {
            channel: "hue_deg",
            ..
        })
    ));
    assert!(matches!(
        new(with_mask([0.0, 90.0], [1.0, 0.5])),
        Some(OptionsError::Reversed {
            channel: "saturation",
            ..
        })
    ));
    assert_eq!(new(with_mask([350.0, 20.0], [0.2, 1.0])), None);
}
