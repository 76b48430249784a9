#![allow(unsafe_code)] // NumPy is lent memory that Rust owns.
//! Numbers of an object of ours as NumPy arrays, without copying them.
//!
//! An array's base is the object: it lives as long as the array does. The object is of a frozen class, of which Rust hands
//! out `&T` only; what can be borrowed from that stays where it is and as it is until the object is gone.

use numpy::ndarray::{ArrayView, Dimension, Ix1, Ix2};
use numpy::{Element, PyArray, PyArrayMethods};
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
    array.readwrite().make_nonwriteable();
    array
}
