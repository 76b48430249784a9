//! Finds the sections that are only as wide as the rope is there. A parallel strand or a shadow
//! makes a section wider.

use super::{Measure, Section};
use crate::centerline::line::Sample;

/// Length, in widths, of the running mean with which a section's width is compared. A rope that
/// rises toward the camera widens gradually, so a section near that mean is the rope's too.
const BEFORE: f32 = 1.5;
/// Maximum deviation from that mean, as a share. A rope 14 px wide, at 50° and a focal length of
/// 600 px, changes its width by 3 % within its own width. The width of two strands that converge at
/// 5° changes by 9 %.
const GRADUAL: f32 = 0.08;
/// Maximum weight of one section in that mean, reached after a gap.
const COUNTS: f32 = 0.25;
/// Maximum factor between a section's width and the rope's usual width.
pub(super) const MOST: f32 = 2.0;
/// Minimum length, in widths, of a run of sections that keep their width, for that width to be the
/// rope's. A rope that points at the camera becomes wide at once, behind a bend or at its tip. Two
/// strands side by side run into a crossing instead.
const STEADY: f32 = 3.0;

/// Marks the sections that are the rope's own. The pair gives the rope's width just beyond the
/// first and the last section.
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

/// Marks, in order, the sections that are as wide as the rope usually is, or as it has gradually
/// become. The pair gives the sample before the first section, and the width there.
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

/// Marks those of adjacent sections that keep their width for long enough. None of the sections has
/// the rope's usual width.
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

/// Returns whether a section is about as wide as those before it.
fn is_gradual(width_px: f32, wide_px: f32) -> bool {
    (width_px - wide_px).abs() < GRADUAL * wide_px
}

fn is_own((_, found): &Section) -> bool {
    found.is_some_and(|found| found.is_own)
}
