//! Depth images beside frames: files, one for each picture, a second camera's, by a thread of its own, or the source's own.

mod camera;

use lariat_capture::{CameraOptions, DepthFiles, FrameSource};
use lariat_wire::{Domain, FrameHeader, Slot, Writer};

use super::super::Station;
use crate::calibrated::{Beside, Calibrated};
use crate::settings::Settings;
use camera::{Bounds, DepthCamera};

/// Where depth images come from.
pub(super) enum Depths {
    Files(Box<Files>),
    Source(Box<Own>),
    Camera(DepthCamera),
}

impl Depths {
    /// `camera`: the depth camera that the settings name, opened. `own`: the size of those that the source has itself. `None` if there are no
    /// depth images.
    pub(super) fn open(
        settings: &Settings,
        station: &Station,
        camera: Option<Box<dyn FrameSource>>,
        own: Option<[u32; 2]>,
    ) -> anyhow::Result<Option<Self>> {
        if let Some(size) = own {
            let Station {
                domain,
                rig,
                delivery,
                ..
            } = station;
            let writer = Writer::depths(domain, rig, delivery, bytes(size), 1)?;
            return Ok(Some(Self::Source(Box::new(Own { writer, size }))));
        }
        if let Some(source) = camera {
            let bounds = Bounds::of(settings);
            let camera = DepthCamera::start(source, bounds, Domain::open, station)?;
            return Ok(Some(Self::Camera(camera)));
        }
        let files = Files::open(settings, station)?;
        Ok(files.map(|files| Self::Files(Box::new(files))))
    }

    /// The depth image that is to be sent before the frame of this number, which the source has just made ready, if one is known by then.
    pub(super) fn slot(
        &mut self,
        sequence: u64,
        source: &mut dyn FrameSource,
    ) -> anyhow::Result<Option<DepthSlot<'_>>> {
        match self {
            Self::Files(files) => files.slot(sequence),
            Self::Source(own) => {
                let size = own.size;
                let mut slot = own.writer.frame_slot(bytes(size))?;
                source.write_depth(&mut slot);
                Ok(Some(DepthSlot { size, slot }))
            }
            Self::Camera(_) => Ok(None),
        }
    }

    /// A frame was sent.
    ///
    /// # Errors
    /// The depth camera has ended with a fault.
    pub(super) fn sent(&mut self, frame: &FrameHeader) -> anyhow::Result<()> {
        match self {
            Self::Files(_) | Self::Source(_) => Ok(()),
            Self::Camera(camera) => camera.frame(frame),
        }
    }

    /// No frame is to come. What a depth camera counted.
    ///
    /// # Errors
    /// It has ended with a fault.
    pub(super) fn end(self) -> anyhow::Result<Option<lariat_sink::DepthCounts>> {
        match self {
            Self::Files(_) | Self::Source(_) => Ok(None),
            Self::Camera(camera) => camera.end().map(Some),
        }
    }
}

/// What the depth camera that the settings name is asked for: images of its calibration's size, as many as frames; `None` if they name
/// none.
///
/// # Errors
/// The calibration cannot be read.
pub(super) fn camera_options(
    settings: &Settings,
    native_fps: Option<f64>,
) -> anyhow::Result<Option<CameraOptions>> {
    let size = settings.capture.likely_size();
    let Some((Beside::Depth(calibration), _)) = Calibrated::beside(&settings.camera, size)? else {
        return Ok(None);
    };
    Ok(settings.capture.depth_camera(calibration.size, native_fps))
}

/// Those of the source itself.
pub(super) struct Own {
    writer: Writer<[u8]>,
    size: [u32; 2],
}

/// Of an image of this size.
fn bytes([width, height]: [u32; 2]) -> usize {
    2 * width as usize * height as usize
}

/// Depth images beside pictures.
pub(super) struct Files {
    images: DepthFiles,
    writer: Writer<[u8]>,
    is_told: bool,
}

impl Files {
    /// `None` if there are none.
    fn open(settings: &Settings, station: &Station) -> anyhow::Result<Option<Self>> {
        let Some(folder) = &settings.capture.depth_images else {
            return Ok(None);
        };
        let options = settings.capture.file_options();
        let pictures = &settings.capture.source;
        let images = DepthFiles::open(std::slice::from_ref(folder), pictures, &options)?;
        tracing::info!("{}", images.notice());
        let Station {
            domain,
            rig,
            delivery,
            ..
        } = station;
        Ok(Some(Self {
            writer: Writer::depths(domain, rig, delivery, images.bytes(), 1)?,
            images,
            is_told: false,
        }))
    }

    /// The depth image of the frame of this number; `None` if it has none, which is said once. Fit counts those frames.
    fn slot(&mut self, sequence: u64) -> anyhow::Result<Option<DepthSlot<'_>>> {
        let mut slot = self.writer.frame_slot(self.images.bytes())?;
        if let Err(why) = self.images.write(sequence, &mut slot) {
            if !std::mem::replace(&mut self.is_told, true) {
                tracing::warn!("{why}");
            }
            return Ok(None);
        }
        let size = self.images.size();
        Ok(Some(DepthSlot { size, slot }))
    }
}

/// A depth image, to be sent.
pub(super) struct DepthSlot<'w> {
    pub(super) size: [u32; 2],
    pub(super) slot: Slot<'w, [u8]>,
}
