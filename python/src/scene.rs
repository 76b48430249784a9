//! The contents of one image for Python: curves, crossings, notices.

use crate::views;
use lariat_extract::{CrossingSequence, Extractor};
use numpy::PyArray;
use numpy::ndarray::{Ix1, Ix2};
use pyo3::prelude::*;
use std::sync::Arc;

/// A copy of the extractor's result, which is valid only until the next image.
#[derive(Debug)]
pub(crate) struct Kept {
    curves: Vec<lariat_extract::Curve>,
    crossings: Vec<lariat_extract::Crossing>,
    notice: Option<lariat_extract::Notice>,
    /// The notice as text for the user of this tracer.
    sentence: String,
    followed: bool,
    /// Width and height of the image, px.
    size: (usize, usize),
}

impl Kept {
    /// Copies a scene. `origin` is the position of the extractor's image in the whole image.
    pub(crate) fn new(
        scene: &lariat_extract::Scene,
        origin: [f32; 2],
        size: (usize, usize),
    ) -> Self {
        let moved = |p: [f32; 2]| [p[0] + origin[0], p[1] + origin[1]];
        let mut curves = scene.curves.to_vec();
        let mut crossings = scene.crossings.to_vec();
        for point in curves.iter_mut().flat_map(|curve| &mut curve.points) {
            *point = moved(*point);
        }
        for crossing in &mut crossings {
            crossing.at = moved(crossing.at);
        }
        Self {
            curves,
            crossings,
            notice: scene.notice,
            sentence: String::new(),
            followed: scene.followed,
            size,
        }
    }

    /// Adds the notice as text for the user of this extractor.
    pub(crate) fn in_words(mut self, extractor: &Extractor) -> Self {
        let sentence = self.notice.map(|notice| extractor.sentence(notice));
        self.sentence = sentence.unwrap_or_default();
        self
    }

    fn scene(&self) -> lariat_extract::Scene<'_> {
        lariat_extract::Scene {
            curves: &self.curves,
            crossings: &self.crossings,
            notice: self.notice,
            followed: self.followed,
        }
    }
}

/// The ropes in one image.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Scene {
    kept: Arc<Kept>,
    curves: Vec<Py<Curve>>,
}

impl Scene {
    pub(crate) fn new(py: Python<'_>, kept: Kept) -> PyResult<Self> {
        let kept = Arc::new(kept);
        let curves = (0..kept.curves.len()).map(|index| {
            let kept = kept.clone();
            Py::new(py, Curve { kept, index })
        });
        let curves = curves.collect::<PyResult<_>>()?;
        Ok(Self { kept, curves })
    }
}

#[pymethods]
impl Scene {
    /// The visible ropes, the longest first, then the lost ones.
    #[getter]
    fn curves(&self, py: Python<'_>) -> Vec<Py<Curve>> {
        self.curves
            .iter()
            .map(|curve| curve.clone_ref(py))
            .collect()
    }

    /// Their crossings, at most 32.
    #[getter]
    fn crossings(&self) -> Vec<Crossing> {
        self.kept.crossings.iter().copied().map(Crossing).collect()
    }

    /// The most important probable fault of the result, if any.
    #[getter]
    fn notice(&self) -> Option<Notice> {
        let sentence = || self.kept.sentence.clone();
        self.kept.notice.map(|notice| Notice(notice, sentence()))
    }

    /// True if the ropes were tracked from the previous image, so that only the area around them
    /// was read.
    #[getter]
    fn followed(&self) -> bool {
        self.kept.followed
    }

    /// Width and height of the image, px.
    #[getter]
    fn size(&self) -> (usize, usize) {
        self.kept.size
    }

    fn __repr__(&self) -> String {
        let counted = |count: usize, one: &str, many: &str| match count {
            0 => format!("no {one}"),
            1 => format!("1 {one}"),
            _ => format!("{count} {many}"),
        };
        let (width, height) = self.kept.size;
        let doubt = self
            .kept
            .notice
            .map(|notice| format!(", {}", notice.name()));
        format!(
            "<lariat.Scene of {width}×{height} px: {}, {}{}>",
            counted(self.kept.curves.len(), "rope", "ropes"),
            counted(self.kept.crossings.len(), "crossing", "crossings"),
            doubt.unwrap_or_default(),
        )
    }

    fn _repr_html_<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        this.py()
            .import("lariat._drawing")?
            .call_method1("scene", (this,))
    }
}

/// The centerline of one rope. Positions are in pixels, x right, y down, with (0, 0) at the center
/// of the top left pixel.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Curve {
    kept: Arc<Kept>,
    index: usize,
}

impl Curve {
    pub(crate) fn seen(&self) -> &lariat_extract::Curve {
        &self.kept.curves[self.index]
    }
}

#[pymethods]
impl Curve {
    /// Rope number, constant from image to image of a `Tracer`.
    #[getter]
    fn track(&self) -> u32 {
        self.seen().track
    }

