//! Determines the 3-D points of centerlines from a depth image or a second view.

use super::covered::Covered;
use crate::calibrated::Beside;
use crate::pipeline::FrameView;
use anyhow::{Context, Result, bail};
use lariat_camera::{
    DepthCalibration, DepthImage, NoDepth, NoSecondView, RopeDepth, RopeViews, SecondCalibration,
    SeenRope, SpacePoint,
};
use lariat_wire::{Centerlines, Curve, PixelFormat, Place, Status};

/// Additional input for a frame's centerlines.
#[derive(Clone, Copy)]
pub enum Companion<'a> {
    /// A depth image.
    Depth(FrameView<'a>),
    /// The centerlines of a second color camera at the same moment.
    Second(&'a Centerlines),
}

/// Determines 3-D points, frame by frame.
pub(super) struct Finder {
    kind: Kind,
    covered: Covered,
}

enum Kind {
    Depth {
        calibration: DepthCalibration,
        ropes: RopeDepth,
    },
    Second {
        calibration: SecondCalibration,
        ropes: RopeViews,
    },
}

/// A frame's companion, prepared for use.
pub(super) enum Shown<'a> {
    Depth(DepthImage<'a>),
    Second,
}

impl Finder {
    pub(super) fn new(beside: Beside) -> Self {
        let kind = match beside {
            Beside::Depth(calibration) => Kind::Depth {
                ropes: RopeDepth::new(calibration.camera),
                calibration,
            },
            Beside::Second(calibration) => Kind::Second {
                ropes: RopeViews::new(calibration.cameras),
                calibration,
            },
        };
        Self {
            kind,
            covered: Covered::default(),
        }
    }

    /// Returns the focal length of the first camera, px.
    pub(super) fn focal_px(&self) -> f64 {
        match &self.kind {
            Kind::Depth { calibration, .. } => calibration.camera.color_focal_px(),
            Kind::Second { calibration, .. } => calibration.cameras.focal_px(),
        }
    }

    /// Prepares the companion of a frame.
    ///
    /// # Errors
    /// Returns an error if the companion does not match the calibration.
    pub(super) fn look<'a>(
        &mut self,
        seen: &Centerlines,
        companion: Companion<'a>,
    ) -> Result<Shown<'a>> {
        match (&mut self.kind, companion) {
            (Kind::Depth { calibration, .. }, Companion::Depth(view)) => {
                check_size(calibration.camera.color_size(), seen, "frames")?;
                depth_image(calibration, view).map(Shown::Depth)
            }
            (Kind::Second { calibration, ropes }, Companion::Second(second)) => {
                let [size, beside] = calibration.cameras.sizes();
                check_size(size, seen, "frames")?;
                check_size(beside, second, "frames of the second camera")?;
                ropes.clear();
                for (i, curve) in seen.curves().iter().enumerate() {
                    // A lost rope is not visible, so it cannot match one in the second view.
                    let curve = match curve.status() {
                        Some(Status::Lost) => &Curve::EMPTY,
                        _ => curve,
                    };
                    ropes.add_first(&rope(&mut self.covered, seen, i, curve));
                }
                for (i, curve) in second.curves().iter().enumerate() {
                    if curve.status() != Some(Status::Lost) {
                        ropes.add_second(&rope(&mut self.covered, second, i, curve));
                    }
                }
                ropes.pair();
                Ok(Shown::Second)
            }
            _ => bail!("a depth image is not a second view: restart the fit stage"),
        }
    }

    /// Determines the 3-D points of the frame's `i`-th curve.
    ///
    /// # Errors
    /// Returns an error if the position is unknown or too few points are known.
    pub(super) fn locate(
        &mut self,
        seen: &Centerlines,
        (i, curve): (usize, &Curve),
        shown: &Shown,
    ) -> Result<&[SpacePoint]> {
        match (&mut self.kind, shown) {
            (Kind::Depth { ropes, .. }, Shown::Depth(image)) => {
                let rope = rope(&mut self.covered, seen, i, curve);
                Ok(ropes.locate(image, &rope)?)
            }
            (Kind::Second { ropes, .. }, _) => Ok(ropes.locate(i)?),
            (Kind::Depth { .. }, Shown::Second) => Err(NoDepth::Points.into()),
        }
    }
}

/// Converts the error of an unknown position to the value in the message.
pub(super) fn place_of(cause: &anyhow::Error) -> Place {
    if let Some(cause) = cause.downcast_ref() {
        return match cause {
            NoDepth::Thin { .. } => Place::Thin,
            NoDepth::Unmeasured { .. } | NoDepth::Flat | NoDepth::Points => Place::Unmeasured,
            NoDepth::Lens => Place::Unreadable,
        };
    }
    match cause.downcast_ref() {
        Some(NoSecondView::Alone | NoSecondView::Along { .. } | NoSecondView::Tangled) => {
            Place::Unmeasured
        }
        _ => Place::Unreadable,
    }
}

fn rope<'a>(
    covered: &'a mut Covered,
    seen: &Centerlines,
    i: usize,
    curve: &'a Curve,
) -> SeenRope<'a> {
    SeenRope {
        points: curve.points(),
        widths_px: curve.widths_px(),
        hidden: covered.of(seen, i, curve),
        closed: curve.closed != 0,
        ends: ends(curve),
    }
}

/// Returns which ends are visible: in the picture, and not under an occluder.
fn ends(curve: &Curve) -> [bool; 2] {
    let last = curve.points().len().saturating_sub(1);
    let at = [0, last];
    [0, 1].map(|end| curve.closed == 0 && curve.border >> end & 1 == 0 && !curve.is_hidden(at[end]))
}

fn check_size(size: Option<[u32; 2]>, seen: &Centerlines, what: &str) -> Result<()> {
    match size {
        Some([width, height]) if [seen.width, seen.height] != [width, height] => bail!(
            "the calibration is for {what} of {width}×{height} pixels, and these have {}×{}: in space it must be the same",
            seen.width,
            seen.height
        ),
        _ => Ok(()),
    }
}

/// Reads a depth image.
fn depth_image<'a>(calibration: &DepthCalibration, view: FrameView<'a>) -> Result<DepthImage<'a>> {
    let header = view.header();
    let [width, height] = calibration.size;
    if [header.width, header.height] != [width, height]
        || header.format() != Some(PixelFormat::Gray16)
    {
        bail!(
            "the depth camera's calibration is for gray16 images of {width}×{height} pixels, and these are {} of {}×{}",
            header.format().map_or("unknown", PixelFormat::name),
            header.width,
            header.height
        );
    }
    let size = [width, height].map(|side| side as usize);
    let stride = header.stride as usize;
    DepthImage::new(view.bytes(), size, stride, calibration.kind)
        .context("a depth image cannot be read")
}
