//! Follows what an extractor says of a film and counts what it says wrong.

use super::TrueRope;

/// What is said of a rope's state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeenStatus {
    /// Seen whole.
    Ok,
    /// Seen in part.
    Partial,
    /// Not seen now.
    Lost,
}

/// A curve as an extractor gives it.
#[derive(Debug, Clone, Copy)]
pub struct SeenCurve<'a> {
    /// The rope's number.
    pub track: u32,
    /// Its state.
    pub status: SeenStatus,
    /// Its points at equal steps of arc length.
    pub points: &'a [[f32; 2]],
    /// Which of them are marked as hidden.
    pub hidden: &'a [bool],
}

/// What was wrong, in frames (of each rope).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Verdict {
    /// Ropes that were there, a frame each: at least half of a rope seen.
    pub shown: u64,
    /// Of those, ropes that no curve lay on.
    pub missed: u64,
    /// Frames whose number of curves was not that of the ropes.
    pub miscounted: u64,
    /// Times that a rope's direction turned around.
    pub flips: u64,
    /// Times that a rope's number changed.
    pub swaps: u64,
    /// Curves that lay on their rope but not in its order: strands exchanged, loops left out.
    pub exchanged: u64,
    /// Curves said to be seen that lay on no rope.
    pub invented: u64,
    /// Ropes seen whole that were not said to be `Ok`, or with a part hidden that were.
    pub misjudged: u64,
    /// Points of curves on their rope that were hidden and not marked, or marked and seen.
    pub mismarked: u64,
    /// Points asked for that.
    pub marked: u64,
}

impl Verdict {
    /// What was wrong of the ropes' places, numbers and directions: missed, miscounted, turned, renamed, exchanged, invented.
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

/// Follows one film.
#[derive(Debug, Default)]
pub struct Judge {
    known: Vec<Identity>,
    frame: u64,
    verdict: Verdict,
}

/// What was said of a rope when it was last seen.
#[derive(Debug, Clone, Copy)]
struct Identity {
    identity: u32,
    track: u32,
    /// Whether the curve ran against the truth.
    reversed: bool,
    frame: u64,
}

/// Frames after which a rope that was gone may have any number.
const FORGOTTEN: u64 = 30;

/// How a curve lies to a rope.
struct Fit {
    /// Mean distance of its points from the rope's line, in widths.
    beside: f64,
    /// 95th percentile of the distance of points of one number, in widths.
    order: f64,
    reversed: bool,
}

impl Judge {
    /// Takes one frame's truth and answer; returns what was wrong in it, in words.
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
        // A rope that is just coming in or going is neither missed nor wrong.
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
        // With an end out of sight points of one number are not one place.
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

    /// Compares the points marked as hidden, but within two widths of where that changes.
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

    /// What was wrong until now.
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
