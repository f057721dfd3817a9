"""A binding: one way to make a canonical signal from channels of a log, and the arithmetic that does it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from parsers.channels import FloatArray
from parsers.units import Unit

BindingKind = Literal["scale", "length", "roll_of_quaternion", "pitch_of_quaternion"]

_MIN_QUATERNION_NORM = 0.5
"""A unit quaternion has norm 1; drivers that do not estimate attitude publish zeros."""


@dataclass(frozen=True)
class Binding:
    """One way to make a signal from channels of one group.

    signal: canonical name ("accel_y"). channels: the main channel, then channels that are added to it (Toyota
    STEER_ANGLE + STEER_FRACTION); for the quaternion kinds x, y, z, w; for "length" the parts of a vector. unit: of the
    channels.
    unit_from: "log", "profile toyota", "map file", "name", "assumed SI", or "magnitude" once a check decided.
    scale, offset: value = sum * scale + offset, in `unit`, before conversion to SI. sign_channel: where it is not
    zero the value is negative (VW). valid_range: in `unit`, after scale and offset; outside it there is no sample.
    where: (channel, low, high), only rows in which that channel lies inside (J1939 axle location, ROS covariance).
    sum_axles: of those rows, the sum over all axles that the channel of `where` tells (see parsers.axle_rows).
    group: of rows that were made for it; None for those of its channels.
    beside: of a latitude the longitude, and the other way round: where both are exactly zero there was no fix.
    across, turning: of a speed along x the velocity along y in the same unit, and a yaw rate with its factor to SI, of the same rows
    (see parsers.velocity_frames).
    rank: lower is better. rule: why ("profile vbox: Y_Accel", "column name 'ay'", "map.toml").
    """

    signal: str
    channels: tuple[str, ...]
    unit: Unit
    unit_from: str
    rule: str
    scale: float = 1.0
    offset: float = 0.0
    invert: bool = False
    sign_channel: str | None = None
    valid_range: tuple[float, float] | None = None
    where: tuple[str, float, float] | None = None
    sum_axles: bool = False
    group: str | None = None
    rank: int = 0
    kind: BindingKind = "scale"
    beside: str | None = None
    across: str | None = None
    turning: tuple[str, float] | None = None

    @property
    def unit_stated(self) -> bool:
        """Whether anything but an assumption says the unit."""
        return self.unit_from != "assumed SI"

    @property
    def needed(self) -> tuple[str, ...]:
        """All channels that must be read."""
        extra = [self.sign_channel] if self.sign_channel else []
        if self.where:
            extra.append(self.where[0])
        if self.beside:
            extra.append(self.beside)
        if self.across:
            extra.append(self.across)
        if self.turning:
            extra.append(self.turning[0])
        return (*self.channels, *extra)


def needed_channels(bindings: Iterable[Binding]) -> frozenset[str]:
    """The channels that must be read for some bindings."""
    return frozenset(name for binding in bindings for name in binding.needed)


def bind(binding: Binding, columns: Mapping[str, FloatArray]) -> FloatArray:
    """SI values from the raw columns of one group, shape (n,); NaN where there is no valid value.

    `columns` must hold every channel in `binding.needed`; all have one length.
    """
    parts = [columns[name] for name in binding.channels]
    if binding.kind == "scale":
        values = np.asarray(parts[0], dtype=np.float64)
        for part in parts[1:]:
            values = values + part
    elif binding.kind == "length":
        values = np.sqrt(np.sum(np.square(parts), axis=0))
    else:
        values = _angle_of_quaternion(binding.kind, parts)
    nowhere = (values == 0) & (columns[binding.beside] == 0) if binding.beside else None
    values = values * binding.scale + binding.offset
    valid = np.isfinite(values)
    if nowhere is not None:
        valid &= ~nowhere
    if binding.valid_range is not None:
        low, high = binding.valid_range
        valid &= (values >= low) & (values <= high)
    if binding.where is not None:
        name, low, high = binding.where
        valid &= (columns[name] >= low) & (columns[name] <= high)
    if binding.sign_channel is not None:
        sign = columns[binding.sign_channel]
        # 0 or 1: of a sign of ±1 a piece of a log does not tell what its ones mean
        valid &= sign >= 0
        values = np.where(sign > 0, -np.abs(values), np.abs(values))
    if binding.invert:
        values = -values
    values = values * binding.unit.scale + binding.unit.offset
    if binding.unit.rise:
        values = np.arctan(values)
    return np.where(valid, values, np.nan)


def _angle_of_quaternion(kind: BindingKind, parts: list[FloatArray]) -> FloatArray:
    """Roll or pitch of the body in the fixed frame, yaw-pitch-roll order (z-y'-x''), radians.

    Follows from the rotation matrix of (x, y, z, w): roll = atan2(R32, R33), pitch = -asin(R31).
    """
    x, y, z, w = parts
    norm2 = x * x + y * y + z * z + w * w
    unit = np.where(norm2 > _MIN_QUATERNION_NORM**2, norm2, np.nan)
    if kind == "roll_of_quaternion":
        return np.arctan2(2 * (w * x + y * z), unit - 2 * (x * x + y * y))
    return np.arcsin(np.clip(2 * (w * y - z * x) / unit, -1.0, 1.0))
