"""The stamp that a JSON message has as one number: {"timestamp": 1710597922.02, …}, since 1970 in s, ms, µs or ns."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from parsers.channels import FloatArray, IntArray

_KEYS = (
    "timestamp",
    "time_stamp",
    "stamp",
    "ts",
    "time",
    "timestamp_s",
    "timestamp_ms",
    "timestamp_us",
    "timestamp_ns",
    "utime",
)
_UNITS_NS = (1.0, 1e3, 1e6, 1e9)
_FROM_S, _TO_S = 946_684_800.0, 4_102_444_800.0
"""The years 2000 to 2100: what lies within in one unit lies far outside in the others."""


@dataclass(frozen=True)
class NumberStamp:
    """path: of the number. unit_ns: what one of it is."""

    path: str
    unit_ns: float

    def stamps(self, values: FloatArray) -> IntArray:
        """Stamps in nanoseconds, shape (n,); 0 where a message has none of this time."""
        scaled = values * self.unit_ns
        good = _possible(scaled)
        return np.where(good, np.round(np.where(good, scaled, 0.0)), 0).astype(np.int64)


def _possible(time_ns: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    with np.errstate(invalid="ignore"):
        return (time_ns >= _FROM_S * 1e9) & (time_ns < _TO_S * 1e9)


def may_have_stamp(keys: Iterable[str]) -> bool:
    """Whether one of a message's keys may hold its stamp, so that messages must be looked at for its unit."""
    return any(key.lower() in _KEYS for key in keys)


def number_stamp(samples: Sequence[Any]) -> NumberStamp | None:
    """The first key of messages by which all of them that have it lie in this century; None where none does. samples: messages as Python values."""
    messages = [each for each in samples if isinstance(each, dict)]
    for wanted in _KEYS:
        for key in dict.fromkeys(key for each in messages for key in each if key.lower() == wanted):
            held = [each[key] for each in messages if key in each]
            if not all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in held):
                continue
            values = np.array([float(value) for value in held])
            unit = next((unit for unit in _UNITS_NS if _possible(values * unit).all()), None)
            if unit is not None:
                return NumberStamp(key, unit)
    return None
