//! Sentences about the findings, generated from the numbers alone.

use super::summary::Summary;
use super::table::fixed;
use super::{Group, Harder, Row, Study, by_value};

/// Describes the results of a group compared with the default case.
pub(super) fn finding(study: &Study, group: Group) -> String {
    let rows = study.of(group);
    let Some(base) = study.base().map(Summary::of) else {
        return String::new();
    };
    let text = match (group.harder(), by_value(&rows)) {
        (_, _) if group == Group::AsItIs => as_it_is(&base),
        (Harder::Upwards, Some(values)) => sweep(study, group, &values, &base),
        (Harder::Downwards, Some(mut values)) => {
            values.reverse();
            sweep(study, group, &values, &base)
        }
        _ => comparison(&rows),
    };
    study.in_unit(&text)
}

fn as_it_is(base: &Summary) -> String {
    let Summary {
        ropes,
        reached,
        time_s,
        overshoot_px,
        final_px,
    } = base;
    let mut text = format!("{reached} of {ropes} ropes reach the target");
    if time_s.median.is_finite() {
        text += &format!(", half of all within {} s", fixed(time_s.median, 2));
    }
    if time_s.p90.is_finite() {
        text += &format!(" and nine tenths within {} s", fixed(time_s.p90, 2));
    }
    text += ". ";
    text += &match overshoot_px.worst {
        worst if worst > 0.0 => format!(
            "Once there, the one that goes farthest away again goes {} px beyond. ",
            fixed(worst, 1)
        ),
        // If no rope reached the target, this is NaN.
        0.0 => "Once there, none goes away again. ".to_owned(),
        _ => String::new(),
    };
    text + &format!(
        "In the end they are {} px from it by median, {} px at worst.",
        fixed(final_px.median, 1),
        fixed(final_px.worst, 1)
    )
}

/// Describes values from the mildest to the hardest: the last one without a loss, and the loss
/// beyond it.
fn sweep(study: &Study, group: Group, values: &[(f64, &Row)], base: &Summary) -> String {
    let summaries: Vec<Summary> = values.iter().map(|(_, row)| Summary::of(row)).collect();
    let held = summaries
        .iter()
        .take_while(|summary| !summary.is_worse_than(base))
        .count();
    let said = |i: usize| group.said(values[i].0);
    let again = |i: usize| group.said_again(values[i].0);
    let to = match group.harder() {
        Harder::Downwards => "Down to",
        _ => "Up to",
    };
    let last = values.len() - 1;
    let mut text = match held {
        0 => format!("Already at {} {}", said(0), lost(&summaries[0], base)),
        all if all > last => format!(
            "{to} {}, the most that was tried, nothing is lost: {}",
            said(last),
            ranges(&summaries)
        ),
        held => format!(
            "{to} {} nothing is lost; at {} {}",
            said(held - 1),
            again(held),
            lost(&summaries[held], base)
        ),
    };
    if held < last {
        text += &format!("; at {} {}", again(last), lost(&summaries[last], base));
    }
    text.push('.');
    if let (Group::Latency, Some(own_ms)) = (group, study.own_latency_ms) {
        let harm_ms = values.get(held).map(|(ms, _)| *ms);
        text += &own(own_ms, harm_ms, values[last].0);
    }
    text
}

/// Compares lariat's own latency with the lowest harmful latency, or with the highest one tried.
fn own(own_ms: f64, harm_ms: Option<f64>, most_ms: f64) -> String {
    let limit_ms = harm_ms.unwrap_or(most_ms);
    let is_what = match harm_ms {
        Some(_) => "what hurts",
        None => "the most that was tried",
    };
    let own = format!(" The chain's own latency, {} ms,", fixed(own_ms, 2));
    if limit_ms > own_ms {
        format!("{own} is {:.0} times below {is_what}.", limit_ms / own_ms)
    } else {
        format!("{own} is not below {is_what}.")
    }
}

/// Compares named rows: names the best and the worst, or says that there is little difference.
fn comparison(rows: &[&Row]) -> String {
    let mut ranked: Vec<(&Row, Summary)> =
        (rows.iter()).map(|&row| (row, Summary::of(row))).collect();
    ranked.sort_by(|(_, a), (_, b)| {
        let by_share = b.share().total_cmp(&a.share());
        by_share.then(a.time_s.median.total_cmp(&b.time_s.median))
    });
    let (Some((best_row, best)), Some((worst_row, worst))) = (ranked.first(), ranked.last()) else {
        return String::new();
    };
    if ranked.len() == 1 {
        return format!("{}: {}.", best_row.name, ranges(&[*best]));
    }
    if !ranked
        .iter()
        .any(|(_, summary)| summary.is_worse_than(best))
    {
        let all: Vec<Summary> = ranked.iter().map(|(_, summary)| *summary).collect();
        return format!("It makes little difference: {}.", ranges(&all));
    }
    format!(
        "Best is {} ({}); worst is {}: {}.",
        best_row.name,
        ranges(&[*best]),
        worst_row.name,
        lost(worst, best)
    )
}

/// Describes what is worse in `row` than in `other`.
fn lost(row: &Summary, other: &Summary) -> String {
    let mut text = match (row.reached, row.ropes) {
        (0, ropes) => format!("none of {ropes} ropes reaches the target"),
        (reached, ropes) => format!("{reached} of {ropes} ropes reach the target"),
    };
    let (time_s, instead_s) = (row.time_s.median, other.time_s.median);
    if time_s.is_finite() && instead_s.is_finite() {
        text += &format!(
            ", half of all within {} s instead of {} s",
            fixed(time_s, 2),
            fixed(instead_s, 2)
        );
    }
    if row.is_farther_than(other) {
        text += &format!(
            ", and they end {} px from it instead of {} px",
            fixed(row.final_px.median, 1),
            fixed(other.final_px.median, 1)
        );
    }
    text
}

/// Describes several rows together by their ranges.
fn ranges(rows: &[Summary]) -> String {
    let range = |numbers: &mut dyn Iterator<Item = f64>, decimals| {
        let (low, high) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let (low, high) = (fixed(low, decimals), fixed(high, decimals));
        if low == high {
            low
        } else {
            format!("{low} to {high}")
        }
    };
    let ropes = rows.first().map_or(0, |row| row.ropes);
    let reached = range(&mut rows.iter().map(|row| row.reached as f64), 0);
    let text = format!("{reached} of {ropes} ropes reach the target");
    if rows.iter().any(|row| !row.time_s.median.is_finite()) {
        return text;
    }
    let times = range(&mut rows.iter().map(|row| row.time_s.median), 2);
    format!("{text}, half of all within {times} s")
}
