//! The true centerline of a drawn rope in an image.

use lariat_drawn::space::{Eye, LiftedRope};

/// 120 points at equal steps in the image, with the rope's width, the axis's distance ahead of the
/// camera, and its ρ at each.
#[derive(Clone)]
pub(crate) struct Line {
    pub(crate) points: Vec<[f32; 2]>,
    pub(crate) widths: Vec<f32>,
    pub(crate) ahead: Vec<f64>,
    pub(crate) rhos: Vec<f64>,
}

impl Line {
    pub(crate) fn of(rope: &LiftedRope, eye: &Eye) -> Self {
        let fine: Vec<([f64; 2], f64)> = rope
            .points
            .iter()
            .map(|&p| eye.see(p))
            .map(|seen| (eye.pixel(seen), seen[2]))
            .collect();
        let step = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let mut arcs = vec![0.0];
        for pair in fine.windows(2) {
            arcs.push(arcs[arcs.len() - 1] + step(pair[0].0, pair[1].0));
        }
        let (mut points, mut widths, mut rhos) = (Vec::new(), Vec::new(), Vec::new());
        let mut ahead = Vec::new();
        for k in 0..120 {
            let target = arcs[arcs.len() - 1] * f64::from(k) / 119.0;
            let at = arcs
                .partition_point(|&arc| arc < target)
                .min(arcs.len() - 1);
            points.push(fine[at].0.map(|c| c as f32));
            widths.push((2.0 * eye.focal_px[0] * rope.radius_mm / fine[at].1) as f32);
            ahead.push(fine[at].1);
            rhos.push(at as f64 / (arcs.len() - 1) as f64);
        }
        Self {
            points,
            widths,
            ahead,
            rhos,
        }
    }
}
