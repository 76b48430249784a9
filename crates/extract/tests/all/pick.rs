//! Color ranges picked from drawn pictures, and their masks.

use crate::drawing;

use drawing::{Rope, Table};
use lariat_extract::{
    Extractor, HsvRange, Image, Mask, Options, PickDoubt, PickError, Picked, PixelFormat,
    judge_pick, mask_of, pick,
};
use proptest::prelude::*;

pub(crate) const SIZE: (usize, usize) = (320, 240);
pub(crate) const LIGHT: [f32; 3] = [225.0, 220.0, 210.0];
/// A point in the middle of `wave`.
pub(crate) const ON_ROPE: [f32; 2] = [160.0, 155.9];

pub(crate) fn wave(color: [f32; 3], y: f32) -> Rope {
    Rope::along(9.0, color, move |t| {
        [40.0 + 240.0 * t, y + 60.0 * (5.0 * t).sin()]
    })
}

pub(crate) fn table(color: [f32; 3]) -> Table {
    Table {
        noise: 2.0,
        gradient: 0.2,
        ..Table::new(SIZE.0, SIZE.1, color).flat()
    }
}

pub(crate) fn rgb(bytes: &[u8]) -> Image<'_> {
    Image::new(bytes, SIZE.0, SIZE.1, 3 * SIZE.0, PixelFormat::Rgb8).expect("a whole image")
}

/// True for pixels that are more than half rope.
pub(crate) fn truth(ropes: &[Rope]) -> Vec<bool> {
    let white = |rope: &Rope| Rope {
        color: [255.0; 3],
        ..rope.clone()
    };
    let ropes: Vec<Rope> = ropes.iter().map(white).collect();
    let drawn = Table::new(SIZE.0, SIZE.1, [0.0; 3]).flat().draw(&ropes);
    drawn.chunks_exact(3).map(|pixel| pixel[0] > 127).collect()
}

/// Intersection over union of the mask of these ranges with the truth.
pub(crate) fn agreement(image: &Image, ranges: &[HsvRange], truth: &[bool]) -> f32 {
    let mask = mask_of(image, &Mask::Hsv(ranges.to_vec()));
    let count = |is: &dyn Fn(bool, bool) -> bool| {
        mask.iter()
            .zip(truth)
            .filter(|(m, t)| is(**m != 0, **t))
            .count() as f32
    };
    count(&|m, t| m && t) / count(&|m, t| m || t)
}

/// Picks without a point and at a point, checks both masks, and returns the range at the point.
fn picked_both_ways(table: &Table, color: [f32; 3]) -> HsvRange {
    let ropes = [wave(color, 120.0)];
    let (bytes, truth) = (table.draw(&ropes), truth(&ropes));
    let image = rgb(&bytes);
    let mut last = None;
    for at in [&[][..], &[ON_ROPE]] {
        let picked = pick(&image, at).expect("a rope");
        assert_eq!(picked.ranges.len(), 1, "{at:?} {picked:?}");
        assert!(picked.agreement > 0.95, "{at:?} {picked:?}");
        let good = agreement(&image, &picked.ranges, &truth);
        assert!(good > 0.9, "{at:?} {good} {picked:?}");
        last = Some(picked.ranges[0]);
    }
    last.expect("picked twice")
}

#[test]
fn a_colored_rope_is_told_by_its_hue_with_a_margin() {
    let blue = picked_both_ways(&table(LIGHT), [40.0, 90.0, 190.0]);
    let [low, high] = blue.hue_deg;
    assert!(low < 210.0 && high > 230.0 && low < high, "{blue:?}");
    // The table's own hue, a light yellow, is excluded.
    assert!(low > 60.0, "{blue:?}");
    let red = picked_both_ways(&table(LIGHT), [190.0, 30.0, 40.0]);
    assert!(red.hue_deg[0] > red.hue_deg[1], "through red: {red:?}");
}

#[test]
fn a_rope_without_color_is_told_by_its_value() {
    let (dark, light) = ([22.0, 20.0, 20.0], LIGHT);
    for (table_color, color) in [
        (dark, [235.0; 3]),
        (light, [25.0, 25.0, 28.0]),
        (light, [128.0; 3]),
    ] {
        let range = picked_both_ways(&table(table_color), color);
        assert_eq!(range.hue_deg, [0.0, 360.0], "{range:?}");
        assert_eq!(range.saturation[0], 0.0, "{range:?}");
        let own = color[0] / 255.0;
        assert!(range.value[0] < own && own < range.value[1], "{range:?}");
    }
    let black = picked_both_ways(&table(light), [25.0, 25.0, 28.0]);
    assert_eq!(black.value[0], 0.0, "darker is still black: {black:?}");
}

