//! Chooses the minimum byte value of rope in a mask that was made elsewhere.
//!
//! A network's probabilities have two clusters, near 0 and near 255, and a long slope between them.
//! On the slope are things that the network has rarely seen, edges, and strands below others.
//! Ridler and Calvard's iteration (see [`threshold`](super::threshold)) finds the clusters, and the
//! cut is near the lower one. A rope then breaks only where the network is almost certain of
//! background. A mask of 0 and 255 is the same at any level.

use crate::image::gray::GrayPlane;

/// Minimum level of rope in a mask without two clusters: the upper half of the byte values.
const HALF: u8 = 128;
/// Position of the cut between the mean of the rest and that of the rope: at a probability of an
/// eighth. Any position from a twentieth to a sixth leaves real masks equally whole.
const SHARE: f32 = 0.12;
/// Minimum distance of the cut from the mean of the rest, in mean deviations: 5 standard deviations
/// of Gaussian noise.
const DEVIATIONS: f32 = 6.0;
/// Minimum mean of ropes in any mask. Below it, ropes have to stand out. Otherwise, only pixels
/// that are more likely rope than not are taken.
const LEAST_ROPE: f32 = 96.0;
/// Minimum mean of ropes in a weak mask: a probability of an eighth, the cut of a mask of full
/// strength.
const LEAST_WEAK: f32 = 32.0;
/// Minimum distance of a weak mask's rope mean from the mean of the rest, in mean deviations of the
/// rest: twice that of the cut.
const APART: f32 = 2.0 * DEVIATIONS;
/// Number of rows that are counted, evenly spread. The means change little from row to row.
const ROWS: usize = 64;

/// Number of times that each byte value occurs in some rows of `mask`.
fn histogram(mask: &GrayPlane) -> [u32; 256] {
    let mut counts = [0; 256];
    let mut nothing = 0;
    for y in (0..mask.height()).step_by((mask.height() / ROWS).max(1)) {
        let (eights, rest) = mask.row(y).as_chunks::<8>();
        for eight in eights {
            // Most of a mask is 0.
            if u64::from_ne_bytes(*eight) == 0 {
                nothing += 8;
            } else {
                eight.iter().for_each(|&b| counts[usize::from(b)] += 1);
            }
        }
        rest.iter().for_each(|&b| counts[usize::from(b)] += 1);
    }
    counts[0] += nothing;
    counts
}

/// Chooses the level from the mask's own histogram.
pub(crate) fn choose(mask: &GrayPlane) -> u8 {
    let counts = histogram(mask);
    let mean = |range: std::ops::Range<usize>, of: &dyn Fn(usize) -> f32| {
        let (mut count, mut sum) = (0, 0.0);
        for level in range {
            count += counts[level];
            sum += counts[level] as f32 * of(level);
        }
        sum / count.max(1) as f32
    };
    let level = |level: usize| level as f32;
    let mut cut = usize::from(HALF);
    let [mut rest, mut rope] = [0.0; 2];
    for _ in 0..32 {
        (rest, rope) = (mean(0..cut, &level), mean(cut..256, &level));
        let next = (0.5 * (rest + rope)).ceil() as usize;
        if next == cut {
            break;
        }
        cut = next.clamp(1, 255);
    }
    let deviation = mean(0..cut, &|level| (level as f32 - rest).abs());
    let stands_out = rope >= LEAST_WEAK && rope - rest >= APART * deviation;
    if rope < LEAST_ROPE && !stands_out {
        return HALF;
    }
    let low = (SHARE * (rope - rest)).max(DEVIATIONS * deviation);
    (rest + low).ceil().clamp(1.0, cut as f32) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane in which the levels repeat in a cycle, each as often as it is listed.
    fn plane(levels: &[u8]) -> GrayPlane {
        let mut plane = GrayPlane::default();
        plane.resize(100, 10);
        for y in 0..10 {
            let row = plane.row_mut(y).iter_mut().enumerate();
            row.for_each(|(x, level)| *level = levels[(7 * y + x) % levels.len()]);
        }
        plane
    }

    #[test]
    fn probabilities_are_cut_near_their_lower_heap() {
        let mut levels = [[0, 1, 2, 0, 1, 3, 0, 0].repeat(10), vec![250; 10]].concat();
        levels.extend([20, 60, 110, 170, 200]);
        let level = choose(&plane(&levels));
        assert!((20..40).contains(&level), "{level}");
    }

    #[test]
    fn a_restless_background_stays_out() {
        let levels = [[30, 50, 40, 60, 35].repeat(16), vec![240; 12]].concat();
        assert!(choose(&plane(&levels)) > 60);
    }

    #[test]
    fn a_weak_mask_is_cut_like_a_strong_one_where_its_heaps_are_apart() {
        for strength in [0.25, 0.45, 0.7] {
            let rope =
                [250, 250, 240, 170, 110, 60, 20].map(|level| (f64::from(level) * strength) as u8);
            let levels = [vec![0; 120], rope.to_vec()].concat();
            let level = f64::from(choose(&plane(&levels))) / strength;
            assert!((10.0..60.0).contains(&level), "{strength}: {level}");
        }
    }

    #[test]
    fn a_mask_in_which_nothing_is_sure_is_cut_in_the_middle() {
        assert_eq!(choose(&plane(&[0, 3, 12, 7, 0, 40])), HALF);
        assert_eq!(choose(&plane(&[0])), HALF);
    }
}
