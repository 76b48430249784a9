//! The order of the strands at each crossing, compared with human judgment.
//!
//! A list gives the picture, the position and the upper strand's direction of each crossing. If it
//! contains one crossing of a set, it contains all of them. A detected crossing is matched to the
//! nearest listed one within a width and a half. The order is right if the upper strand is closer
//! to the listed direction than the lower strand is.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use lariat_extract::{Crossing, Curve};

use super::measure::Measured;

/// Maximum distance between a detected crossing and its listed position, in widths. At an acute
/// crossing, both positions are approximate.
const NEAR: f32 = 1.5;
/// Distance to each side over which directions are measured, in widths. Measured directly at an
/// acute crossing, the directions would be equal.
const CHORD: f32 = 1.5;
/// Lower bounds of the confidence bins.
const BINS: [f32; 3] = [0.0, 0.5, 0.9];

/// A crossing as judged by eye.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LabelledCrossing {
    /// Set and picture: `S1/img000`.
    image: String,
    at: [f32; 2],
    /// Direction of the upper strand, modulo 180°.
    over_deg: f32,
    /// True if the judgment is certain.
    sure: bool,
}

/// Comparison of detected with listed crossings.
#[derive(Clone, Debug, Default, PartialEq)]
struct Score {
    right: usize,
    wrong: usize,
    /// Number of detected crossings whose order could not be judged by eye.
    unsure: usize,
    missed: usize,
    invented: usize,
    /// Distances between detected and listed positions.
    off_px: Vec<f32>,
    /// Number of crossings in each bin of confidence, and how many of them are right.
    bins: [(usize, usize); BINS.len()],
    /// Descriptions of the wrong, missed and invented crossings.
    remarks: Vec<String>,
}

/// Returns the list that belongs to a data set: `labels/NAME-crossings.csv` of this crate, where
/// NAME is the data set's folder or its parent.
pub(super) fn list_for(dataset: &Path) -> Option<PathBuf> {
    let whole = fs::canonicalize(dataset).ok()?;
    let names = whole.ancestors().take(2).filter_map(Path::file_name);
    let labels = Path::new(env!("CARGO_MANIFEST_DIR")).join("labels");
    let mut lists =
        names.map(|name| labels.join(format!("{}-crossings.csv", name.to_string_lossy())));
    lists.find(|list| list.is_file())
}

/// Reads a list. Its first line is `image,x,y,over_deg,sure`, followed by a line for each crossing.
///
/// # Errors
/// The file cannot be read, or a line does not have these five values.
pub(super) fn load(path: &Path) -> Result<Vec<LabelledCrossing>> {
    let shown = path.display();
    let text = fs::read_to_string(path)
        .with_context(|| format!("cannot read the crossings in {shown}"))?;
    let mut seen = Vec::new();
    for (i, line) in text.lines().enumerate().skip(1) {
        let Some(crossing) = parse(line) else {
            bail!(
                "line {} of {shown} is not `SET/IMAGE,x,y,degrees,yes|no`: {line}",
                i + 1
            );
        };
        seen.push(crossing);
    }
    Ok(seen)
}

fn parse(line: &str) -> Option<LabelledCrossing> {
    let [image, x, y, over_deg, sure] = line.split(',').collect::<Vec<_>>().try_into().ok()?;
    Some(LabelledCrossing {
        image: image
            .rsplit_once('.')
            .map_or(image, |(name, _)| name)
            .to_owned(),
        at: [x.parse().ok()?, y.parse().ok()?],
        over_deg: over_deg.parse().ok()?,
        sure: match sure {
            "yes" => true,
            "no" => false,
            _ => return None,
        },
    })
}

