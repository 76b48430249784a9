//! The numbers that lariat uses from `linux/videodev2.h` and `linux/v4l2-controls.h`, in the order
//! of these files.

/// Encodes the four letters of a pixel format.
pub(crate) const fn fourcc(code: &[u8; 4]) -> u32 {
    u32::from_le_bytes(*code)
}

pub(crate) const FIELD_ANY: u32 = 0;
pub(crate) const FIELD_NONE: u32 = 1;

pub(crate) const BUF_TYPE_CAPTURE: u32 = 1;
pub(crate) const BUF_TYPE_CAPTURE_MPLANE: u32 = 9;
pub(crate) const BUF_TYPE_OUTPUT_MPLANE: u32 = 10;

pub(crate) const MEMORY_MMAP: u32 = 1;
pub(crate) const MEMORY_USERPTR: u32 = 2;

pub(crate) const CAP_VIDEO_CAPTURE: u32 = 0x0000_0001;
pub(crate) const CAP_VIDEO_OUTPUT: u32 = 0x0000_0002;
pub(crate) const CAP_VIDEO_OVERLAY: u32 = 0x0000_0004;
pub(crate) const CAP_VBI: u32 = 0x0000_00f0;
pub(crate) const CAP_VIDEO_CAPTURE_MPLANE: u32 = 0x0000_1000;
pub(crate) const CAP_VIDEO_OUTPUT_MPLANE: u32 = 0x0000_2000;
pub(crate) const CAP_VIDEO_M2M_MPLANE: u32 = 0x0000_4000;
pub(crate) const CAP_VIDEO_M2M: u32 = 0x0000_8000;
pub(crate) const CAP_RADIO: u32 = 0x0004_0000;
pub(crate) const CAP_META_CAPTURE: u32 = 0x0080_0000;
pub(crate) const CAP_STREAMING: u32 = 0x0400_0000;
pub(crate) const CAP_META_OUTPUT: u32 = 0x0800_0000;
pub(crate) const CAP_TOUCH: u32 = 0x1000_0000;
pub(crate) const CAP_DEVICE_CAPS: u32 = 0x8000_0000;

pub(crate) const PIX_GREY: u32 = fourcc(b"GREY");
pub(crate) const PIX_RGB3: u32 = fourcc(b"RGB3");
pub(crate) const PIX_BGR3: u32 = fourcc(b"BGR3");
pub(crate) const PIX_AR24: u32 = fourcc(b"AR24");
pub(crate) const PIX_XR24: u32 = fourcc(b"XR24");
pub(crate) const PIX_BGR4: u32 = fourcc(b"BGR4");
pub(crate) const PIX_Y16: u32 = fourcc(b"Y16 ");
pub(crate) const PIX_Z16: u32 = fourcc(b"Z16 ");
pub(crate) const PIX_RGGB: u32 = fourcc(b"RGGB");
pub(crate) const PIX_BA81: u32 = fourcc(b"BA81");
pub(crate) const PIX_GRBG: u32 = fourcc(b"GRBG");
pub(crate) const PIX_GBRG: u32 = fourcc(b"GBRG");
pub(crate) const PIX_YUYV: u32 = fourcc(b"YUYV");
pub(crate) const PIX_UYVY: u32 = fourcc(b"UYVY");
pub(crate) const PIX_NV12: u32 = fourcc(b"NV12");
pub(crate) const PIX_MJPG: u32 = fourcc(b"MJPG");
pub(crate) const PIX_JPEG: u32 = fourcc(b"JPEG");

pub(crate) const FMT_FLAG_COMPRESSED: u32 = 0x0001;

pub(crate) const SIZE_DISCRETE: u32 = 1;
pub(crate) const SIZE_STEPWISE: u32 = 3;
pub(crate) const INTERVAL_DISCRETE: u32 = 1;

/// Flag in [`StreamParameters::capability`](super::StreamParameters): the time per frame can be
/// set.
pub(crate) const CAP_TIMEPERFRAME: u32 = 0x1000;

