//! `lariat devices`: the cameras of this machine and their capabilities.
//!
//! Without a camera, the command prints a sentence to standard error and exits with status 1, as
//! `v4l2-ctl --list-devices` does, so that scripts can detect this. With `--json` the list is
//! empty, and the status is the same.

mod text;

use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use lariat_capture::{
    AboutCamera, Control, FormatOffer, ListedCamera, Rates, SizeRange, list_cameras,
};
use serde::Serialize;

use crate::versioned::Versioned;
use lariat_chain::output::print;

/// List this machine's cameras: names, formats, sizes, rates and controls
#[derive(Debug, Args)]
pub(crate) struct DevicesArgs {
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Advice for a machine without a camera.
const NONE: &str = "lariat: no camera found on this machine. Plug one in and try again. If that does not help, see \
                    `dmesg | tail`. A virtual machine or container needs /dev/video0 passed through. Until then, \
                    `lariat run` shows a drawn rope.";

/// Runs `lariat devices`.
///
/// # Errors
/// Returns an error if the list cannot be written.
pub(crate) fn run(args: DevicesArgs) -> Result<ExitCode> {
    let cameras = list_cameras();
    let text = if args.json {
        let list = List {
            cameras: cameras.iter().map(Camera::of).collect(),
        };
        serde_json::to_string_pretty(&Versioned::first(list))? + "\n"
    } else {
        cameras
            .iter()
            .map(text::describe)
            .collect::<Vec<_>>()
            .join("\n")
    };
    print(&text)?;
    Ok(if cameras.is_empty() {
        eprintln!("{NONE}");
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

#[derive(Serialize)]
struct List {
    cameras: Vec<Camera>,
}

#[derive(Serialize)]
struct Camera {
    path: String,
    /// Names that remain valid when the path's number changes.
    lasting_names: Vec<String>,
    /// Reason why the camera cannot be queried. If set, the following fields are missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
    #[serde(flatten)]
    about: Option<About>,
}

#[derive(Serialize)]
struct About {
    name: String,
    driver: String,
    bus: String,
    multi_planar: bool,
    formats: Vec<Format>,
    controls: Vec<Setting>,
}

#[derive(Serialize)]
struct Format {
    code: String,
    description: String,
    compressed: bool,
    /// True if lariat can read this format.
    readable: bool,
    sizes: Vec<Size>,
}

#[derive(Serialize)]
struct Size {
    /// Width and height; for a range of sizes, the largest.
    size: [u32; 2],
    /// Smallest size, and the step between sizes; only for a range of sizes.
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<[u32; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<[u32; 2]>,
    /// Frame rates, the fastest first; empty if the driver does not report any. For a range of
    /// sizes: at the size nearest to 640x480.
    fps: Vec<f64>,
    /// True if all rates between the first and the last are available, too.
    fps_is_a_range: bool,
}

#[derive(Serialize)]
struct Setting {
    name: String,
    kind: String,
    value: Option<i64>,
    default: i64,
    minimum: i64,
    maximum: i64,
    step: i64,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    items: Vec<(i64, String)>,
    read_only: bool,
    inactive: bool,
}

impl Camera {
    fn of(camera: &ListedCamera) -> Self {
        Self {
            path: camera.path.display().to_string(),
            lasting_names: (camera.lasting_names.iter())
                .map(|name| name.display().to_string())
                .collect(),
            problem: camera.about.as_ref().err().map(ToString::to_string),
            about: camera.about.as_ref().ok().map(About::of),
        }
    }
}

impl About {
    fn of(about: &AboutCamera) -> Self {
        Self {
            name: about.name.clone(),
            driver: about.driver.clone(),
            bus: about.bus.clone(),
            multi_planar: about.has_planes,
            formats: about.formats.iter().map(Format::of).collect(),
            controls: about.controls.iter().map(Setting::of).collect(),
        }
    }
}

impl Format {
    fn of(format: &FormatOffer) -> Self {
        let size = |offer: &lariat_capture::SizeOffer| {
            let (size, from, step) = match offer.range {
                SizeRange::One(size) => (size, None, None),
                SizeRange::Steps { least, most, step } => (most, Some(least), Some(step)),
            };
            Size {
                size,
                from,
                step,
                fps: rates(&offer.rates),
                fps_is_a_range: matches!(offer.rates, Rates::Between { .. }),
            }
        };
        Self {
            code: format.code.to_string(),
            description: format.description.clone(),
            compressed: format.compressed,
            readable: format.code.is_readable(),
            sizes: format.sizes.iter().map(size).collect(),
        }
    }
}

/// Frame rates, the fastest first.
fn rates(rates: &Rates) -> Vec<f64> {
    let mut fps: Vec<_> = match rates {
        Rates::Untold => Vec::new(),
        Rates::Listed(all) => all.iter().map(|interval| interval.fps()).collect(),
        Rates::Between { shortest, longest } => vec![shortest.fps(), longest.fps()],
    };
    fps.sort_by(|a, b| b.total_cmp(a));
    fps
}

impl Setting {
    fn of(control: &Control) -> Self {
        Self {
            name: control.name.clone(),
            kind: control.kind.to_string(),
            value: control.value,
            default: control.default,
            minimum: control.minimum,
            maximum: control.maximum,
            step: control.step,
            items: control.items.clone(),
            read_only: control.read_only,
            inactive: control.inactive,
        }
    }
}
