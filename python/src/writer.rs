#![allow(unsafe_code)] // NumPy writes into slots of shared memory.
//! Writers for users' own frames and masks in Python. `lariat/_writer.py` handles arrays and their
//! checks.
//!
//! Arrays of a slot are views of shared memory, which stays in place while one of them lives. As
//! with a mapped file, a writer is not destroyed while an array of its slot exists.

use crate::errors::{value_error, wire_error};
use crate::frames::Image;
use lariat_wire::{
    DepthWriter, Domain, FrameWriter, MaskWriter, PixelFormat, Stamp, Waiting, WriteError,
};
use numpy::PyArray1;
use numpy::ndarray::ArrayView1;
use pyo3::exceptions::{PyBufferError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

/// The channel's writer. Boxed, because its header is aligned to a cache line and Python objects
/// are not.
enum End {
    Frames(Box<FrameWriter>),
    Masks(Box<MaskWriter>),
    Depths(Box<DepthWriter>),
}

impl End {
    fn has_room(&self, bytes: usize) -> bool {
        match self {
            Self::Frames(writer) => writer.has_room(bytes),
            Self::Masks(writer) => writer.has_room(bytes),
            Self::Depths(writer) => writer.has_room(bytes),
        }
    }
}

/// Writes a rig's frames or masks.
#[pyclass(frozen, subclass, module = "lariat._native")]
pub(crate) struct Writer {
    /// `None` once closed.
    end: Mutex<Option<End>>,
    /// Number of arrays and other views of slots.
    views: AtomicUsize,
    /// True if the writer closes when the last view is dropped.
    is_closing: AtomicBool,
    /// Number of the current loan.
    loan: AtomicU64,
    /// Ends a wait for slow readers.
    stop: Arc<AtomicBool>,
    /// Exception that a signal handler raised during such a wait.
    raised: Arc<Mutex<Option<PyErr>>>,
    rig: String,
    channel: &'static str,
}

#[pymethods]
impl Writer {
    #[new]
    #[pyo3(signature = (channel, rig="default", *, lossless=None))]
    fn new(py: Python<'_>, channel: &str, rig: &str, lossless: Option<bool>) -> PyResult<Self> {
        let (stop, raised) = (Arc::new(AtomicBool::new(false)), Arc::default());
        let waiting = Waiting {
            lossless,
            stop: stop.clone(),
            meanwhile: Some(ask_for_signals(&stop, &raised)),
        };
        const CHANNELS: [&str; 3] = ["frames", "masks", "depth"];
        let Some(channel) = CHANNELS.into_iter().find(|known| *known == channel) else {
            return Err(value_error(format!(
                "Invalid channel '{channel}': use \"frames\", \"masks\" or \"depth\""
            )));
        };
        let open = || -> Result<End, WriteError> {
            let (domain, rig) = (Domain::open()?, rig.parse()?);
            Ok(match channel {
                "frames" => End::Frames(FrameWriter::open_in(domain, &rig, waiting)?.into()),
                "masks" => End::Masks(MaskWriter::open_in(domain, &rig, waiting)?.into()),
                _ => End::Depths(DepthWriter::open_in(domain, &rig, waiting)?.into()),
            })
        };
        let end = py.detach(open);
        Ok(Self {
            end: Mutex::new(Some(end.map_err(write_error)?)),
            views: AtomicUsize::new(0),
            is_closing: AtomicBool::new(false),
            loan: AtomicU64::new(0),
            stop,
            raised,
            rig: rig.to_owned(),
            channel,
        })
    }

    /// Borrows the slot of a frame.
    fn loan_frame(
        this: Bound<'_, Self>,
        height: u32,
        width: u32,
        pixel_format: &str,
    ) -> PyResult<Slot> {
        let Some(format) = PixelFormat::from_name(pixel_format) else {
            let names = PixelFormat::ALL.map(PixelFormat::name).join(", ");
            return Err(value_error(format!(
                "Invalid pixel format '{pixel_format}': use one of {names}"
            )));
        };
        let (shape, item_bytes) = array_shape(height as usize, width as usize, format);
        let bytes = shape.iter().product::<usize>() * item_bytes;
        Self::loan(&this, shape, item_bytes, bytes, |end| match end {
            End::Frames(writer) => writer.loan(width, height, format),
            End::Masks(_) | End::Depths(_) => Err(WriteError::NothingOnLoan),
        })
    }

    /// Borrows the slot of a frame's mask.
    fn loan_mask(this: Bound<'_, Self>, frame: &Image) -> PyResult<Slot> {
        let header = frame.header();
        let shape = vec![header.height as usize, header.width as usize];
        let bytes = shape[0] * shape[1];
        Self::loan(&this, shape, 1, bytes, |end| match end {
            End::Masks(writer) => writer.loan(header),
            End::Frames(_) | End::Depths(_) => Err(WriteError::NothingOnLoan),
        })
    }

    /// Borrows the slot of a frame's depth image.
    fn loan_depth(this: Bound<'_, Self>, frame: &Image, height: u32, width: u32) -> PyResult<Slot> {
        let shape = vec![height as usize, width as usize];
        let bytes = 2 * shape[0] * shape[1];
        Self::loan(&this, shape, 2, bytes, |end| match end {
            End::Depths(writer) => writer.loan(frame.header(), [width, height]),
            End::Frames(_) | End::Masks(_) => Err(WriteError::NothingOnLoan),
        })
    }

    /// Sends a frame without an image.
    fn send_blank(&self, py: Python<'_>) -> PyResult<()> {
        self.send(py, |end| match end {
            End::Frames(writer) => writer.send_blank(Stamp::default()),
            End::Masks(_) | End::Depths(_) => Err(WriteError::NothingOnLoan),
        })
    }

    /// True if it waits for slow readers.
    #[getter]
    fn lossless(&self) -> PyResult<bool> {
        Ok(match open(&mut self.lock()?)? {
            End::Frames(writer) => writer.is_lossless(),
            End::Masks(writer) => writer.is_lossless(),
            End::Depths(writer) => writer.is_lossless(),
        })
    }

    /// Name of the rig.
    #[getter]
    fn rig(&self) -> &str {
        &self.rig
    }

    /// Leaves the rig, so that another writer can open it. Sent frames are delivered.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.loan.fetch_add(1, Ordering::Relaxed);
        let mut guard = self.lock()?;
        if self.views.load(Ordering::Relaxed) > 0 {
            // The last array closes it.
            self.is_closing.store(true, Ordering::Relaxed);
            return Ok(());
        }
        let end = guard.take();
        drop(guard);
        // Leaving removes what dead processes left, which may take a while.
        let end = end.map(Alone);
        py.detach(|| drop(end));
        Ok(())
    }

    /// True if closed.
    #[getter]
    fn closed(&self) -> PyResult<bool> {
        Ok(self.is_closing.load(Ordering::Relaxed) || self.lock()?.is_none())
    }

    fn __enter__(this: Py<Self>) -> Py<Self> {
        this
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&self, py: Python<'_>, _error: &Bound<'_, PyTuple>) -> PyResult<()> {
        self.close(py)
    }

    fn __repr__(&self) -> String {
        let state = match self.closed() {
            Ok(true) => ", closed",
            _ => "",
        };
        format!(
            "<lariat.Writer of {} of rig '{}'{state}>",
            self.channel, self.rig
        )
    }
}

