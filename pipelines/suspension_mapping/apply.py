"""Apply a suspension map to a drive: tyre normal forces with intervals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.signals import WHEELS
from pipelines.results import FloatArray
from pipelines.suspension_mapping.data import DEFLECTIONS, MEASURED, STRUTS, MapData, rate_of
from pipelines.suspension_mapping.record import MapPart, SuspensionMap, WheelMap
from pipelines.suspension_mapping.regressors import (
    REGRESSORS,
    carried_by_springs,
    carried_by_struts,
    shared_columns,
    wheel_columns,
)
from pipelines.suspension_mapping.spread import QUANTILE, state_of

LOAD_SHARE = {"struts": 0.015, "springs": 0.05}
"""Standard deviation of the force over how much a wheel's load differs from the training's: a force sensor's scale, a
spring's rate between driving and standing."""


LAG_S = 0.005
"""Standard deviation of how late the sensors' filters make a force: on rough roads a few milliseconds are tens of newtons."""


COARSE = 3.0
"""Factor on the residual's variance where signals come too slowly for the map's band: what is faster folds back into it."""


@dataclass(frozen=True)
class MappedWheel:
    """One wheel over the drive's rows: force, std (n,) N. outside: share of the rows outside the training's range, by
    regressor. load_n: how much more the suspension carries than in training. missing: regressors without their signal."""

    force: FloatArray
    std: FloatArray
    outside: Mapping[str, float]
    load_n: float
    missing: tuple[str, ...]

    @property
    def low(self) -> FloatArray:
        """Lower end of the 95 % interval (n,)."""
        return np.asarray(self.force - QUANTILE * self.std)

    @property
    def high(self) -> FloatArray:
        """Upper end of the 95 % interval (n,)."""
        return np.asarray(self.force + QUANTILE * self.std)


@dataclass(frozen=True)
class Mapped:
    """All wheels, and from which part of the map."""

    kind: str
    form: str
    wheels: Mapping[str, MappedWheel]


KINDS: Mapping[str, tuple[str, ...]] = {"struts": STRUTS, "springs": DEFLECTIONS}
"""Parts of a map, the better one first, and the signals that each stands on."""


def usable_parts(record: SuspensionMap, data: MapData) -> tuple[MapPart, ...]:
    """The parts of the map that the drive's signals serve: struts before springs."""
    return tuple(record.parts[k] for k, names in KINDS.items() if k in record.parts and data.has(names))


def _columns(
    found: Mapping[str, FloatArray], own: WheelMap, size: int
) -> tuple[FloatArray, FloatArray, dict[str, float], tuple[str, ...]]:
    """Matrix (n, p), variance that missing and unseen regressors add (n,), shares outside, missing names."""
    matrix, extra = np.empty((size, len(own.coefficients))), np.zeros(size)
    outside: dict[str, float] = {}
    missing: list[str] = []
    for place, (name, value) in enumerate(own.coefficients.items()):
        seen = own.seen[name]
        column = found.get(name)
        if column is None:
            missing.append(name)
            matrix[:, place] = seen.mean
            extra += (value * seen.std) ** 2
            continue
        matrix[:, place] = column
        beyond = np.maximum(np.maximum(seen.low - column, column - seen.high), 0.0)
        # a little beyond is no news
        beyond = np.maximum(beyond - 0.02 * (seen.high - seen.low), 0.0)
        extra += (REGRESSORS[name].doubt * value * beyond) ** 2
        share = float(np.mean(beyond > 0))
        if share > 0 and REGRESSORS[name].doubt > 0:
            outside[name] = share
    return matrix, extra, outside, tuple(missing)


def apply_map(record: SuspensionMap, data: MapData, kind: str | None = None) -> Mapped | None:
    """Tyre normal forces over a drive's rows; None where it has neither struts nor deflections that the map knows.

    kind: that part of the map; None = the best that the drive's signals serve.

    The variance of a force is: the residual's at that state, the coefficients', the zeros' drift, the sensors' lag, an allowance for another
    load than in training, and what regressors outside the training's range or without a signal leave open.
    """
    parts = [part for part in usable_parts(record, data) if kind in (None, part.kind)]
    if not parts or data.size == 0:
        return None
    part = parts[0]
    carried = carried_by_struts(data) if part.kind == "struts" else carried_by_springs(data, part.springs)
    shared = shared_columns(data)
    wheels = {}
    for wheel in WHEELS:
        own = part.wheels[wheel]
        found = wheel_columns(data, wheel, carried, record.shape, shared)
        matrix, extra, outside, missing = _columns(found, own, data.size)
        force = matrix @ np.array(list(own.coefficients.values()))
        load = float(np.mean(carried[wheel])) - own.carried_n
        coarse = COARSE if data.band_hz < 0.99 * record.band_hz else 1.0
        variance = coarse * own.factor**2 * (state_of(data, wheel) @ np.array(own.spread))
        variance += np.sum((matrix @ own.covariance) * matrix, axis=1)
        variance += (LAG_S * rate_of(force, data.starts, data.rate_hz)) ** 2
        variance += own.zero_n**2 + (LOAD_SHARE[part.kind] * load) ** 2 + extra
        wheels[wheel] = MappedWheel(force, np.sqrt(np.maximum(variance, 0.0)), outside, load, missing)
    return Mapped(part.kind, part.form, wheels)


@dataclass(frozen=True)
class WheelError:
    """Mapped less measured: RMS, peak (signed, N) and its time, mean; share of the rows inside the 95 % interval."""

    rms_n: float
    peak_n: float
    peak_s: float
    mean_n: float
    coverage: float


def errors_against(mapped: Mapped, data: MapData) -> dict[str, WheelError]:
    """Against the log's own measuring wheels, where it has any; wheel -> error."""
    found = {}
    for wheel, name in zip(WHEELS, MEASURED, strict=True):
        measured = data.columns.get(name)
        if measured is None:
            continue
        own = mapped.wheels[wheel]
        off = own.force - measured
        worst = int(np.argmax(np.abs(off)))
        found[wheel] = WheelError(
            float(np.sqrt(np.mean(off**2))),
            float(off[worst]),
            float(data.time_s[worst]),
            float(np.mean(off)),
            float(np.mean(np.abs(off) <= QUANTILE * own.std)),
        )
    return found
