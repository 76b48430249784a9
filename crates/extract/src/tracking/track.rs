//! Identity of ropes from one image to the next.
//!
//! Ropes and curves are matched greedily, in order of their cost (`matching`). First come near
//! matches, then lost ropes that return. The better direction is kept, so that a rope's first point
//! stays its first. A curve without a match is a new rope. A rope without a match is out of sight,
//! and keeps its number for a while. A curve that is shorter than its rope was may be a part of the
//! rope.

use super::complete::Completer;
use super::matching::{self, Agreement, Shape, nearest_point};
use super::turn::{align_ring, open_ring, reverse, rotate, signed_area};
use super::usual::UsualLength;
use crate::image::color;
use crate::judge::Evidence;
use crate::options::Options;
use crate::past::{Past, State};
use crate::scene::{Curve, Status};
use crate::vec2::{Vec2, distance};

/// Maximum length of a rope seen in part, relative to its usual length. Perspective and slack
/// change the length less.
const PARTIAL: f32 = 0.85;
/// Minimum distance back along the rope, in widths, for a tip to be covered instead of moved. No
/// rope slides along itself that far from one image to the next.
const JUMP_WIDTHS: f32 = 1.5;
/// Minimum loss of length for this, as a share of the rope, in addition to `JUMP_WIDTHS`. The
/// length of a rope seen whole varies by less.
const JUMP_SHARE: f32 = 0.015;
/// Maximum change of a rope's width from one image to the next, as a share.
const WIDTH_PACE: f32 = 0.05;
/// Number of frames in which a rope must be seen before it is reported as lost.
const SETTLED: u32 = 3;
/// Number of frames after which a rope is as well known as possible.
const LONG: u32 = 100;
/// Number of undoubted frames after which a curve is known to be a rope, and is not doubted.
const KNOWN: i32 = 10;
/// Number of undoubted frames, after a doubt, until a curve is treated as a rope again.
const REGAINED: i32 = 3;
/// Maximum number of frames in which a sudden change of a rope's length is not believed. Only an
/// extraction error changes it like that.
const KEPT: u32 = 6;
/// Minimum sudden change of a rope's length: in widths, plus a share of the length.
const LEAP: (f32, f32) = (2.0, 0.05);
/// Maximum distance, in widths, between a rope out of sight and a visible rope for the former to
/// have been a part of the latter.
const SAME_WIDTHS: f32 = 1.0;

/// All ropes, seen or lost, and buffers.
#[derive(Debug, Default)]
pub(crate) struct Tracker {
    tracks: Vec<Track>,
    /// Finished tracks, kept for their memory.
    spare: Vec<Track>,
    matches: Vec<Match>,
    next: u32,
    started: bool,
    now_ns: u64,
    yuv: bool,
    completer: Completer,
}

#[derive(Debug, Default)]
struct Track {
    number: u32,
    /// Time at which it was last seen.
    seen_ns: u64,
    /// Number of frames since then. 0 while in sight.
    age: u32,
    /// Number of frames in which it was seen.
    frames: u32,
    /// Number of consecutive frames in which its length was not believed.
    disbelieved: u32,
    /// Index of the curve of this image that it is, and whether the curve runs against it.
    current: Option<(usize, bool)>,
    closed: bool,
    border: [bool; 2],
    /// Arc length at each end of the visible part, if that end ran into an occluder.
    covered_px: [Option<f32>; 2],
    /// Known shape: as last seen. Parts that were covered are taken from earlier frames.
    points: Vec<Vec2>,
    width_px: f32,
    length_px: f32,
    color: Option<[f32; 3]>,
    /// Confidence when it was last seen.
    confidence: f32,
    /// Usual length while seen whole, the reference for "in part".
    usual: UsualLength,
    /// Number of frames as a rope since the last doubt. Below 0, the curve may not be a rope.
    sure: i32,
}

#[derive(Clone, Copy, Debug)]
struct Match {
    agreement: Agreement,
    track: usize,
    curve: usize,
}

