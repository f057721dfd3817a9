"""A mass on a spring and a damper, as a filter's model: m x'' = f + f0 - k x - c x' (dissertation (55), (63)).

(63) prints the damper's force as -(c/m) x; it is -(c/m) v. f0 is a constant force that the input does not tell (a preload,
a sensor's offset). The mass-spring system is this one with c and f0 known to be 0.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import IntArray
from parsers.jit import kernel, lean_kernel
from pipelines.filters.gpc_filter import StateSpaceModel
from pipelines.filters.gpc_state_space import FilterArrays, Record, Work, note, points, take
from pipelines.results import FloatArray

POSITION, VELOCITY, ACCELERATION = 0, 1, 2
"""What can be measured."""

SMALLEST_MASS = 1e-6


@lean_kernel
def _advance(values: FloatArray, before: float, after: float, step: float) -> None:
    """One Runge-Kutta step of order 4 at all points; the force runs straight from `before` to `after`.

    values (6, Q): x, v, m, k, c, f0; x and v are moved on.
    """
    half = 0.5 * step
    middle = 0.5 * (before + after)
    for q in range(values.shape[1]):
        x, v, mass = values[0, q], values[1, q], values[2, q]
        k, c, f0 = values[3, q], values[4, q], values[5, q]
        # a filter without logarithms may visit masses below 0 (its own trouble), but 0 would end the run
        inverse = 1.0 / (mass if abs(mass) > SMALLEST_MASS else SMALLEST_MASS)
        a1 = (before + f0 - k * x - c * v) * inverse
        v2 = v + half * a1
        a2 = (middle + f0 - k * (x + half * v) - c * v2) * inverse
        v3 = v + half * a2
        a3 = (middle + f0 - k * (x + half * v2) - c * v3) * inverse
        v4 = v + step * a3
        a4 = (after + f0 - k * (x + step * v3) - c * v4) * inverse
        values[0, q] = x + step / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        values[1, q] = v + step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


@lean_kernel
def _outputs(values: FloatArray, force: float, kinds: IntArray, predicted: FloatArray) -> None:
    """predicted (m, Q): what the sensors of `kinds` (m,) would read."""
    for j in range(kinds.shape[0]):
        for q in range(values.shape[1]):
            if kinds[j] < 2:
                predicted[j, q] = values[kinds[j], q]
            else:
                mass = values[2, q]
                total = force + values[5, q] - values[3, q] * values[0, q] - values[4, q] * values[1, q]
                predicted[j, q] = total / (mass if abs(mass) > SMALLEST_MASS else SMALLEST_MASS)


@kernel
def _run(
    x: FloatArray,
    force: FloatArray,
    measured: FloatArray,
    kinds: IntArray,
    arrays: FilterArrays,
    work: Work,
    record: Record,
) -> int:
    """The filter; returns the samples done. force (rows, 1); measured (rows, m); kinds (m,)."""
    values = np.empty((x.shape[0], arrays.basis.shape[1]))
    predicted = np.empty((kinds.shape[0], arrays.basis.shape[1]))
    for k in range(measured.shape[0]):
        points(x, arrays, values, k == 0)
        if k > 0:
            _advance(values, force[k - 1, 0], force[k, 0], arrays.step_s)
        _outputs(values, force[k, 0], kinds, predicted)
        if not take(x, values, predicted, measured[k], arrays, work):
            return k
        note(x, work, k, record)
    return len(measured)


MASS_SPRING = StateSpaceModel(
    name="mass, spring and damper",
    states=("position", "velocity"),
    parameters=("mass", "stiffness", "damping", "offset"),
    inputs=("force",),
    outputs=("position", "velocity", "acceleration"),
    run=_run,
)
"""Units: m, m/s, kg, N/m, N s/m, N."""
