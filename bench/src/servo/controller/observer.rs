//! The controller's observations: the descriptor from the public reader, or points of the
//! centerline, with an optional delay.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use lariat_control::Metric;
use lariat_wire::{
    CENTERLINES, Centerlines, Curve, Descriptor, Domain, MAX_POINTS, Reader, Receiver, Rope, Seen,
    Shape as Spline, Status, now_ns,
};

use super::METRIC_ROWS;
use crate::servo::job::{Features, Job, RAW_POINTS};
use lariat_chain::pipeline::CurveFitter;
use lariat_chain::settings::Settings;

/// State of the rope as observed.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Sight {
    Shape(Shape),
    /// The rope is out of sight.
    Lost,
    /// The newest image is too old.
    Stale,
    /// Zero ropes, or more than one.
    Absent,
}

/// A rope to steer by.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shape {
    pub(super) features: Vec<[f64; 2]>,
    /// Covariance of each point, `[xx, xy, yy]`, px². Empty if unknown.
    pub(super) covariances: Vec<[f64; 3]>,
    pub(super) exposed_ns: u64,
    pub(super) partial: bool,
}

impl Sight {
    pub(super) fn exposed_ns(&self) -> Option<u64> {
        match self {
            Self::Shape(shape) => Some(shape.exposed_ns),
            _ => None,
        }
    }
}

/// Source of the controller's observations.
pub(super) struct Observer {
    source: Source,
    target: Vec<[f64; 2]>,
    /// Rows of the basis that the target is expressed in. Empty if the features are points.
    rows: Vec<Vec<f64>>,
    delay: Duration,
    max_age: Duration,
    /// Delayed observations, oldest first, each with the time at which it becomes known.
    waiting: VecDeque<(Instant, Sight)>,
    /// The newest observation that is no longer delayed.
    known: Sight,
    whole: Whole,
}

/// Maximum relative change in length for a rope to count as completely visible. A rope does not
/// stretch, so a larger change means that more than its ends is covered, or that it is confused
/// with another.
const STRETCHED: f64 = 0.03;
/// Number of initial observations. Their median length is taken as the rope's length.
const FIRST_SIGHTS: usize = 15;

/// Length of the rope when all of it is visible.
#[derive(Default)]
pub(super) struct Whole {
    first_px: Vec<f64>,
}

impl Whole {
    /// Returns whether a rope of this length is completely visible.
    pub(super) fn is_it(&mut self, length_px: f64) -> bool {
        if self.first_px.len() < FIRST_SIGHTS {
            self.first_px.push(length_px);
            self.first_px.sort_by(f64::total_cmp);
        }
        let whole_px = self.first_px[self.first_px.len() / 2];
        (length_px - whole_px).abs() <= STRETCHED * whole_px
    }
}

enum Source {
    Descriptors(Box<Reader>),
    Points(Box<Receiver<Centerlines>>),
}

impl Observer {
    pub(super) fn open(settings: &Settings, job: &Job, target: &[[f64; 2]]) -> Result<Self> {
        let domain = Domain::open()?;
        let rig = settings.run.rig.parse().context("the rig has no name")?;
        let (source, target, rows) = match job.features {
            Features::Descriptor => {
                let (target, rows) = described(target, settings)?;
                let reader = Reader::open_in(domain, &rig)?;
                (Source::Descriptors(Box::new(reader)), target, rows)
            }
            Features::Points => {
                let receiver = Receiver::create(&domain, &rig, &CENTERLINES, None)?;
                let target = lariat_simulation::at_equal_steps(target, RAW_POINTS);
                (Source::Points(Box::new(receiver)), target, Vec::new())
            }
        };
        let delay = Duration::from_secs_f64(job.delay_ms / 1e3);
        // Three frames: the longest delay of a chain that loses none.
        let late_s = (3.0 * job.period_s).max(0.1);
        Ok(Self {
            source,
            target,
            rows,
            delay,
            max_age: Duration::from_secs_f64(late_s),
            waiting: VecDeque::new(),
            known: Sight::Absent,
            whole: Whole::default(),
        })
    }

    /// Returns the target in the features' units.
    pub(super) fn target(&self) -> &[f64] {
        self.target.as_flattened()
    }

    /// Returns the metric for the distance between two shapes.
    pub(super) fn metric(&self) -> Result<Metric> {
        if self.rows.is_empty() {
            return Ok(Metric::default());
        }
        let rows = self.rows.iter().map(Vec::as_slice);
        Metric::of_rows(rows).context("the curve cannot be measured by")
    }

