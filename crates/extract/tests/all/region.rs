//! A region of a picture acts like a picture cut out of it, and nothing outside of it is read.

use crate::drawing;

use drawing::formats::formats;
use drawing::{Rope, Table};
use lariat_extract::{Extractor, HsvRange, Image, Mask, Options, PixelFormat, Region};

const WIDTH: usize = 319;
const HEIGHT: usize = 239;
const POISON: u8 = 0xA5;

/// A rope that moves within the region.
fn wave(frame: usize) -> Rope {
    Rope::along(9.0, [30.0, 60.0, 190.0], |t| {
        let x = 60.0 + 195.0 * t;
        [x, 120.0 + 0.8 * frame as f32 + 45.0 * (5.0 * t).sin()]
    })
}

/// True for each byte of a picture, in all planes, that belongs to pixels of a region.
fn inside(format: PixelFormat, stride: usize, bytes: usize, region: Region) -> Vec<bool> {
    let mut inside = vec![false; bytes];
    let Region {
        x,
        y,
        width,
        height,
    } = region;
    let mut mark = |row: usize, from: usize, count: usize| {
        inside[row * stride + from..][..count].fill(true);
    };
    for row in y..y + height {
        match format {
            // The last pair's second luma may belong to a pixel outside.
            PixelFormat::Yuyv => {
                mark(row, 2 * x, 2 * width);
                if width % 2 == 1 {
                    mark(row, 2 * (x + width) + 1, 1);
                }
            }
            // After a single last pixel come the pair's V and the unused second luma.
            PixelFormat::Uyvy => {
                mark(row, 2 * x, 2 * width);
                if width % 2 == 1 {
                    mark(row, 2 * (x + width), 1);
                }
            }
            PixelFormat::Nv12 => {
                mark(row, x, width);
                mark(HEIGHT + row / 2, x, 2 * width.div_ceil(2));
            }
            _ => {
                let bytes = format.row_bytes(1);
                mark(row, bytes * x, bytes * width);
            }
        }
    }
    inside
}

/// The region's bytes alone, with their own stride.
fn cut_out(format: PixelFormat, bytes: &[u8], stride: usize, region: Region) -> (Vec<u8>, usize) {
    let Region {
        x,
        y,
        width,
        height,
    } = region;
    let even = 2 * width.div_ceil(2);
    let (from, row_bytes) = match format {
        PixelFormat::Yuyv | PixelFormat::Uyvy => (2 * x, 2 * even),
        PixelFormat::Nv12 => (x, even),
        _ => (format.row_bytes(x), format.row_bytes(width)),
    };
    let mut rows: Vec<usize> = (y..y + height).collect();
    if format == PixelFormat::Nv12 {
        rows.extend((0..height.div_ceil(2)).map(|row| HEIGHT + y / 2 + row));
    }
    let row = |row: usize| bytes[row * stride + from..][..row_bytes].iter().copied();
    (rows.into_iter().flat_map(row).collect(), row_bytes)
}

fn options() -> [Options; 2] {
    let blue = HsvRange {
        hue_deg: [180.0, 270.0],
        saturation: [0.3, 1.0],
        value: [0.2, 1.0],
    };
    let mask = Mask::Hsv(vec![blue]);
    [Options::default(), Options::default().mask(mask)]
}

