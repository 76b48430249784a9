//! Statistics of motion-captured ropes: how many were found, and their errors.

use std::collections::BTreeMap;

use super::super::{beside_axis, far};
use crate::Samples;
use lariat_wire::{Descriptor3, Place, Shape, Status};

/// Maximum mean distance of a good frame's points from the axis, mm.
const BAD_MM: f64 = 5.0;

/// Results over all frames.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) sequences: u64,
    frames: u64,
    seen: u64,
    /// Frames without a rope in 3-D, by reason.
    missing: BTreeMap<String, u64>,
    points: Samples,
    ends: Samples,
    curve: Samples,
    bad: u64,
    renamed: u64,
    turned: u64,
    /// Times of depth, fit and covariances.
    pub(super) us: Samples,
}

impl Tally {
    /// Judges a frame and returns a description of its errors. `before` holds the rope's track
    /// number in the last frame that had one, and whether it started at the same end as the truth.
    pub(super) fn judge(
        &mut self,
        curves: &[Descriptor3],
        truth: &[[f64; 3]],
        before: &mut Option<(u32, bool)>,
    ) -> Option<String> {
        self.frames += 1;
        let (one, shape) = match only(curves) {
            Ok(found) => found,
            Err(reason) => {
                *self.missing.entry(reason.clone()).or_default() += 1;
                return Some(reason);
            }
        };
        self.seen += 1;
        let points: Vec<[f64; 3]> = one.points().iter().map(|p| p.map(f64::from)).collect();
        let off: Vec<f64> = points.iter().map(|&p| beside_axis(p, truth)).collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let mut tips = [points[0], points[points.len() - 1]];
        let [first, last] = [truth[0], truth[truth.len() - 1]];
        let is_forward =
            far(tips[0], first) + far(tips[1], last) < far(tips[0], last) + far(tips[1], first);
        if !is_forward {
            tips.reverse();
        }
        let ends = [far(tips[0], first), far(tips[1], last)];
        off.iter().for_each(|&mm| self.points.push(mm));
        ends.iter().for_each(|&mm| self.ends.push(mm));
        shape
            .points::<120>()
            .iter()
            .for_each(|&p| self.curve.push(beside_axis(p, truth)));
        let [was_renamed, was_turned] = match before.replace((one.track, is_forward)) {
            Some((track, way)) => [track != one.track, way != is_forward],
            None => [false; 2],
        };
        let is_bad = mean > BAD_MM;
        self.bad += u64::from(is_bad);
        self.renamed += u64::from(was_renamed);
        self.turned += u64::from(was_turned);
        let wrong = [
            is_bad.then(|| {
                format!(
                    "points are {mean:.1} mm from the axis, ends {:.0} and {:.0}",
                    ends[0], ends[1]
                )
            }),
            was_renamed.then(|| "renamed".to_owned()),
            was_turned.then(|| "turned".to_owned()),
        ];
        let wrong: Vec<String> = wrong.into_iter().flatten().collect();
        (!wrong.is_empty()).then(|| wrong.join(", "))
    }

    pub(super) fn wrong(&self) -> u64 {
        self.frames - self.seen + self.bad + self.renamed + self.turned
    }

    pub(super) fn take(&mut self, other: Self) {
        self.sequences += other.sequences;
        self.frames += other.frames;
        self.seen += other.seen;
        for (reason, count) in other.missing {
            *self.missing.entry(reason).or_default() += count;
        }
        self.points.take(other.points);
        self.ends.take(other.ends);
        self.curve.take(other.curve);
        self.bad += other.bad;
        self.renamed += other.renamed;
        self.turned += other.turned;
        self.us.take(other.us);
    }

    pub(super) fn missing(&self) -> String {
        let reasons = self
            .missing
            .iter()
            .map(|(reason, count)| format!("{count} {reason}"));
        match self.missing.is_empty() {
            true => "none".to_owned(),
            false => reasons.collect::<Vec<_>>().join(", "),
        }
    }

    pub(super) fn row(&self, name: &str) -> [String; 15] {
        let mm = |mm: f64| format!("{mm:.2}");
        [
            name.to_owned(),
            self.sequences.to_string(),
            self.frames.to_string(),
            self.seen.to_string(),
            mm(self.points.mean()),
            mm(self.points.percentile(0.95)),
            mm(self.points.percentile(1.0)),
            mm(self.ends.mean()),
            mm(self.ends.percentile(0.95)),
            mm(self.curve.mean()),
            mm(self.curve.percentile(0.95)),
            self.bad.to_string(),
            self.renamed.to_string(),
            self.turned.to_string(),
            format!("{:.0}", self.us.median()),
        ]
    }
}