/// Returns the table of all sets that are in the list. Empty if there are none.
pub(super) fn table(sets: &[(&str, Vec<Measured>)], seen: &[LabelledCrossing]) -> String {
    let mut out = String::new();
    let mut bins = [(0, 0); BINS.len()];
    let mut remarks = Vec::new();
    // Writing to a string cannot fail.
    for (set, images) in sets {
        let score = score(set, images, seen);
        let Some(mut score) = score else { continue };
        if out.is_empty() {
            let _ = writeln!(
                out,
                "\nCrossings, the upper strand told by eye\n{:<10} {:>6} {:>6} {:>7} {:>7} {:>9} {:>18}",
                "set", "right", "wrong", "unsure", "missed", "invented", "off, px (worst)"
            );
        }
        score.off_px.sort_by(f32::total_cmp);
        let median = score.off_px.get(score.off_px.len() / 2).unwrap_or(&0.0);
        let worst = score.off_px.last().unwrap_or(&0.0);
        let _ = writeln!(
            out,
            "{set:<10} {:>6} {:>6} {:>7} {:>7} {:>9} {:>18}",
            score.right,
            score.wrong,
            score.unsure,
            score.missed,
            score.invented,
            format!("{median:.2} ({worst:.1})")
        );
        for (all, bin) in bins.iter_mut().zip(score.bins) {
            *all = (all.0 + bin.0, all.1 + bin.1);
        }
        remarks.extend(score.remarks);
    }
    if !out.is_empty() {
        let of = |(i, (count, right)): (usize, &(usize, usize))| {
            let to = BINS.get(i + 1).unwrap_or(&1.0);
            format!("{:.1} to {to:.1}: {right} of {count}", BINS[i])
        };
        let bins: Vec<_> = bins.iter().enumerate().map(of).collect();
        let _ = writeln!(out, "right by confidence: {}", bins.join(", "));
        remarks.iter().for_each(|remark| {
            let _ = writeln!(out, "{remark}");
        });
    }
    out
}

/// Compares a set. Returns `None` if the list does not contain it.
fn score(set: &str, images: &[Measured], seen: &[LabelledCrossing]) -> Option<Score> {
    let of_set = |s: &&LabelledCrossing| s.image.split('/').next() == Some(set);
    seen.iter().find(of_set)?;
    let mut score = Score::default();
    for image in images {
        let name = format!("{set}/{}", image.name);
        let here: Vec<_> = seen.iter().filter(|s| s.image == name).collect();
        score.add(&name, &image.curves, &image.crossings, &here);
    }
    Some(score)
}

