//! The kernel's structures, with its layout and field names. They consist of plain integers,
//! without unions. A union is replaced by memory for its largest member, or by functions that read
//! each member.

/// `v4l2_capability`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct Capability {
    pub(crate) driver: [u8; 16],
    pub(crate) card: [u8; 32],
    pub(crate) bus_info: [u8; 32],
    pub(crate) version: u32,
    /// Capabilities of the whole device.
    pub(crate) capabilities: u32,
    /// Capabilities of this node, if `capabilities` includes
    /// [`CAP_DEVICE_CAPS`](super::CAP_DEVICE_CAPS).
    pub(crate) device_caps: u32,
    pub(crate) reserved: [u32; 3],
}

/// `v4l2_fmtdesc`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct FormatDescription {
    pub(crate) index: u32,
    pub(crate) kind: u32,
    pub(crate) flags: u32,
    pub(crate) description: [u8; 32],
    pub(crate) pixelformat: u32,
    pub(crate) mbus_code: u32,
    pub(crate) reserved: [u32; 3],
}

/// `v4l2_format`: a buffer type and a union of 200 bytes that depends on it. The union contains
/// pointers for types that are not used here, which determine its alignment.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(crate) struct Format {
    pub(crate) kind: u32,
    pub(crate) padding: u32,
    words: [u32; 50],
}

/// `v4l2_pix_format`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct PixFormat {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) pixelformat: u32,
    pub(crate) field: u32,
    pub(crate) bytesperline: u32,
    pub(crate) sizeimage: u32,
    pub(crate) colorspace: u32,
    pub(crate) private: u32,
    pub(crate) flags: u32,
    pub(crate) ycbcr_enc: u32,
    pub(crate) quantization: u32,
    pub(crate) xfer_func: u32,
}

/// `v4l2_plane_pix_format`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct PlaneFormat {
    pub(crate) sizeimage: u32,
    pub(crate) bytesperline: u32,
}

/// `v4l2_pix_format_mplane`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct PixFormatPlanes {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) pixelformat: u32,
    pub(crate) field: u32,
    pub(crate) colorspace: u32,
    pub(crate) planes: [PlaneFormat; 8],
    pub(crate) num_planes: u8,
    pub(crate) flags: u8,
    pub(crate) ycbcr_enc: u8,
    pub(crate) quantization: u8,
    pub(crate) xfer_func: u8,
}

/// Words of the planes in `v4l2_pix_format_mplane`, five per plane. The remaining bytes follow
/// them.
const PLANE_WORDS: std::ops::Range<usize> = 5..45;

impl Format {
    /// Creates an empty format of this buffer type.
    pub(crate) fn of(kind: u32) -> Self {
        Self {
            kind,
            padding: 0,
            words: [0; 50],
        }
    }

    /// Creates a format of a single-planar type.
    pub(crate) fn single(kind: u32, pix: PixFormat) -> Self {
        let mut format = Self::of(kind);
        format.words[..12].copy_from_slice(&[
            pix.width,
            pix.height,
            pix.pixelformat,
            pix.field,
            pix.bytesperline,
            pix.sizeimage,
            pix.colorspace,
            pix.private,
            pix.flags,
            pix.ycbcr_enc,
            pix.quantization,
            pix.xfer_func,
        ]);
        format
    }

    /// The format of a single-planar type.
    pub(crate) fn pix(&self) -> PixFormat {
        let words = &self.words;
        PixFormat {
            width: words[0],
            height: words[1],
            pixelformat: words[2],
            field: words[3],
            bytesperline: words[4],
            sizeimage: words[5],
            colorspace: words[6],
            private: words[7],
            flags: words[8],
            ycbcr_enc: words[9],
            quantization: words[10],
            xfer_func: words[11],
        }
    }

    /// Creates a format of a multi-planar type.
    pub(crate) fn planes(kind: u32, pix: &PixFormatPlanes) -> Self {
        let mut format = Self::of(kind);
        let head = [
            pix.width,
            pix.height,
            pix.pixelformat,
            pix.field,
            pix.colorspace,
        ];
        format.words[..PLANE_WORDS.start].copy_from_slice(&head);
        let planes = format.words[PLANE_WORDS].chunks_exact_mut(5);
        for (words, plane) in planes.zip(&pix.planes) {
            words[..2].copy_from_slice(&[plane.sizeimage, plane.bytesperline]);
        }
        let bytes = [pix.num_planes, pix.flags, pix.ycbcr_enc, pix.quantization];
        format.words[45] = u32::from_ne_bytes(bytes);
        format.words[46] = u32::from_ne_bytes([pix.xfer_func, 0, 0, 0]);
        format
    }

