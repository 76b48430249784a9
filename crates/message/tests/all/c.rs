//! The messages as C structs, from which cbindgen generates `lariat.h`.

use std::fmt::Write;

use lariat_message::fields::{Field, Layout, Meaning, Type};
use lariat_message::{CenterlinePoints, Descriptor, Descriptor3, Descriptors, Trace};

use crate::{hold, plain};

/// Name and purpose of each message in C.
const STRUCTS: [(&Layout, &str, &str); 5] = [
    (
        &Trace::LAYOUT,
        "lariat_trace",
        "Counters and times of one frame on its way through the chain. ARCHITECTURE.md explains how they show losses.",
    ),
    (
        &Descriptor::LAYOUT,
        "lariat_descriptor",
        "One rope's shape as a few control points, in the message's unit.",
    ),
    (
        &CenterlinePoints::LAYOUT,
        "lariat_centerline",
        "The points that a rope's curve was fitted to, at equal steps of arc length, in the message's unit, unfiltered.",
    ),
    (
        &Descriptors::LAYOUT,
        "lariat_descriptors",
        "The chain's message for one frame.",
    ),
    (
        &Descriptor3::LAYOUT,
        "lariat_descriptor3",
        "One rope's shape in space as a few control points, in millimetres. It has one unless `place` says why not.",
    ),
];

#[test]
fn c_has_every_field_and_every_code() {
    hold("crates/c/src/message.rs", |committed| {
        let (before, _) = committed
            .split_once("// Generated from")
            .expect("where it begins");
        let mut text = before.to_owned();
        text += "// Generated from the messages' declarations: LARIAT_WRITE_LAYOUTS=1 cargo test -p lariat-message\n";
        for (layout, name, _) in STRUCTS {
            layout
                .fields
                .iter()
                .for_each(|field| constants(name, field, &mut text));
        }
        for (layout, name, about) in STRUCTS {
            let _ = write!(
                text,
                "\n/// {about}\n#[repr(C)]\n#[derive(Debug, Clone, Copy)]\npub struct {name} {{\n"
            );
            for field in layout.fields {
                let _ = writeln!(text, "    /// {}", comment(field));
                let _ = writeln!(
                    text,
                    "    pub {}: {},",
                    field_name(field),
                    of(&field.of, field.name)
                );
            }
            text += "}\n";
        }
        for (layout, name, _) in STRUCTS {
            let _ = write!(text, "\nsame_layout!({name}, wire::{}:", layout.name);
            for field in layout.fields {
                let _ = write!(text, "\n    {} = {},", field_name(field), field.name);
            }
            text.pop();
            text += ");";
        }
        text + "\n"
    });
}

/// Appends constants for the values of a field.
fn constants(of: &str, field: &Field, text: &mut String) {
    let Meaning::Code(codes) = field.meaning else {
        return;
    };
    let field = field.name;
    // Another struct has already defined the same constants.
    if text.contains(&format!("LARIAT_{}_", field.to_uppercase())) {
        return;
    }
    text.push('\n');
    for (i, code) in codes.all.iter().enumerate() {
        let about = ascii(code.about);
        let about = match i {
            0 => format!("{} ({of}.{field}).", about.trim_end_matches('.')),
            _ => about,
        };
        let name = code.name.replace(' ', "_").to_uppercase();
        let field = field.to_uppercase();
        let _ = writeln!(
            text,
            "/// {about}\npub const LARIAT_{field}_{name}: u32 = {};",
            code.number
        );
    }
}

fn comment(field: &Field) -> String {
    let about = ascii(field.about);
    match (&field.meaning, about.split_once("'s number")) {
        (Meaning::Code(_), Some((_, rest))) => {
            let rest = rest
                .strip_suffix('.')
                .filter(|rest| rest.is_empty())
                .unwrap_or(rest);
            format!("A LARIAT_{}_…{rest}", field.name.to_uppercase())
        }
        _ => about,
    }
}

/// Replaces characters that a C header should avoid.
fn ascii(about: &str) -> String {
    plain(about)
        .replace("πρ", "π·ρ")
        .replace('ρ', "rho")
        .replace('−', "-")
}

fn field_name(field: &Field) -> &'static str {
    match field.name {
        // C calls the curves of a message ropes.
        "curves" => "ropes",
        name => name,
    }
}

fn of(of: &Type, field: &str) -> String {
    match of {
        Type::U32 => "u32".to_owned(),
        Type::U64 => "u64".to_owned(),
        Type::F32 => "f32".to_owned(),
        Type::F64 => "f64".to_owned(),
        Type::Message(layout) => {
            let found = STRUCTS.iter().find(|(known, ..)| known.name == layout.name);
            found.expect("C has it").1.to_owned()
        }
        Type::Array(inner, count) => {
            format!("[{}; {}]", self::of(inner, field), length(*count, field))
        }
    }
}

/// Returns the name of a length in C, or the length itself.
fn length(count: usize, field: &str) -> String {
    match (count, field) {
        (8, "hidden") => "LARIAT_HIDDEN_WORDS".to_owned(),
        (24, _) => "LARIAT_MAX_ROPES".to_owned(),
        (32, _) => "LARIAT_MAX_CONTROL_POINTS".to_owned(),
        (256, _) => "LARIAT_MAX_POINTS".to_owned(),
        _ => count.to_string(),
    }
}
