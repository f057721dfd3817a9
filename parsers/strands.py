"""Signals of a drive that lies on disk: pieces of one or several logs, loaded window by window, and what was decided."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.checks.check import Findings
from parsers.checks.flat_tops import Limits
from parsers.checks.spikes import Bounds, Tally, impossible, possible, with_cut_off
from parsers.drive import Signal
from parsers.pieces import Span
from parsers.windows import Track, load_window

CONTEXT = 256
"""Samples before and after a window that are looked at too, so that a burst at its edge shows."""


@dataclass(frozen=True, eq=False)
class Strand:
    """One signal. tracks: in order of time, not overlapping. factor: what its values are multiplied by."""

    name: str
    tracks: tuple[Track, ...]
    factor: float = 1.0

    @property
    def group(self) -> str:
        """The rate group that the signal belongs to."""
        return self.tracks[0].group

    @property
    def usual_ns(self) -> float:
        """About how long a step is."""
        return min(track.facts.period_s for track in self.tracks) * 1e9

    @property
    def whole(self) -> bool:
        """Whether the facts of the tracks are those of the signal: one track, of which nothing is cut off."""
        return len(self.tracks) == 1 and not self.tracks[0].cut


@dataclass(frozen=True)
class Samples:
    """A signal's samples in one window, times its factor. raw: without it."""

    time_ns: IntArray
    values: FloatArray
    raw: FloatArray


def load_samples(strands: Sequence[Strand], start: int, stop: int) -> tuple[dict[str, Samples], IntArray]:
    """The samples of each strand in [start, stop), and the stamps that most of them share."""
    tracks = [track for strand in strands for track in strand.tracks]
    window = load_window(tracks, start, stop)
    found: dict[str, Samples] = {}
    at = 0
    for strand in strands:
        pieces = [piece for piece in window.pieces[at : at + len(strand.tracks)] if len(piece[0])]
        at += len(strand.tracks)
        if len(pieces) == 1:
            time_ns, raw = pieces[0]
        else:
            time_ns = np.concatenate([np.zeros(0, dtype=np.int64), *(each for each, _ in pieces)])
            raw = np.concatenate([np.zeros(0), *(each for _, each in pieces)])
        found[strand.name] = Samples(time_ns, raw * strand.factor if strand.factor != 1.0 else raw, raw)
    return found, window.base


def whole_signals(strands: Sequence[Strand], spans: Sequence[Span]) -> dict[str, Signal]:
    """The strands as signals, raw, with the samples that lie in the spans [start, stop), which are in order."""
    times: dict[str, list[IntArray]] = {strand.name: [] for strand in strands}
    values: dict[str, list[FloatArray]] = {strand.name: [] for strand in strands}
    for start, stop in spans:
        for name, samples in load_samples(strands, start, stop)[0].items():
            times[name].append(samples.time_ns)
            values[name].append(samples.raw)
    shared: dict[tuple[int, ...], IntArray] = {}
    signals: dict[str, Signal] = {}
    for strand in strands:
        parts = times[strand.name]
        key = tuple(id(part) for part in parts)
        if key not in shared:
            shared[key] = np.concatenate(parts)
        first = strand.tracks[0].signal
        joined = np.concatenate(values.pop(strand.name))
        signals[strand.name] = replace(first, time_ns=shared[key], values=joined)
    return signals


@dataclass
class Cleaner:
    """Takes impossible samples out of one signal, window by window. bounds: None where the range itself is in doubt. limits: where it
    is cut off."""

    strand: Strand
    bounds: Bounds | None
    inverted: bool
    tally: Tally
    before: tuple[IntArray, FloatArray]
    limits: Limits | None = None

    def clean(self, now: Samples, after: Samples | None) -> Signal:
        """The window's samples, cleaned and with the right sign. after: those of the next window."""
        time_ns, values = now.time_ns, now.values
        good = self._good(now, after)
        if good is not None:
            time_ns, values = time_ns[good], values[good]
        signal = self.strand.tracks[0].signal
        return replace(signal, time_ns=time_ns, values=-values if self.inverted else values)

    def _good(self, now: Samples, after: Samples | None) -> np.ndarray | None:
        """Which samples stay; None for all."""
        if self.bounds is None or (self.bounds.usual == np.inf and self.bounds.code == np.inf):
            masks = None if self.bounds is None else self._impossible(now.time_ns, now.values)
            self.tally.add(now.values, masks)
            return None if masks is None else possible(masks)
        head = (np.zeros(0, dtype=np.int64), np.zeros(0))
        if after is not None:
            head = after.time_ns[:CONTEXT], after.values[:CONTEXT]
        time_ns = np.concatenate([self.before[0], now.time_ns, head[0]])
        values = np.concatenate([self.before[1], now.values, head[1]])
        here = slice(len(self.before[0]), len(self.before[0]) + len(now.time_ns))
        masks = self._impossible(time_ns, values)
        self.tally.add(values, masks, here)
        keep = slice(max(here.stop - CONTEXT, 0), here.stop)
        self.before = time_ns[keep].copy(), values[keep].copy()
        return None if masks is None else possible(masks)[here]

    def _impossible(self, time_ns: IntArray, values: FloatArray) -> tuple[np.ndarray, ...] | None:
        assert self.bounds is not None
        masks = impossible(self.strand.name, self.bounds, time_ns, values)
        return with_cut_off(masks, values, self.limits)


def make_cleaner(strand: Strand, bounds: Bounds | None, findings: Findings) -> Cleaner:
    """A cleaner at the beginning of the drive."""
    none = (np.zeros(0, dtype=np.int64), np.zeros(0))
    inverted, limits = strand.name in findings.inverted, findings.limits.get(strand.name)
    return Cleaner(strand, bounds, inverted, Tally(), none, limits)


def cleaned(
    strands: Sequence[Strand], windows: Sequence[Span], cleaners: Mapping[str, Cleaner], *, fix: bool
) -> Iterator[tuple[dict[str, Signal], IntArray]]:
    """The signals of each window, and the stamps that most of them share. With fix=False they are untouched: what is
    impossible is only counted."""
    held: tuple[dict[str, Samples], IntArray] | None = None
    for span in [*windows, None]:
        found = load_samples(strands, *span) if span else None
        if held is not None:
            signals: dict[str, Signal] = {}
            for name, now in held[0].items():
                signals[name] = cleaners[name].clean(now, found[0][name] if found else None)
                if not fix:
                    signals[name] = replace(signals[name], time_ns=now.time_ns, values=now.raw)
            yield signals, held[1]
        held = found
