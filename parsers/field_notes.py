"""What the self-describing encodings (JSON, protobuf) have in common: limits, units in comments, header stamps."""

from __future__ import annotations

import re
from collections.abc import Collection

import numpy as np

from parsers.channels import IntArray
from parsers.units import quantities_of

MAX_LIST = 8
"""Elements of a list that become channels."""

MAX_FIELDS = 2048
"""Scalars of one message type that become channels; a type with more is a map or a cloud of points."""

_LAST_SECOND = 9_000_000_000
"""Seconds since 1970 that still fit into int64 nanoseconds: the year 2255."""

_BRACKETED = re.compile(r"[\[(]([^\[\]()]{1,20})[\])]")
_STAMPS = ("header.stamp", "header.timestamp", "timestamp", "stamp", "header.time", "time")
_SECONDS = ("sec", "secs", "seconds")
_NANOSECONDS = ("nsec", "nanosec", "nanos", "nsecs", "nanoseconds")


def unit_in(comment: str) -> str | None:
    """The first bracketed text of a comment that is a unit: "lateral acceleration [m/s^2]" -> "m/s^2"."""
    for found in _BRACKETED.finditer(comment):
        text = found.group(1).strip()
        if not text.isdigit() and quantities_of(text):
            return text
    return None


def stamp_fields(paths: Collection[str]) -> tuple[str, str] | None:
    """The fields with the seconds and the nanoseconds of a message's own stamp, or None where it has none."""
    for stamp in _STAMPS:
        for seconds in _SECONDS:
            for nanoseconds in _NANOSECONDS:
                pair = (f"{stamp}.{seconds}", f"{stamp}.{nanoseconds}")
                if pair[0] in paths and pair[1] in paths:
                    return pair
    return None


def join_stamp(seconds: IntArray, nanoseconds: IntArray) -> IntArray:
    """Stamps in nanoseconds, shape (n,); 0 (no stamp) where the seconds cannot be those of a stamp."""
    good = (seconds >= 0) & (seconds < _LAST_SECOND) & (np.abs(nanoseconds) < _LAST_SECOND)
    return np.where(good, np.where(good, seconds, 0) * 1_000_000_000 + np.where(good, nanoseconds, 0), 0)
