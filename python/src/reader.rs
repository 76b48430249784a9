//! A control loop's reader for Python. It waits without blocking other threads, and Ctrl-C ends the
//! wait.

use crate::errors::{value_error, wire_error};
use crate::frame::Frame;
use lariat_wire::{Domain, KeptFrame, Motion, WireError};
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::os::fd::{AsFd, AsRawFd};
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::{Duration, Instant};
use thiserror::Error;

/// Maximum duration of a single sleep. A signal during a sleep ends it. Python only records a
/// signal that arrives just before the sleep.
const LONGEST_SLEEP: Duration = Duration::from_secs(1);

/// Requests short time slices for the calling thread, for a control loop without realtime priority.
/// When a message wakes the thread, it need not wait until another program's slice ends. This needs
/// no privilege. It requires Linux 6.12 and does nothing on older kernels. Threads that this thread
/// starts later inherit the short slices.
#[pyfunction]
pub(crate) fn take_short_slices() {
    lariat_wire::take_short_slices();
}

/// Reads the shapes of a rig's ropes, for a control loop.
#[pyclass(frozen, subclass, module = "lariat._native")]
pub(crate) struct Reader {
    /// `None` once closed.
    reader: Mutex<Option<lariat_wire::Reader>>,
    rig: String,
    timeout: Duration,
}

#[pymethods]
impl Reader {
    #[new]
    #[pyo3(signature = (rig="default", *, timeout=0.1, accept_coarse=false, min_confidence=0.5, space=false))]
    fn new(
        py: Python<'_>,
        rig: &str,
        timeout: f64,
        accept_coarse: bool,
        min_confidence: f32,
        space: bool,
    ) -> PyResult<Self> {
        let timeout = seconds("timeout", timeout)?;
        if !(0.0..=1.0).contains(&min_confidence) {
            return Err(value_error(format!(
                "invalid min_confidence {min_confidence}: give a number from 0 to 1"
            )));
        }
        let opened = py.detach(|| {
            let mut reader = lariat_wire::Reader::open_in(Domain::open()?, &rig.parse()?)?;
            if space {
                reader.follow_in_space()?;
            }
            Ok(reader)
        });
        let mut reader = opened.map_err(wire_error)?;
        reader.accept_coarse(accept_coarse);
        reader.min_confidence(min_confidence);
        Ok(Self {
            reader: Mutex::new(Some(reader)),
            rig: rig.to_owned(),
            timeout,
        })
    }

    /// Returns the current state without waiting.
    fn latest(&self) -> PyResult<Frame> {
        let mut guard = self.lock()?;
        let frame = open(&mut guard)?.latest().map_err(Problem::Wire)?;
        Ok(Frame::new(frame.keep()))
    }

    /// Waits for an image that this reader has not returned yet, at most `timeout` seconds. After
    /// the timeout, the frame is not new.
    #[pyo3(signature = (timeout=None))]
    fn wait(&self, py: Python<'_>, timeout: Option<f64>) -> PyResult<Frame> {
        let timeout = timeout.map_or(Ok(self.timeout), |timeout| seconds("timeout", timeout))?;
        // A deadline beyond the clock's range never passes.
        let deadline = Instant::now().checked_add(timeout);
        loop {
            py.check_signals()?;
            if let Some(kept) = py.detach(|| self.wait_for_signal(deadline))? {
                return Ok(Frame::new(kept));
            }
        }
    }

    /// Age of the image of the newest frame read, s; `None` before the first frame.
    #[getter]
    fn age(&self) -> PyResult<Option<f64>> {
        let mut guard = self.lock()?;
        Ok(open(&mut guard)?.age().map(|age| age.as_secs_f64()))
    }

    /// Name of the rig.
    #[getter]
    fn rig(&self) -> &str {
        &self.rig
    }

    /// Default timeout of a wait for the next image, s.
    #[getter]
    fn timeout(&self) -> f64 {
        self.timeout.as_secs_f64()
    }

    /// A file descriptor that becomes readable when an image arrives, for your own `select`: see
    /// `before_poll`.
    fn fileno(&self) -> PyResult<i32> {
        let mut guard = self.lock()?;
        Ok(open(&mut guard)?.as_fd().as_raw_fd())
    }

    /// Prepares for your own `select`. Call it before each one and sleep no longer than the
    /// returned seconds; `None` is unlimited. After the sleep, however it ended, `latest` returns
    /// the new state.
    fn before_poll(&self) -> PyResult<Option<f64>> {
        let mut guard = self.lock()?;
        let longest = open(&mut guard)?.before_poll().map_err(Problem::Wire)?;
        Ok(longest.map(|longest| longest.as_secs_f64()))
    }