#[test]
fn what_is_found_in_a_region_is_what_is_found_in_it_cut_out() {
    let asked = Region {
        x: 37,
        y: 21,
        width: 242,
        height: 189,
    };
    let film: [_; 16] = std::array::from_fn(|frame| {
        let mut table = Table::new(WIDTH, HEIGHT, [225.0, 222.0, 218.0]);
        (table.noise, table.seed) = (1.5, frame as u64);
        formats(&table.draw(&[wave(frame)]), WIDTH, HEIGHT)
    });
    for k in 0..12 {
        for options in options() {
            let [mut of_region, mut of_cut] =
                [(); 2].map(|()| Extractor::new(options.clone()).unwrap());
            let (mut followed, mut curves) = (0, 0);
            for (frame, pictures) in film.iter().enumerate() {
                let (format, ref bytes, stride) = pictures[k];
                let region =
                    asked.within(&Image::new(bytes, WIDTH, HEIGHT, stride, format).unwrap());
                let region = region.unwrap();
                let (cut, cut_stride) = cut_out(format, bytes, stride, region);
                let cut =
                    Image::new(&cut, region.width, region.height, cut_stride, format).unwrap();

                let inside = inside(format, stride, bytes.len(), region);
                let poisoned: Vec<u8> = bytes
                    .iter()
                    .zip(inside)
                    .map(|(&byte, inside)| if inside { byte } else { POISON })
                    .collect();
                let whole = Image::new(&poisoned, WIDTH, HEIGHT, stride, format).unwrap();
                let view = whole.region(region).unwrap();

                let expected = of_cut.extract(&cut);
                let found = of_region.extract(&view);
                assert_eq!(found.curves, expected.curves, "{format:?}, frame {frame}");
                assert_eq!(
                    found.crossings, expected.crossings,
                    "{format:?}, frame {frame}"
                );
                assert_eq!(
                    found.followed, expected.followed,
                    "{format:?}, frame {frame}"
                );
                followed += usize::from(found.followed);
                curves += found.curves.len();
            }
            let gray_by_color = matches!(k, 2 | 7) && options.mask != Mask::Auto;
            assert!(
                curves >= 16 || gray_by_color,
                "{curves} curves in 16 frames of format {k}"
            );
            let is_auto = options.mask == Mask::Auto;
            assert!(
                !is_auto || followed > 0,
                "format {k}: none of 16 frames followed"
            );
        }
    }
}

#[test]
fn a_rope_that_leaves_the_region_leaves_the_image() {
    let table = Table::new(WIDTH, HEIGHT, [225.0, 222.0, 218.0]);
    let rgb = table.draw(&[wave(0)]);
    let image = Image::new(&rgb, WIDTH, HEIGHT, 3 * WIDTH, PixelFormat::Rgb8).unwrap();
    let region = Region {
        x: 0,
        y: 0,
        width: 180,
        height: HEIGHT,
    };
    let mut extractor = drawing::extractor();
    let scene = extractor.extract(&image.region(region).unwrap());
    assert_eq!(scene.curves.len(), 1);
    assert_eq!(scene.curves[0].border, [false, true]);
}

#[test]
fn regions_are_clipped_and_begin_where_colour_does() {
    let bytes = vec![0; 4 * 64 * 64];
    let at = |x, y, width, height| Region {
        x,
        y,
        width,
        height,
    };
    let within = |region: Region, format| {
        let image = Image::new(&bytes, 63, 47, 200, format).unwrap();
        region.within(&image)
    };
    let odd = at(5, 7, 10, 12);
    assert_eq!(within(odd, PixelFormat::Rgb8), Some(odd));
    assert_eq!(within(odd, PixelFormat::Yuyv), Some(at(4, 7, 11, 12)));
    assert_eq!(within(odd, PixelFormat::Uyvy), Some(at(4, 7, 11, 12)));
    assert_eq!(within(odd, PixelFormat::Nv12), Some(at(4, 6, 11, 13)));
    assert_eq!(within(odd, PixelFormat::BayerGrbg8), Some(at(4, 6, 11, 13)));
    assert_eq!(within(odd, PixelFormat::Gray16), Some(odd));
    let large = at(20, 10, usize::MAX, usize::MAX);
    assert_eq!(within(large, PixelFormat::Gray8), Some(at(20, 10, 43, 37)));
    for outside in [
        at(63, 0, 5, 5),
        at(0, 47, 5, 5),
        at(3, 3, 0, 5),
        at(3, 3, 5, 0),
    ] {
        assert_eq!(within(outside, PixelFormat::Gray8), None);
    }
    let image = Image::new(&bytes, 63, 47, 200, PixelFormat::Nv12).unwrap();
    assert!(
        image.region(odd).is_none(),
        "it begins within shared colour"
    );
    assert!(
        image.region(at(0, 0, 64, 4)).is_none(),
        "it is wider than the image"
    );
}
