"""State of a rope as a type, and as an exception for code that prefers one."""

from __future__ import annotations

from typing import TypeAlias, Union

from lariat._native import Absent, Fresh, Lost, Partial, Stale, Unsure

Seen: TypeAlias = Union[Fresh, Partial, Unsure, Lost, Stale, Absent]
"""State of a rope: distinguish it with ``match`` or ``isinstance``, or call ``or_raise()``."""


class NotSeen(Exception):
    """A requested rope is missing, or not in the requested state. ``seen`` is its state instead."""

    def __init__(self, seen: Partial | Unsure | Lost | Stale | Absent) -> None:
        super().__init__(str(seen))
        self.seen = seen
