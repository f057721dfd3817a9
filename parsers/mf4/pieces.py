"""Data blocks and how a stream of them is read: in pieces of some MiB, compressed ones inflated in threads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from parsers.allocator import keep_freed_memory
from parsers.channels import ByteArray
from parsers.errors import LogError
from parsers.mf4.compression import first_bytes, inflate
from parsers.parallel import in_order

CHUNK = 4 << 20
"""Bytes handed on at a time."""
BIG = 32 << 20
"""Blocks beyond this many bytes are inflated one at a time, so that memory stays bounded."""


@dataclass(frozen=True)
class Fragment:
    """A data block. at: of its bytes in the file. stored, size: bytes in the file and inflated. method: -1 plain.

    cut: the file ends in it; its first `size` bytes can be inflated.
    """

    at: int
    stored: int
    size: int
    method: int = -1
    columns: int = 0
    cut: bool = False


@dataclass(frozen=True)
class Piece:
    """Bytes of a stream as they are in the file, or why they could not be read. start: place in the stream."""

    start: int
    fragment: Fragment
    data: bytes | ByteArray | LogError


@dataclass(frozen=True)
class Part:
    """Bytes of a stream, or why they are not there. start: place in the stream. file_at: place in the file."""

    start: int
    file_at: int
    data: ByteArray | LogError


def unpack(fragment: Fragment, data: bytes) -> ByteArray:
    """A compressed fragment's bytes. Raises LogError where it is damaged."""
    if not fragment.cut:
        return inflate(data, fragment.method, fragment.size, fragment.columns)
    return np.frombuffer(bytearray(first_bytes(data, fragment.size)), np.uint8)


def _part(piece: Piece) -> Part:
    data = piece.data
    if isinstance(data, bytes):
        try:
            data = unpack(piece.fragment, data)
        except LogError as error:
            data = error
    return Part(piece.start, piece.fragment.at, data)


def _parts(pieces: list[Piece]) -> list[Part]:
    """Inflate neighbours; those that are whole are drawn together. Runs in a thread of its own."""
    parts = [_part(piece) for piece in pieces]
    if len(parts) == 1 or any(isinstance(part.data, LogError) for part in parts):
        return parts
    joined = np.concatenate([part.data for part in parts if not isinstance(part.data, LogError)])
    return [Part(parts[0].start, parts[0].file_at, joined)]


def _bundles(pieces: Iterable[Piece]) -> Iterator[list[Piece]]:
    """Small compressed blocks together, so that each thread has something to do."""
    bundle: list[Piece] = []
    size = 0
    for piece in pieces:
        if bundle and (size + piece.fragment.size > CHUNK or not isinstance(piece.data, bytes)):
            yield bundle
            bundle, size = [], 0
        bundle.append(piece)
        size += piece.fragment.size
        if not isinstance(piece.data, bytes):
            yield bundle
            bundle, size = [], 0
    if bundle:
        yield bundle


def parts(pieces: Iterable[Piece], fragments: list[Fragment]) -> Iterator[Part]:
    """The pieces' bytes, in order. pieces: taken by the caller's thread. fragments: all that there are."""
    keep_freed_memory()
    packed = [fragment.size for fragment in fragments if fragment.method >= 0]
    alone = len(packed) < 2 or max(packed) > BIG
    for some in in_order(_parts, _bundles(pieces), workers=1 if alone else None):
        yield from some
