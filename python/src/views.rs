#![allow(unsafe_code)] // NumPy borrows memory that Rust owns, and a message as bytes.
//! Exposes numbers of our objects as NumPy arrays, without a copy.
//!
//! The base of an array is the object, so the object lives as long as the array. Its class is
//! frozen, so Rust hands out only `&T`. Borrowed data therefore stays in place and unchanged until
//! the object is dropped.

use lariat_wire::Descriptors;
use numpy::ndarray::{ArrayView, Dimension, Ix1, Ix2};
use numpy::{Element, PyArray, PyUntypedArrayMethods, npyffi};
use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::pyclass::boolean_struct::True;

/// A row of numbers as a read-only array.
pub(crate) fn row<'py, O, T>(
    owner: &Bound<'py, O>,
    numbers: impl for<'a> FnOnce(&'a O) -> &'a [T],
) -> Bound<'py, PyArray<T, Ix1>>
where
    O: PyClass<Frozen = True> + Sync,
    T: Element,
{
    view(owner, |owner| ArrayView::from(numbers(owner)))
}

/// Rows of `K` numbers each as a read-only array.
pub(crate) fn rows<'py, O, T, const K: usize>(
    owner: &Bound<'py, O>,
    numbers: impl for<'a> FnOnce(&'a O) -> &'a [[T; K]],
) -> Bound<'py, PyArray<T, Ix2>>
where
    O: PyClass<Frozen = True> + Sync,
    T: Element,
{
    view(owner, |owner| ArrayView::from(numbers(owner)))
}

/// The bytes of a message as a read-only array.
pub(crate) fn message<'py, O>(
    owner: &Bound<'py, O>,
    message: impl for<'a> FnOnce(&'a O) -> Option<&'a Descriptors>,
) -> Bound<'py, PyArray<u8, Ix1>>
where
    O: PyClass<Frozen = True> + Sync,
{
    row(owner, |owner| {
        let message = message(owner).map_or(&[][..], std::slice::from_ref);
        let bytes = std::mem::size_of_val(message);
        // SAFETY: a message consists of integers and floats without padding, so every byte is
        // initialized.
        unsafe { std::slice::from_raw_parts(message.as_ptr().cast(), bytes) }
    })
}

fn view<'py, O, T, D>(
    owner: &Bound<'py, O>,
    numbers: impl for<'a> FnOnce(&'a O) -> ArrayView<'a, T, D>,
) -> Bound<'py, PyArray<T, D>>
where
    O: PyClass<Frozen = True> + Sync,
    T: Element,
    D: Dimension,
{
    let numbers = numbers(owner.get());
    // SAFETY: the owner is of a frozen class, so borrowed data is valid and unchanged while it
    // lives, and the array holds a reference to it.
    let array = unsafe { PyArray::borrow_from_array(&numbers, owner.clone().into_any()) };
    // SAFETY: the array is new and not shared yet.
    unsafe {
        let fields = npyffi::_PyArray_GET_ITEM_DATA(array.as_array_ptr());
        (*fields).flags &= !npyffi::NPY_ARRAY_WRITEABLE;
    }
    array
}
