//! Message with the true position of the drawn rope.

use lariat_message::{Centerlines, Crossing, MAX_CROSSINGS, Status};

/// Writes the drawn centerline (equal steps from tip to tip) as `count` points at equal arc
/// lengths, with its self-crossings. The later strand of a crossing is the upper one.
pub(crate) fn fill(
    line: &[[f64; 2]],
    length_px: f64,
    width_px: f64,
    count: usize,
    truth: &mut Centerlines,
) {
    let segments = line.len() - 1;
    let curve = &mut truth.curves[0];
    truth.count = 1;
    curve.track = 1;
    curve.status = Status::Ok as u32;
    curve.closed = 0;
    curve.border = 0;
    curve.count = count as u32;
    curve.width_px = width_px as f32;
    curve.length_px = length_px as f32;
    curve.confidence = 1.0;
    curve.age_ns = 0;
    curve.set_hidden([]);
    for i in 0..count {
        let position = i as f64 * segments as f64 / (count - 1) as f64;
        let segment = (position as usize).min(segments - 1);
        let share = position - segment as f64;
        let (p, q) = (line[segment], line[segment + 1]);
        curve.points[i] = [0, 1].map(|axis| (p[axis] + (q[axis] - p[axis]) * share) as f32);
        curve.widths_px[i] = width_px as f32;
    }
    truth.crossing_count = 0;
    find_crossings(line, length_px, |at, lower, upper| {
        let n = truth.crossing_count as usize;
        if n < MAX_CROSSINGS {
            truth.crossings[n] = Crossing {
                at: at.map(|value| value as f32),
                over: 0,
                under: 0,
                over_rho: (upper / segments as f64) as f32,
                under_rho: (lower / segments as f64) as f32,
                confidence: 1.0,
                reserved: 0,
            };
            truth.crossing_count += 1;
        }
    });
}

/// Calls back for each self-crossing of the line, with the earlier and the later position in
/// segments.
///
/// If two segments are a distance D apart, the line must advance by D minus their lengths before it
/// can meet the first segment. Most pairs are therefore skipped.
fn find_crossings(line: &[[f64; 2]], length_px: f64, mut found: impl FnMut([f64; 2], f64, f64)) {
    let segments = line.len() - 1;
    let step_px = length_px / segments as f64;
    for i in 0..segments {
        let mut j = i + 2;
        while j < segments {
            let apart = [line[j][0] - line[i][0], line[j][1] - line[i][1]];
            let steps = (apart[0] * apart[0] + apart[1] * apart[1]).sqrt() / step_px;
            if steps < 2.5
                && let Some((s, t)) = meet([line[i], line[i + 1]], [line[j], line[j + 1]])
            {
                let at = [0, 1].map(|a| line[i][a] + (line[i + 1][a] - line[i][a]) * s);
                found(at, i as f64 + s, j as f64 + t);
            }
            // Segment k can meet segment i only if their starts are less than two steps apart.
            j += (steps as usize).saturating_sub(2).max(1);
        }
    }
}

/// Intersection of the segments pq and rs, as a share of each. The ends q and s belong to the next
/// segments.
pub(crate) fn meet([p, q]: [[f64; 2]; 2], [r, s]: [[f64; 2]; 2]) -> Option<(f64, f64)> {
    let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let (u, v, w) = (minus(q, p), minus(s, r), minus(r, p));
    let det = cross(u, v);
    if det == 0.0 {
        return None;
    }
    let (along, other) = (cross(w, v) / det, cross(w, u) / det);
    let within = 0.0..1.0;
    (within.contains(&along) && within.contains(&other)).then_some((along, other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_that_crosses_itself_once_has_one_crossing() {
        // Equal steps along three sides of a square and back across the first.
        let corners: [[f64; 2]; 5] = [
            [0.0, 0.0],
            [40.0, 0.0],
            [40.0, 20.0],
            [20.5, 20.0],
            [20.5, -20.0],
        ];
        let mut line = vec![corners[0]];
        for side in corners.windows(2) {
            let (dx, dy) = (side[1][0] - side[0][0], side[1][1] - side[0][1]);
            let steps = f64::sqrt(dx * dx + dy * dy).round();
            for i in 1..=steps as usize {
                let share = i as f64 / steps;
                line.push([side[0][0] + dx * share, side[0][1] + dy * share]);
            }
        }
        let mut crossings = Vec::new();
        let length_px = (line.len() - 1) as f64;
        find_crossings(&line, length_px, |at, lower, upper| {
            crossings.push((at, lower, upper));
        });
        assert_eq!(crossings.len(), 1, "{crossings:?}");
        let (at, lower, upper) = crossings[0];
        assert!((at[0] - 20.5).abs() < 1e-9 && at[1].abs() < 1e-9);
        assert!((lower - 20.5).abs() < 1e-9);
        assert!((upper - (40.0 + 20.0 + 20.0 + 20.0)).abs() < 1.0);
    }
}
