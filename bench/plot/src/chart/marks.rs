//! The marks between the axes: lines, bands, spreads, notes.

use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{Area, Chart, Drawn, FINE, Place, SOFT, letters};
use crate::spread::Spread;

/// Okabe and Ito's colors without yellow, which is too pale for lines on white.
const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// Opacity of a line that is one among many. Overlapping lines are darker.
const THIN_OPACITY: f64 = 0.35;

/// Dash pattern of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// Solid.
    Solid,
    /// Dashes of 7 px of the page.
    Dashed,
    /// Dots of 2 px of the page.
    Dotted,
    /// Dashes of 14 px of the page.
    LongDashed,
}

/// Marker at a line's points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// No marker.
    None,
    /// A ring.
    Circle,
    /// A square.
    Square,
    /// A triangle, its tip up.
    Triangle,
    /// A square on its corner.
    Diamond,
    /// Two crossed strokes.
    Cross,
}

/// Appearance of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineStyle {
    /// Index of a color in the palette.
    pub color: usize,
    /// Dash pattern.
    pub stroke: Stroke,
    /// Marker at the line's points.
    pub marker: Marker,
}

impl LineStyle {
    /// Returns the look of a chart's `n`-th line: neighboring lines differ in color, dash and
    /// marker.
    pub fn nth(n: usize) -> Self {
        const STROKES: [Stroke; 4] = [
            Stroke::Solid,
            Stroke::Dashed,
            Stroke::Dotted,
            Stroke::LongDashed,
        ];
        const MARKERS: [Marker; 5] = [
            Marker::Circle,
            Marker::Square,
            Marker::Triangle,
            Marker::Diamond,
            Marker::Cross,
        ];
        Self {
            color: n % COLORS.len(),
            stroke: STROKES[n % STROKES.len()],
            marker: MARKERS[n % MARKERS.len()],
        }
    }

    /// Returns the same look with another dash pattern.
    pub fn stroke(self, stroke: Stroke) -> Self {
        Self { stroke, ..self }
    }

    /// Returns the same look with another marker.
    pub fn marker(self, marker: Marker) -> Self {
        Self { marker, ..self }
    }

    pub(super) fn rgb(self) -> RGBColor {
        COLORS[self.color % COLORS.len()]
    }
}

/// A mark in a chart.
#[derive(Debug, Clone)]
pub enum Mark {
    /// A line through points. It is broken at points that are not finite or are beyond the axes.
    Line {
        /// Name in the legend. Empty: not in the legend.
        name: String,
        /// Appearance of the line.
        look: LineStyle,
        /// x and y, in units of the axes.
        points: Vec<[f64; 2]>,
    },
    /// A thin, pale line, one among many, without markers or a legend entry. It is broken at points
    /// that are not finite or are beyond the axes.
    Thin {
        /// Index of a color in the palette.
        color: usize,
        /// x and y, in units of the axes.
        points: Vec<[f64; 2]>,
    },
    /// The area between two lines.
    Band {
        /// Name in the legend. Empty: not in the legend.
        name: String,
        /// Index of a color in the palette.
        color: usize,
        /// Opacity, 0 to 1.
        opacity: f64,
        /// x, lower end and upper end, in units of the axes.
        edges: Vec<[f64; 3]>,
    },
    /// A spread of numbers along x, at the height of the `row`-th name, shifted by a share of a
    /// row.
    Spread {
        /// Index of a name on the vertical axis.
        row: usize,
        /// Downward shift, in rows.
        shift: f64,
        /// Color and marker.
        look: LineStyle,
        /// Median, quartiles, and the range of nine tenths of the numbers.
        spread: Spread,
    },
    /// A vertical line at an x, with a text at its top.
    Rule {
        /// Position on the x axis.
        x: f64,
        /// Text at the line. May be empty.
        text: String,
    },
    /// A horizontal line at a y, with a text above its right end.
    Level {
        /// Position on the y axis.
        y: f64,
        /// Text at the line. May be empty.
        text: String,
    },
    /// A legend entry for unnamed marks.
    Key {
        /// Name in the legend.
        name: String,
        /// Appearance of the marks.
        look: LineStyle,
    },
}

