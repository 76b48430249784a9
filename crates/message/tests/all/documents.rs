//! The tables of docs/messages.md.

use std::fmt::Write;

use lariat_message::fields::{Codes, Field, Layout, Meaning, Type};
use lariat_message::{
    Axes, Basis, CenterlinePoints, Centerlines, Command, Crossing, Curve, Descriptor, Descriptor3,
    Descriptors, Descriptors3, FitQuality, FrameHeader, PixelFormat, Place, SourceKind, Status,
    Trace, Unit,
};

use crate::{hold, plain};

const MESSAGES: [&Layout; 11] = [
    &Trace::LAYOUT,
    &FrameHeader::LAYOUT,
    &Curve::LAYOUT,
    &Crossing::LAYOUT,
    &Centerlines::LAYOUT,
    &Descriptor::LAYOUT,
    &CenterlinePoints::LAYOUT,
    &Descriptors::LAYOUT,
    &Descriptor3::LAYOUT,
    &Descriptors3::LAYOUT,
    &Command::LAYOUT,
];
const CODES: [&Codes; 8] = [
    &PixelFormat::CODES,
    &SourceKind::CODES,
    &Status::CODES,
    &FitQuality::CODES,
    &Basis::CODES,
    &Unit::CODES,
    &Place::CODES,
    &Axes::CODES,
];

#[test]
fn the_document_of_messages_has_every_field_and_every_code() {
    hold("docs/messages.md", |committed| {
        let mut text = committed.to_owned();
        for layout in MESSAGES {
            let head = format!("**`{}`**", layout.name);
            text = with_table(&text, &head, "| offset |", &fields(layout));
            text = with_version(&text, layout);
            text = with_size(&text, &head, layout.size);
        }
        with_table(&text, "**Codes**", "| field |", &codes())
    });
}

/// Updates the version wherever the text names the message's type.
fn with_version(text: &str, layout: &Layout) -> String {
    let unversioned = layout
        .type_name
        .trim_end_matches(|c: char| c.is_ascii_digit());
    let mut parts = text.split(unversioned);
    let mut whole = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        whole += layout.type_name;
        whole += part.trim_start_matches(|c: char| c.is_ascii_digit());
    }
    whole
}

/// Updates a message's size in the sentence that begins with `head`.
fn with_size(text: &str, head: &str, size: usize) -> String {
    let at = text.find(head).expect("it is described");
    let end = at + text[at..].find(" bytes").expect("its size");
    let from = at + text[at..end].rfind(", ").expect("its size") + 2;
    let size = match size {
        0..10_000 => size.to_string(),
        _ => format!("{} {:03}", size / 1000, size % 1000),
    };
    format!("{}{size}{}", &text[..from], &text[end..])
}

/// Replaces the table after a heading.
fn with_table(text: &str, head: &str, begins: &str, table: &str) -> String {
    let at = text
        .find(head)
        .unwrap_or_else(|| panic!("{head} is described"));
    let from = at + text[at..].find(begins).expect("a table");
    let length = text[from..].find("\n\n").expect("more behind it") + 1;
    format!("{}{table}{}", &text[..from], &text[from + length..])
}

fn fields(layout: &Layout) -> String {
    let mut table = "| offset | field | type | |\n|---:|---|---|---|\n".to_owned();
    for field in layout.fields {
        let Field { name, offset, .. } = field;
        let _ = writeln!(
            table,
            "| {offset} | `{name}` | {} | {} |",
            of(&field.of),
            cell(field.about)
        );
    }
    table
}

fn of(of: &Type) -> String {
    match of {
        Type::U32 => "u32".to_owned(),
        Type::U64 => "u64".to_owned(),
        Type::F32 => "f32".to_owned(),
        Type::F64 => "f64".to_owned(),
        Type::Message(layout) => layout.name.to_owned(),
        Type::Array(inner, count) => format!("[{}; {count}]", self::of(inner)),
    }
}

fn codes() -> String {
    let mut table = "| field | | name | |\n|---|---:|---|---|\n".to_owned();
    for codes in CODES {
        let is_of =
            |field: &&Field| matches!(field.meaning, Meaning::Code(of) if of.name == codes.name);
        let field = MESSAGES
            .iter()
            .find_map(|layout| layout.fields.iter().find(is_of));
        let field = field.expect("a field has it").name;
        for code in codes.all {
            let _ = writeln!(
                table,
                "| `{field}` | {} | {} | {} |",
                code.number,
                code.name,
                cell(code.about)
            );
        }
    }
    table
}

/// Text of a table cell: without the final period.
fn cell(about: &str) -> String {
    let text = plain(about);
    text.strip_suffix('.').map_or(text.clone(), str::to_owned)
}
