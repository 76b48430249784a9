//! Nerves of small masks.

use super::*;
use crate::bitmap::components::Components;
use lariat_clustering::{Cells, Pixels, Run};

/// The nerve of centers in a mask that is set where `is_set` returns true.
fn nerve(
    [width, height]: [u16; 2],
    is_set: impl Fn(f32, f32) -> bool,
    centers: &[[f32; 2]],
) -> BitPlane {
    let mut pixels = Pixels::default();
    for y in 0..height {
        for x in (0..width).filter(|&x| is_set(x.into(), y.into())) {
            let (from, to) = (x, x + 1);
            pixels.push(Run { y, from, to });
        }
    }
    let (mut cells, mut nerve) = (Cells::default(), Nerve::default());
    cells.assign(&pixels, centers);
    nerve.begin(width.into(), height.into());
    nerve.add(cells.runs(), centers);
    nerve.plane
}

/// Number of pieces, and whether there is a hole in any.
fn pieces_and_hole(plane: &BitPlane) -> (usize, bool) {
    let (mut components, mut names, mut filled) =
        (Components::default(), Vec::new(), plane.clone());
    let found = components.largest(plane, usize::MAX, &mut names);
    found.expect("a small plane has few runs");
    let found = components.fill_holes(&mut filled, u32::MAX);
    found.expect("a small plane has few runs");
    (names.len(), filled != *plane)
}

#[test]
fn centers_in_single_file_are_a_chain_through_the_middle() {
    let centers = [[10.0, 9.0], [30.0, 11.0], [50.0, 9.0]];
    let plane = nerve([60, 20], |_, y| (6.0..15.0).contains(&y), &centers);
    assert_eq!(pieces_and_hole(&plane), (1, false));
    for x in 10..=50 {
        let set: Vec<_> = (0..20).filter(|&y| plane.get(x, y)).collect();
        assert!(
            set.len() <= 2 && set.iter().all(|y| (9..=11).contains(y)),
            "{x}: {set:?}"
        );
    }
    // The middle of a border is halfway between the two centers.
    assert!(plane.get(20, 10) && plane.get(40, 10));
}

#[test]
fn centers_two_abreast_are_a_band_without_holes() {
    let centers: Vec<[f32; 2]> = (0..12)
        .map(|k| {
            [
                8.0 + 10.0 * (k / 2) as f32 + 3.0 * (k % 2) as f32,
                if k % 2 == 0 { 10.0 } else { 20.0 },
            ]
        })
        .collect();
    let plane = nerve([70, 30], |_, y| (5.0..25.0).contains(&y), &centers);
    assert_eq!(pieces_and_hole(&plane), (1, false));
}

#[test]
fn a_ring_stays_a_ring_with_three_centers_or_two() {
    let ring = |x: f32, y: f32| (15.0..22.0).contains(&(x - 30.0).hypot(y - 30.0));
    for count in [2, 3, 7, 24] {
        let centers: Vec<[f32; 2]> = (0..count)
            .map(|k| {
                let a = k as f32 / count as f32 * std::f32::consts::TAU;
                [30.0 + 18.5 * a.cos(), 30.0 + 18.5 * a.sin()]
            })
            .collect();
        let plane = nerve([60, 60], ring, &centers);
        assert_eq!(pieces_and_hole(&plane), (1, true), "{count}");
    }
}

#[test]
fn where_ways_part_the_mask_itself_is_drawn() {
    // A cross with arms 8 wide, a center in its middle and one in each arm, all of them slightly
    // off.
    let is_set = |x: f32, y: f32| (26.0..34.0).contains(&x) || (26.0..34.0).contains(&y);
    let centers = [
        [32.0, 28.0],
        [8.0, 29.0],
        [52.0, 31.0],
        [29.0, 8.0],
        [31.0, 52.0],
    ];
    let plane = nerve([60, 60], is_set, &centers);
    assert_eq!(pieces_and_hole(&plane), (1, false));
    for (x, y) in [(26, 26), (33, 33), (26, 33), (33, 26)] {
        assert!(plane.get(x, y), "{x}, {y}");
    }
    assert!(!plane.get(8, 26) && !plane.get(8, 33), "an arm is a line");
}

#[test]
fn pieces_apart_and_centers_without_pixels_are_not_joined() {
    let is_set = |x: f32, _: f32| !(20.0..30.0).contains(&x);
    let centers = [[10.0, 5.0], [40.0, 5.0], [90.0, 5.0]];
    let plane = nerve([60, 10], is_set, &centers);
    assert!((20..30).all(|x| (0..10).all(|y| !plane.get(x, y))));
}
