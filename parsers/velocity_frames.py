"""Velocities along x and y: whether x is ahead of the vehicle, or both count along fixed axes (a map's, the world's) or another sensor's.

Simulators and pose estimators fill twists of odometry along the world's axes as well as along the body's, and tables call both `Vx`. Of
a body's the one to the side stays small; of the world's the direction turns as the vehicle does. Their length is the speed on either.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from parsers.axle_sums import Proposals, Rows
from parsers.channels import ChannelInfo, FloatArray, IntArray
from parsers.importer import ImportLog
from parsers.mapping import Binding
from parsers.signals import SIGNALS

_TO = "gps_speed_2d"
_LEAST_ROWS = 20
_MOVES_MPS = 0.3
_TURNS_RADPS = 0.02
"""Root of the mean square of a yaw rate from which on it tells which axes turn."""

_APART_S = 0.2
_MOST_RAD = 1.0
"""What a velocity's direction turns by in that time at the most; a vehicle that changes to reverse jumps by half a turn."""

_SAME, _OTHER = 0.8, 0.5
"""Correlation of the direction's turning with the yaw rate: of fixed axes it is above the one, of a body's below the other."""

_AS_MUCH = (0.6, 1.6)
_ASIDE, _FAR_ASIDE = 0.02, 0.25
"""Share of the motion's energy to the side from which on x is not ahead: slip angles of 8° in the mean, of 30° where the yaw rate says that the axes are a body's."""


@dataclass
class _Seen:
    """Sums over the rows that were seen. whole, aside: of squares of the velocity, and of its part along y."""

    rows: int = 0
    whole: float = 0.0
    aside: float = 0.0
    turns: int = 0
    both: float = 0.0
    direction: float = 0.0
    yaw: float = 0.0

    def add(self, time_ns: IntArray, x: FloatArray, y: FloatArray, rate: FloatArray | None) -> None:
        """Take rows in order of time."""
        valid = np.isfinite(x) & np.isfinite(y)
        square = np.where(valid, x * x + y * y, 0.0)
        self.rows += int(np.count_nonzero(valid))
        self.whole += float(square.sum())
        self.aside += float((y[valid] ** 2).sum())
        if rate is not None and len(time_ns) > _LEAST_ROWS and square.any():
            self._turning(time_ns, x, y, square, rate)

    def _turning(
        self, time_ns: IntArray, x: FloatArray, y: FloatArray, square: FloatArray, rate: FloatArray
    ) -> None:
        step = float(np.median(np.diff(time_ns))) / 1e9
        if step <= 0:
            return
        k = min(max(1, math.ceil(_APART_S / step)), len(time_ns) - 1)
        least = max(0.25 * float(square[square > 0].mean()), 0.01)
        span = (time_ns[k:] - time_ns[:-k]) / 1e9
        mean = (rate[k:] + rate[:-k]) / 2
        turn = np.arctan2(x[:-k] * y[k:] - y[:-k] * x[k:], x[:-k] * x[k:] + y[:-k] * y[k:])
        good = (square[:-k] > least) & (square[k:] > least) & (span < 2 * k * step)
        good &= np.isfinite(mean) & (np.abs(turn) < _MOST_RAD)
        direction, yaw = turn[good] / span[good], mean[good]
        self.turns += len(yaw)
        self.both += float(direction @ yaw)
        self.direction += float(direction @ direction)
        self.yaw += float(yaw @ yaw)

    @property
    def share(self) -> float:
        """Share of the motion's energy that is along y."""
        return self.aside / self.whole if self.whole > 0 else 0.0

    def reason(self, y: str) -> str | None:
        """Why x is not ahead of the vehicle, or None where it may be. y: the other channel's name."""
        if self.rows < _LEAST_ROWS or self.whole / self.rows < _MOVES_MPS**2:
            return None
        most = _ASIDE
        if self.turns >= _LEAST_ROWS and self.yaw / self.turns > _TURNS_RADPS**2 and self.direction > 0:
            alike = abs(self.both) / math.sqrt(self.yaw * self.direction)
            if alike > _SAME and _AS_MUCH[0] < math.sqrt(self.direction / self.yaw) < _AS_MUCH[1]:
                return (
                    f"with {y} it counts along fixed axes, since the direction of both turns as the vehicle does "
                    f"(correlation with yaw_rate {alike:.2f})"
                )
            most = _FAR_ASIDE if alike < _OTHER else _ASIDE
        if self.share < most:
            return None
        angle = math.degrees(math.asin(math.sqrt(self.share)))
        return f"{y} is too large beside it for a vehicle that moves ahead (in the mean {angle:.0f}° aside)"


def with_frames(
    proposals: Proposals, infos: Mapping[str, ChannelInfo], rows: Rows, log: ImportLog
) -> Proposals:
    """The proposals without speeds along axes that are not the vehicle's; their length in the plane is a candidate for `gps_speed_2d`."""
    speeds = list(proposals.get("speed", ()))
    moved: list[Binding] = []
    while speeds and speeds[0].across is not None:
        binding = speeds[0]
        reason = _reason(binding, infos, rows)
        if reason is None:
            break
        moved.append(_length(speeds.pop(0)))
        log.note(
            f"{binding.channels[0]} is not taken for speed: {reason}; the length of both is taken for {_TO} "
            "where nothing else gives it"
        )
    kept = tuple(replace(each, across=None, turning=None) for each in speeds)
    made = {**proposals, "speed": kept, _TO: (*proposals.get(_TO, ()), *moved)}
    return {signal: made[signal] for signal in SIGNALS if made.get(signal)}


def _reason(binding: Binding, infos: Mapping[str, ChannelInfo], rows: Rows) -> str | None:
    x, y = binding.channels[0], binding.across or ""
    names = (x, y) if binding.turning is None else (x, y, binding.turning[0])
    seen, scale = _Seen(), binding.unit.scale * binding.scale
    # bytes that damage put there may be no numbers at all, or such that their squares are none
    with np.errstate(invalid="ignore", over="ignore"):
        for time_ns, columns in rows.pieces(infos[x].group, names):
            rate = None if binding.turning is None else columns[binding.turning[0]] * binding.turning[1]
            seen.add(time_ns, columns[x] * scale, columns[y] * scale, rate)
    return seen.reason(y) if math.isfinite(seen.whole) else None


def _length(binding: Binding) -> Binding:
    """The length in the plane of a speed and what is beside it."""
    return replace(
        binding,
        signal=_TO,
        kind="length",
        channels=(binding.channels[0], binding.across or ""),
        scale=abs(binding.scale),
        invert=False,
        across=None,
        turning=None,
        rule=f"{binding.rule} with {binding.across}, the vector's length",
    )
