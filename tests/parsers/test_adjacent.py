"""Pieces of a column: a view where they are neighbours in memory, a copy where they are not."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from parsers.adjacent import joined
from parsers.allocator import LARGE_PAGE, Slab


@given(st.lists(st.integers(1, 40), min_size=2, max_size=6), st.booleans())
def test_neighbours_are_one_view_of_their_block(sizes: list[int], in_bytes: bool) -> None:
    total = sum(sizes)
    block = np.zeros(8 * (total + 5), np.uint8)
    whole = block.view(np.float64) if in_bytes else np.zeros(total + 5)
    whole[:] = np.arange(total + 5)
    ends = 2 + np.cumsum([0, *sizes])
    found = joined([whole[a:b] for a, b in pairwise(ends)])
    assert found.dtype == np.float64
    assert found.tolist() == list(range(2, 2 + total))
    assert np.shares_memory(found, whole)


def test_columns_of_a_slab_are_joined_where_they_lie() -> None:
    slab = Slab(2 * LARGE_PAGE)
    first, second = slab.empty(1000, np.int64), slab.empty(1000, np.int64)
    first[:], second[:] = np.arange(1000), -1
    assert joined([first[:300], first[300:]]).ctypes.data == first.ctypes.data
    # a column's room ends at a full line: there may be nothing of it between two columns
    assert joined([first[:990], second]).tolist() == [*range(990), *[-1] * 1000]


@pytest.mark.parametrize(
    "pick", [(slice(3, 6), slice(0, 3)), (slice(0, 3), slice(4, 6)), (slice(0, 6, 2), slice(6, 8))]
)
def test_what_is_not_next_to_each_other_is_copied(pick: tuple[slice, slice]) -> None:
    whole = np.arange(8.0)
    found = joined([whole[part] for part in pick])
    assert found.tolist() == [*whole[pick[0]], *whole[pick[1]]]
    assert not np.shares_memory(found, whole)


def test_pieces_of_different_blocks_or_kinds_are_copied() -> None:
    a, b = np.arange(3.0), np.arange(4.0)
    assert joined([a, b]).tolist() == [0, 1, 2, 0, 1, 2, 3]
    assert joined([a[:2], b[1:]]).tolist() == [0, 1, 1, 2, 3]
    block = np.zeros(32, np.uint8)
    mixed = joined([block[:16].view(np.float64), block[16:].view(np.int64).view(np.float64)])
    assert mixed.tolist() == [0.0] * 4
    assert joined([a]) is a