/// Moves the writer to code that runs without Python.
struct Alone(#[allow(dead_code, reason = "it is only dropped")] End);

impl Writer {
    fn lock(&self) -> PyResult<MutexGuard<'_, Option<End>>> {
        match self.end.try_lock() {
            Ok(end) => Ok(end),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err(
                "another thread uses this writer, or waits with it: let one thread write",
            )),
        }
    }

    fn loan(
        this: &Bound<'_, Self>,
        shape: Vec<usize>,
        item_bytes: usize,
        bytes: usize,
        borrow: impl FnOnce(&mut End) -> Result<&mut [u8], WriteError> + Send,
    ) -> PyResult<Slot> {
        let writer = this.get();
        let mut guard = writer.lock()?;
        if writer.is_closing.load(Ordering::Relaxed) {
            return Err(closed());
        }
        let end = open(&mut guard)?;
        if writer.views.load(Ordering::Relaxed) > 0 && !end.has_room(bytes) {
            return Err(PyBufferError::new_err(
                "this image is larger than those before, and an array of an earlier slot is still there: \
                 let go of it (del), or copy it, so that larger slots can be made",
            ));
        }
        let slot = this
            .py()
            .detach(|| borrow(end).map(|slot| (slot.as_mut_ptr() as usize, slot.len())));
        let (address, length) = slot.map_err(write_error)?;
        Ok(Slot {
            writer: this.clone().unbind(),
            number: writer.loan.fetch_add(1, Ordering::Relaxed) + 1,
            address,
            length,
            shape,
            item_bytes,
        })
    }

    fn send(
        &self,
        py: Python<'_>,
        send: impl FnOnce(&mut End) -> Result<bool, WriteError> + Send,
    ) -> PyResult<()> {
        self.loan.fetch_add(1, Ordering::Relaxed);
        let mut guard = self.lock()?;
        let end = open(&mut guard)?;
        self.stop.store(false, Ordering::Relaxed);
        py.detach(|| send(end)).map_err(write_error)?;
        // A frame that was given up because of the signal counts as lost.
        let raised = self.raised.lock().map(|mut raised| raised.take());
        raised.ok().flatten().map_or(Ok(()), Err)
    }
}

fn open<'a>(guard: &'a mut MutexGuard<'_, Option<End>>) -> PyResult<&'a mut End> {
    guard.as_mut().ok_or_else(closed)
}

fn closed() -> PyErr {
    PyValueError::new_err("this writer is closed: open another one")
}

/// Runs Python's signal handlers while the writer waits for a slow reader. Ctrl-C ends the wait.
fn ask_for_signals(
    stop: &Arc<AtomicBool>,
    raised: &Arc<Mutex<Option<PyErr>>>,
) -> Arc<dyn Fn() + Send + Sync> {
    let (stop, raised) = (stop.clone(), raised.clone());
    Arc::new(move || {
        if let Err(cause) = Python::attach(|py| py.check_signals()) {
            if let Ok(mut raised) = raised.lock() {
                *raised = Some(cause);
            }
            stop.store(true, Ordering::Relaxed);
        }
    })
}