    /// Sets the motion model of ropes for `Rope.predict`: the standard deviation of a point's
    /// acceleration, units/s², and its correlation time, s. Use the chain's own values.
    #[pyo3(signature = (acceleration=1000.0, lasts_s=0.1))]
    fn expect_motion(&self, acceleration: f64, lasts_s: f64) -> PyResult<()> {
        if !(acceleration.is_finite() && acceleration > 0.0 && lasts_s.is_finite() && lasts_s > 0.0)
        {
            return Err(value_error(format!(
                "invalid motion of {acceleration} units/s² that lasts {lasts_s} s: give two positive numbers"
            )));
        }
        let mut guard = self.lock()?;
        open(&mut guard)?.expect_motion(Motion {
            acceleration,
            lasts_s,
        });
        Ok(())
    }

    /// Leaves the rig. Frames that were read before stay valid.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        // Leaving removes what dead processes left, which may take a while.
        py.detach(|| -> Result<_, Problem> {
            let reader = self.lock()?.take();
            drop(reader);
            Ok(())
        })?;
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
    fn __exit__(&self, py: Python<'_>, _error: &Bound<'_, pyo3::types::PyTuple>) -> PyResult<()> {
        self.close(py)
    }

    fn __iter__(this: Py<Self>) -> Py<Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Frame> {
        self.wait(py, None)
    }

    fn __repr__(&self) -> String {
        let state = match self.lock() {
            Ok(reader) if reader.is_none() => ", closed",
            _ => "",
        };
        format!("<lariat.Reader of rig '{}'{state}>", self.rig)
    }
}

impl Reader {
    fn lock(&self) -> Result<MutexGuard<'_, Option<lariat_wire::Reader>>, Problem> {
        match self.reader.try_lock() {
            Ok(reader) => Ok(reader),
            // An interrupted read leaves nothing that the next one needs.
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Problem::Busy),
        }
    }

    /// Waits for a new frame or the deadline; `None` if a signal arrived, or may have arrived.
    fn wait_for_signal(&self, deadline: Option<Instant>) -> Result<Option<KeptFrame>, Problem> {
        let mut guard = self.lock()?;
        let reader = open(&mut guard)?;
        let slept = Instant::now();
        loop {
            let frame = reader.latest()?;
            let now = Instant::now();
            if frame.is_new() || deadline.is_some_and(|deadline| now >= deadline) {
                return Ok(Some(frame.keep()));
            }
            let left = deadline.map_or(LONGEST_SLEEP, |deadline| deadline - now);
            let uninterrupted = LONGEST_SLEEP.saturating_sub(now - slept);
            if uninterrupted.is_zero() {
                return Ok(None);
            }
            let longest = reader.before_poll()?.unwrap_or(LONGEST_SLEEP);
            let sleep = left.min(uninterrupted).min(longest);
            // No sleep is longer than a second.
            let sleep = Timespec::try_from(sleep).unwrap_or_default();
            match poll(&mut [PollFd::new(&*reader, PollFlags::IN)], Some(&sleep)) {
                Ok(_) => {}
                Err(Errno::INTR) => return Ok(None),
                Err(cause) => return Err(Problem::Sleep(cause)),
            }
        }
    }
}

/// The reader, unless it is closed.
fn open<'a>(
    guard: &'a mut MutexGuard<'_, Option<lariat_wire::Reader>>,
) -> Result<&'a mut lariat_wire::Reader, Problem> {
    guard.as_mut().ok_or(Problem::Closed)
}

/// Reason why a call failed.
#[derive(Debug, Error)]
enum Problem {
    #[error("this reader is closed: open another one")]
    Closed,
    #[error("another thread uses this reader, or waits with it: open one for each thread")]
    Busy,
    #[error(transparent)]
    Wire(#[from] WireError),
    #[error("waiting for a message failed ({0})")]
    Sleep(Errno),
}

impl From<Problem> for PyErr {
    fn from(problem: Problem) -> Self {
        match problem {
            Problem::Closed => PyValueError::new_err(problem.to_string()),
            Problem::Busy => PyRuntimeError::new_err(problem.to_string()),
            Problem::Wire(cause) => wire_error(cause),
            Problem::Sleep(_) => PyOSError::new_err(problem.to_string()),
        }
    }
}

/// Parses a duration in seconds; infinity means no limit.
pub(crate) fn seconds(what: &str, time: f64) -> PyResult<Duration> {
    match Duration::try_from_secs_f64(time) {
        Ok(time) => Ok(time),
        Err(_) if time > 0.0 => Ok(Duration::MAX),
        Err(_) => Err(value_error(format!(
            "{what} is {time}: give a number of seconds, 0 or more"
        ))),
    }
}
