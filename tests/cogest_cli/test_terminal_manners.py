"""Help texts are whole, closed streams and refusals of the machine are no crash."""

from __future__ import annotations

import re
import resource
import subprocess
from pathlib import Path

import pytest
import typer

from cogest_cli.main import app


def test_no_help_text_loses_its_brackets(inside) -> None:
    """What stands in square brackets is markup to the library that draws the help, and vanishes."""
    commands = typer.main.get_command(app).commands
    assert len(commands) >= 10
    for name, command in commands.items():
        drawn = re.sub(r"[\s│]+", "", inside(name, "--help").out)
        for parameter in command.params:
            text = getattr(parameter, "help", None) or ""
            assert re.sub(r"\s+", "", text).rstrip(".") in drawn, (name, parameter.name)


def test_a_closed_standard_output_is_no_crash(program, samples) -> None:
    log = samples / "csv" / "drive.csv"
    command = f'"{program[0]}" inspect "{log}" >&-'
    done = subprocess.run(["sh", "-c", command], stderr=subprocess.PIPE, check=False)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_limit_on_file_sizes_is_one_line(program, samples, tmp_path: Path) -> None:
    done = subprocess.run(
        [*program, "simulate", "mixed_minute", "--out", tmp_path / "drive.csv"],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000)),
        capture_output=True,
        check=False,
    )
    assert done.returncode == 1
    assert done.stderr.startswith(b"cogest: ")
    assert done.stderr.count(b"\n") == 1


@pytest.mark.parametrize(("number", "words"), [(30, "Read-only file system"), (27, "no space left")])
def test_what_the_machine_refuses_is_one_line(number: int, words: str, inside, monkeypatch, samples) -> None:
    def refused(*_: object, **__: object) -> None:
        raise OSError(number, "Read-only file system", "/tmp/some.svg")

    monkeypatch.setattr("pipelines.inspection.inspect_log", refused)
    run = inside("inspect", samples / "csv" / "drive.csv")
    assert run.code == 1
    assert words in run.err
    assert run.err.count("\n") == 1
