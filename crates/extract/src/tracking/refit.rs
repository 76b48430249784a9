//! Refits the ropes of the prior to this image if its own lines contradict them.
//!
//! If strands touch, or ends are on strands, a single image may show something other than two
//! consecutive images do. A rope does not tear or exchange its strands. Its last centerline is
//! therefore laid over the image, and each sample searches across for the middle of the rope. The
//! movements, not the places, are smoothed along the rope. The shape is kept and carried along
//! where nothing can be measured: at crossings, overlaps and occluders.
//!
//! The refit replaces the image's own lines only if the image supports it: nearly every sample is
//! on a rope or under an occluder, each length is nearly unchanged, and hardly any skeleton is left
//! unexplained.

mod bounds;
mod reach;

use super::tips;
use crate::bitmap::bits::BitPlane;
use crate::centerline::extrapolate;
use crate::centerline::line::{Line, MOST_PIECES, Sample};
use crate::centerline::section::{Measure, Sections};
use crate::centerline::shading::Shading;
use crate::centerline::smooth::Smoother;
use crate::graph::bending::cubic;
use crate::image::gray::GrayPlane;
use crate::occlusion::way::{drawn_in, length_px};
use crate::past::{Move, Past, Rope};
use crate::skeleton::Skeleton;
use crate::statistics::quantile;
use crate::vec2::{self, Vec2};
use reach::Reach;

/// Maximum factor between a section's width and the rope's, in each pass of the measurement.
const LOOKS: [f32; 3] = [1.45, 1.35, 1.3];
/// Length over which movements are smoothed, in widths: as far as a bend of a rope reaches.
const STIFF_WIDTHS: f32 = 2.0;
/// Maximum movement of points in a line that agrees with the prior, in widths, in addition to twice
/// the ropes' mean movement. Minimum share of the points within it.
const AGREES: (f32, f32) = (1.5, 0.95);
/// Maximum share of a refitted rope on the bare table.
const BARE: f32 = 0.04;
/// Maximum length of one bare stretch, in widths. If a stretch is longer, the rope is no longer
/// there.
const BARE_WIDTHS: f32 = 0.75;
/// Minimum share of the skeleton that refitted ropes must explain.
const EXPLAINED: f32 = 0.95;
/// Maximum length of unexplained skeleton, in widths. More is a tip that has come out.
const LEFT_WIDTHS: f32 = 1.0;
/// Maximum change of a rope's length from one image to the next, as a share.
const LENGTH: f32 = 0.06;
/// Number of samples over which a line's direction into an occluder is measured.
const DIRECTION: usize = 6;
/// Number of skeleton pixels that are checked.
const ASKED: usize = 400;
/// Number of points at which two shapes are compared.
const COMPARED: usize = 40;

/// Buffers and result of the step.
#[derive(Debug, Default)]
pub(crate) struct Refitter {
    sections: Sections,
    smoother: Smoother,
    moves: Line,
    before: Vec<Vec2>,
    spaced: Vec<Sample>,
    levels: Vec<f32>,
    /// Refitted ropes. The first `count` belong to this image.
    lines: Vec<Line>,
    /// Reach of each refitted rope.
    reaches: Vec<Reach>,
    count: usize,
    /// Reach of each of the image's own lines that is not a refitted rope.
    new: Vec<Option<Reach>>,
}

/// Data to which ropes are refitted.
pub(crate) struct Scene<'a> {
    pub(crate) past: &'a Past,
    /// Known movement of places on the prior's ropes.
    pub(crate) moves: &'a [Move],
    pub(crate) difference: &'a GrayPlane,
    pub(crate) mask: &'a BitPlane,
    pub(crate) occluder: &'a BitPlane,
    pub(crate) skeleton: &'a Skeleton,
}

