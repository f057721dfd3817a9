"""What is impossible in a signal that lies on disk: the figures of `parsers.checks.spikes`, gathered window by window."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.checks.codes import Span
from parsers.checks.spikes import (
    CODE_LEAST,
    CODE_RANGE,
    LONG_STEP_S,
    USUAL_FACTOR,
    USUAL_SHARE,
    Bounds,
    code_from,
    most_stray,
    out_of_range,
    step_limits,
)
from parsers.drive import Decision
from parsers.signals import SIGNALS
from parsers.step_counts import SizeCounts
from parsers.strands import Strand, load_samples
from parsers.windows import time_windows


@dataclass(frozen=True)
class StrandBounds:
    """bounds: None where so much is beyond the signal's range that the range must be wrong: `doubt` then says so."""

    bounds: Bounds | None
    doubt: Decision | None = None


class _Range:
    """How much is beyond the range, and the largest value within it."""

    def __init__(self, span: Span) -> None:
        self.low, self.high = span
        self.total = self.beyond = 0
        self.top, self.largest = -np.inf, 0.0

    def add(self, values: FloatArray) -> None:
        if len(values) == 0:
            return
        self.total += len(values)
        inside = values[(values >= self.low) & (values <= self.high)]
        self.beyond += len(values) - len(inside)
        self.largest = max(self.largest, float(np.abs(values).max()))
        if len(inside):
            self.top = max(self.top, float(inside.max()))


class _Steps:
    """How values change from sample to sample. Values in [low, below): `counts`; `longest_s`: the longest short step."""

    def __init__(self, low: float, high: float, below: float) -> None:
        self._low, self._high, self._below = low, high, below
        self.counts = SizeCounts()
        self.longest_s = np.nan
        self.largest = -np.inf
        self.samples = 0
        self._last: tuple[IntArray, FloatArray] = (np.zeros(0, dtype=np.int64), np.zeros(0))

    def add(self, time_ns: IntArray, values: FloatArray) -> None:
        here = (values >= self._low) & (values <= self._high) & (values < self._below)
        time_ns, values = time_ns[here], values[here]
        if len(values) == 0:
            return
        self.samples += len(values)
        self.largest = max(self.largest, float(values.max()))
        times = np.concatenate([self._last[0], time_ns])
        series = np.concatenate([self._last[1], values])
        self.counts.add(np.abs(np.diff(series)))
        dt = np.diff(times) / 1e9
        short = dt[dt <= LONG_STEP_S]
        if len(short):
            self.longest_s = float(np.fmax(self.longest_s, short.max()))
        self._last = times[-1:], series[-1:]

    @property
    def usual(self) -> float:
        """The step that is always possible."""
        return USUAL_FACTOR * self.counts.quantile(USUAL_SHARE)


def bounds_of_strands(
    strands: Sequence[Strand], window_bytes: int, narrower: Mapping[str, Span]
) -> dict[str, StrandBounds]:
    """What is impossible in each strand of a rate group. Goes through the samples only where the facts do not say it.

    narrower: ranges of signals whose codes for "no value" lie in the usual range.
    """
    spans = {s.name: narrower.get(s.name, (SIGNALS[s.name].low, SIGNALS[s.name].high)) for s in strands}
    ranges = {s.name: _Range(spans[s.name]) for s in strands if not _in_range(s, spans[s.name])}
    _go_through([s for s in strands if s.name in ranges], window_bytes, ranges, {})
    found: dict[str, StrandBounds] = {}
    tops: dict[str, float] = {}
    for strand in strands:
        name = strand.name
        held = ranges.get(name)
        if held is not None and held.total and held.beyond > most_stray(strand.name) * held.total:
            found[name] = StrandBounds(None, out_of_range(name, held.beyond / held.total, held.largest))
            continue
        found[name] = StrandBounds(Bounds(*spans[name]))
        top = held.top if held else strand.tracks[0].facts.high * strand.factor
        if _may_jump(strand, top):
            tops[name] = top
    jumping = [strand for strand in strands if strand.name in tops]
    for name, bounds in _step_bounds(jumping, tops, spans, window_bytes).items():
        found[name] = StrandBounds(bounds)
    return found


def _in_range(strand: Strand, span: Span) -> bool:
    """Whether the facts say that nothing is beyond the range."""
    facts = strand.tracks[0].facts
    low, high = facts.low * strand.factor, facts.high * strand.factor
    return strand.whole and low >= span[0] and high <= span[1]


def _is_code(name: str, top: float) -> bool:
    return SIGNALS[name].quantity == "speed" and top >= CODE_LEAST


def _may_jump(strand: Strand, top: float) -> bool:
    """Whether some step may be larger than what is always allowed, or the largest value be a code."""
    limits = step_limits(strand.name)
    if limits is None:
        return False
    steep = not strand.whole or strand.tracks[0].facts.steepest * strand.factor > limits[0]
    return steep or _is_code(strand.name, top)


def _step_bounds(
    strands: Sequence[Strand], tops: dict[str, float], spans: Mapping[str, Span], window_bytes: int
) -> dict[str, Bounds]:
    own = {strand.name: spans[strand.name] for strand in strands}
    every = {name: _Steps(*span, np.inf) for name, span in own.items()}
    others = {
        name: _Steps(*span, tops[name] - CODE_RANGE)
        for name, span in own.items()
        if _is_code(name, tops[name])
    }
    _go_through(strands, window_bytes, {}, every, others)
    found: dict[str, Bounds] = {}
    for name, span in own.items():
        steps, code, rest = every[name], np.inf, others.get(name)
        if rest is not None and rest.samples:
            code = code_from(name, tops[name], rest.largest, rest.samples, steps.longest_s, steps.usual)
        if rest is not None and code < np.inf:
            steps = rest
        # three steps are too few to know what is usual
        found[name] = Bounds(*span, code, steps.usual if steps.samples >= 4 else np.inf)
    return found


def _go_through(
    strands: Sequence[Strand], window_bytes: int, ranges: dict[str, _Range], *steps: dict[str, _Steps]
) -> None:
    if not strands:
        return
    for start, stop in time_windows([track for s in strands for track in s.tracks], window_bytes):
        for name, samples in load_samples(strands, start, stop)[0].items():
            if name in ranges:
                ranges[name].add(samples.values)
            for held in steps:
                if name in held:
                    held[name].add(samples.time_ns, samples.values)
