"""A speed that both accelerations contradict alike: what brakes and speeds up, and what is felt in bends, tell one and the same scale.

Banked bends take up to a third of the lateral acceleration, so bends alone say nothing below that (`parsers.checks.evidence`); braking is
banked by nothing. Grades are in what is felt along the vehicle, too: only what pedals do is looked at (`parsers.checks.pedals`).
"""

from __future__ import annotations

import math
from collections.abc import Collection

from parsers.checks.grid import Grid, compare
from parsers.checks.motion import smooth
from parsers.checks.pedals import by_pedals
from parsers.drive import Decision

LEAST = 1.15
"""Times that a speed must be off for it to be said: differing scales of accelerometers and wheels stay below."""

FELT = 1.05
"""What accelerometers feel over the change of speed and the turning: a body that dives and leans has gravity's part in them."""

ALIKE = 1.12
"""How far apart the two ratios may be."""

GOES_ALONG, GOES_ACROSS = 0.9, 0.9
LEAST_MPS = 3.0
LEAST_S = 10.0
"""Of braking and speeding up: in less, steep short hills may be a quarter of what is felt."""
HINTS = ((3.6 * 0.44704, "km/h called mph would be"), (1 / 3.6 / 0.44704, "mph called km/h would be"))
NEAR = 1.06


def speed_scale(grid: Grid, doubted: Collection[str]) -> list[Decision]:
    """What is said of a speed that is too large or too small; it is left alone. grid: with all units repaired; doubted: signals of which something is said already."""
    speed, along, across, yaw = (grid.get(name) for name in ("speed", "accel_x", "accel_y", "yaw_rate"))
    if speed is None or along is None or across is None or yaw is None or "speed" in doubted:
        return []
    change = by_pedals(grid, along, grid.rate(smooth(speed)), GOES_ALONG)
    bends = compare(across, yaw * speed, abs(speed) > LEAST_MPS, centred=False)
    if (
        change is None
        or bends is None
        or change.sign < 0
        or change.seconds < LEAST_S
        or abs(bends.correlation) < GOES_ACROSS
    ):
        return []
    if max(change.ratio, bends.ratio) > ALIKE * min(change.ratio, bends.ratio):
        return []
    times = FELT / math.sqrt(change.ratio * bends.ratio)
    if 1 / LEAST < times < LEAST:
        return []
    hint = next((words for factor, words in HINTS if factor / NEAR < times < factor * NEAR), "")
    text = f"speed is {times:.2f} times what both accelerations say"
    if hint:
        text += f", as {hint}"
    evidence = (
        f"accel_x over the change of speed is {change.ratio:.2f}, accel_y over yaw_rate × speed {bends.ratio:.2f} "
        f"(correlations {change.correlation:.2f} and {abs(bends.correlation):.2f})"
    )
    return [
        Decision(
            "speed", "scale", text, "left as it is: say the unit in a mapping file", evidence, applied=False
        )
    ]
