//! Reads the figures from a `summary.json` of a bench or of a single run.

use std::path::Path;

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::latency::KIND;

/// The kind of a summary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Bench,
    Run,
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bench => "a `lariat bench`",
            Self::Run => "one `lariat run`",
        }
    }

    /// Describes the source of the noise estimate.
    pub(super) fn noise(self) -> &'static str {
        match self {
            Self::Bench => "the spread of the rounds",
            Self::Run => "of single runs only roughly known: `lariat bench` measures it",
        }
    }
}

/// A summary.
#[derive(Debug)]
pub(super) struct Summary {
    pub(super) kind: Kind,
    pub(super) machine: String,
    pub(super) measured: Vec<Measured>,
}

/// A figure and the range of its noise.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measured {
    pub(super) id: String,
    pub(super) figure: String,
    pub(super) value: f64,
    pub(super) low: f64,
    pub(super) high: f64,
    /// Number of rounds that the noise is estimated from.
    pub(super) rounds: usize,
    /// True for a figure of lariat, false for one of the machine or a rival.
    pub(super) ours: bool,
    pub(super) more_is_better: bool,
    /// Minimum relative change that counts.
    pub(super) least_change: f64,
    /// Minimum difference that can be resolved.
    pub(super) resolution: f64,
}

impl Measured {
    pub(super) fn spread(&self) -> f64 {
        let unsure = if self.rounds < 5 { 1.5 } else { 1.0 };
        unsure * (self.high - self.low).max(0.0)
    }
}

/// Round count of a single run, whose noise is computed instead of observed.
const SINGLE: usize = usize::MAX;
/// Minimum number of rounds. With fewer, the noise is unknown.
const LEAST_ROUNDS: usize = 3;

/// Returns the minimum resolvable difference, by the figure's unit. For µs, it is 0.5 because of
/// the clock stamps. For percent of a core (0.2), MB (0.1) and ms (1), it follows from the kernel's
/// accounting. For lost frames, it is below 1, so that every one counts.
fn resolution(figure: &str) -> f64 {
    match figure {
        "lost" => 0.5,
        _ if figure.ends_with("_us") => 0.5,
        _ if figure.ends_with("_percent") => 0.2,
        _ if figure.ends_with("_ms") => 1.0,
        _ if figure.ends_with("_mb") => 0.1,
        _ => 0.0,
    }
}

/// Reads a summary from a file or from the folder that contains it.
pub(super) fn summary(path: &Path) -> Result<Summary> {
    let file = if path.is_dir() {
        path.join("summary.json")
    } else {
        path.to_owned()
    };
    let shown = file.display();
    let text = std::fs::read_to_string(&file).with_context(|| {
        format!("{shown} cannot be read: name a summary.json of `lariat bench --out DIR` or `lariat run --out DIR`")
    })?;
    parse(&text).with_context(|| format!("{shown} is not a summary of lariat"))
}

fn parse(text: &str) -> Result<Summary> {
    let json: Value = serde_json::from_str(text).context("it is not JSON")?;
    let schema = json["schema"].as_u64();
    let (kind, mut measured) = if json["kind"] == KIND {
        (Kind::Bench, bench(&json))
    } else if json["latency_us"].is_object() && json["frames"].is_object() {
        (Kind::Run, run(&json))
    } else {
        bail!("it has neither the keys of `lariat bench` nor those of `lariat run`");
    };
    // The second version of a run's summary has additional keys.
    let newest = match kind {
        Kind::Bench => 1,
        Kind::Run => 2,
    };
    if !schema.is_some_and(|schema| (1..=newest).contains(&schema)) {
        bail!(
            "its keys are of version {}, and this lariat knows version {newest}",
            json["schema"]
        );
    }
    if measured.is_empty() {
        bail!("it holds no figure");
    }
    // A percentile does not show the noise if only a few rounds had enough frames for it.
    measured.retain(|figure| figure.rounds >= LEAST_ROUNDS);
    if measured.is_empty() {
        bail!(
            "it has fewer than {LEAST_ROUNDS} rounds, which do not show the noise: measure without --quick"
        );
    }
    let machine = &json["machine"];
    Ok(Summary {
        kind,
        machine: format!(
            "{}, {} cores",
            machine["cpu"].as_str().unwrap_or("unknown"),
            machine["cores"]
        ),
        measured,
    })
}

