//! Movement of a rope's points. Readings that agree with their neighbors count, and the points
//! between are interpolated.

use super::read::Measurement;
use super::station::Station;
use crate::vec2::{self, Vec2};

/// Range of a width, relative to the rope's width there.
const WIDTH: std::ops::RangeInclusive<f32> = 0.8..=1.25;
/// Weight of a point with one edge, relative to one with two.
const ONE_EDGE: f32 = 0.4;
/// Same in the first round, as the edge may belong to something else.
const ONE_EDGE_AT_FIRST: f32 = 0.2;
/// Maximum difference of a reading from those around it, in pixels plus widths.
const UNLIKE: (f32, f32) = (1.0, 0.06);
/// Distance on either side that is "around", in widths.
const AROUND_WIDTHS: f32 = 2.5;
/// Minimum and maximum number of points on either side for that.
const AROUND: (usize, usize) = (3, 10);
/// Length of the rope, in widths, whose turn an unread part at an end follows. A longer unread part
/// does not turn.
const TURNS_WIDTHS: f32 = 1.5;

/// Sideways movement of a point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Move {
    pub(super) px: f32,
    /// 0 without a reading.
    pub(super) weight: f32,
}

/// Buffers.
#[derive(Debug, Default)]
pub(super) struct Motion {
    pub(super) moves: Vec<Move>,
    means: Vec<Option<f32>>,
    pub(super) shifts: Vec<Vec2>,
}

impl Motion {
    pub(super) fn reserve(&mut self, points: usize) {
        self.moves.reserve(points);
        self.means.reserve(points);
        self.shifts.reserve(points);
    }

    /// Computes the movement of each point from its readings, dropping those that differ from the
    /// others.
    pub(super) fn agree(
        &mut self,
        stations: &[Station],
        readings: &[Measurement],
        (closed, spacing_px, width_px): (bool, f32, f32),
    ) {
        let reach = ((AROUND_WIDTHS * width_px / spacing_px) as usize).clamp(AROUND.0, AROUND.1);
        let most_px = UNLIKE.0 + UNLIKE.1 * width_px;
        self.moves.clear();
        let all = stations.iter().zip(readings);
        self.moves.extend(all.map(|(s, reading)| first(s, reading)));
        for _ in 0..2 {
            self.look_around(closed, reach);
            let said = stations.iter().zip(readings).zip(&self.means);
            for (to, ((station, reading), &mean)) in self.moves.iter_mut().zip(said) {
                *to = mean.map_or(Move::default(), |mean| {
                    likely(station, reading, mean, most_px)
                });
            }
        }
    }

    /// Computes the mean movement around each point.
    fn look_around(&mut self, closed: bool, reach: usize) {
        let (moves, n) = (&self.moves, self.moves.len());
        let at = |i: isize| -> Move {
            let inside = (0..n as isize).contains(&i);
            match (inside, closed) {
                (true, _) => moves[i as usize],
                (false, true) => moves[i.rem_euclid(n as isize) as usize],
                (false, false) => Move::default(),
            }
        };
        let reach = reach as isize;
        let (mut sum, mut weight) = (0.0f32, 0.0f32);
        let mut add = |to: Move, sign: f32| {
            sum += sign * to.weight * to.px;
            weight += sign * to.weight;
            (sum, weight)
        };
        for i in -reach..reach {
            add(at(i), 1.0);
        }
        self.means.clear();
        for i in 0..n as isize {
            let (sum, weight) = add(at(i + reach), 1.0);
            self.means.push((weight > 0.5).then(|| sum / weight));
            add(at(i - reach), -1.0);
        }
    }

    /// Computes the shift of each point: its own movement, or interpolated from those around it.
    pub(super) fn shift(&mut self, stations: &[Station], closed: bool, width_px: f32) {
        let n = stations.len();
        let moves = &self.moves;
        self.shifts.clear();
        let own = stations.iter().zip(moves);
        self.shifts
            .extend(own.map(|(s, by)| vec2::scale(s.normal, by.px)));
        let said = |i: usize| moves[i % n].weight > 0.0;
        let Some(begin) = (0..n).find(|&i| said(i)) else {
            return;
        };
        // From one point with a reading to the next, around a ring.
        let end = if closed { begin + n } else { n };
        let mut from = begin;
        for i in begin + 1..=end {
            if (i == n && !closed) || !said(i) {
                continue;
            }
            let ([a, b], count) = ([self.shifts[from % n], self.shifts[i % n]], i - from);
            for k in 1..count {
                let share = k as f32 / count as f32;
                self.shifts[(from + k) % n] = vec2::along(a, vec2::sub(b, a), share);
            }
            from = i;
        }
        if !closed {
            self.carry_end(stations, begin, width_px, |i| i);
            self.carry_end(stations, n - 1 - from, width_px, |i| n - 1 - i);
        }
    }

    /// Shifts the points before the `unread`-th from an end, with those after it.
    fn carry_end(
        &mut self,
        stations: &[Station],
        unread: usize,
        width_px: f32,
        place: impl Fn(usize) -> usize,
    ) {
        let n = stations.len();
        let here = place(unread);
        let shift = self.shifts[here];
        let at = |i: usize| stations[place(i)].at;
        let spacing_px = vec2::distance(at(0), at(1)).max(0.1);
        let turns = unread as f32 * spacing_px <= TURNS_WIDTHS * width_px;
        let back = unread + ((TURNS_WIDTHS * width_px / spacing_px) as usize).max(2);
        let mut turn = 0.0;
        if turns && back < n {
            let was = vec2::sub(at(unread), at(back));
            let by = vec2::sub(shift, self.shifts[place(back)]);
            turn = vec2::angle(was, vec2::add(was, by));
        }
        let (sin, cos) = libm::sincosf(turn);
        for i in 0..unread {
            let arm = vec2::sub(at(i), at(unread));
            let turned = [cos * arm[0] - sin * arm[1], sin * arm[0] + cos * arm[1]];
            self.shifts[place(i)] = vec2::add(shift, vec2::sub(turned, arm));
        }
    }
}

/// Movement of a point by its own readings.
#[inline(always)]
fn first(station: &Station, reading: &Measurement) -> Move {
    match reading.off_px {
        [Some(a), Some(b)] if fits(station, b - a) => Move {
            px: 0.5 * (a + b),
            weight: 1.0,
        },
        [Some(px), None] | [None, Some(px)] => Move {
            px,
            weight: ONE_EDGE_AT_FIRST,
        },
        _ => Move::default(),
    }
}

/// Movement of a point, given the mean movement around it. Both edges count if they agree with that
/// mean, otherwise the one that does.
#[inline(always)]
fn likely(station: &Station, reading: &Measurement, mean: f32, most_px: f32) -> Move {
    let whole = first(station, reading);
    if whole.weight == 1.0 && (whole.px - mean).abs() <= most_px {
        return whole;
    }
    let off = |px: &f32| (px - mean).abs();
    let edges = reading
        .off_px
        .iter()
        .flatten()
        .filter(|px| off(px) <= most_px);
    let nearest = edges.min_by(|a, b| off(a).total_cmp(&off(b)));
    nearest.map_or(Move::default(), |&px| Move {
        px,
        weight: ONE_EDGE,
    })
}

fn fits(station: &Station, wider_px: f32) -> bool {
    WIDTH.contains(&(1.0 + wider_px / station.width_px.max(0.1)))
}
