//! A message as a few lines of text.

use lariat_sink::{Figure, Micros, Step};
use lariat_wire::{
    Axes, Basis, Centerlines, Curve, Descriptor, Descriptors, Descriptors3, FitQuality,
    PixelFormat, Place, SourceKind, Status, Trace, Unit,
};

use crate::topic::probe::Any;
use lariat_chain::confidence;
use lariat_chain::layout::{self, flowed, hanging};

/// Formats the message as a paragraph, followed by an empty line. `has_colours`: low confidence is
/// printed in yellow.
pub(super) fn paragraph(channel: &str, message: Any, has_colours: bool) -> String {
    let mut text = heading(channel, message.trace());
    match message {
        _ if message.is_blank() => text += "  no image: the source has none to give\n",
        Any::Image(header, pixels) => {
            let sentence = format!(
                "{}×{} {} from {}, {} bytes a row, {} bytes",
                header.width,
                header.height,
                PixelFormat::word(header.pixel_format),
                SourceKind::word(header.source),
                header.stride,
                pixels.len()
            );
            add(&sentence, 2, &mut text);
        }
        Any::Centerlines(message) => centerlines(message, has_colours, &mut text),
        Any::Descriptors(message) => descriptors(message, has_colours, &mut text),
        Any::Descriptors3(message) => descriptors3(message, has_colours, &mut text),
    }
    // Descriptors continue without an image.
    if let (true, Any::Descriptors(message)) = (message.is_blank(), message) {
        descriptors(message, has_colours, &mut text);
    }
    text.push('\n');
    text
}

fn heading(channel: &str, trace: &Trace) -> String {
    let exposed_s = trace.exposed_ns as f64 / 1e9;
    let mut text = format!(
        "{channel}: frame {}, exposed {exposed_s:.6} s; sent: captured {}",
        trace.sequence, trace.captured
    );
    for (name, count) in [("extracted", trace.extracted), ("fitted", trace.fitted)] {
        if count > 0 {
            text += &format!(", {name} {count}");
        }
    }
    let steps: Vec<String> = Step::ALL
        .iter()
        .skip(2)
        .filter_map(|step| {
            let us = step.ns(trace, 0)? as f64 / 1e3;
            Some(format!("{} {}", step.label(), Micros(Some(us))))
        })
        .collect();
    let steps = format!("µs: {}", steps.join(", "));
    let width = layout::width();
    format!(
        "{}\n  {}\n",
        hanging(&text, 2, width),
        hanging(&steps, 4, width)
    )
}

/// Appends an indented sentence.
fn add(sentence: &str, indent: usize, text: &mut String) {
    let lines = hanging(sentence, indent + 2, layout::width());
    *text += &format!("{:indent$}{lines}\n", "");
}

/// Appends a sentence about a rope, which begins with its number and its confidence.
fn add_rope(track: u32, confidence: f32, sentence: &str, has_colours: bool, text: &mut String) {
    let confidence_text = format!("confidence {confidence:.2}");
    let head = format!("rope {track}, {confidence_text}: ");
    let mut lines = String::new();
    add(&(head + sentence), 2, &mut lines);
    if has_colours && confidence::is_low(confidence.into()) {
        // The head of a sentence fits on one line, so nothing was folded before this.
        lines = lines.replacen(&confidence_text, &layout::yellow(&confidence_text), 1);
    }
    *text += &lines;
}

fn centerlines(message: &Centerlines, has_colours: bool, text: &mut String) {
    if message.curves().is_empty() {
        *text += "  no rope\n";
    }
    for curve in message.curves() {
        one_curve(curve, has_colours, text);
    }
    for crossing in message.crossings() {
        let [x, y] = crossing.at;
        let sentence = format!(
            "crossing at ({x:.1}, {y:.1}): curve {} at ρ {:.3} over curve {} at ρ {:.3}, confidence {:.2}",
            crossing.over,
            crossing.over_rho,
            crossing.under,
            crossing.under_rho,
            crossing.confidence
        );
        add(&sentence, 2, text);
    }
}

