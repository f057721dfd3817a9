"""Positions that a table holds between fixes: 1 Hz of satellites in rows of 100 Hz. Held, they stand and jump; as they are, they move."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from parsers.drive import Signal

_LEAST_FIXES = 10
_LEAST_ROWS = 2
"""Rows, at the median, for which a fix stays: below it nothing is held."""


def fixes(signals: Mapping[str, Signal]) -> dict[str, Signal]:
    """The signals, latitude and longitude with the first sample of each fix alone where they are held."""
    latitude, longitude = signals.get("latitude"), signals.get("longitude")
    if latitude is None or longitude is None or not np.array_equal(latitude.time_ns, longitude.time_ns):
        return dict(signals)
    moved = np.diff(latitude.values) != 0
    moved |= np.diff(longitude.values) != 0
    at = np.flatnonzero(np.append(True, moved))
    if len(at) < _LEAST_FIXES or float(np.median(np.diff(at))) < _LEAST_ROWS:
        return dict(signals)
    time_ns = latitude.time_ns[at]
    thin = {
        each.name: replace(each, time_ns=time_ns, values=each.values[at]) for each in (latitude, longitude)
    }
    return {name: thin.get(name, signal) for name, signal in signals.items()}
