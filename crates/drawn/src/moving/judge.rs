//! Compares an extractor's answers to a film with the truth and counts the errors.

use super::TrueRope;

/// Reported state of a rope.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeenStatus {
    /// Completely visible.
    Ok,
    /// Partly visible.
    Partial,
    /// Not visible now.
    Lost,
}

/// A curve from an extractor.
#[derive(Debug, Clone, Copy)]
pub struct SeenCurve<'a> {
    /// Track number.
    pub track: u32,
    /// State of the rope.
    pub status: SeenStatus,
    /// Its points at equal steps of arc length.
    pub points: &'a [[f32; 2]],
    /// True for each point that is marked as hidden.
    pub hidden: &'a [bool],
}

/// Error counts, in frames (per rope).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Verdict {
    /// Number of ropes with at least half of their points visible, summed over the frames.
    pub shown: u64,
    /// Number of these ropes without a curve on them.
    pub missed: u64,
    /// Number of frames with a wrong number of curves.
    pub miscounted: u64,
    /// Number of times that a rope's direction turned around.
    pub flips: u64,
    /// Number of times that a rope's track number changed.
    pub swaps: u64,
    /// Number of curves that are on their rope but do not follow it in order, because strands are
    /// exchanged or loops left out.
    pub exchanged: u64,
    /// Number of curves reported as visible that are not on a rope.
    pub invented: u64,
    /// Number of completely visible ropes not reported as `Ok`, plus number of partly hidden ropes
    /// reported as `Ok`.
    pub misjudged: u64,
    /// Number of wrongly marked points on curves that are on their rope: hidden but not marked, or
    /// marked but visible.
    pub mismarked: u64,
    /// Number of points whose marks were checked.
    pub marked: u64,
}

impl Verdict {
    /// Errors in the ropes' positions, numbers and directions: missed, miscounted, turned, renamed,
    /// exchanged, invented.
    pub fn places(&self) -> [u64; 6] {
        [
            self.missed,
            self.miscounted,
            self.flips,
            self.swaps,
            self.exchanged,
            self.invented,
        ]
    }
}

/// Judges the answers to one film.
#[derive(Debug, Default)]
pub struct Judge {
    known: Vec<Identity>,
    frame: u64,
    verdict: Verdict,
}

/// Last answer for a visible rope.
#[derive(Debug, Clone, Copy)]
struct Identity {
    identity: u32,
    track: u32,
    /// True if the curve ran against the truth.
    reversed: bool,
    frame: u64,
}

/// Number of frames after which an absent rope may return with any number.
const FORGOTTEN: u64 = 30;

/// Position of a curve relative to a rope.
struct Fit {
    /// Mean distance of its points from the rope's centerline, in widths.
    beside: f64,
    /// 95th percentile of the distance between points of the same index, in widths.
    order: f64,
    reversed: bool,
}

impl Judge {
    /// Judges one frame's answer by its truth. Returns the errors in words.
    pub fn look(&mut self, truth: &[TrueRope], curves: &[SeenCurve]) -> Vec<String> {
        self.frame += 1;
        let mut wrong = Vec::new();
        let seen: Vec<_> = curves
            .iter()
            .filter(|c| c.status != SeenStatus::Lost)
            .collect();
        let share = |rope: &TrueRope| {
            rope.seen.iter().filter(|&&s| s).count() as f64 / rope.seen.len() as f64
        };
        // A rope that is just coming in or leaving counts neither as missed nor as wrong.
        let sure: Vec<_> = truth.iter().filter(|rope| share(rope) >= 0.5).collect();
        if seen.len() < sure.len()
            || seen.len() > truth.iter().filter(|rope| share(rope) > 0.0).count()
        {
            self.verdict.miscounted += 1;
            wrong.push(format!("{} curves for {} ropes", seen.len(), sure.len()));
        }
        for rope in &sure {
            self.verdict.shown += 1;
            let best = seen
                .iter()
                .map(|curve| (fit(curve, rope), **curve))
                .min_by(|a, b| {
                    (a.0.beside + 0.2 * a.0.order).total_cmp(&(b.0.beside + 0.2 * b.0.order))
                });
            match best {
                Some((fit, curve)) if fit.beside <= 1.0 => {
                    self.compare(rope, share(rope), &fit, &curve, &mut wrong)
                }
                _ => {
                    self.verdict.missed += 1;
                    wrong.push(format!("rope {} missed", rope.identity));
                }
            }
        }
        for curve in &seen {
            if !truth.iter().any(|rope| fit(curve, rope).beside <= 2.0) {
                self.verdict.invented += 1;
                wrong.push(format!("track {} lies on no rope", curve.track));
            }
        }
        wrong
    }

