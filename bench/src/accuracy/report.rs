//! The printed table.

use std::fmt::Write;
use std::time::Duration;

use super::causes::{Cause, Disagreement};
use super::drawing::RULE;
use super::measure::Measured;

/// Number of worst images named.
const WORST: usize = 5;

/// Returns the figures of each set, and of all sets together if there are several.
pub(super) fn table(sets: &[(&str, Vec<Measured>)]) -> String {
    let mut rows: Vec<(&str, Vec<&Measured>)> = sets
        .iter()
        .map(|(name, images)| (*name, images.iter().collect()))
        .collect();
    if sets.len() > 1 {
        rows.push(("all", sets.iter().flat_map(|(_, images)| images).collect()));
    }
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{RULE}\n");
    figures(&mut out, &rows);
    disagreements(&mut out, &rows);
    times(&mut out, &rows);
    for (name, images) in sets {
        worst(&mut out, name, images);
    }
    out
}

fn figures(out: &mut String, rows: &[(&str, Vec<&Measured>)]) {
    let _ = writeln!(
        out,
        "missed: labelled pixels farther than half a width + 2 px from every curve; \
         stray: curve more than 2 px off every labelled pixel\n\n\
         {:<10} {:>6} {:>8} {:>8} {:>12} {:>16} {:>16}",
        "set", "images", "DICE", "worst", "wrong count", "missed (worst)", "stray (worst)"
    );
    for (name, images) in rows {
        let (dice, lowest) = (mean(images, |i| i.dice), -most(images, |i| -i.dice));
        let wrong = images.iter().filter(|i| i.is_miscounted()).count();
        let share = |value: fn(&Measured) -> f64| {
            let (mean, worst) = (100.0 * mean(images, value), 100.0 * most(images, value));
            format!("{mean:.3}% ({worst:.2}%)")
        };
        let (missed, stray) = (share(|i| i.coverage.missed), share(|i| i.coverage.stray));
        let _ = writeln!(
            out,
            "{name:<10} {:>6} {dice:>8.4} {lowest:>8.4} {wrong:>12} {missed:>16} {stray:>16}",
            images.len()
        );
    }
}

fn disagreements(out: &mut String, rows: &[(&str, Vec<&Measured>)]) {
    let _ = write!(
        out,
        "\nWhere drawing and label disagree, in % of the labelled pixels: −lacking +excess\n{:<10}",
        "set"
    );
    for cause in Cause::ALL {
        let _ = write!(out, " {:>13}", cause.name());
    }
    let _ = writeln!(out, " {:>13} {:>13}", "sum", "side edge, px");
    for (name, images) in rows {
        let mut all = Disagreement::default();
        images.iter().for_each(|i| all.add(&i.disagreement));
        let area = images.iter().map(|i| i.area).sum::<usize>().max(1) as f64;
        let signed = |lacking: usize, excess: usize| {
            let share = |pixels: usize| 100.0 * pixels as f64 / area;
            format!("−{:.3} +{:.3}", share(lacking), share(excess))
        };
        let _ = write!(out, "{name:<10}");
        for (&lacking, &excess) in all.lacking.iter().zip(&all.excess) {
            let _ = write!(out, " {:>13}", signed(lacking, excess));
        }
        let sum = signed(all.lacking.iter().sum(), all.excess.iter().sum());
        let _ = writeln!(out, " {sum:>13} {:>+13.3}", all.edge_bias_px());
    }
}

fn times(out: &mut String, rows: &[(&str, Vec<&Measured>)]) {
    let _ = writeln!(
        out,
        "\nTime for an image in ms, medians\n{:<10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "set", "mask", "skeleton", "graph", "points", "extract", "(decode)"
    );
    for (name, images) in rows {
        let _ = write!(out, "{name:<10}");
        let columns: [fn(&Measured) -> Duration; 6] = [
            |i| i.times.steps[0],
            |i| i.times.steps[1],
            |i| i.times.steps[2],
            |i| i.times.steps[3],
            |i| i.times.extract(),
            |i| i.times.decode,
        ];
        for column in columns {
            let mut times: Vec<_> = images.iter().map(|i| column(i)).collect();
            times.sort();
            let median = times.get(times.len() / 2).copied().unwrap_or_default();
            let _ = write!(out, " {:>9.3}", 1e3 * median.as_secs_f64());
        }
        out.push('\n');
    }
}

fn worst(out: &mut String, set: &str, images: &[Measured]) {
    let named = |value: fn(&Measured) -> f64, show: fn(&Measured) -> String| {
        let mut order: Vec<_> = images.iter().collect();
        order.sort_by(|a, b| value(b).total_cmp(&value(a)));
        let worst = order.iter().take(WORST);
        let worst: Vec<_> = worst.map(|i| format!("{} {}", i.name, show(i))).collect();
        worst.join(", ")
    };
    let dice = named(|i| -i.dice, |i| format!("{:.4}", i.dice));
    let missed = named(
        |i| i.coverage.missed,
        |i| format!("{:.3}%", 100.0 * i.coverage.missed),
    );
    let _ = writeln!(
        out,
        "\n{set}, worst by DICE: {dice}\n{set}, worst by missed: {missed}"
    );
    let wrong = images.iter().filter(|i| i.is_miscounted());
    let wrong: Vec<_> = wrong
        .map(|i| format!("{} {} of {}", i.name, i.curves.len(), i.ropes))
        .collect();
    if !wrong.is_empty() {
        let _ = writeln!(out, "{set}, wrong count: {}", wrong.join(", "));
    }
}

fn mean(images: &[&Measured], value: impl Fn(&Measured) -> f64) -> f64 {
    images.iter().map(|i| value(i)).sum::<f64>() / images.len().max(1) as f64
}

fn most(images: &[&Measured], value: impl Fn(&Measured) -> f64) -> f64 {
    images
        .iter()
        .map(|i| value(i))
        .fold(f64::NEG_INFINITY, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::drawing::tests::curve;
    use crate::accuracy::measure::{Bench, tests::picture};

    #[test]
    fn the_table_has_the_rule_each_set_and_the_worst() {
        let rope = curve(&[[30.0, 50.0], [120.0, 54.0], [210.0, 50.0]], 11.0);
        let (photo, label) = picture(&[rope]);
        let mut good = Bench::new(lariat_extract::Method::Skeleton, crate::mask::Mask::Auto)
            .unwrap()
            .extract(&photo, &label)
            .unwrap();
        good.name = "good".into();
        let mut bad = Bench::new(lariat_extract::Method::Skeleton, crate::mask::Mask::Auto)
            .unwrap()
            .extract(&picture(&[]).0, &label)
            .unwrap();
        bad.name = "bad".into();
        let table = table(&[("one", vec![good.clone()]), ("two", vec![good, bad])]);
        assert!(table.starts_with(RULE));
        let row = |name: &str| {
            let row = table.lines().find(|l| l.starts_with(name)).unwrap();
            row.split_whitespace()
                .map(str::to_owned)
                .collect::<Vec<_>>()
        };
        // Images, and those with a wrong count.
        assert_eq!([&row("one")[1], &row("one")[4]], ["1", "0"]);
        assert_eq!([&row("two")[1], &row("two")[4]], ["2", "1"]);
        assert_eq!([&row("all")[1], &row("all")[4]], ["3", "1"]);
        assert!(table.contains("two, worst by DICE: bad 0.0000, good "));
        assert!(table.contains("two, wrong count: bad 0 of 1"));
        assert!(!table.contains("one, wrong count"));
    }
}
