//! Takes a camera's calibration from its `camera_info`, writes it in the format of ROS's
//! `camera_calibration`, and gives it to the chain.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use lariat_camera::Camera;
use lariat_chain::control::{Asked, ask};
use lariat_chain::output::{Existing, Output};
use lariat_wire::Rig;

use super::pixels::shown;
use super::received::{CameraInfo, Region};
use super::trouble::Tally;

/// Marks a file as ours, which may be replaced.
const MARK: &str = "# Written by lariat ros2";

/// Minimum time between two calibrations, because each is written to a file and read by the chain.
const APART: Duration = Duration::from_secs(1);

/// Handler of received calibrations.
pub(super) struct Calibration {
    topic: String,
    rig: Rig,
    path: PathBuf,
    /// Text and time of the last calibration, so that each calibration is used only once.
    taken: Option<(String, Instant)>,
    tally: Arc<Tally>,
    said: Option<String>,
}

impl Calibration {
    pub(super) fn new(topic: &str, rig: &Rig, path: Option<&Path>, tally: Arc<Tally>) -> Self {
        let usual = || PathBuf::from(format!("{rig}_camera.yaml"));
        Self {
            topic: topic.to_owned(),
            rig: rig.clone(),
            path: path.map_or_else(usual, Path::to_owned),
            taken: None,
            tally,
            said: None,
        }
    }

    /// Uses the first calibration and each one that differs from the previous one. One that arrives
    /// too soon is ignored: a camera sends its calibration with every image.
    pub(super) fn take(&mut self, info: &CameraInfo) {
        let done = yaml(info).and_then(|text| match &self.taken {
            Some((taken, at)) if *taken == text || at.elapsed() < APART => Ok(()),
            _ => {
                self.put(&text)?;
                self.taken = Some((text, Instant::now()));
                Ok(())
            }
        });
        match done {
            Ok(()) => self.tally.take(),
            Err(cause) => self.refuse(format!("{cause:#}")),
        }
    }

    /// Counts an invalid calibration, and reports the problem when it changes.
    pub(super) fn refuse(&mut self, trouble: String) {
        self.tally.refuse();
        if self.said.as_ref() != Some(&trouble) {
            eprintln!("lariat-ros2: {}: {trouble}", self.topic);
            self.said = Some(trouble);
        }
    }

    /// Writes the file, and makes the chain use it if one runs.
    fn put(&self, text: &str) -> Result<()> {
        let path = std::path::absolute(&self.path)?;
        let existing = match std::fs::read_to_string(&path) {
            Ok(there) if there.starts_with(MARK) => Existing::Replace,
            Ok(_) => bail!(
                "{} is a file of somebody else's, and is not overwritten: name another one with --calibration-out",
                path.display()
            ),
            Err(_) => Existing::Keep,
        };
        let marked = format!("{MARK} from {}.\n{text}", self.topic);
        Output::new(&path, existing, [])?.write(marked.as_bytes())?;
        let (rig, shown) = (self.rig.clone(), path.display().to_string());
        // The chain may take a moment to answer, and images arrive meanwhile.
        std::thread::Builder::new()
            .name("calibration".to_owned())
            .spawn(move || {
                let change = format!("camera.calibration={shown}");
                let outcome = match ask(rig.as_str(), &Asked::Set(vec![change])) {
                    Ok(_) => "the chain goes by it now".to_owned(),
                    Err(cause) => format!(
                        "give it to the chain: `lariat run --rig {rig} --source external --calibration {shown}` ({cause:#})"
                    ),
                };
                eprintln!("lariat-ros2: the camera's calibration is in {shown}; {outcome}");
            })
            .context("no thread could be started")?;
        Ok(())
    }
}

/// Formats the calibration as a file.
///
/// # Errors
/// The calibration is missing or of a kind that lariat does not support.
fn yaml(info: &CameraInfo) -> Result<String> {
    if info.k == [0.0; 9] {
        bail!("the camera is not calibrated: its K is 0");
    }
    let is_plain = info.distortion_model.is_empty() && info.d.is_empty();
    let (model, d) = if is_plain {
        ("plumb_bob", &[0.0; 5][..])
    } else {
        (&*info.distortion_model, &info.d[..])
    };
    // A word from another node must not inject a key.
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !model.chars().all(is_word) {
        bail!("the distortion model {} is not known", shown(model));
    }
    let mut text = format!(
        "image_width: {}\nimage_height: {}\ncamera_name: camera\ndistortion_model: {model}\n",
        info.width, info.height
    );
    for (name, [rows, columns], numbers) in [
        ("camera_matrix", [3, 3], &info.k[..]),
        ("distortion_coefficients", [1, d.len()], d),
        ("rectification_matrix", [3, 3], &info.r),
        ("projection_matrix", [3, 4], &info.p),
    ] {
        let numbers: Vec<String> = numbers.iter().map(|x| format!("{x:?}")).collect();
        let _ = writeln!(
            text,
            "{name}:\n  rows: {rows}\n  cols: {columns}\n  data: [{}]",
            numbers.join(", ")
        );
    }
    let Region {
        x_offset,
        y_offset,
        width,
        height,
        ..
    } = info.roi;
    let _ = write!(
        text,
        "binning_x: {}\nbinning_y: {}\nroi:\n  x_offset: {x_offset}\n  y_offset: {y_offset}\n  width: {width}\n  height: {height}\n",
        info.binning_x, info.binning_y
    );
    Camera::from_yaml(&text)?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::incoming::received::tests::camera_info;

    #[test]
    fn what_is_written_is_the_camera_that_came() {
        let text = yaml(&camera_info()).expect("a calibration");
        let camera = Camera::from_yaml(&text).expect("it is read again");
        assert_eq!(camera.focal_px(), [600.5, 601.25]);
        assert_eq!(camera.center_px(), [320.0, 239.5]);
        assert_eq!(camera.size(), Some([640, 480]));
        let seen = camera.distort([100.0, 50.0]).expect("in the picture");
        assert!((seen.point[0] - 100.0).abs() > 1.0, "it is distorted");
    }

    #[test]
    fn pictures_of_a_region_of_the_sensor_and_binned_ones_have_their_center_moved() {
        let mut info = camera_info();
        info.roi = Region {
            x_offset: 120,
            y_offset: 40,
            width: 400,
            height: 400,
            do_rectify: true,
        };
        info.binning_x = 2;
        info.binning_y = 2;
        let text = yaml(&info).expect("a calibration");
        let camera = Camera::from_yaml(&text).expect("it is read again");
        let camera = camera.scaled_to([200, 200]).expect("its own frames");
        assert_eq!(camera.focal_px(), [300.25, 300.625]);
        assert_eq!(camera.center_px(), [99.75, 99.5]);
    }

    #[test]
    fn what_is_no_calibration_is_refused_with_a_sentence() {
        let refused = |change: &dyn Fn(&mut CameraInfo), word: &str| {
            let mut info = camera_info();
            change(&mut info);
            let said = format!("{:#}", yaml(&info).expect_err(word));
            assert!(said.contains(word), "{said}");
        };
        refused(&|info| info.k = [0.0; 9], "not calibrated");
        refused(&|info| info.roi.x_offset = 600, "no part of the image");
        refused(&|info| info.distortion_model = "fov".into(), "lens models");
        refused(
            &|info| info.distortion_model = "x\ncamera_matrix: 1".into(),
            "not known",
        );
        refused(&|info| info.d = vec![0.1; 3], "coefficients");
        refused(&|info| info.k[0] = f64::NAN, "finite");
    }
}
