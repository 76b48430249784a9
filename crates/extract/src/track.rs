//! Which rope is which, from one image to the next.
//!
//! Two curves are compared point by point, in both directions; the nearest pairs are matched first.
//! The direction that fits better is kept, so that a rope's first point stays its first. A rope
//! without a match is out of sight and keeps its number for a while; one that comes into sight takes
//! the number of a lost rope of about its length, or else a new one.

use crate::Options;
use crate::past::Past;
use crate::scene::{Curve, Status};
use crate::vec2::{self, Vec2};

/// A match is not farther, in the mean, than this share of the rope's length.
const FARTHEST: f32 = 0.15;
/// A lost rope may come back elsewhere, with its length within this factor.
const LENGTH_FACTOR: f32 = 1.35;
/// Shorter than this share of its longest, a rope is seen in part. Perspective and slack change the
/// length less.
const PARTIAL: f32 = 0.85;

/// Frames after which a rope is missed when it goes out of sight.
const SETTLED: u32 = 3;

/// Memory of the tracking: all ropes, seen or lost.
#[derive(Debug, Default)]
pub(crate) struct Tracker {
    tracks: Vec<Track>,
    /// Tracks that are done with, kept for their memory.
    spare: Vec<Track>,
    matches: Vec<Match>,
    next: u32,
    started: bool,
}

#[derive(Debug)]
struct Track {
    number: u32,
    /// Frames since it was last seen; 0: now.
    age: u32,
    /// Frames in which it was seen.
    frames: u32,
    /// The curve of this image that it is.
    current: Option<usize>,
    closed: bool,
    border: [bool; 2],
    points: Vec<Vec2>,
    widths_px: Vec<f32>,
    width_px: f32,
    length_px: f32,
    /// Its usual length while seen whole: what "in part" is told by.
    whole_px: f32,
}

#[derive(Clone, Copy, Debug)]
struct Match {
    cost: f32,
    track: usize,
    curve: usize,
}

impl Tracker {
    /// Forgets all ropes; numbers go on.
    pub(crate) fn reset(&mut self) {
        self.spare.append(&mut self.tracks);
        self.started = false;
    }

    /// Numbers ropes from the first again.
    pub(crate) fn restart(&mut self) {
        self.next = 0;
    }

    /// Writes the ropes as they were last seen into `past`.
    pub(crate) fn remember(&self, past: &mut Past) {
        past.clear();
        for track in &self.tracks {
            let sizes_px = [track.length_px, track.width_px];
            past.add(track.number, track.closed, sizes_px, &track.points);
        }
    }

    /// Numbers and turns the curves of a new image, and says which lost ropes are to be reported by
    /// appending them to `curves` from `count` on. Returns the new count.
    pub(crate) fn update(
        &mut self,
        curves: &mut Vec<Curve>,
        count: usize,
        options: &Options,
    ) -> usize {
        for track in &mut self.tracks {
            track.current = None;
            track.age += 1;
        }
        self.match_near(&curves[..count]);
        self.match_lost(&curves[..count]);
        for (c, curve) in curves.iter_mut().enumerate().take(count) {
            if !self.tracks.iter().any(|t| t.current == Some(c)) {
                self.orient_new(curve, options.start);
                self.add(c);
            }
        }
        self.started |= count > 0;
        for t in 0..self.tracks.len() {
            if let Some(c) = self.tracks[t].current {
                self.see(t, &mut curves[c]);
            }
        }
        let mut t = 0;
        while t < self.tracks.len() {
            let track = &self.tracks[t];
            // What was seen for a moment only was hardly a rope: it is not missed.
            let missed = track.frames >= SETTLED && track.age <= options.keep_lost_frames;
            if track.age > 0 && !missed {
                let gone = self.tracks.remove(t);
                self.spare.push(gone);
            } else {
                t += 1;
            }
        }
        self.report_lost(curves, count, options.ropes)
    }