    /// Visibility of the rope: `"ok"`, `"partial"` or `"lost"`; `"doubtful"` if it may not be a
    /// rope.
    #[getter]
    fn status(&self) -> &'static str {
        self.seen().status.name()
    }

    /// Calibrated probability, 0 to 1, that this is a whole rope with its points in order.
    #[getter]
    fn confidence(&self) -> f32 {
        self.seen().confidence
    }

    /// True if the rope is closed. The last point is then one step before the first.
    #[getter]
    fn closed(&self) -> bool {
        self.seen().closed
    }

    /// True for each end, first and last, at which the rope leaves the image.
    #[getter]
    fn leaves_image(&self) -> (bool, bool) {
        self.seen().border.into()
    }

    /// Points at equal steps of arc length, an array of `float32` of shape (points, 2), px.
    #[getter]
    fn points<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f32, Ix2>> {
        views::rows(this, |curve| &curve.seen().points)
    }

    /// Width of the rope at each point, px.
    #[getter]
    fn widths_px<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<f32, Ix1>> {
        views::row(this, |curve| &curve.seen().widths_px)
    }

    /// True for each point that is covered or outside the image; its position is then interpolated.
    #[getter]
    fn hidden<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<bool, Ix1>> {
        views::row(this, |curve| &curve.seen().hidden)
    }

    /// Median of the widths, px.
    #[getter]
    fn width_px(&self) -> f32 {
        self.seen().width_px
    }

    /// Arc length from end to end (once around if closed), px.
    #[getter]
    fn length_px(&self) -> f32 {
        self.seen().length_px
    }

    /// Time since the rope was last visible, s; 0 unless it is lost.
    #[getter]
    fn age(&self) -> f64 {
        self.seen().age_ns as f64 * 1e-9
    }

    /// The rope's crossings with itself, over (O) and under (U), from its first point on.
    /// `"O1 U2 O3 U1 O2 U3"` is an overhand knot.
    #[getter]
    fn crossing_sequence(&self) -> String {
        CrossingSequence::of(&self.kept.scene(), self.index).to_string()
    }

    /// True if the rope becomes straight when its ends are pulled apart; `None` if neither answer
    /// has a probability of 0.9.
    #[getter]
    fn pulls_straight(&self, py: Python<'_>) -> Option<bool> {
        py.detach(|| CrossingSequence::of(&self.kept.scene(), self.index).pulls_straight())
    }

    fn __repr__(&self) -> String {
        let curve = self.seen();
        let closed = if curve.closed { ", closed" } else { "" };
        format!(
            "<lariat.Curve of rope {}, {}{closed}: {} points, {:.1} px long, {:.1} px wide>",
            curve.track,
            self.status(),
            curve.points.len(),
            curve.length_px,
            curve.width_px,
        )
    }

    fn _repr_html_<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        this.py()
            .import("lariat._drawing")?
            .call_method1("curve", (this,))
    }
}

/// A crossing of a rope over another rope or itself.
#[pyclass(frozen, module = "lariat")]
#[derive(Clone, Copy)]
pub(crate) struct Crossing(lariat_extract::Crossing);

#[pymethods]
impl Crossing {
    /// Position, [x, y] in px.
    #[getter]
    fn at(&self) -> (f32, f32) {
        self.0.at.into()
    }

    /// Index of the upper rope in the scene's curves.
    #[getter]
    fn over(&self) -> usize {
        self.0.over
    }

    /// Index of the lower rope in the scene's curves.
    #[getter]
    fn under(&self) -> usize {
        self.0.under
    }

    /// Position on the upper rope as normalized arc length, 0 to 1.
    #[getter]
    fn over_rho(&self) -> f32 {
        self.0.over_rho
    }

    /// Position on the lower rope as normalized arc length, 0 to 1.
    #[getter]
    fn under_rho(&self) -> f32 {
        self.0.under_rho
    }

    /// Confidence in which rope is on top, from 0 (a coin toss) to 1.
    #[getter]
    fn confidence(&self) -> f32 {
        self.0.confidence
    }

    fn __repr__(&self) -> String {
        let lariat_extract::Crossing {
            at,
            over,
            under,
            confidence,
            ..
        } = self.0;
        let [x, y] = at;
        format!(
            "<lariat.Crossing at ({x:.1}, {y:.1}): curve {over} over curve {under}, confidence {confidence:.2}>"
        )
    }
}

/// A reason why the automatic mask may be wrong for an image, and how to fix it; `str()` gives the
/// text.
#[pyclass(frozen, eq, hash, module = "lariat")]
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Notice(lariat_extract::Notice, String);

#[pymethods]
impl Notice {
    /// A short name for programs, such as `"checkered-table"`.
    #[getter]
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn __str__(&self) -> String {
        self.1.clone()
    }

    fn __repr__(&self) -> String {
        format!("<lariat.Notice {}: {}>", self.0.name(), self.1)
    }
}
