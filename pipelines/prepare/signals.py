"""Signals with clocks and rates of their own onto one even grid, in segments without gaps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from parsers.drive import Drive, Signal
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.prepare.resample import on_grid
from pipelines.prepare.spans import runs, usual_period_s
from pipelines.prepare.spikes import without_spikes
from pipelines.prepare.standstill import find_standstill, first_rest, standstill_offsets
from pipelines.results import FloatArray

MAX_ROWS = 20_000_000
MAX_FINE_HZ = 400.0
SHORTEST_SEGMENT_S = 2.0
TOGETHER_S = 0.002
SLOW_SHARE = 0.4
"""Largest share of the slowest wanted signal's own rate that the cutoff may take."""


def _rate(signal: Signal) -> float:
    period = usual_period_s(signal.time_ns)
    return 1 / period if period > 0 else 0.0


def _empty(rate_hz: float, cutoff_hz: float, names: Sequence[str], notes: list[str]) -> Prepared:
    nothing = np.zeros(0)
    return Prepared(
        rate_hz=rate_hz,
        cutoff_hz=cutoff_hz,
        time_s=nothing,
        columns=dict.fromkeys(names, nothing),
        segments=(),
        sources={},
        measured=frozenset(),
        standstill=np.zeros(0, dtype=bool),
        notes=tuple(notes),
    )


def _cutoff(signals: Sequence[Signal], cutoff_hz: float, notes: list[str]) -> float:
    """The cutoff that all wanted signals can carry: all get the same one, or a model would see a delay."""
    slowest = min(signals, key=_rate)
    limit = SLOW_SHARE * _rate(slowest)
    if cutoff_hz <= limit:
        return cutoff_hz
    notes.append(
        f"{slowest.name} comes at {_rate(slowest):.3g} Hz: all signals are low-passed at {limit:.3g} Hz "
        f"instead of {cutoff_hz:.3g} Hz"
    )
    return limit


def _grid_rate(signals: Sequence[Signal], rate_hz: float | None, cutoff_hz: float) -> tuple[float, int]:
    """The grid's rate, and by how much denser the grid is on which the low-pass works."""
    fastest = max(_rate(signal) for signal in signals)
    rate = rate_hz if rate_hz is not None else max(2.5 * cutoff_hz, min(fastest, 4 * cutoff_hz))
    dense = min(max(fastest, 5 * cutoff_hz), max(MAX_FINE_HZ, rate))
    return rate, max(1, math.ceil(dense / rate - 1e-6))


def _span(needed: Sequence[Signal], rate_hz: float, notes: list[str]) -> tuple[int, int]:
    """Where the grid begins [ns] and how many rows it has: 0 where the signals are never there together."""
    start_ns = max(int(signal.time_ns[0]) for signal in needed)
    stop_ns = min(int(signal.time_ns[-1]) for signal in needed)
    rows = int(max(stop_ns - start_ns, 0) / 1e9 * rate_hz) + 1
    if stop_ns <= start_ns:
        notes.append(f"{', '.join(signal.name for signal in needed)} are never there at the same time")
        return start_ns, 0
    if rows > MAX_ROWS:
        notes.append(f"only the first {MAX_ROWS / rate_hz / 3600:.1f} h are used")
        rows = MAX_ROWS
    return start_ns, rows


def _source(signal: Signal) -> str:
    return f"{'measured' if signal.measured else 'derived'}: {signal.source}"


def _segments(columns: Sequence[FloatArray], rate_hz: float) -> tuple[Segment, ...]:
    """Stretches in which all columns are there, two seconds or longer."""
    there = np.all([np.isfinite(column) for column in columns], axis=0)
    shortest = SHORTEST_SEGMENT_S * rate_hz
    return tuple(Segment(first, past) for first, past in runs(there) if past - first >= shortest)


def _cleaned(drive: Drive, names: Sequence[str], notes: list[str]) -> dict[str, Signal]:
    """The signals without wild samples."""
    cleaned: dict[str, Signal] = {}
    for name in names:
        cleaned[name], dropped = without_spikes(drive.signals[name])
        if dropped:
            notes.append(f"{dropped} wild sample{'s' if dropped > 1 else ''} of {name} left out")
    return cleaned


