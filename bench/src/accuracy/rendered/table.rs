//! The figures of each class as a table, the worst pictures, and CSV with one line per picture.

use std::fmt::Write;

use crate::Samples;
use lariat_drawn::scenes::{Class, Score};

use super::Measured;

/// Target for the mean distance in every class.
const MEAN_PX: f64 = 0.3;
const CORRESPONDENCE_PX: f64 = 2.0;
const ENDS_PX: f64 = 1.0;
const CONNECTED: f64 = 0.99;
/// Minimum angle of the crossings that count.
const FLATTEST_DEG: f64 = 25.0;
/// Number of worst pictures shown.
const WORST: usize = 5;

pub(super) fn head() -> String {
    format!(
        "{:<15} {:>8} {:>6} {:>8} {:>9} {:>9} {:>9} {:>7} {:>14} {:>14}\n\
         {:<15} {:>8} {:>6} {:>8} {:>9} {:>9} {:>9} {:>7} {:>14} {:>14}",
        "class",
        "pictures",
        "wrong",
        "mean",
        "corresp.",
        "ends",
        "ends",
        "width",
        "connected",
        "order",
        "",
        "",
        "count",
        "px",
        "p95 px",
        "p95 px",
        "max px",
        "± px",
        "(above 25°)",
        "right",
    )
}

/// Returns the 95th percentile. 0 if there are no values.
fn p95(values: impl Iterator<Item = f64>) -> f64 {
    Samples::from_iter(values).percentile(0.95)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| {
        (sum + value, count + 1)
    });
    sum / count.max(1) as f64
}

/// Marks a figure that misses its target.
fn marked(text: String, is_met: bool) -> String {
    if is_met { text + " " } else { text + "!" }
}

/// Returns the number of right crossings and the number of all crossings, counting only those above
/// [`FLATTEST_DEG`].
fn share(
    scores: &[&Score],
    is_right: impl Fn(&lariat_drawn::scenes::CrossingScore) -> bool,
) -> (usize, usize) {
    let crossings = scores.iter().flat_map(|score| &score.crossings);
    let above: Vec<_> = crossings.filter(|c| c.angle_deg > FLATTEST_DEG).collect();
    (above.iter().filter(|c| is_right(c)).count(), above.len())
}

pub(super) fn row(class: Class, measured: &[Measured]) -> String {
    let scores: Vec<&Score> = measured.iter().map(|m| &m.score).collect();
    let wrong = scores.iter().filter(|score| score.is_miscounted()).count();
    let mean_px = mean(scores.iter().map(|score| score.mean_px()));
    let all = |pick: fn(&Score) -> &Vec<f64>| {
        let values = scores
            .iter()
            .flat_map(move |score| pick(score).iter().copied());
        values.collect::<Vec<f64>>()
    };
    let correspondence_px = p95(all(|s| &s.correspondences_px).into_iter());
    let ends = all(|s| &s.ends_px);
    let ends_px = p95(ends.iter().copied());
    let worst_end_px = ends.iter().copied().fold(0.0, f64::max);
    let width_px = mean(all(|s| &s.width_errors_px).into_iter().map(f64::abs));
    let (mut connected, mut of) = share(&scores, |c| c.connected);
    let (ordered, crossings) = share(&scores, |c| c.order_right);
    let touches = || scores.iter().flat_map(|score| &score.touches);
    connected += touches().filter(|&&is_kept_apart| is_kept_apart).count();
    of += touches().count();
    let is_connected = connected as f64 >= CONNECTED * of as f64;
    let met = [
        wrong == 0,
        mean_px <= MEAN_PX,
        correspondence_px <= CORRESPONDENCE_PX,
        ends_px <= ENDS_PX,
        is_connected,
    ];
    let counted = |n: usize, of: usize| {
        if of == 0 {
            "-".to_owned()
        } else {
            format!("{n}/{of} {:.0}%", 100.0 * n as f64 / of as f64)
        }
    };
    format!(
        "{class:<15} {:>8} {:>6} {:>8} {:>9} {:>9} {worst_end_px:>9.2} {width_px:>7.2} {:>14} {:>14} {}",
        measured.len(),
        marked(wrong.to_string(), met[0]),
        marked(format!("{mean_px:.3}"), met[1]),
        marked(format!("{correspondence_px:.2}"), met[2]),
        marked(format!("{ends_px:.2}"), met[3]),
        marked(counted(connected, of), met[4]),
        counted(ordered, crossings),
        if met.iter().all(|&is| is) {
            "✓"
        } else {
            "✗"
        },
    )
}