/// Observations of a curve for the tracker, in addition to its shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Appearance {
    /// Mean color along the curve, in the image's native format.
    pub(crate) color: [f32; 3],
    /// True for each end that runs into an occluder.
    pub(crate) covered: [bool; 2],
    /// True if the table shows beyond both ends, so that the rope is as long as it looks.
    pub(crate) free: bool,
    /// True if the image is free of occluders.
    pub(crate) is_plain: bool,
    /// True if a rope of the prior was found to be several.
    pub(crate) is_split: bool,
    /// Evidence for and against the curve.
    pub(crate) evidence: Evidence,
}

impl Tracker {
    /// Forgets all ropes. The numbers continue.
    pub(crate) fn reset(&mut self) {
        self.spare.append(&mut self.tracks);
        self.started = false;
    }

    /// Allocates buffers for ropes of this many points.
    pub(crate) fn reserve(&mut self, points: usize) {
        self.completer.reserve(3 * points);
        self.matches.reserve(256);
        self.spare.reserve(64);
        while self.spare.len() + self.tracks.len() < 16 {
            self.spare.push(Track {
                points: Vec::with_capacity(points),
                ..Track::default()
            });
        }
        self.tracks.reserve(64);
    }

    /// Number of the next new rope.
    pub(crate) fn next(&self) -> u32 {
        self.next
    }

    /// Takes over the ropes of another tracker that had reported these curves at `now_ns`.
    pub(crate) fn resume(&mut self, curves: &[Curve], next: u32, now_ns: u64) {
        self.reset();
        (self.next, self.now_ns) = (next, now_ns);
        self.started = !curves.is_empty();
        for curve in curves.iter().filter(|curve| curve.points.len() > 1) {
            let mut track = self.spare.pop().unwrap_or_default();
            track.points.clear();
            track.points.extend_from_slice(&curve.points);
            self.tracks.push(Track {
                number: curve.track,
                seen_ns: now_ns.saturating_sub(curve.age_ns),
                age: u32::from(curve.status == Status::Lost),
                frames: LONG,
                disbelieved: 0,
                current: None,
                closed: curve.closed,
                border: curve.border,
                covered_px: [None; 2],
                points: track.points,
                width_px: curve.width_px,
                length_px: curve.length_px,
                color: None,
                confidence: curve.confidence,
                usual: UsualLength::of(curve.length_px),
                sure: if curve.status == Status::Doubtful {
                    -1
                } else {
                    LONG as i32
                },
            });
        }
    }

    /// Restarts the numbering of ropes.
    pub(crate) fn restart(&mut self) {
        self.next = 0;
    }

    /// Sets the time of the current image and whether its colors are YUV. A change of the color
    /// format discards all known colors.
    pub(crate) fn begin(&mut self, now_ns: u64, yuv: bool) {
        self.now_ns = now_ns;
        if std::mem::replace(&mut self.yuv, yuv) != yuv {
            self.tracks.iter_mut().for_each(|track| track.color = None);
        }
    }

    /// Sets the time without an image.
    pub(crate) fn pass(&mut self, now_ns: u64) {
        self.now_ns = now_ns;
    }

    /// Writes the ropes as they were last seen into `past`.
    pub(crate) fn remember(&self, past: &mut Past) {
        past.clear();
        // An arm may be mistaken for a rope for a moment. Its width must then not become the known
        // width that would hide it as an occluder.
        let longest = self.tracks.iter().map(|track| track.frames).max();
        for track in &self.tracks {
            if 2 * track.frames.min(LONG) >= longest.unwrap_or(0).min(LONG) {
                past.know(track.width_px);
            }
            let sizes_px = [track.length_px, track.width_px, track.usual.px];
            let state = State {
                live: track.age == 0 && track.frames >= SETTLED,
                whole: track.border == [false; 2],
                was_free: track.usual.is_sure(),
            };
            past.add_covered(
                track.closed,
                sizes_px,
                &track.points,
                track.covered_px,
                state,
            );
        }
    }

