//! Extraction from arrays: consecutive images of one moving scene.

use crate::errors::value_error;
use crate::pixels::Pixels;
use crate::scene::{Kept, Scene};
use lariat_extract::{
    Extractor, HsvRange, Mask, MaskError, Method, Network, Options, PickError, Region, mask_levels,
};
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyUserWarning};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ffi::CString;
use std::num::NonZeroU8;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use std::time::Duration;
use thiserror::Error;

/// Reason why an image was not traced.
#[derive(Debug, Error)]
enum Problem {
    #[error(
        "another thread traces a picture with this tracer: give each thread a tracer of its own"
    )]
    Busy,
    #[error(transparent)]
    Mask(#[from] MaskError),
}

impl From<Problem> for PyErr {
    fn from(problem: Problem) -> Self {
        match problem {
            Problem::Busy => PyRuntimeError::new_err(problem.to_string()),
            Problem::Mask(_) => value_error(problem),
        }
    }
}

/// Traces images of one moving scene, and remembers it from one image to the next. Ropes keep their
/// numbers and directions and are tracked, which costs a fraction of a full extraction.
#[pyclass(frozen, module = "lariat")]
pub(crate) struct Tracer {
    extractor: Mutex<Extractor>,
    region: Option<Region>,
    /// True if the level of a mask is chosen automatically. The mask's values may then have another
    /// meaning.
    chooses_level: bool,
}

#[pymethods]
impl Tracer {
    #[new]
    #[pyo3(signature = (*, mask=None, mask_level=None, network=None, method="skeleton", points=120, ropes=24, min_confidence=0.5, start=None, at=Vec::new(), keep_lost_s=1.0, roi=None))]
    #[allow(clippy::too_many_arguments)] // They are keyword arguments in Python.
    fn new(
        mask: Option<&Bound<'_, PyAny>>,
        mask_level: Option<NonZeroU8>,
        network: Option<PathBuf>,
        method: &str,
        points: usize,
        ropes: usize,
        min_confidence: f32,
        start: Option<[f32; 2]>,
        at: Vec<[f32; 2]>,
        keep_lost_s: f64,
        roi: Option<[usize; 4]>,
    ) -> PyResult<Self> {
        let region = roi.map(|[x, y, width, height]| Region {
            x,
            y,
            width,
            height,
        });
        // The extractor sees only the region.
        let [left, top] = region.map_or([0.0; 2], |region| [region.x as f32, region.y as f32]);
        let in_region = |[x, y]: [f32; 2]| [x - left, y - top];
        let chooses_level = mask_level.is_none();
        let options = Options::default()
            .mask(mask.map_or(Ok(Mask::Auto), mask_of)?)
            .mask_level(mask_level)
            .method(method.parse::<Method>().map_err(value_error)?)
            .points(points)
            .ropes(ropes)
            .min_confidence(min_confidence)
            .start(start.map(in_region))
            .at(at.into_iter().map(in_region).collect())
            .keep_lost(Duration::try_from_secs_f64(keep_lost_s).map_err(|_| {
                value_error(format!(
                    "keep_lost_s is {keep_lost_s}: give a number of seconds, 0 or more"
                ))
            })?);
        let mut extractor = Extractor::new(options).map_err(value_error)?;
        if let Some(file) = network {
            let network = Network::from_bytes(&std::fs::read(&file)?);
            extractor = (extractor.with_network(Arc::new(network.map_err(value_error)?)))
                .map_err(value_error)?;
        }
        Ok(Self {
            extractor: Mutex::new(extractor),
            region,
            chooses_level,
        })
    }

    /// Finds the ropes in the next image.
    #[pyo3(signature = (image, *, mask=None, pixel_format=None, at_ns=None))]
    fn trace(
        &self,
        py: Python<'_>,
        image: &Bound<'_, PyAny>,
        mask: Option<&Bound<'_, PyAny>>,
        pixel_format: Option<&str>,
        at_ns: Option<u64>,
    ) -> PyResult<Scene> {
        let pixels = Pixels::of(image, pixel_format)?;
        let mask = mask.map(Pixels::of_mask).transpose()?;
        let whole = pixels.image()?;
        let whole_mask = mask.as_ref().map(Pixels::image).transpose()?;
        let region = self.region_in(&whole)?;
        let (image, mask, origin) = match region {
            None => (whole, whole_mask, [0.0; 2]),
            Some(region) => {
                let within = whole.region(region);
                // A mask of another size is passed whole, so that it is rejected.
                let mask = whole_mask.map(|mask| {
                    match mask.width() == whole.width() && mask.height() == whole.height() {
                        true => mask.region(region).unwrap_or(mask),
                        false => mask,
                    }
                });
                (
                    within.unwrap_or(whole),
                    mask,
                    [region.x as f32, region.y as f32],
                )
            }
        };
        let read = match &mask {
            Some(mask) if self.chooses_level => mask_levels(mask).map_err(Problem::Mask)?,
            _ => None,
        };
        if let Some(notice) = read.as_ref().and_then(|read| read.notice.as_ref()) {
            warn(py, notice)?;
        }
        let mask = match &read {
            Some(read) => Some(read.image().map_err(value_error)?),
            None => mask,
        };
        let size = (whole.width(), whole.height());
        let kept = py.detach(move || -> Result<Kept, Problem> {
            let mut extractor = self.extractor()?;
            if let Some(at_ns) = at_ns {
                extractor.at(at_ns);
            }
            let scene = match &mask {
                None => extractor.extract(&image),
                Some(mask) => extractor.extract_masked(&image, mask)?,
            };
            Ok(Kept::new(&scene, origin, size).in_words(&extractor))
        });
        Scene::new(py, kept?)
    }

