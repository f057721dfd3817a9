"""Uncompressed chunks with large messages that nobody asked for, pictures for example: these are stepped over."""

from __future__ import annotations

import deflate

from parsers.mcap_chunks import ChunkSpan, DamagedError, McapFile, Scratch, read_chunk_head
from parsers.mcap_pick import Picker
from parsers.mcap_records import MESSAGE, MESSAGE_HEAD, RECORD_HEAD, WALK_CUT

SPARSE_BYTES = 1 << 18
"""Smaller chunks are read whole."""
FIRST_WINDOW, LAST_WINDOW = 1 << 13, 1 << 18


def may_skip(span: ChunkSpan, keep: frozenset[int]) -> bool:
    """Whether a chunk is large and has messages of other channels too."""
    return (
        span.whole and span.length >= SPARSE_BYTES and span.channels is not None and not span.channels <= keep
    )


def pick_sparsely(
    file: McapFile, span: ChunkSpan, keep: frozenset[int], scratch: Scratch, picker: Picker
) -> tuple[int, int, int, int] | None:
    """Pick the messages of the channels in `keep` from an uncompressed chunk, stepping over large other records.

    None where the chunk is compressed. Else where and why the walk stopped, how many records were too short, and the
    size of the chunk's records. The checksum can tell nothing where something was stepped over. Raises DamagedError.
    """
    head, length = read_chunk_head(file, span.offset)
    if head.compression:
        return None
    if length != span.length or head.records_length != head.uncompressed_size:
        raise DamagedError(f"its record is {length} bytes long, the index says {span.length}")
    first = span.offset + RECORD_HEAD + head.records_at
    if first + head.records_length > file.size:
        raise DamagedError("the file ends inside it")
    at, end = first, first + head.records_length
    began, mark, short, size, skipped, state = scratch.used, picker.mark(), 0, FIRST_WINDOW, 0, 0
    while at < end:
        room = scratch.room(min(size, end - at))
        got = file.fill(at, room)
        start = scratch.used
        stop, state, too_short = picker.walk(scratch.records, start, start + got)
        short += too_short
        scratch.used = stop
        at += stop - start
        if at >= end or state != WALK_CUT:
            break
        size = min(2 * size, LAST_WINDOW)
        record = file.bytes(at, RECORD_HEAD + MESSAGE_HEAD)
        whole = RECORD_HEAD + int.from_bytes(record[1:RECORD_HEAD], "little")
        if whole > end - at:
            break
        if whole > size and not _is_wanted(record, keep):
            at, skipped, size = at + whole, skipped + whole, FIRST_WINDOW
            state = 0
        else:
            size = max(size, whole)
    if not skipped and head.crc and at >= end and _checksum(scratch, began) != head.crc:
        picker.rewind(mark)
        scratch.used = began
        raise DamagedError("its checksum is wrong")
    return at - first, state, short, head.records_length


def _is_wanted(record: bytes, keep: frozenset[int]) -> bool:
    return record[0] == MESSAGE and int.from_bytes(record[RECORD_HEAD : RECORD_HEAD + 2], "little") in keep


def _checksum(scratch: Scratch, began: int) -> int:
    return int(deflate.crc32(scratch.records[began : scratch.used].data))