pub(super) fn draw(root: &Area, mark: &Mark, at: Place, chart: &Chart) -> Drawn {
    match mark {
        Mark::Line { look, points, .. } => {
            let fits = |p: &[f64; 2]| chart.x.holds(p[0]) && chart.y.holds(p[1]);
            for run in points.split(|p| !fits(p)) {
                let pixels: Vec<_> = run.iter().map(|&p| at(p)).collect();
                stroke(root, &pixels, *look)?;
            }
            let seen = points.iter().filter(|p| fits(p));
            seen.map(|&p| at(p))
                .try_for_each(|p| marker(root, p, *look, 4))
        }
        Mark::Thin { color, points } => {
            let fits = |p: &[f64; 2]| chart.x.holds(p[0]) && chart.y.holds(p[1]);
            let style = COLORS[color % COLORS.len()].mix(THIN_OPACITY);
            for run in points.split(|p| !fits(p)) {
                let pixels: Vec<_> = run.iter().map(|&p| at(p)).collect();
                root.draw(&PathElement::new(pixels, style.stroke_width(FINE as u32)))?;
            }
            Ok(())
        }
        Mark::Band {
            color,
            opacity,
            edges,
            ..
        } => {
            let known = || {
                edges
                    .iter()
                    .filter(|e| e[1].is_finite() && e[2].is_finite())
            };
            let lower = known().map(|&[x, low, _]| at([x, low]));
            let upper = known().rev().map(|&[x, _, high]| at([x, high]));
            let outline: Vec<_> = lower.chain(upper).collect();
            let fill = COLORS[color % COLORS.len()].mix(*opacity).filled();
            root.draw(&Polygon::new(outline, fill))
        }
        Mark::Spread {
            row,
            shift,
            look,
            spread,
        } => {
            let y = *row as f64 + shift;
            let ends = |low: f64, high: f64| [at([low, y]), at([high, y])];
            if spread.count == 0 {
                return Ok(());
            }
            let thin = look.rgb().stroke_width(FINE as u32 * 3 / 2);
            let thick = look.rgb().stroke_width(FINE as u32 * 4);
            root.draw(&PathElement::new(ends(spread.p5, spread.p95), thin))?;
            root.draw(&PathElement::new(ends(spread.p25, spread.p75), thick))?;
            marker(root, at([spread.median, y]), *look, 5)
        }
        Mark::Rule { x, text } => rule(root, *x, text, at, chart),
        Mark::Level { y, text } => level(root, *y, text, at, chart),
        Mark::Key { .. } => Ok(()),
    }
}

/// Draws a vertical dashed line with a text at its top.
fn rule(root: &Area, x: f64, text: &str, at: Place, chart: &Chart) -> Drawn {
    let (top, bottom) = (at([x, chart.y.last()]), at([x, chart.y.first()]));
    let style = SOFT.stroke_width(FINE as u32);
    let (dash, gap) = (4 * FINE, 3 * FINE);
    root.draw(&DashedPathElement::new([top, bottom], dash, gap, style))?;
    // Put the text on the side that has room for it.
    let is_right = top.0 > at([chart.x.last(), chart.y.last()]).0 - 60 * FINE;
    let (side, dx) = if is_right {
        (HPos::Right, -4 * FINE)
    } else {
        (HPos::Left, 4 * FINE)
    };
    let style = letters(SOFT, false).pos(Pos::new(side, VPos::Top));
    let place = (top.0 + dx, top.1 + 3 * FINE);
    root.draw(&Text::new(text.to_owned(), place, style))
}

/// Draws a horizontal dashed line with a text above its right end.
fn level(root: &Area, y: f64, text: &str, at: Place, chart: &Chart) -> Drawn {
    let (left, right) = (at([chart.x.first(), y]), at([chart.x.last(), y]));
    let style = SOFT.stroke_width(FINE as u32);
    let (dash, gap) = (4 * FINE, 3 * FINE);
    root.draw(&DashedPathElement::new([left, right], dash, gap, style))?;
    let style = letters(SOFT, false).pos(Pos::new(HPos::Right, VPos::Bottom));
    let place = (right.0 - 4 * FINE, right.1 - 2 * FINE);
    root.draw(&Text::new(text.to_owned(), place, style))
}

/// Draws a line through pixels.
pub(super) fn stroke(root: &Area, pixels: &[(i32, i32)], look: LineStyle) -> Drawn {
    if pixels.len() < 2 {
        return Ok(());
    }
    let style = look.rgb().stroke_width(FINE as u32 * 2);
    let [dash, gap] = match look.stroke {
        Stroke::Solid => return root.draw(&PathElement::new(pixels.to_vec(), style)),
        Stroke::Dashed => [7, 4],
        Stroke::Dotted => [2, 4],
        Stroke::LongDashed => [14, 4],
    };
    root.draw(&DashedPathElement::new(
        pixels.to_vec(),
        dash * FINE,
        gap * FINE,
        style,
    ))
}

/// Draws a marker around a pixel. Its light inside distinguishes it from a bend of the line.
pub(super) fn marker(root: &Area, (x, y): (i32, i32), look: LineStyle, radius_px: i32) -> Drawn {
    let r = radius_px * FINE;
    let line = look.rgb().stroke_width(FINE as u32 * 2);
    let corners: Vec<(i32, i32)> = match look.marker {
        Marker::None => return Ok(()),
        Marker::Circle => {
            root.draw(&Circle::new((x, y), r, WHITE.filled()))?;
            return root.draw(&Circle::new((x, y), r, line));
        }
        Marker::Cross => {
            let d = r * 3 / 4;
            root.draw(&PathElement::new([(x - d, y - d), (x + d, y + d)], line))?;
            return root.draw(&PathElement::new([(x - d, y + d), (x + d, y - d)], line));
        }
        Marker::Square => {
            let d = r * 7 / 8;
            vec![
                (x - d, y - d),
                (x + d, y - d),
                (x + d, y + d),
                (x - d, y + d),
            ]
        }
        Marker::Triangle => vec![(x, y - r), (x + r, y + r * 3 / 4), (x - r, y + r * 3 / 4)],
        Marker::Diamond => vec![(x, y - r), (x + r, y), (x, y + r), (x - r, y)],
    };
    root.draw(&Polygon::new(corners.clone(), WHITE.filled()))?;
    let closed: Vec<_> = corners.iter().chain(corners.first()).copied().collect();
    root.draw(&PathElement::new(closed, line))
}
