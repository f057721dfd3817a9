"""Ordered work on all cores, and the unchecked loads that kernels use."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import numpy as np
import pytest

from parsers.channels import ByteArray
from parsers.jit import kernel, load_u16, load_u32, load_u64, prefetch
from parsers.parallel import in_order


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_results_come_in_the_order_of_the_items(workers: int) -> None:
    first = threading.Event()

    def work(item: int) -> int:
        # the first item is the last to be done where there is more than one worker
        if item == 0 and workers > 1:
            assert first.wait(10)
        if item == 1:
            first.set()
        return item * item

    assert list(in_order(work, range(20), workers=workers)) == [k * k for k in range(20)]


@pytest.mark.parametrize("workers", [1, 3])
def test_only_a_few_items_are_taken_ahead_of_what_is_used(workers: int) -> None:
    taken = 0

    def items() -> Iterator[int]:
        nonlocal taken
        for k in range(100):
            taken += 1
            yield k

    results = in_order(lambda k: k, items(), workers=workers, ahead=2)
    for used, _ in enumerate(results):
        assert taken <= used + workers + 2
        if used == 50:
            break


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_comes_where_its_result_would_have(workers: int) -> None:
    def work(item: int) -> int:
        if item == 3:
            raise ValueError("three")
        return item

    results = in_order(work, range(10), workers=workers)
    assert [next(results) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(ValueError, match="three"):
        next(results)


def test_the_caller_works_too() -> None:
    ran: set[int] = set()

    def work(item: int) -> None:
        ran.add(threading.get_ident())

    list(in_order(work, range(200), workers=2))
    assert threading.get_ident() in ran
    assert len(ran) <= 2


def test_who_stops_early_leaves_no_thread_behind() -> None:
    before = threading.active_count()
    results = in_order(lambda k: k, range(100), workers=3)
    assert next(results) == 0
    results.close()
    assert threading.active_count() == before


@kernel
def _first_of_each(buffer: ByteArray, step: int) -> int:
    total = 0
    for at in range(0, buffer.size, step):
        # far beyond the end too
        prefetch(buffer, at + 1000 * step)
        total += buffer[at]
    return total


def test_sending_for_bytes_changes_nothing() -> None:
    raw = np.arange(5000, dtype=np.int64).astype(np.uint8)
    assert _first_of_each(raw, 7) == int(raw[::7].sum())


@kernel
def _all_loads(buffer: ByteArray, two: np.ndarray, four: np.ndarray, eight: np.ndarray) -> None:  # type: ignore[type-arg]
    for at in range(buffer.size - 7):
        two[at], four[at], eight[at] = load_u16(buffer, at), load_u32(buffer, at), load_u64(buffer, at)


def test_loads_are_little_endian_at_any_place() -> None:
    raw = np.random.default_rng(1).bytes(64)
    n = len(raw) - 7
    two, four, eight = np.zeros(n, np.int64), np.zeros(n, np.int64), np.zeros(n, np.uint64)
    _all_loads(np.frombuffer(raw, np.uint8), two, four, eight)
    for width, found in ((2, two), (4, four), (8, eight)):
        assert found.tolist() == [int.from_bytes(raw[at : at + width], "little") for at in range(n)]
