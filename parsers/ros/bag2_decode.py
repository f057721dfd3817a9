"""Messages in bulk to columns, topic by topic: the part of reading a ROS 2 bag that threads share."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from parsers.channels import ByteArray, Chunk, IntArray
from parsers.importer import ImportLog
from parsers.ros.bag2_messages import unpack_messages
from parsers.ros.bag2_rows import Rows
from parsers.ros.contract import Cells, Decoded
from parsers.ros.stamps import StampChooser
from parsers.ros.topics import MAX_CELLS, Topic

Chosen = Mapping[int, tuple[Topic, tuple[str, ...]]]
"""Topic id -> the topic and the paths of its wanted fields."""


@dataclass(frozen=True)
class Piece:
    """Some messages of one topic, decoded. receive_ns: (n,)."""

    topic: Topic
    decoded: Decoded
    receive_ns: IntArray


@dataclass(frozen=True)
class Outcome:
    """What became of a batch of messages; it refers to nothing of the buffer that they were in.

    span_ns: receive times of its first and last message. lost_before, lost_after: something next to it could not be
    read; lost_inside: (before, after) of what could not be read in the middle of it. overflow: pages of chains read.
    """

    pieces: tuple[Piece, ...]
    rejected: Mapping[str, int]
    span_ns: tuple[int, int] | None
    lost_before: bool = False
    lost_after: bool = False
    lost_inside: tuple[tuple[int, int], ...] = ()
    overflow: int = 0


def decode_rows(rows: Rows, chosen: Chosen) -> Outcome:
    """Decode a batch of messages. Touches nothing that another thread might."""
    log = ImportLog()
    pieces = tuple(piece for plain in unpack_messages(rows, log) for piece in _decode(plain, chosen))
    span = (int(rows.time_ns[0]), int(rows.time_ns[-1])) if len(rows.time_ns) else None
    return Outcome(pieces, log.rejected, span, lost_before=rows.lost)


def _decode(rows: Rows, chosen: Chosen) -> Iterator[Piece]:
    for number, wanted in chosen.items():
        at = np.flatnonzero(rows.topic_id == number)
        yield from decode_topic(wanted, rows.data, rows.time_ns[at], rows.offset[at], rows.length[at])


def decode_topic(
    wanted: tuple[Topic, tuple[str, ...]],
    data: ByteArray,
    time_ns: IntArray,
    offset: IntArray,
    length: IntArray,
    cells: Cells = np.empty,
) -> Iterator[Piece]:
    """Decode messages of one topic, at most MAX_CELLS numbers at a time; time_ns, offset, length: (n,).

    cells: gives the columns' memory.
    """
    topic, paths = wanted
    most = max(1, MAX_CELLS // max(1, len(paths)))
    for start in range(0, len(offset), most):
        part = slice(start, start + most)
        decoded = topic.decoder.decode(data, offset[part], length[part], paths, cells)
        yield Piece(topic, decoded, time_ns[part])


@dataclass
class Collector:
    """Outcomes, in the order of the log, to chunks; what was met on the way goes into the log book."""

    chooser: StampChooser
    log: ImportLog
    last_ns: int | None = None
    lost: bool = field(default=False)

    def chunks(self, outcome: Outcome) -> Iterator[Chunk]:
        """The chunks of a batch."""
        for reason, count in outcome.rejected.items():
            self.log.reject(reason, count)
        self.lost = self.lost or outcome.lost_before
        if outcome.span_ns is not None:
            if self.lost and self.last_ns is not None:
                self.log.lost_spans_ns.append((self.last_ns, outcome.span_ns[0]))
            self.log.lost_spans_ns.extend(outcome.lost_inside)
            self.lost, self.last_ns = False, outcome.span_ns[1]
        self.lost = self.lost or outcome.lost_after
        for piece in outcome.pieces:
            yield self._chunk(piece)

    def _chunk(self, piece: Piece) -> Chunk:
        group, decoded = piece.topic.group, piece.decoded
        self.log.messages += len(piece.receive_ns)
        self.log.reject(decoded.why_bad, decoded.bad)
        time_ns = self.chooser.choose(group, decoded.stamp_ns, piece.receive_ns, unread=decoded.bad)
        return Chunk(group, time_ns, {f"{group}.{path}": x for path, x in decoded.columns.items()})
