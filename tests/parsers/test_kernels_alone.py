"""Reading a log of any format needs numba only to compile: loading it takes longer than most logs do."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROGRAM = """
import sys
from pathlib import Path
from parsers import allocator
from parsers.importer import ImportLog, ReadOptions
from parsers.jit import Kernel
from parsers.registry import find_importer

# short logs take the ways of long ones
allocator.LARGE_PAGE = 1 << 12
prepare = Kernel._prepare

def spy(self, shapes, args):
    call = prepare(self, shapes, args)
    print("called", self.py_func.__module__, self.py_func.__name__, self._by_numba)
    return call

Kernel._prepare = spy
root = Path(sys.argv[1])
options = ReadOptions(dbc=tuple((root / "can").glob("*.dbc")))
for path in sorted([*root.glob("*/drive*"), *root.glob("ros/*/*.db3")]):
    if path.suffix not in (".json", ".toml", ".txt", ".yaml", ".dbc"):
        log = ImportLog()
        reader = find_importer(path).open(path, options, log)
        rows = sum(chunk.time_ns.size for chunk in reader.read(frozenset(each.name for each in reader.channels)))
        print("read", path.name, rows)
        assert rows
"""


def test_no_kernel_of_the_importers_needs_numba_beside_it() -> None:
    told = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(ROOT / "sample_logs")],
        env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert told.returncode == 0, told.stderr
    lines = [line.split() for line in told.stdout.splitlines()]
    called = {" ".join(words[1:3]): words[3] for words in lines if words[0] == "called"}
    assert {"parsers.can.plain _columns", "parsers.mcap_train take_chunks"} <= set(called)
    assert sum(words[0] == "read" for words in lines) > 12
    assert [name for name, by_numba in called.items() if by_numba == "True"] == []