    /// Matches tracks and curves that lie near each other, the nearest first.
    fn match_near(&mut self, curves: &[Curve]) {
        self.matches.clear();
        for (t, track) in self.tracks.iter().enumerate() {
            for (c, curve) in curves.iter().enumerate() {
                if track.points.len() != curve.points.len() || track.closed != curve.closed {
                    continue;
                }
                let (ahead, back) = distances(&track.points, &curve.points, curve.closed);
                let cost = ahead.min(back);
                let limit = FARTHEST * track.length_px.max(curve.length_px);
                if cost <= limit + 4.0 * track.width_px {
                    self.matches.push(Match {
                        cost,
                        track: t,
                        curve: c,
                    });
                }
            }
        }
        self.matches
            .sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost));
        self.take_matches();
    }

    /// Matches what is left of tracks and curves by length alone.
    fn match_lost(&mut self, curves: &[Curve]) {
        self.matches.clear();
        for (t, track) in self.tracks.iter().enumerate() {
            for (c, curve) in curves.iter().enumerate() {
                let ratio =
                    (track.whole_px / curve.length_px).max(curve.length_px / track.whole_px);
                let same_kind =
                    track.points.len() == curve.points.len() && track.closed == curve.closed;
                if track.age > 1 && same_kind && ratio <= LENGTH_FACTOR {
                    self.matches.push(Match {
                        cost: ratio,
                        track: t,
                        curve: c,
                    });
                }
            }
        }
        self.matches
            .sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost));
        self.take_matches();
    }

    fn take_matches(&mut self) {
        for i in 0..self.matches.len() {
            let m = self.matches[i];
            let taken = self.tracks.iter().any(|t| t.current == Some(m.curve));
            if !taken && self.tracks[m.track].current.is_none() {
                self.tracks[m.track].current = Some(m.curve);
            }
        }
    }

    /// A new rope begins at the end nearest to `start` or, without one, to the top left.
    fn orient_new(&mut self, curve: &mut Curve, start: Option<Vec2>) {
        let goal = match start {
            Some(goal) if !self.started => goal,
            _ => [0.0, 0.0],
        };
        if curve.closed {
            let nearest = nearest_point(&curve.points, goal);
            curve.points.rotate_left(nearest);
            curve.widths_px.rotate_left(nearest);
            if signed_area(&curve.points) < 0.0 {
                reverse(curve);
            }
        } else if let (Some(&first), Some(&last)) = (curve.points.first(), curve.points.last())
            && vec2::distance(last, goal) < vec2::distance(first, goal)
        {
            reverse(curve);
        }
    }

    fn add(&mut self, curve: usize) {
        let mut track = self.spare.pop().unwrap_or_else(|| Track {
            number: 0,
            age: 0,
            frames: 0,
            current: None,
            closed: false,
            border: [false; 2],
            points: Vec::new(),
            widths_px: Vec::new(),
            width_px: 0.0,
            length_px: 0.0,
            whole_px: 0.0,
        });
        track.number = self.next;
        self.next = self.next.wrapping_add(1);
        track.current = Some(curve);
        track.points.clear();
        track.whole_px = 0.0;
        track.frames = 0;
        track.age = 0;
        self.tracks.push(track);
    }

    /// Turns the curve as its track was, and takes it as the track's newest shape.
    fn see(&mut self, t: usize, curve: &mut Curve) {
        let track = &mut self.tracks[t];
        if track.points.len() == curve.points.len() {
            if curve.closed {
                align_ring(&track.points, curve);
            } else {
                let (ahead, back) = distances(&track.points, &curve.points, false);
                if back < ahead {
                    reverse(curve);
                }
            }
        }
        curve.track = track.number;
        let cut = curve.border[0] || curve.border[1] || track.border[0] || track.border[1];
        // The usual length follows growth at once and shrinking slowly: a rope that stays short
        // is a shorter view of it, not half hidden for ever.
        track.whole_px = if cut || curve.length_px > track.whole_px {
            curve.length_px
        } else {
            0.98 * track.whole_px + 0.02 * curve.length_px
        };
        let whole = curve.length_px >= PARTIAL * track.whole_px;
        curve.status = if whole { Status::Ok } else { Status::Partial };
        track.age = 0;
        track.frames = track.frames.saturating_add(1);
        track.closed = curve.closed;
        track.border = curve.border;
        track.points.clear();
        track.points.extend_from_slice(&curve.points);
        track.widths_px.clear();
        track.widths_px.extend_from_slice(&curve.widths_px);
        (track.width_px, track.length_px) = (curve.width_px, curve.length_px);
    }

    fn report_lost(&self, curves: &mut Vec<Curve>, count: usize, most: usize) -> usize {
        let mut count = count;
        for track in self.tracks.iter().filter(|t| t.current.is_none()) {
            if count >= most {
                break;
            }
            if count == curves.len() {
                curves.push(Curve::empty());
            }
            let curve = &mut curves[count];
            curve.track = track.number;
            curve.status = Status::Lost;
            curve.closed = track.closed;
            curve.border = track.border;
            curve.points.clear();
            curve.points.extend_from_slice(&track.points);
            curve.widths_px.clear();
            curve.widths_px.extend_from_slice(&track.widths_px);
            (curve.width_px, curve.length_px) = (track.width_px, track.length_px);
            count += 1;
        }
        count
    }
}

/// The mean distance of corresponding points, and that of points taken in opposite directions. A
/// ring's points correspond from wherever they lie nearest.
fn distances(a: &[Vec2], b: &[Vec2], closed: bool) -> (f32, f32) {
    let n = a.len();
    if n == 0 {
        return (f32::INFINITY, f32::INFINITY);
    }
    let shift = if closed { nearest_point(b, a[0]) } else { 0 };
    let (mut ahead, mut back) = (0.0, 0.0);
    for (i, &p) in a.iter().enumerate() {
        ahead += vec2::distance(p, b[(i + shift) % n]);
        let opposite = if closed {
            (shift + n - i) % n
        } else {
            n - 1 - i
        };
        back += vec2::distance(p, b[opposite]);
    }
    (ahead / n as f32, back / n as f32)
}

/// Turns a ring so that it runs as the last one did and starts nearest to where that started.
fn align_ring(last: &[Vec2], curve: &mut Curve) {
    let (ahead, back) = distances(last, &curve.points, true);
    if back < ahead {
        reverse(curve);
    }
    let shift = nearest_point(&curve.points, last[0]);
    curve.points.rotate_left(shift);
    curve.widths_px.rotate_left(shift);
}

fn reverse(curve: &mut Curve) {
    curve.points.reverse();
    curve.widths_px.reverse();
    curve.border.swap(0, 1);
}

fn nearest_point(points: &[Vec2], goal: Vec2) -> usize {
    let by_distance = |&a: &usize, &b: &usize| {
        vec2::distance(points[a], goal).total_cmp(&vec2::distance(points[b], goal))
    };
    (0..points.len()).min_by(by_distance).unwrap_or(0)
}

fn signed_area(points: &[Vec2]) -> f32 {
    let n = points.len();
    (0..n)
        .map(|i| vec2::cross(points[i], points[(i + 1) % n]))
        .sum()
}
