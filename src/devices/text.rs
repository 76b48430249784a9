//! A camera as text.

use lariat_capture::{
    AboutCamera, Control, ControlKind, FormatOffer, ListedCamera, Rates, SizeOffer, SizeRange,
};

use super::rates;
use lariat_chain::layout::{self, hanging};

/// Maximum number of sizes or rates on a line. Any more are only counted, as are formats that
/// lariat does not read.
const MOST_RATES: usize = 8;

/// Describes one camera in a paragraph.
pub(super) fn describe(camera: &ListedCamera) -> String {
    let path = camera.path.display();
    let about = match &camera.about {
        Ok(about) => about,
        // The message names the device node.
        Err(problem) => return format!("{path}\n  {problem}\n"),
    };
    let mut text = format!("{path}  {} ({}, {})\n", about.name, about.driver, about.bus);
    for name in &camera.lasting_names {
        text += &format!("  also {}\n", name.display());
    }
    text += "\n";
    text += &formats(about);
    if !about.controls.is_empty() {
        text += "\n  Controls\n";
        let widest = (about.controls.iter())
            .map(|control| control.name.len())
            .max();
        for line in about
            .controls
            .iter()
            .map(|one| control(one, widest.unwrap_or(0)))
        {
            // The list of choices may be long.
            text += &format!("    {}\n", in_columns(&line));
        }
    }
    text
}

fn formats(about: &AboutCamera) -> String {
    let (read, others): (Vec<_>, Vec<_>) =
        (about.formats.iter()).partition(|format| format.code.is_readable());
    let mut text = String::new();
    if read.is_empty() {
        text += "  No pixel format that lariat reads\n";
    }
    for format in read {
        text += &format!("  {:<5} {}\n", format.code, format.description);
        text += &sizes(format);
    }
    if !others.is_empty() {
        let codes: Vec<_> = others
            .iter()
            .map(|format| format.code.to_string())
            .collect();
        let list = format!("Not read by lariat: {}", codes.join(" "));
        text += &format!("  {}\n", hanging(&list, 4, layout::width()));
    }
    text
}

/// Wraps a line and indents its continuation if it is too wide for the terminal. Other lines keep
/// their columns.
fn in_columns(line: &str) -> String {
    let width = layout::width();
    match 4 + line.chars().count() <= width {
        true => line.to_owned(),
        false => hanging(line, 8, width),
    }
}

fn sizes(format: &FormatOffer) -> String {
    let line =
        |offer: &SizeOffer| format!("    {}  {}\n", size(&offer.range), frames(&offer.rates));
    match format.sizes.is_empty() {
        true => "    sizes are not told by the driver\n".to_owned(),
        false => format.sizes.iter().map(line).collect(),
    }
}

fn size(range: &SizeRange) -> String {
    let words = |[width, height]: [u32; 2]| format!("{width}x{height}");
    match *range {
        SizeRange::One(size) => format!("{:<10}", words(size)),
        SizeRange::Steps { least, most, step } => {
            format!(
                "{} to {} in steps of {}",
                words(least),
                words(most),
                words(step)
            )
        }
    }
}

fn frames(offered: &Rates) -> String {
    let mut shown: Vec<_> = rates(offered)
        .iter()
        .map(|fps| ((fps * 100.0).round() / 100.0).to_string())
        .collect();
    let left = shown.len().saturating_sub(MOST_RATES);
    if left > 0 {
        // The slowest rate shows where the list ends.
        let slowest = shown.pop().unwrap_or_default();
        shown.truncate(MOST_RATES - 2);
        shown.extend(["…".to_owned(), slowest]);
    }
    match offered {
        Rates::Untold => "frames/s are not told by the driver".to_owned(),
        Rates::Listed(_) => format!("{} frames/s", shown.join(", ")),
        Rates::Between { .. } => format!("{} frames/s", shown.join(" to ")),
    }
}

fn control(control: &Control, widest: usize) -> String {
    let value = match (control.value, control.kind) {
        (_, ControlKind::Button) => "a button".to_owned(),
        (None, _) => "-".to_owned(),
        (Some(value), ControlKind::Boolean) => if value == 0 { "off" } else { "on" }.to_owned(),
        (Some(value), ControlKind::Bitmask) => format!("{value:#x}"),
        (Some(value), _) => (control.items.iter())
            .find(|(index, _)| *index == value)
            .map_or(value.to_string(), |(index, name)| {
                format!("{index} ({name})")
            }),
    };
    let range = match control.kind {
        ControlKind::Integer if control.step == 1 => {
            format!(
                "{} to {}, default {}",
                control.minimum, control.maximum, control.default
            )
        }
        ControlKind::Integer => format!(
            "{} to {} in steps of {}, default {}",
            control.minimum, control.maximum, control.step, control.default
        ),
        ControlKind::Boolean => format!(
            "default {}",
            if control.default == 0 { "off" } else { "on" }
        ),
        ControlKind::Bitmask => format!("bits {:#x}", control.maximum),
        ControlKind::Menu | ControlKind::IntegerMenu => {
            let items = control
                .items
                .iter()
                .map(|(index, name)| format!("{index} {name}"));
            items.collect::<Vec<_>>().join(", ")
        }
        ControlKind::Button | ControlKind::Other => String::new(),
    };
    let state = match (control.read_only, control.inactive) {
        (true, _) => "  (read only)",
        (_, true) => "  (without effect now)",
        _ => "",
    };
    format!("{:<widest$}  {value:<12}  {range}{state}", control.name)
        .trim_end()
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lariat_capture::{FourCc, Interval};

    fn per_second(denominator: u32) -> Interval {
        Interval {
            numerator: 1,
            denominator,
        }
    }

    #[test]
    fn a_camera_is_described_by_what_can_be_asked_of_it() {
        let format = |code: &str, rates| FormatOffer {
            code: code.parse::<FourCc>().expect("a code"),
            description: "Words".to_owned(),
            compressed: false,
            sizes: vec![SizeOffer {
                range: SizeRange::One([640, 480]),
                rates,
            }],
        };
        let camera = ListedCamera {
            path: "/dev/video0".into(),
            lasting_names: vec!["/dev/v4l/by-id/usb-one".into()],
            about: Ok(AboutCamera {
                name: "One".to_owned(),
                driver: "uvcvideo".to_owned(),
                bus: "usb-1".to_owned(),
                has_planes: false,
                formats: vec![
                    format("yuyv", Rates::Listed(vec![per_second(15), per_second(30)])),
                    format("h264", Rates::Untold),
                ],
                controls: Vec::new(),
            }),
        };
        assert_eq!(
            describe(&camera),
            "/dev/video0  One (uvcvideo, usb-1)\n  also /dev/v4l/by-id/usb-one\n\n  YUYV  Words\n    \
             640x480     30, 15 frames/s\n  Not read by lariat: H264\n"
        );
    }

    #[test]
    fn long_lists_of_rates_are_cut_but_show_where_they_end() {
        let many = Rates::Listed((1..=20).map(per_second).collect());
        assert_eq!(frames(&many), "20, 19, 18, 17, 16, 15, …, 1 frames/s");
    }
}
