//! A rig's frames for Python. Each one is a copy, so it can be kept and used in any thread.

use crate::errors::wire_error;
use crate::reader::seconds;
use crate::way::Trace;
use crate::writer::{array_shape, shaped};
use lariat_wire::{Domain, FrameHeader, FrameReader, Message};
use numpy::PyArray1;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::{Duration, Instant};

/// Maximum duration of a single sleep, as for a reader.
const LONGEST_SLEEP: Duration = Duration::from_secs(1);

/// Reads the frames of a rig, for a network that computes masks from them.
#[pyclass(frozen, subclass, module = "lariat._native")]
pub(crate) struct Frames {
    /// `None` once closed.
    reader: Mutex<Option<FrameReader>>,
    rig: String,
}

/// A copy of a frame's pixels, with rows without gaps.
struct Copied {
    header: FrameHeader,
    bytes: Vec<u8>,
}

#[pymethods]
impl Frames {
    #[new]
    #[pyo3(signature = (rig="default", *, lossless=None))]
    fn new(py: Python<'_>, rig: &str, lossless: Option<bool>) -> PyResult<Self> {
        let open = || FrameReader::open_in(Domain::open()?, &rig.parse()?, lossless);
        Ok(Self {
            reader: Mutex::new(Some(py.detach(open).map_err(wire_error)?)),
            rig: rig.to_owned(),
        })
    }

    /// Waits for the next image, at most `timeout` seconds; `None` if none arrived.
    #[pyo3(signature = (timeout=None))]
    fn wait(&self, py: Python<'_>, timeout: Option<f64>) -> PyResult<Option<Image>> {
        let timeout = timeout
            .map(|timeout| seconds("timeout", timeout))
            .transpose()?;
        let deadline = timeout.and_then(|timeout| Instant::now().checked_add(timeout));
        loop {
            py.check_signals()?;
            match py.detach(|| self.wait_for_signal(deadline))? {
                Waited::Came(copied) => return Image::new(py, copied).map(Some),
                Waited::Over => return Ok(None),
                Waited::Signal => {}
            }
        }
    }

    /// Name of the rig.
    #[getter]
    fn rig(&self) -> &str {
        &self.rig
    }

    /// Leaves the rig. Images that were read before stay valid.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let reader = self.lock()?.take();
        py.detach(|| drop(reader));
        Ok(())
    }

    /// True if closed.
    #[getter]
    fn closed(&self) -> PyResult<bool> {
        Ok(self.lock()?.is_none())
    }

    fn __enter__(this: Py<Self>) -> Py<Self> {
        this
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&self, py: Python<'_>, _error: &Bound<'_, PyTuple>) -> PyResult<()> {
        self.close(py)
    }

    fn __iter__(this: Py<Self>) -> Py<Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Image>> {
        self.wait(py, None)
    }

    fn __repr__(&self) -> String {
        let state = match self.closed() {
            Ok(true) => ", closed",
            _ => "",
        };
        format!("<lariat.Frames of rig '{}'{state}>", self.rig)
    }
}

/// Result of a wait.
enum Waited {
    Came(Copied),
    Over,
    /// A signal arrived, or may have arrived.
    Signal,
}

