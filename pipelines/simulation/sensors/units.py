"""Sensors: from the true motion to what a log holds. Every error is a parameter, and what was drawn is kept.

A SensorSet is made of units (boxes, bus messages), a unit of sensors that share its stamps. `apply` measures a run.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from parsers.channels import IntArray
from pipelines.results import FloatArray
from pipelines.simulation.records import PlantRun
from pipelines.simulation.sensors.errors import Drawn, SensorModel, draw, lose, measure
from pipelines.simulation.sensors.truth import Fit, Mount, mounted, true_signals

_ANGLES = 3


@dataclass(frozen=True)
class SensorUnit:
    """One box or bus message. name: the group in the store. rate_hz: of its stamps.

    mount: place and angles of an inertial unit; without one it sits at the sprung CG, straight. dropouts_per_s,
    dropout_s: how often the whole message is lost, and for how long in the mean.
    """

    name: str
    rate_hz: float
    sensors: tuple[SensorModel, ...]
    mount: Mount | None = None
    dropouts_per_s: float = 0.0
    dropout_s: float = 0.5

    def scaled(self, factor: float) -> SensorUnit:
        """The same unit with all sizes of error times a factor; 0 = none. Delays, steps, filters and losses stay."""
        mount = None if self.mount is None else self.mount.scaled(factor)
        return replace(self, sensors=tuple(s.scaled(factor) for s in self.sensors), mount=mount)


@dataclass(frozen=True)
class SensorSet:
    """All sensors of a vehicle. title: one line for lists. fit: what sensors know of the vehicle they are built into."""

    name: str
    title: str
    units: tuple[SensorUnit, ...]
    fit: Fit = field(default_factory=Fit)

    @property
    def signals(self) -> tuple[str, ...]:
        """Every canonical signal that the set measures."""
        return tuple(sensor.signal for unit in self.units for sensor in unit.sensors)

    def scaled(self, factor: float) -> SensorSet:
        """All sizes of error times a factor (see SensorUnit.scaled)."""
        return replace(self, units=tuple(unit.scaled(factor) for unit in self.units))

    def at_rate(self, rate_hz: float) -> SensorSet:
        """The same sensors, all at one rate."""
        return replace(self, units=tuple(replace(unit, rate_hz=rate_hz) for unit in self.units))

    def spoiled(self, dropouts_per_s: float, outlier_share: float) -> SensorSet:
        """The same sensors with lost messages and wild samples; outliers have ten times the size that a sensor's own have."""
        units = []
        for unit in self.units:
            sensors = tuple(replace(s, outlier_share=outlier_share) for s in unit.sensors)
            units.append(
                replace(unit, sensors=sensors, dropouts_per_s=max(unit.dropouts_per_s, dropouts_per_s))
            )
        return replace(self, units=tuple(units))


@dataclass(frozen=True)
class SensorGroup:
    """What one unit gave. time_ns (n,) from the start of the run; columns: signal -> (n,), NaN where nothing came."""

    name: str
    rate_hz: float
    time_ns: IntArray
    columns: Mapping[str, FloatArray]


@dataclass(frozen=True)
class SensorLog:
    """What all sensors gave. drawn: by signal, the constant errors of this run. mounts: by unit, place and angles."""

    groups: tuple[SensorGroup, ...]
    drawn: Mapping[str, Drawn]
    mounts: Mapping[str, Mount]

    @property
    def signals(self) -> dict[str, FloatArray]:
        """Every column by its signal, each on its group's stamps."""
        return {name: values for group in self.groups for name, values in group.columns.items()}


def _stream(root: int, *names: str) -> np.random.Generator:
    """A generator of its own for each sensor, so that one sensor more does not change the others' noise."""
    return np.random.default_rng([root, *(zlib.crc32(name.encode()) for name in names)])


def _stamps(duration_s: float, rate_hz: float) -> IntArray:
    count = int(np.floor(duration_s * rate_hz + 1e-6)) + 1
    return np.asarray(np.round(np.arange(count) * (1e9 / rate_hz)), dtype=np.int64)


def _draw_mount(mount: Mount, rng: np.random.Generator) -> Mount:
    angles = rng.standard_normal(_ANGLES) * mount.misalignment_std_rad
    roll, pitch, yaw = (float(given + a) for given, a in zip(mount.misalignment_rad, angles, strict=True))
    return replace(mount, misalignment_rad=(roll, pitch, yaw), misalignment_std_rad=0.0)


def apply(run: PlantRun, sensors: SensorSet, rng: np.random.Generator) -> SensorLog:
    """Measure a run. One number is taken from rng; each sensor's noise follows from that and from its name.

    Raises ValueError for a signal that nothing in the plant gives, and for a rate that is not above 0.
    """
    root = int(rng.integers(2**62))
    groups: list[SensorGroup] = []
    drawn: dict[str, Drawn] = {}
    mounts: dict[str, Mount] = {}
    start, duration = float(run.time_s[0]), float(run.time_s[-1] - run.time_s[0])
    for unit in sensors.units:
        if not unit.rate_hz > 0:
            raise ValueError(f"the rate of unit {unit.name!r} is {unit.rate_hz:g} Hz: expected more than 0")
        mount = None
        if unit.mount is not None:
            mount = _draw_mount(unit.mount, _stream(root, "mount", unit.name))
            mounts[unit.name] = mount
        truth = true_signals(run, sensors.fit) | mounted(run, mount)
        time_ns = _stamps(duration, unit.rate_hz)
        seconds = np.asarray(time_ns / 1e9)
        lost = lose(seconds, unit.dropouts_per_s, unit.dropout_s, _stream(root, "losses", unit.name))
        columns: dict[str, FloatArray] = {}
        for sensor in unit.sensors:
            if sensor.signal not in truth:
                raise ValueError(f"the plant gives no signal {sensor.signal!r}")
            errors = drawn[sensor.signal] = draw(sensor, _stream(root, "constants", sensor.signal))
            noise = _stream(root, "noise", sensor.signal)
            clean = truth[sensor.signal]()
            values = measure(clean, run.rate_hz, start, seconds, sensor, errors, noise)
            columns[sensor.signal] = np.where(lost, np.nan, values)
        groups.append(SensorGroup(unit.name, unit.rate_hz, time_ns, columns))
    return SensorLog(tuple(groups), drawn, mounts)
