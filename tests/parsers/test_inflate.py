"""Many deflated streams with one call."""

from __future__ import annotations

import zlib

import deflate
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers import inflate
from parsers.channels import ByteArray, IntArray
from parsers.inflate import inflate_all


def packed(contents: list[bytes]) -> tuple[ByteArray, IntArray, IntArray]:
    """Streams behind each other, with other bytes between them: all bytes, and where each begins and how long it is."""
    streams = [zlib.compress(content) for content in contents]
    raw = b"??".join(streams)
    sizes = np.array([len(each) for each in streams], np.int64)
    return np.frombuffer(bytearray(raw), np.uint8), np.cumsum(sizes + 2) - sizes - 2, sizes


@settings(max_examples=50, deadline=None)
@given(st.lists(st.binary(min_size=1, max_size=3000), min_size=1, max_size=20))
def test_streams_come_out_as_they_went_in(contents: list[bytes]) -> None:
    raw, begins, sizes = packed(contents)
    rooms = np.array([len(content) for content in contents], np.int64)
    out = np.zeros(int(rooms.sum()), np.uint8)
    whole = inflate_all(raw, begins, sizes, out, np.cumsum(rooms) - rooms, rooms)
    assert whole is not None
    assert whole.all()
    assert out.tobytes() == b"".join(contents)


@pytest.mark.parametrize("change", ["damaged", "cut", "shorter", "longer"])
def test_one_that_is_not_as_it_says_costs_no_other(change: str) -> None:
    contents = [bytes([k]) * 5000 + np.random.default_rng(k).bytes(500) for k in range(3)]
    raw, begins, sizes = packed(contents)
    rooms = np.full(3, 5500, np.int64)
    if change == "damaged":
        raw[begins[1] + 40] ^= 0xFF
    elif change == "cut":
        sizes[1] -= 5
    else:
        rooms[1] += -1 if change == "shorter" else 1
    out = np.zeros(6000 * 3, np.uint8)
    places = np.array([0, 6000, 12000])
    whole = inflate_all(raw, begins, sizes, out, places, rooms)
    assert whole is not None
    assert whole.tolist() == [True, False, True]
    for k in (0, 2):
        assert out[places[k] : places[k] + 5500].tobytes() == contents[k]
    # nothing was written beyond a stream's room
    assert not out[5500:6000].any()
    assert not out[6000 + rooms[1] : 12000].any()


@pytest.mark.parametrize(
    ("begin", "size", "place", "room"), [(-1, 10, 0, 10), (0, 200, 0, 10), (0, 10, 95, 10), (0, 10, 0, -1)]
)
def test_places_outside_of_the_buffers_are_refused(begin: int, size: int, place: int, room: int) -> None:
    buffer = np.zeros(100, np.uint8)
    one = [np.array([value], np.int64) for value in (begin, size, place, room)]
    with pytest.raises(ValueError, match="outside"):
        inflate_all(buffer, *one[:2], buffer.copy(), *one[2:])


def test_a_package_that_hides_its_functions(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its readers then ask it for every stream: `parsers.blf_groups` falls back to that."""
    inflate._library.cache_clear()
    monkeypatch.setattr(deflate._deflate, "__file__", "/nowhere/at/all.so")
    raw, begins, sizes = packed([b"abc"])
    try:
        assert (
            inflate_all(raw, begins, sizes, np.zeros(3, np.uint8), np.zeros(1, np.int64), np.full(1, 3))
            is None
        )
    finally:
        inflate._library.cache_clear()
