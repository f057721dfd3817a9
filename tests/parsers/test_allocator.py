"""Slabs: columns of their own, from memory of one piece."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from parsers.allocator import LARGE_PAGE, SLAB_BYTES, Slab, Slabs, room_of
from parsers.parallel import CORES_VARIABLE


def test_columns_of_a_slab_do_not_overlap_and_lie_where_a_core_reads() -> None:
    slab = Slab(3 * LARGE_PAGE)
    columns = [
        slab.empty(count, kind) for count, kind in ((1000, np.float64), (7, np.uint8), (999, np.int32))
    ]
    for number, column in enumerate(columns):
        column[:] = number
    assert [int(column.min()) for column in columns] == [int(column.max()) for column in columns] == [0, 1, 2]
    assert all(column.ctypes.data % 64 == 0 for column in columns)
    assert columns[0].ctypes.data % LARGE_PAGE == 0
    assert slab.left == 3 * LARGE_PAGE - room_of(8000) - room_of(7) - room_of(4 * 999)


@pytest.mark.parametrize("size", [0, LARGE_PAGE, 2 * LARGE_PAGE])
def test_a_slab_that_is_full_or_small_gives_memory_all_the_same(size: int) -> None:
    slab = Slab(size)
    columns = [slab.empty(LARGE_PAGE // 8, np.float64) for _ in range(4)]
    for number, column in enumerate(columns):
        column[:] = number
    assert [column.sum() for column in columns] == [number * LARGE_PAGE / 8 for number in range(4)]


def test_slabs_serve_threads_at_once() -> None:
    slabs, sizes = Slabs(), np.random.default_rng(5).integers(1, 40_000, 400)

    def take(number: int) -> np.ndarray:
        column = slabs.cells(int(sizes[number]))
        column[:] = number
        return column

    with ThreadPoolExecutor(4) as pool:
        columns = list(pool.map(take, range(sizes.size)))
    for number, column in enumerate(columns):
        assert column.size == sizes[number]
        assert (column == number).all()


def test_a_column_larger_than_half_a_slab_has_memory_of_its_own() -> None:
    slabs = Slabs()
    assert slabs.cells(SLAB_BYTES // 8).base is None
    assert slabs.cells(100).base is not None
    assert slabs.slab.left == SLAB_BYTES - room_of(800)


@pytest.mark.parametrize("cores", ["1", "2", "3"])
@pytest.mark.parametrize("pages", [0, 1, 2, 5])
def test_touching_a_slab_reaches_every_large_page_and_nothing_beyond(
    pages: int, cores: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(CORES_VARIABLE, cores)
    slab = Slab(pages * LARGE_PAGE + 100)
    slab.cells[:] = 1.0
    slab.touch()
    marked = np.flatnonzero(slab.cells.view(np.uint8)[::LARGE_PAGE] == 0)
    assert len(marked) == -(-slab.cells.nbytes // LARGE_PAGE)
    assert slab.left == slab.empty(0, np.uint8).size + (pages * LARGE_PAGE + 100 if pages > 1 else 0)
