"""Messages of an MCAP file, span by span, and the batches in which they are decoded."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from parsers.channels import IntArray
from parsers.importer import ImportLog
from parsers.mcap_chunks import ChunkSpan, DamagedError, McapFile, Span, load_chunk
from parsers.mcap_records import WALK_CUT, WALK_INVALID, Messages, Walker, find_messages
from parsers.mcap_survey import damage
from parsers.mcap_toplevel import TopLevel

BATCH_BYTES = 4 << 20
BATCH_ROWS = 1 << 16
CHANNEL_IDS = 1 << 16
_TOO_SHORT = "message record too short for its own head"


def messages_in(file: McapFile, span: Span, keep: frozenset[int], log: ImportLog) -> Iterator[Messages]:
    """All messages of a span, some at a time; large ones outside of chunks only where their channel is in `keep`.

    A damaged chunk gives none, and is written down in the log book.
    """
    if not isinstance(span, ChunkSpan):
        top = TopLevel(file, span.offset, span.end)
        for window in top.windows(keep):
            messages, short = find_messages(window.data, window.records)
            log.reject(_TOO_SHORT, short)
            yield messages
        if top.broken:
            log.worsen("malformed", f"at byte {top.at} {top.broken}")
        return
    try:
        data = load_chunk(file, span)
    except DamagedError as error:
        damage(log, span, error)
        return
    walker = Walker()
    for records in walker.walk(data):
        messages, short = find_messages(data, records)
        log.reject(_TOO_SHORT, short)
        yield messages
    if span.whole and walker.state in (WALK_CUT, WALK_INVALID):
        log.worsen(
            "malformed",
            f"the chunk at byte {span.offset} is damaged from its byte {walker.at} on (of {data.size}): "
            "what stands behind was left out",
        )


def holds(span: Span, keep: frozenset[int]) -> bool:
    """Whether a span may hold messages of these channels."""
    return not isinstance(span, ChunkSpan) or span.channels is None or not span.channels.isdisjoint(keep)


class Batcher:
    """Sorts messages by topic and holds them until there are enough to decode at once.

    topics: the channel ids of each topic. Payloads are copied out of large buffers, so that not more than a batch
    a topic stays in memory.
    """

    def __init__(self, topics: Sequence[Iterable[int]]) -> None:
        self._slot = np.full(CHANNEL_IDS, -1, dtype=np.int64)
        for number, ids in enumerate(topics):
            self._slot[list(ids)] = number
        self._held: list[list[Messages]] = [[] for _ in topics]
        self._bytes = [0] * len(topics)
        self._rows = [0] * len(topics)

    def add(self, messages: Messages) -> Iterator[tuple[int, Messages]]:
        """Take messages in; yields (topic, its messages) for the topics that have enough."""
        slot = self._slot[messages.channel & (CHANNEL_IDS - 1)]
        rows = np.flatnonzero((slot >= 0) & (messages.channel >= 0))
        rows = rows[np.argsort(slot[rows], kind="stable")]
        numbers, first = np.unique(slot[rows], return_index=True)
        for number, part in zip(numbers.tolist(), np.split(rows, first[1:]), strict=False):
            yield from self._add_topic(int(number), messages.take(part))

    def _add_topic(self, number: int, messages: Messages) -> Iterator[tuple[int, Messages]]:
        size = int(messages.length.sum())
        if not self._held[number] and (size >= BATCH_BYTES or messages.length.size >= BATCH_ROWS):
            yield number, messages
            return
        self._held[number].append(messages.packed())
        self._bytes[number] += size
        self._rows[number] += messages.length.size
        if self._bytes[number] >= BATCH_BYTES or self._rows[number] >= BATCH_ROWS:
            yield number, self._take(number)

    def rest(self) -> Iterator[tuple[int, Messages]]:
        """What is still held, at the end."""
        for number, held in enumerate(self._held):
            if held:
                yield number, self._take(number)

    def _take(self, number: int) -> Messages:
        held, self._held[number] = self._held[number], []
        self._bytes[number] = self._rows[number] = 0
        return join(held)


def join(parts: Sequence[Messages]) -> Messages:
    """Packed messages behind one another, in one buffer."""
    if len(parts) == 1:
        return parts[0]
    starts = np.cumsum([0] + [part.data.size for part in parts[:-1]])
    offset: list[IntArray] = [part.offset + start for part, start in zip(parts, starts.tolist(), strict=True)]
    return Messages(
        np.concatenate([part.data for part in parts]),
        np.concatenate([part.channel for part in parts]),
        np.concatenate([part.log_ns for part in parts]),
        np.concatenate([part.publish_ns for part in parts]),
        np.concatenate(offset),
        np.concatenate([part.length for part in parts]),
    )
