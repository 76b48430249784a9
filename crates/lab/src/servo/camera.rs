//! Films a rope that is driven: what the chain sees and says, and what its controller commands, from the rig's own channels.

use anyhow::{Context, Result};
use lariat_wire::{CommandReader, Domain, FRAMES, PixelFormat, Reader, Receiver, Rig, Seen, Trace};

use super::film::{Film, Shot};

/// Points that the curve is drawn through.
const DRAWN_POINTS: usize = 60;
/// What is older than this is not what the controller goes by.
const MAX_AGE: std::time::Duration = std::time::Duration::from_millis(200);

/// A film in the making, and what it is made from.
pub(super) struct Camera {
    frames: Receiver<[u8]>,
    reader: Reader,
    commands: CommandReader,
    velocities: Vec<[f64; 3]>,
    target: Vec<[f64; 2]>,
    film: Option<Film>,
    rgb: Vec<u8>,
}

impl Camera {
    /// Of a rig's next ropes, which are driven to a target.
    pub(super) fn open(domain: &Domain, rig: &Rig, target: &[[f64; 2]]) -> Result<Self> {
        Ok(Self {
            frames: Receiver::create_unwoken(domain, rig, &FRAMES, None)?,
            reader: Reader::open_in(Domain::open()?, rig)?,
            commands: CommandReader::open(Domain::open()?, rig)?,
            velocities: Vec::new(),
            target: target.to_vec(),
            film: None,
            rgb: Vec::new(),
        })
    }

    /// Takes what there is of a moment. `ends`: where the rope leaves the grippers.
    pub(super) fn take(
        &mut self,
        trace: &Trace,
        ends: [[f64; 2]; 2],
        (at_s, error_px): (f64, f64),
    ) -> Result<()> {
        while let Some(command) = self.commands.next()? {
            self.velocities.clear();
            let in_picture = |&[x, y, .., turn]: &[f64; 6]| [x, y, turn];
            self.velocities
                .extend(command.velocities().iter().map(in_picture));
        }
        let Some(frame) = self.frames.latest()? else {
            return Ok(());
        };
        let header = *frame.header();
        let size = [header.width as usize, header.height as usize];
        let is_usable = header.format() == Some(PixelFormat::Rgb8)
            && header.stride as usize == 3 * size[0]
            && header.trace.captured.abs_diff(trace.captured) <= 1;
        if !is_usable {
            return Ok(());
        }
        let film = self
            .film
            .get_or_insert_with(|| Film::new(size, &self.target));
        let wanted = film.wants(at_s);
        self.rgb.clear();
        if wanted {
            self.rgb.extend_from_slice(&frame[..3 * size[0] * size[1]]);
        }
        drop(frame);
        let frame = self.reader.latest()?;
        let (seen, control_points) = match frame.only_rope(MAX_AGE) {
            Seen::Fresh(rope) | Seen::Partial(rope) | Seen::Unsure(rope, _) if wanted => {
                let shape = rope.shape().ok();
                let points = shape.map(|shape| shape.points::<DRAWN_POINTS>());
                (points, rope.control_points())
            }
            _ => (None, &[][..]),
        };
        let grippers: Vec<_> = ends
            .into_iter()
            .zip(self.velocities.iter().copied())
            .collect();
        film.add(&Shot {
            rgb: &self.rgb,
            seen: seen.as_ref().map(|points| &points[..]),
            control_points,
            grippers: &grippers,
            at_s,
            error_px,
        });
        Ok(())
    }

    /// The film as a GIF.
    pub(super) fn finish(self) -> Result<Vec<u8>> {
        let film = self.film.context("no image of the rope was seen to film")?;
        film.finish().context("the film could not be made")
    }
}
