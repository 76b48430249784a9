//! Where centerlines cross, and which of the two ropes lies on top.
//!
//! Only around the zones of the graph can lines cross; there their segments are intersected. The
//! upper rope's surface goes on undisturbed through a crossing, the lower one's is broken by the
//! upper one's edges and shadow: so the upper rope is the one along which the image's color varies
//! less. How clear that is becomes the confidence.

use crate::Image;
use crate::color;
use crate::graph::Graph;
use crate::line::Line;
use crate::scene::{Crossing, Curve};
use crate::skeleton::Skeleton;
use crate::vec2::{self, Vec2};
use crate::zones::Zones;

/// The most crossings reported.
const MOST: usize = 32;
/// The most segments looked at around one zone.
const MOST_SEGMENTS: usize = 512;
/// Levels of variation that mean nothing: noise and coding.
const NOISE_LEVELS: f32 = 12.0;

/// Memory of the step.
#[derive(Debug, Default)]
pub(crate) struct Crosser {
    near: Vec<Segment>,
    found: Vec<Found>,
}

/// Segment `index` of line `line`.
#[derive(Clone, Copy, Debug)]
struct Segment {
    line: usize,
    index: usize,
}

/// Two places on lines that lie over each other: line and sample (with its fraction) of each.
#[derive(Clone, Copy, Debug)]
struct Found {
    at: Vec2,
    a: (usize, f32),
    b: (usize, f32),
}

impl Crosser {
    /// Finds the crossings of `lines`, whose finished curves are `curves`.
    pub(crate) fn find(
        &mut self,
        image: &Image,
        (graph, skeleton, zones): (&Graph, &Skeleton, &Zones),
        lines: &[Line],
        curves: &[Curve],
        out: &mut Vec<Crossing>,
    ) {
        out.clear();
        self.found.clear();
        let mut from = 0;
        while from < zones.arms.len() && self.found.len() < MOST {
            let to = zones.zone_end(from);
            if to - from >= 4 {
                let nodes = || {
                    zones.arms[from..to].iter().map(|arm| {
                        let edge = &graph.edges[arm.edge as usize];
                        let node = edge.nodes[usize::from(arm.end)];
                        skeleton.pixels[graph.nodes[node as usize].pixel as usize].at()
                    })
                };
                let sum = nodes().fold([0.0; 2], vec2::add);
                let center = vec2::scale(sum, 1.0 / (to - from) as f32);
                let spread = nodes()
                    .map(|n| vec2::distance(n, center))
                    .fold(0.0, f32::max);
                self.intersect(
                    center,
                    spread + 4.0 * zones.half_px + 2.0,
                    lines,
                    zones.half_px,
                );
            }
            from = to;
        }
        for found in self.found.iter().take(MOST) {
            out.push(order(image, found, lines, curves));
        }
    }

    /// Intersects all segments within `radius` of `center` with each other.
    fn intersect(&mut self, center: Vec2, radius: f32, lines: &[Line], half_px: f32) {
        self.near.clear();
        for (l, line) in lines.iter().enumerate() {
            for (index, sample) in line.samples.iter().enumerate() {
                let close = vec2::distance(sample.at, center) <= radius;
                if close && index + 1 < line.samples.len() && self.near.len() < MOST_SEGMENTS {
                    self.near.push(Segment { line: l, index });
                }
            }
        }
        for (i, p) in self.near.iter().enumerate() {
            for q in &self.near[i + 1..] {
                if p.line == q.line && q.index <= p.index + 2 {
                    continue;
                }
                let of = |s: &Segment, k: usize| lines[s.line].samples[s.index + k].at;
                let Some((t, u)) = meet(of(p, 0), of(p, 1), of(q, 0), of(q, 1)) else {
                    continue;
                };
                let at = vec2::along(of(p, 0), vec2::sub(of(p, 1), of(p, 0)), t);
                // Neighboring zones see the same crossing; lines that touch meet again and again.
                let known = |f: &Found| {
                    (f.a.0, f.b.0) == (p.line, q.line)
                        && vec2::distance(f.at, at) < 2.0 * half_px + 1.0
                };
                if !self.found.iter().any(known) {
                    let a = (p.line, p.index as f32 + t);
                    self.found.push(Found {
                        at,
                        a,
                        b: (q.line, q.index as f32 + u),
                    });
                }
            }
        }
    }
}