impl Refitter {
    /// Allocates buffers for `ropes` ropes of up to `samples` samples, by laying those of the prior
    /// over the image.
    pub(crate) fn warm_up(&mut self, ropes: usize, samples: usize, scene: &Scene) {
        self.sections.reserve(samples);
        self.lines
            .resize_with(ropes.max(self.lines.len()), Line::default);
        for line in &mut self.lines {
            line.samples.reserve(samples);
        }
        self.spaced.reserve(samples);
        self.moves.samples.reserve(samples);
        self.before.reserve(samples);
        self.levels.reserve(samples);
        self.reaches.reserve(ropes);
        self.new.reserve(MOST_PIECES);
        let mut line = std::mem::take(&mut self.lines[0]);
        for rope in scene.past.ropes() {
            self.lay(rope, scene, &[], &mut line);
        }
        // Shifts the longest possible line as a ring, because smoothing a ring also needs an
        // overlap.
        line.closed = true;
        line.samples.resize(samples, Sample::default());
        let how = Measure {
            half_px: 3.0,
            step_px: 1.0,
            tolerance: LOOKS[0],
            shading: Shading::FLAT,
        };
        self.shift(&mut line, scene, how);
        line.clear();
        self.lines[0] = line;
    }

    /// Refits the ropes of the prior if `lines` contradict them. Returns whether they replace the
    /// lines along them.
    ///
    /// It does nothing if all visible ropes agree with a line, if one of them leaves the image, or
    /// if the lines restore usual lengths (`are_restored`). The ropes are first laid where they
    /// were, then as the movement of their fragments suggests. The first attempt that the image
    /// supports wins.
    pub(crate) fn refit(&mut self, lines: &[Line], scene: &Scene) -> bool {
        let live = || scene.past.live();
        if live().next().is_none()
            || live().all(|rope| self.agrees(rope, lines, scene.past))
            || live().any(|r| !r.state.whole)
            || are_restored(lines, scene.past)
        {
            return false;
        }
        // Ropes that have moved far are placed by their visible fragments.
        let ways = [&[], scene.moves];
        let ways = &ways[..1 + usize::from(!scene.moves.is_empty())];
        ways.iter().any(|moves| {
            if !self.lay_all(scene, moves) {
                return false;
            }
            self.reaches.clear();
            self.reaches
                .extend(self.lines[..self.count].iter().map(Reach::of));
            self.explained(lines, scene)
        })
    }

    /// Lays all ropes over the image, displaced by `moves`. Returns false at the first one that the
    /// image does not support.
    fn lay_all(&mut self, scene: &Scene, moves: &[Move]) -> bool {
        self.count = 0;
        for rope in scene.past.live() {
            if self.lines.len() <= self.count {
                self.lines.push(Line::default());
            }
            let mut line = std::mem::take(&mut self.lines[self.count]);
            let borne_out = self.lay(rope, scene, moves, &mut line);
            self.lines[self.count] = line;
            if !borne_out {
                return false;
            }
            self.count += 1;
        }
        true
    }

    /// Returns whether one of the lines is the rope from end to end, slightly moved. The line may
    /// also include a part that was out of sight at one end. A closed rope is compared by length
    /// only.
    fn agrees(&self, rope: &Rope, lines: &[Line], past: &Past) -> bool {
        let most_px = (AGREES.0 + 2.0 * past.moved()) * rope.width_px;
        lines.iter().any(|line| {
            let length_px = line.length_px();
            let known = (length_px / rope.length_px - 1.0).abs() <= LENGTH;
            let come_out =
                length_px > rope.length_px && length_px <= (1.0 + 0.5 * LENGTH) * rope.usual_px;
            if line.closed != rope.closed || !(known || come_out) || line.samples.len() < 2 {
                return false;
            }
            if line.closed {
                return true;
            }
            // Start of the rope's known stretch on the line, and its share of the line.
            let rest = (1.0 - rope.length_px / length_px).max(0.0);
            let laid = [(0.0, 1.0), (0.0, 1.0 - rest), (rest, 1.0 - rest)];
            let ways = if known { &laid[..] } else { &laid[1..] };
            ways.iter().any(|&(from, share)| {
                [false, true].into_iter().any(|reversed| {
                    let near = (0..COMPARED).filter(|&k| {
                        let t = k as f32 / (COMPARED - 1) as f32;
                        let u = from + share * t;
                        let u = if reversed { 1.0 - u } else { u };
                        let place = (u * (line.samples.len() - 1) as f32).round() as usize;
                        let at = rope.at(t * rope.length_px);
                        vec2::distance(at, line.samples[place].at) <= most_px
                    });
                    near.count() as f32 >= AGREES.1 * COMPARED as f32
                })
            })
        })
    }

