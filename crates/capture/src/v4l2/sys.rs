//! The kernel interface of a camera: one safe function for each Video4Linux2 ioctl that is used.
//!
//! This file contains `unsafe` code: an ioctl is a number and a pointer, and only this file knows
//! which structure belongs to the number. Every structure ([`structs`]) consists of plain integers,
//! so that whatever the kernel writes is a valid value. Numbers and layouts are those of
//! `linux/videodev2.h` on 64-bit Linux. A test checks their sizes. As the size is part of an
//! ioctl's number, the kernel refuses (`ENOTTY`) a structure that does not fit.

#![allow(unsafe_code)]

mod constants;
mod structs;

use std::os::fd::AsFd;

use rustix::io::{Result, retry_on_intr};
use rustix::ioctl::{Opcode, Setter, Updater, ioctl, opcode};

pub(super) use constants::*;
pub(super) use structs::*;

/// Type of all Video4Linux2 ioctls.
const V4L2: u8 = b'V';

/// Calls an ioctl that reads `value` and writes it back.
///
/// # Safety
/// The argument of `OPCODE` must be a `T`, and every pointer in `value` that the kernel follows
/// must be valid.
unsafe fn update<const OPCODE: Opcode, T>(fd: impl AsFd, value: &mut T) -> Result<()> {
    let fd = fd.as_fd();
    // No call blocks (the device is open with O_NONBLOCK), so an interrupted one can be repeated at
    // once.
    retry_on_intr(|| {
        // SAFETY: by the caller's contract; `value` is exclusively borrowed during the call.
        unsafe { ioctl(fd, Updater::<OPCODE, T>::new(value)) }
    })
}

/// Calls an ioctl that only reads `value`.
///
/// # Safety
/// As [`update`], and the kernel writes nothing.
unsafe fn set<const OPCODE: Opcode, T: Copy>(fd: impl AsFd, value: T) -> Result<()> {
    let fd = fd.as_fd();
    retry_on_intr(|| {
        // SAFETY: by the caller's contract.
        unsafe { ioctl(fd, Setter::<OPCODE, T>::new(value)) }
    })
}

