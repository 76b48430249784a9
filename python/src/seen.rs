//! State of a rope, as classes that must be distinguished before there is a shape.

use crate::frame::Frame;
use crate::rope::Rope;
use lariat_wire::{Doubt, Seen};
use pyo3::prelude::*;
use std::time::Duration;

/// The state of a rope as an object of its class.
pub(crate) fn of<'py>(
    frame: &Bound<'py, Frame>,
    seen: Seen,
    max_age: Duration,
) -> PyResult<Bound<'py, PyAny>> {
    let py = frame.py();
    let sight = |rope: &lariat_wire::Rope| {
        let rope = Py::new(py, Rope::of(frame, rope))?;
        Ok::<_, PyErr>(Sight { rope, max_age })
    };
    Ok(match seen {
        Seen::Fresh(rope) => Bound::new(py, Fresh(sight(&rope)?))?.into_any(),
        Seen::Partial(rope) => Bound::new(py, Partial(sight(&rope)?))?.into_any(),
        Seen::Unsure(rope, why) => {
            let sight = sight(&rope)?;
            Bound::new(py, Unsure { sight, why })?.into_any()
        }
        Seen::Lost(last) => Bound::new(py, Lost(sight(&last.as_it_was())?))?.into_any(),
        Seen::Stale(last) => Bound::new(py, Stale(sight(&last.as_it_was())?))?.into_any(),
        Seen::Absent(why) => Bound::new(py, Absent(why))?.into_any(),
    })
}

/// A rope and the maximum age of its image.
struct Sight {
    rope: Py<Rope>,
    max_age: Duration,
}

impl Sight {
    fn rope(&self, py: Python<'_>) -> Py<Rope> {
        self.rope.clone_ref(py)
    }

    fn sentence(&self) -> String {
        let seen = self.rope.get().seen(self.max_age);
        seen.map_or_else(String::new, |seen| seen.to_string())
    }
}

/// Raises an exception that says what was found instead of a rope.
fn raise<T>(seen: &Bound<'_, PyAny>) -> PyResult<T> {
    let error = seen.py().import("lariat._seen")?.getattr("NotSeen")?;
    Err(PyErr::from_value(error.call1((seen,))?))
}

/// The whole rope, in an image no older than requested.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Fresh(Sight);

#[pymethods]
impl Fresh {
    #[classattr]
    fn __match_args__() -> (&'static str,) {
        ("rope",)
    }

    /// The rope.
    #[getter]
    fn rope(&self, py: Python<'_>) -> Py<Rope> {
        self.0.rope(py)
    }

    /// Returns the rope.
    #[pyo3(signature = (*, partial=false))]
    fn or_raise(&self, py: Python<'_>, partial: bool) -> Py<Rope> {
        let _ = partial;
        self.0.rope(py)
    }

    fn __str__(&self) -> String {
        self.0.sentence()
    }

    fn __repr__(&self) -> String {
        format!("<lariat.Fresh: {}>", self.0.sentence())
    }
}

/// The rope, partly covered. The covered part is interpolated from the parts on both sides and from
/// its earlier position.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Partial(Sight);

#[pymethods]
impl Partial {
    #[classattr]
    fn __match_args__() -> (&'static str,) {
        ("rope",)
    }

    /// The partly covered rope.
    #[getter]
    fn rope(&self, py: Python<'_>) -> Py<Rope> {
        self.0.rope(py)
    }

    /// Returns the rope if `partial` is True; otherwise raises `NotSeen`.
    #[pyo3(signature = (*, partial=false))]
    fn or_raise(this: &Bound<'_, Self>, partial: bool) -> PyResult<Py<Rope>> {
        if partial {
            return Ok(this.get().0.rope(this.py()));
        }
        raise(this)
    }

    fn __str__(&self) -> String {
        self.0.sentence()
    }

    fn __repr__(&self) -> String {
        format!("<lariat.Partial: {}>", self.0.sentence())
    }
}

/// A rope or something similar, with the reason why it must not be used for steering as it is.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Unsure {
    sight: Sight,
    why: Doubt,
}

#[pymethods]
impl Unsure {
    #[classattr]
    fn __match_args__() -> (&'static str, &'static str) {
        ("rope", "why")
    }