    /// The format of a multi-planar type.
    pub(crate) fn pix_planes(&self) -> PixFormatPlanes {
        let words = &self.words;
        let mut planes = [PlaneFormat::default(); 8];
        for (plane, words) in planes.iter_mut().zip(words[PLANE_WORDS].chunks_exact(5)) {
            *plane = PlaneFormat {
                sizeimage: words[0],
                bytesperline: words[1],
            };
        }
        let [num_planes, flags, ycbcr_enc, quantization] = words[45].to_ne_bytes();
        let [xfer_func, ..] = words[46].to_ne_bytes();
        PixFormatPlanes {
            width: words[0],
            height: words[1],
            pixelformat: words[2],
            field: words[3],
            colorspace: words[4],
            planes,
            num_planes,
            flags,
            ycbcr_enc,
            quantization,
            xfer_func,
        }
    }
}

/// `v4l2_requestbuffers`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct RequestBuffers {
    pub(crate) count: u32,
    pub(crate) kind: u32,
    pub(crate) memory: u32,
    pub(crate) capabilities: u32,
    pub(crate) flags: u8,
    pub(crate) reserved: [u8; 3],
}

/// `v4l2_buffer`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct Buffer {
    pub(crate) index: u32,
    pub(crate) kind: u32,
    pub(crate) bytesused: u32,
    pub(crate) flags: u32,
    pub(crate) field: u32,
    pub(crate) padding: u32,
    pub(crate) timestamp_s: i64,
    pub(crate) timestamp_us: i64,
    pub(crate) timecode: [u32; 4],
    pub(crate) sequence: u32,
    pub(crate) memory: u32,
    /// The union `m` of the single-planar types: an offset for mmap (in its lower half), or an
    /// address.
    pub(crate) m: u64,
    /// Length in bytes, for the single-planar types.
    pub(crate) length: u32,
    pub(crate) reserved2: u32,
    pub(crate) request_fd: i32,
    pub(crate) padding2: u32,
}

impl Buffer {
    /// Offset at which to map it ([`MEMORY_MMAP`](super::MEMORY_MMAP), single-planar).
    pub(crate) fn offset(&self) -> u32 {
        lower_half(self.m)
    }

    /// Returns whether planes describe the memory of this kind of buffer.
    pub(crate) fn has_planes(&self) -> bool {
        [
            super::BUF_TYPE_CAPTURE_MPLANE,
            super::BUF_TYPE_OUTPUT_MPLANE,
        ]
        .contains(&self.kind)
    }

    /// Makes the buffer refer to `planes`, if its kind has any.
    pub(super) fn point_to(&mut self, planes: &mut [Plane]) {
        if self.has_planes() {
            self.m = planes.as_mut_ptr().expose_provenance() as u64;
            // The kernel accepts at most 8; the rest of a longer slice is ignored.
            self.length = planes.len().min(8) as u32;
        }
    }
}

/// `v4l2_plane`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct Plane {
    pub(crate) bytesused: u32,
    pub(crate) length: u32,
    /// The union `m`: an offset for mmap (in its lower half), or an address.
    pub(crate) m: u64,
    pub(crate) data_offset: u32,
    pub(crate) reserved: [u32; 11],
}

impl Plane {
    /// Offset at which to map it ([`MEMORY_MMAP`](super::MEMORY_MMAP)).
    pub(crate) fn offset(&self) -> u32 {
        lower_half(self.m)
    }
}

/// Returns the `__u32` at the start of an 8-byte union.
fn lower_half(union: u64) -> u32 {
    let [a, b, c, d, ..] = union.to_ne_bytes();
    u32::from_ne_bytes([a, b, c, d])
}

/// `v4l2_streamparm`, with `v4l2_captureparm`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(crate) struct StreamParameters {
    pub(crate) kind: u32,
    pub(crate) capability: u32,
    pub(crate) capturemode: u32,
    /// Seconds per frame, as numerator and denominator.
    pub(crate) timeperframe: [u32; 2],
    pub(crate) extendedmode: u32,
    pub(crate) readbuffers: u32,
    pub(crate) rest: [u32; 44],
}

impl StreamParameters {
    /// Creates empty parameters of this buffer type.
    pub(crate) fn of(kind: u32) -> Self {
        Self {
            kind,
            capability: 0,
            capturemode: 0,
            timeperframe: [0; 2],
            extendedmode: 0,
            readbuffers: 0,
            rest: [0; 44],
        }
    }
}

