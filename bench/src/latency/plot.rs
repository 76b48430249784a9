//! Plots of latency distributions: time over percentile, both logarithmic, one line for each
//! distribution.
//!
//! The percentile axis is 1/(1 − q), as in HdrHistogram's own plots. Each decade adds another nine,
//! so that one event in a thousand gets as much space as one in two.

use lariat_plot::{Axis, Chart, LineStyle, Marker, PlotError, Stroke, draw};
use lariat_sink::Times;

/// Points of a line per decade of the percentile axis.
const STEPS: u32 = 24;
/// Dash patterns of the lines that are not emphasized, in turn.
const STROKES: [Stroke; 3] = [Stroke::Dashed, Stroke::Dotted, Stroke::LongDashed];

/// A distribution to draw.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) name: &'a str,
    pub(super) times: &'a Times,
    /// True for the reference lines of the comparison.
    pub(super) bold: bool,
}

/// Draws these distributions as an SVG.
///
/// # Errors
/// Fails if the plotting library does.
pub(super) fn percentiles(lines: &[Line]) -> Result<String, PlotError> {
    let measured = || lines.iter().filter(|line| line.times.count() > 0);
    let most = measured().map(|line| line.times.count()).max();
    let Some(most) = most else {
        return Ok("<p>nothing was measured</p>\n".to_owned());
    };
    let drawn: Vec<_> = measured().map(|line| points(line.times)).collect();
    let times_us = drawn.iter().flatten().map(|point| point[1]);
    let mut chart = Chart::new(
        Axis::nines("percentile", (most as f64).log10().ceil().max(1.0) as u32),
        Axis::log_around("µs", times_us),
    );
    chart.height_px = 380;
    for (index, (line, points)) in measured().zip(drawn).enumerate() {
        let look = LineStyle::nth(index)
            .marker(Marker::None)
            .stroke(match line.bold {
                true => Stroke::Solid,
                false => STROKES[index % STROKES.len()],
            });
        chart.line(line.name, look, points);
    }
    draw("percentiles", &[chart], 1)
}

/// Returns points of 1/(1 − q) and the time in µs, up to the maximum.
fn points(times: &Times) -> Vec<[f64; 2]> {
    let last = (times.count().max(1) as f64).log10();
    let steps = (last * f64::from(STEPS)).ceil() as u32;
    let point = |step| {
        let decades = (f64::from(step) / f64::from(STEPS)).min(last);
        let quantile = match step == steps {
            true => 1.0,
            false => 1.0 - 10f64.powf(-decades),
        };
        // A duration below the clock's resolution is not zero.
        Some([10f64.powf(decades), times.quantile_us(quantile)?.max(0.01)])
    };
    (0..=steps).filter_map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_rises_to_its_longest() {
        let mut times = Times::default();
        (1..=2000).for_each(|us| times.add(us * 1000));
        let points = points(&times);
        assert!(points.len() > 50);
        let rises = |pair: &[[f64; 2]]| pair[0][0] < pair[1][0] && pair[0][1] <= pair[1][1];
        assert!(points.windows(2).all(rises), "{points:?}");
        assert_eq!(points.last().map(|point| point[1]), times.quantile_us(1.0));
        let line = Line {
            name: "a < b",
            times: &times,
            bold: true,
        };
        let svg = percentiles(&[line]).expect("a drawing");
        assert!(svg.contains("a &lt; b") && svg.contains("99.9 %"), "{svg}");
    }

    #[test]
    fn nothing_measured_is_said() {
        let said = |lines: &[Line]| percentiles(lines).expect("a sentence");
        assert!(said(&[]).contains("nothing was measured"));
        let empty = Line {
            name: "x",
            times: &Times::default(),
            bold: false,
        };
        assert!(said(&[empty]).contains("nothing was measured"));
    }
}
