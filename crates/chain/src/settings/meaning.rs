//! Interprets values, or explains in a sentence what to write instead.

use crate::settings::curve::ControlPoints;
use crate::settings::{Fps, duration};
use lariat_extract::{HsvRange, Mask};
use lariat_fit::MAX_CONTROL_POINTS;
use std::num::NonZeroU8;
use std::path::{Path, PathBuf};
use std::time::Duration;
use toml::Value;

const NO_FPS: &str = "frames per second are a number such as 30, \"max\" or \"auto\"";

/// Upper limit of the frame rate, above that of any camera.
const MAX_FPS: f64 = 1e6;

pub(super) fn text(value: &Value) -> Result<&str, String> {
    match value.as_str() {
        Some("") => Err("it must not be empty".to_owned()),
        Some(text) => Ok(text),
        None => Err("write it as text, in quotes".to_owned()),
    }
}

/// Returns the number of an integer or a float.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(n) => Some(*n as f64),
        Value::Float(x) => Some(*x),
        _ => None,
    }
}

/// Returns the shortest value of the number: `30`, not `30.0`.
pub(super) fn number_value(x: f64) -> Value {
    if x.fract() == 0.0 && x.abs() < 1e15 {
        Value::Integer(x as i64)
    } else {
        Value::Float(x)
    }
}

/// Formats a number exactly, with a decimal point, as in the file.
pub fn number_text(x: f64) -> String {
    Value::Float(x).to_string()
}

pub(super) fn whole(value: &Value, low: i64, high: i64) -> Result<i64, String> {
    let range = if high == i64::MAX {
        format!("of at least {low}")
    } else {
        format!("from {low} to {high}")
    };
    match value {
        Value::Integer(n) if (low..=high).contains(n) => Ok(*n),
        Value::String(text) if text.trim().parse::<i64>().is_ok() => {
            Err(format!("write the number without quotes: {}", text.trim()))
        }
        _ => Err(format!("choose a whole number {range}")),
    }
}

/// Reads a duration given in `unit`, which lasts `unit_s` seconds.
pub(super) fn time(value: &Value, unit_s: f64, unit: &str) -> Result<Duration, String> {
    if let Some(number) = number(value) {
        return duration::from_s(number * unit_s);
    }
    let why = format!("it is a number of {unit}, without a unit");
    Err(match value.as_str().map(duration::parse) {
        Some(Ok(time)) => {
            // Round to what a person would write.
            let count = (time.as_secs_f64() / unit_s * 1e6).round() / 1e6;
            format!("{why}: write {}", number_value(count))
        }
        _ => why,
    })
}

pub(super) fn rig(value: &Value) -> Result<String, String> {
    let name = text(value)?;
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || c == '-';
    if name.len() <= 32 && name.chars().all(allowed) {
        Ok(name.to_owned())
    } else {
        Err("a rig's name is 1 to 32 of a-z, 0-9, _ and -".to_owned())
    }
}

pub(super) fn paths(value: &Value) -> Result<Vec<PathBuf>, String> {
    let why = || {
        "write \"rendered\", \"simulated\", \"external\", a path in quotes, or a list of paths"
            .to_owned()
    };
    let one = |value: &Value| value.as_str().filter(|s| !s.is_empty()).map(PathBuf::from);
    match value {
        Value::Array(list) if !list.is_empty() => list.iter().map(one).collect(),
        value => one(value).map(|path| vec![path]),
    }
    .ok_or_else(why)
}

pub(super) fn paths_value(paths: &[PathBuf]) -> Value {
    match paths {
        [one] => path_value(one),
        many => Value::Array(many.iter().map(|path| path_value(path)).collect()),
    }
}

pub(super) fn path_value(path: &Path) -> Value {
    Value::String(path.to_string_lossy().into_owned())
}

pub(super) fn fps(value: &Value) -> Result<Fps, String> {
    if let Some(fps) = number(value) {
        return if fps > 0.0 && fps <= MAX_FPS {
            Ok(Fps::PerSecond(fps))
        } else {
            Err(format!(
                "frames per second must be more than 0 and at most {MAX_FPS}; as fast as possible is \
                 \"max\""
            ))
        };
    }
    match value.as_str().map(str::trim) {
        Some("max") => Ok(Fps::Max),
        Some("auto") => Ok(Fps::Auto),
        Some(text) => {
            let digits: String = text
                .chars()
                .take_while(|c| c.is_ascii_digit() || *c == '.')
                .collect();
            let unit = text[digits.len()..].trim();
            let Ok(number) = digits.parse::<f64>() else {
                return Err(NO_FPS.to_owned());
            };
            Err(match unit {
                "ms" | "us" | "s" => format!(
                    "frames per second, not the time between two frames: write {}",
                    number_value((1.0 / (number * unit_in_s(unit))).round())
                ),
                _ => format!(
                    "frames per second are a number without a unit: write {}",
                    number_value(number)
                ),
            })
        }
        None => Err(NO_FPS.to_owned()),
    }
}

fn unit_in_s(unit: &str) -> f64 {
    match unit {
        "us" => 1e-6,
        "ms" => 1e-3,
        _ => 1.0,
    }
}

