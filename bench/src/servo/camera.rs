//! Films a rope that is driven. Uses the rig's own channels: the chain's frames and results, and
//! the controller's commands.

mod views;

use anyhow::{Context, Result};
use lariat_wire::{
    CommandReader, Domain, FRAMES, PixelFormat, Reader, Receiver, Rig, Rope, Seen, Trace,
};

use super::film::{Film, Shot, Sketch};
use super::job::Wanted;
use views::Views;

/// Points that the curve is drawn through.
const DRAWN_POINTS: usize = 60;
/// Maximum age of an observation. The controller does not use older ones.
const MAX_AGE: std::time::Duration = std::time::Duration::from_millis(200);

/// A film in progress and its sources.
pub(super) struct Camera {
    frames: Receiver<[u8]>,
    reader: Reader,
    commands: CommandReader,
    /// The last commanded velocity of each gripper.
    velocities: Vec<[f64; 6]>,
    wanted: Wanted,
    /// The film, and the views of a lifted rope.
    film: Option<(Film, Option<Views>)>,
    rgb: Vec<u8>,
}

/// True position of the rope: its points in the picture, px, or in the robot's frame, mm.
pub(super) enum Truth {
    InPlane(Vec<[f64; 2]>),
    InSpace(Vec<[f64; 3]>),
}

impl Camera {
    /// Opens the channels of a rig whose next ropes are driven to a target.
    pub(super) fn open(domain: &Domain, rig: &Rig, wanted: &Wanted) -> Result<Self> {
        let mut reader = Reader::open_in(Domain::open()?, rig)?;
        if let Wanted::InSpace { .. } = wanted {
            reader.follow_in_space()?;
        }
        Ok(Self {
            frames: Receiver::create_unwoken(domain, rig, &FRAMES, None)?,
            reader,
            commands: CommandReader::open(Domain::open()?, rig)?,
            velocities: Vec::new(),
            wanted: wanted.clone(),
            film: None,
            rgb: Vec::new(),
        })
    }

    /// Adds the available data for one time.
    pub(super) fn take(
        &mut self,
        trace: &Trace,
        truth: &Truth,
        (at_s, error_px): (f64, f64),
    ) -> Result<()> {
        while let Some(command) = self.commands.next()? {
            self.velocities.clear();
            self.velocities.extend_from_slice(command.velocities());
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
        let wanted = &self.wanted;
        let (film, views) = (self.film).get_or_insert_with(|| begin(wanted, size));
        let mut sketch = Sketch::default();
        self.rgb.clear();
        if film.wants(at_s) {
            self.rgb.extend_from_slice(&frame[..3 * size[0] * size[1]]);
            drop(frame);
            let frame = self.reader.latest()?;
            let rope = match frame.only_rope(MAX_AGE) {
                Seen::Fresh(rope) | Seen::Partial(rope) | Seen::Unsure(rope, _) => Some(rope),
                _ => None,
            };
            let velocities = &self.velocities;
            sketch = match (views, truth) {
                (Some(views), Truth::InSpace(truth)) => {
                    views.add_side(&mut self.rgb);
                    views.sketch(rope.as_ref(), truth, velocities)
                }
                (None, Truth::InPlane(truth)) => in_picture(rope.as_ref(), truth, velocities),
                _ => sketch,
            };
        }
        film.add(&Shot {
            rgb: &self.rgb,
            sketch: &sketch,
            at_s,
            error_px,
        });
        Ok(())
    }

    /// Returns the film as a GIF.
    pub(super) fn finish(self) -> Result<Vec<u8>> {
        let (film, _) = self.film.context("no image of the rope was seen to film")?;
        film.finish().context("the film could not be made")
    }
}

/// Creates a film for images of this size, with the target.
fn begin(wanted: &Wanted, size: [usize; 2]) -> (Film, Option<Views>) {
    match wanted {
        Wanted::InPlane { target, .. } => (Film::new(size, std::slice::from_ref(target)), None),
        Wanted::InSpace { target, .. } => {
            let views = Views::new(size);
            (Film::new(views.size(), &views.lines(target)), Some(views))
        }
    }
}

/// Returns the sketch of a rope on the table.
fn in_picture(rope: Option<&Rope>, truth: &[[f64; 2]], velocities: &[[f64; 6]]) -> Sketch {
    let shape = rope.and_then(|rope| rope.shape().ok());
    let moves = velocities.iter().map(|&[x, y, .., turn]| [x, y, turn]);
    Sketch {
        seen: shape
            .map(|shape| shape.points::<DRAWN_POINTS>().to_vec())
            .into_iter()
            .collect(),
        control_points: rope
            .map(|rope| rope.control_points().to_vec())
            .unwrap_or_default(),
        grippers: ends(truth).zip(moves).collect(),
        ..Sketch::default()
    }
}

/// Returns the points where a rope leaves its grippers.
fn ends<const D: usize>(truth: &[[f64; D]]) -> impl Iterator<Item = [f64; D]> {
    [truth.first(), truth.last()].into_iter().flatten().copied()
}
