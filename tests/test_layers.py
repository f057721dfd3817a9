"""Imports run one way: cogest_cli -> reports -> pipelines -> parsers; heavy libraries stay out of start-up."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
LAYERS = ("parsers", "pipelines", "reports", "cogest_cli")


def _imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield node.module


@pytest.mark.parametrize("layer", LAYERS)
def test_imports_run_one_way(layer: str) -> None:
    above = LAYERS[LAYERS.index(layer) + 1 :]
    files = sorted((ROOT / layer).rglob("*.py"))
    assert files
    wrong = [
        f"{path.relative_to(ROOT)} imports {name}"
        for path in files
        for name in _imports(path)
        if name.split(".")[0] in above
    ]
    assert not wrong


def test_no_module_is_named_like_a_library() -> None:
    libraries = {"mcap", "csv", "json", "dask", "rosbags", "can", "cantools", "polars", "typst", "html"}
    allowed = {"reports/html.py"}
    named = {
        str(path.relative_to(ROOT))
        for layer in LAYERS
        for path in (ROOT / layer).rglob("*.py")
        if path.stem in libraries
    }
    assert named <= allowed


def test_all_packages_are_listed_for_installation() -> None:
    import tomllib

    listed = set(
        tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["packages"]
    )
    found = {
        ".".join(path.parent.relative_to(ROOT).parts)
        for layer in LAYERS
        for path in (ROOT / layer).rglob("__init__.py")
    }
    assert found <= listed


def test_help_loads_no_heavy_library() -> None:
    heavy = ["numpy", "polars", "numba", "scipy", "matplotlib", "cantools", "typst", "jinja2"]
    code = f"import sys; import cogest_cli.main; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_reading_a_log_loads_no_masked_arrays() -> None:
    # some of numpy's functions load them, which takes longer than to decode a short log: `parsers.quantiles` has others
    code = """
import sys
from pathlib import Path
from cogest_cli.options import load_options
from cogest_cli.progress import ProgressLine
from parsers.load import load_drive
logs = sorted(p for f in ("can", "csv", "mcap", "mf4", "ros", "vbo") for p in Path("sample_logs", f).iterdir()
              if p.is_file() and p.suffix not in (".dbc", ".toml", ".yaml", ".json"))
told = []
for log in logs:
    load_drive([log], load_options([log], None, None, True, ProgressLine()))
    if "numpy.ma" in sys.modules and not told:
        told.append(str(log))
print(len(logs), told)
"""
    run = [sys.executable, "-c", code]
    # the first compiles what was not compiled yet, for which numba loads them
    subprocess.run(run, cwd=ROOT, capture_output=True, check=True)
    done = subprocess.run(run, cwd=ROOT, capture_output=True, text=True, check=True)
    count, told = done.stdout.strip().split(" ", 1)
    assert int(count) > 8
    assert told == "[]"