fn one_curve(curve: &Curve, has_colours: bool, text: &mut String) {
    let points = curve.points();
    let hidden = (0..points.len()).filter(|&i| curve.is_hidden(i)).count();
    let sentence = format!(
        "{}{}; {:.1} px long, {:.1} wide, {} points{}",
        Status::word(curve.status),
        more(curve.closed, curve.border, curve.age_ns),
        curve.length_px,
        curve.width_px,
        points.len(),
        match hidden {
            0 => String::new(),
            hidden => format!(", {hidden} hidden"),
        }
    );
    add_rope(curve.track, curve.confidence, &sentence, has_colours, text);
    let as_f64 = points.iter().map(|point| point.map(f64::from));
    in_lines(as_f64, text);
}

fn descriptors(message: &Descriptors, has_colours: bool, text: &mut String) {
    if message.curves().is_empty() {
        *text += "  no rope\n";
    }
    let unit = Unit::word(message.unit);
    for curve in message.curves() {
        one_descriptor(curve, &unit, has_colours, text);
    }
}

fn one_descriptor(curve: &Descriptor, unit: &str, has_colours: bool, text: &mut String) {
    let name = Basis::word(curve.basis);
    let count = curve.control_points().len();
    let judged = match curve.fit() {
        Some(FitQuality::NotJudged) => String::new(),
        _ => format!(", {}", FitQuality::word(curve.fit)),
    };
    let sentence = format!(
        "{}{}; {name} of degree {}, {count} control points{judged}, {:.1} {unit} long, {:.1} wide",
        Status::word(curve.status),
        more(curve.closed, curve.border, curve.age_ns),
        curve.degree,
        curve.length,
        curve.width,
    );
    add_rope(curve.track, curve.confidence, &sentence, has_colours, text);
    let sigma = |[xx, _, yy]: [f64; 3]| (xx.max(yy)).max(0.0).sqrt();
    let least_certain = curve.covariances[..count].iter().copied().map(sigma);
    let sentence = format!(
        "rms {}, max {} {unit} of {} points ({} hidden), condition {}, control points known to {} {unit}{}",
        Figure(Some(curve.rms)),
        Figure(Some(curve.max)),
        curve.samples,
        curve.hidden,
        Figure(Some(curve.condition)),
        Figure(least_certain.reduce(f64::max)),
        if curve.filtered == 0 {
            ""
        } else {
            ", filtered"
        },
    );
    add(&sentence, 4, text);
    in_lines(curve.control_points().iter().copied(), text);
}

fn descriptors3(message: &Descriptors3, has_colours: bool, text: &mut String) {
    if message.curves().is_empty() {
        *text += "  no rope\n";
    }
    let axes = Axes::word(message.axes);
    for curve in message.curves() {
        let status = Status::word(curve.status);
        let say = |sentence: &str, text: &mut String| {
            add_rope(curve.track, curve.confidence, sentence, has_colours, text);
        };
        let more = more(curve.closed, curve.border, curve.age_ns);
        if curve.control_points().is_empty() {
            let place = Place::word(curve.place);
            say(&format!("{status}{more}; in space: {place}"), text);
            continue;
        }
        let sentence = format!(
            "{status}{more}; {} of degree {}, {} control points, {}, {:.1} mm long, {:.1} wide, {} of {} points measured, {axes} axes",
            Basis::word(curve.basis),
            curve.degree,
            curve.control_points().len(),
            Place::word(curve.place),
            curve.length,
            curve.width,
            curve.measured,
            curve.points().len(),
        );
        say(&sentence, text);
        in_lines(curve.control_points().iter().copied(), text);
    }
}

/// Describes unusual properties of a rope.
fn more(closed: u32, border: u32, age_ns: u64) -> String {
    let mut text = String::new();
    if age_ns > 0 {
        text += &format!(" for {:.2} s", age_ns as f64 / 1e9);
    }
    if closed != 0 {
        text += ", closed";
    }
    match border & 3 {
        0 => {}
        1 => text += ", its first end leaves the image",
        2 => text += ", its last end leaves the image",
        _ => text += ", both ends leave the image",
    }
    text
}

/// Appends points, as many per line as fit.
fn in_lines<const D: usize>(points: impl Iterator<Item = [f64; D]>, text: &mut String) {
    let points = points.map(|point| {
        let numbers = point.map(|c| format!("{c:.1}"));
        format!("({})", numbers.join(", "))
    });
    let lines = flowed(points, layout::width().saturating_sub(4));
    *text += &format!("    {}\n", lines.replace('\n', "\n    "));
}
