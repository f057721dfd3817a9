"""What the filter works on: excited stretches, the input that moves the body, and the outputs at the rate of their noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from pipelines.estimators.roll_map.data import RollData
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray

ONE_UNIT_S, ANY_UNIT_S = 0.01, 0.05
"""s by which the roll channel and the acceleration may differ in time: of one unit, and of units of their own."""


@dataclass(frozen=True)
class Inputs:
    """y: (n, 2) roll and roll rate, NaN where not scored. accel: (n,). Segments as in `RollData`.

    gravity: g where the input is free of gravity's part, 0 where an accelerometer's reading is taken as it is. delay_std_s:
    how well the channels' delay is known.
    """

    y: FloatArray
    accel: FloatArray
    step_s: float
    starts: IntArray
    stops: IntArray
    gravity: float
    delay_std_s: float

    @property
    def segments(self) -> tuple[IntArray, IntArray]:
        """First rows and rows past the last."""
        return self.starts, self.stops

    def first(self, seconds: float) -> Inputs:
        """The first stretches, so many seconds of them in all."""
        rows = min(max(round(seconds / self.step_s), 2), len(self.accel))
        starts = self.starts[self.starts < rows - 1]
        stops = np.minimum(self.stops[: len(starts)], rows)
        last = int(stops[-1])
        return Inputs(
            self.y[:last], self.accel[:last], self.step_s, starts, stops, self.gravity, self.delay_std_s
        )

    def less(self, offsets: FloatArray) -> Inputs:
        """The same with constant offsets (2,) taken from the outputs."""
        return Inputs(
            self.y - offsets, self.accel, self.step_s, self.starts, self.stops, self.gravity, self.delay_std_s
        )


def inputs_of(data: RollData, prepared: Prepared) -> Inputs:
    """Input and outputs of the excited stretches.

    With an angle against the horizon the input is the path's acceleration f - g φ, as (1) has it, so that banks drop out
    (see `roll_map`); otherwise the accelerometer's reading. The rate of the body goes with an angle against the horizon
    only: against the axles, tyres move the body as well, and the model has one body.
    """
    together = data.rate_with_accel and data.has_rate
    # an angle that lags behind a rate of the accelerometer's unit lags behind the acceleration as well
    lag = 0.0 if data.against_axles or not data.has_roll else data.rate_shift_s
    known = together and (not data.has_roll or (lag != 0.0 and not data.against_axles))
    delay = -lag if known else 0.0
    accel = data.shifter.delayed(delay)
    gravity = GRAVITY if data.holds_course else 0.0
    if data.holds_course:
        accel = accel - GRAVITY * data.whole_roll
    nothing = np.full(data.size, np.nan)
    roll = data.roll if data.has_roll else nothing
    rate = data.rate if data.has_rate and not (data.has_roll and data.against_axles) else nothing
    y = np.column_stack((roll, rate))
    scored = np.flatnonzero(np.isfinite(y).any(axis=1))
    if len(scored) > 1:
        # signals low-passed at f have white noise at 2 f: rows between carry no news
        spacing = float(np.median(np.diff(scored))) * data.step_s
        skipped = np.ones(len(y), dtype=bool)
        skipped[scored[:: max(1, round(1 / (2 * prepared.cutoff_hz * spacing)))]] = False
        y[skipped] = np.nan
    return Inputs(
        y,
        np.ascontiguousarray(accel),
        data.step_s,
        data.starts,
        data.stops,
        gravity,
        ONE_UNIT_S if known else ANY_UNIT_S,
    )


def spread_over_time(normalised: FloatArray, step_s: float, longest_s: float = 2.0) -> float:
    """By how much more than white noise of unit variance a column (n,) varies: its variance times its correlation time.

    NaN rows are left out. Sums autocorrelations while they are positive, up to `longest_s`. At least 1.
    """
    good = np.flatnonzero(np.isfinite(normalised))
    if len(good) < 20:
        return 1.0
    e = normalised[good]
    every = max(float(np.median(np.diff(good))) * step_s, 1e-9)
    variance = float(np.mean(e * e))
    time = 1.0
    for lag in range(1, min(round(longest_s / every), len(e) // 4) + 1):
        rho = float(np.mean(e[lag:] * e[:-lag])) / max(variance, 1e-300)
        if rho <= 0:
            break
        time += 2 * rho
    return max(1.0, variance * time)
