"""How long a batch still takes: drives differ by orders of magnitude in size, so work is counted by drives and by bytes."""

from __future__ import annotations

from collections import deque
from statistics import median

LATEST = 400
"""Drives that the fit looks back on: logs are done in the order of size, so the latest are nearest to what is left."""

LEAST = 3
"""Drives before anything is said."""

ROUNDS = 4
CLIP = 3.0
"""Fits, each with what lies beyond so many times the median relative deviation weighted down (Huber)."""


def fit_cost(sizes: list[int], seconds: list[float]) -> tuple[float, float]:
    """(a, b) of seconds = a + b * bytes, both at least 0, by weighted least squares that a few odd drives do not move.

    A drive's scatter grows with its length, so residuals are relative to the fit. With sizes all alike the line is not
    determined: half of the cost then is taken to go with the size.
    """
    mean_size = sum(sizes) / len(sizes)
    middle = median(seconds)
    if max(sizes) - min(sizes) < 0.1 * mean_size or mean_size <= 0:
        return (0.5 * middle, 0.5 * middle / mean_size) if mean_size > 0 else (middle, 0.0)
    a, b = 0.5 * middle, 0.5 * middle / mean_size
    for _ in range(ROUNDS):
        fitted = [max(a + b * x, 1e-3) for x in sizes]
        off = [abs(y - f) / f for y, f in zip(seconds, fitted, strict=True)]
        limit = CLIP * max(median(off), 1e-3)
        weights = [min(1.0, limit / max(o, 1e-12)) / (f * f) for o, f in zip(off, fitted, strict=True)]
        a, b = _line(sizes, seconds, weights)
    return a, b


def _line(x: list[int], y: list[float], w: list[float]) -> tuple[float, float]:
    total = sum(w)
    mx = sum(wi * xi for wi, xi in zip(w, x, strict=True)) / total
    my = sum(wi * yi for wi, yi in zip(w, y, strict=True)) / total
    spread = sum(wi * (xi - mx) ** 2 for wi, xi in zip(w, x, strict=True))
    together = sum(wi * (xi - mx) * (yi - my) for wi, xi, yi in zip(w, x, y, strict=True))
    # a drive never costs less for being larger, nor less than nothing when it is empty
    slope = min(max(together / spread, 0.0), my / mx)
    return my - slope * mx, slope


class TimeLeft:
    """Counts the work of a batch while its drives end. Times in s, of a clock that only goes on."""

    def __init__(self, drives: int, size: int, started: float) -> None:
        """drives, size: how many drives and bytes are to do. started: now."""
        self._drives, self._bytes, self._started = drives, size, started
        self._latest: deque[tuple[int, float]] = deque(maxlen=LATEST)
        self._done_drives, self._done_bytes = 0, 0
        self._last = started
        self._cost: tuple[float, float] | None = None

    def ended(self, size: int, seconds: float, now: float, *, work: bool = True) -> None:
        """A drive of `size` bytes ended after `seconds` of its own. work: False where nothing was to do after all."""
        self._drives -= 1
        self._bytes -= size
        if work:
            self._latest.append((size, seconds))
            self._done_drives += 1
            self._done_bytes += size
            self._last, self._cost = now, None

    def a_minute(self, now: float) -> float:
        """Drives that end in a minute, on the whole."""
        return 60.0 * self._done_drives / max(now - self._started, 1e-3)

    def seconds(self, now: float) -> float | None:
        """Seconds left; None while too little is known.

        Work done over the time that it took is the speed of all workers together, whatever their number and what they lose
        between drives; the work left goes on at that speed. Between two ends the time left runs down, but not below half of
        what it would be if all that was waited for in vain.
        """
        if self._done_drives < LEAST or self._last <= self._started:
            return None
        if self._cost is None:
            self._cost = fit_cost([s for s, _ in self._latest], [t for _, t in self._latest])
        a, b = self._cost
        done = a * self._done_drives + b * self._done_bytes
        left = a * max(self._drives, 0) + b * max(self._bytes, 0)
        if done <= 0:
            return None
        at_last = left * (self._last - self._started) / done
        return max(at_last - (now - self._last), 0.5 * left * (now - self._started) / done)


def told(seconds: float) -> str:
    """A time left as people say it: "about 40 s", "about 12 min", "about 2 h 20 min", "about 3 days"."""
    if seconds < 90:
        return f"about {max(10, round(seconds / 10) * 10)} s"
    minutes = round(seconds / 60)
    if minutes < 90:
        return f"about {minutes} min"
    if minutes < 48 * 60:
        hours, rest = divmod(round(minutes / 10) * 10, 60)
        return f"about {hours} h {rest} min" if rest else f"about {hours} h"
    return f"about {round(minutes / 60 / 24)} days"
