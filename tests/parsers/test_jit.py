"""Kernels called without numba give what plain Python gives."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from parsers.jit import kernel, lean_kernel, vector_kernel
from parsers.jit_shape import leaves_of, shape_of

SCALE = 3


class Pair(NamedTuple):
    """Two arrays that go together."""

    left: np.ndarray
    right: np.ndarray


@lean_kernel
def _weighted(values, at):
    return values[at] * SCALE


@kernel
def total(values):
    """A number from an array, through a helper."""
    found = 0.0
    for k in range(values.size):
        found += _weighted(values, k)
    return found


@kernel
def table_sum(table):
    """A number from a table, whatever its layout."""
    found = 0.0
    for row in range(table.shape[0]):
        for column in range(table.shape[1]):
            found += table[row, column] * (row + 10 * column)
    return found


@kernel
def several(a, b, wrong, words):
    """All sorts of numbers, in and out."""
    return a + words[1], b / 2, not wrong, words[0], int(words.size)


@kernel
def pair_sum(pair, more):
    """Tuples as arguments."""
    return pair[0].sum() + pair[1].sum() * more[1] + more[0]


@kernel
def fill(out, value):
    """No result; arrays of its own in between."""
    between = np.zeros(out.size)
    for k in range(out.size):
        between[k] = value * k
    for k in range(out.size):
        out[k] = between[k]


@kernel
def doubled(values):
    """An array as result: only numba can hand that over."""
    return values * 2


@kernel
def share(a, b):
    """Raises where there is nothing to divide by."""
    return a // b


@kernel
def refuse(a):
    """Raises on its own."""
    if a > 2:
        raise ValueError("too much")
    return a


def is_native(function, *args):
    """Whether a kernel was called by itself for such arguments."""
    call = function._calls.get(tuple(map(shape_of, args)))
    return call is not None and call != function.by_numba


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int64, np.int16, np.uint8])
@pytest.mark.parametrize("values", [[], [1], [3, 1, 4, 1, 5]])
def test_numbers_of_arrays(kind, values):
    array = np.array(values, dtype=kind)
    assert total(array) == total.py_func(array)
    assert is_native(total, array)


def test_layouts_steps_and_locks():
    table = np.arange(24.0).reshape(4, 6)
    locked = table.copy()
    locked.flags.writeable = False
    for each in (table, np.asfortranarray(table), table[::2, ::-1], table[1:1], locked, table.T):
        assert table_sum(each) == table_sum.py_func(each)
        assert is_native(table_sum, each)


def test_numbers_in_and_out():
    words = np.array([2**64 - 1, 5], dtype=np.uint64)
    found = several(np.uint64(7), 3.0, True, words)
    assert found == (12, 1.5, False, 2**64 - 1, 2)
    assert [type(each) for each in found] == [int, float, bool, int, int]
    assert is_native(several, np.uint64(7), 3.0, True, words)


def test_tuples_in():
    pair = Pair(np.arange(3.0), np.arange(4.0))
    assert pair_sum(pair, (1, 2.0)) == 3 + 6 * 2 + 1
    assert is_native(pair_sum, pair, (1, 2.0))


def test_arrays_written_to():
    out = np.ones(5)
    assert fill(out, 2.0) is None
    assert out.tolist() == [0, 2, 4, 6, 8]
    part = np.ones(10)
    fill(part[::2], 1.0)
    assert part.tolist() == [0, 1, 1, 1, 2, 1, 3, 1, 4, 1]
    assert is_native(fill, part[::2], 1.0)


def test_what_only_numba_can_do_is_left_to_it():
    assert doubled(np.arange(3)).tolist() == [0, 2, 4]
    assert not is_native(doubled, np.arange(3))
    assert total(values=np.ones(2)) == 2 * SCALE
    with pytest.raises(Exception, match="too large"):
        share(1 << 70, 2)


def test_errors_are_numbas_own():
    assert share(7, 2) == 3
    with pytest.raises(ZeroDivisionError):
        share(7, 0)
    assert refuse(2) == 2
    with pytest.raises(ValueError, match="too much"):
        refuse(3)
    with pytest.raises(Exception, match="nopython"):
        total("text")


def test_a_vector_kernel_divides_by_zero():
    @vector_kernel
    def over(a, b):
        return a / b

    @kernel
    def quotients(a, b, out):
        for i in range(len(a)):
            out[i] = over(a[i], b[i])

    out = np.zeros(3)
    quotients(np.array([1.0, -1.0, 0.0]), np.array([0.0, 0.0, 2.0]), out)
    assert out.tolist() == [np.inf, -np.inf, 0.0]


def test_shapes_tell_apart_what_machine_code_depends_on():
    array = np.zeros((2, 3))
    locked = array.copy()
    locked.flags.writeable = False
    shapes = [shape_of(each) for each in (array, array.T, array[:, ::2], locked, array[0], array.astype(int))]
    assert len(set(shapes)) == len(shapes)
    assert shape_of(1) != shape_of(1.0) != shape_of(True)
    assert leaves_of([shape_of("text")]) is None
    assert leaves_of([shape_of(np.zeros(2, "M8[s]"))]) is None
    assert leaves_of([shape_of(1 << 64)]) is None


def test_kernels_are_called_from_several_threads():
    from concurrent.futures import ThreadPoolExecutor

    arrays = [np.arange(float(n)) for n in range(200)]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(total, arrays)) == [total.py_func(each) for each in arrays]


def test_kernels_of_one_name_and_equal_kernels_are_kept_apart() -> None:
    def made(factor: float):
        def scaled(values):
            found = 0.0
            for k in range(values.size):
                found += factor * values[k]
            return found

        return kernel(scaled)

    values = np.arange(4.0)
    kernels = [made(factor) for factor in (2.0, 3.0, 2.0)]
    assert [each(values) for each in kernels] == [12.0, 18.0, 12.0]
    # called again after others were linked
    assert [each(values) for each in kernels] == [12.0, 18.0, 12.0]
