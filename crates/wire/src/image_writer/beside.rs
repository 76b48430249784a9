//! Writers for images that accompany frames: masks and depth images.

use std::fmt;

use super::{Images, Waiting};
use crate::channel::{Channel, DEPTH, MASKS};
use crate::error::MAX_SIDE;
use crate::{Domain, FrameHeader, Rig, WireError, WriteError};

/// Writing end of a channel for such images, with the header of the image on loan.
struct Beside {
    images: Images,
    header: FrameHeader,
}

impl Beside {
    fn open(
        domain: Domain,
        rig: &Rig,
        channel: &'static Channel<[u8]>,
        waiting: Waiting,
    ) -> Result<Self, WireError> {
        Ok(Self {
            images: Images::open(domain, rig, channel, waiting)?,
            header: FrameHeader::default(),
        })
    }

    /// Borrows a slot for the image that `header` describes, which accompanies `frame`.
    fn loan(&mut self, frame: &FrameHeader, header: FrameHeader) -> Result<&mut [u8], WriteError> {
        if frame.is_blank() {
            return Err(WriteError::NoImage);
        }
        self.header = header;
        let bytes = header.image_bytes().filter(|&bytes| bytes > 0);
        Ok(self.images.loan(bytes.ok_or(WriteError::NoImage)?)?)
    }
}

macro_rules! writer {
    ($(#[$about:meta])* $writer:ident, $what:literal, $channel:ident) => {
        $(#[$about])*
        pub struct $writer(Beside);

        impl fmt::Debug for $writer {
            fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.debug_struct(stringify!($writer)).finish_non_exhaustive()
            }
        }

        impl $writer {
            #[doc = concat!("Becomes the writer of a rig's ", $what, ".")]
            ///
            /// # Errors
            /// As for [`FrameWriter::open`](super::FrameWriter::open).
            pub fn open(rig: &str) -> Result<Self, WriteError> {
                Self::open_in(Domain::open()?, &rig.parse()?, Waiting::default())
            }

            /// Opens the writer in a given domain, with a given behavior towards slow readers.
            ///
            /// # Errors
            /// As for [`FrameWriter::open_in`](super::FrameWriter::open_in).
            pub fn open_in(domain: Domain, rig: &Rig, waiting: Waiting) -> Result<Self, WriteError> {
                Ok(Self(Beside::open(domain, rig, &$channel, waiting)?))
            }

            /// Sends the image on loan. Returns `false` if it was lost because the writer gave up
            /// waiting for a reader.
            ///
            /// # Errors
            /// No image is on loan, or the transport failed.
            pub fn send(&mut self) -> Result<bool, WriteError> {
                self.0.images.send(self.0.header)
            }

            /// Returns whether the slots have room for an image of this many bytes, as
            /// [`FrameWriter::has_room`](super::FrameWriter::has_room) does.
            pub fn has_room(&self, bytes: usize) -> bool {
                self.0.images.has_room(bytes)
            }

            /// Returns whether this writer waits for slow readers, so that each of them receives
            /// every image.
            pub fn is_lossless(&self) -> bool {
                self.0.images.is_lossless()
            }
        }
    };
}

writer! {
    /// Writes the masks of a rig whose chain has `mask = "external"`: one for each frame, as soon
    /// as the mask is ready.
    ///
    /// ```no_run
    /// use lariat_wire::{FrameReader, MaskWriter};
    ///
    /// let mut frames = FrameReader::open("default")?;
    /// let mut masks = MaskWriter::open("default")?;
    /// loop {
    ///     let Some(frame) = frames.wait(None)? else { continue };
    ///     let mask = masks.loan(frame.header())?; // a byte for each pixel, the higher the likelier rope
    ///     network(frame.header(), frame, mask);
    ///     masks.send()?;
    /// }
    /// # fn network(_: &lariat_wire::FrameHeader, _: &[u8], _: &mut [u8]) {}
    /// # #[allow(unreachable_code)]
    /// # Ok::<(), lariat_wire::WriteError>(())
    /// ```
    ///
    /// The mask carries its frame's trace, so that extract can match the two.
    MaskWriter, "masks", MASKS
}

writer! {
    /// Writes the depth images of a rig whose chain has a depth camera (`[camera] depth`): one for
    /// each frame, taken at about the same time.
    ///
    /// ```no_run
    /// use lariat_wire::{DepthWriter, FrameReader};
    ///
    /// let mut frames = FrameReader::open("default")?;
    /// let mut depths = DepthWriter::open("default")?;
    /// loop {
    ///     let Some(frame) = frames.wait(None)? else { continue };
    ///     // A whole number of 16 bits for each pixel of the depth camera, 0 where nothing is known.
    ///     let depth = depths.loan(frame.header(), [848, 480])?;
    ///     nearest_in_time(frame.header(), depth);
    ///     depths.send()?;
    /// }
    /// # fn nearest_in_time(_: &lariat_wire::FrameHeader, _: &mut [u8]) {}
    /// # #[allow(unreachable_code)]
    /// # Ok::<(), lariat_wire::WriteError>(())
    /// ```
    ///
    /// The depth image carries its frame's trace, so that fit can match the two.
    DepthWriter, "depth images", DEPTH
}

impl MaskWriter {
    /// Borrows the slot of a frame's mask: one byte per pixel of the frame, higher where rope is
    /// more likely, with rows without gaps. It still holds an earlier mask. A slot that was
    /// borrowed and not sent is returned.
    ///
    /// # Errors
    /// The frame is blank, or `/dev/shm` lacks the space.
    pub fn loan(&mut self, frame: &FrameHeader) -> Result<&mut [u8], WriteError> {
        self.0.loan(frame, frame.of_mask())
    }
}

impl DepthWriter {
    /// Borrows the slot of a frame's depth image of the given size, with rows without gaps. Each
    /// pixel is a 16-bit integer in native byte order, in the unit of the depth camera's
    /// calibration; 0 is unknown. The slot still holds an earlier image. A slot that was borrowed
    /// and not sent is returned.
    ///
    /// # Errors
    /// The frame is blank, the size is invalid, or `/dev/shm` lacks the space.
    pub fn loan(&mut self, frame: &FrameHeader, size: [u32; 2]) -> Result<&mut [u8], WriteError> {
        if size.iter().any(|&side| side > MAX_SIDE) {
            return Err(WriteError::NoImage);
        }
        self.0.loan(frame, frame.of_depth(size))
    }
}
