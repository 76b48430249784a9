//! Writes masks of a topic as the rig's masks. Each mask is paired with its frame by stamp, in
//! either order of arrival.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;

use lariat_wire::{MaskWriter, PixelFormat, WriteError};

use super::frames::Sent;
use super::pixels::{Pixels, decode, shown};
use super::received::{Picture, TakePicture};
use super::trouble::{Tally, Trouble, TroubleReporter};

/// Number of masks that may wait for their image, which is larger and may arrive later.
const MOST_WAITING: usize = 4;

/// The rig's masks.
pub(super) struct Masks {
    topic: String,
    writer: MaskWriter,
    sent: Rc<RefCell<Sent>>,
    waiting: VecDeque<Mask>,
    tally: Arc<Tally>,
    reporter: TroubleReporter,
}

/// A mask whose image has not arrived.
struct Mask {
    stamp_ns: u64,
    size: [u32; 2],
    bytes: Vec<u8>,
}

/// The result of reading a message.
pub(super) enum Taken {
    /// The mask is in its slot and only needs to be sent.
    Lent,
    /// The image has not arrived.
    Early {
        stamp_ns: u64,
        size: [u32; 2],
        bytes: Vec<u8>,
    },
    /// An image file that still has to be decoded.
    File { stamp_ns: u64, file: Vec<u8> },
}

impl Masks {
    pub(super) fn new(
        topic: &str,
        writer: MaskWriter,
        sent: Rc<RefCell<Sent>>,
        tally: Arc<Tally>,
    ) -> Self {
        Self {
            topic: topic.to_owned(),
            writer,
            sent,
            waiting: VecDeque::new(),
            tally,
            reporter: TroubleReporter::default(),
        }
    }

    /// Sends the mask that was read, or keeps it until its image arrives.
    pub(super) fn send(&mut self, taken: Result<Taken, Trouble>) {
        if let Err(trouble) = taken.and_then(|taken| self.send_taken(taken)) {
            self.refuse(&trouble);
        }
    }

    /// Sends the mask of the image with this stamp, which has become a frame, if the mask arrived
    /// first.
    pub(super) fn offer(&mut self, stamp_ns: u64) {
        let place = self
            .waiting
            .iter()
            .position(|mask| mask.stamp_ns == stamp_ns);
        if let Some(mask) = place.and_then(|place| self.waiting.remove(place)) {
            let copy = |slot: &mut [u8]| slot.copy_from_slice(&mask.bytes);
            let taken = self.lend(stamp_ns, mask.size, copy);
            self.send(taken.map(|_| Taken::Lent));
        }
    }

    /// Counts an invalid mask.
    pub(super) fn refuse(&mut self, trouble: &Trouble) {
        self.tally.refuse();
        self.reporter.report(&self.topic, trouble);
    }

    fn send_taken(&mut self, taken: Taken) -> Result<(), Trouble> {
        let (stamp_ns, size, bytes) = match taken {
            Taken::Lent => {
                self.writer.send().map_err(not_written)?;
                self.tally.take();
                return Ok(());
            }
            Taken::Early {
                stamp_ns,
                size,
                bytes,
            } => (stamp_ns, size, bytes),
            Taken::File { stamp_ns, file } => {
                let read = decode(&file)?;
                if read.format != PixelFormat::Gray8 {
                    return Err(Trouble::MaskEncoding("a picture in color".to_owned()));
                }
                let size = [read.width, read.height];
                if self.lend(stamp_ns, size, |slot| slot.copy_from_slice(&read.bytes))? {
                    return self.send_taken(Taken::Lent);
                }
                (stamp_ns, size, read.bytes)
            }
        };
        self.waiting.push_back(Mask {
            stamp_ns,
            size,
            bytes,
        });
        if self.waiting.len() > MOST_WAITING
            && let Some(Mask { stamp_ns, .. }) = self.waiting.pop_front()
        {
            return Err(Trouble::NoImage { stamp_ns });
        }
        Ok(())
    }

    /// Lets `copy` fill the slot of the mask, if its image has arrived.
    fn lend(
        &mut self,
        stamp_ns: u64,
        size: [u32; 2],
        copy: impl FnOnce(&mut [u8]),
    ) -> Result<bool, Trouble> {
        let Some(frame) = self.sent.borrow().of(stamp_ns).copied() else {
            return Ok(false);
        };
        if size != [frame.width, frame.height] {
            let words = |[width, height]: [u32; 2]| format!("{width}×{height}");
            return Err(Trouble::MaskSize {
                mask: words(size),
                image: words([frame.width, frame.height]),
            });
        }
        copy(self.writer.loan(&frame).map_err(not_written)?);
        Ok(true)
    }
}

impl TakePicture for Masks {
    type Taken = Result<Taken, Trouble>;

    fn take(&mut self, picture: Picture) -> Self::Taken {
        let image = match picture {
            Picture::Raw(image) => image,
            Picture::File(image) => {
                return Ok(Taken::File {
                    stamp_ns: image.header.stamp_ns(),
                    file: image.data.to_vec(),
                });
            }
        };
        let pixels = Pixels::of(&image)?;
        if pixels.format != PixelFormat::Gray8 {
            return Err(Trouble::MaskEncoding(shown(&image.encoding)));
        }
        let (stamp_ns, size) = (image.header.stamp_ns(), [pixels.width, pixels.height]);
        if self.lend(stamp_ns, size, |slot| pixels.copy_to(slot))? {
            return Ok(Taken::Lent);
        }
        let mut bytes = vec![0; pixels.width as usize * pixels.height as usize];
        pixels.copy_to(&mut bytes);
        Ok(Taken::Early {
            stamp_ns,
            size,
            bytes,
        })
    }
}

fn not_written(cause: WriteError) -> Trouble {
    Trouble::NotWritten(cause.to_string())
}
