//! Depth images that belong to frames. They come from files (one per picture), from a second camera
//! with its own thread, or from the source itself.

mod camera;

use lariat_capture::{CameraOptions, DepthFiles, FrameSource};
use lariat_wire::{Domain, FrameHeader, Slot, Writer};

use super::super::Station;
use crate::calibrated::{Beside, Calibrated};
use crate::settings::Settings;
use camera::{Bounds, DepthCamera};

/// Origin of the depth images.
pub(super) enum Depths {
    Files(Box<Files>),
    Source(Box<Own>),
    Camera(DepthCamera),
}

impl Depths {
    /// Opens the depth images. `camera` is the open depth camera that the settings name. `own` is
    /// the size of the source's own depth images. Returns `None` without depth images.
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

    /// Returns the depth image to send before this frame, if it is known by then. The source has
    /// just prepared the frame.
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

    /// Notes that a frame was sent.
    ///
    /// # Errors
    /// Returns an error if the depth camera failed.
    pub(super) fn sent(&mut self, frame: &FrameHeader) -> anyhow::Result<()> {
        match self {
            Self::Files(_) | Self::Source(_) => Ok(()),
            Self::Camera(camera) => camera.frame(frame),
        }
    }

    /// Ends the depth images, because no more frames follow. Returns the counts of a depth camera.
    ///
    /// # Errors
    /// Returns an error if the depth camera failed.
    pub(super) fn end(self) -> anyhow::Result<Option<lariat_sink::DepthCounts>> {
        match self {
            Self::Files(_) | Self::Source(_) => Ok(None),
            Self::Camera(camera) => camera.end().map(Some),
        }
    }
}

/// Returns the options of the depth camera that the settings name, or `None` without one. It should
/// deliver images of its calibration's size, at the frame rate.
///
/// # Errors
/// Returns an error if the calibration cannot be read.
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

/// Depth images of the source itself.
pub(super) struct Own {
    writer: Writer<[u8]>,
    size: [u32; 2],
}

/// Returns the number of bytes of an image.
fn bytes([width, height]: [u32; 2]) -> usize {
    2 * width as usize * height as usize
}

/// Depth images for picture files.
pub(super) struct Files {
    images: DepthFiles,
    writer: Writer<[u8]>,
    is_told: bool,
}

impl Files {
    /// Returns `None` if the settings name no folder.
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

    /// Returns the depth image of this frame. If it is missing, warns once and returns `None`. Fit
    /// counts those frames.
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

/// A depth image that is ready to send.
pub(super) struct DepthSlot<'w> {
    pub(super) size: [u32; 2],
    pub(super) slot: Slot<'w, [u8]>,
}
