//! The common style of all charts, drawn by one routine.
//!
//! Colors are those of Okabe and Ito (*Color Universal Design*, 2008), which people with color
//! vision deficiency can tell apart. Lines also differ in dash and marker, for print in gray. The
//! plotting library rounds positions to whole pixels, so charts are drawn [`FINE`] times larger
//! than intended and scaled down when displayed.

mod axis;
mod legend;
mod marks;

pub use axis::Axis;
pub use marks::{LineStyle, Mark, Marker, Stroke};

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use thiserror::Error;

/// Pixels of the drawing per pixel of the page.
const FINE: i32 = 4;
/// Width of a figure, px of the page.
const WIDTH_PX: i32 = 760;
/// Font size, px of the page.
const LETTER_PX: i32 = 13;
/// The plotting library divides font sizes by this factor.
const LIBRARY_SCALE: f64 = 1.24;
/// Height of a chart's title, px of the page.
const TITLE_PX: i32 = 22;
/// Height below a chart for ticks and label, px of the page.
const BELOW_PX: i32 = 42;
const MARGIN_PX: i32 = 10;

/// Maps values of the axes to pixels of the drawing.
type Place<'a> = &'a dyn Fn([f64; 2]) -> (i32, i32);
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

const INK: RGBColor = RGBColor(34, 34, 34);
const SOFT: RGBColor = RGBColor(90, 90, 90);
const GRID: RGBColor = RGBColor(221, 221, 221);
const FAINT: RGBColor = RGBColor(240, 240, 240);

/// A drawing failed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the figure '{figure}' cannot be drawn: {why}")]
pub struct PlotError {
    /// Name of the figure.
    pub figure: &'static str,
    /// Error message of the plotting library.
    pub why: String,
}

/// A chart: two axes and the marks between them.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Title of the chart, for figures with several charts.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Marks, drawn in this order: later ones cover earlier ones.
    pub marks: Vec<Mark>,
    /// Height without title and legend, px of the page.
    pub height_px: i32,
    /// Width of the space for labels on the left, px of the page.
    pub left_px: i32,
}

impl Chart {
    /// Creates an empty chart without a title.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            title: String::new(),
            x,
            y,
            marks: Vec::new(),
            height_px: 262,
            left_px: 62,
        }
    }

    /// Sets the title.
    pub fn titled(mut self, title: &str) -> Self {
        title.clone_into(&mut self.title);
        self
    }

    /// Adds a line that is named in the legend.
    pub fn line(&mut self, name: &str, look: LineStyle, points: Vec<[f64; 2]>) {
        let name = name.to_owned();
        self.marks.push(Mark::Line { name, look, points });
    }
}

/// Draws charts side by side, `columns` in a row, as one SVG without a fixed size. `figure` is the
/// name of the drawing in errors.
///
/// # Errors
/// Fails if the plotting library does.
pub fn draw(figure: &'static str, charts: &[Chart], columns: i32) -> Result<String, PlotError> {
    let width = WIDTH_PX * FINE;
    let each = width / columns;
    // The axes of one row's charts are aligned, so the tallest legend determines the height.
    let heads: Vec<i32> = charts
        .iter()
        .map(|chart| legend::height_px(chart, each / FINE) + title_px(chart))
        .collect();
    let rows: Vec<(i32, i32)> = charts
        .chunks(columns as usize)
        .zip(heads.chunks(columns as usize))
        .map(|(row, heads)| {
            let head = heads.iter().copied().max().unwrap_or(0);
            let body = row.iter().map(|chart| chart.height_px).max().unwrap_or(0);
            (head * FINE, body * FINE)
        })
        .collect();
    let height: i32 = rows.iter().map(|(head, body)| head + body).sum();
    let mut svg = String::new();
    let drawn = {
        let root = SVGBackend::with_string(&mut svg, (width as u32, height as u32));
        let root = root.into_drawing_area();
        let mut top = 0;
        let mut all = Ok(());
        for (row, &(head, body)) in charts.chunks(columns as usize).zip(&rows) {
            for (i, chart) in row.iter().enumerate() {
                let left = each * i as i32;
                let place = Spot {
                    left,
                    top,
                    width: each,
                    head,
                    body,
                };
                all = all.and_then(|()| draw_one(&root, chart, place));
            }
            top += head + body;
        }
        all.and_then(|()| root.present().map_err(|e| e.to_string()))
    };
    drawn.map_err(|why| PlotError { figure, why })?;
    Ok(without_size(&svg))
}

/// Position of a chart, in pixels of the drawing.
#[derive(Clone, Copy)]
struct Spot {
    left: i32,
    top: i32,
    width: i32,
    head: i32,
    body: i32,
}

