//! Images that go beside frames: masks, and depth.

use std::fmt;

use super::{Images, Waiting};
use crate::channel::{Channel, DEPTH, MASKS};
use crate::error::MAX_SIDE;
use crate::{Domain, FrameHeader, Rig, WireError, WriteError};

/// Their end of a channel, and what stands beside the one on loan.
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

    /// Borrows the slot of an image that this header describes, beside this frame.
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
            /// As [`FrameWriter::open`](super::FrameWriter::open).
            pub fn open(rig: &str) -> Result<Self, WriteError> {
                Self::open_in(Domain::open()?, &rig.parse()?, Waiting::default())
            }

            /// The same, in a domain of one's own choice, and with a word on slow readers.
            ///
            /// # Errors
            /// As [`FrameWriter::open_in`](super::FrameWriter::open_in).
            pub fn open_in(domain: Domain, rig: &Rig, waiting: Waiting) -> Result<Self, WriteError> {
                Ok(Self(Beside::open(domain, rig, &$channel, waiting)?))
            }

            /// Sends the image on loan. `false`: it was lost, because waiting for a reader was given up.
            ///
            /// # Errors
            /// There is nothing to send, or the transport failed.
            pub fn send(&mut self) -> Result<bool, WriteError> {
                self.0.images.send(self.0.header)
            }

            /// Whether its slots have room for an image of so many bytes, as
            /// [`FrameWriter::has_room`](super::FrameWriter::has_room).
            pub fn has_room(&self, bytes: usize) -> bool {
                self.0.images.has_room(bytes)
            }

            /// Whether it waits for slow readers, so that each of them has every image.
            pub fn is_lossless(&self) -> bool {
                self.0.images.is_lossless()
            }
        }
    };
}

writer! {
    /// Writes the masks of a rig whose chain has `mask = "external"`: one for each frame, as soon as it is made.
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
    /// It carries its frame's trace, by which extract knows whose mask it is.
    MaskWriter, "masks", MASKS
}

writer! {
    /// Writes the depth images of a rig whose chain has a depth camera (`[camera] depth`): one for each frame, taken at the same
    /// time or nearly.
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
    /// It carries its frame's trace, by which fit knows whose it is.
    DepthWriter, "depth images", DEPTH
}

impl MaskWriter {
    /// Borrows the slot of a frame's mask: a byte for each pixel of the frame, the higher the likelier rope, rows without gaps. It
    /// holds an earlier one's. A slot that was borrowed and not sent is given back.
    ///
    /// # Errors
    /// The frame has no image, or there is no room for its mask in `/dev/shm`.
    pub fn loan(&mut self, frame: &FrameHeader) -> Result<&mut [u8], WriteError> {
        self.0.loan(frame, frame.of_mask())
    }
}

impl DepthWriter {
    /// Borrows the slot of a frame's depth image, of its own size: two bytes for each pixel, a whole number in the machine's own order,
    /// in the unit that the depth camera's calibration says; 0 where nothing is known. Rows without gaps. It holds an earlier
    /// one's. A slot that was borrowed and not sent is given back.
    ///
    /// # Errors
    /// The frame has no image, or the size is none; or there is no room for it in `/dev/shm`.
    pub fn loan(&mut self, frame: &FrameHeader, size: [u32; 2]) -> Result<&mut [u8], WriteError> {
        if size.iter().any(|&side| side > MAX_SIDE) {
            return Err(WriteError::NoImage);
        }
        self.0.loan(frame, frame.of_depth(size))
    }
}
