//! One frame, with everything that is known about it. The page shows one such moment at a time.

use std::sync::{Mutex, OnceLock, PoisonError};

use lariat_camera::{Jacobian, Mapping};
use lariat_chain::places;
use lariat_record::Losses;
use lariat_sink::points_along;
use lariat_wire::{
    Basis, Centerlines, Curve, Descriptor, Descriptors, FitQuality, FrameHeader, Status, Trace,
    Unit,
};
use serde::Serialize;

use crate::picture::{Rgb, rgb};

/// Number of points that a curve is drawn with.
const DRAWN: usize = 160;

/// A frame's image, copied out of shared memory.
#[derive(Debug)]
pub(crate) struct Image {
    pub(crate) header: FrameHeader,
    pub(crate) bytes: Vec<u8>,
}

/// One frame, and what is known about it.
#[derive(Debug)]
pub(crate) struct Moment {
    /// Number among the moments that were shown, from 1.
    pub(crate) number: u64,
    /// `None` if the source provides none, or newer images have overtaken it.
    pub(crate) image: Option<Image>,
    pub(crate) centerlines: Option<Box<Centerlines>>,
    pub(crate) descriptors: Box<Descriptors>,
    /// Frames lost before this one, since the server began to watch the rig.
    pub(crate) losses: Losses,
    /// Doubt of the extraction, if the page itself has asked for it.
    pub(crate) notice: Option<String>,
    /// Mapping from the picture to the coordinates of the curves, if these are not the picture's
    /// and the mapping is known.
    pub(crate) places: Option<Mapping>,
    said: OnceLock<String>,
    rgb: OnceLock<Option<Rgb>>,
    /// JPEGs by their factor of reduction.
    jpegs: Mutex<Vec<(u32, Option<tungstenite::Bytes>)>>,
}

impl Moment {
    pub(crate) fn new(
        number: u64,
        image: Option<Image>,
        centerlines: Option<Box<Centerlines>>,
        descriptors: Box<Descriptors>,
        losses: Losses,
    ) -> Self {
        Self {
            number,
            image,
            centerlines,
            descriptors,
            losses,
            notice: None,
            places: None,
            said: OnceLock::new(),
            rgb: OnceLock::new(),
            jpegs: Mutex::default(),
        }
    }

    /// Returns where in the picture a point of the descriptors is visible; `None` if it is not
    /// visible, or if that is unknown.
    pub(crate) fn pixel(&self, point: [f64; 2]) -> Option<[f64; 2]> {
        places::pixel(&self.descriptors, self.places.as_ref(), point)
    }

    /// Returns the pixels: red, green and blue.
    pub(crate) fn rgb(&self) -> Option<&Rgb> {
        let rgb = self.rgb.get_or_init(|| {
            let image = self.image.as_ref()?;
            rgb(&image.header, &image.bytes)
        });
        rgb.as_ref()
    }

    /// Returns the picture, `times` times smaller. The first caller encodes it.
    pub(crate) fn jpeg(&self, times: u32) -> Option<tungstenite::Bytes> {
        let mut jpegs = self.jpegs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, jpeg)) = jpegs.iter().find(|(known, _)| *known == times) {
            return jpeg.clone();
        }
        let jpeg = self.rgb().and_then(|rgb| rgb.jpeg(times));
        let jpeg = jpeg.map(tungstenite::Bytes::from);
        jpegs.push((times, jpeg.clone()));
        jpeg
    }

    /// Returns everything that is drawn over the picture, as JSON.
    pub(crate) fn said(&self) -> &str {
        self.said.get_or_init(|| {
            let said = Said::of(self);
            serde_json::to_string(&said).unwrap_or_else(|_| "{}".to_owned())
        })
    }
}