#[test]
fn the_ranges_hold_in_half_and_in_more_light() {
    let ropes = [wave([40.0, 90.0, 190.0], 120.0)];
    let bytes = table(LIGHT).draw(&ropes);
    let ranges = pick(&rgb(&bytes), &[]).expect("a rope").ranges;
    for light in [0.6, 1.1] {
        let lit: Vec<u8> = bytes
            .iter()
            .map(|&b| (f32::from(b) * light).min(255.0) as u8)
            .collect();
        let good = agreement(&rgb(&lit), &ranges, &truth(&ropes));
        assert!(good > 0.85, "{light}: {good}");
    }
}

#[test]
fn ropes_of_several_colors_have_a_range_each() {
    let ropes = [
        wave([190.0, 30.0, 40.0], 60.0),
        wave([30.0, 120.0, 50.0], 120.0),
        wave([25.0, 25.0, 25.0], 180.0),
        // The same red again, a little darker.
        Rope::along(9.0, [160.0, 25.0, 35.0], |t| [20.0 + 280.0 * t, 15.0]),
    ];
    let bytes = table(LIGHT).draw(&ropes);
    let image = rgb(&bytes);
    let picked = pick(&image, &[]).expect("ropes");
    assert_eq!(picked.ranges.len(), 3, "{picked:?}");
    assert!(agreement(&image, &picked.ranges, &truth(&ropes)) > 0.9);
    // At a point on the green one, the others are left out.
    let at = [160.0, 120.0 + 60.0 * 2.5f32.sin()];
    let green = pick(&image, &[at]).expect("a rope");
    assert_eq!(green.ranges.len(), 1, "{green:?}");
    assert!(
        agreement(&image, &green.ranges, &truth(&ropes[1..2])) > 0.85,
        "{green:?}"
    );
}

#[test]
fn colors_that_are_enough_are_not_doubted() {
    let ropes = [wave([190.0, 30.0, 40.0], 120.0)];
    let bytes = table(LIGHT).draw(&ropes);
    for at in [&[][..], &[ON_ROPE]] {
        let picked = pick(&rgb(&bytes), at).expect("a rope");
        assert_eq!(judge_pick(&rgb(&bytes), &picked.ranges, at).doubt, None);
    }
}

#[test]
fn colors_that_something_else_has_are_doubted() {
    let red = [190.0, 30.0, 40.0];
    // An object of the rope's color that is as large as the rope, and a dozen specks.
    let thing = Rope::along(44.0, red, |t| [230.0 + 60.0 * t, 40.0]);
    let bytes = table(LIGHT).draw(&[wave(red, 140.0), thing]);
    let red = HsvRange {
        hue_deg: [330.0, 30.0],
        saturation: [0.4, 1.0],
        value: [0.3, 1.0],
    };
    let doubt = judge_pick(&rgb(&bytes), &[red], &[[160.0, 175.9]]).doubt;
    assert!(
        matches!(doubt, Some(PickDoubt::Elsewhere(share)) if share > 0.2),
        "{doubt:?}"
    );
    let strokes: Vec<Rope> = (0..12u8)
        .map(|i| {
            let [x, y] = [f32::from(i % 4), f32::from(i / 4)].map(|c| 30.0 + 70.0 * c);
            Rope::along(5.0, [190.0, 30.0, 40.0], move |t| [x + 40.0 * t, y])
        })
        .collect();
    let bytes = table(LIGHT).draw(&strokes);
    let doubt = judge_pick(&rgb(&bytes), &[red], &[[50.0, 30.0]]).doubt;
    assert_eq!(doubt, Some(PickDoubt::Pieces(12)));
    let blue = HsvRange {
        hue_deg: [200.0, 250.0],
        ..red
    };
    assert_eq!(
        judge_pick(&rgb(&bytes), &[blue], &[]).doubt,
        Some(PickDoubt::NoRope)
    );
}

