"""Roll by what is quicker than roads bank: in a bend that leans, the body turns with the road, and its springs the other way.

Against the horizon a body rolls with the road and on its springs. A road that leans into its bends is the larger part, and opposite to what
springs and the lateral acceleration say. Within a second no road leans that much: what moves so quickly is the body on its
springs, or wheels that roll it over uneven ground, and both press the springs of the side to which it rolls.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import Grid, Together, compare
from parsers.checks.motion import MIN_SPEED, smooth, vehicle_speed

_CELLS = 11
_FLAT = 0.95
"""Accelerometers on level roads show yaw rate times speed, and 3 to 10 % more by the body's roll; on roads that lean in, less."""
_LEAST = 0.9
_SLOWEST_CELLS, _NOISE_CELLS = 31, 5
_LEAST_SWIFT, _LEAST_PLAIN, _LEAST_QUICK = 0.6, 0.4, 0.3
"""Correlations within three seconds, of all, and within one. Simulated drives on any road have 0.5 and more in the first, never of the wrong
sign where it is 0.25."""
CANNOT_TELL = (
    "its quick changes are too small, and slow ones may be those of roads that lean into their bends"
)


def quick(values: FloatArray) -> FloatArray:
    """What is left of a column (n,) without its mean over 1.1 s."""
    return values - smooth(values, _CELLS)


def swift(rate: FloatArray) -> FloatArray:
    """A rate of change, (n,), without noise and without what lasts longer than three seconds: hills, and most of what banks."""
    return smooth(rate, _NOISE_CELLS) - smooth(rate, _SLOWEST_CELLS)


def swift_tells(turning: FloatArray, driving: FloatArray) -> Together | None:
    """How a body's turning goes with what drives it, both (n,) as rates of change, where hills or banked roads are larger than the lean.

    None where that is not clear, or what is quicker or slower says otherwise.
    """
    found, plain = compare(swift(turning), swift(driving)), compare(turning, driving)
    sudden = compare(quick(turning), quick(driving))
    if found is None or plain is None or sudden is None or abs(found.correlation) < _LEAST_SWIFT:
        return None
    if min(plain.correlation * found.sign / _LEAST_PLAIN, sudden.correlation * found.sign / _LEAST_QUICK) < 1:
        return None
    return found


def level_roads(grid: Grid) -> bool:
    """Whether the lateral acceleration is surely not less than yaw rate times speed, as it is where roads lean into bends."""
    lateral, yaw, speed = grid.get("accel_y"), grid.get("yaw_rate"), vehicle_speed(grid)
    if lateral is None or yaw is None or speed is None:
        return False
    # noise of an accelerometer on a rough road would make it the larger one
    turning = smooth(yaw * speed, _CELLS)
    found = compare(smooth(lateral, _CELLS), turning, np.abs(speed) > MIN_SPEED, centred=False)
    return found is not None and abs(found.correlation) >= _LEAST and found.ratio >= _FLAT


def told_by(
    grid: Grid, plain: Together, changes: tuple[FloatArray, FloatArray], least: float
) -> Together | None:
    """How roll goes with what rolls it, whatever the roads do; None where they may hide it.

    plain: of both as they are. changes: (n,) each, the rates of change of both; least: the correlation from which their quick part tells.
    """
    found = compare(quick(changes[0]), quick(changes[1]))
    if found is not None and abs(found.correlation) >= least:
        return plain if found.sign == plain.sign else found
    return plain if level_roads(grid) else None