/// Overlay of a frame. Positions are pixels of the whole image, and the center of the top-left
/// pixel is (0, 0).
#[derive(Debug, Serialize)]
struct Said<'a> {
    number: u64,
    frame: u64,
    width: u32,
    height: u32,
    unit: &'static str,
    /// Timestamps of the frame's steps in µs since the exposure; 0 if unknown.
    way_us: [u64; 6],
    /// Time of the exposure, in ms of the machine's clock.
    exposed_ms: f64,
    ropes: Vec<RopeSaid>,
    crossings: Vec<CrossingSaid>,
    #[serde(skip_serializing_if = "Option::is_none")]
    notice: Option<&'a str>,
}

#[derive(Debug, Serialize)]
struct RopeSaid {
    track: u32,
    status: Option<&'static str>,
    closed: bool,
    basis: &'static str,
    degree: u32,
    control_points: u32,
    length: f64,
    width: f64,
    rms: f64,
    max: f64,
    coarse: bool,
    confidence: f64,
    age_s: f64,
    /// Points where the rope was seen, in pixels, and the indices of those that are covered.
    points: Vec<[f64; 2]>,
    hidden: Vec<usize>,
    width_px: f64,
    /// Points along the curve; empty without a curve, or if its position in the picture is unknown.
    curve: Vec<[f64; 2]>,
    control: Vec<[f64; 2]>,
    /// `[xx, xy, yy]`, px².
    covariances: Vec<[f64; 3]>,
}

#[derive(Debug, Serialize)]
struct CrossingSaid {
    at: [f64; 2],
    over: u32,
    under: u32,
    over_rho: f64,
    confidence: f64,
}

impl<'a> Said<'a> {
    fn of(moment: &'a Moment) -> Self {
        let shapes = &moment.descriptors;
        let seen = moment.centerlines.as_deref();
        let is_of_image = shapes.unit() == Some(Unit::Pixel);
        let places = moment.places.as_ref();
        let seen_at = |point| Projection::new(moment.pixel(point)?, places);
        let curve_of = |track| {
            let mut curves = seen.into_iter().flat_map(Centerlines::curves);
            curves.find(|curve| curve.track == track)
        };
        let ropes = shapes.curves().iter().map(|shape| {
            let mut rope = RopeSaid::of(shape, &seen_at);
            match curve_of(shape.track) {
                Some(curve) => rope.see(curve),
                None if is_of_image => rope.see_points(shapes, shape.track),
                None => {}
            }
            rope
        });
        let crossings = seen.into_iter().flat_map(|seen| {
            let track = |index: u32| {
                seen.curves()
                    .get(index as usize)
                    .map_or(0, |curve| curve.track)
            };
            seen.crossings().iter().map(move |crossing| CrossingSaid {
                at: crossing.at.map(|x| short(x.into())),
                over: track(crossing.over),
                under: track(crossing.under),
                over_rho: short(crossing.over_rho.into()),
                confidence: short(crossing.confidence.into()),
            })
        });
        Self {
            number: moment.number,
            frame: shapes.trace.sequence,
            width: shapes.width,
            height: shapes.height,
            unit: shapes.unit().map_or("?", Unit::name),
            way_us: way_us(&shapes.trace),
            exposed_ms: (shapes.trace.exposed_ns / 1000) as f64 / 1e3,
            ropes: ropes.collect(),
            crossings: crossings.collect(),
            notice: moment.notice.as_deref(),
        }
    }
}

fn way_us(trace: &Trace) -> [u64; 6] {
    let stamps = [
        trace.captured_ns,
        trace.extract_started_ns,
        trace.extracted_ns,
        trace.fit_started_ns,
        trace.fitted_ns,
    ];
    let mut way = [0; 6];
    for (to, stamp) in way[1..].iter_mut().zip(stamps) {
        *to = stamp.saturating_sub(trace.exposed_ns) / 1000;
    }
    way
}