    /// Lays the rope over the image, displaced by `moves`. Returns whether the image supports it:
    /// its length is within `LENGTH`, and its bare parts are within `BARE` and `BARE_WIDTHS`.
    fn lay(&mut self, rope: &Rope, scene: &Scene, moves: &[Move], line: &mut Line) -> bool {
        let half_px = 0.5 * rope.width_px;
        let step_px = (half_px / 4.0).clamp(0.75, 4.0);
        let count = (rope.length_px / step_px).ceil().max(8.0) as usize;
        line.clear();
        line.closed = rope.closed;
        let intervals = count - usize::from(!rope.closed);
        for k in 0..count {
            let along_px = rope.length_px * k as f32 / intervals as f32;
            line.samples.push(Sample {
                at: vec2::add(rope.at(along_px), moved(rope, along_px, moves)),
                weight: 1.0,
                width_px: rope.width_px,
                side: 0.0,
            });
        }
        let mut shading = Shading::FLAT;
        for tolerance in LOOKS {
            let how = Measure {
                half_px,
                step_px,
                tolerance,
                shading,
            };
            self.shift(line, scene, how);
            shading = Shading::measure(line, scene.difference, how);
        }
        self.smoother
            .smooth(line, (0.35 * half_px).max(2.5) / step_px);
        if !line.closed {
            draw_in(line, rope.usual_px, scene.occluder);
            for _end in 0..2 {
                let room_px = rope.usual_px - line.length_px();
                self.find_tip(line, scene.difference, [half_px, step_px, room_px]);
                line.samples.reverse();
                line.border.swap(0, 1);
            }
        }
        tips::shorten(line, scene.past, [scene.mask, scene.occluder]);
        tips::lengthen(line, scene.past, [scene.mask, scene.occluder]);
        let count = (line.length_px() / step_px).ceil().max(8.0) as usize;
        line.resample(count, &mut self.spaced);
        std::mem::swap(&mut line.samples, &mut self.spaced);
        let same_length = (line.length_px() / rope.length_px - 1.0).abs() <= LENGTH;
        let (mut bare, mut run, mut longest) = (0, 0, 0);
        for sample in &line.samples {
            run = if is_bare(sample.at, scene) {
                run + 1
            } else {
                0
            };
            bare += usize::from(run > 0);
            longest = longest.max(run);
        }
        same_length
            && bare as f32 <= BARE * line.samples.len() as f32
            && longest as f32 * step_px <= BARE_WIDTHS * rope.width_px
    }

    /// Moves each sample to the middle of the rope. Samples without a measurement move into their
    /// bounds, or along with their neighbors.
    fn shift(&mut self, line: &mut Line, scene: &Scene, how: Measure) {
        self.before.clear();
        self.before.extend(line.samples.iter().map(|s| s.at));
        line.samples.iter_mut().for_each(|s| s.weight = 1.0);
        self.sections.measure(line, scene.difference, how);
        bounds::hold(line, scene, how);
        self.moves.closed = line.closed;
        self.moves.samples.clear();
        let moves = line.samples.iter().zip(&self.before);
        self.moves
            .samples
            .extend(moves.map(|(sample, &before)| Sample {
                at: vec2::sub(sample.at, before),
                ..*sample
            }));
        let stiff = (STIFF_WIDTHS * 2.0 * how.half_px / how.step_px).max(2.0);
        self.smoother.smooth(&mut self.moves, stiff);
        let moved = self.moves.samples.iter().zip(&self.before);
        for (sample, (shift, &before)) in line.samples.iter_mut().zip(moved) {
            // Measured samples keep their place, and the others are carried along.
            if sample.weight <= 0.0 {
                sample.at = vec2::add(before, shift.at);
                sample.width_px = 2.0 * how.half_px;
                sample.weight = CARRIED;
            }
        }
    }

