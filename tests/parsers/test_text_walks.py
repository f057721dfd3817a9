"""A piece that a kernel reads by itself gives what the plain way gives, whatever the sizes and the damage."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
import text_log_fuzz as fuzz
from test_text_pieces import LOGS, everything, set_sizes

from parsers.can import pieces as pieces_module
from parsers.can.blocks import BEGIN, CUT, LAST, STOP, next_block, walk_of
from parsers.can.pieces import Buffers, Piece, read_piece, walk_piece
from parsers.channels import ByteArray, IntArray
from parsers.errors import LogError
from parsers.jit_foreign import pread_address

pytestmark = pytest.mark.skipif(
    not pread_address(), reason="no pread of 64 bits here: the plain way is taken"
)


def blocks_of(path: Path, piece: Piece, block: int, *, plain: bool) -> tuple[list[tuple[bytes, bool]], bool]:
    """Every block's lines, whether they are ended, and whether the piece is."""
    found: list[tuple[bytes, bool]] = []

    def parse(text: ByteArray, begin: int, stop: int, ended: bool) -> None:
        found.append((text[begin:stop].tobytes(), ended))

    def walk(text: ByteArray, walk: IntArray) -> bool:
        more = next_block(text, walk)
        if more:
            begin, stop = int(walk[BEGIN]), int(walk[STOP])
            parse(text, begin, stop, bool(walk[CUT]) or text[stop - 1] == 10)
            walk[BEGIN] = stop
        return more

    if plain:
        return found, read_piece(path, piece, Buffers(block), parse)
    ended = walk_piece(path, piece, Buffers(block), walk)
    assert ended is not None
    return found, ended


@pytest.mark.parametrize("seed", range(6))
def test_blocks_are_those_of_the_plain_way(seed: int, tmp_path: Path) -> None:
    rng = random.Random(seed)
    path = tmp_path / "a.txt"
    lines = [b"x" * rng.choice([0, 1, 5, 40, 90, 200, 1000]) for _ in range(200)]
    path.write_bytes(b"\n".join(lines) + rng.choice([b"", b"\n"]))
    size = path.stat().st_size
    for block in (16, 100, 101, 4096):
        for begin, end in ((0, size), (7, size - 3), (0, size + 50)):
            piece = Piece(begin, end, True)
            assert blocks_of(path, piece, block, plain=False) == blocks_of(path, piece, block, plain=True)


def test_lines_that_a_parser_left_come_again_without_reading(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(b"one\ntwo\n")
    seen = []

    def walk(text: ByteArray, walk: IntArray) -> bool:
        assert next_block(text, walk)
        seen.append(text[walk[BEGIN] : walk[STOP]].tobytes())
        walk[BEGIN] += 4
        return len(seen) < 2

    assert walk_piece(path, Piece(0, 8, True), Buffers(100), walk) is True
    assert seen == [b"one\ntwo\n", b"two\n"]


@pytest.mark.parametrize("name", sorted(LOGS))
def test_frames_and_counts_are_those_of_the_plain_way(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    head, makers = LOGS[name]
    path = tmp_path / f"a{Path(name).suffix}"
    path.write_bytes(head + fuzz.random_log(makers, 11, 250, share=0.1))
    set_sizes(monkeypatch, 3000, 700)
    frames, log = everything(path, workers=2)
    monkeypatch.setattr(pieces_module, "pread_address", lambda: 0)
    plain, plain_log = everything(path, workers=2)
    assert frames
    assert frames == plain
    assert (log.messages, log.rejected, log.notes) == (
        plain_log.messages,
        plain_log.rejected,
        plain_log.notes,
    )


def test_a_disk_that_fails_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(b"one\n")
    monkeypatch.setattr(pieces_module, "descriptor_of", lambda _file: 987_654)

    def walk(text: ByteArray, walk: IntArray) -> bool:
        return next_block(text, walk)

    with pytest.raises(LogError, match="disk reports an error"):
        walk_piece(path, Piece(0, 4, True), Buffers(100), walk)
    assert walk_of(0, 0, 1, 0, 1)[LAST] == 0
