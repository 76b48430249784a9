//! Draws the ropes in Braille, with eight dots per character. A terminal of 80 columns is then an
//! image about 100 pixels wide.

use lariat_chain::confidence;
use lariat_sink::Figure;
use lariat_wire::{Place, Status};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{self, Canvas, Context, Rectangle};
use ratatui::widgets::{Block, Paragraph};

use super::{BAD, BOLD, DIM, DOUBTFUL, GOOD};
use lariat_view::{InSpace, Rope, Shape};

/// Colors by track number, so that a rope keeps its color.
const COLORS: [Color; 6] = [
    Color::Cyan,
    Color::Yellow,
    Color::Magenta,
    Color::Green,
    Color::Blue,
    Color::LightRed,
];
/// Number of columns of the list next to the picture.
const LIST: u16 = 30;
/// Number of dots in a character, across and down.
const DOTS: [f64; 2] = [2.0, 4.0];

pub(super) fn draw(frame: &mut Frame, area: Rect, shape: &Shape) {
    let title = format!(" frame {} ", shape.frame);
    let block = Block::bordered().border_style(DIM).title(title);
    let inside = block.inner(area);
    frame.render_widget(block, area);
    let columns = Layout::horizontal([Constraint::Fill(1), Constraint::Length(LIST)]).spacing(1);
    let [picture, list] = columns.areas(inside);
    if picture.is_empty() {
        return;
    }
    let view = Window::of(shape, picture);
    let canvas = Canvas::default()
        .marker(Marker::Braille)
        .x_bounds(view.x)
        .y_bounds(view.y)
        .paint(|context| paint(context, shape));
    frame.render_widget(canvas, picture);
    frame.render_widget(Paragraph::new(lines(shape, list.height)), list);
}

/// The visible part of the plane. Rows count downwards in an image and upwards on a canvas, so y is
/// negated.
struct Window {
    x: [f64; 2],
    y: [f64; 2],
}

impl Window {
    /// Returns the whole image, or the part of the plane where ropes have been, with square dots.
    fn of(shape: &Shape, area: Rect) -> Self {
        let [x0, y0, x1, y1] = match (shape.is_of_image, shape.width, shape.height) {
            (true, width @ 1.., height @ 1..) => {
                [-0.5, -0.5, f64::from(width) - 0.5, f64::from(height) - 0.5]
            }
            _ => shape.reach,
        };
        let dots = [
            f64::from(area.width) * DOTS[0],
            f64::from(area.height) * DOTS[1],
        ];
        let per_dot = ((x1 - x0) / dots[0]).max((y1 - y0) / dots[1]).max(1e-9);
        let around =
            |middle: f64, dots: f64| [middle - dots * per_dot / 2.0, middle + dots * per_dot / 2.0];
        Self {
            x: around((x0 + x1) / 2.0, dots[0]),
            y: around(-(y0 + y1) / 2.0, dots[1]),
        }
    }
}

fn paint(context: &mut Context, shape: &Shape) {
    if shape.is_of_image && shape.width > 0 && shape.height > 0 {
        let (width, height) = (f64::from(shape.width), f64::from(shape.height));
        context.draw(&Rectangle {
            x: -0.5,
            y: 0.5 - height,
            width,
            height,
            color: Color::DarkGray,
        });
    }
    context.layer();
    for rope in &shape.ropes {
        let color = color(rope);
        for pair in rope.points.windows(2) {
            let ([x1, y1], [x2, y2]) = (pair[0], pair[1]);
            context.draw(&canvas::Line {
                x1,
                y1: -y1,
                x2,
                y2: -y2,
                color,
            });
        }
    }
    // Drawn on top of all lines.
    context.layer();
    for rope in &shape.ropes {
        for [x, y] in &rope.control_points {
            context.print(*x, -y, Span::styled("○", Style::new().fg(color(rope))));
        }
        // Mark the end where ρ is 0.
        if let Some([x, y]) = rope.points.first() {
            context.print(*x, -y, Span::styled("●", Style::new().fg(color(rope))));
        }
    }
}

fn color(rope: &Rope) -> Color {
    match rope.status {
        Some(Status::Lost) => Color::DarkGray,
        _ => COLORS[rope.track as usize % COLORS.len()],
    }
}

/// Returns the heading and the lines of each rope: three, or four with 3-D data, or one if there
/// are many ropes.
fn lines(shape: &Shape, height: u16) -> Vec<Line<'static>> {
    if shape.ropes.is_empty() {
        return vec![Line::styled("no rope", DIM)];
    }
    let in_space = shape.ropes.iter().filter(|rope| rope.in_space.is_some());
    let is_short = 1 + shape.ropes.len() * 3 + in_space.count() > usize::from(height);
    let of_rope = |rope: &Rope| {
        let mut lines = vec![heading(rope)];
        if !is_short {
            let extent = if rope.is_closed { "closed" } else { "long" };
            let (unit, rms) = (shape.unit, Figure(Some(rope.rms)));
            let length = format!("  {:.1} {unit} {extent}, rms {rms}", rope.length);
            lines.push(Line::raw(length));
            let count = rope.control_point_count;
            lines.push(Line::styled(
                format!("  {count} control points, {}", rope.basis),
                DIM,
            ));
            lines.extend(rope.in_space.map(placed));
        }
        lines
    };
    let headings = Line::styled("rope  conf.  status", DIM);
    std::iter::once(headings)
        .chain(shape.ropes.iter().flat_map(of_rope))
        .collect()
}

/// Returns the length in 3-D, or why it is unknown.
fn placed(InSpace { place, length_mm }: InSpace) -> Line<'static> {
    match place {
        Some(Place::Known) => Line::raw(format!("  {length_mm:.1} mm in space")),
        Some(Place::Before) => {
            Line::styled(format!("  {length_mm:.1} mm in space, before"), DOUBTFUL)
        }
        Some(why) => Line::styled(format!("  in space: {}", why.name()), BAD),
        None => Line::styled("  in space: ?", BAD),
    }
}

fn heading(rope: &Rope) -> Line<'static> {
    let style = match rope.status {
        Some(Status::Ok) if !confidence::is_low(rope.confidence.into()) => GOOD,
        Some(Status::Ok | Status::Partial | Status::Doubtful) => DOUBTFUL,
        Some(Status::Lost) | None => BAD,
    };
    let name = rope.status.map_or("?", Status::name);
    let word = match rope.status {
        Some(Status::Lost) => format!("{name} for {:.1} s", rope.age_s),
        _ => confidence::status_word(name, rope.confidence.into()).to_owned(),
    };
    let doubt = match confidence::is_low(rope.confidence.into()) {
        true => DOUBTFUL,
        false => Style::new(),
    };
    let mut line = Line::from(vec![
        Span::styled(format!("{:>4}", rope.track), BOLD.fg(color(rope))),
        Span::styled(format!("  {:>5.2}  ", rope.confidence), doubt),
        Span::styled(word, style),
    ]);
    if rope.is_coarse {
        line.push_span(Span::styled(", coarse", BAD));
    }
    line
}
