//! Color ranges picked at points on drawn ropes: what one point gives, and what further points add.

use crate::drawing::{Rope, Table};
use crate::pick::{LIGHT, ON_ROPE, SIZE, agreement, rgb, table, truth, wave};
use lariat_extract::{Mask, PickDoubt, PickError, judge_pick, mask_of, pick};

const BLUE: [f32; 3] = [40.0, 90.0, 190.0];

/// The middle of `wave(_, 120)` at a share of its length.
fn on_wave(t: f32) -> [f32; 2] {
    [40.0 + 240.0 * t, 120.0 + 60.0 * (5.0 * t).sin()]
}

/// Takes each pixel from the first or the second picture.
fn mixed(first: &[u8], second: &[u8], is_first: impl Fn(usize, usize) -> bool) -> Vec<u8> {
    let pixels = first.chunks_exact(3).zip(second.chunks_exact(3));
    let mix = |(i, (a, b))| match is_first(i % SIZE.0, i / SIZE.0) {
        true => a,
        false => b,
    };
    pixels.enumerate().flat_map(mix).copied().collect()
}

#[test]
fn every_point_of_a_rope_gives_the_same_mask() {
    let ropes = [wave([190.0, 30.0, 40.0], 120.0)];
    let noisy = Table {
        noise: 6.0,
        ..table(LIGHT)
    };
    let bytes = noisy.draw(&ropes);
    let image = rgb(&bytes);
    let mask = |at| {
        let picked = pick(&image, &[at]).expect("a rope");
        mask_of(&image, &Mask::Hsv(picked.ranges))
    };
    let first = mask(ON_ROPE);
    for k in 0..12 {
        let [x, y] = on_wave(0.02 + 0.08 * k as f32);
        // Up to two thirds of a half-width from the middle.
        let at = [x, y + (k % 7) as f32 - 3.0];
        let other = mask(at);
        let count = |is: &dyn Fn(bool, bool) -> bool| {
            let pairs = first.iter().zip(&other);
            pairs.filter(|(a, b)| is(**a > 0, **b > 0)).count() as f32
        };
        let alike = count(&|a, b| a && b) / count(&|a, b| a || b);
        assert!(alike > 0.97, "{at:?}: {alike}");
    }
}

#[test]
fn a_twisted_rope_is_picked_by_a_point_on_each_of_its_colors() {
    let table = table([90.0, 110.0, 100.0]);
    let (red, yellow) = ([200.0, 40.0, 40.0], [235.0, 210.0, 60.0]);
    let [a, b] = [red, yellow].map(|color| table.draw(&[wave(color, 120.0)]));
    let is_red = |x: usize, y: usize| ((x + 2 * y) / 9).is_multiple_of(2);
    let bytes = mixed(&a, &b, is_red);
    let image = rgb(&bytes);
    let truth = truth(&[wave(red, 120.0)]);
    let near = |want: bool| {
        let along = (0..200).map(|k| on_wave(0.3 + 0.002 * k as f32));
        // In the middle of a stripe.
        let is_wanted = |&[x, y]: &[f32; 2]| {
            [-2.0, 0.0, 2.0]
                .iter()
                .all(|d| is_red((x + d) as usize, y as usize) == want)
        };
        along.into_iter().find(is_wanted).expect("stripes of both")
    };
    let points = [near(true), near(false)];
    let picked = pick(&image, &points).expect("a rope");
    let good = agreement(&image, &picked.ranges, &truth);
    assert!(good > 0.9, "{good} {picked:?}");
    assert_eq!(judge_pick(&image, &picked.ranges, &points).doubt, None);
}

#[test]
fn three_points_say_what_a_rope_is_like_in_light_and_in_shade() {
    let ropes = [wave(BLUE, 120.0)];
    let light = table(LIGHT).draw(&ropes);
    let dark: Vec<u8> = light.iter().map(|&b| (f32::from(b) * 0.3) as u8).collect();
    let bytes = mixed(&light, &dark, |x, _| x < 170);
    let image = rgb(&bytes);
    let points = [on_wave(0.2), on_wave(0.45), on_wave(0.8)];
    let picked = pick(&image, &points).expect("a rope");
    let good = agreement(&image, &picked.ranges, &truth(&ropes));
    assert!(good > 0.9, "{good} {picked:?}");
}

#[test]
fn a_thin_rope_in_noise_is_picked() {
    for width in [3.0, 4.0] {
        let rope = Rope::along(width, BLUE, on_wave);
        let noisy = Table {
            noise: 8.0,
            ..table(LIGHT)
        };
        let bytes = noisy.draw(std::slice::from_ref(&rope));
        let image = rgb(&bytes);
        for t in [0.2, 0.5, 0.77] {
            let picked = pick(&image, &[on_wave(t)]).expect("a rope");
            let good = agreement(&image, &picked.ranges, &truth(std::slice::from_ref(&rope)));
            assert!(good > 0.75, "{width} {t}: {good} {picked:?}");
        }
    }
}

#[test]
fn a_shadow_beside_the_rope_is_left_out() {
    let ropes = [wave(BLUE, 120.0)];
    let shadow = Rope::along(9.0, [150.0, 146.0, 139.0], |t| {
        let [x, y] = on_wave(t);
        [x + 4.0, y + 7.0]
    });
    let bytes = table(LIGHT).draw(&[shadow, ropes[0].clone()]);
    let image = rgb(&bytes);
    let picked = pick(&image, &[on_wave(0.4)]).expect("a rope");
    let good = agreement(&image, &picked.ranges, &truth(&ropes));
    assert!(good > 0.9, "{good} {picked:?}");
}

#[test]
fn gray_on_gray_is_told_by_light_and_a_table_of_the_ropes_color_is_said() {
    let gray = wave([150.0; 3], 120.0);
    let bytes = table([90.0; 3]).draw(std::slice::from_ref(&gray));
    let image = rgb(&bytes);
    let picked = pick(&image, &[on_wave(0.4)]).expect("a rope");
    let good = agreement(&image, &picked.ranges, &truth(std::slice::from_ref(&gray)));
    assert!(good > 0.9, "{good} {picked:?}");
    // Blotches as light as the rope and as dark as the table, all over the picture.
    let [light, dark] =
        [[150.0; 3], [90.0; 3]].map(|color| table(color).draw(std::slice::from_ref(&gray)));
    let is_light = |x: usize, y: usize| (x * x / 90 + y * y / 70 + x * y / 110).is_multiple_of(3);
    let bytes = mixed(&light, &dark, is_light);
    let image = rgb(&bytes);
    let points = [on_wave(0.4)];
    match pick(&image, &points) {
        Err(why) => assert_eq!(why, PickError::NotARope { at: points[0] }),
        Ok(picked) => {
            let doubt = judge_pick(&image, &picked.ranges, &points).doubt;
            assert!(
                matches!(
                    doubt,
                    Some(PickDoubt::Elsewhere(_) | PickDoubt::Pieces(_) | PickDoubt::Unsure(_))
                ),
                "{doubt:?} {picked:?}"
            );
        }
    }
}
