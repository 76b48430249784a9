#![allow(unsafe_code)] // Functions for C, called on memory that another thread writes.
//! The number of a rope's control points is read only once. If a writer changes it meanwhile, the
//! answer fits the old or the new number, and nothing is written beyond that answer.

use std::ffi::c_int;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use lariat::{LARIAT_MAX_CONTROL_POINTS, lariat_covariance, lariat_descriptor, lariat_jacobian_at};
use lariat_wire::{Basis, Descriptor};

/// Both give a valid B-spline with the available knots.
const COUNTS: [u32; 2] = [9, LARIAT_MAX_CONTROL_POINTS as u32];
/// Marks numbers that were not written.
const UNTOUCHED: f64 = -7.25e77;
const ROUNDS: usize = 20_000;

/// Returns how many numbers are written into a slice that is larger than any answer.
fn written(place: &mut [f64], answer: impl FnOnce(*mut f64) -> c_int) -> usize {
    place.fill(UNTOUCHED);
    let code = answer(place.as_mut_ptr());
    assert!(code >= 0, "{code}");
    let written = place.partition_point(|number| *number != UNTOUCHED);
    assert!(place[written..].iter().all(|number| *number == UNTOUCHED));
    written
}

#[test]
fn a_count_that_changes_while_it_is_read_is_one_of_the_two() {
    let mut rope = Box::new(Descriptor {
        basis: Basis::BSpline as u32,
        degree: 3,
        count: COUNTS[0],
        samples: 40,
        ..Descriptor::EMPTY
    });
    for j in 0..LARIAT_MAX_CONTROL_POINTS {
        rope.control_points[j] = [j as f64, 0.0];
        rope.covariances[j] = [1.0, 0.0, 1.0];
        rope.knots[j] = (j + 1) as f64 / 40.0;
    }
    let rope = Box::into_raw(rope);
    // SAFETY: the descriptor lives until the end of the test, and nothing else writes its count.
    let count = unsafe { AtomicU32::from_ptr(&raw mut (*rope).count) };
    let rope_in_c = rope.cast_const().cast::<lariat_descriptor>();
    let is_over = AtomicBool::new(false);
    let mut seen = [0; 2];
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !is_over.load(Ordering::Relaxed) {
                for number in COUNTS {
                    count.store(number, Ordering::Relaxed);
                }
            }
        });
        let mut values = [0.0; 2 * LARIAT_MAX_CONTROL_POINTS];
        let mut matrix = [0.0; 5 * LARIAT_MAX_CONTROL_POINTS * LARIAT_MAX_CONTROL_POINTS];
        for round in 0..ROUNDS {
            // SAFETY: the slices are larger than the header requires, and the descriptor exists.
            let found = written(&mut values, |place| unsafe {
                lariat_jacobian_at(rope_in_c, 0.4, place)
            });
            let known = COUNTS.iter().position(|&count| count as usize == found);
            seen[known.unwrap_or_else(|| panic!("{found} numbers"))] += 1;
            let sum: f64 = values[..found].iter().sum();
            assert!((sum - 1.0).abs() < 1e-9, "{sum}");
            if round % 20 == 0 {
                // SAFETY: as above.
                let found = written(&mut matrix, |place| unsafe {
                    lariat_covariance(rope_in_c, place)
                });
                let sizes = COUNTS.map(|count| (2 * count as usize).pow(2));
                assert!(sizes.contains(&found), "{found} numbers");
            }
        }
        is_over.store(true, Ordering::Relaxed);
    });
    // SAFETY: it was created above and is freed once.
    drop(unsafe { Box::from_raw(rope) });
    assert_eq!(seen.iter().sum::<usize>(), ROUNDS);
}