/// Converts an error to a Python exception: `ValueError` for invalid arguments, otherwise as for a
/// reader.
fn write_error(cause: WriteError) -> PyErr {
    match cause {
        WriteError::Wire(cause) => wire_error(cause),
        WriteError::FramesTaken { .. } => PyOSError::new_err(cause.to_string()),
        cause => value_error(cause),
    }
}

/// The shape of a format's array, and the bytes per element.
pub(crate) fn array_shape(height: usize, width: usize, format: PixelFormat) -> (Vec<usize>, usize) {
    // Rows of all planes, one after the other.
    let rows = format.image_bytes(1, u32::try_from(height).unwrap_or(u32::MAX));
    // Computed for two pixels, because some formats cannot represent a single pixel.
    let pixel_bytes = format.row_bytes(2) / 2;
    // In formats where two pixels share their color, a row consists of whole pairs.
    let width = format.row_bytes(u32::try_from(width).unwrap_or(u32::MAX)) / pixel_bytes;
    match pixel_bytes {
        1 => (vec![rows, width], 1),
        2 if format.name() == "gray16" => (vec![rows, width], 2),
        channels => (vec![rows, width, channels], 1),
    }
}

/// The bytes as an array of that shape.
pub(crate) fn shaped<'py>(
    flat: &Bound<'py, PyArray1<u8>>,
    shape: &[usize],
    item_bytes: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let dtype = if item_bytes == 2 { "uint16" } else { "uint8" };
    let array = flat.as_any().call_method1("view", (dtype,))?;
    array.call_method1("reshape", (PyTuple::new(flat.py(), shape)?,))
}

/// Base of a slot's array, which keeps the writer and its memory alive.
#[pyclass(frozen)]
struct View(Py<Writer>);

impl View {
    fn of(writer: Py<Writer>) -> Self {
        writer.get().views.fetch_add(1, Ordering::Relaxed);
        Self(writer)
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let writer = self.0.get();
        let was_last = writer.views.fetch_sub(1, Ordering::Relaxed) == 1;
        if was_last
            && writer.is_closing.load(Ordering::Relaxed)
            && let Ok(mut end) = writer.lock()
        {
            *end = None;
        }
    }
}

/// A borrowed slot of shared memory.
#[pyclass(frozen, module = "lariat._native")]
pub(crate) struct Slot {
    writer: Py<Writer>,
    /// Number of the loan.
    number: u64,
    address: usize,
    length: usize,
    shape: Vec<usize>,
    item_bytes: usize,
}

#[pymethods]
impl Slot {
    /// Returns an array that is the slot itself.
    fn array<'py>(slot: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (py, this) = (slot.py(), slot.get());
        this.check()?;
        let view = Bound::new(py, View::of(this.writer.clone_ref(py)))?;
        // SAFETY: the slot is mapped while the view lives, which its writer counts, and belongs to
        // nobody else while on loan. A later write into it corrupts an image, whose bytes may have
        // any value.
        let flat = unsafe {
            let slot = ArrayView1::from_shape_ptr(this.length, this.address as *const u8);
            PyArray1::borrow_from_array(&slot, view.into_any())
        };
        shaped(&flat, &this.shape, this.item_bytes)
    }

    /// Sends the slot as a frame.
    #[pyo3(signature = (exposed_ns=None, sequence=None))]
    fn send_frame(
        &self,
        py: Python<'_>,
        exposed_ns: Option<u64>,
        sequence: Option<u64>,
    ) -> PyResult<()> {
        self.send(py, |end| match end {
            End::Frames(writer) => writer.send(Stamp {
                exposed_ns,
                sequence,
            }),
            End::Masks(_) | End::Depths(_) => Err(WriteError::NothingOnLoan),
        })
    }

    /// Sends the slot as a depth image.
    fn send_depth(&self, py: Python<'_>) -> PyResult<()> {
        self.send(py, |end| match end {
            End::Depths(writer) => writer.send(),
            End::Frames(_) | End::Masks(_) => Err(WriteError::NothingOnLoan),
        })
    }

    /// Sends the slot as a mask.
    fn send_mask(&self, py: Python<'_>) -> PyResult<()> {
        self.send(py, |end| match end {
            End::Masks(writer) => writer.send(),
            End::Frames(_) | End::Depths(_) => Err(WriteError::NothingOnLoan),
        })
    }
}

impl Slot {
    /// Checks that the slot is still on loan.
    fn check(&self) -> PyResult<()> {
        if self.writer.get().loan.load(Ordering::Relaxed) != self.number {
            return Err(PyValueError::new_err(
                "this slot was sent, or given back: borrow another one",
            ));
        }
        Ok(())
    }

    fn send(
        &self,
        py: Python<'_>,
        send: impl FnOnce(&mut End) -> Result<bool, WriteError> + Send,
    ) -> PyResult<()> {
        self.check()?;
        self.writer.get().send(py, send)
    }
}