    /// Numbers and aligns the `count` curves of a new image, and appends the lost ropes. Returns the
    /// number of all curves.
    pub(crate) fn update(
        &mut self,
        curves: &mut Vec<Curve>,
        count: usize,
        appearances: &mut [Appearance],
        options: &Options,
    ) -> usize {
        for track in &mut self.tracks {
            track.current = None;
            track.age = track.age.saturating_add(1);
        }
        self.match_with(&curves[..count], appearances, |track, rope, curve| {
            let agreement = matching::near(rope, curve)?;
            // Among ropes at equal distance, one in sight wins over a lost one, and a long-known
            // one over a new one.
            let (frames, age) = (track.frames.min(LONG) as f32, track.age.min(2) as f32);
            let doubt = age - frames / LONG as f32;
            let cost = agreement.cost + doubt * rope.width_px;
            Some(Agreement { cost, ..agreement })
        });
        self.match_with(&curves[..count], appearances, |track, rope, curve| {
            let was_lost = track.age > 1;
            was_lost.then(|| matching::returned(rope, track.usual.px, curve))?
        });
        for (c, curve) in curves.iter_mut().enumerate().take(count) {
            if !self.tracks.iter().any(|t| is_current(t, c)) {
                if self.orient_new(curve, options.start) {
                    appearances[c].covered.swap(0, 1);
                }
                self.add(c);
            }
        }
        self.started |= count > 0;
        for t in 0..self.tracks.len() {
            if let Some((c, reversed)) = self.tracks[t].current {
                let track = &mut self.tracks[t];
                see(
                    track,
                    &mut curves[c],
                    &mut appearances[c],
                    reversed,
                    &mut self.completer,
                );
                track.seen_ns = self.now_ns;
            }
        }
        self.drop_old(options.keep_lost.as_nanos());
        self.report_lost(curves, count, options.ropes)
    }

    /// Returns whether the rope of this number has been treated as a rope for a while.
    pub(crate) fn is_known(&self, number: u32) -> bool {
        (self.tracks.iter()).any(|track| track.number == number && track.sure >= KNOWN)
    }

    /// Returns whether any known rope had a last confidence of at least `sure` and was seen for
    /// more than a moment.
    pub(crate) fn knows_some(&self, sure: f32) -> bool {
        (self.tracks.iter()).any(|track| track.frames >= SETTLED && track.confidence >= sure)
    }

    /// Returns whether a curve may be a known rope.
    pub(crate) fn may_know(&self, curve: &Curve) -> bool {
        let shape = shape_of_curve(curve);
        self.tracks.iter().any(|track| {
            let rope = shape_of(track);
            matching::near(&rope, &shape).is_some()
                || matching::returned(&rope, track.usual.px, &shape).is_some()
        })
    }

    /// Weighs a doubt about a curve, which is not a [known](Self::is_known) rope, against its track's
    /// history. Returns whether it may not be a rope.
    pub(crate) fn weigh(&mut self, number: u32, is_doubted: bool) -> bool {
        let Some(track) = self.tracks.iter_mut().find(|track| track.number == number) else {
            return is_doubted;
        };
        track.sure = match is_doubted {
            false => (track.sure + 1).min(LONG as i32),
            true => -REGAINED,
        };
        track.sure < 0
    }

    /// Records the confidence of a visible rope, for when it is lost.
    pub(crate) fn note_confidence(&mut self, number: u32, sure: f32) {
        if let Some(track) = self.tracks.iter_mut().find(|track| track.number == number) {
            track.confidence = sure;
        }
    }

    /// Updates the ropes after they were followed into an image. No other ropes are known then.
    pub(crate) fn go_on(&mut self, curves: &[Curve]) {
        for track in &mut self.tracks {
            if let Some(curve) = curves.iter().find(|curve| curve.track == track.number) {
                track.seen_ns = self.now_ns;
                track.age = 0;
                track.frames = track.frames.saturating_add(1);
                if track.sure >= 0 {
                    track.sure = (track.sure + 1).min(LONG as i32);
                }
                track.usual.note(curve);
                track.points.clear();
                track.points.extend_from_slice(&curve.points);
                (track.width_px, track.length_px) = (curve.width_px, curve.length_px);
            }
        }
    }

    /// Repeats the answer to the last image, which had `seen` curves in sight, and appends the lost
    /// ropes. Returns the number of curves.
    pub(crate) fn stay(
        &mut self,
        curves: &mut Vec<Curve>,
        seen: usize,
        options: &Options,
    ) -> usize {
        self.go_on(&curves[..seen]);
        self.tracks
            .iter_mut()
            .filter(|track| track.age > 0)
            .for_each(|track| track.age = track.age.saturating_add(1));
        self.drop_old(options.keep_lost.as_nanos());
        self.report_lost(curves, seen, options.ropes)
    }