    /// Moves the last end of the line to where the rope ends, if that is near. Over another strand,
    /// no end shows, so the end is carried along. `room_px` is how much longer the rope usually is.
    fn find_tip(
        &mut self,
        line: &mut Line,
        difference: &GrayPlane,
        [half_px, step_px, room_px]: [f32; 3],
    ) {
        let n = line.samples.len();
        let back = ((2.0 * half_px / step_px) as usize).clamp(2, n / 3);
        let (inner, before) = (
            line.samples[n - 1 - back].at,
            line.samples[n - 1 - 2 * back.min(n / 4)].at,
        );
        let last = line.samples[n - 1];
        let out = vec2::unit_or(vec2::sub(last.at, inner), vec2::sub(inner, before));
        self.levels.clear();
        let piece = &line.samples[n - 1 - back..];
        self.levels
            .extend(piece.iter().map(|s| difference.sample(s.at)));
        let level = 0.5 * quantile(&mut self.levels, 0.5).max(2.0);
        let limit_px = 6.0 * half_px;
        let (far, border) =
            extrapolate::tip(difference, |d| vec2::along(inner, out, d), level, limit_px);
        line.border[1] = border;
        let more_px = far - back as f32 * step_px;
        if more_px <= half_px.min(room_px + 0.5 * half_px) {
            line.samples.truncate(n - back);
            let count = (far / step_px).ceil().max(1.0) as usize;
            for k in 1..=count {
                line.samples.push(Sample {
                    at: vec2::along(inner, out, far * k as f32 / count as f32),
                    ..last
                });
            }
        }
    }

    /// Returns whether hardly any of the skeleton is unexplained. Skeleton on a new rope does not
    /// count.
    fn explained(&mut self, lines: &[Line], scene: &Scene) -> bool {
        let mut new = std::mem::take(&mut self.new);
        new.clear();
        new.extend(
            lines
                .iter()
                .map(|line| (!self.lies_along(line)).then(|| Reach::of(line))),
        );
        self.new = new;
        let pixels = &scene.skeleton.pixels;
        let stride = (pixels.len() / ASKED).max(1);
        let (mut asked, mut known) = (0.0f32, 0.0);
        for pixel in pixels.iter().step_by(stride).filter(|p| p.degree > 0) {
            let mut new = lines.iter().zip(&self.new);
            let on_new =
                new.any(|(line, reach)| reach.is_some_and(|reach| reach.holds(line, pixel.at())));
            if on_new {
                continue;
            }
            asked += 1.0;
            known += f32::from(self.is_refitted(pixel.at()));
        }
        let width_px = |line: &Line| line.samples.first().map_or(1.0, |s| s.width_px);
        let widest_px = self.lines[..self.count]
            .iter()
            .map(width_px)
            .fold(1.0, f32::max);
        let left_px = (asked - known) * stride as f32;
        known >= EXPLAINED * asked && left_px <= LEFT_WIDTHS * widest_px
    }

    /// Returns whether refitted ropes explain at least half of a line.
    pub(crate) fn lies_along(&self, line: &Line) -> bool {
        let stride = (line.samples.len() / COMPARED).max(1);
        let (mut asked, mut known) = (0, 0);
        for sample in line.samples.iter().step_by(stride) {
            asked += 1;
            known += usize::from(self.is_refitted(sample.at));
        }
        2 * known >= asked
    }