/// Declares a safe function for each ioctl that reads and writes a structure without pointers.
macro_rules! updating {
    ($($(#[$doc:meta])* $direction:ident $number:literal fn $name:ident($type:ty);)+) => {$(
        $(#[$doc])*
        pub(super) fn $name(fd: impl AsFd, value: &mut $type) -> Result<()> {
            // SAFETY: the ioctl's argument is this structure, by `linux/videodev2.h`, and has no
            // pointer.
            unsafe { update::<{ opcode::$direction::<$type>(V4L2, $number) }, $type>(fd, value) }
        }
    )+};
}

updating! {
    /// `VIDIOC_QUERYCAP`: describes the device.
    read 0 fn query_capability(Capability);
    /// `VIDIOC_ENUM_FMT`: the pixel format with this `index`; `EINVAL` after the last.
    read_write 2 fn enumerate_formats(FormatDescription);
    /// `VIDIOC_G_FMT`: the present format.
    read_write 4 fn get_format(Format);
    /// `VIDIOC_S_FMT`: sets the format. Drivers set another one rather than refuse, and write it
    /// back.
    read_write 5 fn set_format(Format);
    /// `VIDIOC_REQBUFS`: allocates about `count` buffers, and writes back the actual number; 0
    /// frees them.
    read_write 8 fn request_buffers(RequestBuffers);
    /// `VIDIOC_G_PARM`: the present time per frame.
    read_write 21 fn get_parameters(StreamParameters);
    /// `VIDIOC_S_PARM`: sets the time per frame to one that the device supports, and writes it
    /// back.
    read_write 22 fn set_parameters(StreamParameters);
    /// `VIDIOC_G_CTRL`: the value of a control.
    read_write 27 fn get_control(Control);
    /// `VIDIOC_S_CTRL`: sets a control to the nearest supported value, and writes it back.
    read_write 28 fn set_control(Control);
    /// `VIDIOC_QUERYCTRL`: describes a control, for drivers without [`query_extended_control`].
    read_write 36 fn query_control(QueryControl);
    /// `VIDIOC_QUERYMENU`: one entry of a menu; `EINVAL` for a missing one.
    read_write 37 fn query_menu(QueryMenu);
    /// `VIDIOC_ENUM_FRAMESIZES`: the frame size with this `index`.
    read_write 74 fn enumerate_sizes(SizeDescription);
    /// `VIDIOC_ENUM_FRAMEINTERVALS`: the time per frame with this `index`, for a format and size.
    read_write 75 fn enumerate_intervals(IntervalDescription);
    /// `VIDIOC_QUERY_EXT_CTRL`: describes a control, or the next one ([`NEXT_CONTROL`]).
    read_write 103 fn query_extended_control(QueryExtendedControl);
}

/// `VIDIOC_STREAMON`: starts streaming. `kind` is a buffer type.
pub(super) fn stream_on(fd: impl AsFd, kind: u32) -> Result<()> {
    // SAFETY: the argument is an `int`, which the kernel only reads.
    unsafe { set::<{ opcode::write::<u32>(V4L2, 18) }, u32>(fd, kind) }
}

/// `VIDIOC_STREAMOFF`: stops streaming and returns all buffers. `kind` is a buffer type.
pub(super) fn stream_off(fd: impl AsFd, kind: u32) -> Result<()> {
    // SAFETY: the argument is an `int`, which the kernel only reads.
    unsafe { set::<{ opcode::write::<u32>(V4L2, 19) }, u32>(fd, kind) }
}

/// `VIDIOC_QUERYBUF`: position and length of a buffer. `planes` is written only for the
/// multi-planar types.
pub(super) fn query_buffer(fd: impl AsFd, buffer: &mut Buffer, planes: &mut [Plane]) -> Result<()> {
    buffer.point_to(planes);
    // SAFETY: the argument is this structure. Its pointer, which is followed only for the
    // multi-planar types, was just set to `planes`, with their number. They are exclusively
    // borrowed during the call.
    unsafe { update::<{ opcode::read_write::<Buffer>(V4L2, 9) }, Buffer>(fd, buffer) }
}

/// `VIDIOC_QBUF`: lends a buffer to the driver to fill.
///
/// # Safety
/// With [`MEMORY_USERPTR`], the memory that `buffer` points to must stay valid and untouched in its
/// whole length. For the multi-planar types, this applies to the memory that each of `planes`
/// points to. This requirement ends when the buffer is dequeued, streaming is stopped, or all
/// descriptors of the device are closed.
pub(super) unsafe fn queue_buffer(
    fd: impl AsFd,
    buffer: &mut Buffer,
    planes: &mut [Plane],
) -> Result<()> {
    buffer.point_to(planes);
    // SAFETY: as in `query_buffer`; the memory to fill is valid by the caller's contract.
    unsafe { update::<{ opcode::read_write::<Buffer>(V4L2, 15) }, Buffer>(fd, buffer) }
}

/// `VIDIOC_DQBUF`: takes back the buffer that was filled first; `EAGAIN` if none is filled.
pub(super) fn dequeue_buffer(
    fd: impl AsFd,
    buffer: &mut Buffer,
    planes: &mut [Plane],
) -> Result<()> {
    buffer.point_to(planes);
    // SAFETY: as in `query_buffer`.
    unsafe { update::<{ opcode::read_write::<Buffer>(V4L2, 17) }, Buffer>(fd, buffer) }
}

/// `VIDIOC_G_EXT_CTRLS`: reads the values of these controls.
pub(super) fn get_extended_controls(fd: impl AsFd, controls: &mut [ExtendedControl]) -> Result<()> {
    let mut value = ExtendedControls::of(controls);
    const OPCODE: Opcode = opcode::read_write::<ExtendedControls>(V4L2, 71);
    // SAFETY: the argument is this structure, and its pointer is to `controls`, with their number.
    // They are exclusively borrowed during the call. `ExtendedControls::of` has set their sizes to
    // 0, so that none counts as a pointer to a payload: the kernel then refuses controls that need
    // one.
    unsafe { update::<OPCODE, ExtendedControls>(fd, &mut value) }
}

/// `VIDIOC_S_EXT_CTRLS`: sets these controls; after an error, usually none is set.
pub(super) fn set_extended_controls(fd: impl AsFd, controls: &mut [ExtendedControl]) -> Result<()> {
    let mut value = ExtendedControls::of(controls);
    const OPCODE: Opcode = opcode::read_write::<ExtendedControls>(V4L2, 72);
    // SAFETY: as in `get_extended_controls`.
    unsafe { update::<OPCODE, ExtendedControls>(fd, &mut value) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structures_are_as_long_as_the_kernels() {
        assert_eq!(size_of::<Capability>(), 104);
        assert_eq!(size_of::<FormatDescription>(), 64);
        assert_eq!(size_of::<Format>(), 208);
        assert_eq!(size_of::<Buffer>(), 88);
        assert_eq!(size_of::<Plane>(), 64);
        assert_eq!(size_of::<RequestBuffers>(), 20);
        assert_eq!(size_of::<StreamParameters>(), 204);
        assert_eq!(size_of::<SizeDescription>(), 44);
        assert_eq!(size_of::<IntervalDescription>(), 52);
        assert_eq!(size_of::<QueryControl>(), 68);
        assert_eq!(size_of::<QueryExtendedControl>(), 232);
        assert_eq!(size_of::<Control>(), 8);
        assert_eq!(size_of::<ExtendedControls>(), 32);
        assert_eq!(size_of::<ExtendedControl>(), 20);
        assert_eq!(size_of::<QueryMenu>(), 44);
    }

    #[test]
    fn what_is_no_camera_says_so() {
        let file = std::fs::File::open("/dev/null").expect("every Linux has it");
        let mut capability = Capability::default();
        let refused = query_capability(&file, &mut capability);
        assert_eq!(refused, Err(rustix::io::Errno::NOTTY));
    }

    #[test]
    fn a_planar_format_is_read_back_as_it_was_written() {
        let single = PixFormat {
            width: 640,
            height: 480,
            pixelformat: PIX_NV12,
            bytesperline: 704,
            sizeimage: 506_880,
            field: FIELD_NONE,
            ..PixFormat::default()
        };
        let format = Format::single(BUF_TYPE_CAPTURE, single);
        assert_eq!(format.pix(), single);

        let mut many = PixFormatPlanes {
            width: 640,
            height: 480,
            pixelformat: PIX_NV12,
            field: FIELD_NONE,
            num_planes: 2,
            ..PixFormatPlanes::default()
        };
        many.planes[0].bytesperline = 704;
        many.planes[1].sizeimage = 168_960;
        let format = Format::planes(BUF_TYPE_CAPTURE_MPLANE, &many);
        assert_eq!(format.pix_planes(), many);
    }
}
