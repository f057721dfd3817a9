"""Ordered work on all cores, and the unchecked loads that kernels use."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import numpy as np
import pytest

from parsers.channels import ByteArray
from parsers.jit import kernel, load_u16, load_u32, load_u64
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