impl Score {
    /// Adds one image.
    fn add(
        &mut self,
        name: &str,
        curves: &[Curve],
        found: &[Crossing],
        seen: &[&LabelledCrossing],
    ) {
        let mut pairs = Vec::new();
        for (i, crossing) in found.iter().enumerate() {
            let near_px = NEAR * curves[crossing.over].width_px;
            for (j, seen) in seen.iter().enumerate() {
                let off = (crossing.at[0] - seen.at[0]).hypot(crossing.at[1] - seen.at[1]);
                if off <= near_px {
                    pairs.push((off, i, j));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut taken = (vec![false; found.len()], vec![false; seen.len()]);
        for (off, i, j) in pairs {
            if !taken.0[i] && !taken.1[j] {
                (taken.0[i], taken.1[j]) = (true, true);
                self.off_px.push(off);
                self.compare(name, curves, &found[i], seen[j]);
            }
        }
        for (crossing, _) in found.iter().zip(&taken.0).filter(|(_, taken)| !**taken) {
            self.invented += 1;
            self.remark("invented", name, crossing.at);
        }
        for (seen, _) in seen.iter().zip(&taken.1).filter(|(_, taken)| !**taken) {
            self.missed += 1;
            self.remark("missed", name, seen.at);
        }
    }

    fn compare(&mut self, name: &str, curves: &[Curve], found: &Crossing, seen: &LabelledCrossing) {
        if !seen.sure {
            self.unsure += 1;
            return;
        }
        let off = |curve: usize, rho: f32| {
            let turn = (direction_deg(&curves[curve], rho) - seen.over_deg).rem_euclid(180.0);
            turn.min(180.0 - turn)
        };
        let right = off(found.over, found.over_rho) < off(found.under, found.under_rho);
        let bin = BINS.iter().rposition(|&from| found.confidence >= from);
        if let Some(bin) = bin {
            self.bins[bin].0 += 1;
            self.bins[bin].1 += usize::from(right);
        }
        if right {
            self.right += 1;
        } else {
            self.wrong += 1;
            let how = format!("wrong (confidence {:.2})", found.confidence);
            self.remark(&how, name, seen.at);
        }
    }

    fn remark(&mut self, what: &str, name: &str, [x, y]: [f32; 2]) {
        self.remarks
            .push(format!("{what}: {name} at {x:.0}, {y:.0}"));
    }
}

/// Returns the direction of the curve around `rho`, in degrees.
fn direction_deg(curve: &Curve, rho: f32) -> f32 {
    let away = CHORD * curve.width_px / curve.length_px.max(1.0);
    let [a, b] = [rho - away, rho + away].map(|rho| at(curve, rho));
    (b[1] - a[1]).atan2(b[0] - a[0]).to_degrees()
}

/// Returns the point at normalized arc length `rho`. Beyond the ends of an open curve, returns its
/// tip.
fn at(curve: &Curve, rho: f32) -> [f32; 2] {
    let n = curve.points.len();
    let (rho, intervals) = if curve.closed {
        (rho.rem_euclid(1.0), n)
    } else {
        (rho.clamp(0.0, 1.0), n - 1)
    };
    let place = rho * intervals as f32;
    let i = (place as usize).min(intervals.saturating_sub(1));
    let (a, b, t) = (curve.points[i], curve.points[(i + 1) % n], place - i as f32);
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::drawing::tests::{crossing, curve};

    /// Returns a horizontal and a steep rope that cross at (120, 80), with the horizontal one on
    /// top.
    fn cross() -> ([Curve; 2], Crossing) {
        let level = curve(&[[20.0, 80.0], [120.0, 80.0], [220.0, 80.0]], 10.0);
        let steep = curve(&[[120.0, 10.0], [120.0, 80.0], [120.0, 150.0]], 10.0);
        ([level, steep], crossing([120.0, 80.0], 0, 1))
    }

    fn scored(found: &[Crossing], lines: &[&str]) -> Score {
        let (curves, _) = cross();
        let seen: Vec<_> = lines.iter().map(|line| parse(line).unwrap()).collect();
        let mut score = Score::default();
        score.add("S1/a", &curves, found, &seen.iter().collect::<Vec<_>>());
        score
    }

    #[test]
    fn the_upper_strand_is_known_by_its_direction() {
        let (_, found) = cross();
        let score = scored(&[found], &["S1/a.jpg,121,80,178,yes"]);
        assert_eq!((score.right, score.wrong), (1, 0));
        assert_eq!(score.bins, [(0, 0), (0, 0), (1, 1)]);
        let score = scored(&[found], &["S1/a.jpg,121,80,88,yes"]);
        assert_eq!((score.right, score.wrong), (0, 1));
        assert_eq!(score.bins, [(0, 0), (0, 0), (1, 0)]);
        assert_eq!(score.remarks, ["wrong (confidence 0.95): S1/a at 121, 80"]);
        let score = scored(&[found], &["S1/a.jpg,121,80,88,no"]);
        assert_eq!((score.right, score.wrong, score.unsure), (0, 0, 1));
    }

    #[test]
    fn what_is_far_from_every_line_is_invented_and_the_line_missed() {
        let (_, found) = cross();
        let score = scored(&[found], &["S1/a.jpg,150,80,0,yes"]);
        assert_eq!((score.missed, score.invented), (1, 1));
        let score = scored(&[found, found], &["S1/a.jpg,120,80,0,yes"]);
        assert_eq!((score.right, score.invented), (1, 1));
    }

    #[test]
    fn a_set_that_is_not_in_the_list_is_not_told_of() {
        let seen = [parse("S1/a.jpg,121,80,178,yes").unwrap()];
        assert_eq!(table(&[("S3", Vec::new())], &seen), "");
        assert!(table(&[("S1", Vec::new())], &seen).contains("S1"));
    }

    #[test]
    fn a_line_that_is_no_crossing_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("list.csv");
        fs::write(
            &list,
            "image,x,y,over_deg,sure\nS1/a.jpg,1,2,3,yes\nS1/a.jpg,1,2,maybe\n",
        )
        .unwrap();
        let error = format!("{:#}", load(&list).unwrap_err());
        assert!(error.contains("line 3"), "{error}");
        fs::write(&list, "image,x,y,over_deg,sure\nS1/a.jpg,1,2,3,yes\n").unwrap();
        assert_eq!(load(&list).unwrap().len(), 1);
    }
}