/// Returns the only rope of a frame, or the reason why there is none.
fn only(curves: &[Descriptor3]) -> Result<(&Descriptor3, Shape<'_, 3>), String> {
    let known = |one: &&Descriptor3| one.place() == Some(Place::Known);
    let mut found = curves.iter().filter(known);
    match (found.next(), found.next()) {
        (Some(one), None) => match Shape::in_space(one) {
            Ok(shape) => Ok((one, shape)),
            Err(cause) => Err(cause.to_string()),
        },
        (Some(_), Some(_)) => Err("several".to_owned()),
        (None, _) => match curves {
            [] => Err("none".to_owned()),
            [one, ..] if one.status() == Some(Status::Lost) => Err("lost".to_owned()),
            [one, ..] => Err(one.place().map_or("unknown", Place::name).to_owned()),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a straight rope of 600 mm, half a meter away.
    fn truth() -> Vec<[f64; 3]> {
        (0..=600).map(|x| [f64::from(x), 0.0, 500.0]).collect()
    }

    /// Returns a descriptor of a rope along x, with an offset of `beside_mm`.
    fn said(track: u32, [from, to]: [f64; 2], beside_mm: f64) -> Descriptor3 {
        let mut one = Descriptor3::EMPTY;
        (one.track, one.place, one.status) = (track, Place::Known as u32, Status::Ok as u32);
        (one.degree, one.count, one.samples) = (1, 2, 9);
        let at = |share: f64| [from + share * (to - from), beside_mm, 500.0];
        one.control_points[..2].copy_from_slice(&[at(0.0), at(1.0)]);
        for k in 0..9 {
            one.points[k] = at(k as f64 / 8.0).map(|c| c as f32);
        }
        one
    }

    #[test]
    fn what_is_off_is_measured_whichever_way_the_rope_is_taken() {
        let mut tally = Tally::default();
        let mut before = None;
        let wrong = tally.judge(&[said(1, [10.0, 600.0], 2.0)], &truth(), &mut before);
        assert_eq!(wrong, None);
        // The axis has a point per millimeter. Half a millimeter along it adds 0.06 mm to a
        // distance of 2.
        for mean_mm in [tally.points.mean(), tally.curve.mean()] {
            assert!((2.0..2.07).contains(&mean_mm), "{mean_mm}");
        }
        assert!((tally.ends.percentile(1.0) - 104f64.sqrt()).abs() < 1e-6);
        let turned = said(1, [600.0, 10.0], 2.0);
        let wrong = tally.judge(&[turned], &truth(), &mut before);
        assert_eq!(wrong.as_deref(), Some("turned"));
        assert!((tally.ends.percentile(1.0) - 104f64.sqrt()).abs() < 1e-6);
        assert_eq!(
            (tally.frames, tally.seen, tally.turned, tally.wrong()),
            (2, 2, 1, 1)
        );
    }

    #[test]
    fn ropes_that_are_missing_renamed_or_bad_are_wrong() {
        let mut tally = Tally::default();
        let mut before = None;
        let whole = [0.0, 600.0];
        let mut judge = |curves: &[Descriptor3]| tally.judge(curves, &truth(), &mut before);
        assert_eq!(judge(&[said(1, whole, 0.0)]), None);
        assert_eq!(judge(&[]).as_deref(), Some("none"));
        let both = [said(1, whole, 0.0), said(2, whole, 30.0)];
        assert_eq!(judge(&both).as_deref(), Some("several"));
        let thin = Descriptor3 {
            place: Place::Thin as u32,
            ..said(1, whole, 0.0)
        };
        assert_eq!(judge(&[thin]).as_deref(), Some(Place::Thin.name()));
        let wrong = judge(&[said(2, whole, 8.0)]).expect("it is bad, and another");
        assert!(
            wrong.starts_with("points are 8.0 mm") && wrong.ends_with("renamed"),
            "{wrong}"
        );
        assert_eq!(
            (tally.frames, tally.seen, tally.bad, tally.renamed),
            (5, 2, 1, 1)
        );
        assert_eq!(tally.wrong(), 5);
        assert_eq!(
            tally.missing(),
            format!("1 none, 1 several, 1 {}", Place::Thin.name())
        );
        let mut all = Tally::default();
        all.take(tally);
        assert_eq!((all.frames, all.wrong()), (5, 5));
    }
}
