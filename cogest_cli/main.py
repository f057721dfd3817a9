"""The `cogest` program: one small file a command; the only place that knows exit codes.

0 all done; 1 a known error; 2 wrong usage (typer's own, and names that cogest does not know); 3 a batch that finished with some drives failed;
130 interrupted.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import gc
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable
from typing import Annotated, ParamSpec

import typer

from cogest_cli.analyze_command import analyze
from cogest_cli.batch_command import batch
from cogest_cli.convert_command import convert
from cogest_cli.estimators_command import estimators
from cogest_cli.inspect_command import inspect
from cogest_cli.output import (
    MACHINE_ERRORS,
    complain,
    drop_output,
    finish_output,
    forgive_encodings,
    machine_error,
)
from cogest_cli.quick_options import QuickCommand, QuickGroup
from cogest_cli.report_command import report
from cogest_cli.reproduce_command import reproduce
from cogest_cli.results_command import results
from cogest_cli.simulate_command import simulate
from cogest_cli.suspension_map_command import suspension_map
from parsers.algebra_threads import one_algebra_thread
from parsers.errors import CogestError

P = ParamSpec("P")

TURN_S = 0.0005

WRONG_USAGE = 2
INTERRUPTED = 130
TERMINATED = 143
"""What a shell gives for a program that Ctrl-C ended."""

app = typer.Typer(
    name="cogest",
    cls=QuickGroup,
    help="Estimate a vehicle's centre-of-gravity height, mass and suspension from its drive log, offline and honestly.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)


class _Terminated(KeyboardInterrupt):
    """A scheduler wants the command to end: what Ctrl-C puts away is put away."""


def _end_on_sigterm() -> None:
    """SIGTERM ends a command as Ctrl-C does. Only the main thread may say so; processes that are started do not inherit it."""

    def end(number: int, frame: object) -> None:
        raise _Terminated

    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, end)


def _known_errors(command: Callable[P, None]) -> Callable[P, None]:
    """A known error is one line on stderr and exit code 1, or 2 for wrong usage; an unknown one keeps its traceback."""

    @functools.wraps(command)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            command(*args, **kwargs)
        except CogestError as error:
            complain(error)
            raise typer.Exit(WRONG_USAGE if error.wrong_usage else 1) from None
        except MemoryError:
            complain("not enough memory for this log; analyse it in parts, or on a machine with more")
            raise typer.Exit(1) from None
        except KeyboardInterrupt as end:
            terminated = isinstance(end, _Terminated)
            complain("ended by SIGTERM" if terminated else "interrupted")
            raise typer.Exit(TERMINATED if terminated else INTERRUPTED) from None
        except BrokenPipeError:
            # the reader of a pipe (head, less) has seen enough
            drop_output()
            raise typer.Exit(0) from None
        except OSError as error:
            if error.errno not in MACHINE_ERRORS:
                raise
            raise typer.Exit(machine_error(error)) from None

    return wrapped


@_known_errors
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


for _command in (
    analyze,
    batch,
    results,
    report,
    inspect,
    convert,
    estimators,
    reproduce,
    simulate,
    suspension_map,
):
    app.command(cls=QuickCommand)(_known_errors(_command))


def program() -> None:
    """The installed program's entry point: `run`, and out.

    Taking apart what lies in memory, object by object, would take a fifth of the time of a short command.
    """
    code = 0
    try:
        run()
    except SystemExit as end:
        if end.code is not None and not isinstance(end.code, int):
            raise
        code = end.code or 0
    # temporary files are removed, streams flushed, as at any other end
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        # a stream that the caller closed (`>&-`) is None, whatever its type says
        with contextlib.suppress(OSError, ValueError, AttributeError):
            stream.flush()
    os._exit(code & 0xFF)


def run() -> None:
    """One command, with its exit code as SystemExit."""
    # importing makes two hundred thousand objects and no garbage: looking for some costs a short command 6 % of its time
    gc.set_threshold(300_000, 20, 20)
    # threads that hash, unpack and pack come back for the interpreter's lock: by default they wait up to 5 ms each time
    sys.setswitchinterval(TURN_S)
    one_algebra_thread()
    _end_on_sigterm()
    forgive_encodings()
    if not sys.warnoptions:
        # a library's word to its programmers tells a user nothing; tests turn each into an error
        warnings.simplefilter("ignore")
    try:
        app()
    except SystemExit as end:
        # what is still in the buffer is written now, while an error can be told
        sys.exit(finish_output() or end.code)
    except OSError as error:
        if error.errno not in MACHINE_ERRORS:
            raise
        sys.exit(machine_error(error))
