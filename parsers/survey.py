"""A log whose rows lie on disk: which of its channels become signals, and what these are as a whole."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from parsers.axle_sums import RowPiece, with_axle_sums
from parsers.bound_signals import MIN_SAMPLES, given, group_of, is_stated, mapped_channel, refused
from parsers.channels import FloatArray, IntArray
from parsers.other_units import Spare, spare_of
from parsers.read_log import PartFacts, Taken, leave_out_beyond_jumps
from parsers.spool import GroupRows, GroupWriter
from parsers.time_figures import SharedFigures
from parsers.timebase import NS
from parsers.velocity_frames import with_frames
from parsers.windows import Track, TrackFacts, bound_piece, time_windows, windows_of

_ITEM = 8
_NONE = TrackFacts(0, 0, 0, 0.0, np.inf, -np.inf, 0.0)


@dataclass(frozen=True)
class SpooledPart(PartFacts):
    """One log, read: its signals as tracks. resolution_ns: to how much their usual steps are known."""

    tracks: Mapping[str, Track] = field(default_factory=dict)
    resolution_ns: int = 1


@dataclass
class _Values:
    """Extremes of values that come in order."""

    low: float = np.inf
    high: float = -np.inf
    steepest: float = 0.0
    last: float = np.nan

    def add(self, values: FloatArray) -> None:
        if len(values) == 0:
            return
        self.low, self.high = min(self.low, float(values.min())), max(self.high, float(values.max()))
        steps = [self.steepest, abs(float(values[0]) - self.last) if np.isfinite(self.last) else 0.0]
        if len(values) > 1:
            change = np.diff(values)
            steps += [float(change.max()), -float(change.min())]
        self.steepest, self.last = max(steps), float(values[-1])


def survey_part(taken: Taken, window_bytes: int) -> SpooledPart:
    """Go once through a log's rows on disk."""
    infos, groups = taken.infos, taken.rows.spooled()
    leave_out_beyond_jumps(taken.opened.log, sum(rows.lost for rows in groups.values()))
    logged = list(groups.values())
    stored = _SpooledRows(groups, window_bytes)
    framed = with_frames(taken.proposals, infos, stored, taken.opened.log)
    proposals = with_axle_sums(framed, infos, stored, taken.opened.log)
    bindings: dict[str, list[Track]] = {}
    for binding in (each for proposed in proposals.values() for each in proposed):
        group = group_of(binding, infos)
        rows = groups.get(group)
        if rows is not None and all(name in rows.columns for name in binding.channels):
            bindings.setdefault(group, []).append(Track(binding, group, rows, _NONE, window_bytes))
    duplicates, resolution = 0, 1
    facts: dict[int, TrackFacts] = {}
    for group, tracks in bindings.items():
        unique, coarse = _survey_group(groups[group], tracks, window_bytes, facts)
        duplicates += groups[group].rows - unique
        resolution = max(resolution, coarse)
    tracks_of: dict[str, Track] = {}
    mapped = []
    spares: dict[str, Spare[Track]] = {}
    group_by_channel = {name: info.group for name, info in infos.items()}
    for name, proposed in proposals.items():
        for binding in proposed:
            found = facts.get(id(binding), _NONE)
            taken.opened.log.reject(refused(binding), found.refused)
            if found.samples >= MIN_SAMPLES:
                group = group_of(binding, infos)
                tracks_of[name] = Track(binding, group, groups[group], found, window_bytes)
                mapped.append(mapped_channel(binding, found.samples, found.period_s, proposed))
                other = spare_of(name, binding, proposed, group_by_channel)
                known = _NONE if other is None else facts.get(id(other), _NONE)
                if other is not None and known.samples >= MIN_SAMPLES:
                    group = group_of(other, infos)
                    track = Track(other, group, groups[group], known, window_bytes)
                    entry = mapped_channel(other, known.samples, known.period_s, proposed)
                    spares[name] = Spare(track, entry, is_stated(other), other.unit.scale)
                break
    return SpooledPart(
        opened=taken.opened,
        mapped=tuple(mapped),
        stated={name: is_stated(track.binding) for name, track in tracks_of.items()},
        taken={name: track.binding.unit.scale for name, track in tracks_of.items()},
        short=tuple(name for name in proposals if name not in tracks_of),
        spares=spares,
        out_of_order=sum(rows.late for rows in logged),
        duplicates=duplicates,
        jumps=sum(rows.jumps for rows in logged),
        tracks=tracks_of,
        resolution_ns=resolution,
    )


@dataclass(frozen=True)
class _SpooledRows:
    """Rows on disk, for `with_axle_sums`."""

    groups: dict[str, GroupRows]
    window_bytes: int

    def pieces(self, group: str, columns: tuple[str, ...]) -> Iterator[RowPiece]:
        rows = self.groups.get(group)
        if rows is None or any(column not in rows.columns for column in columns):
            return
        for start, stop in windows_of([(rows, _ITEM * (1 + len(columns)))], self.window_bytes):
            yield rows.load(start, stop, columns)

    def logged(self, group: str) -> int:
        rows = self.groups.get(group)
        return 0 if rows is None else rows.rows

    def keep(self, group: str, column: str, parts: Iterator[tuple[IntArray, FloatArray]]) -> None:
        spool = next(rows.spool for rows in self.groups.values())
        writer = GroupWriter(spool, (column,))
        for time_ns, values in parts:
            writer.add(time_ns, {column: values})
            writer.flush()
        rows = writer.finish()
        if len(rows.index.rows):
            self.groups[group] = rows


def _survey_group(
    rows: GroupRows, tracks: list[Track], window_bytes: int, facts: dict[int, TrackFacts]
) -> tuple[int, int]:
    """Write down the facts of each binding (by identity); the number of rows with different stamps, the resolution."""
    names = sorted({name for track in tracks for name in track.binding.needed})
    times = SharedFigures({str(number): None for number in range(len(tracks))})
    values = [_Values() for _ in tracks]
    offered = [0] * len(tracks)
    unique = 0
    for start, stop in time_windows(tracks, window_bytes):
        time_ns, columns = rows.load(start, stop, names)
        unique += len(time_ns)
        pieces = [bound_piece(track, time_ns, columns) for track in tracks]
        times.add(time_ns, {str(number): stamps for number, (stamps, _) in enumerate(pieces)})
        for number, (_, piece) in enumerate(pieces):
            values[number].add(piece)
            offered[number] += given(tracks[number].binding, columns)
    resolution = 1
    for number, (track, held) in enumerate(zip(tracks, values, strict=True)):
        time = times.of(str(number))
        facts[id(track.binding)] = TrackFacts(
            time.samples,
            time.first,
            time.last,
            time.median_ns / NS,
            held.low,
            held.high,
            held.steepest,
            refused=max(offered[number] - time.samples, 0),
        )
        if time.samples:
            resolution = max(resolution, time.resolution_ns)
    return unique, resolution
