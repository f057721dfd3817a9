"""The `cogest` program: one small file a command; the only place that knows exit codes.

0 all done; 1 a known error; 2 wrong usage (typer's own); 3 a batch that finished with some drives failed.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import Annotated, ParamSpec

import typer

from cogest_cli.analyze_command import analyze
from cogest_cli.convert_command import convert
from cogest_cli.estimators_command import estimators
from cogest_cli.inspect_command import inspect
from cogest_cli.report_command import report
from parsers.errors import CogestError

P = ParamSpec("P")

app = typer.Typer(
    name="cogest",
    help="Estimate a vehicle's centre-of-gravity height, mass and suspension from its drive log, offline and honestly.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)


def _known_errors(command: Callable[P, None]) -> Callable[P, None]:
    """A known error is one line on stderr and exit code 1; an unknown one keeps its traceback."""

    @functools.wraps(command)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            command(*args, **kwargs)
        except CogestError as error:
            line = " ".join(str(error).split())
            print(f"cogest: {line}", file=sys.stderr)
            raise typer.Exit(1) from None
        except BrokenPipeError:
            # the reader of a pipe (head, less) has seen enough
            sys.stderr.close()
            raise typer.Exit(0) from None

    return wrapped


def _version(wanted: bool) -> None:
    if wanted:
        from cogest_cli.version import version

        print(f"cogest {version()}")
        raise typer.Exit


@app.callback()
def _root(
    _: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Estimate a vehicle's centre-of-gravity height, mass and suspension from its drive log."""


for _command in (analyze, inspect, convert, estimators, report):
    app.command()(_known_errors(_command))


def run() -> None:
    """The installed program's entry point."""
    app()
