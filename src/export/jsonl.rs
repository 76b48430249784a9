//! Descriptors as JSON lines, one frame per line.

use super::shapes::FrameObject;
use super::{Part, Written};
use crate::versioned::Versioned;
use anyhow::{Context, Result, bail};
use std::io::{self, Write};

pub(super) fn write(part: &Part, file: &mut impl Write) -> Result<Written> {
    let about = || part.failure();
    let mut frames = part.gathered()?;
    let (mut place, mut lines) = (0, 0_u64);
    while let Some(gathered) = frames.next()? {
        let wanted = part.is_wanted(place);
        place += 1;
        if let Some(descriptors) = gathered.descriptors().filter(|_| wanted) {
            serde_json::to_writer(&mut *file, &Versioned::first(FrameObject::of(descriptors)))
                .map_err(io::Error::from)
                .with_context(about)?;
            file.write_all(b"\n").with_context(about)?;
            lines += 1;
        }
    }
    if lines == 0 {
        bail!("there are no descriptors in this part of the recording");
    }
    Ok(Written {
        what: format!("the descriptors of {lines} frames"),
        notes: Vec::new(),
    })
}
