//! Which sections are as wide as the rope is there, and no others': a strand beside it, or a shadow, makes them wider.

use super::{Measure, Section};
use crate::centerline::line::Sample;

/// A rope that rises to the camera becomes wider by and by: a section whose width differs from the mean over so many widths before it by
/// this share at most is the rope's too. Of 14 px, at 50° and a focal length of 600 px, its width changes by 3 % in its own; that of two
/// strands that run together at 5°, by 9 %.
const BEFORE: f32 = 1.5;
const GRADUAL: f32 = 0.08;
/// After a gap a section counts for no more in that mean than this.
const COUNTS: f32 = 0.25;
/// So much wider or narrower than mostly it becomes, as a factor, at most.
pub(super) const MOST: f32 = 2.0;
/// A rope that points at the camera is wide at once, behind a bend or from its tip on: so many widths of sections that go on as wide as
/// those before them are the rope's too. Two strands beside each other run into a crossing.
const STEADY: f32 = 3.0;

/// Notes which of the sections are the rope's own, where `ends` says how wide it is beyond the first and the last of them.
pub(super) fn judge(
    samples: &[Sample],
    how: Measure,
    [first_px, last_px]: [f32; 2],
    sections: &mut [Section],
) {
    let [Some(&(first, _)), Some(&(last, _))] = [sections.first(), sections.last()] else {
        return;
    };
    judge_gradual((first, first_px), how, sections.iter_mut());
    judge_gradual((last, last_px), how, sections.iter_mut().rev());
    for stretch in sections.chunk_by_mut(|a, b| is_own(a) == is_own(b)) {
        let is_crossed = |(i, _): &Section| samples[*i].weight < 1.0;
        if !is_own(&stretch[0]) && !stretch.iter().any(is_crossed) {
            judge_steady(how, stretch);
        }
    }
}

/// Notes which of the sections in turn are as wide as the rope mostly is, or as it has become by and by since `from`: a sample, and the
/// width there.
fn judge_gradual<'a>(
    (mut before, mut wide_px): (usize, f32),
    how: Measure,
    sections: impl Iterator<Item = &'a mut Section>,
) {
    for (i, found) in sections {
        let Some(found) = found else { continue };
        let gap = i.abs_diff(before) as f32 * how.step_px / wide_px;
        if how.is_plausible(found.width_px) || is_gradual(found.width_px, wide_px) {
            found.is_own = true;
            wide_px += (gap / BEFORE).min(COUNTS) * (found.width_px - wide_px);
            before = *i;
        }
    }
}

/// Notes of sections in a row, of which none is as wide as the rope mostly is, those that go on as wide as each other for long enough.
fn judge_steady(how: Measure, stretch: &mut [Section]) {
    let mut wide_px = stretch[0].1.map_or(0.0, |found| found.width_px);
    let goes_on = |_: &Section, (_, found): &Section| {
        let Some(found) = found else { return false };
        let goes_on = is_gradual(found.width_px, wide_px);
        let share = match goes_on {
            true => (how.step_px / wide_px / BEFORE).min(COUNTS),
            false => 1.0,
        };
        wide_px += share * (found.width_px - wide_px);
        goes_on
    };
    for run in stretch.chunk_by_mut(goes_on) {
        let long_px = run.len() as f32 * how.step_px;
        for found in run.iter_mut().filter_map(|(_, found)| found.as_mut()) {
            found.is_own = long_px > STEADY * found.width_px;
        }
    }
}

/// Whether a section goes on as wide as those before it.
fn is_gradual(width_px: f32, wide_px: f32) -> bool {
    (width_px - wide_px).abs() < GRADUAL * wide_px
}

fn is_own((_, found): &Section) -> bool {
    found.is_some_and(|found| found.is_own)
}
