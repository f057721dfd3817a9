"""Plain values need none of typer's heavy helpers; all others are judged by typer as before."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from cogest_cli.quick_options import QuickCommand, QuickGroup

ROOT = Path(__file__).resolve().parents[2]
HEAVY = ["numba", "pydantic", "polars", "scipy", "matplotlib", "rich"]


def word(text: str) -> str:
    """A parser as those of the program."""
    if text == "bad":
        raise ValueError("not that one")
    return f"<{text}>"


def app_of(group, command):
    app = typer.Typer(cls=group)

    @app.callback()
    def _root(loud: Annotated[bool, typer.Option("--loud")] = False) -> None:
        print(f"loud={loud}")

    @app.command(cls=command)
    def run(
        words: Annotated[list[str], typer.Argument(parser=word)],
        one: Annotated[str | None, typer.Option(parser=word)] = None,
        more: Annotated[list[str] | None, typer.Option(parser=word)] = None,
        text: Annotated[str, typer.Option()] = "none",
        maybe: Annotated[str | None, typer.Option()] = None,
        number: Annotated[int, typer.Option(min=0)] = 3,
        share: Annotated[float, typer.Option()] = 0.5,
        out: Annotated[Path, typer.Option()] = Path("here"),
        there: Annotated[Path | None, typer.Option(exists=True)] = None,
        flag: Annotated[bool, typer.Option("--flag")] = False,
    ) -> None:
        print([words, one, more, text, maybe, number, share, out, there, flag])

    return app


LINES = [
    "run a",
    "run a b --one c --more d --more e --text f --maybe g --number 7 --share 0.25 --out h --there . --flag",
    "--loud run a",
    "run a --number 0",
    "run a --number -1",
    "run a --number x",
    "run a --share x",
    "run a --there /nowhere/at/all",
    "run bad",
    "run a --one bad",
    "run a --more d --more bad",
    "run",
    "run a --what",
    "run a --text",
    "walk",
    "",
]


@pytest.mark.parametrize("line", LINES)
def test_every_line_gives_what_typer_alone_gives(line):
    ours, theirs = (
        CliRunner().invoke(app_of(*kinds), line.split())
        for kinds in ((QuickGroup, QuickCommand), (typer.core.TyperGroup, typer.core.TyperCommand))
    )
    assert ours.exit_code == theirs.exit_code
    assert ours.stdout == theirs.stdout
    assert ours.stderr == theirs.stderr


def loaded_by(*words: str, **environment: str) -> list[str]:
    """Which of HEAVY a run of the program has loaded at its end."""
    program = (
        "import sys\nfrom cogest_cli.main import run\n"
        "try:\n    run()\nexcept SystemExit as end:\n    assert not end.code\n"
        f"print(*[name for name in {HEAVY!r} if name in sys.modules])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *words],
        env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split("\n")[-2].split()


def test_a_conversion_loads_nothing_heavy(tmp_path):
    log = ROOT / "sample_logs" / "can" / "drive.blf"
    words = ["convert", str(log), "--out", str(tmp_path / "out")]
    cache = str(tmp_path / "cache")
    # the first start compiles
    assert "numba" in loaded_by(*words, NUMBA_CACHE_DIR=cache)
    assert loaded_by(*words, NUMBA_CACHE_DIR=cache) == []


def test_an_analysis_whose_kernels_are_made_loads_no_numba(tmp_path):
    log = ROOT / "sample_logs" / "csv" / "drive.csv"
    words = ["analyze", str(log), "--format", "json", "--out", str(tmp_path / "out")]
    # whatever was not compiled yet is at the first start
    assert "numba" not in loaded_by(*words) or "numba" not in loaded_by(*words)


@pytest.mark.parametrize(
    ("command", "option"), [("analyze", "--map"), ("inspect", "--map"), ("analyze", "--vehicle")]
)
def test_an_option_of_one_value_is_not_given_twice(cogest, command: str, option: str) -> None:
    """The first of two mapping files was lost without a word."""
    run = cogest(command, "a.csv", option, "a.toml", f"{option}=b.toml")
    assert run.code == 2
    assert f"{option} was given twice" in run.out + run.err
