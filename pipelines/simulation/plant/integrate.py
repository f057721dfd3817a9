"""The plant's equations over time: midpoint steps, recorded at an even rate, and the plant's energy."""

from __future__ import annotations

import math

from parsers.jit import kernel
from pipelines.results import FloatArray
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.motion import derivative

FALLEN_RAD = 1.2


@kernel
def integrate(
    y: FloatArray,
    times: tuple[float, float, int],
    body: FloatArray,
    wheels: FloatArray,
    demand: FloatArray,
    road: FloatArray,
    grids: tuple[float, float],
    scratch: FloatArray,
    work: FloatArray,
    states: FloatArray,
    extras: FloatArray,
) -> int:
    """Run from state y (in place) over len(states) rows; returns how many rows are whole.

    times: start [s], step [s], steps a row. scratch: (5, 128) and work: (10, 8) are overwritten. states: (n, STATES); extras: (n, AUX_SIZE), of each row's
    instant. Ends early where the body has fallen (beyond 1.2 rad) or a state is not finite.
    """
    start, step, stride = times
    slope, trial = scratch[0, : at.STATES], scratch[1, : at.STATES]
    aux, unused = scratch[3, : at.AUX_SIZE], scratch[4, : at.AUX_SIZE]
    for row in range(states.shape[0]):
        for part in range(stride):
            now = start + (row * stride + part) * step
            derivative(now, y, body, wheels, demand, road, grids, slope, aux, work)
            if part == 0:
                states[row] = y
                extras[row] = aux
                if not (
                    abs(y[at.ROLL]) < FALLEN_RAD and abs(y[at.PITCH]) < FALLEN_RAD and math.isfinite(y[at.VX])
                ):
                    return row
            for k in range(at.STATES):
                trial[k] = y[k] + 0.5 * step * slope[k]
            derivative(now + 0.5 * step, trial, body, wheels, demand, road, grids, slope, unused, work)
            for k in range(at.STATES):
                y[k] += step * slope[k]
    return len(states)
