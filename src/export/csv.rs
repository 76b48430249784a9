//! Control points as a table: a row for each rope in each frame. A frame without a rope has one row
//! with empty cells.

use super::shapes::{basis, fit, status, unit};
use super::{Part, Written};
use anyhow::{Context, Result, bail};
use lariat_record::Entry;
use lariat_wire::Descriptors;
use std::io::{self, Write};

/// Columns before the control points.
const COLUMNS: &str = "sequence,exposed_ns,rope,track,status,closed,basis,degree,unit,length,width,confidence,fit,rms,max,filtered";

pub(super) fn write(part: &Part, file: &mut impl Write) -> Result<Written> {
    let about = || part.failure();
    let points = most_points(part)?;
    file.write_all(head(points).as_bytes())
        .with_context(about)?;
    let mut frames = part.gathered()?;
    let (mut place, mut rows) = (0, 0);
    while let Some(gathered) = frames.next()? {
        let wanted = part.is_wanted(place);
        place += 1;
        if let Some(descriptors) = gathered.descriptors().filter(|_| wanted) {
            rows += write_frame(file, descriptors, points).with_context(about)?;
        }
    }
    if rows == 0 {
        bail!("there are no descriptors in this part of the recording");
    }
    Ok(Written {
        what: format!("{rows} rows of up to {points} control points"),
        notes: Vec::new(),
    })
}

/// Largest number of control points of any rope. The first row already depends on it.
fn most_points(part: &Part) -> Result<usize> {
    let mut messages = part.frames()?;
    let mut most = 0;
    while let Some(entry) = messages.next()? {
        if let Entry::Descriptors(message) = entry {
            let counts = message.curves().iter().map(|c| c.control_points().len());
            most = counts.fold(most, usize::max);
        }
    }
    Ok(most)
}

fn head(points: usize) -> String {
    let mut head = COLUMNS.to_owned();
    for i in 0..points {
        head.push_str(&format!(",x{i},y{i}"));
    }
    head.push('\n');
    head
}

/// Writes a frame and returns the number of rows. Numbers have full precision.
fn write_frame(to: &mut impl Write, message: &Descriptors, points: usize) -> io::Result<u64> {
    let trace = &message.trace;
    let beginning = [trace.sequence, trace.exposed_ns];
    let columns = COLUMNS.split(',').count() + 2 * points;
    if message.curves().is_empty() {
        let empty = ",".repeat(columns - beginning.len());
        writeln!(to, "{},{}{empty}", beginning[0], beginning[1])?;
        return Ok(1);
    }
    for (i, curve) in message.curves().iter().enumerate() {
        write!(
            to,
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            beginning[0],
            beginning[1],
            i + 1,
            curve.track,
            status(curve),
            u32::from(curve.closed != 0),
            basis(curve),
            curve.degree,
            unit(message),
            curve.length,
            curve.width,
            curve.confidence,
            fit(curve),
            curve.rms,
            curve.max,
            curve.filtered
        )?;
        let own = curve.control_points();
        for [x, y] in own {
            write!(to, ",{x},{y}")?;
        }
        let empty = ",".repeat(2 * points.saturating_sub(own.len()));
        writeln!(to, "{empty}")?;
    }
    Ok(message.curves().len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_as_many_columns_as_the_head() {
        let mut message = Box::new(Descriptors::EMPTY);
        let mut text = Vec::new();
        write_frame(&mut text, &message, 3).unwrap();
        message.count = 2;
        message.curves[0].count = 3;
        message.curves[1].count = 1;
        write_frame(&mut text, &message, 3).unwrap();
        let text = head(3) + &String::from_utf8(text).unwrap();
        let columns: Vec<_> = text.lines().map(|row| row.split(',').count()).collect();
        assert_eq!(columns, [22; 4]);
        assert!(text.contains(",x2,y2\n"));
    }
}