    /// Matches free tracks with free curves, the best agreement first.
    fn match_with(
        &mut self,
        curves: &[Curve],
        appearances: &[Appearance],
        agree: impl Fn(&Track, &Shape, &Shape) -> Option<Agreement>,
    ) {
        self.matches.clear();
        for (t, track) in self.tracks.iter().enumerate() {
            for (c, curve) in curves.iter().enumerate() {
                let color_levels = track.color.map_or(0.0, |color| {
                    color::distance(color, appearances[c].color, self.yuv)
                });
                let rope = Shape {
                    color_levels,
                    ..shape_of(track)
                };
                let curve = Shape {
                    color_levels,
                    ..shape_of_curve(curve)
                };
                if let Some(agreement) = agree(track, &rope, &curve) {
                    self.matches.push(Match {
                        agreement,
                        track: t,
                        curve: c,
                    });
                }
            }
        }
        self.matches
            .sort_unstable_by(|a, b| a.agreement.cost.total_cmp(&b.agreement.cost));
        for m in &self.matches {
            let taken = self.tracks.iter().any(|t| is_current(t, m.curve));
            if !taken && self.tracks[m.track].current.is_none() {
                self.tracks[m.track].current = Some((m.curve, m.agreement.reversed));
            }
        }
    }

    /// Makes a new rope start at the end nearest to `start` or, without one, to the top left.
    /// Returns whether an open one was reversed.
    fn orient_new(&mut self, curve: &mut Curve, start: Option<Vec2>) -> bool {
        let goal = match start {
            Some(goal) if !self.started => goal,
            _ => [0.0, 0.0],
        };
        if curve.closed {
            rotate(curve, nearest_point(&curve.points, goal));
            if signed_area(&curve.points) < 0.0 {
                reverse(curve);
            }
        } else if let (Some(&first), Some(&last)) = (curve.points.first(), curve.points.last())
            && distance(last, goal) < distance(first, goal)
        {
            reverse(curve);
            return true;
        }
        false
    }

    fn add(&mut self, curve: usize) {
        let mut track = self.spare.pop().unwrap_or_default();
        track.number = self.next;
        self.next = self.next.wrapping_add(1);
        track.current = Some((curve, false));
        track.points.clear();
        track.color = None;
        track.usual = UsualLength::default();
        (track.frames, track.age, track.sure) = (0, 0, 0);
        self.tracks.push(track);
    }

    /// Drops ropes that are out of sight for too long, were hardly seen, or were parts of others.
    fn drop_old(&mut self, keep_ns: u128) {
        let mut t = 0;
        while t < self.tracks.len() {
            let track = &self.tracks[t];
            let age_ns = self.now_ns.saturating_sub(track.seen_ns);
            // A rope seen only for a moment is not missed.
            let missed = track.frames >= SETTLED && u128::from(age_ns) <= keep_ns;
            if track.age > 0 && (!missed || self.was_part_of_another(track)) {
                let gone = self.tracks.remove(t);
                self.spare.push(gone);
            } else {
                t += 1;
            }
        }
    }

    /// Returns whether a lost rope is along a visible one, which means that it was a fragment of
    /// the visible one.
    fn was_part_of_another(&self, lost: &Track) -> bool {
        let part = shape_of(lost);
        self.tracks.iter().any(|whole| {
            let longer = whole.age == 0 && whole.length_px > lost.length_px;
            longer && matching::along(&shape_of(whole), &part).cost <= SAME_WIDTHS * whole.width_px
        })
    }

    fn report_lost(&self, curves: &mut Vec<Curve>, count: usize, most: usize) -> usize {
        let mut count = count;
        for track in self.tracks.iter().filter(|t| t.current.is_none()) {
            if count >= most {
                break;
            }
            if count == curves.len() {
                curves.push(Curve::default());
            }
            let curve = &mut curves[count];
            curve.track = track.number;
            curve.status = Status::Lost;
            curve.age_ns = self.now_ns.saturating_sub(track.seen_ns);
            curve.closed = track.closed;
            curve.border = track.border;
            curve.points.clear();
            curve.points.extend_from_slice(&track.points);
            curve.widths_px.clear();
            curve.widths_px.resize(track.points.len(), track.width_px);
            curve.hidden.clear();
            curve.hidden.resize(track.points.len(), true);
            (curve.width_px, curve.length_px) = (track.width_px, track.length_px);
            curve.confidence = track.confidence;
            count += 1;
        }
        count
    }
}