/// `v4l2_frmsizeenum`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct SizeDescription {
    pub(crate) index: u32,
    pub(crate) pixel_format: u32,
    pub(crate) kind: u32,
    /// Discrete: width and height. Otherwise minimum, maximum and step of the width, then of the
    /// height.
    pub(crate) size: [u32; 6],
    pub(crate) reserved: [u32; 2],
}

/// `v4l2_frmivalenum`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct IntervalDescription {
    pub(crate) index: u32,
    pub(crate) pixel_format: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) kind: u32,
    /// Seconds as numerator and denominator. Discrete: the first pair. Otherwise minimum, maximum
    /// and step.
    pub(crate) interval: [[u32; 2]; 3],
    pub(crate) reserved: [u32; 2],
}

/// `v4l2_control`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct Control {
    pub(crate) id: u32,
    pub(crate) value: i32,
}

/// `v4l2_queryctrl`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct QueryControl {
    pub(crate) id: u32,
    pub(crate) kind: u32,
    pub(crate) name: [u8; 32],
    pub(crate) minimum: i32,
    pub(crate) maximum: i32,
    pub(crate) step: i32,
    pub(crate) default_value: i32,
    pub(crate) flags: u32,
    pub(crate) reserved: [u32; 2],
}

/// `v4l2_query_ext_ctrl`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct QueryExtendedControl {
    pub(crate) id: u32,
    pub(crate) kind: u32,
    pub(crate) name: [u8; 32],
    pub(crate) minimum: i64,
    pub(crate) maximum: i64,
    pub(crate) step: u64,
    pub(crate) default_value: i64,
    pub(crate) flags: u32,
    pub(crate) elem_size: u32,
    pub(crate) elems: u32,
    pub(crate) nr_of_dims: u32,
    pub(crate) dims: [u32; 4],
    pub(crate) reserved: [u32; 32],
}

/// `v4l2_querymenu`.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct QueryMenu {
    pub(crate) id: u32,
    pub(crate) index: u32,
    /// The entry's name. For an integer menu, the first 8 bytes contain its number.
    pub(crate) name: [u8; 32],
    pub(crate) reserved: u32,
}

impl QueryMenu {
    /// The number of an entry in an integer menu.
    pub(crate) fn value(&self) -> i64 {
        let [a, b, c, d, e, f, g, h, ..] = self.name;
        i64::from_ne_bytes([a, b, c, d, e, f, g, h])
    }
}

/// `v4l2_ext_control`, which the kernel packs, so it cannot contain an 8-byte integer.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(crate) struct ExtendedControl {
    pub(crate) id: u32,
    size: u32,
    pub(crate) reserved: u32,
    value: [u32; 2],
}

impl ExtendedControl {
    /// Creates a control with a value of 8 or 4 bytes, depending on its type.
    pub(crate) fn new(id: u32, is_64_bit: bool, value: i64) -> Self {
        let mut control = Self {
            id,
            ..Self::default()
        };
        if is_64_bit {
            let [a, b, c, d, e, f, g, h] = value.to_ne_bytes();
            control.value = [[a, b, c, d], [e, f, g, h]].map(u32::from_ne_bytes);
        } else {
            control.value[0] = value as u32;
        }
        control
    }

    /// The value, of 8 or 4 bytes depending on the control's type.
    pub(crate) fn value(&self, is_64_bit: bool) -> i64 {
        if is_64_bit {
            let [[a, b, c, d], [e, f, g, h]] = self.value.map(u32::to_ne_bytes);
            i64::from_ne_bytes([a, b, c, d, e, f, g, h])
        } else {
            i64::from(self.value[0] as i32)
        }
    }
}

/// `v4l2_ext_controls`: pointer to the controls, and their number.
#[derive(Debug)]
#[repr(C)]
pub(super) struct ExtendedControls {
    /// 0: the current values, of controls of any class.
    which: u32,
    count: u32,
    error_idx: u32,
    pub(crate) request_fd: i32,
    pub(crate) reserved: u32,
    pub(crate) padding: u32,
    controls: *mut ExtendedControl,
}

impl ExtendedControls {
    /// Refers to these controls, whose values are all inline.
    pub(super) fn of(controls: &mut [ExtendedControl]) -> Self {
        for control in controls.iter_mut() {
            control.size = 0;
        }
        Self {
            which: 0,
            // The kernel refuses more than 1,024.
            count: controls.len().min(1024) as u32,
            error_idx: 0,
            request_fd: 0,
            reserved: 0,
            padding: 0,
            controls: controls.as_mut_ptr(),
        }
    }
}
