"""Containers of a BLF file in groups: read in large pieces, inflated on all cores, walked in their order.

Fresh memory costs more than inflating into it, so that the buffers of a group are used again.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from io import FileIO
from pathlib import Path

import numpy as np

from parsers.allocator import Slab
from parsers.blf_containers import (
    HEAD_SIZE,
    OBJECT_SIZE,
    ZLIB,
    BlfHeader,
    Container,
    can_hold,
    container_at,
    content_of,
    odd_blocks,
)
from parsers.blf_walk import BEHIND, COLUMNS_BYTES, FRONT, Block, Columns, block_of
from parsers.blf_walker import Guess, guess
from parsers.channels import ByteArray
from parsers.inflate import inflate_all
from parsers.parallel import in_order

READ_BYTES = 2 << 20
"""Bytes of the file that are read at a time."""
GROUP_BYTES = 2 << 20
"""Inflated bytes that a core takes at a time: enough that threads seldom wait for each other, and no more."""


@dataclass(frozen=True)
class _Room:
    """Where a group's content goes, and its frames."""

    content: ByteArray
    columns: Columns


_CONTENT_BYTES = FRONT + GROUP_BYTES + BEHIND
_ROOMS = 4
"""Rooms that are made at a time."""


@dataclass
class _Pool:
    """Buffers that nobody uses at the moment. Only the caller's thread takes and gives."""

    raw: list[bytearray] = field(default_factory=list)
    room: list[_Room] = field(default_factory=list)

    def take_raw(self) -> bytearray:
        return self.raw.pop() if self.raw else bytearray(READ_BYTES)

    def take_room(self) -> _Room:
        if not self.room:
            slab = Slab(_ROOMS * (_CONTENT_BYTES + COLUMNS_BYTES))
            self.room += [
                _Room(slab.empty(_CONTENT_BYTES, np.uint8), Columns.of(slab)) for _ in range(_ROOMS)
            ]
        return self.room.pop()


@dataclass(frozen=True)
class _Group:
    """Containers that follow each other. raw: the file from byte `start` on. last: no other group has its containers
    there. start_ns: of the measurement."""

    start: int
    raw: bytearray
    containers: list[Container]
    room: _Room
    last: bool
    start_ns: int


def _walked(work: _Group | Block) -> tuple[_Group | Block, list[tuple[Block, Guess | None]]]:
    """The blocks of a group of containers, the first of them walked."""
    if isinstance(work, Block):
        return work, [(work, None)]
    found = _whole(work) or _inflated(work)
    ahead = guess(found[0], work.start_ns, work.room.columns) if found else None
    return work, [(block, ahead if number == 0 else None) for number, block in enumerate(found)]


def _whole(work: _Group) -> list[Block]:
    """The contents of a group of containers as one block; none where not all of them are as they should be."""
    found, content = work.containers, work.room.content
    at, size, rooms = np.array([(each.at, each.size, each.claimed) for each in found], np.int64).T.copy()
    ends = FRONT + np.cumsum(rooms)
    usual = all(each.method == ZLIB and can_hold(each.size - HEAD_SIZE, each.claimed) for each in found)
    if not usual or ends[-1] > content.size - BEHIND:
        return []
    raw = np.frombuffer(work.raw, np.uint8)
    whole = inflate_all(raw, at - work.start + HEAD_SIZE, size - HEAD_SIZE, content, ends - rooms, rooms)
    if whole is None or not whole.all():
        return []
    first, last = found[0], found[-1]
    return [Block("container", first.at, last.at + last.size - first.at, content, FRONT, int(ends[-1]))]


def _inflated(work: _Group) -> list[Block]:
    """The contents of a group of containers, one by one: as few blocks as there can be, in order."""
    blocks: list[Block] = []
    raw, room = memoryview(work.raw), work.room.content
    begin = at = FRONT
    first, until = 0, 0

    def close() -> None:
        if at > begin:
            blocks.append(Block("container", first, until - first, room, begin, at))

    for found in work.containers:
        payload = raw[found.at - work.start + HEAD_SIZE : found.at - work.start + found.size]
        content, whole = content_of(found.method, found.claimed, payload)
        size = len(content)
        if whole and at + size <= room.size - BEHIND:
            if at == begin:
                first = found.at
            room[at : at + size] = np.frombuffer(content, np.uint8)
            at, until = at + size, found.at + found.size
            continue
        close()
        begin = at
        kind = "container" if whole else "damaged"
        blocks.append(block_of(kind, found.at, found.size, content if whole else b""))
    close()
    return blocks


def _usual_containers(raw: bytearray, filled: int, position: int, total: int) -> list[Container]:
    """The whole containers in raw[:filled], which is the file from `position` on, up to the first unusual thing."""
    found: list[Container] = []
    place = 0
    while True:
        # writers pad to a multiple of four, in one way or another
        mark = raw.find(b"LOBJ", place, min(place + 12, filled))
        if mark < 0 or mark + HEAD_SIZE > filled:
            return found
        container = container_at(raw, mark, position + mark)
        if container is None or mark + container.size > filled or container.at + container.size > total:
            return found
        found.append(container)
        place = mark + container.size


def _grouped(containers: Iterable[Container]) -> Iterator[list[Container]]:
    """Containers whose contents fit into one room together; one that is too large for it is alone."""
    group: list[Container] = []
    size = 0
    for container in containers:
        grows = container.claimed if container.method == ZLIB else container.size
        if group and size + grows > GROUP_BYTES:
            yield group
            group, size = [], 0
        group.append(container)
        size += grows
    if group:
        yield group


def _work(file: FileIO, header: BlfHeader, total: int, pool: _Pool) -> Iterator[_Group | Block]:
    """The file in order: groups of usual containers, and blocks where there is something else."""
    position = header.size
    while position + OBJECT_SIZE <= total:
        raw = pool.take_raw()
        file.seek(position)
        filled = file.readinto(raw) or 0
        groups = list(_grouped(_usual_containers(raw, filled, position, total)))
        start = position
        for number, group in enumerate(groups):
            position = group[-1].at + group[-1].size
            yield _Group(start, raw, group, pool.take_room(), number == len(groups) - 1, header.start_ns or 0)
        if not groups:
            pool.raw.append(raw)
            for block in odd_blocks(file, position, total):
                position = block.position + block.size
                yield block
    if 0 < total - position < OBJECT_SIZE:
        file.seek(position)
        if any(file.read()):
            yield block_of("cut", position, total - position)


def blocks(path: Path, header: BlfHeader) -> Iterator[tuple[Block, Guess | None]]:
    """The file's blocks in order, some of them walked ahead of their turn; each is good until the next is asked for.

    Every step moves on in the file, so that none is read for ever.
    """
    pool = _Pool()
    total = path.stat().st_size
    with path.open("rb", buffering=0) as file:
        for work, found in in_order(_walked, _work(file, header, total, pool)):
            yield from found
            if isinstance(work, _Group):
                pool.room.append(work.room)
                if work.last:
                    pool.raw.append(work.raw)