/// Where on the segments a–b and c–d they meet, as shares of each.
fn meet(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> Option<(f32, f32)> {
    let (ab, cd, ac) = (vec2::sub(b, a), vec2::sub(d, c), vec2::sub(c, a));
    let area = vec2::cross(ab, cd);
    if area.abs() < 1e-9 {
        return None;
    }
    let (t, u) = (vec2::cross(ac, cd) / area, vec2::cross(ac, ab) / area);
    let inside = |v: f32| (0.0..1.0).contains(&v);
    (inside(t) && inside(u)).then_some((t, u))
}

/// Says which of the two is on top.
fn order(image: &Image, found: &Found, lines: &[Line], curves: &[Curve]) -> Crossing {
    let tangent = |(line, at): (usize, f32)| lines[line].tangent(at as usize, 2);
    let sin = vec2::cross(tangent(found.a), tangent(found.b))
        .abs()
        .max(0.2);
    let reach = |other: usize| 0.5 * curves[other].width_px / sin + 2.5;
    let va = variation(image, &lines[found.a.0], found.a.1, reach(found.b.0));
    let vb = variation(image, &lines[found.b.0], found.b.1, reach(found.a.0));
    // Per pixel of way, so that a flat crossing does not count against either.
    let (va, vb) = (va / reach(found.b.0), vb / reach(found.a.0));
    let noise = NOISE_LEVELS / (reach(found.a.0) + reach(found.b.0));
    let confidence = ((va - vb).abs() / (va + vb + noise)).min(1.0);
    let (over, under) = if va <= vb {
        (found.a, found.b)
    } else {
        (found.b, found.a)
    };
    let rho = |(line, at): (usize, f32)| rho(&lines[line], at, &curves[line]);
    Crossing {
        at: found.at,
        over: over.0,
        under: under.0,
        over_rho: rho(over),
        under_rho: rho(under),
        confidence,
    }
}

/// How much the image's color changes along `line`, `reach_px` to both sides of sample `at`.
fn variation(image: &Image, line: &Line, at: f32, reach_px: f32) -> f32 {
    let n = line.samples.len();
    let step_px = line.length_px() / (n.max(2) - 1) as f32;
    let span = reach_px / step_px.max(0.1);
    let (from, to) = (
        (at - span).max(0.0) as usize,
        ((at + span) as usize + 1).min(n - 1),
    );
    let yuv = color::is_yuv(image.format());
    let mut sum = 0.0;
    let mut before = color::between(image, line.samples[from].at);
    for sample in &line.samples[from + 1..=to.max(from)] {
        let here = color::between(image, sample.at);
        sum += color::distance(here, before, yuv);
        before = here;
    }
    sum
}

/// The normalized arc length on the finished curve, which may run the other way, or begin elsewhere
/// when it is closed.
fn rho(line: &Line, at: f32, curve: &Curve) -> f32 {
    let n = line.samples.len();
    let intervals = if line.closed { n } else { n - 1 };
    let along = at / intervals as f32;
    let nearest = |p: Vec2| {
        (0..curve.points.len())
            .min_by(|&i, &j| {
                vec2::distance(curve.points[i], p).total_cmp(&vec2::distance(curve.points[j], p))
            })
            .unwrap_or(0)
    };
    if !line.closed {
        let ends = [0, curve.points.len() - 1].map(|i| curve.points[i]);
        let first = line.samples[0].at;
        let reversed = vec2::distance(first, ends[1]) < vec2::distance(first, ends[0]);
        return if reversed { 1.0 - along } else { along };
    }
    let (start, quarter) = (nearest(line.samples[0].at), nearest(line.samples[n / 4].at));
    let count = curve.points.len();
    let forward = (quarter + count - start) % count <= count / 2;
    let shift = start as f32 / count as f32;
    (if forward {
        shift + along
    } else {
        shift - along
    })
    .rem_euclid(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_meet_where_they_cross() {
        let met = meet([0.0, 0.0], [4.0, 4.0], [0.0, 2.0], [4.0, 2.0]);
        assert_eq!(met, Some((0.5, 0.5)));
        assert_eq!(meet([0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]), None);
    }
}