fn is_current(track: &Track, curve: usize) -> bool {
    track.current.is_some_and(|(c, _)| c == curve)
}

fn shape_of(track: &Track) -> Shape<'_> {
    Shape {
        points: &track.points,
        closed: track.closed,
        length_px: track.length_px,
        width_px: track.width_px,
        color_levels: 0.0,
    }
}

fn shape_of_curve(curve: &Curve) -> Shape<'_> {
    Shape {
        points: &curve.points,
        closed: curve.closed,
        length_px: curve.length_px,
        width_px: curve.width_px,
        color_levels: 0.0,
    }
}

/// Aligns the curve with its track, sets its status, and updates the track's shape.
///
/// If a tip is covered, the hidden part of the shape stays as it was (`Completer`). If the length
/// changes suddenly in plain sight, the whole shape stays, for up to `KEPT` frames.
fn see(
    track: &mut Track,
    curve: &mut Curve,
    look: &mut Appearance,
    reversed: bool,
    completer: &mut Completer,
) {
    if curve.closed && !track.closed {
        open_ring(&track.points, curve);
    }
    if reversed && !curve.closed {
        reverse(curve);
        look.covered.swap(0, 1);
    }
    if curve.closed && track.closed && track.points.len() == curve.points.len() {
        align_ring(&track.points, curve);
    }
    curve.track = track.number;
    curve.age_ns = 0;
    let cut = curve.border.iter().chain(&track.border).any(|&b| b);
    let missing_px = track.length_px.min(track.usual.px) - curve.length_px;
    let is_short = missing_px > JUMP_WIDTHS * curve.width_px + JUMP_SHARE * track.length_px;
    let tip_covered = look.covered.contains(&true);
    let jumped = !cut && is_short && has_jumped(track, curve);
    let whole = !jumped && (cut || curve.length_px >= PARTIAL * track.usual.px);
    let covered = curve.hidden.contains(&true) || tip_covered;
    curve.status = if whole && !covered {
        Status::Ok
    } else {
        Status::Partial
    };
    if cut || track.frames == 0 {
        track.usual = UsualLength::of(curve.length_px);
    }
    (track.usual).look(look.free, look.is_plain && !covered);
    if !cut {
        track.usual.note(curve);
    }
    track.age = 0;
    track.frames = track.frames.saturating_add(1);
    track.color = Some(match track.color {
        // The light changes slowly, and a rope's own color does not change.
        Some(color) => std::array::from_fn(|i| color[i] + 0.1 * (look.color[i] - color[i])),
        None => look.color,
    });
    let is_open = !track.closed && !curve.closed;
    let is_part = is_short && (jumped || tip_covered) && is_open && !look.is_split;
    let is_plain = look.is_plain && !(cut || is_part || covered || look.is_split);
    let is_leap = is_plain && track.disbelieved < KEPT && track.has_leapt(curve);
    track.disbelieved = if is_leap { track.disbelieved + 1 } else { 0 };
    let seen_px;
    (track.length_px, seen_px) = if is_part {
        completer.complete(&mut track.points, track.length_px, curve)
    } else if is_leap {
        (track.length_px, [0.0, track.length_px])
    } else {
        track.points.clear();
        track.points.extend_from_slice(&curve.points);
        (curve.length_px, [0.0, curve.length_px])
    };
    track.covered_px = [0, 1].map(|end| look.covered[end].then_some(seen_px[end]));
    track.note_width(curve.width_px);
    (track.closed, track.border) = (curve.closed, curve.border);
}

impl Track {
    /// Returns whether the length of a known rope has changed suddenly, but not to its usual
    /// length.
    fn has_leapt(&self, curve: &Curve) -> bool {
        let most_px = LEAP.0 * self.width_px + LEAP.1 * self.length_px;
        let differs = |length_px: f32| (curve.length_px - length_px).abs() > most_px;
        let is_known = self.frames > KNOWN.unsigned_abs() && self.closed == curve.closed;
        is_known && differs(self.length_px) && differs(self.usual.px)
    }

