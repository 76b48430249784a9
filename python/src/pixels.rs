#![allow(unsafe_code)] // Rows with gaps are read as the bytes from the first pixel to the last.
//! Images in NumPy arrays, in the form that the extractor reads.

use crate::errors::value_error;
use lariat_extract::{Image, PixelFormat};
use numpy::{
    BorrowError, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PySlice;

/// Pixel formats by name, with the length of the array's last axis in bytes per pixel; `None`
/// without such an axis.
const FORMATS: [(&str, PixelFormat, Option<usize>); 12] = [
    ("gray", PixelFormat::Gray8, None),
    ("rgb", PixelFormat::Rgb8, Some(3)),
    ("bgr", PixelFormat::Bgr8, Some(3)),
    ("yuyv", PixelFormat::Yuyv, Some(2)),
    ("uyvy", PixelFormat::Uyvy, Some(2)),
    ("nv12", PixelFormat::Nv12, None),
    ("bgra", PixelFormat::Bgra8, Some(4)),
    ("gray16", PixelFormat::Gray16, None),
    ("bayer_rggb8", PixelFormat::BayerRggb8, None),
    ("bayer_bggr8", PixelFormat::BayerBggr8, None),
    ("bayer_grbg8", PixelFormat::BayerGrbg8, None),
    ("bayer_gbrg8", PixelFormat::BayerGbrg8, None),
];

/// The pixels of an array: borrowed if its rows are contiguous, otherwise copied.
pub(crate) struct Pixels<'py> {
    array: PyReadonlyArrayDyn<'py, u8>,
    format: PixelFormat,
}

impl<'py> Pixels<'py> {
    /// The pixels of `image`. `uint8` of shape (height, width) is gray, and (height, width, 3) is
    /// `rgb` unless `format` says otherwise. `uint16` of shape (height, width) is 16-bit gray.
    ///
    /// # Errors
    /// `TypeError` if it is not an array of `uint8`; `ValueError` if its shape is not that of an
    /// image.
    pub(crate) fn of(image: &Bound<'py, PyAny>, format: Option<&str>) -> PyResult<Self> {
        if image.cast::<PyArrayDyn<u16>>().is_ok() {
            return Self::of_wide(image, format);
        }
        let mut array = bytes(image)?;
        let mut format = format_of(array.shape(), format)?;
        if format == PixelFormat::Gray16 {
            return Err(PyTypeError::new_err(
                "an image in 'gray16' is an array of uint16",
            ));
        }
        // `image[..., ::-1]` swaps red and blue, so its bytes are those of the other format.
        if let Some((back, other)) = turned(&array, format) {
            (array, format) = (back, other);
        }
        if !array.shape().contains(&0) && !has_whole_rows(&array) {
            let numpy = image.py().import("numpy")?;
            array = bytes(&numpy.call_method1("ascontiguousarray", (array,))?)?;
        }
        let array = array.try_readonly().map_err(being_written)?;
        Ok(Self { array, format })
    }

    /// The pixels of an array of `uint16`.
    fn of_wide(image: &Bound<'py, PyAny>, format: Option<&str>) -> PyResult<Self> {
        let numpy = image.py().import("numpy")?;
        let whole = numpy.call_method1("ascontiguousarray", (image,))?;
        let shape: Vec<usize> = whole.getattr("shape")?.extract()?;
        if format_of(&shape, Some(format.unwrap_or("gray16")))? != PixelFormat::Gray16 {
            return Err(PyTypeError::new_err(
                "an image of uint16 is in 'gray16': scale others to 0 to 255 and say .astype(numpy.uint8)",
            ));
        }
        // View the numbers as bytes.
        let array = bytes(&whole.call_method1("view", (numpy.getattr("uint8")?,))?)?;
        let array = array.try_readonly().map_err(being_written)?;
        let format = PixelFormat::Gray16;
        Ok(Self { array, format })
    }

    /// A mask: `uint8`, higher where rope is more likely, or `bool`, of shape (height, width).
    ///
    /// # Errors
    /// As for [`of`](Self::of).
    pub(crate) fn of_mask(mask: &Bound<'py, PyAny>) -> PyResult<Self> {
        if let Ok(array) = mask.cast::<PyArrayDyn<bool>>() {
            let numpy = mask.py().import("numpy")?;
            let of_bytes =
                numpy.call_method1("multiply", (array, numpy.call_method1("uint8", (255,))?))?;
            return Self::of(&of_bytes, Some("gray"));
        }
        Self::of(mask, Some("gray"))
    }

