//! Incoming ROS messages, read in the transport's memory.

use std::cell::RefCell;

use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer};

const NS_PER_S: u64 = 1_000_000_000;

/// `builtin_interfaces/Time`.
#[derive(Debug, Clone, Copy, Deserialize)]
struct Time {
    sec: i32,
    nanosec: u32,
}

/// `std_msgs/Header`.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Header {
    stamp: Time,
    /// Ignored, because everything received belongs to the image of this rig.
    #[serde(rename = "frame_id")]
    _frame_id: String,
}

impl Header {
    /// Nanoseconds of ROS time; 0 if not set.
    pub(crate) fn stamp_ns(&self) -> u64 {
        u64::from(self.stamp.sec.max(0).unsigned_abs()) * NS_PER_S + u64::from(self.stamp.nanosec)
    }
}

/// `sensor_msgs/Image`.
#[derive(Debug, Deserialize)]
pub(crate) struct Image<'a> {
    pub(crate) header: Header,
    pub(crate) height: u32,
    pub(crate) width: u32,
    pub(crate) encoding: String,
    pub(crate) is_bigendian: u8,
    pub(crate) step: u32,
    pub(crate) data: &'a [u8],
}

/// `sensor_msgs/CompressedImage`.
#[derive(Debug, Deserialize)]
pub(crate) struct CompressedImage<'a> {
    pub(crate) header: Header,
    #[serde(rename = "format")]
    _format: String,
    pub(crate) data: &'a [u8],
}

/// An image of either kind.
#[derive(Debug)]
pub(crate) enum Picture<'a> {
    Raw(Image<'a>),
    File(CompressedImage<'a>),
}

/// Parses an image and passes it to `take` while it is in the transport's memory, so that its
/// pixels are copied only once.
pub(crate) struct PictureSeed<'f, F> {
    pub(crate) is_file: bool,
    pub(crate) take: &'f RefCell<F>,
}

impl<F> Clone for PictureSeed<'_, F> {
    fn clone(&self) -> Self {
        Self { ..*self }
    }
}

impl<'de, F: TakePicture> DeserializeSeed<'de> for PictureSeed<'_, F> {
    type Value = F::Taken;

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<F::Taken, D::Error> {
        let picture = if self.is_file {
            Picture::File(CompressedImage::deserialize(from)?)
        } else {
            Picture::Raw(Image::deserialize(from)?)
        };
        Ok(self.take.borrow_mut().take(picture))
    }
}

/// A handler of images.
pub(crate) trait TakePicture {
    /// The part of an image that is kept.
    type Taken: 'static;
    /// Copies what is needed of an image. The transport waits meanwhile, so nothing else is done
    /// here.
    fn take(&mut self, picture: Picture) -> Self::Taken;
}

/// `geometry_msgs/TwistStamped`.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct TwistStamped {
    pub(crate) header: Header,
    pub(crate) linear: [f64; 3],
    pub(crate) angular: [f64; 3],
}

/// `sensor_msgs/RegionOfInterest`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(crate) struct Region {
    pub(crate) x_offset: u32,
    pub(crate) y_offset: u32,
    pub(crate) height: u32,
    pub(crate) width: u32,
    pub(crate) do_rectify: bool,
}

/// `sensor_msgs/CameraInfo`.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct CameraInfo {
    #[serde(rename = "header")]
    _header: Header,
    pub(crate) height: u32,
    pub(crate) width: u32,
    pub(crate) distortion_model: String,
    pub(crate) d: Vec<f64>,
    pub(crate) k: [f64; 9],
    pub(crate) r: [f64; 9],
    pub(crate) p: [f64; 12],
    pub(crate) binning_x: u32,
    pub(crate) binning_y: u32,
    pub(crate) roi: Region,
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::incoming) fn header(stamp_ns: u64) -> Header {
        Header {
            stamp: Time {
                sec: (stamp_ns / NS_PER_S) as i32,
                nanosec: (stamp_ns % NS_PER_S) as u32,
            },
            _frame_id: "camera".to_owned(),
        }
    }

    pub(in crate::incoming) fn image<'a>(
        encoding: &str,
        [width, height]: [u32; 2],
        step: u32,
        data: &'a [u8],
    ) -> Image<'a> {
        Image {
            header: header(5),
            height,
            width,
            encoding: encoding.to_owned(),
            is_bigendian: 0,
            step,
            data,
        }
    }

    pub(in crate::incoming) fn camera_info() -> CameraInfo {
        let [fx, fy, cx, cy] = [600.5, 601.25, 320.0, 239.5];
        CameraInfo {
            _header: header(5),
            height: 480,
            width: 640,
            distortion_model: "plumb_bob".to_owned(),
            d: vec![-0.2, 0.05, 0.001, 0.0, 0.0],
            k: [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            p: [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
            binning_x: 0,
            binning_y: 0,
            roi: Region {
                x_offset: 0,
                y_offset: 0,
                height: 0,
                width: 0,
                do_rectify: false,
            },
        }
    }

    #[test]
    fn a_stamp_that_is_before_the_epoch_is_none() {
        let mut header = header(1_700_000_000_000_000_001);
        assert_eq!(header.stamp_ns(), 1_700_000_000_000_000_001);
        header.stamp.sec = -5;
        assert_eq!(header.stamp_ns(), 1);
    }
}
