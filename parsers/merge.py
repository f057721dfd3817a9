"""Several logs of one drive, recorded in parts or by several recorders: one set of signals on one clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from parsers.drive import Signal
from parsers.errors import LogError
from parsers.read_log import Part
from parsers.timebase import NS

APART_NS = 48 * 3600 * NS
"""Logs further apart than this are of two drives."""

OVERLAP_NS = NS
"""Parts in a row may overlap by this much; by more, they are recorders of the same span."""


@dataclass
class Merged:
    """Signals of all logs. left_out: (number of the log, signal) where another log's was taken. notes: sentences."""

    signals: dict[str, Signal] = field(default_factory=dict)
    left_out: set[tuple[int, str]] = field(default_factory=set)
    notes: list[str] = field(default_factory=list)


def merge_parts(parts: Sequence[Part]) -> Merged:
    """Bring the signals of all logs onto one clock. Raises LogError where the clocks cannot be brought together."""
    if len(parts) == 1:
        return Merged(dict(parts[0].signals))
    merged = Merged()
    with_signals = [part for part in parts if part.signals]
    kinds = {part.opened.reader.absolute for part in with_signals}
    if len(kinds) > 1:
        relative = next(part.opened.path for part in with_signals if not part.opened.reader.absolute)
        raise LogError(
            "its stamps count from its own start, the other log's from 1970: they cannot be laid side by side",
            path=relative,
            hint="analyse the logs one by one, or record with one clock",
        )
    if kinds == {False}:
        merged.notes.append("the logs' stamps are relative: their zeros are taken as one moment")
    spans = [(int(s.time_ns[0]), int(s.time_ns[-1])) for part in parts for s in part.signals.values()]
    if spans and max(b for _, b in spans) - min(a for a, _ in spans) > APART_NS:
        raise LogError(
            "the logs lie more than two days apart: nothing overlaps",
            path=parts[0].opened.path,
            hint="give only logs of one drive",
        )
    for name in dict.fromkeys(name for part in parts for name in part.signals):
        held = {number: part.signals[name] for number, part in enumerate(parts) if name in part.signals}
        merged.signals[name] = _joined(name, held, merged)
    return merged


def _joined(name: str, held: Mapping[int, Signal], merged: Merged) -> Signal:
    """One signal that several logs hold: parts in a row are joined, a second recorder of the same span is left out."""
    longest = max(held, key=lambda number: len(held[number].values))
    chosen = [held[longest]]
    for number in sorted(held, key=lambda each: int(held[each].time_ns[0])):
        part = held[number]
        if number == longest:
            continue
        if any(_overlap_ns(part, other) > OVERLAP_NS for other in chosen):
            merged.notes.append(f"{name} is in several logs over the same time: {part.source!r} left out")
            merged.left_out.add((number, name))
            continue
        fresh = np.ones(len(part.time_ns), dtype=np.bool_)
        for other in chosen:
            fresh &= (part.time_ns < other.time_ns[0]) | (part.time_ns > other.time_ns[-1])
        if fresh.any():
            chosen.append(replace(part, time_ns=part.time_ns[fresh], values=part.values[fresh]))
    chosen.sort(key=lambda s: int(s.time_ns[0]))
    if len(chosen) == 1:
        return chosen[0]
    return replace(
        chosen[0],
        time_ns=np.concatenate([s.time_ns for s in chosen]),
        values=np.concatenate([s.values for s in chosen]),
    )


def _overlap_ns(first: Signal, second: Signal) -> int:
    """How long both run; negative where they are apart. One inside the other is more than any allowed overlap."""
    a, b = int(first.time_ns[0]), int(first.time_ns[-1])
    c, d = int(second.time_ns[0]), int(second.time_ns[-1])
    inside = (c <= a and b <= d) or (a <= c and d <= b)
    return OVERLAP_NS + 1 if inside else min(b, d) - max(a, c)