fn title_px(chart: &Chart) -> i32 {
    if chart.title.is_empty() { 0 } else { TITLE_PX }
}

fn draw_one(root: &Area, chart: &Chart, place: Spot) -> Result<(), String> {
    let said = |e: DrawingAreaErrorKind<_>| e.to_string();
    let Spot {
        left,
        top,
        width,
        head,
        body,
    } = place;
    let inner_left = left + chart.left_px * FINE;
    if !chart.title.is_empty() {
        let style = letters(INK, true).pos(Pos::new(HPos::Left, VPos::Top));
        root.draw(&Text::new(
            chart.title.clone(),
            (inner_left, top + 2 * FINE),
            style,
        ))
        .map_err(said)?;
    }
    legend::draw(
        root,
        chart,
        [inner_left, top + title_px(chart) * FINE],
        (width / FINE) - chart.left_px,
    )
    .map_err(said)?;

    let area = root.clone().shrink((left, top + head), (width, body));
    let mut builder = ChartBuilder::on(&area);
    builder
        .margin_top(MARGIN_PX * FINE)
        .margin_right((MARGIN_PX + 6) * FINE)
        .x_label_area_size(BELOW_PX * FINE)
        .y_label_area_size(chart.left_px * FINE);
    let (x, y) = (&chart.x, &chart.y);
    let mut context = builder
        .build_cartesian_2d(x.ruler(), y.ruler())
        .map_err(said)?;
    // The library's own plotting area, used to map coordinates.
    let plot = context.plotting_area().clone();
    let at = |p: [f64; 2]| plot.map_coordinate(&(x.place(p[0]), y.place(p[1])));
    draw_minor(root, chart, &at).map_err(said)?;
    context
        .configure_mesh()
        .axis_style(SOFT.stroke_width(FINE as u32))
        .bold_line_style(GRID.stroke_width(FINE as u32))
        .light_line_style(TRANSPARENT)
        .set_all_tick_mark_size(3 * FINE)
        .label_style(letters(INK, false))
        .axis_desc_style(letters(INK, false))
        .x_desc(x.label())
        .y_desc(y.label())
        .x_label_formatter(&|place| x.text(*place))
        .y_label_formatter(&|place| y.text(*place))
        .draw()
        .map_err(said)?;
    for mark in &chart.marks {
        marks::draw(root, mark, &at, chart).map_err(said)?;
    }
    Ok(())
}

/// Draws faint lines between the ticks of logarithmic axes.
fn draw_minor(root: &Area, chart: &Chart, at: Place) -> Drawn {
    let (x, y) = (&chart.x, &chart.y);
    let upright = x
        .minor()
        .into_iter()
        .map(|m| [[m, y.first()], [m, y.last()]]);
    let level = y
        .minor()
        .into_iter()
        .map(|m| [[x.first(), m], [x.last(), m]]);
    for ends in upright.chain(level) {
        let style = FAINT.stroke_width(FINE as u32);
        root.draw(&PathElement::new(ends.map(at), style))?;
    }
    Ok(())
}

fn letters(color: RGBColor, bold: bool) -> TextStyle<'static> {
    let size = f64::from(LETTER_PX * FINE) * LIBRARY_SCALE;
    let style = if bold {
        FontStyle::Bold
    } else {
        FontStyle::Normal
    };
    FontDesc::new(FontFamily::SansSerif, size, style).color(&color)
}

/// Removes the size from an SVG. With a `viewBox` alone, it fills the width that the page gives it.
fn without_size(svg: &str) -> String {
    let Some((head, rest)) = svg.split_once("viewBox") else {
        return svg.to_owned();
    };
    let tag = head.split_once("width").map_or(head, |(tag, _)| tag);
    format!("{tag}viewBox{rest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_is_one_svg_that_takes_the_room_it_is_given() {
        let mut chart = Chart::new(
            Axis::linear("order < n", [0.0, 10.0], 2.0),
            Axis::log("error & px", [0.01, 100.0]),
        );
        let points = (1..10).map(|i| [f64::from(i), 10.0 / f64::from(i)]);
        chart.line("Bezier", LineStyle::nth(0), points.clone().collect());
        chart.marks.push(Mark::Thin {
            color: 1,
            points: points.collect(),
        });
        let text = "a level".to_owned();
        chart.marks.push(Mark::Level { y: 5.0, text });
        let svg = draw("a test", &[chart.clone(), chart.titled("another")], 2).unwrap();
        assert!(svg.starts_with("<svg viewBox="), "{}", &svg[..60]);
        assert_eq!(svg.matches("<svg").count(), 1);
        assert!(svg.contains("order &lt; n") && svg.contains("error &amp; px"));
        assert!(svg.contains("another") && svg.contains("a level"));
        crate::check_tags(&svg).unwrap();
    }
}
