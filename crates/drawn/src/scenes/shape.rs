//! Random smooth curves: open ones from a heading that swings along them, closed ones from waves in
//! x and y, and pairs of strands along a common spine.

use super::line::{Line, Vec2, minus, norm};
use crate::rendered::portable::{cos_turns, sin_turns, smoothstep};
use lariat_portable::SplitMix64;

/// Number of segments of a trial curve; a drawn curve has more.
pub(super) const TRIAL_SEGMENTS: usize = 320;

/// Size of the image, and the margin that ropes keep from its border.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    pub(super) size_px: Vec2,
    pub(super) margin_px: f64,
}

impl Room {
    /// Moves and scales points to fit inside, at a random share of the largest size.
    fn fit(self, random: &mut SplitMix64, points: &mut [Vec2]) {
        let share = random.uniform(0.8, 1.0);
        let (low, high) = bounds(points);
        let spans = [0, 1].map(|k| self.size_px[k] - 1.0 - 2.0 * self.margin_px);
        let scales = [0, 1].map(|k| spans[k] / (high[k] - low[k]).max(1e-9));
        let scale = share * scales[0].min(scales[1]);
        let shift = [0, 1].map(|k| {
            let spare = spans[k] - scale * (high[k] - low[k]);
            self.margin_px + random.uniform(0.0, 1.0) * spare - scale * low[k]
        });
        for point in points {
            *point = [0, 1].map(|k| scale * point[k] + shift[k]);
        }
    }

    pub(super) fn holds(self, line: &Line) -> bool {
        line.points.iter().all(|point| {
            (0..2).all(|k| {
                point[k] >= self.margin_px && point[k] <= self.size_px[k] - 1.0 - self.margin_px
            })
        })
    }
}

fn bounds(points: &[Vec2]) -> (Vec2, Vec2) {
    let fold = |k: usize, start: f64, pick: fn(f64, f64) -> f64| {
        points.iter().map(|point| point[k]).fold(start, pick)
    };
    (
        [0, 1].map(|k| fold(k, f64::MAX, f64::min)),
        [0, 1].map(|k| fold(k, f64::MIN, f64::max)),
    )
}

/// Makes an open curve that fills the room. A larger `swing` (0 to 1) makes it wind more and cross
/// itself more often.
pub(super) fn open(random: &mut SplitMix64, room: Room, swing: f64) -> Line {
    const MODES: usize = 6;
    let heading = random.uniform(0.0, 1.0);
    let turn = random.uniform(-1.0, 1.0) * 2.0 * swing;
    let size = 0.2 + 0.3 * swing;
    let modes: [Vec2; MODES] = std::array::from_fn(|k| {
        let fade = 1.0 / (1.0 + 0.5 * k as f64);
        [random.uniform(-size, size) * fade, random.uniform(0.0, 1.0)]
    });
    let step = 1.0 / TRIAL_SEGMENTS as f64;
    let mut at = [0.0; 2];
    let mut points = vec![at];
    for i in 0..TRIAL_SEGMENTS {
        let along = (i as f64 + 0.5) * step;
        let mut turns = heading + turn * along;
        for (k, [amplitude, phase]) in modes.iter().enumerate() {
            turns += amplitude * sin_turns(0.5 * (k + 1) as f64 * along + phase);
        }
        at = [
            at[0] + step * cos_turns(turns),
            at[1] + step * sin_turns(turns),
        ];
        points.push(at);
    }
    room.fit(random, &mut points);
    let step_px = norm(minus(points[1], points[0]));
    Line {
        points,
        closed: false,
        step_px,
    }
}

/// Makes a line through and beyond the picture, bent by up to a twenty-fifth of its length.
pub(super) fn taut(random: &mut SplitMix64, size_px: Vec2) -> Line {
    let middle = size_px.map(|side| side * random.uniform(0.2, 0.8));
    let turns = random.uniform(0.0, 1.0);
    let along = [cos_turns(turns), sin_turns(turns)];
    let length_px = 1.6 * norm(size_px);
    let bend_px = length_px * random.uniform(-0.04, 0.04);
    let points: Vec<Vec2> = (0..=TRIAL_SEGMENTS)
        .map(|i| {
            let at = 2.0 * i as f64 / TRIAL_SEGMENTS as f64 - 1.0;
            let (run_px, off_px) = (0.5 * length_px * at, bend_px * (1.0 - at * at));
            [
                middle[0] + run_px * along[0] - off_px * along[1],
                middle[1] + run_px * along[1] + off_px * along[0],
            ]
        })
        .collect();
    Line::through(&points, false, TRIAL_SEGMENTS)
}

/// Makes a line of one curvature: straight, an arc, or a ring.
pub(super) fn even(random: &mut SplitMix64, size_px: Vec2, width_px: f64) -> Line {
    let length_px = width_px * random.uniform(8.0, 45.0);
    let turns = match random.uniform(0.0, 1.0) {
        kind if kind < 0.4 => random.uniform(0.0, 0.02),
        kind if kind < 0.85 => random.uniform(0.02, 0.8),
        _ => 1.0,
    };
    let closed = turns == 1.0;
    let heading = random.uniform(0.0, 1.0);
    let step_px = length_px / TRIAL_SEGMENTS as f64;
    let mut at = [0, 1].map(|k| size_px[k] * random.uniform(0.1, 0.9));
    let mut points = vec![at];
    for i in 1..TRIAL_SEGMENTS + usize::from(!closed) {
        let turn = heading + turns * (i as f64 - 0.5) / TRIAL_SEGMENTS as f64;
        at = [
            at[0] + step_px * cos_turns(turn),
            at[1] + step_px * sin_turns(turn),
        ];
        points.push(at);
    }
    Line {
        points,
        closed,
        step_px,
    }
}

