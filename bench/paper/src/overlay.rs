//! Curves and points drawn over pictures, in panels side by side.

use std::fmt::Write;

use lariat_plot::escaped;

use crate::{PaperError, Picture};

/// Width of a whole figure, in its own units.
const WIDTH: f64 = 734.0;
/// Gap between panels, and height for the title above each.
const APART: f64 = 14.0;
const TITLE: f64 = 22.0;

/// A shape over the picture, in the picture's pixels.
#[derive(Debug, Clone)]
pub(crate) struct Stroke {
    pub(crate) points: Vec<[f64; 2]>,
    /// CSS color.
    pub(crate) color: &'static str,
    /// Stroke width in units of the figure, which is 734 wide.
    pub(crate) width: f64,
    /// SVG dash pattern. Empty for a solid line.
    pub(crate) dashes: &'static str,
    pub(crate) drawn: Drawn,
}

/// The way a shape is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Drawn {
    Line,
    /// Dots at the shape's points, as wide as the stroke.
    Dots,
    /// Rings: dots with a white inside.
    Rings,
}

/// The part of a picture that panels show, in the picture's pixels: left, top, width, height.
pub(crate) type View = [f64; 4];

/// Returns a view of the whole picture with a margin around it. Along each axis, the margin is
/// `beyond` times the picture's side.
pub(crate) fn around(picture: &Picture, beyond: f64) -> View {
    let sides = [picture.width as f64, picture.height as f64];
    let [left, top] = sides.map(|side| -0.5 - beyond * side);
    let [width, height] = sides.map(|side| side * (1.0 + 2.0 * beyond));
    [left, top, width, height]
}

/// Returns a view with the picture's aspect ratio, no larger than the picture, that contains all
/// points and `margin_px` around them.
pub(crate) fn close_up<'a>(
    picture: &Picture,
    points: impl Iterator<Item = &'a [f64; 2]>,
    margin_px: f64,
) -> View {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for p in points {
        low = [0, 1].map(|k| low[k].min(p[k] - margin_px));
        high = [0, 1].map(|k| high[k].max(p[k] + margin_px));
    }
    let sides = [picture.width as f64, picture.height as f64];
    let share = |k: usize| (high[k] - low[k]) / sides[k];
    let share = share(0).max(share(1));
    if !(0.0..1.0).contains(&share) {
        return around(picture, 0.0);
    }
    let size = sides.map(|side| share * side);
    let from = [0, 1].map(|k| {
        let centred = 0.5 * (low[k] + high[k] - size[k]);
        centred.clamp(-0.5, sides[k] - 0.5 - size[k])
    });
    [from[0], from[1], size[0], size[1]]
}

/// A picture with shapes over it.
#[derive(Debug, Clone)]
pub(crate) struct Panel {
    pub(crate) title: String,
    /// Index of the picture.
    pub(crate) picture: usize,
    pub(crate) strokes: Vec<Stroke>,
}

/// Draws panels in rows of `columns`. All show the same part of their picture.
pub(crate) fn draw(
    label: &str,
    pictures: &[&Picture],
    panels: &[Panel],
    columns: usize,
    view: View,
) -> Result<String, PaperError> {
    let mut defined = String::new();
    for (i, picture) in pictures.iter().enumerate() {
        let _ = write!(
            defined,
            "<image id=\"{label}-{i}\" width=\"{}\" height=\"{}\" x=\"-0.5\" y=\"-0.5\" \
             preserveAspectRatio=\"none\" href=\"{}\"/>",
            picture.width,
            picture.height,
            picture.data_uri()?
        );
    }
    let panel_width = (WIDTH + APART) / columns as f64 - APART;
    let [_, _, view_width, view_height] = view;
    let panel_height = panel_width * view_height / view_width;
    let heights: Vec<f64> = panels.chunks(columns).map(|_| panel_height).collect();
    let height: f64 = heights.iter().map(|height| height + TITLE + APART).sum();
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH:.0} {height:.0}\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"sans-serif\" font-size=\"13\"><defs>{defined}</defs>"
    );
    let mut top = 0.0;
    for (row, height) in panels.chunks(columns).zip(&heights) {
        for (i, panel) in row.iter().enumerate() {
            let left = i as f64 * (panel_width + APART);
            let picture = pictures[panel.picture];
            let _ = write!(
                svg,
                "<text x=\"{left:.0}\" y=\"{:.0}\" font-weight=\"bold\" fill=\"#222\">{}</text>",
                top + 15.0,
                escaped(&panel.title)
            );
            let place = [left, top + TITLE, panel_width, panel_height];
            draw_panel(&mut svg, label, panel, picture, place, view);
        }
        top += height + TITLE + APART;
    }
    svg.push_str("</svg>");
    Ok(svg)
}

