"""Messages of an MCAP file, span by span, for looking at some of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from parsers.mcap_chunks import ChunkSpan, DamagedError, McapFile, Scratch, Span, load_chunk
from parsers.mcap_pick import Picker, slot_table
from parsers.mcap_records import Messages, Walker, find_messages
from parsers.mcap_sparse import may_skip, pick_sparsely
from parsers.mcap_toplevel import TopLevel


def messages_in(file: McapFile, span: Span, keep: frozenset[int]) -> Iterator[Messages]:
    """All messages of a span, some at a time; large ones outside of chunks only where their channel is in `keep`.

    A damaged chunk gives none. Of a large chunk that is not compressed only the messages of the channels in `keep` are read.
    """
    if not isinstance(span, ChunkSpan):
        for window in TopLevel(file, span.offset, span.end).windows(keep):
            yield find_messages(window.data, window.records)[0]
        return
    scratch = Scratch()
    if may_skip(span, keep):
        ids = sorted(keep)
        picker = Picker(slot_table([(channel,) for channel in ids]), len(ids))
        try:
            sparse = pick_sparsely(file, span, keep, scratch, picker)
        except DamagedError:
            return
        if sparse is not None:
            data = scratch.records
            for found in picker.take():
                channel = np.full(len(found.offset), ids[found.number], dtype=np.int64)
                yield Messages(data, channel, found.log_ns, found.offset, found.length)
            return
    try:
        size = load_chunk(file, span, scratch)
    except DamagedError:
        return
    data = scratch.records[:size]
    for records in Walker().walk(data):
        yield find_messages(data, records)[0]


def holds(span: Span, keep: frozenset[int]) -> bool:
    """Whether a span may hold messages of these channels."""
    return not isinstance(span, ChunkSpan) or span.channels is None or not span.channels.isdisjoint(keep)