impl Frames {
    fn lock(&self) -> PyResult<MutexGuard<'_, Option<FrameReader>>> {
        match self.reader.try_lock() {
            Ok(reader) => Ok(reader),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
                "another thread waits for these frames: open a reader for each thread",
            )),
        }
    }

    fn wait_for_signal(&self, deadline: Option<Instant>) -> PyResult<Waited> {
        let mut guard = self.lock()?;
        let reader = guard
            .as_mut()
            .ok_or_else(|| PyValueError::new_err("these frames are closed: open another reader"))?;
        let slept = Instant::now();
        loop {
            if let Some(frame) = reader.try_next().map_err(wire_error)? {
                if frame.header().is_blank() {
                    continue;
                }
                return Ok(Waited::Came(copied(frame)));
            }
            let now = Instant::now();
            if deadline.is_some_and(|deadline| now >= deadline) {
                return Ok(Waited::Over);
            }
            let left = deadline.map_or(LONGEST_SLEEP, |deadline| deadline - now);
            let uninterrupted = LONGEST_SLEEP.saturating_sub(now - slept);
            if uninterrupted.is_zero() {
                return Ok(Waited::Signal);
            }
            let longest = reader.before_poll().map_err(wire_error)?;
            let sleep = left
                .min(uninterrupted)
                .min(longest.unwrap_or(LONGEST_SLEEP));
            let sleep = Timespec::try_from(sleep).unwrap_or_default();
            match poll(&mut [PollFd::new(&*reader, PollFlags::IN)], Some(&sleep)) {
                Ok(_) => {}
                Err(Errno::INTR) => return Ok(Waited::Signal),
                Err(cause) => {
                    return Err(PyOSError::new_err(format!(
                        "waiting for a frame failed ({cause})"
                    )));
                }
            }
        }
    }
}

/// Copies the rows without gaps. If the header declares more than there is, copies the available
/// bytes.
fn copied(frame: &Message<[u8]>) -> Copied {
    let header = *frame.header();
    let row_bytes = header
        .format()
        .map_or(0, |format| format.row_bytes(header.width));
    let rows = frame.chunks(header.stride.max(1) as usize);
    let mut bytes = Vec::with_capacity(frame.len());
    if row_bytes == header.stride as usize {
        bytes.extend_from_slice(frame);
    } else {
        for row in rows {
            bytes.extend_from_slice(&row[..row_bytes.min(row.len())]);
        }
    }
    Copied { header, bytes }
}

/// A frame: its pixels, counters and times.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Image {
    /// Boxed, because it is aligned to a cache line and Python objects are not.
    header: Box<FrameHeader>,
    array: Py<PyAny>,
}

#[pymethods]
impl Image {
    /// Its pixels: (height, width) for gray, (height, width, channels) for colors. The array is a
    /// copy.
    #[getter]
    fn array(&self, py: Python<'_>) -> Py<PyAny> {
        self.array.clone_ref(py)
    }

    /// Name of its pixel format: `rgb8`, `bgr8`, `gray8`, `yuyv`, `uyvy`, `nv12`, …
    #[getter]
    fn pixel_format(&self) -> Option<&'static str> {
        self.header.format().map(lariat_wire::PixelFormat::name)
    }

    /// Width and height in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.header.width, self.header.height)
    }

    /// Counters and times of the frame up to capture, such as its number and exposure time.
    #[getter]
    fn trace(&self) -> Trace {
        self.header.trace.into()
    }

    fn __repr__(&self) -> String {
        format!(
            "<lariat.Image {} of {}×{} in {}>",
            self.header.trace.sequence,
            self.header.width,
            self.header.height,
            self.pixel_format().unwrap_or("an unknown format"),
        )
    }
}

impl Image {
    fn new(py: Python<'_>, copied: Copied) -> PyResult<Self> {
        let Copied { header, mut bytes } = copied;
        let unreadable = || {
            PyOSError::new_err(format!(
                "frames come in pixel format {} with {} bytes, which this release does not know: use the same release of \
                 lariat for every process on a rig",
                header.pixel_format,
                bytes.len()
            ))
        };
        let format = header.format().ok_or_else(unreadable)?;
        let (shape, item_bytes) =
            array_shape(header.height as usize, header.width as usize, format);
        let wanted = shape.iter().product::<usize>() * item_bytes;
        if bytes.len() < wanted {
            return Err(unreadable());
        }
        // A driver may reserve more space than the pixels need.
        bytes.truncate(wanted);
        let array = shaped(&PyArray1::from_vec(py, bytes), &shape, item_bytes)?;
        Ok(Self {
            header: Box::new(header),
            array: array.unbind(),
        })
    }

    pub(crate) fn header(&self) -> &FrameHeader {
        &self.header
    }
}