    /// The rope.
    #[getter]
    fn rope(&self, py: Python<'_>) -> Py<Rope> {
        self.sight.rope(py)
    }

    /// `"coarse"`: the curve does not follow the rope, but its `centerline` does. `"no-rope"`: it
    /// may be a shadow, a pen or an edge. `"low-confidence"`: its `confidence` is less than the
    /// reader's `min_confidence`.
    #[getter]
    fn why(&self) -> &'static str {
        match self.why {
            Doubt::Coarse => "coarse",
            Doubt::LowConfidence => "low-confidence",
            // The only other reason in this release.
            _ => "no-rope",
        }
    }

    /// Raises `NotSeen`.
    #[pyo3(signature = (*, partial=false))]
    fn or_raise(this: &Bound<'_, Self>, partial: bool) -> PyResult<Py<Rope>> {
        let _ = partial;
        raise(this)
    }

    fn __str__(&self) -> String {
        self.sight.sentence()
    }

    fn __repr__(&self) -> String {
        format!("<lariat.Unsure: {}>", self.sight.sentence())
    }
}

/// The image is fresh but does not show the rope, or the camera gives no image.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Lost(Sight);

#[pymethods]
impl Lost {
    /// Time since the rope was observed with its last known shape, s.
    #[getter]
    fn age(&self) -> PyResult<f64> {
        self.0.rope.get().age()
    }

    /// The last known rope. Use it to search, to draw, or to predict its position, but not to
    /// steer.
    #[getter]
    fn as_it_was(&self, py: Python<'_>) -> Py<Rope> {
        self.0.rope(py)
    }

    /// Raises `NotSeen`.
    #[pyo3(signature = (*, partial=false))]
    fn or_raise(this: &Bound<'_, Self>, partial: bool) -> PyResult<Py<Rope>> {
        let _ = partial;
        raise(this)
    }

    fn __str__(&self) -> String {
        self.0.sentence()
    }

    fn __repr__(&self) -> String {
        format!("<lariat.Lost: {}>", self.0.sentence())
    }
}

/// The image is older than requested: the chain hangs, is too slow, or has ended.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Stale(Sight);

#[pymethods]
impl Stale {
    /// Time since the rope was observed with its last known shape, s.
    #[getter]
    fn age(&self) -> PyResult<f64> {
        self.0.rope.get().age()
    }

    /// The last known rope. Use it to draw, or to predict its position, but not to steer.
    #[getter]
    fn as_it_was(&self, py: Python<'_>) -> Py<Rope> {
        self.0.rope(py)
    }

    /// Raises `NotSeen`.
    #[pyo3(signature = (*, partial=false))]
    fn or_raise(this: &Bound<'_, Self>, partial: bool) -> PyResult<Py<Rope>> {
        let _ = partial;
        raise(this)
    }

    fn __str__(&self) -> String {
        self.0.sentence()
    }

    fn __repr__(&self) -> String {
        format!("<lariat.Stale: {}>", self.0.sentence())
    }
}

/// No shape is known, not even an old one.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Absent(lariat_wire::Absent);

#[pymethods]
impl Absent {
    #[classattr]
    fn __match_args__() -> (&'static str,) {
        ("why",)
    }

    /// The reason: `"nothing-yet"`, `"nothing-lately"`, `"no-image"`, `"no-rope"`, `"several"`,
    /// `"other-run"` or `"unreadable"`. `str()` of the object gives it as a sentence.
    #[getter]
    fn why(&self) -> &'static str {
        use lariat_wire::Absent;
        match self.0 {
            Absent::NothingYet => "nothing-yet",
            Absent::NothingLately => "nothing-lately",
            Absent::NoImage => "no-image",
            Absent::NoRope => "no-rope",
            Absent::Several => "several",
            Absent::OtherRun => "other-run",
            // The only other reason in this release.
            _ => "unreadable",
        }
    }

    /// Raises `NotSeen`.
    #[pyo3(signature = (*, partial=false))]
    fn or_raise(this: &Bound<'_, Self>, partial: bool) -> PyResult<Py<Rope>> {
        let _ = partial;
        raise(this)
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        format!("<lariat.Absent: {}>", self.0)
    }
}
