"""Ways to run cogest: the installed program in a process of its own, and the same commands in this process."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cogest_cli.main import app

PROGRAM = Path(sys.executable).parent / "cogest"

QUICK = "[roll_map]\ndraws = 1000\nmax_rows = 1000\n"
"""Settings for tests that do not look at the figures."""


@dataclass(frozen=True)
class Run:
    """What a run gave."""

    code: int
    out: str
    err: str


Runner = Callable[..., Run]


@pytest.fixture(scope="session")
def cogest() -> Runner:
    """Run the installed program: cogest("analyze", log, …)."""

    def run(*arguments: object, **environment: str) -> Run:
        done = subprocess.run(
            [os.fsencode(PROGRAM), *(os.fsencode(str(a)) for a in arguments)],
            capture_output=True,
            env={**os.environ, "COLUMNS": "80", **environment},
            timeout=300,
            check=False,
        )
        return Run(done.returncode, done.stdout.decode(), done.stderr.decode())

    return run


@pytest.fixture(scope="session")
def program() -> list[str]:
    """The installed program as a command: for tests that start it and go on."""
    return [str(PROGRAM)]


@pytest.fixture(scope="session")
def inside() -> Runner:
    """Run a command in this process: no start-up time."""

    def run(*arguments: object) -> Run:
        done = CliRunner().invoke(app, [str(a) for a in arguments])
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        return Run(done.exit_code, done.stdout, done.stderr)

    return run


@pytest.fixture(scope="session")
def quick(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A settings file that makes the estimator quick."""
    path = tmp_path_factory.mktemp("settings") / "quick.toml"
    path.write_text(QUICK, encoding="utf-8")
    return path


@pytest.fixture
def drive(tmp_path: Path, samples: Path) -> Path:
    """A copy of the CSV sample in a folder of its own."""
    path = tmp_path / "drive.csv"
    path.write_bytes((samples / "csv" / "drive.csv").read_bytes())
    return path
