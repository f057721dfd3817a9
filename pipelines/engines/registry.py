"""The engines that cogest has: one line each."""

from __future__ import annotations

import difflib
import importlib
from typing import cast

from parsers.errors import EngineError
from pipelines.engines.base import Engine

ENGINES: dict[str, str] = {
    "serial": "pipelines.engines.serial:SerialEngine",
    "local": "pipelines.engines.local:LocalEngine",
    "dask": "pipelines.engines.dask_cluster:DaskEngine",
}
"""name -> "module:Class". A class is made with (workers, scheduler), see `pipelines.engines.base.Engine`."""


def engine_named(name: str, workers: int | None = None, scheduler: str | None = None) -> Engine:
    """The engine of that name. Loads its module alone; starts nothing.

    workers: how many at most; None = the engine's own choice. scheduler: address of a running cluster. Raises EngineError
    for a name that is none, and for what the engine cannot do.
    """
    line = ENGINES.get(name)
    if line is None:
        near = difflib.get_close_matches(name, ENGINES, 1)
        raise EngineError(
            f'there is no engine "{name}"',
            hint=f'did you mean "{near[0]}"?' if near else f"there are {', '.join(ENGINES)}",
            wrong_usage=True,
        )
    module, _, made = line.partition(":")
    return cast("Engine", getattr(importlib.import_module(module), made)(workers, scheduler))
