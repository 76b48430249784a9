//! The table's plane, from points that were clicked in the picture. The server judges the points as
//! they are added. Then it writes the plane into the file that `[camera] plane` of the chain names,
//! and the chain reads that file.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use lariat_camera::Pair;
use lariat_chain::calibrated::read_camera;
use lariat_chain::control::{Asked, ask};
use lariat_chain::measured_plane::{Grid, MeasuredPlane, Off};
use lariat_chain::output::{Existing, Output};
use lariat_chain::settings::{self, settings_of};
use lariat_wire::members;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::gather::stage_of;

/// Maximum number of points; a page shows no more.
const MOST_POINTS: usize = 64;
/// Name of a new plane's file, next to the settings file.
const FILE_NAME: &str = "plane.toml";

/// A point that was clicked and measured.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Point {
    /// Position in the picture, px.
    pixel: [f64; 2],
    /// Position on the table, mm.
    mm: [f64; 2],
}

/// Judges the plane of these points, in pictures of this size. Returns each point's error, the size
/// of a pixel, and a grid to draw.
///
/// # Errors
/// Fails with a sentence that says why, if the points do not determine a plane.
pub(crate) fn judge(rig: Option<&str>, points: &[Point], size: [u32; 2]) -> Result<Value> {
    let lens = rig.map(Lens::of).transpose()?.unwrap_or_default();
    let measured = lens.measured(points, size)?;
    let Grid { step_mm, lines } = measured.grid();
    let short = |px: f64| (px * 10.0).round() / 10.0;
    let lines: Vec<Vec<_>> = (lines.into_iter())
        .map(|line| line.into_iter().map(|at| at.map(short)).collect())
        .collect();
    let middle = measured.mapping().size().map(|side| 0.5 * f64::from(side));
    let [rms_mm, most_mm] = measured.error_mm().map_or([None; 2], |both| both.map(Some));
    Ok(json!({
        "off": measured.off().map(|Off { mm, px }| [mm, px]).collect::<Vec<_>>(),
        "rms_mm": rms_mm,
        "most_mm": most_mm,
        "mm_per_px": measured.mapping().unit_per_px(middle).ok(),
        "grid": { "step_mm": step_mm, "lines": lines },
        "undistorted": lens.camera.calibration.is_some(),
    }))
}

/// Writes the plane of these points into the file that the rig's chain uses, and makes the chain
/// read it. Returns what was done, and the change of the settings.
///
/// # Errors
/// Fails if the points do not determine a plane, if the file cannot be written or is not the
/// chain's, or if the chain refuses it.
pub(crate) fn write(rig: &str, points: &[Point], size: [u32; 2]) -> Result<Value> {
    let lens = Lens::of(rig)?;
    let text = lens
        .measured(points, size)?
        .file_text("the points clicked in `lariat view`");
    let (path, existing) = match &lens.camera.plane {
        Some(named) => (named.clone(), Existing::Replace),
        None => {
            let settings = PathBuf::from(ask(rig, &Asked::File)?.trim_end());
            (settings.with_file_name(FILE_NAME), Existing::Keep)
        }
    };
    let change = format!("camera.plane={}", quoted(&path)?);
    let inputs = lens.camera.calibration.as_deref();
    if existing == Existing::Keep && path.exists() {
        bail!(
            "{} is there already, and is not the chain's plane: move it away, or name it as the chain's by `lariat set \
             camera.plane=…` to have it overwritten",
            path.display()
        );
    }
    Output::new(&path, existing, inputs)?.write(text.as_bytes())?;
    let said = ask(rig, &Asked::Set(vec![change.clone()]))
        .with_context(|| format!("the plane is in {}, but the chain", path.display()))?;
    Ok(json!({
        "said": format!("written into {}; {}", path.display(), said.trim_end()),
        "change": change,
    }))
}

/// Lens and plane of a rig's fit.
#[derive(Default)]
struct Lens {
    camera: settings::Camera,
}

impl Lens {
    /// Returns the settings of the rig's fit, or defaults if no fit runs.
    fn of(rig: &str) -> Result<Self> {
        let members = members()?;
        Ok(match stage_of(&members, rig, "fit") {
            Some(fit) => Self {
                camera: settings_of(fit)?.camera,
            },
            None => Self::default(),
        })
    }

    fn measured(&self, points: &[Point], size: [u32; 2]) -> Result<MeasuredPlane> {
        ensure!(
            points.len() <= MOST_POINTS,
            "at most {MOST_POINTS} points are taken"
        );
        ensure!(!size.contains(&0), "there is no picture to click points in");
        let camera = self.camera.calibration.as_deref().map(read_camera);
        let camera = camera.transpose()?;
        let pairs: Vec<Pair> = (points.iter())
            .map(|&Point { pixel, mm }| Pair {
                pixel,
                plane_mm: mm,
            })
            .collect();
        MeasuredPlane::of(&pairs, camera.as_ref(), size)
    }
}

/// Quotes a path for a settings file.
fn quoted(path: &Path) -> Result<String> {
    let path = path.to_str().with_context(|| {
        format!(
            "{} cannot be written to a settings file: it is not text",
            path.display()
        )
    })?;
    // JSON's escapes are TOML's too.
    Ok(Value::from(path).to_string())
}
