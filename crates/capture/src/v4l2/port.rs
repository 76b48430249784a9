//! Opens a camera by name with the requested setup, and restores that setup when it comes back.

use std::path::{Path, PathBuf};

use rustix::io::Errno;

use super::camera::{Camera, Encoding, Io, Port, Shape};
use super::controls::{Adjusted, ControlSettings};
use super::device::{Device, refusal};
use super::error::CameraError;
use super::hotplug::Hotplug;
use super::negotiate::Request;
use super::setup::Setup;
use crate::source::FrameSource;

/// A camera and its requested setup.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CameraOptions {
    /// Path of the camera: a node (`/dev/video0`), or a link to one (`/dev/v4l/by-id/…`), which
    /// stays the same when the node's number changes.
    pub path: PathBuf,
    /// Pixel format, size and rate.
    pub request: Request,
    /// Settings of its controls.
    pub controls: ControlSettings,
    /// How frames are transferred from its driver.
    pub io: Io,
}

/// Opens a camera as a source of frames.
///
/// # Errors
/// The camera does not exist, is not accessible, is in use, or does not have what is requested.
pub(crate) fn open_camera(options: &CameraOptions) -> Result<Box<dyn FrameSource>, CameraError> {
    let path = std::path::absolute(&options.path).unwrap_or_else(|_| options.path.clone());
    // Watches before the camera is opened, so that no event is missed. Without inotify, reopening
    // is retried at intervals.
    let hotplug = Hotplug::watch(&path).ok();
    let device = Device::open(&path)?;
    let setup = device.set_up(&options.request)?;
    let shape = shape_of(&device, &setup)?;
    let adjusted = Adjusted::new(&device, &options.controls)?;
    let name = path.display().to_string();
    let about = format!("{name}: {}, {}", device.about().card, setup.summary());
    let port = DevicePort {
        path,
        // When the camera comes back, the same choice is requested explicitly.
        request: Request {
            size: Some([setup.width, setup.height]),
            fps: setup.interval.map(|interval| interval.fps()),
            format: Some(setup.code),
            wanted: options.request.wanted,
        },
        shape,
        adjusted,
        lock: options.controls.lock,
    };
    let mut camera = Camera::new(name, device, port, shape, options.io, hotplug);
    camera.tell(about, setup.told);
    Ok(Box::new(camera))
}

/// Extracts from a setup what streaming needs.
fn shape_of(device: &Device, setup: &Setup) -> Result<Shape, CameraError> {
    let [buffer_bytes] = setup.plane_bytes[..] else {
        return Err(device.refusal(
            "give frames of several pieces of memory, which lariat does not read: choose another --pixel-format",
            Errno::NOTSUP,
        ));
    };
    Ok(Shape {
        width: setup.width,
        height: setup.height,
        stride: setup.stride,
        encoding: match setup.pixel_format() {
            Some(format) => Encoding::Plain(format),
            None => Encoding::Jpeg,
        },
        buffer_bytes: buffer_bytes as usize,
        range: setup.range,
        interval_ns: setup.interval.map(|interval| (1e9 / interval.fps()) as u64),
    })
}

/// Opens and reopens the device.
struct DevicePort {
    path: PathBuf,
    request: Request,
    shape: Shape,
    adjusted: Adjusted,
    lock: bool,
}

impl DevicePort {
    fn path(&self) -> &Path {
        &self.path
    }
}

impl Port for DevicePort {
    type Driver = Device;

    fn reopen(&mut self) -> Result<(Device, Option<String>), CameraError> {
        let device = Device::open(self.path())?;
        let setup = device.set_up(&self.request)?;
        let shape = shape_of(&device, &setup)?;
        // The rate may differ, because frames still fit.
        let as_before = Shape {
            interval_ns: self.shape.interval_ns,
            ..shape
        };
        if as_before != self.shape {
            return Err(device.refusal(
                "be set up as before: it is not the same camera, or its driver has changed; start lariat again",
                Errno::INVAL,
            ));
        }
        let refused = self.adjusted.again(&device);
        let but = (refused > 0).then(|| {
            format!("{refused} of its controls could not be set as they were: look with `lariat devices`")
        });
        Ok((device, but))
    }

    fn refusal(&self, call: &'static str, errno: Errno) -> CameraError {
        let doing = match call {
            "VIDIOC_REQBUFS" => "have memory for its frames (VIDIOC_REQBUFS); try --io mmap",
            "VIDIOC_QUERYBUF" => "show its memory (VIDIOC_QUERYBUF); try --io userptr",
            "VIDIOC_QBUF" => "be given memory for its frames (VIDIOC_QBUF); try --io mmap",
            _ => "be started (VIDIOC_STREAMON)",
        };
        refusal(self.path(), doing, errno)
    }

    fn settled(&mut self, driver: &Device) -> Option<String> {
        self.lock.then(|| self.adjusted.lock(driver))
    }

    fn leave(&mut self, driver: &Device) {
        self.adjusted.restore(driver);
    }
}
