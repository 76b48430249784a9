//! Random ropes that loop over themselves. Each is found as one rope, where it was drawn, and
//! connected correctly through every crossing.

use crate::drawing;
use lariat_portable::SplitMix64;

use std::f32::consts::{PI, TAU};

use drawing::{Rope, Table, Vec2, distance, error, extractor, see};

const WHITE: [f32; 3] = [215.0, 212.0, 205.0];
const BLUE: [f32; 3] = [30.0, 60.0, 130.0];
const SAMPLES: usize = 400;
const LOOPS: usize = 200;

/// A sum of four random waves in each direction.
fn random_rope(random: &mut SplitMix64) -> Rope {
    let width_px = random.uniform_f32(4.0, 14.0);
    let waves: Vec<[f32; 4]> = (1..5)
        .map(|k| {
            let size = 150.0 / (k as f32).powf(1.2);
            let mut wave = || {
                [
                    random.uniform_f32(-size, size),
                    random.uniform_f32(0.0, TAU),
                ]
            };
            let ([a, b], [c, d]) = (wave(), wave());
            [a, b, c, d]
        })
        .collect();
    Rope::along(width_px, BLUE, |t| {
        let mut at = [320.0, 240.0];
        for (k, [ax, px, ay, py]) in waves.iter().enumerate() {
            let turn = (k + 1) as f32 * 5.5 * t;
            at[0] += ax * (turn + px).sin();
            at[1] += ay * (turn + py).sin();
        }
        at
    })
}

/// The number of self-crossings of a rope that must be extracted correctly, or `None` for any
/// other. Such a rope is inside the image, bends with a radius above 1.8 widths, and crosses itself
/// above 25° and not at its ends.
fn crossings(rope: &Rope) -> Option<usize> {
    let p = rope.truth(SAMPLES);
    let step = distance(p[0], p[1]);
    let inside = |q: &Vec2| q[0] > 20.0 && q[1] > 20.0 && q[0] < 620.0 && q[1] < 460.0;
    if step * (SAMPLES as f32) < 300.0 || !p.iter().all(inside) {
        return None;
    }
    let direction = |i: usize| {
        let (a, b) = (p[i.saturating_sub(1)], p[(i + 1).min(SAMPLES - 1)]);
        (b[1] - a[1]).atan2(b[0] - a[0])
    };
    let folded = |angle: f32, period: f32| {
        let rest = angle.rem_euclid(period);
        rest.min(period - rest)
    };
    for i in 1..SAMPLES - 1 {
        let bend = folded(direction(i + 1) - direction(i - 1), TAU) / (2.0 * step);
        if bend > 1.0 / (1.8 * rope.width_px) {
            return None;
        }
    }
    let mut count = 0;
    let margin = 3.0 * rope.width_px / step;
    for i in 0..SAMPLES {
        for j in i + (5.0 * rope.width_px / step) as usize..SAMPLES {
            if distance(p[i], p[j]) < 1.6 * rope.width_px {
                let flat = folded(direction(i) - direction(j), PI) < 25f32.to_radians();
                if flat || (i as f32) < margin || ((SAMPLES - 1 - j) as f32) < margin {
                    return None;
                }
            }
            if j + 1 < SAMPLES && i + 1 < SAMPLES && cross(p[i], p[i + 1], p[j], p[j + 1]) {
                count += 1;
            }
        }
    }
    Some(count)
}

/// Returns whether the segments a–b and c–d cross.
fn cross(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let side = |p: Vec2, q: Vec2, r: Vec2| {
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) > 0.0
    };
    side(a, b, c) != side(a, b, d) && side(c, d, a) != side(c, d, b)
}