/// Returns a sort key for bad pictures: first the number of wrong counts and connections, then the
/// farthest point.
fn badness(score: &Score) -> (usize, f64) {
    let broken = score.crossings.iter().filter(|c| !c.connected).count()
        + score
            .touches
            .iter()
            .filter(|&&is_kept_apart| !is_kept_apart)
            .count();
    let farthest_px = score.correspondences_px.iter().copied().fold(0.0, f64::max);
    (broken + usize::from(score.is_miscounted()), farthest_px)
}

pub(super) fn foot(measured: &[Measured]) -> String {
    let mut order: Vec<&Measured> = measured.iter().collect();
    order.sort_by(|a, b| {
        let (a, b) = (badness(&a.score), badness(&b.score));
        b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    let mut text = format!(
        "\nTo reach (! where it is not): no wrong count, mean ≤ {MEAN_PX} px, correspondence p95 ≤ {CORRESPONDENCE_PX} px, \
         ends p95 ≤ {ENDS_PX} px, {}% of the crossings above {FLATTEST_DEG}° and of the touching strands connected.\nThe worst pictures:\n",
        100.0 * CONNECTED
    );
    for m in order.iter().take(WORST) {
        let score = &m.score;
        let (broken, farthest_px) = badness(score);
        let _ = writeln!(
            text,
            "  --class {} --seed {} --seeds 1: {} ropes, {} curves, {broken} broken, mean {:.2} px, farthest {farthest_px:.1} px",
            m.class,
            m.seed,
            score.ropes,
            score.curves,
            score.mean_px(),
        );
    }
    let mut doubted: Vec<String> = Vec::new();
    for of in measured.chunk_by(|a, b| a.class == b.class) {
        let curves: usize = of.iter().map(|m| m.doubtful).sum();
        if curves > 0 {
            doubted.push(format!("{curves} in {}", of[0].class));
        }
    }
    if !doubted.is_empty() {
        let _ = writeln!(
            text,
            "Curves that may not be ropes, and are not counted: {}.",
            doubted.join(", ")
        );
    }
    text
}

/// Returns the CSV text with one line per picture.
pub(super) fn csv(measured: &[Measured]) -> String {
    let mut text = String::from(
        "class,seed,width_px,ropes,curves,misclosed,mean_px,correspondence_p95_px,correspondence_max_px,end_max_px,\
         width_error_px,crossings,connected,order_right,flattest_deg,touches,kept_apart\n",
    );
    for m in measured {
        let score = &m.score;
        let off = || score.correspondences_px.iter().copied();
        let count = |is: fn(&lariat_drawn::scenes::CrossingScore) -> bool| {
            score.crossings.iter().filter(|c| is(c)).count()
        };
        let flattest_deg = score
            .crossings
            .iter()
            .map(|c| c.angle_deg)
            .fold(90.0, f64::min);
        let _ = writeln!(
            text,
            "{},{},{:.2},{},{},{},{:.4},{:.4},{:.4},{:.4},{:.4},{},{},{},{flattest_deg:.1},{},{}",
            m.class,
            m.seed,
            m.width_px,
            score.ropes,
            score.curves,
            score.misclosed,
            score.mean_px(),
            p95(off()),
            off().fold(0.0, f64::max),
            score.ends_px.iter().copied().fold(0.0, f64::max),
            mean(score.width_errors_px.iter().copied()),
            score.crossings.len(),
            count(|c| c.connected),
            count(|c| c.order_right),
            score.touches.len(),
            score
                .touches
                .iter()
                .filter(|&&is_kept_apart| is_kept_apart)
                .count(),
        );
    }
    text
}
