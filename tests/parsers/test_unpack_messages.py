"""Messages that rosbag2 compressed one by one: unpacked by libzstd in a kernel, and without it."""

from __future__ import annotations

import numpy as np
import pytest
import zstandard

from parsers.ros import bag2_messages
from parsers.ros.bag2_messages import frame_sizes, unpack_at
from parsers.ros.bag2_rows import Rows


class NoLibrary:
    """As `ZstdContext` is where the package keeps its library to itself."""

    decompress = context = 0


@pytest.mark.parametrize("library", [True, False])
def test_whole_frames_come_joined_and_damaged_ones_are_told(library, monkeypatch):
    if not library:
        monkeypatch.setattr(bag2_messages, "ZstdContext", NoLibrary)
    rng = np.random.default_rng(5)
    texts = [rng.integers(0, 4, int(n), dtype=np.uint8).tobytes() for n in rng.integers(1, 4000, 60)]
    frames = [bytearray(zstandard.compress(text)) for text in texts]
    for damaged in (0, 17, 59):
        # the header stays, so that the size is still told
        frames[damaged][12:] = bytes(len(frames[damaged]) - 12)
        texts[damaged] = b""
    frames[30] = frames[30][:-3]
    texts[30] = b""
    length = np.array([len(frame) for frame in frames])
    offset = np.cumsum(length) - length
    data = np.frombuffer(b"".join(frames), dtype=np.uint8)
    sizes = np.empty(len(frames), dtype=np.int64)
    assert frame_sizes(data, offset, length, sizes) == len(frames)
    every = np.arange(len(frames))
    rows = Rows(np.zeros_like(offset), np.zeros_like(offset), offset, length, data)
    joined, found, good = unpack_at(rows, every, sizes)
    assert np.flatnonzero(~good).tolist() == [0, 17, 30, 59]
    assert joined.tobytes() == b"".join(texts)
    assert found.tolist() == [len(text) for text in texts if text]
