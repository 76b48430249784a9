//! What the page asks for beside pictures: the settings of the running chain, changes of them, and the colours of a rope.

use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use lariat_chain::bounded;
use lariat_chain::control::{Asked, ask};
use lariat_chain::output::{Existing, Output};
use lariat_chain::pipeline::FrameView;
use lariat_chain::settings::{Settings, mask_text, with_changes};
use lariat_extract::{Mask, judge_pick, mask_of, pick};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::calibrating::Point;
use crate::moment::Moment;

/// Changes in one wish, and points on ropes.
const MOST_CHANGES: usize = 64;
const MOST_POINTS: usize = 32;
/// Below this agreement colour does not tell the rope from the rest.
const GOOD: f32 = 0.7;

/// What the page asks for.
#[derive(Debug, Deserialize)]
#[serde(tag = "wish", rename_all = "snake_case")]
pub(crate) enum Wish {
    /// The settings that hold.
    Settings,
    /// That settings hold from now on, each written as `section.name=value`.
    Set {
        /// As `lariat set` takes them.
        changes: Vec<String>,
    },
    /// That they are written into the chain's settings file.
    Keep {
        /// Likewise.
        changes: Vec<String>,
    },
    /// The colours of what lies at these points of a moment; without points, of the ropes that stand out by themselves.
    Pick {
        /// The moment's number.
        number: u64,
        /// In pixels.
        at: Vec<[f32; 2]>,
    },
    /// What the table's plane would be by these points, in pictures of this size ([`calibrating`](crate::calibrating)).
    Plane {
        /// Four or more.
        points: Vec<Point>,
        /// Width and height.
        size: [u32; 2],
    },
    /// That it is written, and used from now on.
    WritePlane {
        /// Likewise.
        points: Vec<Point>,
        /// Likewise.
        size: [u32; 2],
    },
    /// That a mask, as the settings have it, is drawn with each moment from now on; none: no mask.
    Mask {
        /// Of colours.
        mask: Option<String>,
    },
}

impl Wish {
    /// Whether it changes something outside of the page.
    pub(crate) fn writes(&self) -> bool {
        matches!(
            self,
            Self::Set { .. } | Self::Keep { .. } | Self::WritePlane { .. }
        )
    }
}

/// Asks the chain of a rig, or writes into its settings file.
///
/// # Errors
/// What was wrong, as a sentence.
pub(crate) fn of_chain(rig: &str, wish: &Wish) -> Result<Value> {
    match wish {
        Wish::Settings => {
            let text = ask(rig, &Asked::Settings)?;
            let table: toml::Table = text.parse().context("the chain's settings are not TOML")?;
            Ok(serde_json::to_value(table)?)
        }
        Wish::Set { changes } => {
            check(changes)?;
            Ok(ask(rig, &Asked::Set(changes.clone()))?.trim_end().into())
        }
        Wish::Keep { changes } => {
            check(changes)?;
            // Only what the chain starts with.
            ask(rig, &Asked::Set(changes.clone()))?;
            let file = PathBuf::from(ask(rig, &Asked::File)?.trim_end());
            let text = match bounded::read(&file, bounded::LONGEST_TEXT) {
                Ok(bytes) => String::from_utf8(bytes).context("the settings file is not text")?,
                Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => String::new(),
                Err(cause) => {
                    return Err(cause).with_context(|| format!("cannot read {}", file.display()));
                }
            };
            let text = with_changes(&text, changes)?;
            Settings::of_text(&text)
                .with_context(|| format!("{} would not be read again", file.display()))?;
            Output::new(&file, Existing::forced(true), [])?.write(text.as_bytes())?;
            Ok(format!("written into {}", file.display()).into())
        }
        _ => bail!("this is not the chain's to answer"),
    }
}

fn check(changes: &[String]) -> Result<()> {
    ensure!(
        changes.len() <= MOST_CHANGES,
        "at most {MOST_CHANGES} settings are changed at a time"
    );
    // Each is a line of what the chain is asked.
    let is_line = changes
        .iter()
        .all(|change| !change.contains(char::is_control));
    ensure!(
        is_line,
        "a change is one line, such as fit.control_points=7"
    );
    Ok(())
}

/// The colours at these points of a picture: the answer, and the mask to be drawn.
///
/// # Errors
/// There is no picture, or no rope at a point.
pub(crate) fn colours(moment: &Moment, at: &[[f32; 2]]) -> Result<(Value, Mask)> {
    ensure!(
        at.len() <= MOST_POINTS,
        "at most {MOST_POINTS} points are looked at"
    );
    let frame = moment.image.as_ref().context("this frame has no picture")?;
    let image = FrameView::new(&frame.header, &frame.bytes).image()?;
    let picked = pick(&image, at)?;
    let doubt = judge_pick(&image, &picked.ranges, at)
        .doubt
        .map(|doubt| doubt.to_string());
    let doubt = doubt.or_else(|| {
        (picked.agreement < GOOD).then(|| {
            format!(
                "colour alone tells this rope from the rest in {:.0} % only: look at the mask before you use it",
                100.0 * picked.agreement
            )
        })
    });
    let mask = Mask::Hsv(picked.ranges);
    let answer = json!({ "mask": mask_text(&mask), "agreement": picked.agreement, "doubt": doubt });
    Ok((answer, mask))
}

/// A mask of colours, as the settings have it.
///
/// # Errors
/// It is none.
pub(crate) fn mask(text: &str) -> Result<Mask> {
    ensure!(!text.contains(char::is_control), "a mask is one line");
    match Settings::of_text(&format!("[extract]\nmask = {text}\n"))?
        .extract
        .mask
    {
        mask @ Mask::Hsv(_) => Ok(mask),
        _ => bail!("only a mask of colours can be drawn"),
    }
}

/// What of a moment's picture is in a mask, as a PNG of the picture's size; `None` without a picture.
pub(crate) fn drawn(moment: &Moment, mask: &Mask) -> Option<Vec<u8>> {
    let frame = moment.image.as_ref()?;
    let image = FrameView::new(&frame.header, &frame.bytes).image().ok()?;
    let pixels = mask_of(&image, mask);
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, CompressionType::Fast, FilterType::NoFilter)
        .write_image(
            &pixels,
            frame.header.width,
            frame.header.height,
            ExtendedColorType::L8,
        )
        .ok()?;
    Some(png)
}