    /// Returns whether one of the refitted ropes explains a place.
    fn is_refitted(&self, at: Vec2) -> bool {
        let mut ropes = self.lines[..self.count].iter().zip(&self.reaches);
        ropes.any(|(rope, reach)| reach.holds(rope, at))
    }

    /// Moves the refitted ropes, and those of the first `count` lines that they do not explain, to
    /// the front of `lines`, the longest first. Returns their number.
    pub(crate) fn take(&mut self, lines: &mut Vec<Line>, count: usize) -> usize {
        let mut kept = 0;
        for l in 0..count {
            if !self.lies_along(&lines[l]) {
                lines.swap(kept, l);
                kept += 1;
            }
        }
        while lines.len() < kept + self.count {
            lines.push(Line::default());
        }
        for (line, rope) in lines[kept..].iter_mut().zip(&mut self.lines[..self.count]) {
            std::mem::swap(line, rope);
        }
        let count = kept + self.count;
        lines[..count].sort_unstable_by(|a, b| b.length_px().total_cmp(&a.length_px()));
        count
    }

    /// Calls `found` with each stretch of a line, in arc length, that is under an occluder.
    pub(crate) fn covered(line: &Line, occluder: &BitPlane, mut found: impl FnMut(f32, f32)) {
        let step_px = line.length_px() / (line.samples.len().max(2) - 1) as f32;
        let mut from = None;
        for (i, sample) in line.samples.iter().enumerate() {
            let under = occluder.get(sample.at[0] as i32, sample.at[1] as i32);
            let along_px = i as f32 * step_px;
            match (from, under) {
                (None, true) => from = Some(along_px),
                (Some(start), false) => {
                    found(start - 0.5 * step_px, along_px - 0.5 * step_px);
                    from = None;
                }
                _ => {}
            }
        }
        if let Some(start) = from {
            found(start, line.length_px());
        }
    }
}

/// Returns whether `lines` restore the usual lengths of all ropes, and the prior did not have all
/// of these lengths. In that case, strands were confused in the prior and no longer are.
fn are_restored(lines: &[Line], past: &Past) -> bool {
    let is_usual =
        |length_px: f32, rope: &Rope| (length_px / rope.usual_px - 1.0).abs() <= 0.5 * LENGTH;
    let is_rope = |line: &Line, rope: &Rope| {
        let stride = (line.samples.len() / COMPARED).max(1);
        let places = || line.samples.iter().step_by(stride);
        let near = places().filter(|sample| rope.off_px(sample.at) <= rope.width_px);
        is_usual(line.length_px(), rope) && 2 * near.count() > places().count()
    };
    let mut ropes = past.live();
    lines.len() == past.live().count()
        && past.live().any(|rope| !is_usual(rope.length_px, rope))
        && ropes.all(|rope| lines.iter().any(|line| is_rope(line, rope)))
}

/// Draws in the longest hidden stretch of a line by as much as the line exceeds the rope's usual
/// length. Nothing else constrains the length of that stretch.
fn draw_in(line: &mut Line, usual_px: f32, occluder: &BitPlane) {
    let spare_px = line.length_px() - usual_px;
    if spare_px <= 0.0 {
        return;
    }
    let step_px = line.length_px() / (line.samples.len().max(2) - 1) as f32;
    let (mut from, mut to) = (0, 0);
    Refitter::covered(line, occluder, |from_px, to_px| {
        // The stretch begins and ends between two samples.
        let ends = [from_px, to_px].map(|px| (px / step_px + 0.5).round() as usize);
        if ends[1] - ends[0] > to - from {
            [from, to] = ends;
        }
    });
    let samples = &mut line.samples;
    if from == to || from < 2 * DIRECTION || to + 2 * DIRECTION > samples.len() {
        return;
    }
    let end = |tip: usize, inner: usize| {
        let out = vec2::sub(samples[tip].at, samples[inner].at);
        [samples[tip].at, vec2::unit_or(out, [1.0, 0.0])]
    };
    let (before, after) = (from - 1, to);
    let plain = cubic(
        end(before, before - DIRECTION),
        end(after, after + DIRECTION),
    );
    let pairs = samples[before..=after].windows(2);
    let way_px = pairs
        .map(|pair| vec2::distance(pair[0].at, pair[1].at))
        .sum();
    let share = drawn_in(spare_px, way_px, length_px(&plain));
    let pieces = (after - before) as f32;
    for (k, sample) in samples[from..to].iter_mut().enumerate() {
        let off = vec2::sub(plain((k + 1) as f32 / pieces), sample.at);
        sample.at = vec2::along(sample.at, off, share);
    }
}

