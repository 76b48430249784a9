//! Curves and points drawn over pictures, panel beside panel.

use std::fmt::Write;

use crate::report::escaped;
use crate::{PaperError, Picture};

/// Lines and dots are of these sizes in a panel that is this wide.
const PANEL_UNITS: f64 = 360.0;
/// Between panels, and room above each for its title.
const APART: f64 = 14.0;
const TITLE: f64 = 22.0;

/// A shape over the picture, in the picture's pixels.
#[derive(Debug, Clone)]
pub(crate) struct Stroke {
    pub(crate) points: Vec<[f64; 2]>,
    /// As CSS has it.
    pub(crate) color: &'static str,
    /// In units of a panel, of which it is 360 wide.
    pub(crate) width: f64,
    /// As SVG has it; empty for a line without gaps.
    pub(crate) dashes: &'static str,
    /// Whether it is drawn as dots of that width.
    pub(crate) dots: bool,
}

/// One picture with shapes over it.
#[derive(Debug, Clone)]
pub(crate) struct Panel {
    pub(crate) title: String,
    /// Which of the pictures.
    pub(crate) picture: usize,
    pub(crate) strokes: Vec<Stroke>,
}

/// Panels in rows of `columns`. Beyond the picture's edge shapes are shown as far as `beyond` (a share of its sides).
pub(crate) fn draw(
    label: &str,
    pictures: &[&Picture],
    panels: &[Panel],
    columns: usize,
    beyond: f64,
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
    // All panels of a row are as high as its highest.
    let heights: Vec<f64> = panels
        .chunks(columns)
        .map(|row| {
            let tallest = row.iter().map(|panel| {
                let picture = pictures[panel.picture];
                picture.height as f64 / picture.width as f64
            });
            PANEL_UNITS * tallest.fold(0.0, f64::max)
        })
        .collect();
    let columns_used = columns.min(panels.len());
    let width = columns_used as f64 * (PANEL_UNITS + APART) - APART;
    let height: f64 = heights.iter().map(|height| height + TITLE + APART).sum();
    let mut svg = format!(
        "<svg viewBox=\"0 0 {width:.0} {height:.0}\" xmlns=\"http://www.w3.org/2000/svg\" \
         font-family=\"sans-serif\" font-size=\"13\"><defs>{defined}</defs>"
    );
    let mut top = 0.0;
    for (row, height) in panels.chunks(columns).zip(&heights) {
        for (i, panel) in row.iter().enumerate() {
            let left = i as f64 * (PANEL_UNITS + APART);
            let picture = pictures[panel.picture];
            let _ = write!(
                svg,
                "<text x=\"{left:.0}\" y=\"{:.0}\" font-weight=\"bold\" fill=\"#222\">{}</text>",
                top + 15.0,
                escaped(&panel.title)
            );
            draw_panel(&mut svg, label, panel, picture, [left, top + TITLE], beyond);
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
    [left, top]: [f64; 2],
    beyond: f64,
) {
    let (width, height) = (picture.width as f64, picture.height as f64);
    let margin = [beyond * width, beyond * height];
    let _ = write!(
        svg,
        "<svg x=\"{left:.1}\" y=\"{top:.1}\" width=\"{PANEL_UNITS}\" height=\"{:.1}\" \
         viewBox=\"{:.1} {:.1} {:.1} {:.1}\"><use href=\"#{label}-{}\"/>",
        PANEL_UNITS * height / width,
        -0.5 - margin[0],
        -0.5 - margin[1],
        width + 2.0 * margin[0],
        height + 2.0 * margin[1],
        panel.picture
    );
    let _ = write!(
        svg,
        "<rect x=\"-0.5\" y=\"-0.5\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"#bbb\" \
         stroke-width=\"{:.2}\"/>",
        width / PANEL_UNITS
    );
    let unit = (width + 2.0 * margin[0]) / PANEL_UNITS;
    for stroke in &panel.strokes {
        if stroke.dots {
            dots(svg, stroke, unit);
        } else {
            line(svg, stroke, unit);
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

fn dots(svg: &mut String, stroke: &Stroke, unit: f64) {
    let _ = write!(
        svg,
        "<g fill=\"#fff\" stroke=\"{}\" stroke-width=\"{:.2}\">",
        stroke.color,
        1.2 * unit
    );
    for [x, y] in &stroke.points {
        let r = 0.5 * unit * stroke.width;
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
            dots: false,
        };
        let panel = |title: &str| Panel {
            title: title.to_owned(),
            picture: 0,
            strokes: vec![
                stroke.clone(),
                Stroke {
                    dots: true,
                    ..stroke.clone()
                },
            ],
        };
        let panels = [panel("a < b"), panel("c"), panel("d")];
        let svg = draw("test", &[&picture], &panels, 2, 0.1).unwrap();
        assert_eq!(svg.matches("data:image/png").count(), 1);
        assert_eq!(svg.matches("<use").count(), 3);
        assert!(svg.contains("a &lt; b"));
        crate::report::check_tags(&svg).unwrap();
    }
}