pub(super) fn fps_value(fps: &Fps) -> Value {
    match fps {
        Fps::PerSecond(number) => number_value(*number),
        Fps::Max => Value::String("max".to_owned()),
        Fps::Auto => Value::String("auto".to_owned()),
    }
}

pub(super) fn size(value: &Value) -> Result<Option<[u32; 2]>, String> {
    if value.as_str() == Some("auto") {
        return Ok(None);
    }
    let sides: Vec<Option<u32>> = match value {
        Value::Array(sides) => sides
            .iter()
            .map(|side| u32::try_from(side.as_integer()?).ok())
            .collect(),
        Value::String(text) => text
            .split(['x', 'X', '×'])
            .map(|side| side.trim().parse().ok())
            .collect(),
        _ => Vec::new(),
    };
    match sides[..] {
        [Some(width), Some(height)]
            if (64..=8192).contains(&width) && (64..=8192).contains(&height) =>
        {
            Ok(Some([width, height]))
        }
        _ => Err(
            "a size is width and height in pixels, each 64 to 8192: [640, 480] in the file, 640x480 as a \
             flag; or \"auto\""
            .to_owned(),
        ),
    }
}

pub(super) fn size_value(size: &Option<[u32; 2]>) -> Value {
    match size {
        Some(size) => Value::Array(size.map(|side| side.into()).map(Value::Integer).into()),
        None => Value::String("auto".to_owned()),
    }
}

/// Parses the size of images as a flag gives it.
pub fn image_size(text: &str) -> Result<[u32; 2], String> {
    size(&Value::String(text.to_owned()))?
        .ok_or_else(|| "a size of its own is needed, as 640x480".to_owned())
}

pub(super) fn position(value: &Value) -> Result<[f32; 2], String> {
    let of_flag = |text: &str| {
        let (x, y) = text.split_once(',')?;
        Some([x.trim().parse().ok()?, y.trim().parse().ok()?])
    };
    match pair(value).or(value.as_str().and_then(of_flag)) {
        Some([x, y]) if x.abs() < 1e6 && y.abs() < 1e6 => Ok([x as f32, y as f32]),
        _ => {
            Err("a position is two numbers of pixels: [x, y] in the file, X,Y as a flag".to_owned())
        }
    }
}

pub(super) fn position_value(position: &[f32; 2]) -> Value {
    Value::Array(position.map(|c| number_value(c.into())).into())
}

pub(super) fn positions(value: &Value) -> Result<Vec<[f32; 2]>, String> {
    let listed = match value {
        Value::Array(positions) => positions.iter().map(position).collect(),
        Value::String(text) => {
            let numbers: Vec<&str> = text.split(',').collect();
            let pairs = numbers.chunks(2).map(|pair| Value::String(pair.join(",")));
            pairs.map(|pair| position(&pair)).collect()
        }
        _ => Err(String::new()),
    };
    listed.map_err(|_: String| {
        "positions are two numbers of pixels each: [[x, y], [x, y]] in the file, X,Y,X,Y as a flag"
            .to_owned()
    })
}

/// Parses positions in an image as a flag gives them: `X,Y`, or several separated by commas.
pub fn image_positions(text: &str) -> Result<Vec<[f32; 2]>, String> {
    positions(&Value::String(text.to_owned()))
}

pub(super) fn positions_value(positions: &[[f32; 2]]) -> Value {
    Value::Array(positions.iter().map(position_value).collect())
}

/// Returns two finite numbers.
fn pair(value: &Value) -> Option<[f64; 2]> {
    match value.as_array().map(Vec::as_slice) {
        Some([a, b]) => Some([number(a)?, number(b)?]).filter(|p| p.iter().all(|x| x.is_finite())),
        _ => None,
    }
}

pub(super) fn control_points(value: &Value) -> Result<ControlPoints, String> {
    match value.as_str() {
        Some("auto") => Ok(ControlPoints::Auto),
        Some(text) if text.trim().parse::<i64>().is_err() => Err(format!(
            "write a whole number from 2 to {MAX_CONTROL_POINTS}, or \"auto\""
        )),
        _ => whole(value, 2, MAX_CONTROL_POINTS as i64)
            .map(|n| ControlPoints::Named(n.unsigned_abs() as usize)),
    }
}

pub(super) fn control_points_value(control_points: &ControlPoints) -> Value {
    match control_points {
        ControlPoints::Named(count) => Value::Integer(*count as i64),
        ControlPoints::Auto => Value::String("auto".to_owned()),
    }
}

pub(super) fn mask(value: &Value) -> Result<Mask, String> {
    match value {
        Value::String(name) if name == "auto" => Ok(Mask::Auto),
        Value::String(name) if name == "network" => Ok(Mask::Network),
        Value::String(name) if name == "external" => Ok(Mask::External),
        Value::Array(ranges) if !ranges.is_empty() => {
            let ranges: Result<Vec<_>, _> = ranges.iter().map(hsv_range).collect();
            Ok(Mask::Hsv(ranges?))
        }
        Value::Table(_) => Ok(Mask::Hsv(vec![hsv_range(value)?])),
        _ => Err(
            "write \"auto\", \"network\", \"external\" or a list of ranges: [{ hue_deg = [190, 250], saturation = [0.3, 1], value = \
             [0.2, 1] }] (a folder of masks is `lariat trace --masks DIR`)"
                .to_owned(),
        ),
    }
}

