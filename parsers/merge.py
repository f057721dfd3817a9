"""Several logs of one drive, recorded in parts or by several recorders: one set of signals on one clock."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic, TypeVar

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.drive import Signal
from parsers.opened_log import OpenedLog
from parsers.pieces import OVERLAP_NS, Piece, Span, inside, overlap_ns, same_samples
from parsers.placing import place_logs, refuse_far_apart, refuse_other_moments
from parsers.read_log import Part
from parsers.timebase import NS

P = TypeVar("P", bound=Piece)


@dataclass
class Joined(Generic[P]):
    """What all logs have of each signal, in order of time. left_out: (number of the log, signal) where another log's
    was taken. notes: sentences. shifts_ns: what was added to each log's stamps."""

    pieces: dict[str, list[P]] = field(default_factory=dict)
    left_out: set[tuple[int, str]] = field(default_factory=set)
    notes: list[str] = field(default_factory=list)
    shifts_ns: tuple[int, ...] = ()


def join_pieces(
    logs: Sequence[OpenedLog],
    held: Sequence[Mapping[str, P]],
    shifted: Callable[[Mapping[str, P], int], Mapping[str, P]],
) -> Joined[P]:
    """Bring what several logs hold (signal -> piece) onto one clock: parts in a row follow one another, a second recorder
    of the same span is left out. shifted: a log's pieces, so many nanoseconds later. Raises LogError where the clocks
    cannot be brought together."""
    joined = Joined[P](shifts_ns=(0,) * len(logs))
    if len(held) > 1:
        placing = place_logs(logs, held)
        held = [
            shifted(pieces, ns) if ns else pieces for pieces, ns in zip(held, placing.shifts_ns, strict=True)
        ]
        refuse_far_apart(logs, held)
        refuse_other_moments(logs, held, placing)
        joined.shifts_ns = placing.shifts_ns
        joined.notes += placing.notes
    common = _Common(logs)
    for name in dict.fromkeys(name for pieces in held for name in pieces):
        of = {number: pieces[name] for number, pieces in enumerate(held) if name in pieces}
        joined.pieces[name] = _chosen(name, of, joined, common)
    joined.notes += common.notes()
    return joined


@dataclass
class _Common:
    """Pairs of logs that hold the same samples where they overlap: for how long, and of which signals."""

    logs: Sequence[OpenedLog]
    pairs: dict[tuple[int, int], tuple[int, list[str]]] = field(default_factory=dict)

    def add(self, one: int, two: int, overlap: int, name: str) -> None:
        pair = (min(one, two), max(one, two))
        longest, names = self.pairs.get(pair, (0, []))
        self.pairs[pair] = (max(longest, overlap), [*names, name])

    def notes(self) -> Iterator[str]:
        for (one, two), (overlap, names) in self.pairs.items():
            paths = f"{self.logs[one].path.name} and {self.logs[two].path.name}"
            yield (
                f"{paths} overlap by {overlap / NS:.1f} s and hold the same samples there, which count once: "
                f"{', '.join(names[:6])}{', …' if len(names) > 6 else ''}"
            )


def _chosen(name: str, held: Mapping[int, P], joined: Joined[P], common: _Common) -> list[P]:
    """The pieces of one signal that are used: the longest, and all that fit beside it or go on with the same samples."""
    longest = max(held, key=lambda number: held[number].samples)
    chosen = {longest: held[longest]}
    for number in sorted(held, key=lambda each: held[each].span[0]):
        piece = held[number]
        if number == longest:
            continue
        clashes = [k for k, other in chosen.items() if overlap_ns(piece.span, other.span) > OVERLAP_NS]
        fresh = None
        if all(not inside(piece.span, chosen[k].span) and same_samples(piece, chosen[k]) for k in clashes):
            fresh = piece.outside([other.span for other in chosen.values()])
        if fresh is None:
            joined.notes.append(f"{name} is in several logs over the same time: {piece.source!r} left out")
            joined.left_out.add((number, name))
            continue
        for k in clashes:
            (a, b), (c, d) = piece.span, chosen[k].span
            common.add(number, k, min(b, d) - max(a, c), name)
        chosen[number] = fresh
    return sorted(chosen.values(), key=lambda each: each.span[0])


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

    def load(self, start: int, stop: int) -> tuple[IntArray, FloatArray]:
        here = slice(*np.searchsorted(self.signal.time_ns, [start, stop]).tolist())
        return self.signal.time_ns[here], self.signal.values[here]

    def outside(self, spans: Sequence[Span]) -> _InMemory | None:
        time_ns = self.signal.time_ns
        fresh = np.ones(len(time_ns), dtype=np.bool_)
        for start, end in spans:
            fresh &= (time_ns < start) | (time_ns > end)
        if not fresh.any():
            return None
        return _InMemory(replace(self.signal, time_ns=time_ns[fresh], values=self.signal.values[fresh]))


def _shifted(pieces: Mapping[str, _InMemory], by_ns: int) -> dict[str, _InMemory]:
    """Signals that share their stamps go on sharing them."""
    times = {id(each.signal.time_ns): each.signal.time_ns for each in pieces.values()}
    later = {key: time_ns + by_ns for key, time_ns in times.items()}
    return {
        name: _InMemory(replace(each.signal, time_ns=later[id(each.signal.time_ns)]))
        for name, each in pieces.items()
    }


@dataclass(frozen=True)
class Merged:
    """Signals of all logs. left_out, notes, shifts_ns: as `Joined` has them."""

    signals: dict[str, Signal]
    left_out: set[tuple[int, str]]
    notes: list[str]
    shifts_ns: tuple[int, ...]


def merge_parts(parts: Sequence[Part]) -> Merged:
    """Bring the signals of all logs onto one clock. Raises LogError where the clocks cannot be brought together."""
    held = [{name: _InMemory(signal) for name, signal in part.signals.items()} for part in parts]
    joined = join_pieces([part.opened for part in parts], held, _shifted)
    signals = {
        name: _concatenated([each.signal for each in pieces]) for name, pieces in joined.pieces.items()
    }
    return Merged(signals, joined.left_out, joined.notes, joined.shifts_ns)


def _concatenated(signals: Sequence[Signal]) -> Signal:
    if len(signals) == 1:
        return signals[0]
    return replace(
        signals[0],
        time_ns=np.concatenate([s.time_ns for s in signals]),
        values=np.concatenate([s.values for s in signals]),
    )
