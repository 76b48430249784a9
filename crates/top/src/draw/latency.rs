//! Draws the latency of a frame step by step, and the shares of work and waiting.

use lariat_sink::{Micros, Step};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::{BOLD, DIM};
use lariat_view::{StepRow, View};

pub(super) fn draw(frame: &mut Frame, area: Rect, view: &View) {
    let heading = format!(
        "{:<18}{:>7}{:>7}{:>7}{:>7}",
        format!("µs, last {} s", view.window_s),
        "p50",
        "p90",
        "p99",
        "max"
    );
    let mut lines = vec![Line::styled(heading, DIM)];
    lines.extend(view.steps.iter().map(row));
    if view.steps.is_empty() {
        lines.push(Line::styled("no frame with an image in this time", DIM));
    } else {
        lines.push(bar(&view.steps, usize::from(area.width)));
    }
    frame.render_widget(Paragraph::new(lines), area);
}

/// Returns the color of a step. Each work step has its own; all waits share one.
fn style(step: Step) -> Style {
    match step {
        Step::Capture => Style::new().fg(Color::Blue),
        Step::Extract => Style::new().fg(Color::Green),
        Step::Fit => Style::new().fg(Color::Cyan),
        step if step.is_wait() => DIM,
        _ => BOLD,
    }
}

fn row(row: &StepRow) -> Line<'static> {
    let indent = match row.step {
        Step::Received | Step::Fitted => "",
        step if step.is_wait() => "  ",
        _ => " ",
    };
    let [p50, p90, p99, max] = [row.p50, row.p90, row.p99, row.max].map(|us| Micros(Some(us)));
    Line::from(vec![
        Span::styled(
            format!("{:<18}", format!("{indent}{}", row.step.label())),
            style(row.step),
        ),
        Span::raw(format!("{p50:>7}{p90:>7}{p99:>7}{max:>7}")),
    ])
}

/// Draws the medians side by side, each with a length proportional to its share of the sum.
fn bar(steps: &[StepRow], width: usize) -> Line<'static> {
    let parts = || {
        steps
            .iter()
            .filter(|row| !matches!(row.step, Step::Fitted | Step::Received))
    };
    let whole: f64 = parts().map(|row| row.p50).sum();
    let (mut until, mut drawn) = (0.0, 0);
    let spans = parts().map(|row| {
        until += row.p50;
        let end = match whole > 0.0 {
            true => (until / whole * width as f64).round() as usize,
            false => 0,
        };
        let cells = end.saturating_sub(drawn);
        drawn = drawn.max(end);
        let cell = if row.step.is_wait() { "░" } else { "█" };
        Span::styled(cell.repeat(cells), style(row.step))
    });
    Line::from(spans.collect::<Vec<_>>())
}