/// Returns the figures of a bench that measure quality. It omits the maximum time, which depends on
/// one sample, and the number of frames, which is an option.
fn bench(json: &Value) -> Vec<Measured> {
    let items = json["measured"].as_array().into_iter().flatten();
    let figures = items.flat_map(|item| {
        let figures = item["figures"].as_object().into_iter().flatten();
        figures.map(move |(name, figure)| (item, name, figure))
    });
    figures
        .filter(|(item, name, _)| {
            let id = item["id"].as_str().unwrap_or_default();
            // At a fixed rate, the measured rate is the one that was set.
            let is_rate = *name == "rate_per_s" && !id.contains("@max");
            !is_rate && *name != "max_us" && *name != "frames"
        })
        .filter_map(|(item, name, figure)| {
            Some(Measured {
                id: item["id"].as_str()?.to_owned(),
                figure: name.clone(),
                value: figure["median"].as_f64()?,
                low: figure["low"].as_f64()?,
                high: figure["high"].as_f64()?,
                rounds: figure["rounds"].as_array()?.len(),
                ours: item["group"] == "chain",
                more_is_better: name.ends_with("_per_s"),
                least_change: 0.05,
                resolution: resolution(name),
            })
        })
        .collect()
}

fn run(json: &Value) -> Vec<Measured> {
    let count = json["frames"]["received"].as_f64().unwrap_or(0.0);
    let rows = json["latency_us"].as_object().into_iter().flatten();
    let mut found: Vec<Measured> = rows
        .flat_map(|(row, spread)| {
            [(0.5, "p50"), (0.99, "p99"), (0.999, "p999")]
                .into_iter()
                // A percentile with fewer than ten samples beyond it depends on a few samples.
                .filter(move |(quantile, _)| (1.0 - quantile) * count >= 10.0)
                .filter_map(move |(quantile, name)| percentile(row, spread, quantile, name, count))
        })
        .collect();
    let lost = json["frames"]["lost"].as_object().into_iter().flatten();
    let lost: f64 = lost.filter_map(|(_, count)| count.as_f64()).sum();
    found.push(Measured {
        id: "frames".to_owned(),
        figure: "lost".to_owned(),
        value: lost,
        low: lost,
        high: lost,
        rounds: SINGLE,
        ours: true,
        more_is_better: false,
        least_change: 0.1,
        resolution: resolution("lost"),
    });
    found
}

fn percentile(
    row: &str,
    spread: &Value,
    quantile: f64,
    name: &str,
    count: f64,
) -> Option<Measured> {
    let value = spread[name].as_f64()?;
    // Two standard errors of the rank.
    let reach = 2.0 * (quantile * (1.0 - quantile) / count).sqrt();
    let high = interpolated(spread, quantile + reach)?.max(value);
    Some(Measured {
        id: row.to_owned(),
        figure: name.to_owned(),
        value,
        // The distribution below the median is unknown, so the upward distance is used in both
        // directions.
        low: value - (high - value),
        high,
        rounds: SINGLE,
        ours: true,
        more_is_better: false,
        least_change: 0.1,
        resolution: resolution("_us"),
    })
}

/// Interpolates the distribution at a quantile of at least 0.5. Between known percentiles, times
/// are linear in the logarithm of 1/(1 − q), as in the plots.
fn interpolated(spread: &Value, quantile: f64) -> Option<f64> {
    const KNOWN: [(f64, &str); 4] = [(0.5, "p50"), (0.9, "p90"), (0.99, "p99"), (0.999, "p999")];
    let nines = |quantile: f64| -(1.0 - quantile).log10();
    for pair in KNOWN.windows(2) {
        let [(from, low), (to, high)] = [pair[0], pair[1]];
        if quantile <= to {
            let (low, high) = (spread[low].as_f64()?, spread[high].as_f64()?);
            let share = (nines(quantile) - nines(from)) / (nines(to) - nines(from));
            return Some(low + share * (high - low));
        }
    }
    spread["max"].as_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_runs_noise_comes_from_its_own_distribution() {
        let spread = serde_json::json!({"p50": 100.0, "p90": 200.0, "p99": 400.0, "p999": 800.0, "max": 900.0});
        let wide = percentile("total", &spread, 0.5, "p50", 100.0).expect("a figure");
        let narrow = percentile("total", &spread, 0.5, "p50", 10_000.0).expect("a figure");
        assert!(wide.high > narrow.high && narrow.high > 100.0);
        assert_eq!(interpolated(&spread, 0.9), Some(200.0));
        assert_eq!(interpolated(&spread, 0.9999), Some(900.0));
    }

    #[test]
    fn what_is_no_summary_is_said() {
        let why = |text: &str| format!("{:#}", parse(text).expect_err("no summary"));
        assert!(why("{").contains("not JSON"));
        assert!(why("{}").contains("neither the keys"));
        let newer = r#"{"kind": "lariat bench", "schema": 2, "measured": []}"#;
        assert!(why(newer).contains("version 2"));
        let empty = r#"{"kind": "lariat bench", "schema": 1, "measured": []}"#;
        assert!(why(empty).contains("no figure"));
    }
}