    /// Moves the width toward the measured one. An object on or next to the rope may change the
    /// measured width at once, but not the rope's own.
    fn note_width(&mut self, width_px: f32) {
        if self.frames <= SETTLED {
            self.width_px = width_px;
        }
        let most_px = WIDTH_PACE * self.width_px;
        self.width_px += (width_px - self.width_px).clamp(-most_px, most_px);
    }
}

/// Returns whether a tip of the rope is suddenly farther back along it.
fn has_jumped(track: &Track, curve: &Curve) -> bool {
    if track.closed || curve.closed {
        return track.closed && !curve.closed;
    }
    let ends = [
        (track.points.first(), curve.points.first()),
        (track.points.last(), curve.points.last()),
    ];
    ends.iter().any(|ends| match ends {
        &(Some(&before), Some(&now)) => {
            let back = distance(before, now) > JUMP_WIDTHS * track.width_px;
            let nearest = nearest_point(&track.points, now);
            back && distance(track.points[nearest], now) < JUMP_WIDTHS * track.width_px
        }
        _ => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rope along y = 50, seen between these values of x.
    fn seen(from: f32, to: f32) -> Curve {
        let at = |i: u8| [from + (to - from) * f32::from(i) / 19.0, 50.0];
        Curve {
            points: (0..20).map(at).collect(),
            widths_px: vec![8.0; 20],
            hidden: vec![false; 20],
            width_px: 8.0,
            length_px: to - from,
            ..Curve::default()
        }
    }

    #[test]
    fn a_tip_that_is_read_too_short_upon_something_makes_the_rope_no_shorter() {
        let look = |free| {
            let mut tracker = Tracker::default();
            for length_px in [300.0, 298.0, 298.0] {
                let mut appearances = [Appearance {
                    free,
                    ..Appearance::default()
                }];
                tracker.begin(tracker.now_ns + 33_000_000, false);
                let mut curves = vec![seen(10.0, 10.0 + length_px)];
                tracker.update(&mut curves, 1, &mut appearances, &Options::default());
                // Then it is followed.
                tracker.go_on(&curves);
            }
            tracker.tracks[0].usual.px
        };
        assert_eq!(look(false), 300.0);
        assert!(look(true) < 300.0);
    }

    #[test]
    fn a_rope_that_seems_to_lose_a_stretch_at_once_is_remembered_as_it_was() {
        let mut tracker = Tracker::default();
        let mut look = |curve: Curve, is_plain, is_split| {
            let mut appearances = [Appearance {
                is_plain,
                is_split,
                ..Appearance::default()
            }];
            tracker.begin(tracker.now_ns + 33_000_000, false);
            tracker.update(&mut vec![curve], 1, &mut appearances, &Options::default());
            tracker.tracks[0].length_px
        };
        for _ in 0..=KNOWN {
            look(seen(10.0, 310.0), true, false);
        }
        // A loop is missing, while both tips are where they were.
        let cut = |length_px| Curve {
            length_px,
            ..seen(10.0, 310.0)
        };
        for _ in 0..KEPT {
            assert_eq!(look(cut(240.0), true, false), 300.0);
        }
        assert_eq!(look(cut(240.0), true, false), 240.0);
        // The new length is believed if an object may cover the rope.
        assert_eq!(look(cut(200.0), false, false), 200.0);
        // The same if the known rope is found to be two.
        assert_eq!(look(cut(150.0), true, true), 150.0);
    }

    #[test]
    fn a_rope_is_known_that_was_surely_seen_for_more_than_a_moment() {
        let curve = Curve {
            points: (0u8..20).map(|i| [10.0 * f32::from(i), 50.0]).collect(),
            widths_px: vec![8.0; 20],
            hidden: vec![false; 20],
            width_px: 8.0,
            length_px: 190.0,
            ..Curve::default()
        };
        for (confidence, is_known) in [(0.9, true), (0.3, false)] {
            let (mut tracker, mut curves) = (Tracker::default(), vec![curve.clone()]);
            for frame in 0..SETTLED {
                assert!(!tracker.knows_some(0.5), "in frame {frame}");
                tracker.begin(33_000_000 * u64::from(frame + 1), false);
                let mut appearances = [Appearance::default()];
                tracker.update(&mut curves, 1, &mut appearances, &Options::default());
                tracker.note_confidence(curves[0].track, confidence);
            }
            assert_eq!(tracker.knows_some(0.5), is_known);
        }
    }
}