pub(super) fn mask_level(value: &Value) -> Result<Option<NonZeroU8>, String> {
    match value.as_str() {
        Some("auto") => Ok(None),
        Some(text) if text.trim().parse::<i64>().is_err() => {
            Err("a level is a whole number from 1 to 255, or \"auto\"".to_owned())
        }
        _ => whole(value, 1, 255).map(|n| u8::try_from(n).ok().and_then(NonZeroU8::new)),
    }
}

pub(super) fn mask_level_value(level: &Option<NonZeroU8>) -> Value {
    match level {
        Some(level) => Value::Integer(i64::from(level.get())),
        None => Value::String("auto".to_owned()),
    }
}

/// The channels of a range and the maxima of their scales.
const CHANNELS: [(&str, f64); 3] = [("hue_deg", 360.0), ("saturation", 1.0), ("value", 1.0)];

fn hsv_range(value: &Value) -> Result<HsvRange, String> {
    let Some(range) = value.as_table() else {
        return Err(
            "a range is { hue_deg = [a, b], saturation = [a, b], value = [a, b] }".to_owned(),
        );
    };
    let names = || CHANNELS.iter().map(|(name, _)| *name);
    if let Some(unknown) = range.keys().find(|key| !names().any(|name| name == *key)) {
        let guess = nearest(unknown, names())
            .map_or(String::new(), |near| format!("Did you mean \"{near}\"? "));
        return Err(format!(
            "a range has no \"{unknown}\". {guess}It has hue_deg, saturation and value"
        ));
    }
    // A missing channel is unrestricted.
    let bounds = |index: usize| {
        let (name, limit) = CHANNELS[index];
        range
            .get(name)
            .map_or(Ok([0.0, limit as f32]), |value| channel(index, value))
    };
    Ok(HsvRange {
        hue_deg: bounds(0)?,
        saturation: bounds(1)?,
        value: bounds(2)?,
    })
}

fn channel(index: usize, value: &Value) -> Result<[f32; 2], String> {
    let (name, limit) = CHANNELS[index];
    let Some([a, b]) = pair(value) else {
        return Err(format!(
            "{name} is a pair of numbers from 0 to {limit}: [a, b]"
        ));
    };
    let is_hue = index == 0;
    if a < 0.0 || b < 0.0 || a.max(b) > limit {
        let opencv = a.min(b) >= 0.0 && a.max(b) <= 255.0;
        return Err(if !is_hue && opencv {
            let share = |x: f64| number_value((x / 255.0 * 100.0).round() / 100.0);
            format!(
                "{name} goes from 0 to 1: OpenCV's 0 to 255 is divided by 255, so write {name} = [{}, {}] \
                 (and OpenCV's hue is doubled to degrees)",
                share(a),
                share(b)
            )
        } else {
            format!("{name} goes from 0 to {limit}")
        });
    }
    if a > b && !is_hue {
        return Err(format!(
            "{name} = [{a}, {b}] is turned around: put the smaller first, {name} = [{b}, {a}] (only a hue \
             may go through its end)"
        ));
    }
    Ok([a as f32, b as f32])
}

/// Formats a mask setting as in the file.
pub fn mask_text(mask: &Mask) -> String {
    mask_value(mask).to_string()
}

pub(super) fn mask_value(mask: &Mask) -> Value {
    let ranges = match mask {
        Mask::Auto => return Value::String("auto".to_owned()),
        Mask::Network => return Value::String("network".to_owned()),
        Mask::External => return Value::String("external".to_owned()),
        Mask::Hsv(ranges) => ranges,
    };
    // Convert through decimal text, so that 0.3 as f32 is not shown with its digits as f64.
    let shown = |x: f32| number_value(x.to_string().parse().unwrap_or(f64::from(x)));
    let bounds = |pair: [f32; 2]| Value::Array(pair.map(shown).into());
    let range = |range: &HsvRange| {
        Value::Table(toml::Table::from_iter([
            ("hue_deg".to_owned(), bounds(range.hue_deg)),
            ("saturation".to_owned(), bounds(range.saturation)),
            ("value".to_owned(), bounds(range.value)),
        ]))
    };
    Value::Array(ranges.iter().map(range).collect())
}

/// Returns the name that was probably meant: one with the same beginning, or with at most two
/// different letters.
pub fn nearest<'a>(given: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let given = given.to_lowercase();
    known
        .map(|name| {
            let begins_alike =
                given.len() >= 3 && (name.starts_with(&given) || given.starts_with(name));
            let distance = match begins_alike {
                true => 0,
                false => strsim::levenshtein(&given, &name.to_lowercase()),
            };
            (distance, name)
        })
        .filter(|(distance, name)| *distance <= 2 && *distance < name.len() - 1)
        .min()
        .map(|(_, name)| name)
}
