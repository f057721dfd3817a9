"""The installed program as such: its version, its help, pipes, narrow encodings, odd file names."""

from __future__ import annotations

import ast
import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cogest_cli.main import app
from cogest_cli.version import version
from parsers.algebra_threads import ALGEBRA_THREADS
from pipelines.estimators.registry import estimators
from pipelines.settings import defaults, texts

PROGRAM = Path(sys.executable).parent / "cogest"


def test_version_help_and_wrong_usage(cogest):
    run = cogest("--version")
    assert (run.code, run.out, run.err) == (0, f"cogest {version()}\n", "")
    run = cogest("--help")
    assert run.code == 0
    for command in ("analyze", "inspect", "convert", "estimators", "report"):
        assert command in run.out
    wrong = cogest("analyse")
    assert (wrong.code, wrong.out) == (2, "")


def test_estimators_and_their_settings(inside):
    run = inside("estimators")
    assert run.code == 0
    for estimator in estimators():
        assert f"{estimator.name}: {estimator.title}" in run.out
        assert estimator.source in run.out
    settings = tomllib.loads(inside("estimators", "--settings").out)
    words = {e.name: {t.name: t.default for t in texts(e)} for e in estimators()}
    assert settings == {e.name: defaults(e) | words[e.name] for e in estimators()}


def test_a_reader_that_has_seen_enough_is_no_error():
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run([PROGRAM, "--version"], stdout=writing, stderr=subprocess.PIPE, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_terminal_that_knows_ascii_only(cogest, samples, quick, tmp_path):
    narrow = {"LC_ALL": "C", "PYTHONIOENCODING": "ascii"}
    log = samples / "vbo" / "drive.vbo"
    run = cogest("analyze", log, "--format", "json", "--settings", quick, "--out", tmp_path / "out", **narrow)
    assert (run.code, run.err) == (0, "")
    assert "95 % interval" in run.out
    assert run.out.isascii()


def test_json_is_whole_where_only_ascii_gets_through(samples):
    run = CliRunner(charset="ascii").invoke(app, ["inspect", str(samples / "vbo" / "drive.vbo"), "--json"])
    assert run.exit_code == 0
    assert run.stdout_bytes.isascii()
    found = json.loads(run.stdout_bytes)
    assert "°/s" in {channel["unit"] for channel in found["channels"]}


def test_a_file_name_that_is_no_text(cogest, samples, tmp_path):
    name = b"a\nb\x1b[31m \xff.csv"
    log = Path(os.fsdecode(os.fsencode(tmp_path) + b"/" + name))
    shutil.copy(samples / "csv" / "drive.csv", log)
    done = subprocess.run(
        [PROGRAM, "convert", log, "--out", tmp_path / "tables"], capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")
    record = json.loads((tmp_path / "tables" / "import_record.json").read_text(encoding="utf-8"))
    assert record["paths"][0].endswith("a\nb\x1b[31m ?.csv")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_full_disk_is_one_line():
    with Path("/dev/full").open("wb") as out:
        done = subprocess.run([PROGRAM, "--version"], stdout=out, stderr=subprocess.PIPE, check=False)
    assert done.returncode == 1
    assert done.stderr.startswith(b"cogest: no space left")
    assert done.stderr.count(b"\n") == 1


ALGEBRA = """
import sys
import cogest_cli.main
assert not {"numpy", "scipy"} & set(sys.modules), "loaded before the limit is set"
sys.argv = ["cogest", "--version"]
try:
    cogest_cli.main.run()
except SystemExit:
    pass
import scipy.linalg
from threadpoolctl import threadpool_info
print([library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"])
"""


@pytest.mark.parametrize(("told", "threads"), [(None, 1), ("2", 2)])
def test_linear_algebra_runs_on_one_thread_unless_told_otherwise(told: str | None, threads: int) -> None:
    environment = {name: value for name, value in os.environ.items() if name not in ALGEBRA_THREADS}
    if told:
        environment |= dict.fromkeys(ALGEBRA_THREADS, told)
    done = subprocess.run(
        [sys.executable, "-c", ALGEBRA], env=environment, capture_output=True, text=True, check=True
    )
    found = ast.literal_eval(done.stdout.splitlines()[-1])
    assert found
    assert set(found) == {min(threads, os.cpu_count() or 1)}


def test_it_runs_as_a_module() -> None:
    """For who has no scripts on the path."""
    done = subprocess.run(
        [sys.executable, "-m", "cogest_cli", "--version"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0
    assert done.stdout.startswith("cogest ")