pub(crate) const BUF_FLAG_ERROR: u32 = 0x0000_0040;
pub(crate) const BUF_FLAG_TIMESTAMP_MASK: u32 = 0x0000_e000;
pub(crate) const BUF_FLAG_TIMESTAMP_MONOTONIC: u32 = 0x0000_2000;
#[cfg(test)]
pub(crate) const BUF_FLAG_TIMESTAMP_COPY: u32 = 0x0000_4000;
pub(crate) const BUF_FLAG_TSTAMP_SRC_MASK: u32 = 0x0007_0000;
/// No bit is set, as in the kernel.
#[cfg(test)]
pub(crate) const BUF_FLAG_TSTAMP_SRC_EOF: u32 = 0x0000_0000;
pub(crate) const BUF_FLAG_TSTAMP_SRC_SOE: u32 = 0x0001_0000;

pub(crate) const CTRL_TYPE_INTEGER: u32 = 1;
pub(crate) const CTRL_TYPE_BOOLEAN: u32 = 2;
pub(crate) const CTRL_TYPE_MENU: u32 = 3;
pub(crate) const CTRL_TYPE_BUTTON: u32 = 4;
pub(crate) const CTRL_TYPE_INTEGER64: u32 = 5;
pub(crate) const CTRL_TYPE_CLASS: u32 = 6;
pub(crate) const CTRL_TYPE_BITMASK: u32 = 8;
pub(crate) const CTRL_TYPE_INTEGER_MENU: u32 = 9;

pub(crate) const CTRL_FLAG_DISABLED: u32 = 0x0001;
pub(crate) const CTRL_FLAG_READ_ONLY: u32 = 0x0004;
pub(crate) const CTRL_FLAG_INACTIVE: u32 = 0x0010;
pub(crate) const CTRL_FLAG_WRITE_ONLY: u32 = 0x0040;
pub(crate) const CTRL_FLAG_HAS_PAYLOAD: u32 = 0x0100;

/// Flag in a control's id that requests the next control.
pub(crate) const NEXT_CONTROL: u32 = 0x8000_0000;

pub(crate) const CID_AUTO_WHITE_BALANCE: u32 = 0x0098_090c;
pub(crate) const CID_EXPOSURE: u32 = 0x0098_0911;
pub(crate) const CID_AUTOGAIN: u32 = 0x0098_0912;
pub(crate) const CID_GAIN: u32 = 0x0098_0913;
pub(crate) const CID_HUE_AUTO: u32 = 0x0098_0919;
pub(crate) const CID_AUTOBRIGHTNESS: u32 = 0x0098_0920;
pub(crate) const CID_EXPOSURE_AUTO: u32 = 0x009a_0901;
/// Exposure time in units of 100 µs.
pub(crate) const CID_EXPOSURE_ABSOLUTE: u32 = 0x009a_0902;
/// True if the camera may lower its frame rate to expose for longer.
pub(crate) const CID_EXPOSURE_AUTO_PRIORITY: u32 = 0x009a_0903;
pub(crate) const CID_FOCUS_AUTO: u32 = 0x009a_090c;
pub(crate) const CID_AUTO_N_PRESET_WHITE_BALANCE: u32 = 0x009a_0914;
pub(crate) const CID_ISO_SENSITIVITY_AUTO: u32 = 0x009a_0918;
/// The 3A lock: one bit each for exposure, white balance and focus.
pub(crate) const CID_3A_LOCK: u32 = 0x009a_091b;

/// `V4L2_COLORSPACE_JPEG`: the color space of JFIF.
pub(crate) const COLORSPACE_JPEG: u32 = 7;
/// `V4L2_QUANTIZATION_FULL_RANGE`: levels from 0 to 255.
pub(crate) const QUANTIZATION_FULL: u32 = 1;
/// `V4L2_QUANTIZATION_LIM_RANGE`: levels from 16 to 235, or to 240 for U and V.
pub(crate) const QUANTIZATION_LIMITED: u32 = 2;
