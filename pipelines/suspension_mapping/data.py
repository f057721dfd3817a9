"""A drive as the mapping sees it: rows without gaps, and each wheel's regressors."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.signals import prepare_signals
from pipelines.results import FloatArray

BAND_HZ = 10.0
"""Zero-phase low-pass of all signals, unless another is asked for."""

STRUTS: tuple[str, ...] = tuple(f"suspension_force_{w}" for w in WHEELS)
DEFLECTIONS: tuple[str, ...] = tuple(f"suspension_deflection_{w}" for w in WHEELS)
HUBS: tuple[str, ...] = tuple(f"accel_z_unsprung_{w}" for w in WHEELS)
MEASURED: tuple[str, ...] = tuple(f"tire_normal_force_{w}" for w in WHEELS)
OTHERS: tuple[str, ...] = ("accel_x", "accel_y", "accel_z", "yaw_rate", "speed")


@dataclass(frozen=True)
class MapData:
    """Rows of a drive in which the suspension is known, one after the other.

    time_s (n,); starts (n,): 1 where a stretch begins. columns: canonical signal -> (n,); a signal that is not there, or
    has holes in these rows, is not in it. still (n,): the vehicle stands.
    """

    rate_hz: float
    band_hz: float
    time_s: FloatArray
    starts: FloatArray
    columns: Mapping[str, FloatArray]
    still: np.ndarray
    rows: np.ndarray
    notes: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Rows."""
        return len(self.time_s)

    def has(self, names: tuple[str, ...]) -> bool:
        """Whether all of these signals are there."""
        return all(name in self.columns for name in names)


def prepare_map(drive: Drive, band_hz: float) -> Prepared:
    """What the mapping uses of a drive, on one clock, low-passed alike."""
    there = drive.signals
    wanted = [n for names in (STRUTS, DEFLECTIONS) if all(m in there for m in names) for n in names]
    wanted += [n for n in ("accel_x", "accel_y") if n in there]
    optional = [n for n in (*OTHERS, *HUBS, *MEASURED) if n not in wanted]
    return prepare_signals(drive, wanted, rate_hz=None, cutoff_hz=band_hz, optional=optional)


def collect(prepared: Prepared, *, need_measured: bool = False) -> MapData:
    """The rows of all segments. need_measured: only rows where all four measuring wheels are there (for training)."""
    n = len(prepared.time_s)
    inside = np.zeros(n, dtype=bool)
    starts = np.zeros(n)
    for segment in prepared.segments:
        inside[segment.start : segment.stop] = True
        starts[segment.start] = 1.0
    if need_measured and all(name in prepared.columns for name in MEASURED):
        there = np.all([np.isfinite(prepared.columns[name]) for name in MEASURED], axis=0)
        inside &= there
    rows = np.flatnonzero(inside)
    begin = np.concatenate(([True], np.diff(rows) > 1)) if len(rows) else np.zeros(0, dtype=bool)
    first = np.maximum(starts[rows], begin.astype(np.float64))
    columns: dict[str, FloatArray] = {}
    for name, column in prepared.columns.items():
        values = column[rows]
        there = np.isfinite(values)
        if len(values) and there.all():
            columns[name] = values
        elif len(values) and name in (*OTHERS, *HUBS) and float(np.mean(there)) >= 0.9:
            # a speed that comes at 20 Hz ends a few rows early: that must not cost the whole column
            columns[name] = np.interp(rows, rows[there], values[there])
    return MapData(
        prepared.rate_hz, prepared.cutoff_hz, prepared.time_s[rows], first, columns, prepared.standstill[rows], rows,
        prepared.notes,
    )  # fmt: skip


def narrowed(data: MapData, band_hz: float) -> MapData:
    """The rows low-passed at a lower band, as a map was trained on; stretch by stretch."""
    columns = {}
    for name, values in data.columns.items():
        out = np.array(values)
        for first, past in stretches(data.starts):
            out[first:past] = lowpass(values[first:past], data.rate_hz, band_hz)
        columns[name] = out
    return replace(data, columns=columns, band_hz=band_hz)


_FIRST = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
_SECOND = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0
"""Central differences of sixth order: two-point ones would take a third off a motion at the band's end."""


def stretches(starts: FloatArray) -> Iterator[tuple[int, int]]:
    """First row and past the last of each stretch. starts (n,): 1 where one begins."""
    edges = [*np.flatnonzero(starts > 0.5).tolist(), len(starts)]
    return itertools.pairwise(edges)


def _differences(values: FloatArray, starts: FloatArray, stencil: FloatArray, scale: float) -> FloatArray:
    out = np.zeros(len(values))
    for first, past in stretches(starts):
        if past - first < len(stencil):
            continue
        # the ends are continued by turning the signal about its end points
        part = values[first:past]
        before, after = 2 * part[0] - part[3:0:-1], 2 * part[-1] - part[-2:-5:-1]
        padded = np.concatenate((before, part, after))
        out[first:past] = np.convolve(padded, stencil[::-1], mode="valid") * scale
    return out


def rate_of(values: FloatArray, starts: FloatArray, rate_hz: float) -> FloatArray:
    """Derivative over time, stretch by stretch; (n,)."""
    return _differences(values, starts, _FIRST, rate_hz)


def second_rate_of(values: FloatArray, starts: FloatArray, rate_hz: float) -> FloatArray:
    """Second derivative over time, stretch by stretch; (n,)."""
    return _differences(values, starts, _SECOND, rate_hz**2)
