"""A drive that lies on disk, in windows of time: cut so that each holds about as much, and loaded signal by signal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from parsers.bound_signals import source_text
from parsers.channels import FloatArray, IntArray
from parsers.drive import Signal
from parsers.mapping import Binding, bind
from parsers.pieces import Span
from parsers.spool import GroupRows

_ITEM = 8


@dataclass(frozen=True)
class TrackFacts:
    """What is known of a track as a whole. samples: valid ones; first, last: their stamps; period_s: the usual step, 0 for
    one sample; low, high: values; steepest: the largest step between two samples that follow one another. refused: numbers
    that were not taken."""

    samples: int
    first: int
    last: int
    period_s: float
    low: float
    high: float
    steepest: float
    refused: int = 0


@dataclass(frozen=True, eq=False)
class Track:
    """What one log has of a signal. cut: spans that another log covers, which are left out."""

    binding: Binding
    group: str
    rows: GroupRows
    facts: TrackFacts
    window_bytes: int
    cut: tuple[Span, ...] = ()

    @property
    def span(self) -> Span:
        """First and last stamp."""
        return self.facts.first, self.facts.last

    @property
    def samples(self) -> int:
        """How many samples are valid."""
        return self.facts.samples

    @property
    def source(self) -> str:
        """The channels."""
        return source_text(self.binding)

    @property
    def signal(self) -> Signal:
        """The signal without samples."""
        none = np.zeros(0, dtype=np.int64)
        return Signal(self.binding.signal, none, np.zeros(0), self.source, group=self.group)

    def load(self, start: int, stop: int) -> tuple[IntArray, FloatArray]:
        """Stamps and values in [start, stop), (n,) each."""
        return load_window([self], start, stop).pieces[0]

    def outside(self, spans: Sequence[Span]) -> Track | None:
        """The samples that lie in none of the spans; None where there are none."""
        first, last = self.span
        if all(b < first or a > last for a, b in spans):
            return self
        cut = replace(self, cut=(*self.cut, *spans))
        samples, starts, ends = 0, [], []
        for start, stop in time_windows([self], self.window_bytes):
            time_ns = load_window([cut], start, stop).pieces[0][0]
            if len(time_ns):
                samples += len(time_ns)
                starts.append(int(time_ns[0]))
                ends.append(int(time_ns[-1]))
        if not samples:
            return None
        return replace(cut, facts=replace(self.facts, samples=samples, first=starts[0], last=ends[-1]))


def shifted_tracks(tracks: Mapping[str, Track], by_ns: int) -> dict[str, Track]:
    """A log's tracks with later stamps; those of one group go on sharing its rows."""
    rows = {id(track.rows): track.rows for track in tracks.values()}
    later = {key: each.shifted(by_ns) for key, each in rows.items()}
    return {
        name: replace(
            track,
            rows=later[id(track.rows)],
            facts=replace(track.facts, first=track.facts.first + by_ns, last=track.facts.last + by_ns),
        )
        for name, track in tracks.items()
    }


def time_windows(tracks: Sequence[Track], most: int) -> list[Span]:
    """Windows [start, stop) over all that the tracks' groups hold, each of about `most` bytes as far as blocks tell."""
    widths: dict[int, int] = {}
    for track in tracks:
        widths[id(track.rows)] = widths.get(id(track.rows), _ITEM) + _ITEM * len(track.binding.needed)
    return windows_of(
        [(rows, widths[key]) for key, rows in {id(t.rows): t.rows for t in tracks}.items()], most
    )


def windows_of(groups: Sequence[tuple[GroupRows, int]], most: int) -> list[Span]:
    """Windows over groups, each given with the bytes of one of its rows. Inside a block rows are taken as evenly spread."""
    low = np.concatenate([rows.index.low for rows, _ in groups])
    high = np.concatenate([rows.index.high for rows, _ in groups]) + 1
    size = np.concatenate([rows.index.rows * width for rows, width in groups]).astype(np.float64)
    start, stop = int(low.min()), int(high.max())
    count = max(1, math.ceil(float(size.sum()) / most))
    if count == 1:
        return [(start, stop)]
    # how many bytes there are up to any moment: a line that bends where blocks begin and end
    begins, ends = (low - start).astype(np.float64), (high - start).astype(np.float64)
    slope = size / np.maximum(ends - begins, 1.0)
    bends = np.concatenate([begins, ends])
    order = np.argsort(bends, kind="stable")
    rise = np.cumsum(np.concatenate([slope, -slope])[order])
    bends = bends[order]
    upto = np.concatenate([[0.0], np.cumsum(rise[:-1] * np.diff(bends))])
    wanted = np.linspace(0, upto[-1], count + 1)[1:-1]
    inner = np.interp(wanted, np.maximum.accumulate(upto), bends).astype(np.int64) + start
    edges = np.unique(np.concatenate([[start], np.clip(inner, start, stop), [stop]])).tolist()
    return list(pairwise(edges))


@dataclass(frozen=True)
class Window:
    """pieces: of each track its stamps and values, (n,) each, finite values only. base: the stamps of the first track's
    group; tracks whose every row has a value share it."""

    pieces: list[tuple[IntArray, FloatArray]]
    base: IntArray


def load_window(tracks: Sequence[Track], start: int, stop: int) -> Window:
    """What the tracks hold in [start, stop)."""
    needed: dict[int, dict[str, None]] = {}
    for track in tracks:
        needed.setdefault(id(track.rows), {}).update(dict.fromkeys(track.binding.needed))
    groups = {id(track.rows): track.rows for track in tracks}
    loaded = {key: rows.load(start, stop, list(needed[key])) for key, rows in groups.items()}
    pieces = [bound_piece(track, *loaded[id(track.rows)]) for track in tracks]
    return Window(pieces, loaded[id(tracks[0].rows)][0])


def bound_piece(
    track: Track, time_ns: IntArray, columns: Mapping[str, FloatArray]
) -> tuple[IntArray, FloatArray]:
    """A track's samples out of rows of its group."""
    values = bind(track.binding, columns)
    valid = np.isfinite(values)
    for a, b in track.cut:
        valid &= (time_ns < a) | (time_ns > b)
    return (time_ns, values) if valid.all() else (time_ns[valid], values[valid])
