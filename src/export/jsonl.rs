//! Descriptors as JSON lines: one frame each.

use super::shapes::FrameObject;
use super::{Part, Written};
use crate::whole_file::{Existing, Growing};
use anyhow::{Context, Result, bail};
use std::io::{BufWriter, Write};
use std::path::Path;

pub(super) fn write(part: &Part, path: &Path) -> Result<Written> {
    let about = || format!("cannot write {}", path.display());
    let mut file = BufWriter::new(Growing::new(path)?);
    let mut frames = part.gathered()?;
    let (mut place, mut lines) = (0, 0_u64);
    while let Some(gathered) = frames.next()? {
        let wanted = part.is_wanted(place);
        place += 1;
        if let Some(descriptors) = gathered.descriptors().filter(|_| wanted) {
            serde_json::to_writer(&mut file, &FrameObject::of(descriptors)).with_context(about)?;
            file.write_all(b"\n").with_context(about)?;
            lines += 1;
        }
    }
    if lines == 0 {
        bail!("there are no descriptors in this part of the recording");
    }
    let file = file.into_inner().map_err(|error| error.into_error());
    file.with_context(about)?.place(Existing::Replace)?;
    Ok(Written {
        what: format!("the descriptors of {lines} frames"),
        notes: Vec::new(),
    })
}
