"""Kernels called without numba give what plain Python gives; machine code is found again, and never that of other code."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from parsers.jit import Kernel, kernel, lean_kernel, vector_kernel
from parsers.jit_shape import leaves_of, shape_of
from parsers.jit_store import _MARK, _writable, key_of, read_code, write_code

ROOT = Path(__file__).resolve().parents[2]
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


def made(text, name="f", **known):
    """A kernel of a source text that knows these names."""
    space = {"np": np, "__name__": "made", **known}
    exec(text, space)
    return Kernel(space[name])


def test_the_key_changes_with_all_that_is_compiled_in():
    text = "def f(a):\n return g(a) + C + T[0]\n"
    inner = "def f(a):\n return a + D\n"
    table = np.arange(3)

    def key(text=text, inner=inner, c=1, d=1, t=table, manner="whole"):
        helper = made(inner, D=d)
        helper.manner = manner
        return key_of(made(text, g=helper, C=c, T=t), (int,))

    first = key()
    assert key() == first
    others = [
        key(text=text.replace("+ C", "- C")),
        key(text=text.replace("T[0]", "T[1]")),
        key(inner=inner.replace("+", "*")),
        key(c=2),
        key(c=1.0),
        key(d=2),
        key(t=np.arange(1, 4)),
        key(t=(0, 1)),
        key(manner="lean"),
        key(manner="vector"),
    ]
    assert len({first, *others}) == 11


def test_the_key_sees_closures_and_endless_circles():
    def outer(n):
        def f(a):
            return a + n

        return Kernel(f)

    assert key_of(outer(1)) != key_of(outer(2))
    loop = made("def f(a):\n return f(a - 1) if a else 0\n")
    assert key_of(loop) == key_of(loop)


ALL_KEYS = """
import importlib, pkgutil
import parsers, pipelines
from parsers.jit import Kernel
from parsers.jit_store import key_of

for package in (parsers, pipelines):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        for name, value in sorted(vars(importlib.import_module(module.name)).items()):
            if isinstance(value, Kernel):
                print(module.name, name, key_of(value))
"""


def test_no_kernels_key_hangs_on_the_terminal_that_it_is_started_from(tmp_path):
    """One that did was compiled anew, for half a minute, in every other shell."""
    found = []
    for seed in ("1", "2"):
        told = {
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "PYTHONHASHSEED": seed,
            "TERM_SESSION_ID": seed * 3,
            "NUMBA_DISABLE_JIT": "0",
        }
        place = tmp_path / seed
        place.mkdir()
        done = subprocess.run(
            [sys.executable, "-c", ALL_KEYS], capture_output=True, text=True, env=told, cwd=place, check=True
        )
        found.append(done.stdout.splitlines())
    assert len(found[0]) > 400
    assert found[0] == found[1]


def test_damaged_files_count_as_none(monkeypatch, tmp_path):
    monkeypatch.setattr("parsers.jit_store._folders", lambda _: [tmp_path])
    assert read_code(total, "k") is None
    write_code(total, "k", b"code\n\0", "(qd")
    assert read_code(total, "k") == (b"code\n\0", "(qd")
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    for damaged in (whole[:-1], whole[: len(_MARK)], b"", whole + b"x", b"other" + whole):
        file.write_bytes(damaged)
        assert read_code(total, "k") is None


PROGRAM = """
import sys
import numpy as np
from parsers.jit import kernel
HEAVY = {heavy}

@kernel
def f(values, k):
    found = np.zeros(3)
    for value in values:
        found[k] += value * {factor}
    return found[k]

print(f(np.arange(4.0), 1), "numba" in sys.modules)
"""


def run(folder, factor=2):
    (folder / "program.py").write_text(PROGRAM.format(heavy="{}", factor=factor), encoding="utf-8")
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, str(folder / "program.py")],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split()


def test_a_later_start_needs_no_numba_and_a_change_does(tmp_path):
    assert run(tmp_path) == ["12.0", "True"]
    assert run(tmp_path) == ["12.0", "False"]
    assert run(tmp_path, factor=3) == ["18.0", "True"]
    assert run(tmp_path, factor=3) == ["18.0", "False"]


OF_THE_HOUSE = """
import sys
import numpy as np
from parsers.blf_objects import first_object

assert first_object(np.zeros(99, np.uint8), 0, 99) == -1
print("numba" in sys.modules)
"""


def test_a_second_installation_takes_what_the_first_compiled(tmp_path):
    """An environment made afresh, a new version: only what changed is compiled again."""
    found = []
    for name in ("first", "second"):
        packages = tmp_path / name
        shutil.copytree(ROOT / "parsers", packages / "parsers", ignore=shutil.ignore_patterns("__pycache__"))
        environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache"), "PYTHONPATH": str(packages)}
        environment.pop("NUMBA_CACHE_DIR", None)
        done = subprocess.run(
            [sys.executable, "-c", OF_THE_HOUSE],
            env=environment,
            cwd=packages,
            capture_output=True,
            text=True,
            check=True,
        )
        found.append(done.stdout.strip())
        beside = list((packages / "parsers" / "__pycache__").glob("*.kernel"))
        assert bool(beside) == (name == "first")
    assert found == ["True", "False"]


HELPER = """
from parsers.jit import lean_kernel

@lean_kernel
def times(value):
    return {factor} * value
"""

BY_NUMBA = """
import numpy as np
from helper import times
from parsers.jit import kernel

@kernel
def f(values):
    found = np.empty_like(values)
    for k in range(values.size):
        found[k] = times(values[k])
    return found

print(f(np.ones(1)).tolist()[0], f._by_numba, sum(f.dispatcher.stats.cache_hits.values()))
"""


def test_a_helper_changed_in_another_file_is_seen_by_kernels_that_go_through_numba(tmp_path):
    """numba's own cache looks at the kernel's file alone."""
    program = tmp_path / "by_numba.py"
    program.write_text(BY_NUMBA, encoding="utf-8")
    paths = os.pathsep.join((str(ROOT), str(tmp_path)))
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": paths}
    found = []
    for factor in (2.0, 2.0, 3.0, 2.0):
        # a size of its own each: Python's own cache of compiled text knows a file by its second and its size
        text = HELPER.format(factor=factor) + "#" * len(found)
        (tmp_path / "helper.py").write_text(text, encoding="utf-8")
        done = subprocess.run(
            [sys.executable, str(program)], env=environment, capture_output=True, text=True, check=True
        )
        found.append(done.stdout.split())
    assert found == [["2.0", "True", "0"], ["2.0", "True", "1"], ["3.0", "True", "0"], ["2.0", "True", "1"]]


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


def test_a_version_of_numba_that_nobody_tried_calls_its_kernels_itself(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr("parsers.jit_compile.TRIED", frozenset())
    _writable.cache_clear()
    fresh = kernel(total.py_func)
    values = np.arange(5.0)
    assert fresh(values) == total.py_func(values) == 30.0
    kept = list(tmp_path.rglob("*.kernel"))
    assert kept
    assert all(place.stat().st_size < 100 for place in kept), "machine code was kept"
    _writable.cache_clear()
