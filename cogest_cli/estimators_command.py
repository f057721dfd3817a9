"""`cogest estimators`: the methods, what they need and where they are from."""

from __future__ import annotations

from typing import Annotated

import typer


def estimators(
    settings: Annotated[
        bool, typer.Option("--settings", help="Print a settings file with every default instead.")
    ] = False,
) -> None:
    """List the estimators with their needs, parameters and sources."""
    from cogest_cli.output import show, show_line
    from pipelines.estimators.registry import estimators as known
    from pipelines.settings import settings_text

    if settings:
        show(settings_text(known()).rstrip("\n"))
        return
    for estimator in known():
        show_line(f"{estimator.name}: {estimator.title}")
        show_line(f"  source: {estimator.source}")
        for need in (*estimator.signal_needs, *estimator.vehicle_needs):
            show_line(f"  needs {' or '.join(need.any_of)}: {need.why}")
        show_line(f"  gives {', '.join(estimator.parameters)}")
