//! The table of the rivals.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::{MBEST_MS, STEPS_MS, Samples, Table, millis, times};
use lariat_drawn::scenes::{SeenCurve, score};

use super::Rival;
use super::ours::{Measured, Ours};
use super::pictures::{DRAWN, Pictures, Shown};
use super::script::{Done, Work};

/// Returns the table, the missing libraries, the errors of the points, and figures from another
/// machine.
pub(super) fn report(pictures: &Pictures, ours: &Ours, rivals: &[Rival], passes: usize) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        out,
        "The same pictures, one thread each, medians of {passes} passes in turn\n"
    );
    let _ = writeln!(out, "{}", table(pictures, ours, rivals));
    let _ = writeln!(
        out,
        "The colours of each picture's ropes are told to both, except in the rows marked \"told nothing\". lariat's step \
         does more than\nthe rival's: its mask step thresholds and finds the components, its points step finds centers \
         between pixels too."
    );
    for why in missing(rivals) {
        let _ = writeln!(out, "Not measured: {why}.");
    }
    if let Some(Ok(chain)) = rivals
        .iter()
        .find(|r| r.work == Work::Chain)
        .map(|r| &r.done)
    {
        let _ = write!(out, "{}", accuracy(pictures, ours, chain));
    }
    let _ = write!(out, "\n{}", elsewhere(pictures, ours, rivals));
    out
}

fn table(pictures: &Pictures, ours: &Ours, rivals: &[Rival]) -> Table {
    let mut table = Table::new(&[
        "work",
        "pictures",
        "theirs, ms",
        "lariat, ms",
        "theirs ÷ lariat",
        "lariat's step",
        "versions",
    ]);
    for set in &pictures.sets {
        let members = members(pictures, &[set]);
        for rival in rivals {
            let done = rival.done.as_ref().ok();
            let their_ns = done.and_then(|done| median(members.clone(), |k| done.median_ns(k)));
            let mut row = |work: String, of: &dyn Fn(usize) -> f64| {
                let Some(our_ns) = median(members.clone(), |k| Some(of(k))) else {
                    return;
                };
                table.push([
                    work,
                    format!("{set} ({})", members.len()),
                    their_ns.map_or("-".into(), millis),
                    millis(our_ns),
                    their_ns.map_or("-".into(), |ns| times(ns, our_ns)),
                    Measured::step(rival.work).1.into(),
                    done.map_or("-".into(), versions),
                ]);
            };
            let name = rival.work.name();
            row(name.into(), &|k| ours.told(k).median_ns(rival.work));
            if rival.work == Work::Chain {
                row(format!("{name}, told nothing"), &|k| {
                    ours.by_itself(k).median_ns(rival.work)
                });
            }
        }
    }
    table
}

fn versions(done: &Done) -> String {
    let named = |(library, version): (&String, &String)| format!("{library} {version}");
    let named: Vec<String> = done.versions.iter().map(named).collect();
    named.join(", ")
}

/// Returns each reason once, with the measurements that it prevents.
fn missing(rivals: &[Rival]) -> Vec<String> {
    let mut works: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for rival in rivals {
        if let Err(why) = &rival.done {
            works.entry(why).or_default().push(rival.work.name());
        }
    }
    let reasons = works.into_iter().map(|(why, names)| {
        let what = match names.len() {
            all if all == rivals.len() => "the rivals".into(),
            _ => names.join("; "),
        };
        format!("{what}, because {why}")
    });
    reasons.collect()
}