/// Movement of a place on a rope, interpolated between the known movements on both sides.
fn moved(rope: &Rope, along_px: f32, moves: &[Move]) -> Vec2 {
    let mut before: Option<&Move> = None;
    for after in moves.iter().filter(|m| m.rope == rope.index) {
        if after.along_px >= along_px {
            let Some(before) = before else {
                return after.by;
            };
            let t = (along_px - before.along_px) / (after.along_px - before.along_px).max(1e-6);
            return vec2::along(before.by, vec2::sub(after.by, before.by), t);
        }
        before = Some(after);
    }
    before.map_or([0.0; 2], |before| before.by)
}

/// Weight of a place that was carried along. It is less than that of a measured one.
const CARRIED: f32 = 0.05;

/// Returns whether a place shows the table.
fn is_bare(at: Vec2, scene: &Scene) -> bool {
    !scene.mask.has(at) && !scene.occluder.has(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::past::State;

    #[test]
    fn ropes_are_restored_by_lines_of_their_usual_lengths_alone() {
        let line = |from: i32, to: i32, y: f32| Line {
            samples: (from..=to)
                .map(|x| Sample {
                    at: [x as f32, y],
                    ..Sample::default()
                })
                .collect(),
            ..Line::default()
        };
        // Two ropes of 100 px. The second was measured 30 px too long in the last image.
        let mut past = Past::default();
        for (y, last_px) in [(20.0, 100.0), (60.0, 130.0)] {
            let points: Vec<Vec2> = (0..=20).map(|i| [last_px / 20.0 * i as f32, y]).collect();
            let sizes_px = [last_px, 6.0, 100.0];
            past.add_covered(false, sizes_px, &points, [None; 2], State::SEEN);
        }
        let lines = [line(0, 100, 21.0), line(0, 101, 60.0)];
        assert!(are_restored(&lines, &past));
        assert!(!are_restored(&lines[..1], &past));
        assert!(!are_restored(
            &[line(0, 100, 21.0), line(0, 120, 60.0)],
            &past
        ));
        assert!(!are_restored(
            &[line(0, 100, 21.0), line(0, 100, 90.0)],
            &past
        ));
    }

    #[test]
    fn a_hidden_part_is_drawn_in_to_the_ropes_usual_length() {
        let mut occluder = BitPlane::default();
        occluder.resize(240, 120);
        (20..110).for_each(|y| occluder.fill(y, 80, 160, true));
        // A straight line with a detour of 40 px where it is hidden.
        let bulge = |x: f32| {
            let off = (x - 120.0) / 15.0;
            40.0 * (-off * off).exp()
        };
        let mut line = Line::default();
        line.samples.extend((20..=220).map(|x| Sample {
            at: [x as f32, 100.0 - bulge(x as f32)],
            weight: 1.0,
            width_px: 8.0,
            side: 0.0,
        }));
        let before_px = line.length_px();
        draw_in(&mut line, before_px, &occluder);
        assert_eq!(line.length_px(), before_px);
        draw_in(&mut line, 200.0, &occluder);
        assert!(
            (line.length_px() - 200.0).abs() < 2.0,
            "{}",
            line.length_px()
        );
        let seen = line
            .samples
            .iter()
            .filter(|s| !(80.0..160.0).contains(&s.at[0]));
        assert!(seen.into_iter().all(|s| (s.at[1] - 100.0).abs() < 0.1));
    }
}