/// A table of squares with the strongest contrast.
fn checkered(ropes: &[Rope]) -> Vec<u8> {
    let mut bytes = table([40.0, 40.0, 45.0]).draw(ropes);
    let light = table([230.0, 225.0, 215.0]).draw(ropes);
    for (i, (to, from)) in bytes
        .chunks_exact_mut(3)
        .zip(light.chunks_exact(3))
        .enumerate()
    {
        if (i % SIZE.0 / 16 + i / SIZE.0 / 16).is_multiple_of(2) {
            to.copy_from_slice(from);
        }
    }
    bytes
}

#[test]
fn on_a_checkered_table_the_rope_is_found_by_its_shape_and_by_a_point() {
    let ropes = [wave([200.0, 30.0, 40.0], 120.0)];
    let bytes = checkered(&ropes);
    let image = rgb(&bytes);
    for at in [&[][..], &[ON_ROPE]] {
        let picked = pick(&image, at).expect("a rope");
        assert!(
            agreement(&image, &picked.ranges, &truth(&ropes)) > 0.85,
            "{picked:?}"
        );
    }
    for at in [[8.0, 8.0], [24.0, 8.0], [300.0, 200.0], [310.0, 230.0]] {
        assert_eq!(pick(&image, &[at]), Err(PickError::NotARope { at }));
    }
}

#[test]
fn a_point_that_is_on_no_rope_is_refused() {
    let bytes = table(LIGHT).draw(&[wave([40.0, 90.0, 190.0], 120.0)]);
    let image = rgb(&bytes);
    let at = [20.0, 30.0];
    assert_eq!(pick(&image, &[at]), Err(PickError::Table { at }));
    // A point next to the rope is accepted, as a mouse click is not exact.
    for beside_px in [6.0, 12.0] {
        assert!(
            pick(&image, &[[ON_ROPE[0], ON_ROPE[1] - beside_px]]).is_ok(),
            "{beside_px}"
        );
    }
    for at in [
        [-1.0, 5.0],
        [320.0, 5.0],
        [5.0, 240.0],
        [f32::NAN, 5.0],
        [f32::INFINITY, 0.0],
    ] {
        let outside = pick(&image, &[at]);
        assert!(
            matches!(
                outside,
                Err(PickError::Outside {
                    last: [319, 239],
                    ..
                })
            ),
            "{outside:?}"
        );
    }
    let empty = table(LIGHT).draw(&[]);
    assert_eq!(pick(&rgb(&empty), &[]), Err(PickError::NoRope));
}

#[test]
fn a_gray_image_is_picked_by_value() {
    let bytes = table(LIGHT).draw(&[wave([40.0; 3], 120.0)]);
    let gray: Vec<u8> = bytes.chunks_exact(3).map(|pixel| pixel[1]).collect();
    let image = Image::new(&gray, SIZE.0, SIZE.1, SIZE.0, PixelFormat::Gray8).expect("whole");
    let picked = pick(&image, &[]).expect("a rope");
    assert!(picked.ranges[0].value[1] < 0.7, "{picked:?}");
}

fn is_valid(picked: &Picked) -> bool {
    let mask = Mask::Hsv(picked.ranges.clone());
    let options = Options::default().mask(mask);
    (0.0..=1.0).contains(&picked.agreement) && Extractor::new(options).is_ok()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn whatever_is_picked_is_a_valid_mask(
        width in 1usize..70, height in 1usize..50, format in 0usize..9, block in 1usize..12,
        at in prop::collection::vec((-2.0f32..72.0, -2.0f32..52.0), 0..4), seed in any::<u64>(),
    ) {
        let format = [
            PixelFormat::Gray8, PixelFormat::Rgb8, PixelFormat::Bgr8,
            PixelFormat::Yuyv, PixelFormat::Uyvy, PixelFormat::Nv12,
            PixelFormat::Bgra8, PixelFormat::Gray16, PixelFormat::BayerGrbg8,
        ][format];
        let stride = 4 * width.div_ceil(2).max(1) + 2 * width;
        let bytes: Vec<u8> = (0..stride * (height + height.div_ceil(2)))
            .map(|i| {
                let cell = ((i / stride / block) * 977 + (i % stride) / block) as u64;
                let mixed = (cell ^ seed).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                ((mixed ^ (mixed >> 29)) >> 40) as u8
            })
            .collect();
        let image = Image::new(&bytes, width, height, stride, format).expect("enough bytes");
        let at: Vec<[f32; 2]> = at.into_iter().map(|(x, y)| [x, y]).collect();
        if let Ok(picked) = pick(&image, &at) {
            prop_assert!(is_valid(&picked), "{:?}", picked);
        }
    }
}
