//! Draws the processes of the rig, and the losses between them.

use lariat_sink::Figure;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::{BAD, BOLD, DIM, DOUBTFUL};
use lariat_view::{StageRow, View};

pub(super) fn draw(frame: &mut Frame, area: Rect, view: &View) {
    let heading = format!(
        "{:<8}{:>7}{:>6}{:>6}{:>5}",
        "stage", "pid", "CPU %", "MB", "/s"
    );
    let mut lines = vec![Line::styled(heading, DIM)];
    // The last two lines show the losses.
    let most = usize::from(area.height).saturating_sub(4);
    lines.extend(view.stages.iter().take(most).map(stage));
    if view.stages.is_empty() {
        lines.push(Line::styled(
            "its stages have not announced themselves",
            DIM,
        ));
    }
    let room = usize::from(area.height).saturating_sub(lines.len() + 2);
    lines.extend(std::iter::repeat_n(Line::default(), room));
    lines.extend(lost(view));
    frame.render_widget(Paragraph::new(lines), area);
}

fn stage(row: &StageRow) -> Line<'static> {
    // A stage can use at most one core.
    let cpu = match row.cpu_percent {
        Some(busy) if busy >= 90.0 => BAD,
        Some(busy) if busy >= 60.0 => DOUBTFUL,
        _ => Style::new(),
    };
    let tenth = |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{value:.1}"));
    Line::from(vec![
        Span::styled(format!("{:<8.8}", row.stage), BOLD),
        Span::raw(format!("{:>7}", row.pid)),
        Span::styled(format!("{:>6}", tenth(row.cpu_percent)), cpu),
        Span::raw(format!("{:>6}", tenth(row.own_mb))),
        Span::raw(format!("{:>5}", Figure(row.frames_per_s))),
    ])
}

/// Returns the lines of lost frames, by where they were lost.
fn lost(view: &View) -> [Line<'static>; 2] {
    let count = |count: u64, width: usize| {
        let style = if count > 0 { BAD } else { Style::new() };
        Span::styled(format!("{count:>width$}"), style)
    };
    let here = [view.lost.source, view.lost.capture, view.lost.extract];
    let far = [here[0], here[1], here[2], view.lost.bridge];
    // On another machine, include the losses on the way to it.
    let (names, losses, widths) = match view.clock_bound_us {
        None => (
            &["at source", "→ extract", "→ fit"][..],
            &here[..],
            &[10, 10, 8][..],
        ),
        Some(_) => (
            &["source", "extract", "fit", "here"][..],
            &far[..],
            &[8, 8, 6, 6][..],
        ),
    };
    let heading = names.iter().zip(widths);
    let heading: String = heading
        .map(|(name, &width)| format!("{name:>width$}"))
        .collect();
    let counts = losses
        .iter()
        .zip(widths)
        .map(|(lost, width)| count(*lost, *width));
    [
        Line::styled(format!("lost{heading}"), DIM),
        Line::from_iter([Span::raw("    ")].into_iter().chain(counts)),
    ]
}
