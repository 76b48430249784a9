//! The legend: above the chart, in as many rows as needed, so that it hides nothing.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::marks::{LineStyle, Mark, Marker, Stroke, marker, stroke};
use super::{Area, Chart, Drawn, FINE, INK, LETTER_PX, letters};

const ROW_PX: i32 = 19;
/// Width of a line's sample, and the gap between it and the name, px of the page.
const SAMPLE_PX: i32 = 30;
const GAP_PX: i32 = 6;
/// Gap between two entries, px of the page.
const APART_PX: i32 = 18;

struct Entry<'a> {
    name: &'a str,
    look: LineStyle,
    /// Opacity of a band; `None` for other marks.
    opacity: Option<f64>,
}

fn entries(chart: &Chart) -> Vec<Entry<'_>> {
    let entry = |mark| match mark {
        &Mark::Line { ref name, look, .. } | &Mark::Key { ref name, look } => Some(Entry {
            name,
            look,
            opacity: None,
        }),
        &Mark::Band {
            ref name,
            color,
            opacity,
            ..
        } => Some(Entry {
            name,
            look: LineStyle {
                color,
                stroke: Stroke::Solid,
                marker: Marker::None,
            },
            opacity: Some(opacity),
        }),
        _ => None,
    };
    let named = chart.marks.iter().filter_map(entry);
    named.filter(|entry| !entry.name.is_empty()).collect()
}

/// Returns the left side and the row of each entry.
fn places(entries: &[Entry], room_px: i32) -> Vec<[i32; 2]> {
    let (mut x, mut row) = (0, 0);
    entries
        .iter()
        .map(|entry| {
            let width = SAMPLE_PX + GAP_PX + text_px(entry.name);
            if x > 0 && x + width > room_px {
                (x, row) = (0, row + 1);
            }
            let place = [x, row];
            x += width + APART_PX;
            place
        })
        .collect()
}

/// Estimates the width of a text in a sans-serif font.
fn text_px(text: &str) -> i32 {
    (0.53 * f64::from(LETTER_PX) * text.chars().count() as f64).ceil() as i32
}

pub(super) fn height_px(chart: &Chart, width_px: i32) -> i32 {
    let places = places(&entries(chart), width_px - chart.left_px);
    places.last().map_or(0, |[_, row]| (row + 1) * ROW_PX + 2)
}

/// Draws the legend with its top left corner at the given pixels of the drawing. `room_px` is the
/// available width.
pub(super) fn draw(root: &Area, chart: &Chart, [left, top]: [i32; 2], room_px: i32) -> Drawn {
    let entries = entries(chart);
    for (entry, [x, row]) in entries.iter().zip(places(&entries, room_px)) {
        let x = left + x * FINE;
        let y = top + (row * ROW_PX + ROW_PX / 2) * FINE;
        let end = x + SAMPLE_PX * FINE;
        if let Some(opacity) = entry.opacity {
            let fill = entry.look.rgb().mix(opacity).filled();
            let corners = [(x, y - 5 * FINE), (end, y + 5 * FINE)];
            root.draw(&Rectangle::new(corners, fill))?;
        } else {
            stroke(root, &[(x, y), (end, y)], entry.look)?;
            marker(root, ((x + end) / 2, y), entry.look, 4)?;
        }
        let style = letters(INK, false).pos(Pos::new(HPos::Left, VPos::Center));
        let at = (end + GAP_PX * FINE, y);
        root.draw(&Text::new(entry.name.to_owned(), at, style))?;
    }
    Ok(())
}
