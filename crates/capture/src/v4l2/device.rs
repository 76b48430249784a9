//! An open video node that is known to be a camera.

use std::fs;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;

use super::error::CameraError;
use super::{nodes, sys};

/// An open camera.
#[derive(Debug)]
pub(crate) struct Device {
    fd: OwnedFd,
    path: PathBuf,
    about: About,
    buffer_type: u32,
}

/// A node's description of itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct About {
    /// The camera's name.
    pub(crate) card: String,
    pub(crate) driver: String,
    /// The port that the camera is plugged into.
    pub(crate) bus: String,
    pub(super) role: Role,
}

/// Purpose of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// Delivers pictures. `planes` is true for the multi-planar interface.
    Camera {
        planes: bool,
    },
    /// Delivers pictures, but cannot stream.
    ReadOnly,
    Metadata,
    Output,
    Codec,
    Radio,
    Teletext,
    Touch,
    Other,
}

impl Role {
    /// Determines the role from `V4L2_CAP_*`.
    fn of(caps: u32) -> Self {
        let has = |any: u32| caps & any != 0;
        if has(sys::CAP_VIDEO_M2M | sys::CAP_VIDEO_M2M_MPLANE) {
            Self::Codec
        } else if has(sys::CAP_TOUCH) {
            Self::Touch
        } else if has(sys::CAP_VIDEO_CAPTURE | sys::CAP_VIDEO_CAPTURE_MPLANE) {
            if has(sys::CAP_STREAMING) {
                let planes = !has(sys::CAP_VIDEO_CAPTURE);
                Self::Camera { planes }
            } else {
                Self::ReadOnly
            }
        } else if has(sys::CAP_META_CAPTURE | sys::CAP_META_OUTPUT) {
            Self::Metadata
        } else if has(sys::CAP_VIDEO_OUTPUT | sys::CAP_VIDEO_OUTPUT_MPLANE | sys::CAP_VIDEO_OVERLAY)
        {
            Self::Output
        } else if has(sys::CAP_VBI) {
            Self::Teletext
        } else if has(sys::CAP_RADIO) {
            Self::Radio
        } else {
            Self::Other
        }
    }
}

impl Device {
    /// Opens the camera at `path`.
    ///
    /// # Errors
    /// The path does not exist, may not be opened, is in use by another program, or is not a
    /// camera.
    pub(crate) fn open(path: &Path) -> Result<Self, CameraError> {
        let (fd, about) = open_node(path)?;
        let Role::Camera { planes } = about.role else {
            return Err(CameraError::NotACamera {
                path: path.to_owned(),
                what: what_instead(path, &about),
            });
        };
        Ok(Self {
            fd,
            path: path.to_owned(),
            about,
            buffer_type: if planes {
                sys::BUF_TYPE_CAPTURE_MPLANE
            } else {
                sys::BUF_TYPE_CAPTURE
            },
        })
    }

    /// The path that it was opened with.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Its description of itself.
    pub(crate) fn about(&self) -> &About {
        &self.about
    }

    /// The single- or multi-planar buffer type that every call needs.
    pub(crate) fn buffer_type(&self) -> u32 {
        self.buffer_type
    }

    /// Returns whether it is multi-planar.
    pub(crate) fn has_planes(&self) -> bool {
        self.buffer_type == sys::BUF_TYPE_CAPTURE_MPLANE
    }

    /// The error for the kernel's refusal; `doing` completes "it cannot …".
    pub(crate) fn refusal(&self, doing: &'static str, errno: Errno) -> CameraError {
        refusal(&self.path, doing, errno)
    }
}

impl AsFd for Device {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.fd.as_fd()
    }
}

/// The error for the kernel's refusal; `doing` completes "it cannot …".
pub(super) fn refusal(path: &Path, doing: &'static str, errno: Errno) -> CameraError {
    let path = path.to_owned();
    match errno {
        Errno::BUSY => CameraError::Busy {
            holder: nodes::holders(&path).unwrap_or_else(|| "another program".to_owned()),
            path,
        },
        Errno::NODEV | Errno::NXIO => CameraError::Gone {
            path,
            error: errno.into(),
        },
        _ => CameraError::Refused {
            path,
            doing,
            error: errno.into(),
        },
    }
}

/// Opens any video node and queries what it is.
pub(super) fn open_node(path: &Path) -> Result<(OwnedFd, About), CameraError> {
    let not_a_camera = |what: &str| CameraError::NotACamera {
        path: path.to_owned(),
        what: what.to_owned(),
    };
    match fs::metadata(path) {
        Ok(meta) if meta.file_type().is_char_device() => {}
        Ok(_) => return Err(not_a_camera("it is no device at all")),
        Err(error) if error.kind() == std::io::ErrorKind::PermissionDenied => {
            return Err(CameraError::NoPermission {
                path: path.to_owned(),
                remedy: "a folder above it cannot be entered".to_owned(),
            });
        }
        Err(_) => {
            return Err(CameraError::Absent {
                path: path.to_owned(),
                cameras: the_cameras(),
            });
        }
    }
    let flags = OFlags::RDWR | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let fd = rustix::fs::open(path, flags, Mode::empty()).map_err(|errno| match errno {
        Errno::ACCESS | Errno::PERM => CameraError::NoPermission {
            path: path.to_owned(),
            remedy: nodes::permission_remedy(path),
        },
        Errno::NOENT => CameraError::Absent {
            path: path.to_owned(),
            cameras: the_cameras(),
        },
        errno => refusal(path, "be opened", errno),
    })?;
    let mut capability = sys::Capability::default();
    match sys::query_capability(&fd, &mut capability) {
        Ok(()) => Ok((fd, about(&capability))),
        Err(Errno::NOTTY | Errno::INVAL) => Err(not_a_camera(
            "it is a device of another kind, not of Video4Linux2; `lariat devices` lists the cameras",
        )),
        Err(errno) => Err(refusal(path, "say what it is (VIDIOC_QUERYCAP)", errno)),
    }
}

