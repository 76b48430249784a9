//! Requests of the page other than pictures: the settings of the running chain, changes of them,
//! and the colors of a rope.

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

/// Maximum number of changes in one request, and of points on ropes.
const MOST_CHANGES: usize = 64;
const MOST_POINTS: usize = 32;
/// Agreement below which color alone does not distinguish the rope from the rest.
const GOOD: f32 = 0.7;

/// A request of the page.
#[derive(Debug, Deserialize)]
#[serde(tag = "wish", rename_all = "snake_case")]
pub(crate) enum Wish {
    /// Returns the current settings.
    Settings,
    /// Changes settings from now on, each written as `section.name=value`.
    Set {
        /// Changes, as `lariat set` takes them.
        changes: Vec<String>,
    },
    /// Writes settings into the chain's settings file.
    Keep {
        /// Changes, as `lariat set` takes them.
        changes: Vec<String>,
    },
    /// Finds the colors at these points of a moment; without points, finds the colors of the ropes
    /// that stand out.
    Pick {
        /// Number of the moment.
        number: u64,
        /// Points, in pixels.
        at: Vec<[f32; 2]>,
    },
    /// Judges the table's plane from these points, in pictures of this size
    /// ([`calibrating`](crate::calibrating)).
    Plane {
        /// Four points or more.
        points: Vec<Point>,
        /// Width and height.
        size: [u32; 2],
    },
    /// Writes the table's plane, and uses it from now on.
    WritePlane {
        /// Four points or more.
        points: Vec<Point>,
        /// Width and height.
        size: [u32; 2],
    },
    /// Draws a mask with each moment from now on, or none.
    Mask {
        /// A mask of colors, as the settings have it.
        mask: Option<String>,
    },
}

impl Wish {
    /// Returns whether the request changes something outside of the page.
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
/// Fails with a sentence that says what is wrong.
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
            // Write only what the chain accepts.
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
    // Each change is one line of the request to the chain.
    let is_line = changes
        .iter()
        .all(|change| !change.contains(char::is_control));
    ensure!(
        is_line,
        "a change is one line, such as fit.control_points=7"
    );
    Ok(())
}

/// Finds the colors at these points of a picture. Returns the answer, and the mask to draw.
///
/// # Errors
/// Fails without a picture, or if a point is not on a rope.
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

/// Parses a mask of colors, as the settings have it.
///
/// # Errors
/// Fails if the text is not such a mask.
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

/// Returns the part of a moment's picture that is in a mask, as a PNG of the picture's size; `None`
/// without a picture.
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
