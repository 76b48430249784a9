//! Draws a [`View`]. The code is pure, so a test can draw without a terminal.

mod latency;
mod ropes;
mod stages;

use lariat_sink::Figure;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use lariat_view::View;

/// Number of rows of the tables: a heading, six steps, and the bar.
const TABLES: u16 = 8;
/// Number of columns of the table of stages. The latencies get the rest, less a gap: 46 of the
/// usual 80.
const STAGES: u16 = 32;

const DIM: Style = Style::new().fg(Color::DarkGray);
const BOLD: Style = Style::new().add_modifier(Modifier::BOLD);
const GOOD: Style = Style::new().fg(Color::Green);
const DOUBTFUL: Style = Style::new().fg(Color::Yellow);
const BAD: Style = Style::new().fg(Color::Red);

/// Draws the whole screen.
pub(super) fn draw(frame: &mut Frame, view: &View) {
    let rows = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(TABLES),
        Constraint::Fill(1),
        Constraint::Length(1),
    ]);
    let [title, tables, ropes, keys] = rows.areas(frame.area());
    frame.render_widget(Paragraph::new(heading(view)), title);
    frame.render_widget(Paragraph::new(keys_line(view)), keys);
    if let Some(obstacle) = &view.obstacle {
        let text = Paragraph::new(obstacle.as_str()).wrap(Wrap { trim: true });
        let [middle] = Layout::vertical([Constraint::Length(4)])
            .flex(ratatui::layout::Flex::Center)
            .areas(inset(tables.union(ropes)));
        frame.render_widget(text, middle);
        return;
    }
    let columns = Layout::horizontal([Constraint::Length(STAGES), Constraint::Fill(1)]).spacing(2);
    let [left, right] = columns.areas(tables);
    stages::draw(frame, left, view);
    latency::draw(frame, right, view);
    if let Some(shape) = &view.shape {
        ropes::draw(frame, ropes, shape);
    }
}

/// Adds margins on the left and right.
fn inset(area: Rect) -> Rect {
    Rect {
        x: area.x + 4.min(area.width / 4),
        width: area.width.saturating_sub(8),
        ..area
    }
}

fn heading(view: &View) -> Line<'static> {
    let mut spans = vec![Span::styled("lariat top", BOLD)];
    let mut add = |text: String, style: Style| {
        spans.push(Span::styled(" · ", DIM));
        spans.push(Span::styled(text, style));
    };
    if let Some(rig) = &view.rig {
        add(format!("rig {rig}"), BOLD);
        if let (place @ 1.., many @ 2..) = view.place {
            add(format!("{place} of {many}"), Style::new());
        }
    }
    if view.obstacle.is_none() {
        let fit = view.stages.iter().rev().find_map(|row| row.frames_per_s);
        add(format!("{} frames/s", Figure(fit)), Style::new());
        if let Some(shape) = &view.shape {
            match (shape.width, shape.height) {
                (0, _) | (_, 0) => add("no image".into(), BAD),
                (width, height) => add(format!("{width}×{height}"), Style::new()),
            }
            // A short age only shows how long the frame waited for this update. A long one means
            // that no more frames arrive.
            if shape.age_s > 1.0 {
                add(format!("silent for {:.0} s", shape.age_s), BAD);
            }
        }
        if let Some(mb) = view.shared_mb {
            add(format!("{mb:.1} MB shared"), Style::new());
        }
        if view.clock_bound_us.is_some() {
            let bound = Figure(view.clock_bound_us);
            add(format!("± {bound} µs of clock"), Style::new());
        }
        if view.is_lossless {
            add("lossless".into(), DOUBTFUL);
        }
    }
    if view.is_paused {
        add("PAUSED".into(), DOUBTFUL.add_modifier(Modifier::BOLD));
    }
    Line::from(spans)
}

fn keys_line(view: &View) -> Line<'static> {
    let pause = if view.is_paused { "go on" } else { "pause" };
    let mut spans = Vec::new();
    let window = format!("latency of {} s", view.window_s);
    for (key, what) in [
        ("q", "quit"),
        ("p", pause),
        ("Tab", "next rig"),
        ("+ −", window.as_str()),
    ] {
        spans.push(Span::styled(key, BOLD));
        spans.push(Span::styled(format!(" {what}   "), DIM));
    }
    Line::from(spans)
}

#[cfg(test)]
mod tests;