impl RopeSaid {
    fn of(shape: &Descriptor, seen_at: &impl Fn([f64; 2]) -> Option<Projection>) -> Self {
        let all = |points: &[[f64; 2]]| points.iter().map(|point| seen_at(*point)).collect();
        let mut curve = vec![[0.0; 2]; DRAWN];
        let is_curve = points_along(shape, &mut curve);
        let curve: Option<Vec<Projection>> = is_curve.then(|| all(&curve)).flatten();
        // A Fourier series has coefficients, not points.
        let has_points = !matches!(shape.basis(), Some(Basis::Fourier) | None);
        let control: Option<Vec<Projection>> =
            has_points.then(|| all(shape.control_points())).flatten();
        let (curve, control) = (curve.unwrap_or_default(), control.unwrap_or_default());
        Self {
            track: shape.track,
            status: shape.status().map(Status::name),
            closed: shape.closed != 0,
            basis: shape.basis().map_or("?", Basis::name),
            degree: shape.degree,
            control_points: shape.count,
            length: short(shape.length),
            width: short(shape.width),
            rms: short(shape.rms),
            max: short(shape.max),
            coarse: shape.fit() == Some(FitQuality::Coarse),
            confidence: short(shape.confidence.into()),
            age_s: shape.age_ns as f64 / 1e9,
            points: Vec::new(),
            hidden: Vec::new(),
            width_px: 0.0,
            curve: curve.iter().map(|seen| seen.at.map(short)).collect(),
            covariances: (control.iter().zip(shape.covariances()))
                .map(|(seen, covariance)| seen.covariance(*covariance).map(fine))
                .collect(),
            control: control.iter().map(|seen| seen.at.map(short)).collect(),
        }
    }

    fn see(&mut self, curve: &Curve) {
        let points = curve.points();
        self.points = points.iter().map(|p| p.map(|x| short(x.into()))).collect();
        self.hidden = (0..points.len()).filter(|&i| curve.is_hidden(i)).collect();
        self.width_px = short(curve.width_px.into());
    }

    /// Takes the descriptors' own points, if extract's are not available.
    fn see_points(&mut self, shapes: &Descriptors, track: u32) {
        let place = shapes
            .curves()
            .iter()
            .position(|shape| shape.track == track);
        if let Some(line) = place.and_then(|place| shapes.centerlines().get(place)) {
            let points = line.points();
            self.points = points.iter().map(|p| p.map(|x| short(x.into()))).collect();
            self.hidden = (0..points.len()).filter(|&i| line.is_hidden(i)).collect();
            self.width_px = self.width;
        }
    }
}

/// A point in the picture.
struct Projection {
    at: [f64; 2],
    /// Jacobian of the position in the picture with respect to the point. `None` is the identity.
    way: Option<Jacobian>,
}

impl Projection {
    /// Creates a point at a pixel; `None` if the mapping fails there.
    fn new(at: [f64; 2], places: Option<&Mapping>) -> Option<Self> {
        let Some(places) = places else {
            return Some(Self { at, way: None });
        };
        let way = places.place(at).ok()?.jacobian;
        let [[a, b], [c, d]] = way;
        let determinant = a * d - b * c;
        let back = [[d, -b], [-c, a]].map(|row| row.map(|x| x / determinant));
        Some(Self {
            at,
            way: Some(back),
        })
    }

    /// Converts a covariance `[xx, xy, yy]` of the point to the picture: `J C Jᵀ`.
    fn covariance(&self, [xx, xy, yy]: [f64; 3]) -> [f64; 3] {
        let Some(way) = self.way else {
            return [xx, xy, yy];
        };
        let product = |p: [f64; 2], q: [f64; 2]| {
            p[0] * (xx * q[0] + xy * q[1]) + p[1] * (xy * q[0] + yy * q[1])
        };
        let [a, b] = way;
        [product(a, a), product(a, b), product(b, b)]
    }
}

/// Rounds to a hundredth, and replaces numbers that are not finite, which JSON does not have.
fn short(x: f64) -> f64 {
    rounded(x, 1e2)
}

/// Rounds to a hundred-thousandth, because variances are small.
fn fine(x: f64) -> f64 {
    rounded(x, 1e5)
}

fn rounded(x: f64, per_unit: f64) -> f64 {
    if x.is_finite() {
        (x * per_unit).round() / per_unit + 0.0
    } else {
        0.0
    }
}
