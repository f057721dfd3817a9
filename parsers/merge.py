"""Several logs of one drive, recorded in parts or by several recorders: one set of signals on one clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic, Protocol, Self, TypeVar

import numpy as np

from parsers.drive import Signal
from parsers.errors import LogError
from parsers.read_log import OpenedLog, Part
from parsers.timebase import NS

APART_NS = 48 * 3600 * NS
"""Logs further apart than this are of two drives."""

OVERLAP_NS = NS
"""Parts in a row may overlap by this much; by more, they are recorders of the same span."""

Span = tuple[int, int]


class Piece(Protocol):
    """What one log has of a signal, wherever its samples are."""

    @property
    def span(self) -> Span:
        """First and last stamp."""
        ...

    @property
    def samples(self) -> int:
        """How many samples it has."""
        ...

    @property
    def source(self) -> str:
        """Where it is from, as a record says it."""
        ...

    def outside(self, spans: Sequence[Span]) -> Self | None:
        """The samples that lie in none of the spans (their ends are inside); None where there are none."""
        ...


P = TypeVar("P", bound=Piece)


@dataclass
class Joined(Generic[P]):
    """What all logs have of each signal, in order of time. left_out: (number of the log, signal) where another log's
    was taken. notes: sentences."""

    pieces: dict[str, list[P]] = field(default_factory=dict)
    left_out: set[tuple[int, str]] = field(default_factory=set)
    notes: list[str] = field(default_factory=list)


def join_pieces(logs: Sequence[OpenedLog], held: Sequence[Mapping[str, P]]) -> Joined[P]:
    """Bring what several logs hold (signal -> piece) onto one clock: parts in a row follow one another, a second recorder
    of the same span is left out. Raises LogError where the clocks cannot be brought together."""
    joined = Joined[P]()
    if len(held) > 1:
        joined.notes += _one_clock(logs, held)
    for name in dict.fromkeys(name for pieces in held for name in pieces):
        of = {number: pieces[name] for number, pieces in enumerate(held) if name in pieces}
        joined.pieces[name] = _chosen(name, of, joined)
    return joined


def _one_clock(logs: Sequence[OpenedLog], held: Sequence[Mapping[str, P]]) -> list[str]:
    """What is to be said of the clocks. Raises LogError where they have nothing in common."""
    readers = [log.reader for log, pieces in zip(logs, held, strict=True) if pieces]
    kinds = {reader.absolute for reader in readers}
    if len(kinds) > 1:
        paths = [log.path for log, pieces in zip(logs, held, strict=True) if pieces]
        raise LogError(
            "its stamps count from its own start, the other log's from 1970: they cannot be laid side by side",
            path=next(path for path, reader in zip(paths, readers, strict=True) if not reader.absolute),
            hint="analyse the logs one by one, or record with one clock",
        )
    spans = [piece.span for pieces in held for piece in pieces.values()]
    if spans and max(b for _, b in spans) - min(a for a, _ in spans) > APART_NS:
        raise LogError(
            "the logs lie more than two days apart: nothing overlaps",
            path=logs[0].path,
            hint="give only logs of one drive",
        )
    relative = kinds == {False}
    return ["the logs' stamps are relative: their zeros are taken as one moment"] if relative else []


def _chosen(name: str, held: Mapping[int, P], joined: Joined[P]) -> list[P]:
    """The pieces of one signal that are used: the longest, and all that fit beside it."""
    longest = max(held, key=lambda number: held[number].samples)
    chosen = [held[longest]]
    for number in sorted(held, key=lambda each: held[each].span[0]):
        piece = held[number]
        if number == longest:
            continue
        if any(_overlap_ns(piece.span, other.span) > OVERLAP_NS for other in chosen):
            joined.notes.append(f"{name} is in several logs over the same time: {piece.source!r} left out")
            joined.left_out.add((number, name))
            continue
        fresh = piece.outside([other.span for other in chosen])
        if fresh is not None:
            chosen.append(fresh)
    return sorted(chosen, key=lambda each: each.span[0])


def _overlap_ns(first: Span, second: Span) -> int:
    """How long both run; negative where they are apart. One inside the other is more than any allowed overlap."""
    (a, b), (c, d) = first, second
    inside = (c <= a and b <= d) or (a <= c and d <= b)
    return OVERLAP_NS + 1 if inside else min(b, d) - max(a, c)


@dataclass(frozen=True)
class _InMemory:
    """A signal as a piece."""

    signal: Signal

    @property
    def span(self) -> Span:
        return int(self.signal.time_ns[0]), int(self.signal.time_ns[-1])

    @property
    def samples(self) -> int:
        return len(self.signal.time_ns)

    @property
    def source(self) -> str:
        return self.signal.source

    def outside(self, spans: Sequence[Span]) -> _InMemory | None:
        time_ns = self.signal.time_ns
        fresh = np.ones(len(time_ns), dtype=np.bool_)
        for start, end in spans:
            fresh &= (time_ns < start) | (time_ns > end)
        if not fresh.any():
            return None
        return _InMemory(replace(self.signal, time_ns=time_ns[fresh], values=self.signal.values[fresh]))


@dataclass
class Merged:
    """Signals of all logs. left_out, notes: as `Joined` has them."""

    signals: dict[str, Signal] = field(default_factory=dict)
    left_out: set[tuple[int, str]] = field(default_factory=set)
    notes: list[str] = field(default_factory=list)


def merge_parts(parts: Sequence[Part]) -> Merged:
    """Bring the signals of all logs onto one clock. Raises LogError where the clocks cannot be brought together."""
    held = [{name: _InMemory(signal) for name, signal in part.signals.items()} for part in parts]
    joined = join_pieces([part.opened for part in parts], held)
    signals = {
        name: _concatenated([each.signal for each in pieces]) for name, pieces in joined.pieces.items()
    }
    return Merged(signals, joined.left_out, joined.notes)


def _concatenated(signals: Sequence[Signal]) -> Signal:
    if len(signals) == 1:
        return signals[0]
    return replace(
        signals[0],
        time_ns=np.concatenate([s.time_ns for s in signals]),
        values=np.concatenate([s.values for s in signals]),
    )
