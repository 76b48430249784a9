//! The thread that writes a recording. It takes messages from the queue and returns their buffers.

use crossbeam::channel::RecvTimeoutError;

use super::error::WriteError;
use super::pictures::{Images, PictureMaker};
use super::queue::{Item, Order, Outlet, Parcel};
use super::recorder::Ending;
use super::topic::Topic;
use super::writer::{Writer, Written};

/// Writes until the queue's other end is gone.
pub(crate) fn to_file(mut writer: Writer, outlet: Outlet, images: Images) -> Ending {
    let mut developer = Developer::new(images);
    let fault = loop {
        let outcome = match outlet.next(writer.due()) {
            Ok(Item::Message(parcel)) => write(&mut writer, &mut developer, parcel, &outlet),
            Ok(Item::Order(order)) => obey(&mut writer, *order),
            Err(RecvTimeoutError::Timeout) => writer.commit_if_due(),
            Err(RecvTimeoutError::Disconnected) => break None,
        };
        if let Err(fault) = outcome {
            break Some(fault);
        }
    };
    // The reader must not wait while the file is closed.
    drop(outlet);
    end(writer, fault)
}

/// Closes a recording, including one that ended early.
pub(super) fn end(writer: Writer, fault: Option<WriteError>) -> Ending {
    match (writer.finish(), fault) {
        (Ok(written), fault) => Ending { written, fault },
        (Err(closing), fault) => Ending {
            written: Written::default(),
            fault: fault.or(Some(closing)),
        },
    }
}

fn write(
    writer: &mut Writer,
    developer: &mut Developer,
    parcel: Parcel,
    outlet: &Outlet,
) -> Result<(), WriteError> {
    let Parcel {
        topic,
        sequence,
        log_ns,
        cdr,
        ..
    } = parcel;
    let outcome = match developer.develop(topic, &cdr) {
        Some((topic, picture)) => writer.write(topic, sequence, log_ns, picture),
        None => writer.write(topic, sequence, log_ns, &cdr),
    };
    outlet.give_back(cdr);
    outcome
}

fn obey(writer: &mut Writer, order: Order) -> Result<(), WriteError> {
    match order {
        Order::Attach {
            name,
            media_type,
            log_ns,
            bytes,
        } => writer.attach(&name, media_type, log_ns, &bytes),
        Order::About(about) => writer.about(&about),
        Order::Flush(_) => Ok(()),
    }
}

/// Encodes images as pictures if requested.
pub(super) struct Developer {
    images: Images,
    maker: PictureMaker,
    cdr: Vec<u8>,
}

impl Developer {
    pub(super) fn new(images: Images) -> Self {
        Self {
            images,
            maker: PictureMaker::default(),
            cdr: Vec::new(),
        }
    }

    /// Returns the picture that replaces a message, if it is an image to encode. Masks distinguish
    /// zero from other values, which JPEG does not preserve, so they become PNG.
    pub(super) fn develop(&mut self, topic: Topic, cdr: &[u8]) -> Option<(Topic, &[u8])> {
        let (topic, images) = match (topic, self.images) {
            (Topic::Image, Images::Png | Images::Jpeg(_)) => (Topic::Picture, self.images),
            (Topic::MaskImage, Images::Png | Images::Jpeg(_)) => (Topic::MaskPicture, Images::Png),
            _ => return None,
        };
        // The image was written by this library, so decoding should not fail. If it does, the image
        // is recorded as it is.
        let made = self.maker.make(cdr, images, &mut self.cdr);
        made.unwrap_or(false).then_some((topic, &self.cdr))
    }
}
