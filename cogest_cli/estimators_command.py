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
    from pipelines.estimators.registry import estimators as known
    from pipelines.settings import settings_text

    if settings:
        print(settings_text(known()), end="")
        return
    for estimator in known():
        print(f"{estimator.name}: {estimator.title}")
        print(f"  source: {estimator.source}")
        for need in (*estimator.signal_needs, *estimator.vehicle_needs):
            print(f"  needs {' or '.join(need.any_of)}: {need.why}")
        print(f"  gives {', '.join(estimator.parameters)}")
