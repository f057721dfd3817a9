"""Does the clock go with the vehicle? What accelerates by 1 m/s² is 1 m/s quicker a second later, if that second is one.

A column that counts rows, or ticks of an unknown length, is read as seconds where nothing says otherwise. Over windows of so many
rows the change of speed is the integral of acceleration, whatever is in between:

    Δv = s ∫ a dt + b Δt

with b for gravity's part and the offset. s is 1 for a right clock, and what the clock's second has of a second otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.drive import Signal
from parsers.timebase import NS

WINDOWS, FEWEST = 200, 20
LEAST_MPS = 3.0
"""Standard deviation of a speed below which it says nothing."""

FAR, TOGETHER = 3.0, 0.8
"""Factor from which on it is the clock, and least correlation of both sides. Grades, scales and pitching bodies are far from either."""


def clock_over_speed(signals: Mapping[str, Signal]) -> float | None:
    """s of speed and longitudinal acceleration; None where these do not tell it."""
    speed, accel = signals.get("speed"), signals.get("accel_x")
    if speed is None or accel is None or len(speed.values) < 2 * FEWEST or len(accel.values) < 2 * FEWEST:
        return None
    at = accel.time_ns / NS
    steps = 0.5 * (accel.values[1:] + accel.values[:-1]) * np.diff(at)
    gained = np.concatenate([[0.0], np.cumsum(np.where(np.isfinite(steps), steps, 0.0))])
    last = len(speed.values) - 1
    rows = np.linspace(0, last, min(WINDOWS, last) + 1).astype(np.int64)
    v, t = speed.values[rows], speed.time_ns[rows] / NS
    inside = np.isfinite(v) & (t >= at[0]) & (t <= at[-1])
    v, t = v[inside], t[inside]
    if len(v) < FEWEST or float(np.std(v)) < LEAST_MPS:
        return None
    change, push, width = np.diff(v), np.diff(np.interp(t, at, gained)), np.diff(t)
    # without what goes by the time alone
    part = width / max(float(np.linalg.norm(width)), 1e-300)
    change, push = change - part * (part @ change), push - part * (part @ push)
    sizes = float(np.linalg.norm(change)), float(np.linalg.norm(push))
    if min(sizes) <= 0 or float(change @ push) < TOGETHER * sizes[0] * sizes[1]:
        return None
    return float(change @ push) / sizes[1] ** 2


def clock_note(signals: Mapping[str, Signal], doubt: str) -> list[str]:
    """What is said of a clock that does not go with the vehicle; nothing of a right one. doubt: the question to be asked of it."""
    found = clock_over_speed(signals)
    if found is None or 1 / FAR < found < FAR:
        return []
    return [
        f"speed changes {found:.2g} times as fast as longitudinal acceleration says, as if a second of the log were {found:.2g} s: "
        f"{doubt} A mapping file's [time] names the column and its unit"
    ]
