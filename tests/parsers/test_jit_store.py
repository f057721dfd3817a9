"""Machine code of kernels on disk: found again by all that it depends on, by a second installation too, and never that of other code."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from parsers.jit import Kernel, kernel
from parsers.jit_store import _MARK, _own, _writable, key_of, read_code, write_code

ROOT = Path(__file__).resolve().parents[2]
SCALE = 3


@kernel
def total(values):
    """A number from an array, through a helper."""
    found = 0.0
    for k in range(values.size):
        found += SCALE * values[k]
    return found


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


@pytest.mark.skipif(sys.platform == "win32", reason="permissions are of POSIX")
def test_a_folder_that_others_can_write_into_gives_no_code(tmp_path):
    folder = tmp_path / "cache" / "kernels"
    assert _own(folder) == [folder]
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o777)
    _own.cache_clear()
    assert _own(folder) == []
    _own.cache_clear()


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
