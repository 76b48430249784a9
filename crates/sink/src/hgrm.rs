//! `.hgrm`: a histogram as text, by HdrHistogram's own format, which its plotters read.

use hdrhistogram::Histogram;
use std::io::{Result, Write};

/// Steps for each halving of the distance to 100 %, as in HdrHistogram's own output.
const TICKS_PER_HALF: u32 = 5;

/// Writes a histogram of nanoseconds, its values in microseconds.
pub(crate) fn write(histogram: &Histogram<u64>, out: &mut impl Write) -> Result<()> {
    let us = |ns: f64| ns / 1e3;
    writeln!(
        out,
        "{:>12} {:>14} {:>10} {:>14}\n",
        "Value", "Percentile", "TotalCount", "1/(1-Percentile)"
    )?;
    let mut count = 0;
    for step in histogram.iter_quantiles(TICKS_PER_HALF) {
        count += step.count_since_last_iteration();
        let value_us = us(step.value_iterated_to().min(histogram.max()) as f64);
        let quantile = step.quantile_iterated_to();
        write!(out, "{value_us:>12.3} {quantile:>14.12} {count:>10}")?;
        if quantile < 1.0 {
            write!(out, " {:>14.2}", 1.0 / (1.0 - quantile))?;
        }
        writeln!(out)?;
    }
    // Of nothing there is neither a mean nor a deviation; the format wants numbers.
    let or_zero = |value: f64| if value.is_finite() { value } else { 0.0 };
    writeln!(
        out,
        "#[Mean    = {:>12.3}, StdDeviation   = {:>12.3}]",
        us(or_zero(histogram.mean())),
        us(or_zero(histogram.stdev()))
    )?;
    writeln!(
        out,
        "#[Max     = {:>12.3}, Total count    = {:>12}]",
        us(histogram.max() as f64),
        histogram.len()
    )?;
    writeln!(
        out,
        "#[Buckets = {:>12}, SubBuckets     = {:>12}]",
        histogram.buckets(),
        1u64 << (64 - (2 * 10u64.pow(histogram.sigfig().into()) - 1).leading_zeros())
    )
}
