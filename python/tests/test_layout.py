"""One layout in every language: a message in which each number is its own offset
(examples/message_of_offsets.rs)."""

from __future__ import annotations

import subprocess

import numpy as np
from conftest import program

import lariat


def check(record: np.dtype[np.void], numbers: np.void, at: int) -> int:
    """Returns how many numbers of a record that begins at this offset equal their own offsets;
    others are an error."""
    checked = 0
    assert record.fields is not None
    for name, (field, offset, *_) in record.fields.items():
        values = np.asarray(numbers[name]).ravel()
        element, size = field.base, field.base.itemsize
        for i, value in enumerate(values):
            place = at + offset + i * size
            if element.fields is not None:
                checked += check(element, value, place)
            else:
                assert value == place + (0.5 if element.kind == "f" else 0), f"{name}[{i}] at {place}"
                checked += 1
    return checked


def test_every_field_is_read_where_the_writer_put_it(domain: str) -> None:
    writer = subprocess.Popen(
        [program("examples/message_of_offsets")], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    with lariat.Reader() as reader:
        frame = reader.wait(30.0)
    writer.communicate(timeout=30)
    assert lariat.MESSAGE.itemsize == 132_592
    assert frame.message.base is not None and not frame.message.flags.writeable
    # The message has 13 + 4 numbers. Each of 24 ropes has 19, and 9 for each of 32 control points;
    # its centerline has 10, and 3 for each of 256 points.
    assert check(lariat.MESSAGE, frame.message, 0) == 17 + 24 * (19 + 32 * 9 + 10 + 256 * 3)
    # The same numbers by name.
    assert frame.trace is not None and frame.trace.fitted_ns == 80 and frame.size == (96, 100)
    # They form a message, but not a rope.
    assert {str(seen) for seen in frame.ropes(float("inf"))} == {
        "the message makes no sense: use the same release of lariat for every process"
    }
