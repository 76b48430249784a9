//! Centerlines as lists of points.

/// Returns the point at share `u` (0 to 1) along a list of evenly spaced points.
pub(crate) fn at(points: &[[f64; 2]], u: f64) -> [f64; 2] {
    let last = points.len().saturating_sub(1);
    let place = u.clamp(0.0, 1.0) * last as f64;
    let below = (place as usize).min(last.saturating_sub(1));
    let share = place - below as f64;
    let above = (below + 1).min(last);
    [0, 1].map(|k| points[below][k] + share * (points[above][k] - points[below][k]))
}

/// Returns `count` points at even steps.
pub(crate) fn even(points: &[[f64; 2]], count: usize) -> Vec<[f64; 2]> {
    (0..count)
        .map(|i| at(points, i as f64 / (count - 1) as f64))
        .collect()
}

pub(crate) fn apart_px(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Returns the root mean square distance between corresponding points of two lists of equal length.
pub(crate) fn rms_apart_px(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(&a, &b)| apart_px(a, b).powi(2)).sum();
    (sum / a.len().min(b.len()) as f64).sqrt()
}

/// Returns the distance of a point from the nearest point of a line.
pub(crate) fn from_line_px(p: [f64; 2], line: &[[f64; 2]]) -> f64 {
    let to_segment = |ends: &[[f64; 2]]| {
        let along = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
        let from = [p[0] - ends[0][0], p[1] - ends[0][1]];
        let length2 = along[0] * along[0] + along[1] * along[1];
        let share = if length2 > 0.0 {
            ((from[0] * along[0] + from[1] * along[1]) / length2).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (from[0] - share * along[0]).hypot(from[1] - share * along[1])
    };
    line.windows(2)
        .map(to_segment)
        .fold(f64::INFINITY, f64::min)
}

/// Returns the root mean square distance of points from the nearest points of a line.
pub(crate) fn rms_from_line_px(points: &[[f64; 2]], line: &[[f64; 2]]) -> f64 {
    let sum: f64 = points.iter().map(|&p| from_line_px(p, line).powi(2)).sum();
    (sum / points.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_found_between_points() {
        let line = [[0.0, 0.0], [2.0, 0.0], [4.0, 4.0]];
        assert_eq!(at(&line, 0.25), [1.0, 0.0]);
        assert_eq!(at(&line, 0.75), [3.0, 2.0]);
        assert_eq!(at(&line, 1.0), [4.0, 4.0]);
        assert_eq!(even(&line, 3), line);
        assert_eq!(from_line_px([1.0, -2.0], &line), 2.0);
        assert_eq!(from_line_px([-3.0, 4.0], &line), 5.0);
        assert_eq!(
            rms_apart_px(&line, &[[0.0, 3.0], [2.0, 3.0], [4.0, 7.0]]),
            3.0
        );
    }
}
