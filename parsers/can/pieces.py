"""A text log in pieces of whole lines, so that each can be read on its own, a block at a time, by any thread."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import FileIO
from pathlib import Path

import numpy as np

from parsers.can.blocks import LAST, walk_of
from parsers.can.words import BEHIND, FRONT
from parsers.channels import ByteArray, IntArray
from parsers.errors import LogError
from parsers.jit_foreign import descriptor_of, pread_address

PIECE_BYTES = 4 << 20
BLOCK_BYTES = 512 << 10
"""A block and what its frames take should stay in a core's own cache. Of a longer line only the beginning is looked at."""

_SEARCH_BYTES = 4096
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"


@dataclass(frozen=True)
class Piece:
    """Whole lines of a file: the bytes [begin, end). last: no piece follows, and the last line may lack its feed."""

    begin: int
    end: int
    last: bool


def pieces(path: Path, size: int | None = None) -> Iterator[Piece]:
    """A file in pieces of `size` bytes and the rest of a line; without a byte order mark. Raises LogError."""
    size = size or PIECE_BYTES
    try:
        with path.open("rb", buffering=0) as file:
            total = file.seek(0, 2)
            file.seek(0)
            begin = len(_BYTE_ORDER_MARK) if file.read(len(_BYTE_ORDER_MARK)) == _BYTE_ORDER_MARK else 0
            while begin < total:
                end = _after_feed(file, begin + size - 1, total)
                yield Piece(begin, end, last=end == total)
                begin = end
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error


def tail_of(path: Path, size: int) -> Piece:
    """The whole lines in a file's last `size` bytes, and what stands behind its last feed. Raises LogError."""
    try:
        with path.open("rb", buffering=0) as file:
            total = file.seek(0, 2)
            begin = _after_feed(file, total - size, total) if total > size else 0
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error
    return Piece(begin, total, last=True)


def _after_feed(file: FileIO, at: int, total: int) -> int:
    """The place behind the first line feed at or after `at`, or the end."""
    if at >= total:
        return total
    file.seek(at)
    while at < total and (read := file.read(_SEARCH_BYTES)):
        feed = read.find(b"\n")
        if feed >= 0:
            return at + feed + 1
        at += len(read)
    return total


@dataclass(frozen=True)
class Buffers:
    """Buffers for blocks that are used again: fresh memory costs more than what is done with it."""

    block: int = field(default_factory=lambda: BLOCK_BYTES)
    free: deque[bytearray] = field(default_factory=deque)

    def take(self) -> bytearray:
        """A buffer for two blocks between the margins that the kernels need."""
        try:
            return self.free.pop()
        except IndexError:
            return bytearray(FRONT + 2 * self.block + BEHIND)


def read_piece(
    path: Path, piece: Piece, buffers: Buffers, parse: Callable[[ByteArray, int, int, bool], None]
) -> bool:
    """Call parse(text, begin, stop, ended) for the lines of a piece, some at a time; whether the last line is ended.

    Raises LogError.
    """
    buffer = buffers.take()
    text = np.frombuffer(buffer, dtype=np.uint8)
    try:
        with path.open("rb", buffering=0) as file:
            file.seek(piece.begin)
            for begin, stop, cut in _lines(file, piece.end - piece.begin, buffer, buffers.block):
                parse(text, begin, stop, cut or buffer[stop - 1] == 10)
            file.seek(max(piece.end - 1, 0))
            return file.read(1) == b"\n"
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error
    finally:
        buffers.free.append(buffer)


def walk_piece(
    path: Path, piece: Piece, buffers: Buffers, parse: Callable[[ByteArray, IntArray], bool]
) -> bool | None:
    """As `read_piece`, for a kernel that reads the blocks itself: call parse(text, walk) as long as it wants more room.

    walk: of `parsers.can.blocks`. None, and nothing is read, where a kernel cannot: of files that are not on this machine's disks.
    Raises LogError.
    """
    pread = pread_address()
    if not pread:
        return None
    buffer = buffers.take()
    text = np.frombuffer(buffer, dtype=np.uint8)
    try:
        with path.open("rb", buffering=0) as file:
            number = descriptor_of(file)
            if number < 0:
                return None
            walk = walk_of(pread, number, buffers.block, piece.begin, piece.end)
            while parse(text, walk):
                pass
        if walk[LAST] < 0:
            raise LogError("cannot be read (the disk reports an error)", path=path)
        return int(walk[LAST]) == 10
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error
    finally:
        buffers.free.append(buffer)


def _lines(file: FileIO, left: int, buffer: bytearray, block: int) -> Iterator[tuple[int, int, bool]]:
    """Read `left` bytes block by block; where in the buffer whole lines begin and stop, and whether the last is cut.

    A line without a feed for more than a block is cut: what follows up to its feed is passed over.
    """
    view = memoryview(buffer)
    kept, passing = FRONT, False
    while left > 0:
        got = file.readinto(view[kept : kept + min(block, left)])
        fill = kept + (got or 0)
        # a file may have become shorter since it was measured
        left = left - got if got else 0
        begin = FRONT
        if passing:
            begin = buffer.find(b"\n", FRONT, fill) + 1
            if begin == 0:
                kept = FRONT
                continue
            passing = False
        stop = buffer.rfind(b"\n", begin, fill) + 1 if left else fill
        if stop == 0:
            stop = begin
            if fill - begin > block:
                stop, passing = fill, True
        if stop > begin:
            yield begin, stop, passing
        kept = FRONT + fill - stop
        buffer[FRONT:kept] = buffer[stop:fill]
