"""The reader that all CAN formats share: frames and databases in, channels and decoded chunks out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from parsers.can.coalesce import coalesced
from parsers.can.database import builtin_j1939, load_databases
from parsers.can.decode import decode_signal, frame_keys, raw_values, rows_by_slot
from parsers.can.definitions import Gate, SignalDef
from parsers.can.frames import EXTENDED, CanFrames, FrameSource
from parsers.can.matching import Stream, explain_no_match, match_streams, note_unknown
from parsers.channels import ChannelInfo, Chunk, FloatArray, IntArray
from parsers.importer import ImportLog, ReadOptions


@dataclass(frozen=True)
class _Group:
    """Signals of a stream that are in the same frames: channel name -> definition."""

    name: str
    stream: Stream
    gates: tuple[Gate, ...]
    signals: dict[str, SignalDef]


class CanReader:
    """A `LogReader` over the frames of any CAN format.

    On opening it loads the databases and looks once through the log for the identifiers in it; `read` goes through
    the log a second time. Raises DatabaseError where a database cannot be used; where no channel can be made of the
    frames, `channels` is empty and the log book says why.
    """

    def __init__(self, source: FrameSource, options: ReadOptions, log: ImportLog, path: Path) -> None:
        self._source = source
        self._log = log
        self._path = path
        given = load_databases(options.dbc, log)
        seen = count_ids(source)
        # the second database is needed only where 29-bit ids are about
        extended = any(key & EXTENDED for key in seen)
        streams = match_streams(seen, given, builtin_j1939(log) if extended else (), log)
        if streams:
            note_unknown(seen, streams, log)
        else:
            explain_no_match(seen, given, log)
        self._groups = tuple(group for stream in streams for group in _groups(stream))
        self._channels = tuple(
            _channel(group, name, signal) for group in self._groups for name, signal in group.signals.items()
        )

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """Signals of all messages that are in the log, in the order of the databases."""
        return self._channels

    @property
    def clock(self) -> str:
        """As the format has it."""
        return self._source.clock

    @property
    def absolute(self) -> bool:
        """As the format has it."""
        return self._source.absolute

    @property
    def start_utc_ns(self) -> int | None:
        """As the format has it."""
        return self._source.start_utc_ns

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield decoded chunks: one a group and batch of frames."""
        groups = [group for group in self._groups if not wanted.isdisjoint(group.signals)]
        streams = list({id(group.stream): group.stream for group in groups}.values())
        slots = {id(stream): slot for slot, stream in enumerate(streams)}
        pairs = sorted((key, slot) for slot, stream in enumerate(streams) for key in stream.keys)
        keys = np.array([key for key, _ in pairs], dtype=np.int64)
        slot_of = np.array([slot for _, slot in pairs], dtype=np.int64)
        for frames in coalesced(self._source.frames(counting=True)):
            if not pairs:
                continue
            found = frame_keys(frames)
            place = np.minimum(np.searchsorted(keys, found), keys.size - 1)
            rows = rows_by_slot(np.where(keys[place] == found, slot_of[place], -1), len(streams))
            for group in groups:
                chunk = self._decode(frames, rows[slots[id(group.stream)]], group, wanted)
                if chunk is not None:
                    yield chunk

    def _decode(
        self, frames: CanFrames, rows: IntArray, group: _Group, wanted: frozenset[str]
    ) -> Chunk | None:
        too_short = f"{group.stream.message.name}: frame shorter than the DBC says"
        for gate in group.gates:
            if rows.size == 0:
                return None
            raw, short = raw_values(frames, rows, gate.field)
            self._log.reject(too_short, int(np.count_nonzero(short)))
            rows = rows[np.isin(raw, np.array(gate.values, dtype=np.uint64)) & ~short]
        if rows.size == 0:
            return None
        columns: dict[str, FloatArray] = {}
        any_short = np.zeros(rows.size, dtype=np.bool_)
        stream = group.stream
        for name, signal in group.signals.items():
            if name not in wanted:
                continue
            got = decode_signal(
                frames, rows, signal, j1939=stream.special_codes, proprietary=stream.proprietary
            )
            columns[name] = got.values
            any_short |= got.short
            self._log.reject(f"{name}: not available", got.not_available)
            self._log.reject(f"{name}: error indicator", got.errors)
            self._log.reject(f"{name}: reserved code", got.reserved)
            self._log.reject(f"{name}: invalid by the database's value table", got.invalid)
        self._log.reject(too_short, int(np.count_nonzero(any_short)))
        return Chunk(group.name, frames.time_ns[rows], columns)


def count_ids(source: FrameSource) -> Counter[int]:
    """The number of frames of each bus and id (bus * 2**32 + id) in a log, without counting into the log book."""
    seen: Counter[int] = Counter()
    for frames in coalesced(source.frames(counting=False)):
        keys, counts = np.unique(frame_keys(frames), return_counts=True)
        seen.update(dict(zip(keys.tolist(), counts.tolist(), strict=True)))
    return seen


def _groups(stream: Stream) -> list[_Group]:
    """One group for the signals in every frame, and one for each multiplexer value or set of values."""
    groups: dict[tuple[Gate, ...], _Group] = {}
    base = stream.message.name + stream.suffix
    for signal in stream.message.signals:
        group = groups.get(signal.gates)
        if group is None:
            name = "/".join([base, *(_gate_text(gate) for gate in reversed(signal.gates))])
            group = groups[signal.gates] = _Group(name, stream, signal.gates, {})
        group.signals[f"{stream.message.name}.{signal.name}{stream.suffix}"] = signal
    return list(groups.values())


def _gate_text(gate: Gate) -> str:
    """A multiplexer and its values as text, neighbours drawn together: "Mode=0-3,7"."""
    runs: list[list[int]] = []
    for value in gate.values:
        if runs and value == runs[-1][1] + 1:
            runs[-1][1] = value
        else:
            runs.append([value, value])
    return f"{gate.multiplexer}=" + ",".join(f"{a}" if a == b else f"{a}-{b}" for a, b in runs)


def _channel(group: _Group, name: str, signal: SignalDef) -> ChannelInfo:
    stream = group.stream
    # the id in the log, which for J1939 may differ from the database's
    can_id = stream.keys[0] & 0xFFFF_FFFF
    tags = {
        "message": stream.message.name,
        "signal": signal.name,
        "id": str(can_id & ~EXTENDED),
        "bus": str(stream.bus),
    }
    if can_id & EXTENDED:
        tags["extended"] = "1"
    if stream.pgn is not None and stream.sender is not None:
        tags["pgn"] = str(stream.pgn)
        tags["source_address"] = str(stream.sender)
    if signal.spn is not None:
        tags["spn"] = str(signal.spn)
    return ChannelInfo(
        name=name,
        group=group.name,
        unit=signal.unit,
        family="can",
        count=None if group.gates else stream.frames,
        comment=signal.comment,
        tags=tags,
    )