    /// Forgets the past, so that the next image is a new scene.
    fn reset(&self) -> PyResult<()> {
        self.extractor()?.reset();
        Ok(())
    }
}

impl Tracer {
    fn extractor(&self) -> Result<MutexGuard<'_, Extractor>, Problem> {
        match self.extractor.try_lock() {
            Ok(extractor) => Ok(extractor),
            Err(TryLockError::WouldBlock) => Err(Problem::Busy),
            // Whatever happened, a new scene starts from nothing.
            Err(TryLockError::Poisoned(poisoned)) => {
                let mut extractor = poisoned.into_inner();
                extractor.reset();
                Ok(extractor)
            }
        }
    }

    /// The region of an image that is read.
    fn region_in(&self, image: &lariat_extract::Image) -> PyResult<Option<Region>> {
        let Some(region) = self.region else {
            return Ok(None);
        };
        let outside = || {
            value_error(format!(
                "nothing of roi = ({}, {}, {}, {}) lies in an image of {}×{} pixels: it is (x, y, width, height)",
                region.x,
                region.y,
                region.width,
                region.height,
                image.width(),
                image.height()
            ))
        };
        region.within(image).ok_or_else(outside).map(Some)
    }
}

/// Parses `"auto"`, `"network"`, `"external"`, a range or a list of ranges.
fn mask_of(mask: &Bound<'_, PyAny>) -> PyResult<Mask> {
    if let Ok(name) = mask.extract::<String>() {
        return match &name[..] {
            "auto" => Ok(Mask::Auto),
            "network" => Ok(Mask::Network),
            "external" => Ok(Mask::External),
            _ => Err(value_error(format!(
                "there is no mask '{name}': say \"auto\", \"network\", \"external\" or colour ranges, as lariat.pick proposes them"
            ))),
        };
    }
    if let Ok(range) = mask.cast::<PyDict>() {
        return Ok(Mask::Hsv(vec![range_of(range)?]));
    }
    let ranges: Vec<Bound<'_, PyDict>> = mask.extract().map_err(|_| {
        PyTypeError::new_err(
            "a mask is \"auto\", \"external\" or a list of ranges {\"hue_deg\": (190, 250), \"saturation\": (0.3, 1), \
             \"value\": (0.2, 1)}",
        )
    })?;
    Ok(Mask::Hsv(
        ranges.iter().map(range_of).collect::<PyResult<_>>()?,
    ))
}

/// Parses a range from Python. Missing bounds are unrestricted.
fn range_of(range: &Bound<'_, PyDict>) -> PyResult<HsvRange> {
    let mut found = HsvRange {
        hue_deg: [0.0, 360.0],
        saturation: [0.0, 1.0],
        value: [0.0, 1.0],
    };
    for (key, bounds) in range {
        let key: String = key.extract()?;
        let place = match &key[..] {
            "hue_deg" => &mut found.hue_deg,
            "saturation" => &mut found.saturation,
            "value" => &mut found.value,
            _ => {
                return Err(value_error(format!(
                    "a range has no \"{key}\": it has hue_deg, saturation and value"
                )));
            }
        };
        *place = bounds.extract().map_err(|_| {
            PyTypeError::new_err(format!(
                "{key} of a range is a pair of numbers, the smaller first"
            ))
        })?;
    }
    Ok(found)
}

/// One position, or a list of positions.
#[derive(Debug, FromPyObject)]
pub(crate) enum Points {
    One([f32; 2]),
    Some(Vec<[f32; 2]>),
}

/// Proposes color ranges of the ropes in an image, for the setting `mask`. They cover all ropes
/// that differ from the table, or only the ropes at one or several positions `at`, with one range
/// for each color. Also returns how well the ranges separate rope from table. Below about 0.7,
/// their mask has holes or includes parts of the table. Warns if tracing with that mask gives a
/// doubtful result.
#[pyfunction]
#[pyo3(signature = (image, at=None, *, pixel_format=None))]
pub(crate) fn pick<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    at: Option<Points>,
    pixel_format: Option<&str>,
) -> PyResult<(Vec<Bound<'py, PyDict>>, f32)> {
    let points = match at {
        None => Vec::new(),
        Some(Points::One(at)) => vec![at],
        Some(Points::Some(at)) => at,
    };
    let pixels = Pixels::of(image, pixel_format)?;
    let image = pixels.image()?;
    let (picked, doubt) = py
        .detach(|| {
            let picked = lariat_extract::pick(&image, &points)?;
            let doubt = lariat_extract::judge_pick(&image, &picked.ranges, &points).doubt;
            Ok::<_, PickError>((picked, doubt))
        })
        .map_err(value_error)?;
    if let Some(doubt) = doubt {
        warn(py, &doubt.to_string())?;
    }
    let ranges = picked.ranges.iter().map(|range| {
        let dict = PyDict::new(py);
        dict.set_item("hue_deg", <(f32, f32)>::from(range.hue_deg))?;
        dict.set_item("saturation", <(f32, f32)>::from(range.saturation))?;
        dict.set_item("value", <(f32, f32)>::from(range.value))?;
        Ok(dict)
    });
    Ok((ranges.collect::<PyResult<_>>()?, picked.agreement))
}

/// Issues a Python warning at the line of the caller.
fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    let category = py.get_type::<PyUserWarning>();
    PyErr::warn(py, &category, &CString::new(text)?, 1)
}