    /// Waits until the deadline or until an observation becomes known. Returns the newest known
    /// observation.
    pub(super) fn look(&mut self, deadline: Instant) -> Result<Sight> {
        let due = self.waiting.front().map(|(due, _)| *due);
        let until = due.map_or(deadline, |due| due.min(deadline));
        if let Some(sight) = self.see(until)? {
            self.waiting.push_back((Instant::now() + self.delay, sight));
        }
        let now = Instant::now();
        while let Some((due, _)) = self.waiting.front()
            && *due <= now
            && let Some((_, sight)) = self.waiting.pop_front()
        {
            self.known = sight;
        }
        let oldest_ns = (self.max_age + self.delay).as_nanos() as u64;
        let is_old = |exposed_ns: u64| now_ns().saturating_sub(exposed_ns) > oldest_ns;
        if self.known.exposed_ns().is_some_and(is_old) {
            self.known = Sight::Stale;
        }
        Ok(self.known.clone())
    }

    /// Returns the observation in the next image. Returns `None` if none arrives in time.
    fn see(&mut self, until: Instant) -> Result<Option<Sight>> {
        match &mut self.source {
            Source::Descriptors(reader) => {
                let frame = reader.wait(until)?;
                if !frame.is_new() {
                    return Ok(None);
                }
                Ok(Some(match frame.only_rope(self.max_age) {
                    // Ends in a gripper's jaws are always covered, so only other hidden parts
                    // count. An unsure rope is accepted too, because whatever is in the jaws is a
                    // rope. The law compares descriptors and does not need an accurate curve; some
                    // cases use few control points on purpose.
                    Seen::Fresh(rope) | Seen::Partial(rope) | Seen::Unsure(rope, _) => {
                        let is_whole = self.whole.is_it(rope.length());
                        by_descriptor(&rope, rope.hidden() > 0.0 || !is_whole)
                    }
                    Seen::Lost(_) => Sight::Lost,
                    Seen::Stale(_) => Sight::Stale,
                    Seen::Absent(_) => Sight::Absent,
                }))
            }
            Source::Points(receiver) => {
                let message = receiver.wait(until)?;
                Ok(message.map(|message| by_points(&message, &mut self.whole)))
            }
        }
    }
}

fn by_descriptor(rope: &Rope, partial: bool) -> Sight {
    let covariances = match rope.shape() {
        Ok(_) => {
            let count = rope.control_points().len();
            rope.descriptor().covariances[..count].to_vec()
        }
        Err(_) => return Sight::Absent,
    };
    Sight::Shape(Shape {
        features: rope.control_points().to_vec(),
        covariances,
        exposed_ns: rope.exposed_ns(),
        partial,
    })
}

fn by_points(seen: &Centerlines, whole: &mut Whole) -> Sight {
    let mut curves = seen.curves().iter();
    let (Some(curve), None) = (curves.next(), curves.next()) else {
        return Sight::Absent;
    };
    match curve.status() {
        Some(Status::Ok | Status::Partial | Status::Doubtful) => {
            let is_whole = whole.is_it(f64::from(curve.length_px));
            let is_hidden = curve.hidden.iter().any(|&word| word != 0);
            let points: Vec<[f64; 2]> = curve.points().iter().map(|p| p.map(f64::from)).collect();
            Sight::Shape(Shape {
                features: lariat_simulation::at_equal_steps(&points, RAW_POINTS),
                covariances: Vec::new(),
                exposed_ns: seen.trace.exposed_ns,
                partial: is_hidden || !is_whole,
            })
        }
        Some(Status::Lost) => Sight::Lost,
        None => Sight::Absent,
    }
}

/// A curve's control points, and the rows of its basis at even steps.
type Described = (Vec<[f64; 2]>, Vec<Vec<f64>>);

/// Fits the target as a descriptor of the chain's own kind.
fn described(target: &[[f64; 2]], settings: &Settings) -> Result<Described> {
    let count = settings.extract.points.min(MAX_POINTS);
    let points = lariat_simulation::at_equal_steps(target, count);
    let mut curve = Box::new(Curve::EMPTY);
    curve.count = count as u32;
    for (to, from) in curve.points.iter_mut().zip(&points) {
        *to = from.map(|at| at as f32);
    }
    let mut descriptor = Box::new(Descriptor::EMPTY);
    CurveFitter::new(settings)?
        .describe(&curve, 0, &mut descriptor)
        .context("the target cannot be fitted")?;
    let shape = Spline::of(&descriptor).context("the target has no shape")?;
    let rows = (0..METRIC_ROWS).map(|i| shape.even_rho(i, METRIC_ROWS));
    let rows = rows.map(|rho| shape.jacobian_at(rho).to_vec()).collect();
    Ok((shape.control_points().to_vec(), rows))
}
