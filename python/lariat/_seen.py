"""What is known of a rope, as a type, and as an exception for those who would rather have that."""

from __future__ import annotations

from typing import TypeAlias, Union

from lariat._native import Absent, Fresh, Lost, Partial, Stale, Unsure

Seen: TypeAlias = Union[Fresh, Partial, Unsure, Lost, Stale, Absent]
"""What is known of a rope: tell it apart with ``match`` or ``isinstance``, or say ``or_raise()``."""


class NotSeen(Exception):
    """A rope was asked for that is not there, or not as it was asked for. ``seen`` is what is known instead."""

    def __init__(self, seen: Partial | Unsure | Lost | Stale | Absent) -> None:
        super().__init__(str(seen))
        self.seen = seen
