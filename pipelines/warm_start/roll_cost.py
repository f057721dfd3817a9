"""The cost of Algorithm 1 for the roll model: the L2 error of the motion that K, D, h give under the measured acceleration."""

from __future__ import annotations

import numpy as np

from parsers.channels import IntArray
from parsers.jit import kernel
from pipelines.filters.lanes import LANES
from pipelines.filters.marginalized_particle.discretise import discretise
from pipelines.filters.marginalized_particle.layout import (
    A00,
    A01,
    A10,
    A11,
    AFTER0,
    AFTER1,
    LEVEL0,
    LEVEL1,
    LOG,
)
from pipelines.results import FloatArray
from pipelines.warm_start.weighting import independent_residuals


@kernel
def _respond(
    theta: FloatArray,
    accel: FloatArray,
    step: float,
    gravity: float,
    starts: IntArray,
    stops: IntArray,
    out: FloatArray,
) -> bool:
    """Roll and roll rate (n, 2) from rest under the first input; False where the roll is unstable."""
    row = np.zeros(LOG)
    for j in range(6):
        row[j * LANES : (j + 1) * LANES] = theta[j]
    lever = theta[3] * theta[2]
    stiffness = theta[0] - lever * gravity
    if stiffness <= 0.0 or theta[4] + lever * (theta[2] - theta[5]) <= 0.0:
        return False
    discretise(row, step, gravity)
    for segment in range(len(starts)):
        x0, x1 = lever / stiffness * accel[starts[segment]], 0.0
        for k in range(starts[segment], stops[segment]):
            out[k, 0], out[k, 1] = x0, x1
            if k + 1 == stops[segment]:
                break
            now, change = accel[k], accel[k + 1] - accel[k]
            x0, x1 = (
                row[A00] * x0 + row[A01] * x1 + row[LEVEL0] * now + row[AFTER0] * change,
                row[A10] * x0 + row[A11] * x1 + row[LEVEL1] * now + row[AFTER1] * change,
            )
    return True


class RollError:
    """J(θ) for θ = (K, D, h): root of the sum of squared differences, each output divided by its scale.

    y: (n, 2) roll and roll rate, NaN where not measured. accel: (n,). scale: of roll and of roll rate; (1, 1) is the plain
    L2 error, the noise's standard deviations make it a likelihood's. offsets: a constant difference of each output counts
    nothing (sensor offsets). segments: first rows and rows past the last.
    """

    def __init__(
        self,
        y: FloatArray,
        accel: FloatArray,
        step_s: float,
        *,
        mass_kg: float,
        roll_inertia_kgm2: float,
        input_height_m: float = 0.0,
        gravity_mps2: float = 9.80665,
        scale: tuple[float, float] = (1.0, 1.0),
        offsets: bool = False,
        segments: tuple[IntArray, IntArray] | None = None,
    ):
        if y.shape != (len(accel), 2) or not np.isfinite(accel).all():
            raise ValueError("measurements are (n, 2) and the acceleration is (n,) finite numbers")
        self._y, self._accel = y, np.ascontiguousarray(accel, dtype=np.float64)
        self._step, self._gravity = step_s, gravity_mps2
        self._given = (mass_kg, roll_inertia_kgm2, input_height_m)
        self._scale, self._offsets = np.array(scale), offsets
        whole = (np.array([0]), np.array([len(accel)]))
        starts, stops = whole if segments is None else segments
        self._segments = (np.asarray(starts, dtype=np.int64), np.asarray(stops, dtype=np.int64))

    def residuals(self, theta: FloatArray) -> FloatArray | None:
        """(n, 2) measured minus simulated over scale, NaN where not measured; None where the roll is unstable."""
        out = np.full(self._y.shape, np.nan)
        row = np.array([*theta, *self._given])
        if not _respond(row, self._accel, self._step, self._gravity, *self._segments, out):
            return None
        left = (self._y - out) / self._scale
        if self._offsets:
            seen = np.isfinite(left)
            count = np.maximum(seen.sum(axis=0), 1)
            left = left - np.where(seen, left, 0.0).sum(axis=0) / count
        return np.asarray(left)

    def __call__(self, theta: FloatArray) -> float:
        """J(θ); infinity where the roll is unstable."""
        left = self.residuals(theta)
        return np.inf if left is None else float(np.sqrt(np.nansum(left**2)))

    def independent(self, theta: FloatArray) -> float:
        """How many independent residuals theta leaves: those of the output that has fewer (the two are of one motion)."""
        left = self.residuals(theta)
        if left is None:
            return 1.0
        seen = [column[np.isfinite(column)] for column in left.T]
        return max(1.0, min(independent_residuals(column) for column in seen if len(column) > 1))


def roll_features(theta: FloatArray) -> FloatArray:
    """(n, 3) K/h, D/h, h of K, D, h: the roll fixes the first two well and the third badly, so that the valley runs along it."""
    return np.column_stack((theta[:, 0] / theta[:, 2], theta[:, 1] / theta[:, 2], theta[:, 2]))
