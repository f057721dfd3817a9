"""LZ4 frames into a buffer: as the package itself unpacks them, and nothing beyond the buffer."""

from __future__ import annotations

import contextlib
import threading

import lz4.frame
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers import lz4_frames
from parsers.lz4_frames import FrameUnpacker, Lz4Error

SHARED = FrameUnpacker()


@pytest.fixture(params=["library", "package"])
def frames(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> FrameUnpacker:
    """By liblz4's own function, and where the package hides it."""
    if request.param == "package":
        monkeypatch.setattr(lz4_frames, "_library", lambda: None)
    return FrameUnpacker()


def test_the_library_is_there_where_the_tests_run() -> None:
    assert lz4_frames._library() is not None


@settings(max_examples=60, deadline=None)
@given(
    st.binary(max_size=200_000),
    st.sampled_from([lz4.frame.BLOCKSIZE_MAX64KB, lz4.frame.BLOCKSIZE_MAX4MB]),
    st.booleans(),
    st.booleans(),
)
def test_frames_come_out_as_they_went_in(content: bytes, size: int, linked: bool, checked: bool) -> None:
    raw = lz4.frame.compress(content * 3, block_size=size, block_linked=linked, content_checksum=checked)
    out = np.full(3 * len(content) + 9, 7, np.uint8)
    assert SHARED.unpack(raw, out[:-8]) == 3 * len(content)
    assert out[: 3 * len(content)].tobytes() == content * 3
    assert (out[-8:] == 7).all()


@pytest.mark.parametrize("room", [0, 1, 5000, 5999, 6000, 6001])
def test_no_more_than_there_is_room_for(frames: FrameUnpacker, room: int) -> None:
    content = np.random.default_rng(0).bytes(500) * 12
    out = np.full(room + 64, 9, np.uint8)
    assert frames.unpack(lz4.frame.compress(content), out[:room]) == min(room, 6000)
    assert out[: min(room, 6000)].tobytes() == content[:room]
    assert (out[room:] == 9).all()


def test_of_a_frame_that_is_cut_what_is_whole_comes_out(frames: FrameUnpacker) -> None:
    content = np.random.default_rng(0).bytes(300_000)
    raw = lz4.frame.compress(content, block_size=lz4.frame.BLOCKSIZE_MAX64KB)
    out = np.zeros(400_000, np.uint8)
    got = frames.unpack(raw[: len(raw) // 2], out)
    assert 65536 <= got <= len(raw) // 2
    assert out[:got].tobytes() == content[:got]
    # and the next frame knows nothing of it
    assert frames.unpack(raw, out) == 300_000


@pytest.mark.parametrize("place", [0, 4, 6, 3000])
def test_damage_is_an_error(frames: FrameUnpacker, place: int) -> None:
    raw = bytearray(lz4.frame.compress(np.random.default_rng(0).bytes(5000), content_checksum=True))
    raw[place] ^= 0xFF
    out = np.zeros(5001, np.uint8)
    with pytest.raises(Lz4Error, match="error"):
        frames.unpack(bytes(raw), out)
    assert frames.unpack(lz4.frame.compress(b"after it"), out) == 8


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=300), st.integers(0, 400))
def test_whatever_the_bytes_are_the_buffer_is_kept_to(junk: bytes, room: int) -> None:
    out = np.full(room + 32, 5, np.uint8)
    for raw in (junk, lz4.frame.compress(b"ab" * 100)[:20] + junk):
        with contextlib.suppress(Lz4Error):
            assert 0 <= SHARED.unpack(raw, out[:room]) <= room
        assert (out[room:] == 5).all()


def test_threads_each_with_their_own() -> None:
    contents = [np.random.default_rng(k).bytes(100_000) * 5 for k in range(4)]
    raws = [lz4.frame.compress(c) for c in contents]
    wrong: list[int] = []

    def work(k: int) -> None:
        mine, out = FrameUnpacker(), np.zeros(500_001, np.uint8)
        for _ in range(30):
            if mine.unpack(raws[k], out) != 500_000 or out[:-1].tobytes() != contents[k]:
                wrong.append(k)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