fn draw_panel(
    svg: &mut String,
    label: &str,
    panel: &Panel,
    picture: &Picture,
    [left, top, panel_width, panel_height]: [f64; 4],
    [from_x, from_y, view_width, view_height]: View,
) {
    let (width, height) = (picture.width as f64, picture.height as f64);
    let _ = write!(
        svg,
        "<svg x=\"{left:.1}\" y=\"{top:.1}\" width=\"{panel_width:.1}\" height=\"{panel_height:.1}\" \
         viewBox=\"{from_x:.1} {from_y:.1} {view_width:.1} {view_height:.1}\"><use href=\"#{label}-{}\"/>",
        panel.picture
    );
    let _ = write!(
        svg,
        "<rect x=\"-0.5\" y=\"-0.5\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"#bbb\" \
         stroke-width=\"{:.2}\"/>",
        view_width / panel_width
    );
    let unit = view_width / panel_width;
    for stroke in &panel.strokes {
        match stroke.drawn {
            Drawn::Line => line(svg, stroke, unit),
            Drawn::Dots => dots(svg, stroke, unit, stroke.color),
            Drawn::Rings => dots(svg, stroke, unit, "#fff"),
        }
    }
    svg.push_str("</svg>");
}

fn line(svg: &mut String, stroke: &Stroke, unit: f64) {
    let mut points = String::new();
    for [x, y] in &stroke.points {
        let _ = write!(points, "{x:.1},{y:.1} ");
    }
    let Stroke {
        color,
        width,
        dashes,
        ..
    } = stroke;
    let gaps: Vec<String> = dashes
        .split_whitespace()
        .filter_map(|number| number.parse::<f64>().ok())
        .map(|number| format!("{:.1}", unit * number))
        .collect();
    let _ = write!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{:.2}\" \
         stroke-linejoin=\"round\" stroke-linecap=\"round\"",
        points.trim_end(),
        unit * width
    );
    if !gaps.is_empty() {
        let _ = write!(svg, " stroke-dasharray=\"{}\"", gaps.join(" "));
    }
    svg.push_str("/>");
}

fn dots(svg: &mut String, stroke: &Stroke, unit: f64, fill: &str) {
    let _ = write!(
        svg,
        "<g fill=\"{fill}\" stroke=\"{}\" stroke-width=\"{:.2}\">",
        stroke.color,
        0.2 * stroke.width * unit
    );
    for [x, y] in &stroke.points {
        let r = 0.4 * unit * stroke.width;
        let _ = write!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.2}\"/>");
    }
    svg.push_str("</g>");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_in_the_drawing_once_however_many_panels_show_it() {
        let picture = Picture {
            name: "grey".to_owned(),
            width: 40,
            height: 30,
            rgb: vec![200; 3600],
        };
        let stroke = Stroke {
            points: vec![[1.0, 2.0], [30.0, 20.0]],
            color: "#000",
            width: 2.0,
            dashes: "4 2",
            drawn: Drawn::Line,
        };
        let panel = |title: &str| Panel {
            title: title.to_owned(),
            picture: 0,
            strokes: vec![
                stroke.clone(),
                Stroke {
                    drawn: Drawn::Rings,
                    ..stroke.clone()
                },
            ],
        };
        let panels = [panel("a < b"), panel("c"), panel("d")];
        let svg = draw("test", &[&picture], &panels, 2, around(&picture, 0.1)).unwrap();
        assert_eq!(svg.matches("data:image/png").count(), 1);
        assert_eq!(svg.matches("<use").count(), 3);
        assert!(svg.contains("a &lt; b"));
        lariat_plot::check_tags(&svg).unwrap();
    }

    #[test]
    fn a_close_up_has_the_picture_s_shape_and_stays_within_it() {
        let picture = Picture {
            name: String::new(),
            width: 400,
            height: 300,
            rgb: Vec::new(),
        };
        let points = [[10.0, 20.0], [90.0, 30.0]];
        let [x, y, width, height] = close_up(&picture, points.iter(), 20.0);
        assert!((width - 120.0).abs() < 1e-9 && (height - 90.0).abs() < 1e-9);
        assert!((x + 0.5).abs() < 20.0 && x >= -0.5 && y >= -0.5);
        let [x, .., height] = close_up(&picture, [[0.0, 0.0], [399.0, 299.0]].iter(), 9.0);
        assert_eq!([x, height], [-0.5, 300.0]);
    }
}
