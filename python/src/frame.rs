//! State of a reader at one moment.
//!
//! A frame is copied out of shared memory once, when it is read, and everything read from it later
//! comes from the copy. Arrays therefore stay valid forever and in every thread, and none occupies
//! one of the two slots that a reader may hold. The copy costs less than creating one array
//! (`bench/readers.py`).

use crate::reader::seconds;
use crate::rope::Track;
use crate::seen;
use crate::views;
use crate::way::Trace;
use lariat_wire::{KeptFrame, Unit};
use numpy::PyArray;
use numpy::ndarray::Ix1;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

/// The newest frame at the time of a request.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Frame {
    kept: KeptFrame,
}

impl Frame {
    pub(crate) fn new(kept: KeptFrame) -> Self {
        Self { kept }
    }

    pub(crate) fn frame(&self) -> lariat_wire::Frame<'_> {
        self.kept.frame()
    }

    /// Index of this rope among the ropes of the frame.
    pub(crate) fn index_of(&self, rope: &lariat_wire::Rope) -> usize {
        let ropes = self
            .frame()
            .message()
            .map_or(&[][..], |message| message.curves());
        ropes
            .iter()
            .position(|other| std::ptr::eq(other, rope.descriptor()))
            .unwrap_or(ropes.len())
    }
}

#[pymethods]
impl Frame {
    /// True if the frame arrived after the previous request. Otherwise it is the same image, now
    /// older.
    #[getter]
    fn is_new(&self) -> bool {
        self.frame().is_new()
    }

    /// Age of the image when the frame was requested, s; `None` before the first image.
    #[getter]
    fn age(&self) -> Option<f64> {
        self.frame().age().map(|age| age.as_secs_f64())
    }

    /// Run of the chain, counted by this reader from 1; 0 before the first message.
    #[getter]
    fn run(&self) -> u64 {
        self.frame().run()
    }

    /// Width and height of the image, px; (0, 0) while the camera gives no image, and before the
    /// first message.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.frame()
            .message()
            .map_or((0, 0), |message| (message.width, message.height))
    }

    /// Unit of the ropes: `"px"`, `"mm"` on the plane, or `"ideal px"` of an image without
    /// distortion.
    #[getter]
    pub(crate) fn unit(&self) -> Option<&'static str> {
        self.frame().message()?.unit().map(Unit::name)
    }

    /// Counters and times of the frame; `None` before the first message.
    #[getter]
    fn trace(&self) -> Option<Trace> {
        self.frame()
            .message()
            .map(|message| Trace::from(message.trace))
    }

    /// The bytes of the message; empty before the first.
    #[getter]
    fn _bytes<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyArray<u8, Ix1>> {
        views::message(this, |frame| frame.frame().message())
    }

    /// The whole message as a NumPy record (`lariat.MESSAGE`), with the names and layout of
    /// docs/messages.md, for example for recording. It does not contain its age. `count` fields
    /// give the number of valid array entries. `None` before the first message.
    #[getter]
    fn message<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let py = this.py();
        py.import("lariat._layout")?
            .call_method1("record", (Self::_bytes(this),))
    }

    /// The rope of an image that has exactly one. If there are several, choose one of `ropes` and
    /// request its track. In an image older than `max_age` seconds, the rope is `Stale`.
    fn only_rope<'py>(this: &Bound<'py, Self>, max_age: f64) -> PyResult<Bound<'py, PyAny>> {
        let max_age = seconds("max_age", max_age)?;
        seen::of(this, this.get().frame().only_rope(max_age), max_age)
    }

    /// The rope of this track, and no other.
    fn rope<'py>(
        this: &Bound<'py, Self>,
        track: &Bound<'py, PyAny>,
        max_age: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let max_age = seconds("max_age", max_age)?;
        let Ok(track) = track.cast::<Track>() else {
            return Err(PyTypeError::new_err(
                "a track is what a rope's own `track` is: its number alone may be another rope's after a restart",
            ));
        };
        seen::of(
            this,
            this.get().frame().rope(track.get().0, max_age),
            max_age,
        )
    }

    /// Every rope of the image, including lost ones.
    fn ropes<'py>(this: &Bound<'py, Self>, max_age: f64) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let max_age = seconds("max_age", max_age)?;
        let ropes = this.get().frame().ropes(max_age);
        ropes.map(|rope| seen::of(this, rope, max_age)).collect()
    }

    fn __repr__(&self) -> String {
        let Some(message) = self.frame().message() else {
            return "<lariat.Frame: nothing came yet>".to_owned();
        };
        let ropes = match message.curves().len() {
            0 => "no rope".to_owned(),
            1 => "1 rope".to_owned(),
            count => format!("{count} ropes"),
        };
        format!(
            "<lariat.Frame {} of run {}: {ropes}, {:.1} ms old>",
            message.trace.sequence,
            self.run(),
            1e3 * self.age().unwrap_or_default(),
        )
    }

    fn _repr_html_<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        this.py()
            .import("lariat._drawing")?
            .call_method1("frame", (this,))
    }
}
