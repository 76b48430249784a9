//! Masks of a drawn rope: the true one, and imitations of external ones.

use lariat_drawn::scenes::Still;
use lariat_portable::SplitMix64;

use super::ground::Waves;

/// Returns the true mask: the share of each pixel that is rope.
pub(super) fn cover(still: &Still) -> Vec<u8> {
    let mut nearest_px = vec![f32::INFINITY; still.width * still.height];
    let mut half_px = 0.0;
    for rope in &still.truth.ropes {
        half_px = rope.width_px / 2.0;
        for &point in &rope.points {
            around(still, point, half_px + 2.0, |i, far_px| {
                nearest_px[i] = nearest_px[i].min(far_px as f32);
            });
        }
    }
    let share = |far_px: &f32| (half_px as f32 + 0.5 - far_px).clamp(0.0, 1.0);
    nearest_px
        .iter()
        .map(|far| (255.0 * share(far)) as u8)
        .collect()
}

/// Returns a mask with gaps, with a missing end, and with strands on bare background.
pub(super) fn damaged(mask: &[u8], still: &Still, random: &mut SplitMix64) -> Vec<u8> {
    let mut mask = mask.to_vec();
    let ropes = &still.truth.ropes;
    for _ in 0..random.uniform(0.0, 2.5) as usize {
        let rope = &ropes[random.uniform(0.0, ropes.len() as f64) as usize];
        let at = rope.points[random.uniform(0.0, rope.points.len() as f64) as usize];
        let reach_px = random.uniform(0.6, 6.0) * rope.width_px;
        around(still, at, reach_px, |i, _| mask[i] = 0);
    }
    if random.uniform(0.0, 1.0) < 0.3 {
        let rope = &ropes[random.uniform(0.0, ropes.len() as f64) as usize];
        let count = random.uniform(0.1, 0.6) * rope.points.len() as f64;
        for &at in &rope.points[..count as usize] {
            around(still, at, 0.7 * rope.width_px, |i, _| mask[i] = 0);
        }
    }
    for _ in 0..random.uniform(-1.5, 1.8).max(0.0) as usize {
        let half_px = random.uniform(0.25, 0.9) * ropes[0].width_px;
        let mut at = [still.width, still.height].map(|side| random.uniform(0.0, side as f64));
        let mut heading = random.uniform(0.0, std::f64::consts::TAU);
        let mut turn = random.uniform(-0.02, 0.02);
        for _ in 0..random.uniform(40.0, 500.0) as usize {
            at = [at[0] + libm::cos(heading), at[1] + libm::sin(heading)];
            heading += turn;
            turn = (turn + random.uniform(-0.004, 0.004)).clamp(-0.04, 0.04);
            around(still, at, half_px, |i, _| mask[i] = 255);
        }
    }
    mask
}

/// Imitates a network's mask: soft, with a width that changes every few pixels.
pub(super) fn uneven(mask: &[u8], width: usize, random: &mut SplitMix64) -> Vec<u8> {
    let mut soft: Vec<f32> = mask.iter().map(|&byte| f32::from(byte) / 255.0).collect();
    let height = mask.len() / width;
    for _ in 0..random.uniform(0.0, 4.0) as usize {
        let before = soft.clone();
        for y in 1..height - 1 {
            for x in 1..width - 1 {
                let rows =
                    (y - 1..=y + 1).flat_map(|y| &before[y * width + x - 1..=y * width + x + 1]);
                soft[y * width + x] = rows.sum::<f32>() / 9.0;
            }
        }
    }
    let cell_px = random.uniform(6.0, 24.0) as usize;
    let strength = random.uniform(0.0, 0.9) as f32;
    let waves = Waves::of(random, [width, height], cell_px);
    let uneven = soft.iter().enumerate().map(|(i, &share)| {
        // The change is largest at the edges.
        let edge = if share > 0.0 {
            1.0 - 0.7 * (2.0 * share - 1.0).abs()
        } else {
            0.0
        };
        let wave = waves.at([(i % width) as f32, (i / width) as f32]);
        (255.0 * (share + strength * edge * wave)) as u8
    });
    uneven.collect()
}

/// Calls `put` with each pixel of a disc and its distance from the center.
fn around(still: &Still, at: [f64; 2], reach_px: f64, mut put: impl FnMut(usize, f64)) {
    let range = |middle: f64, side: usize| {
        let from = (middle - reach_px).ceil().max(0.0) as usize;
        from..((middle + reach_px).floor() + 1.0).clamp(0.0, side as f64) as usize
    };
    for y in range(at[1], still.height) {
        for x in range(at[0], still.width) {
            let far_px = libm::hypot(x as f64 - at[0], y as f64 - at[1]);
            if far_px <= reach_px {
                put(y * still.width + x, far_px);
            }
        }
    }
}
