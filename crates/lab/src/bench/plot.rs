//! Distributions of latency as an inline SVG: time over percentile, both logarithmic, one line for each.
//!
//! The axis of percentiles is 1/(1 − q): a step along it is another nine, so that what happens once in a thousand times
//! has as much room as what happens every other time (as in HdrHistogram's own plots).

use std::fmt::Write;

use lariat_sink::Times;

/// A line's colours, one after the other: Okabe and Ito's (2008), which the colour-blind tell apart, then darker ones.
const COLORS: [&str; 14] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#8a6d00",
    "#5b3fa0", "#7f1d1d", "#0f5c4a", "#666666", "#b0367a", "#1f3b73",
];
/// Outside and inside of the axes, px.
const WIDTH: f64 = 1100.0;
const HEIGHT: f64 = 460.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 700.0;
const TOP: f64 = 20.0;
const BOTTOM: f64 = 410.0;
/// Points of a line on each decade of its axis.
const STEPS: u32 = 24;

/// A distribution to draw.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) name: &'a str,
    pub(super) times: &'a Times,
    /// What the others are held against or compared with.
    pub(super) bold: bool,
}

/// A drawing of these distributions.
pub(super) fn percentiles(lines: &[Line]) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-size=\"12\" \
         font-family=\"sans-serif\">\n"
    );
    let filled = || {
        lines
            .iter()
            .map(|line| line.times)
            .filter(|times| times.count() > 0)
    };
    let longest = filled().filter_map(|times| times.quantile_us(1.0));
    let shortest = filled().filter_map(|times| times.quantile_us(0.0));
    let (low, high) = (
        shortest.fold(f64::MAX, f64::min),
        longest.fold(0.0, f64::max),
    );
    let most = filled().map(Times::count).max().unwrap_or(0);
    if most == 0 || high <= 0.0 {
        return svg + "<text x=\"80\" y=\"40\">nothing was measured</text>\n</svg>\n";
    }
    let axes = Axes {
        nines: (most as f64).log10().ceil().max(1.0),
        low: low.max(0.01).log10().floor(),
        high: high.log10().ceil(),
    };
    axes.draw(&mut svg);
    for (index, line) in lines.iter().enumerate() {
        let color = COLORS[index % COLORS.len()];
        let dash = if index < COLORS.len() {
            ""
        } else {
            " stroke-dasharray=\"5 3\""
        };
        let _ = writeln!(
            svg,
            "<polyline fill=\"none\" stroke=\"{color}\" stroke-width=\"{}\"{dash} points=\"{}\"/>",
            if line.bold { 2.6 } else { 1.3 },
            axes.line(line.times)
        );
        let y = TOP + 14.0 * (index as f64 + 0.5);
        let _ = writeln!(
            svg,
            "<line x1=\"{}\" x2=\"{}\" y1=\"{y}\" y2=\"{y}\" stroke=\"{color}\" stroke-width=\"3\"{dash}/>\
             <text x=\"{}\" y=\"{}\" font-size=\"11\">{}</text>",
            RIGHT + 14.0,
            RIGHT + 34.0,
            RIGHT + 40.0,
            y + 4.0,
            escaped(line.name)
        );
    }
    svg + "</svg>\n"
}

/// Decades of both axes.
struct Axes {
    /// 1/(1 − q) goes from 1 to ten to this.
    nines: f64,
    /// Times go from ten to the one to ten to the other, in µs.
    low: f64,
    high: f64,
}

impl Axes {
    fn x(&self, decades: f64) -> f64 {
        LEFT + (RIGHT - LEFT) * decades / self.nines
    }

    fn y(&self, us: f64) -> f64 {
        let share = (us.max(1e-3).log10() - self.low) / (self.high - self.low).max(1.0);
        BOTTOM - (BOTTOM - TOP) * share.clamp(0.0, 1.0)
    }

    fn line(&self, times: &Times) -> String {
        let last = (times.count().max(1) as f64).log10();
        let steps = (last * f64::from(STEPS)).ceil() as u32;
        let mut points = String::new();
        for step in 0..=steps {
            let decades = (f64::from(step) / f64::from(STEPS)).min(last);
            let quantile = if step == steps {
                1.0
            } else {
                1.0 - 10f64.powf(-decades)
            };
            if let Some(us) = times.quantile_us(quantile) {
                let _ = write!(points, "{:.1},{:.1} ", self.x(decades), self.y(us));
            }
        }
        points.trim_end().to_owned()
    }

    fn draw(&self, svg: &mut String) {
        for decade in self.low as i32..=self.high as i32 {
            let us = 10f64.powi(decade);
            let y = self.y(us);
            let _ = writeln!(
                svg,
                "<line x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{y:.1}\" y2=\"{y:.1}\" stroke=\"#ddd\"/>\
                 <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{us} µs</text>",
                LEFT - 6.0,
                y + 4.0
            );
        }
        for decade in 0..=self.nines as i32 {
            let x = self.x(f64::from(decade));
            let label = match decade {
                0 => "0 %".to_owned(),
                1 => "90 %".to_owned(),
                2 => "99 %".to_owned(),
                more => format!("99.{} %", "9".repeat(more as usize - 2)),
            };
            let _ = writeln!(
                svg,
                "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{TOP}\" y2=\"{BOTTOM}\" stroke=\"#ddd\"/>\
                 <text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
                BOTTOM + 18.0
            );
        }
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">percentile, each step another nine: 1/(1 − q) = 1, 10, 100, …</text>",
            f64::midpoint(LEFT, RIGHT),
            BOTTOM + 40.0
        );
    }
}

/// Text as it may stand in HTML and SVG.
pub(super) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            c => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_rises_to_its_longest_and_stays_inside() {
        let mut times = Times::default();
        (1..=2000).for_each(|us| times.add(us * 1000));
        let svg = percentiles(&[Line {
            name: "a < b",
            times: &times,
            bold: true,
        }]);
        assert!(svg.contains("a &lt; b"), "{svg}");
        assert!(svg.contains("99.9 %"), "{svg}");
        let points = svg
            .split("points=\"")
            .nth(1)
            .and_then(|rest| rest.split('"').next());
        let points: Vec<(f64, f64)> = points
            .expect("a line")
            .split(' ')
            .map(|point| point.split_once(',').expect("x,y"))
            .map(|(x, y)| (x.parse().expect("x"), y.parse().expect("y")))
            .collect();
        assert!(points.len() > 50);
        assert!(
            points
                .windows(2)
                .all(|pair| pair[0].0 < pair[1].0 && pair[0].1 >= pair[1].1)
        );
        assert!(
            points
                .iter()
                .all(|&(x, y)| (LEFT..=RIGHT).contains(&x) && (TOP..=BOTTOM).contains(&y))
        );
    }

    #[test]
    fn nothing_measured_is_said() {
        assert!(percentiles(&[]).contains("nothing was measured"));
        let empty = Line {
            name: "x",
            times: &Times::default(),
            bold: false,
        };
        assert!(percentiles(&[empty]).contains("nothing was measured"));
    }
}