/// Makes a closed curve that fills the room.
pub(super) fn closed(random: &mut SplitMix64, room: Room) -> Line {
    let waves: [[f64; 4]; 4] = std::array::from_fn(|k| {
        let size = 1.0 / libm::pow((k + 1) as f64 * (k + 1) as f64, 0.8);
        [
            random.uniform(-size, size),
            random.uniform(0.0, 1.0),
            random.uniform(-size, size),
            random.uniform(0.0, 1.0),
        ]
    });
    let mut points: Vec<Vec2> = (0..TRIAL_SEGMENTS)
        .map(|i| {
            let along = i as f64 / TRIAL_SEGMENTS as f64;
            let mut at = [0.0; 2];
            for (k, wave) in waves.iter().enumerate() {
                let turns = (k + 1) as f64 * along;
                at[0] += wave[0] * sin_turns(turns + wave[1]);
                at[1] += wave[2] * sin_turns(turns + wave[3]);
            }
            at
        })
        .collect();
    room.fit(random, &mut points);
    Line::through(&points, true, TRIAL_SEGMENTS)
}

/// Position of two strands relative to their spine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside {
    /// Distance between the strands' centers where they run together.
    pub(super) together_px: f64,
    /// Length over which they run together.
    pub(super) run_px: f64,
    /// Distance between their centers where they are apart.
    pub(super) apart_px: f64,
    /// Length over which they part.
    pub(super) parting_px: f64,
}

/// Makes two strands that come together, run next to each other and part. With `joined`, makes one
/// rope instead, whose two strands are joined by a loop at the end. Their spine is a gentle curve
/// somewhere in the room. Also returns the arc lengths of the run on the second strand.
pub(super) fn beside(
    random: &mut SplitMix64,
    room: Room,
    how: Beside,
    joined: bool,
) -> (Vec<Line>, [f64; 2]) {
    let legs_px = [(); 2].map(|()| how.parting_px + random.uniform(2.0, 5.0) * how.apart_px);
    let length_px = legs_px[0] + how.run_px + legs_px[1];
    let [from_px, to_px] = [legs_px[0], legs_px[0] + how.run_px];
    let half_px = |along_px: f64| {
        let beyond_px = (from_px - along_px).max(along_px - to_px);
        let parted = smoothstep(beyond_px / how.parting_px);
        let mut half_px = 0.5 * (how.together_px + parted * (how.apart_px - how.together_px));
        if joined {
            // The loop's head is half an ellipse.
            let head_px = how.apart_px;
            let into = ((along_px - (length_px - head_px)) / head_px).clamp(0.0, 1.0);
            half_px *= (1.0 - into * into).max(0.0).sqrt();
        }
        half_px
    };
    let bend = random.uniform(-0.2, 0.2);
    let second_bend = random.uniform(-0.12, 0.12);
    let heading = random.uniform(0.0, 1.0);
    let segments = 200;
    let mut spine = [0.0; 2];
    let mut sides = [Vec::new(), Vec::new()];
    for i in 0..=segments {
        // Points are denser toward the head, where the sides close.
        let share = sin_turns(0.25 * i as f64 / segments as f64);
        let along_px = length_px * share;
        let turns = heading + bend * share + second_bend * sin_turns(share);
        let normal = [-sin_turns(turns), cos_turns(turns)];
        let half_px = half_px(along_px);
        sides[0].push([0, 1].map(|k| spine[k] + half_px * normal[k]));
        sides[1].push([0, 1].map(|k| spine[k] - half_px * normal[k]));
        let next = length_px * sin_turns(0.25 * (i + 1) as f64 / segments as f64);
        let step_px = if i < segments { next - along_px } else { 0.0 };
        spine = [
            spine[0] + step_px * cos_turns(turns),
            spine[1] + step_px * sin_turns(turns),
        ];
    }
    let [mut first, mut second] = sides;
    let mut all: Vec<Vec2> = first.iter().chain(&second).copied().collect();
    let (low, high) = bounds(&all);
    let shift = [0, 1].map(|k| {
        let spare = room.size_px[k] - 1.0 - 2.0 * room.margin_px - (high[k] - low[k]);
        room.margin_px + random.uniform(0.0, 1.0) * spare - low[k]
    });
    for point in first.iter_mut().chain(&mut second) {
        *point = [0, 1].map(|k| point[k] + shift[k]);
    }
    all.clear();
    if joined {
        all.extend(&first);
        // Both sides share the point at the head.
        all.extend(second.iter().rev().skip(1));
        (
            vec![Line::through(&all, false, 2 * TRIAL_SEGMENTS)],
            [0.0; 2],
        )
    } else {
        let lines = [first, second].map(|side| Line::through(&side, false, TRIAL_SEGMENTS));
        (lines.to_vec(), [from_px, to_px])
    }
}
