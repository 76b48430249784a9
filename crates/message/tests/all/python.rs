//! The layout for NumPy, and the names of codes as types.

use std::fmt::Write;

use lariat_message::fields::{Codes, Layout, Type};
use lariat_message::{
    Basis, CenterlinePoints, Descriptor, Descriptors, FitQuality, Status, Trace, Unit,
};

use crate::hold;

#[test]
fn numpy_has_every_field() {
    hold("python/lariat/_layout.py", |committed| {
        let (before, rest) = committed.split_once("_TRACE = ").expect("the first type");
        let (_, after) = rest
            .split_once("\"\"\"The type of")
            .expect("the message's documentation");
        let mut text = before.to_owned();
        for layout in [
            &Trace::LAYOUT,
            &Descriptor::LAYOUT,
            &CenterlinePoints::LAYOUT,
            &Descriptors::LAYOUT,
        ] {
            text += &dtype(layout);
        }
        let (_, after) = after.split_once("\"\"\"").expect("its end");
        text.pop();
        text + &format!(
            "\"\"\"The type of ``Frame.message``: ``{}``.\"\"\"{after}",
            Descriptors::LAYOUT.type_name
        )
    });
}

fn dtype(layout: &Layout) -> String {
    let mut text = format!("{} = np.dtype(\n    [\n", name(layout));
    for field in layout.fields {
        let (element, shape) = field.of.element();
        let element = match element {
            Type::U32 => "\"u4\"".to_owned(),
            Type::U64 => "\"u8\"".to_owned(),
            Type::F32 => "\"f4\"".to_owned(),
            Type::F64 => "\"f8\"".to_owned(),
            Type::Message(layout) => name(layout).to_owned(),
            Type::Array(..) => unreachable!("an element is no array"),
        };
        let shape = match &shape[..] {
            [] => String::new(),
            [one] => format!(", ({one},)"),
            more => format!(
                ", ({})",
                more.iter()
                    .map(usize::to_string)
                    .collect::<Vec<_>>()
                    .join(", ")
            ),
        };
        let _ = writeln!(text, "        (\"{}\", {element}{shape}),", field.name);
    }
    text + "    ]\n)\n\n"
}

fn name(layout: &Layout) -> &'static str {
    match layout.name {
        "Trace" => "_TRACE",
        "Descriptor" => "_DESCRIPTOR",
        "CenterlinePoints" => "_CENTERLINE",
        _ => "MESSAGE",
    }
}

#[test]
fn types_have_the_names_of_codes() {
    hold("python/lariat/_names.py", |committed| {
        let mut text = committed.to_owned();
        for (name, codes) in [
            ("StatusName", &Status::CODES),
            ("FitName", &FitQuality::CODES),
            ("BasisName", &Basis::CODES),
            ("UnitName", &Unit::CODES),
        ] {
            let begins = format!("{name}: TypeAlias = Literal[");
            let at = text.find(&begins).expect("a type") + begins.len();
            let end = at + text[at..].find(']').expect("its end");
            text.replace_range(at..end, &names(codes));
        }
        text
    });
}

fn names(codes: &Codes) -> String {
    let names: Vec<_> = codes
        .all
        .iter()
        .map(|code| format!("\"{}\"", code.name))
        .collect();
    names.join(", ")
}