fn about(capability: &sys::Capability) -> About {
    let caps = if capability.capabilities & sys::CAP_DEVICE_CAPS != 0 {
        capability.device_caps
    } else {
        capability.capabilities
    };
    About {
        card: text(&capability.card),
        driver: text(&capability.driver),
        bus: text(&capability.bus_info),
        role: Role::of(caps),
    }
}

/// Converts a zero-terminated text from the kernel.
pub(super) fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).trim().to_owned()
}

/// Lists the nodes that are cameras and can be queried, with their descriptions.
pub(super) fn cameras() -> Vec<(PathBuf, About)> {
    nodes::all()
        .into_iter()
        .filter_map(|node| Some((node.path.clone(), open_node(&node.path).ok()?.1)))
        .filter(|(_, about)| matches!(about.role, Role::Camera { .. }))
        .collect()
}

/// Lists the cameras for the end of a sentence.
fn the_cameras() -> String {
    let all: Vec<_> = cameras()
        .iter()
        .map(|(path, about)| format!("{} ({})", path.display(), about.card))
        .collect();
    match all.len() {
        0 => "no camera found on this machine; plug one in and check with `lariat devices`"
            .to_owned(),
        1 => format!("the camera here is {}", all[0]),
        _ => format!("the cameras here are {}", all.join(", ")),
    }
}

/// Says what a node is, since it is not a camera, and what to name instead.
fn what_instead(path: &Path, about: &About) -> String {
    let what = match about.role {
        Role::Metadata => "it gives the pictures' metadata, not the pictures",
        Role::Output if about.driver.contains("loopback") => {
            return "nothing is fed into this loopback device yet; it is a camera once a program writes to it".to_owned();
        }
        Role::Output => "it shows pictures and gives none",
        Role::Codec => "it is a codec, which turns pictures into other pictures",
        Role::ReadOnly => {
            return "its driver only lets pictures be read(), without the timestamps that streaming has".to_owned();
        }
        Role::Radio => "it is a radio",
        Role::Teletext => "it gives teletext (VBI), not pictures",
        Role::Touch => "it is a touch screen",
        Role::Camera { .. } | Role::Other => "it has no pictures to give",
    };
    let pictures: Vec<_> = nodes::siblings(path)
        .into_iter()
        .filter(|node| {
            open_node(node).is_ok_and(|(_, about)| matches!(about.role, Role::Camera { .. }))
        })
        .map(|node| node.display().to_string())
        .collect();
    match pictures.is_empty() {
        true => format!("{what}; {}", the_cameras()),
        false => format!(
            "{what}; name {} instead, of the same device",
            pictures.join(" or ")
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_what_its_capabilities_say() {
        // Device capabilities of real nodes as `v4l2-ctl --info` shows them.
        for (caps, role) in [
            (0x0420_0001, Role::Camera { planes: false }), // a USB camera
            (0x04a0_0000, Role::Metadata),                 // the second node of a USB camera
            (0x8520_0001, Role::Camera { planes: false }), // vivid, v4l2loopback
            (0x0420_1000, Role::Camera { planes: true }),  // a Rockchip camera interface
            (0x0420_4000, Role::Codec),                    // a Raspberry Pi's decoder
            (0x0520_0002, Role::Output),                   // v4l2loopback, not fed
            (0x0525_0011, Role::Camera { planes: false }), // a TV card
            (0x0025_0050, Role::Teletext),
            (0x0015_0000, Role::Radio),
            (0x1420_0001, Role::Touch),
            (0x0020_0001, Role::ReadOnly),
            (0x0020_0000, Role::Other),
        ] {
            assert_eq!(Role::of(caps), role, "{caps:#x}");
        }
    }

    #[test]
    fn what_is_not_there_is_said_with_what_is() {
        let error = Device::open(Path::new("/dev/video4711")).expect_err("it has no such number");
        let text = error.to_string();
        assert!(text.starts_with("there is no /dev/video4711: "), "{text}");
        assert!(text.contains("camera"), "{text}");
    }

    #[test]
    fn a_device_of_another_kind_and_a_file_are_no_cameras() {
        for path in ["/dev/null", "/proc/self/status", "/"] {
            let error = Device::open(Path::new(path)).expect_err(path);
            assert!(matches!(error, CameraError::NotACamera { .. }), "{error}");
        }
    }
}
