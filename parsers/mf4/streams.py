"""The data stream of a data group: one row of bytes, kept in DT, DV, SD or DZ blocks, in a list (DL, HL) or alone."""

from __future__ import annotations

import bisect
import struct
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from parsers.channels import ByteArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.mf4.blocks import HEADER, BlockFile
from parsers.mf4.compression import first_bytes
from parsers.mf4.model import UNFINISHED_LENGTH, UNFINISHED_LIST
from parsers.mf4.pieces import CHUNK, Fragment, Piece, parts, unpack

ALL_VALID, UNREADABLE = -1, -2
MAX_LISTS = 1 << 20
_DZ = struct.Struct("<2sBxIQQ")
_PLAIN = ("DT", "DV", "SD", "DI")
MAX_CUT = 32 << 20
"""Bytes of a cut block that are looked at."""
_KEPT, _KEPT_BYTES = 4, 32 << 20


@dataclass
class DataStream:
    """The fragments in order; `starts[i]` is the place in the stream of fragment i, `size` the stream's length.

    values_only: records without invalidation bytes (DV blocks); those are in `bits`, if anywhere.
    """

    file: BlockFile
    log: ImportLog
    fragments: list[Fragment] = field(default_factory=list)
    starts: list[int] = field(default_factory=list)
    size: int = 0
    values_only: bool = False
    bits: BitBlocks | None = None
    _kept: OrderedDict[int, ByteArray] = field(default_factory=OrderedDict)

    @property
    def plain(self) -> bool:
        """Whether nothing of it is compressed."""
        return all(fragment.method < 0 for fragment in self.fragments)

    def add(self, fragment: Fragment) -> None:
        """Append a fragment."""
        if fragment.size > 0:
            self.fragments.append(fragment)
            self.starts.append(self.size)
            self.size += fragment.size

    def place(self, at: int) -> int:
        """Where in the file a place of the stream is; of a compressed block its beginning."""
        index = max(bisect.bisect_right(self.starts, at) - 1, 0)
        fragment = self.fragments[index]
        return fragment.at + (at - self.starts[index] if fragment.method < 0 else 0)

    def _inflated(self, index: int) -> ByteArray:
        """A compressed fragment's bytes; the last few are kept. Raises LogError where it is damaged."""
        if index in self._kept:
            return self._kept[index]
        fragment = self.fragments[index]
        raw = unpack(fragment, self.file.read(fragment.at, fragment.stored))
        self._kept[index] = raw
        while len(self._kept) > 1 and (
            len(self._kept) > _KEPT or sum(some.size for some in self._kept.values()) > _KEPT_BYTES
        ):
            self._kept.popitem(last=False)
        return raw

    def read(self, start: int, stop: int) -> ByteArray:
        """The bytes from start to stop. Raises LogError where they are not all there."""
        if not 0 <= start <= stop <= self.size:
            raise LogError(
                f"bytes {start} to {stop} of a data stream of {self.size} bytes", path=self.file.path
            )
        out = np.empty(stop - start, np.uint8)
        self.read_into(start, out)
        return out

    def read_into(self, start: int, out: ByteArray) -> None:
        """Fill `out` (contiguous) with the bytes from start, which must all lie in the stream. Raises LogError."""
        at, stop = start, start + out.size
        index = bisect.bisect_right(self.starts, start) - 1
        while at < stop:
            begin, fragment = self.starts[index], self.fragments[index]
            end = min(stop, begin + fragment.size)
            into = out[at - start : end - start]
            if fragment.method < 0:
                self.file.read_into(fragment.at + at - begin, into)
            else:
                into[:] = self._inflated(index)[at - begin : end - begin]
            at, index = end, index + 1

    def filled(self) -> int:
        """The place behind the last byte that is not zero, or behind the last compressed block."""
        index = len(self.fragments)
        while index and self.fragments[index - 1].method < 0:
            index -= 1
        first = self.starts[index] if index < len(self.fragments) else self.size
        # most files have none behind their records: a little look is enough
        stop, step = self.size, 4096
        while stop > first:
            begin, step = max(stop - step, first), min(4 * step, CHUNK)
            used = np.flatnonzero(self.read(begin, stop))
            if used.size:
                return begin + int(used[-1]) + 1
            stop = begin
        return first

    def _plain(self, index: int, unit: int) -> Iterator[Piece]:
        """The plain fragments from one on, up to the next compressed one: whole units, wherever the blocks end."""
        at, end = self.starts[index], index
        while end < len(self.fragments) and self.fragments[end].method < 0:
            end += 1
        stop = self.starts[end] if end < len(self.fragments) else self.size
        step = max(CHUNK // unit, 1) * unit
        while at < stop:
            after = min(at - at % unit + step, stop)
            index = bisect.bisect_right(self.starts, at) - 1
            fragment = self.fragments[index]
            data: ByteArray | LogError
            try:
                data = self.read(at, after)
            except LogError as error:
                data = error
            yield Piece(at, Fragment(fragment.at + at - self.starts[index], after - at, after - at), data)
            at = after

    def _pieces(self, unit: int) -> Iterator[Piece]:
        index = 0
        while index < len(self.fragments):
            fragment, start = self.fragments[index], self.starts[index]
            if fragment.method < 0:
                yield from self._plain(index, unit)
                while index < len(self.fragments) and self.fragments[index].method < 0:
                    index += 1
                continue
            try:
                yield Piece(start, fragment, self.file.read(fragment.at, fragment.stored))
            except LogError as error:
                yield Piece(start, fragment, error)
            index += 1

    def chunks(self, unit: int = 1) -> Iterator[tuple[int, ByteArray, int]]:
        """(place in the stream, bytes, place in the file) in order, about CHUNK bytes each.

        unit: bytes of a record, so that chunks of plain bytes end with a whole one. A damaged block is left out and
        said: the next chunk then begins later than the last one ended.
        """
        for part in parts(self._pieces(unit), self.fragments):
            if isinstance(part.data, LogError):
                self.left_out(part.file_at, part.data)
            else:
                yield part.start, part.data, part.file_at

    def left_out(self, file_at: int, why: LogError) -> None:
        """Say that a piece of the stream could not be read."""
        self.log.reject("damaged data block in the MF4 file")
        self.log.worsen(
            "malformed", f"the data block at byte {file_at} is damaged and was left out: {why.problem}"
        )


@dataclass
class BitBlocks:
    """Where the bits of each block of values are: for block i, which begins at values_at[i] in the stream of values, at
    bits_at[i] in the stream of bits; ALL_VALID where there are none, UNREADABLE where they cannot be read.
    """

    bits: DataStream
    values_at: list[int] = field(default_factory=list)
    bits_at: list[int] = field(default_factory=list)

    def add(self, values_at: int, bits_at: int) -> None:
        """Say where the bits of the next block of values are."""
        self.values_at.append(values_at)
        self.bits_at.append(bits_at)


class _Builder:
    """Collects a stream's fragments from the blocks that a data link leads to."""

    def __init__(self, file: BlockFile, log: ImportLog, unfinished: int) -> None:
        self.stream = DataStream(file, log)
        self.file, self.log, self.unfinished = file, log, unfinished
        self.end = 0
        self.visited: set[int] = set()

    def truncated(self, at: int) -> None:
        self.log.worsen(
            "truncated",
            f"the file breaks off in the data block at byte {at}; all records that are whole were used",
        )

    def data_block(self, at: int, *, last: bool) -> None:
        """Add one DT, DV, SD or DZ block; a plain one may be cut by the file's end."""
        head = self.file.head(at)
        begin = at + HEADER.size
        if head.kind == "DZ":
            inner, method, columns, size, stored = _DZ.unpack(self.file.read(begin, _DZ.size))
            begin += _DZ.size
            self.end = begin + stored
            if inner.decode("latin-1") not in _PLAIN:
                raise self.file.fail(f"a compressed block of kind {inner!r}", at)
            self.stream.values_only |= inner == b"DV"
            if begin + stored > self.file.size:
                self.truncated(at)
                self._cut(begin, method, size)
                return
            self.stream.add(Fragment(begin, stored, size, method, columns))
            return
        if head.kind not in _PLAIN:
            raise self.file.fail(f"a data block expected, found {head.kind}", at)
        self.stream.values_only |= head.kind == "DV"
        length = head.length
        if last and head.kind != "SD" and (length <= HEADER.size or self.unfinished & UNFINISHED_LENGTH):
            # the recorder never wrote the length: the data go on to the next block or the file's end
            length = self.file.next_seen(at) - at
        self.end = at + length
        if self.end > self.file.size:
            self.truncated(at)
            length = self.file.size - at
        self.stream.add(Fragment(begin, length - HEADER.size, length - HEADER.size))

    def _cut(self, begin: int, method: int, size: int) -> None:
        """Add the beginning of a deflated block in which the file ends. Of a transposed one no record would be whole."""
        stored = self.file.size - begin
        if method == 0 and 0 < stored <= MAX_CUT:
            there = len(first_bytes(self.file.read(begin, stored), size))
            self.stream.add(Fragment(begin, stored, there, method, cut=True))

    def data_list(self, at: int) -> None:
        """Add all blocks of a list of lists."""
        blocks: list[tuple[int, int]] = []
        marked = False
        while at and at not in self.visited and len(self.visited) < MAX_LISTS:
            self.visited.add(at)
            block = self.file.block(at, "DL", "LD")
            self.end = at + HEADER.size + 8 * len(block.links) + len(block.data)
            count = int.from_bytes(block.data[4:8], "little")
            # behind them an LD block has links to invalidation bits, if the highest of its flags says so
            apart = block.kind == "LD" and bool(block.data[3] & 0x80)
            marked = marked or apart
            for number, link in enumerate(block.links[1 : 1 + count]):
                if not link:
                    break
                blocks.append((link, block.link(1 + count + number) if apart else 0))
            at = block.link(0)
        bits = self.stream.bits = BitBlocks(DataStream(self.file, self.log)) if marked else None
        for index, (link, bits_link) in enumerate(blocks):
            if link not in self.visited:
                self.visited.add(link)
                begin = self.stream.size
                self.data_block(link, last=index + 1 == len(blocks))
                if bits is not None and self.stream.size > begin:
                    bits.add(begin, self._bits(bits_link, bits.bits))

    def _bits(self, link: int, into: DataStream) -> int:
        """Add a block of invalidation bits to their stream: its place there, or why there is none."""
        if not link:
            return ALL_VALID
        other = _Builder(self.file, ImportLog(), 0)
        try:
            other.data_block(link, last=False)
        except LogError:
            return UNREADABLE
        begin = into.size
        for fragment in other.stream.fragments:
            into.add(fragment)
        return begin

    def follow(self) -> None:
        """The last list of an unfinished file misses blocks that stand behind it in the file: add them."""
        while True:
            at = (self.end + 7) // 8 * 8
            try:
                if at in self.visited or self.file.head(at).kind not in ("DT", "DV", "DZ"):
                    return
                self.visited.add(at)
                self.data_block(at, last=True)
            except LogError:
                return


def open_stream(file: BlockFile, link: int, unfinished: int, log: ImportLog) -> DataStream:
    """The stream behind a data link; what cannot be read of it is left out at its end and said."""
    builder = _Builder(file, log, unfinished)
    if not link:
        return builder.stream
    try:
        kind = file.head(link).kind
        if kind == "HL":
            link = file.block(link, "HL").link(0)
            kind = "DL"
        if kind in ("DL", "LD"):
            builder.data_list(link)
            if unfinished & UNFINISHED_LIST:
                builder.follow()
        else:
            builder.data_block(link, last=True)
    except LogError as error:
        cut = link >= file.size or "the file ends" in error.problem
        log.worsen(
            "truncated" if cut else "malformed",
            f"a data block cannot be read ({error.place}: {error.problem}); all records before it were used",
        )
    return builder.stream