/// Returns the distances of the rival chain's points and lariat's from the truth, where it is
/// known.
fn accuracy(pictures: &Pictures, ours: &Ours, chain: &Done) -> String {
    let [mut theirs, mut told, mut by_itself] = [(); 3].map(|()| Off::default());
    for (k, shown) in pictures.shown.iter().enumerate() {
        let Some(points) = chain.points.get(&k) else {
            continue;
        };
        theirs.add(shown, points);
        told.add(shown, &ours.told(k).points);
        by_itself.add(shown, &ours.by_itself(k).points);
    }
    if theirs.mean_px.count() == 0 {
        return String::new();
    }
    let mut table = Table::new(&["drawn rope, off the truth", "centerline, px", "ends, px"]);
    let thinning = chain.thinning.as_deref().unwrap_or("none");
    let rows = [
        (
            format!("whole chain by scripts (thinned by {thinning})"),
            theirs,
        ),
        ("lariat, told the colours".into(), told),
        ("lariat, told nothing".into(), by_itself),
    ];
    for (name, off) in rows {
        let figure = |samples: &Samples| format!("{:.3}", samples.median());
        table.push([name, figure(&off.mean_px), figure(&off.ends_px)]);
    }
    format!("\n{table}")
}

/// Mean distance of a picture's points from the true centerline, and mean distance of its ends.
#[derive(Default)]
struct Off {
    mean_px: Samples,
    ends_px: Samples,
}

impl Off {
    fn add(&mut self, shown: &Shown, points: &[[f32; 2]]) {
        let Some(truth) = &shown.truth else {
            return;
        };
        let curve = SeenCurve {
            points,
            width_px: 0.0,
            closed: false,
        };
        let score = score(truth, &[curve], &[]);
        self.mean_px.push(score.mean_px());
        let ends = &score.ends_px;
        let mean_px = ends.iter().sum::<f64>() / ends.len().max(1) as f64;
        self.ends_px.push(mean_px);
    }
}

/// Returns figures that were measured elsewhere next to those of this run, for scale.
fn elsewhere(pictures: &Pictures, ours: &Ours, rivals: &[Rival]) -> String {
    let mut table = Table::new(&[
        "measured elsewhere *",
        "pictures",
        "there, ms",
        "here, ms",
        "lariat here, ms",
        "there ÷ lariat",
    ]);
    let mut row = |work: &str, set: &str, ms: f64, here: Option<f64>, ours: Option<f64>| {
        table.push([
            work.into(),
            set.into(),
            format!("{ms:.3}"),
            here.map_or("-".into(), millis),
            ours.map_or("-".into(), millis),
            ours.map_or("-".into(), |ns| times(1e6 * ms, ns)),
        ]);
    };
    for (set, ms) in MBEST_MS {
        let whole = median(members(pictures, &[set]), |k| {
            Some(ours.by_itself(k).median_ns(Work::Chain))
        });
        row("mBEST, centerlines only", set, ms, None, whole);
    }
    let drawn = || members(pictures, &[DRAWN]);
    for (name, ms) in STEPS_MS {
        let rival = rivals.iter().find(|rival| rival.work.name() == name);
        let done = rival.and_then(|rival| rival.done.as_ref().ok());
        let here = done.and_then(|done| median(drawn(), |k| done.median_ns(k)));
        let step =
            rival.and_then(|rival| median(drawn(), |k| Some(ours.told(k).median_ns(rival.work))));
        row(name, "640×480", ms, here, step);
    }
    format!(
        "{table}* on one day, on a core that reads 640×480 RGB in 11 µs; mBEST on the photographs of its own data set. The \
         other rows tell how\nthis machine compares with that one (our script asks for components in 16 bits, which takes \
         a third of the default's time).\n"
    )
}

/// Returns the pictures of these sets.
fn members(pictures: &Pictures, sets: &[&str]) -> Vec<usize> {
    let is_member = |k: &usize| sets.contains(&pictures.sets[pictures.shown[*k].set].as_str());
    (0..pictures.shown.len()).filter(is_member).collect()
}

/// Returns the median over those pictures that have a figure. `None` if there are none.
fn median(pictures: Vec<usize>, of: impl Fn(usize) -> Option<f64>) -> Option<f64> {
    let figures: Samples = pictures.into_iter().filter_map(of).collect();
    (figures.count() > 0).then(|| figures.median())
}