    /// The image.
    ///
    /// # Errors
    /// The extractor does not support the size.
    pub(crate) fn image(&self) -> PyResult<Image<'_>> {
        let (shape, strides) = (self.array.shape(), self.array.strides());
        let rows = shape[0];
        let row_bytes = shape[1..].iter().product::<usize>();
        // The stride of a single row is arbitrary.
        let stride = if rows > 1 {
            strides[0].unsigned_abs()
        } else {
            row_bytes
        };
        let bytes: &[u8] = if row_bytes == 0 || rows == 0 {
            &[]
        } else {
            // SAFETY: the rows are contiguous and ascending, `stride` apart (`has_whole_rows`, or
            // contiguous), so these are the array's own bytes and those between its rows. The array
            // is kept alive, and Rust does not write to it.
            unsafe {
                std::slice::from_raw_parts(self.array.data(), (rows - 1) * stride + row_bytes)
            }
        };
        let height = match self.format {
            // A plane of half the height follows the Y plane.
            PixelFormat::Nv12 => rows * 2 / 3,
            _ => rows,
        };
        let width = match self.format {
            // Two bytes per pixel.
            PixelFormat::Gray16 => shape[1] / 2,
            _ => shape[1],
        };
        Image::new(bytes, width, height, stride, self.format).map_err(value_error)
    }
}

fn being_written(cause: BorrowError) -> PyErr {
    value_error(format!(
        "the image is being written to ({cause}): wait for that"
    ))
}

/// The array as bytes.
fn bytes<'py>(image: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
    if let Ok(array) = image.cast::<PyArrayDyn<u8>>() {
        return Ok(array.clone());
    }
    Err(PyTypeError::new_err(match image.cast::<PyUntypedArray>() {
        Ok(array) => format!(
            "an image is an array of uint8 (or uint16, if gray), and this one is of {}: scale it to 0 to 255 and say .astype(numpy.uint8)",
            array.dtype()
        ),
        Err(_) => format!(
            "an image is a NumPy array of uint8, and this is of type {}: say numpy.asarray(image)",
            image.get_type()
        ),
    }))
}

fn format_of(shape: &[usize], name: Option<&str>) -> PyResult<PixelFormat> {
    let name = match (name, shape) {
        (Some(name), _) => name,
        (None, [_, _] | [_, _, 1]) => "gray",
        (None, _) => "rgb",
    };
    let Some((_, format, last)) = FORMATS.iter().find(|(known, _, _)| *known == name) else {
        let names = FORMATS.map(|(name, _, _)| name).join(", ");
        return Err(value_error(format!(
            "there is no pixel format '{name}': choose one of {names}"
        )));
    };
    let fits = match (shape, last) {
        ([_, _], None) => true,
        ([_, _, given], Some(wanted)) => given == wanted,
        ([_, _, 1], None) => *format == PixelFormat::Gray8,
        _ => false,
    };
    if !fits {
        let wanted = match (*format, last) {
            (PixelFormat::Nv12, _) => "(height · 3/2, width)".to_owned(),
            (_, None) => "(height, width)".to_owned(),
            (_, Some(bytes)) => format!("(height, width, {bytes})"),
        };
        let advice = match shape {
            [_, _, 4] => {
                "; leave out an alpha channel: image[..., :3] (or say pixel_format='bgra', if it is)"
            }
            _ => "",
        };
        return Err(value_error(format!(
            "an image in '{name}' has the shape {wanted}, and this one has {shape:?}{advice}"
        )));
    }
    if *format == PixelFormat::Nv12 && !shape[0].is_multiple_of(3) {
        return Err(value_error(format!(
            "an image in 'nv12' is 3/2 as high as the picture, and {} rows are not",
            shape[0]
        )));
    }
    Ok(*format)
}

/// For an array whose colors were swapped by a reversed view, the original array and its format.
fn turned<'py>(
    array: &Bound<'py, PyArrayDyn<u8>>,
    format: PixelFormat,
) -> Option<(Bound<'py, PyArrayDyn<u8>>, PixelFormat)> {
    let other = match format {
        PixelFormat::Rgb8 => PixelFormat::Bgr8,
        PixelFormat::Bgr8 => PixelFormat::Rgb8,
        _ => return None,
    };
    let is_turned = array.strides()[2] == -1;
    let py = array.py();
    let all = PySlice::full(py);
    let back = PySlice::new(py, isize::MAX, isize::MIN, -1);
    let before = is_turned
        .then(|| array.get_item((&all, &all, back)).ok())
        .flatten()?;
    Some((bytes(&before).ok()?, other))
}

/// Returns whether each row is contiguous and the next one follows it.
fn has_whole_rows(array: &Bound<'_, PyArrayDyn<u8>>) -> bool {
    let (shape, strides) = (array.shape(), array.strides());
    let mut expected = 1;
    for axis in (1..shape.len()).rev() {
        if shape[axis] > 1 && strides[axis] != expected {
            return false;
        }
        expected *= shape[axis] as isize;
    }
    shape[0] == 1 || strides[0] >= expected
}
