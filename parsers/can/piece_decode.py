"""Pieces of a CAN log to chunks of decoded signals: what each core does."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from parsers.allocator import Slab, room_of
from parsers.can.decode import Payloads, codes_of, decode_signal, last_byte, raw_values, short
from parsers.can.groups import Group
from parsers.can.plain import PlainColumns, PlainGroups
from parsers.can.spread import Piece, spread
from parsers.can.whole import Columns, Places
from parsers.channels import Chunk, FloatArray, IntArray

VALUES = 1 << 21
"""About how many values a chunk has at the most."""


@dataclass(frozen=True)
class Cut:
    """How kept frames are parted into payloads: as the arguments of `spread` of the same names."""

    slot_words: IntArray
    part_of: IntArray
    width: Sequence[int]


@dataclass(frozen=True)
class _Target:
    """Where a piece is decoded to: the signals that are wanted, room for what has no other, and what decodes plain columns later."""

    wanted: frozenset[str]
    slab: Slab
    plain: PlainColumns


Outcome = tuple[Chunk | None, list[tuple[str, int]]]
"""A chunk, and what was left out of it: reasons and counts."""


def _size(payloads: Payloads, group: Group, wanted: frozenset[str]) -> int:
    """The bytes of a group's chunks out of a batch: stamps and values."""
    return room_of(8 * payloads.length.size) * (1 + sum(name in wanted for name in group.signals))


def _decoded(
    payloads: Payloads,
    group: Group,
    into: Columns | None,
    to: _Target,
) -> Iterator[Outcome]:
    """The chunks of one group out of a batch of its stream's payloads; plain columns are only noted."""
    step = max(VALUES // len(group.signals), 4096)
    for begin in range(0, payloads.length.size, step):
        part, columns = payloads, into
        if payloads.length.size > step:
            rows = slice(begin, begin + step)
            part = payloads.rows(rows)
            columns = {name: values[rows] for name, values in into.items()} if into is not None else None
        yield _chunk(part, group, columns, to)


def _chunk(
    payloads: Payloads,
    group: Group,
    into: Columns | None,
    to: _Target,
) -> Outcome:
    """One chunk. into: where its values go; without, values and stamps go into the slab."""
    stream = group.stream
    rejected: list[tuple[str, int]] = []
    too_short = f"{stream.message.name}: frame shorter than the DBC says"
    for gate in group.gates:
        missing = short(payloads, [gate.field])
        rejected.append((too_short, int(np.count_nonzero(missing))))
        passes = np.isin(raw_values(payloads, gate.field), np.array(gate.values, np.uint64)) & ~missing
        payloads = payloads.rows(np.flatnonzero(passes))
    if payloads.length.size == 0:
        return None, rejected
    signals = {name: signal for name, signal in group.signals.items() if name in to.wanted}
    columns: dict[str, FloatArray] = {}
    for name, signal in signals.items():
        values = to.slab.empty(payloads.length.size, np.float64) if into is None else into[name]
        columns[name] = values
        codes = codes_of(signal, j1939=stream.special_codes, proprietary=stream.proprietary)
        if to.plain.take(payloads, signal, values, codes=bool(codes)):
            continue
        got = decode_signal(
            payloads, signal, values, j1939=stream.special_codes, proprietary=stream.proprietary
        )
        rejected += [
            (f"{name}: not available", got.not_available),
            (f"{name}: error indicator", got.errors),
            (f"{name}: reserved code", got.reserved),
            (f"{name}: invalid by the database's value table", got.invalid),
        ]
    fields = [signal.field for signal in signals.values()]
    if payloads.shortest <= last_byte(fields):
        rejected.append((too_short, int(np.count_nonzero(short(payloads, fields)))))
    time_ns = payloads.time_ns
    if into is None:
        # a copy, lest a few rows of a slow message keep the stamps of all in memory
        time_ns = to.slab.empty(payloads.length.size, np.int64)
        time_ns[:] = payloads.time_ns
    return Chunk(group.name, time_ns, columns, own=True), rejected


@dataclass(frozen=True)
class PieceDecoder:
    """Decodes pieces, each by itself, on any thread. parts: of each group the part of a piece that it is made of. plain: of groups
    in whole columns."""

    groups: Sequence[Group]
    parts: Sequence[int]
    wanted: frozenset[str]
    cut: Cut
    plain: PlainGroups | None

    def __call__(self, item: tuple[Piece, Places]) -> list[Outcome]:
        """The chunks of a piece, written to their places."""
        piece, into = item
        cut = self.cut
        payloads = spread(piece, cut.slot_words, cut.part_of, cut.width, into.stamps, into.stamps_at)
        done: frozenset[int] = frozenset()
        if self.plain is not None and into.rows_at is not None:
            done = self.plain.decode(payloads, into.rows_at)
        parcels = [
            (payloads[part], group, columns)
            for part, group, columns in zip(self.parts, self.groups, into.columns, strict=True)
        ]
        slab = Slab(sum(_size(of, group, self.wanted) for of, group, columns in parcels if columns is None))
        to = _Target(self.wanted, slab, PlainColumns(into.slab or slab))
        outcomes: list[Outcome] = []
        for number, (of, group, columns) in enumerate(parcels):
            if number not in done or columns is None:
                outcomes += _decoded(of, group, columns, to)
            elif of.length.size:
                outcomes.append((Chunk(group.name, of.time_ns, columns, own=True), []))
        to.plain.decode()
        return outcomes