def _together(drive: Drive, first: str, names: Iterable[str]) -> frozenset[str]:
    """Signals whose samples come at the instants of `first`, within TOGETHER_S as frames of one cycle on a bus do."""
    clock = drive.signals[first].time_ns
    limit = min(TOGETHER_S, 0.2 * usual_period_s(clock)) * 1e9
    found = []
    for name in names:
        other = drive.signals[name].time_ns
        if name == first or abs(len(other) - len(clock)) > 0.02 * len(clock):
            continue
        if np.array_equal(other, clock):
            found.append(name)
            continue
        after = np.clip(np.searchsorted(other, clock), 1, len(other) - 1)
        apart = np.minimum(np.abs(other[after] - clock), np.abs(other[after - 1] - clock))
        if float(np.quantile(apart, 0.9)) <= limit:
            found.append(name)
    return frozenset(found)


def prepare_signals(
    drive: Drive,
    wanted: Sequence[str],
    *,
    rate_hz: float | None,
    cutoff_hz: float,
    max_gap_s: float | None = None,
    optional: Sequence[str] = (),
) -> Prepared:
    """Bring `wanted` (and what is there of `optional`) onto one grid, low-passed alike with zero phase.

    Segments are where all of `wanted` are there; an optional signal is NaN where it is missing and cuts nothing.
    rate_hz None: four times the cutoff, or the fastest signal's rate where that is lower. max_gap_s None: a distance
    of more than 4.5 of a signal's own periods is a gap. A wanted signal that the drive lacks, or signals that never
    overlap, give no segments and a note, never an error.
    """
    notes: list[str] = []
    missing = [name for name in wanted if name not in drive.signals or len(drive.signals[name].time_ns) < 2]
    if missing or not wanted:
        notes.append(f"not in the log: {', '.join(missing)}" if missing else "no signal was asked for")
        return _empty(rate_hz or 0.0, cutoff_hz, wanted, notes)
    extra = [
        n for n in optional if n in drive.signals and n not in wanted and len(drive.signals[n].time_ns) > 1
    ]
    cleaned = _cleaned(drive, (*wanted, *extra), notes)
    needed = [cleaned[name] for name in wanted]
    cutoff = _cutoff(needed, cutoff_hz, notes)
    rate, fine = _grid_rate(list(cleaned.values()), rate_hz, cutoff)
    start_ns, rows = _span(needed, rate, notes)
    if not rows:
        return _empty(rate, cutoff, wanted, notes)
    columns = {name: on_grid(s, start_ns, rows, rate, fine, cutoff, max_gap_s) for name, s in cleaned.items()}
    segments = _segments([columns[name] for name in wanted], rate)
    if not segments:
        notes.append(f"no stretch of {SHORTEST_SEGMENT_S:g} s holds {', '.join(wanted)} without a gap")
    still, how = find_standstill(drive, start_ns, rows, rate, max_gap_s)
    rest = first_rest(still, rate)
    if rest is not None:
        notes.append(
            f"offsets from standstill (told by {how}) over {(rest[1] - rest[0]) / rate:.1f} s "
            f"from {(start_ns - drive.start_ns) / 1e9 + rest[0] / rate:.1f} s"
        )
    return Prepared(
        rate_hz=rate,
        cutoff_hz=cutoff,
        time_s=(start_ns - drive.start_ns) / 1e9 + np.arange(rows) / rate,
        columns=columns,
        segments=segments,
        sources={name: _source(signal) for name, signal in cleaned.items()},
        measured=frozenset(name for name, signal in cleaned.items() if signal.measured),
        standstill=still,
        raw_rate_hz={name: _rate(signal) for name, signal in cleaned.items()},
        standstill_offset=standstill_offsets(columns, list(columns), rest, rate),
        notes=tuple(notes),
        together=_together(drive, wanted[0], cleaned),
    )
