//! `.hgrm`: a histogram as text in HdrHistogram's own format, which its plotters read.

use crate::times::Times;
use std::io::{Result, Write};

/// Steps for each halving of the distance to 100 %, as in HdrHistogram's own output.
const TICKS_PER_HALF: u32 = 5;

/// Writes a distribution of durations, in microseconds.
pub(crate) fn write(times: &Times, out: &mut impl Write) -> Result<()> {
    let histogram = times.histogram();
    // An empty distribution has neither mean nor maximum, but the format requires numbers.
    let longest_us = times.quantile_us(1.0).unwrap_or(0.0);
    let mean_us = times.mean_us().unwrap_or(0.0);
    writeln!(
        out,
        "{:>12} {:>14} {:>10} {:>14}\n",
        "Value", "Percentile", "TotalCount", "1/(1-Percentile)"
    )?;
    let mut count = 0;
    for step in histogram.iter_quantiles(TICKS_PER_HALF) {
        count += step.count_since_last_iteration();
        let value_us = (step.value_iterated_to() as f64 / 1e3).min(longest_us);
        let quantile = step.quantile_iterated_to();
        write!(out, "{value_us:>12.3} {quantile:>14.12} {count:>10}")?;
        if quantile < 1.0 {
            write!(out, " {:>14.2}", 1.0 / (1.0 - quantile))?;
        }
        writeln!(out)?;
    }
    writeln!(
        out,
        "#[Mean    = {:>12.3}, StdDeviation   = {:>12.3}]",
        mean_us,
        histogram.stdev() / 1e3
    )?;
    writeln!(
        out,
        "#[Max     = {:>12.3}, Total count    = {:>12}]",
        longest_us,
        histogram.len()
    )?;
    writeln!(
        out,
        "#[Buckets = {:>12}, SubBuckets     = {:>12}]",
        histogram.buckets(),
        1u64 << (64 - (2 * 10u64.pow(histogram.sigfig().into()) - 1).leading_zeros())
    )
}

/// Reads a distribution of durations. Its mean is computed from the steps.
pub(crate) fn read(text: &str) -> Option<Times> {
    let mut times = Times::default();
    let mut before = 0;
    let mut lines = text.lines();
    lines.find(|line| line.trim_start().starts_with("Value"))?;
    for line in lines {
        let mut words = line.split_whitespace();
        match words.next() {
            None => {}
            Some("#[Max") => {
                let total = line.rsplit('=').next()?;
                let total: u64 = total.trim().trim_end_matches(']').parse().ok()?;
                return (total == before).then_some(times);
            }
            Some(word) if word.starts_with('#') => {}
            Some(value_us) => {
                let value_us: f64 = value_us.parse().ok()?;
                let count: u64 = words.nth(1)?.parse().ok()?;
                times.add_many((value_us * 1e3).round() as u64, count.checked_sub(before)?);
                before = count;
            }
        }
    }
    // The end is missing.
    None
}
