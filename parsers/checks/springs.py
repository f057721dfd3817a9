"""The springs' own sign: braking presses the front down and lifts the rear, whatever the lateral signals say."""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import Grid, Together
from parsers.checks.motion import seconds
from parsers.checks.pedals import backwards, by_pedals, change_of_speed
from parsers.drive import Decision
from parsers.quantiles import median
from parsers.signals import WHEELS

DEFLECTIONS = tuple(f"suspension_deflection_{wheel}" for wheel in WHEELS)
_LEAST = 0.8
"""Simulated drives with any braking come to 0.85 and more; off-road ground without it to 0.6, of either sign."""
_MIN_CHANGE = 0.7


def springs_in_braking(grid: Grid) -> Together | None:
    """Front less rear compression against the loss of speed: positive where compression is positive.

    None without all four deflections and a speed, and where the vehicle neither brakes nor speeds up (0.7 m/s² for a
    second) as only pedals make it, or the two do not go together clearly; nor where a negative speed may be the wrong one of both.
    """
    pitching, change = springs_tilt(grid, "pitch"), change_of_speed(grid)
    if change is None or pitching is None or seconds(np.abs(change) > _MIN_CHANGE) < 1.0:
        return None
    found = by_pedals(grid, pitching - median(pitching), -change, _LEAST)
    return None if found is None or (found.sign < 0 and backwards(grid)) else found


def springs_tilt(grid: Grid, angle: str) -> FloatArray | None:
    """What the springs say of roll or pitch, in m of compression: positive as the angle is. None without all four."""
    columns = [grid.get(name) for name in DEFLECTIONS]
    if any(column is None for column in columns):
        return None
    fl, fr, rl, rr = (column for column in columns if column is not None)
    return fr + rr - fl - rl if angle == "roll" else fl + fr - rl - rr


def springs_decision(found: Together) -> Decision:
    """What is said of deflections that are positive where the spring extends."""
    return Decision(
        DEFLECTIONS[0],
        "sign",
        "suspension deflection falls at the front and rises at the rear in braking: extension was taken for compression",
        "all four deflections inverted (compression is positive)",
        f"correlation {found.correlation:.2f} with the loss of speed over {found.seconds:.0f} s",
        applied=True,
    )


def exchanged_decision(inverted: bool) -> Decision:
    """What is said of deflections whose sign braking tells one way and bends the other. inverted: braking took them for extension."""
    pair = "front and rear" if inverted else "left and right"
    other = "left and right" if inverted else "front and rear"
    return Decision(
        DEFLECTIONS[0],
        "sign",
        f"suspension deflections of {pair} wheels look exchanged: {other} move as they should, {pair} the other way round",
        "all four left out; say in a mapping file which channel is which wheel",
        "braking and the lateral signals contradict each other on their sign",
        applied=True,
    )
