//! The true mask of a frame, drawn from the known ropes.

use super::TrueRope;

/// Fills `out` with the share of each pixel that visible rope covers, one byte per pixel.
pub(super) fn draw(ropes: &[TrueRope], [width, height]: [usize; 2], out: &mut Vec<u8>) {
    out.clear();
    out.resize(width * height, 0);
    for rope in ropes {
        let half_px = 0.5 * rope.width_px;
        let last = rope.points.len() - 2;
        let pieces = rope.points.windows(2).zip(rope.seen.windows(2));
        for (i, (piece, _)) in (pieces.enumerate()).filter(|(_, (_, seen))| seen[0] && seen[1]) {
            let [a, b] = [piece[0], piece[1]];
            let is_tip = [i == 0, i == last];
            let span = |axis: usize, side: usize| {
                let low = (a[axis].min(b[axis]) - half_px - 1.0).max(0.0) as usize;
                let high = (a[axis].max(b[axis]) + half_px + 2.0).max(0.0) as usize;
                low.min(side)..high.min(side)
            };
            for (x, y) in span(1, height).flat_map(|y| span(0, width).map(move |x| (x, y))) {
                let within_px = half_px - off_px([x as f64, y as f64], [a, b], is_tip);
                let cover = (within_px + 0.5).clamp(0.0, 1.0);
                let known = &mut out[y * width + x];
                *known = (*known).max((255.0 * cover) as u8);
            }
        }
    }
}

/// Distance of a point from the segment between two others; infinite beyond an end that is a tip.
fn off_px(p: [f64; 2], [a, b]: [[f64; 2]; 2], is_tip: [bool; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let from = [p[0] - a[0], p[1] - a[1]];
    let square = (along[0] * along[0] + along[1] * along[1]).max(1e-12);
    let share = (from[0] * along[0] + from[1] * along[1]) / square;
    if is_tip[0] && share < 0.0 || is_tip[1] && share > 1.0 {
        return f64::INFINITY;
    }
    let share = share.clamp(0.0, 1.0);
    let off = [from[0] - share * along[0], from[1] - share * along[1]];
    (off[0] * off[0] + off[1] * off[1]).sqrt()
}