#[test]
fn random_ropes_are_connected_rightly_through_their_crossings() {
    let mut random = SplitMix64::new(3);
    let (mut ropes, mut all_crossings, mut mean_px, mut ends_px) = (0, 0, 0.0, 0.0);
    while ropes < 40 {
        let rope = random_rope(&mut random);
        let Some(count) = crossings(&rope) else {
            continue;
        };
        ropes += 1;
        all_crossings += count;
        let mut table = Table::new(640, 480, WHITE);
        table.noise = random.uniform_f32(0.0, 5.0);
        table.gradient = random.uniform_f32(-0.5, 0.5);
        table.seed = random.next_u64();
        let mut extractor = extractor();
        let rgb = table.draw(std::slice::from_ref(&rope));
        let scene = see(&mut extractor, &rgb, &table);
        assert_eq!(scene.curves.len(), 1, "rope {ropes}");
        assert_eq!(scene.crossings.len(), count, "rope {ropes}");
        let error = error(&scene.curves[0], &rope);
        // A wrong turn at a crossing would put points of the same index far apart.
        assert!(error.correspondence_px < 2.0, "rope {ropes}: {error:?}");
        assert!(error.mean_px < 0.3, "rope {ropes}: {error:?}");
        mean_px += error.mean_px / 40.0;
        ends_px += error.ends_px / 40.0;
    }
    assert!(
        all_crossings > 20,
        "too few crossings to say anything: {all_crossings}"
    );
    assert!(
        mean_px < 0.05 && ends_px < 0.5,
        "mean {mean_px}, ends {ends_px}"
    );
}

/// A rope that bends gently, makes one tight loop the same way, and then bends gently again. Its
/// strands touch almost along each other where the loop closes.
fn tightly_looped(random: &mut SplitMix64) -> Rope {
    let width_px = random.uniform_f32(8.0, 13.0);
    let radius_px = width_px * random.uniform_f32(1.8, 2.6);
    let turn = random.uniform_f32(0.75, 1.0) * TAU;
    let gentle = [(); 2].map(|()| 1.0 / (width_px * random.uniform_f32(9.0, 16.0)));
    let arms_px = [(); 2].map(|()| random.uniform_f32(110.0, 160.0));
    let ramp_px = width_px * random.uniform_f32(0.5, 2.0);
    let heading = random.uniform_f32(0.0, TAU);
    let loop_px = turn * radius_px;
    let length_px = arms_px[0] + loop_px + arms_px[1];
    let steps = 1500;
    let step = length_px / steps as f32;
    let bend = |s: f32| {
        let rise = |x: f32| (0.5 + x / ramp_px).clamp(0.0, 1.0);
        let inside = rise(s - arms_px[0]) * rise(arms_px[0] + loop_px - s);
        let outside = gentle[usize::from(s > arms_px[0] + 0.5 * loop_px)];
        outside + inside * (1.0 / radius_px - outside)
    };
    let (mut points, mut angle, mut at) = (Vec::new(), heading, [0.0f32; 2]);
    for i in 0..=steps {
        points.push(at);
        angle += step * bend((i as f32 + 0.5) * step);
        at = [at[0] + step * angle.cos(), at[1] + step * angle.sin()];
    }
    let side = |c: usize| {
        let of = |p: &Vec2| p[c];
        let (low, high) = points
            .iter()
            .map(of)
            .fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(v), h.max(v)));
        0.5 * (low + high)
    };
    let middle = [side(0), side(1)];
    for p in &mut points {
        *p = [p[0] - middle[0] + 320.0, p[1] - middle[1] + 240.0];
    }
    Rope {
        points,
        width_px,
        color: BLUE,
        closed: false,
    }
}

#[test]
fn a_tight_loop_that_touches_itself_belongs_to_the_rope() {
    let mut random = SplitMix64::new(11);
    let mut wrong_turns = Vec::new();
    for rope in 0..LOOPS {
        let truth = tightly_looped(&mut random);
        let mut table = Table::new(640, 480, WHITE);
        table.noise = random.uniform_f32(0.0, 4.0);
        table.seed = random.next_u64();
        let mut extractor = extractor();
        let rgb = table.draw(std::slice::from_ref(&truth));
        let scene = see(&mut extractor, &rgb, &table);
        assert_eq!(scene.curves.len(), 1, "rope {rope}");
        assert!(!scene.curves[0].closed, "rope {rope}");
        let error = error(&scene.curves[0], &truth);
        if error.correspondence_px > 2.0 {
            wrong_turns.push((rope, error));
        }
    }
    // The tightest loops close so flat that the arms of the wrong pairing bend no more than those
    // of the right one.
    assert!(100 * wrong_turns.len() <= LOOPS, "{wrong_turns:?}");
}