    fn compare(
        &mut self,
        rope: &TrueRope,
        share: f64,
        fit: &Fit,
        curve: &SeenCurve,
        wrong: &mut Vec<String>,
    ) {
        let inside = rope.seen[0] && rope.seen[rope.seen.len() - 1];
        // If an end is out of view, points of the same index are not at the same place.
        if inside && fit.order > 2.0 {
            self.verdict.exchanged += 1;
            wrong.push(format!(
                "rope {} not in its order: {:.1} widths",
                rope.identity, fit.order
            ));
        }
        let mut now = Identity {
            identity: rope.identity,
            track: curve.track,
            reversed: fit.reversed,
            frame: self.frame,
        };
        let known = self.known.iter_mut().find(|k| k.identity == rope.identity);
        match known {
            None => self.known.push(now),
            Some(known) => {
                let forgotten = known.frame + FORGOTTEN < self.frame;
                if !forgotten && known.track != now.track {
                    self.verdict.swaps += 1;
                    wrong.push(format!(
                        "rope {}: track {} is {} now",
                        rope.identity, known.track, now.track
                    ));
                } else if !forgotten && inside && known.reversed != now.reversed {
                    self.verdict.flips += 1;
                    wrong.push(format!("rope {} flipped", rope.identity));
                }
                if !inside {
                    now.reversed = known.reversed;
                }
                *known = now;
            }
        }
        let is_whole = share == 1.0;
        if inside && (curve.status == SeenStatus::Ok) != is_whole {
            self.verdict.misjudged += 1;
            wrong.push(format!(
                "rope {} is {:?} with {:.0} % seen",
                rope.identity,
                curve.status,
                100.0 * share
            ));
        }
        if inside && fit.order <= 2.0 {
            self.mark(rope, fit, curve);
        }
    }

    /// Compares the hidden marks, except within two widths of a change.
    fn mark(&mut self, rope: &TrueRope, fit: &Fit, curve: &SeenCurve) {
        let (n, m) = (curve.points.len(), rope.points.len());
        let length: f64 = rope.points.windows(2).map(|p| distance(p[0], p[1])).sum();
        let margin = (2.0 * rope.width_px / length * m as f64) as usize;
        for (i, &hidden) in curve.hidden.iter().enumerate() {
            let k = i * (m - 1) / (n - 1).max(1);
            let k = if fit.reversed { m - 1 - k } else { k };
            let around = &rope.seen[k.saturating_sub(margin)..(k + margin + 1).min(m)];
            if around.iter().all(|&s| s == around[0]) {
                self.verdict.marked += 1;
                self.verdict.mismarked += u64::from(hidden == around[0]);
            }
        }
    }

    /// Returns the error counts so far.
    pub fn verdict(&self) -> Verdict {
        self.verdict
    }
}

fn fit(curve: &SeenCurve, rope: &TrueRope) -> Fit {
    let n = curve.points.len();
    let m = rope.points.len();
    let at = |i: usize| curve.points[i].map(f64::from);
    let truth = |i: usize| {
        let place = i as f64 * (m - 1) as f64 / (n - 1).max(1) as f64;
        let k = (place as usize).min(m - 2);
        let (p, q) = (rope.points[k], rope.points[k + 1]);
        [0, 1].map(|axis| p[axis] + (q[axis] - p[axis]) * (place - k as f64))
    };
    let mut ahead: Vec<f64> = (0..n).map(|i| distance(at(i), truth(i))).collect();
    let mut back: Vec<f64> = (0..n).map(|i| distance(at(i), truth(n - 1 - i))).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / n.max(1) as f64;
    let reversed = mean(&back) < mean(&ahead);
    let order = if reversed { &mut back } else { &mut ahead };
    order.sort_by(f64::total_cmp);
    let beside: f64 = (0..n).map(|i| to_line(at(i), &rope.points)).sum();
    Fit {
        beside: beside / n.max(1) as f64 / rope.width_px,
        order: order
            .get(n * 95 / 100)
            .map_or(f64::INFINITY, |d| d / rope.width_px),
        reversed,
    }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    square_of_distance(a, b).sqrt()
}

fn square_of_distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1]];
    d[0] * d[0] + d[1] * d[1]
}

fn to_line(p: [f64; 2], line: &[[f64; 2]]) -> f64 {
    let segments = line.windows(2).map(|pair| {
        let (a, b) = (pair[0], pair[1]);
        let d = [b[0] - a[0], b[1] - a[1]];
        let square = (d[0] * d[0] + d[1] * d[1]).max(1e-12);
        let t = (((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / square).clamp(0.0, 1.0);
        square_of_distance(p, [a[0] + t * d[0], a[1] + t * d[1]])
    });
    segments.fold(f64::INFINITY, f64::min).sqrt()
}
