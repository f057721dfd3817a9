"""The blocks of an MDF 4 file: bounded reads, checked against the file's length before anything is allocated."""

from __future__ import annotations

import bisect
import re
import struct
from dataclasses import dataclass, field
from io import FileIO
from pathlib import Path
from types import TracebackType

import numpy as np

from parsers.channels import ByteArray
from parsers.errors import LogError
from parsers.shared_file import SharedFile

HEADER = struct.Struct("<4sIQQ")
ID_SIZE = 64
MAX_BLOCK = 64 << 20
"""Bytes of one block of descriptions; data blocks are read piece by piece instead."""
MAX_TEXT = 1 << 20
_TX = re.compile(rb"<TX[^>]*>(.*?)</TX>", re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A block of descriptions: its links (file positions, 0 for none) and the bytes behind them."""

    kind: str
    at: int
    links: tuple[int, ...]
    data: bytes

    def link(self, index: int) -> int:
        """A link, 0 where the block has fewer."""
        return self.links[index] if index < len(self.links) else 0


@dataclass(frozen=True)
class Head:
    """A block's header alone. length: as the file says, which may be wrong."""

    kind: str
    at: int
    length: int
    links: int


@dataclass
class BlockFile:
    """An open MF4 file, to be read by any thread. `with BlockFile(path) as file:`. seen: where blocks begin, as far as they have been met."""

    path: Path
    size: int = 0
    seen: list[int] = field(default_factory=list)
    _raw: FileIO = field(init=False)
    _shared: SharedFile = field(init=False)

    def __enter__(self) -> BlockFile:
        try:
            # no buffer of Python's own: blocks are read whole, each with one call
            self._raw = self.path.open("rb", buffering=0)
        except OSError as error:
            raise LogError(f"cannot be opened ({error.strerror})", path=self.path) from error
        self.size = self._raw.seek(0, 2)
        self._shared = SharedFile(self._raw)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._raw.close()

    def fail(self, problem: str, at: int) -> LogError:
        """The error for something wrong at a place."""
        return LogError(problem, path=self.path, place=f"byte {at}", hint="the file is damaged or cut short")

    def read(self, at: int, size: int) -> bytes:
        """Exactly `size` bytes. Raises LogError where the file has fewer."""
        self._check(at, size)
        data = self._shared.bytes(at, size)
        if len(data) == size:
            return data
        # a read may stop early without being at the end
        out = np.empty(size, np.uint8)
        self.read_into(at, out)
        return out.tobytes()

    def read_into(self, at: int, out: ByteArray) -> None:
        """Fill `out` (contiguous) with the file's bytes from `at`. Raises LogError where the file has fewer."""
        self._check(at, out.size)
        if self._shared.fill(at, out) < out.size:
            raise self.fail("the file became shorter while it was read", at)

    def _check(self, at: int, size: int) -> None:
        if at < 0 or size < 0 or at + size > self.size:
            raise self.fail(f"{size} bytes expected, the file ends at {self.size}", at)

    def head(self, at: int) -> Head:
        """A block's header. Raises LogError where there is none."""
        mark, _, length, links = HEADER.unpack(self.read(at, HEADER.size))
        if mark[:2] != b"##":
            raise self.fail(f"an MDF block expected, found {mark!r}", at)
        return Head(mark[2:].decode("latin-1"), at, length, links)

    def block(self, at: int, *kinds: str) -> Block:
        """A whole block of one of the kinds. Raises LogError where it is another, or does not fit the file."""
        head = self.head(at)
        if kinds and head.kind not in kinds:
            raise self.fail(f"a block {' or '.join(kinds)} expected, found {head.kind}", at)
        if not HEADER.size + 8 * head.links <= head.length <= MAX_BLOCK:
            raise self.fail(
                f"block {head.kind} with {head.links} links cannot be {head.length} bytes long", at
            )
        body = self.read(at + HEADER.size, head.length - HEADER.size)
        bisect.insort(self.seen, at)
        links = struct.unpack_from(f"<{head.links}Q", body)
        return Block(head.kind, at, links, body[8 * head.links :])

    def text(self, at: int) -> str:
        """The text of a TX or MD block (of an MD, its <TX>); empty where there is none or it is damaged."""
        if not at:
            return ""
        try:
            head = self.head(at)
            if head.kind not in ("TX", "MD") or head.length < HEADER.size:
                return ""
            raw = self.read(at + HEADER.size, min(head.length - HEADER.size, MAX_TEXT))
            bisect.insort(self.seen, at)
        except LogError:
            return ""
        if head.kind == "MD":
            found = _TX.search(raw)
            raw = found.group(1) if found else b""
        return raw.split(b"\0", 1)[0].decode("utf-8", errors="replace").strip()

    def next_seen(self, at: int) -> int:
        """Where the next known block begins behind a place, or the file's end."""
        index = bisect.bisect_right(self.seen, at)
        return self.seen[index] if index < len(self.seen) else self.size
