#![allow(unsafe_code)] // NumPy is lent memory that Rust owns, and a message as its bytes.
//! Numbers of an object of ours as NumPy arrays, without copying them.
//!
//! An array's base is the object: it lives as long as the array does. The object is of a frozen class, of which Rust hands
//! out `&T` only; what can be borrowed from that stays where it is and as it is until the object is gone.

use lariat_wire::Descriptors;
use numpy::ndarray::{ArrayView, Dimension, Ix1, Ix2};
use numpy::{Element, PyArray, PyUntypedArrayMethods, npyffi};
use pyo3::PyClass;
use pyo3::prelude::*;
use pyo3::pyclass::boolean_struct::True;

/// A row of numbers, as an array that cannot be written to.
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

/// Rows of `K` numbers each, likewise.
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

/// The bytes of a message, likewise.
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
        // SAFETY: a message is made of integers and floats without padding, so that each of its bytes has a value.
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
    // SAFETY: what is borrowed from the owner is valid and unchanged while that lives, being of a frozen class, and the
    // array holds a reference to it.
    let array = unsafe { PyArray::borrow_from_array(&numbers, owner.clone().into_any()) };
    // SAFETY: the array is new, and nobody else's yet.
    unsafe {
        let fields = npyffi::_PyArray_GET_ITEM_DATA(array.as_array_ptr());
        (*fields).flags &= !npyffi::NPY_ARRAY_WRITEABLE;
    }
    array
}
