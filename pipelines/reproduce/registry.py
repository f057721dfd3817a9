"""The papers that can be reproduced: one line each."""

from __future__ import annotations

import difflib
import importlib
from collections.abc import Mapping
from typing import cast

from parsers.errors import SettingsError
from pipelines.reproduce.base import Paper

PAPERS: dict[str, str] = {
    "pence": "pipelines.reproduce.pence.paper:Pence",
    "park": "pipelines.reproduce.park.paper:Park",
    "wu": "pipelines.reproduce.wu.paper:Wu",
    "gpc_filter": "pipelines.reproduce.gpc_filter.paper:GpcFilter",
    "gpc_map": "pipelines.reproduce.gpc_map.paper:GpcMap",
    "suspension_map": "pipelines.reproduce.suspension_map.paper:SuspensionMapping",
    "load_transfer": "pipelines.reproduce.load_transfer.paper:LoadTransferPaper",
    "gpc_regression": "pipelines.reproduce.gpc_regression.paper:GpcRegression",
    "berntorp": "pipelines.reproduce.berntorp.paper:Berntorp",
}
"""Name on the command line -> "module:Class"."""

RUNS = 50
RUNS_OF = {"berntorp": 1000, "pence": 200}
"""Noise seeds of a study by default; of papers that say how many they ran, theirs; more where they take seconds."""


def paper(name: str) -> Paper:
    """The paper of that name. Raises KeyError for an unknown one."""
    module, _, class_name = PAPERS[name].partition(":")
    return cast("Paper", getattr(importlib.import_module(module), class_name)())


def choose_papers(name: str | None, known: Mapping[str, str]) -> tuple[str, ...]:
    """The paper of that name, in whatever case, all for None. Raises SettingsError for an unknown one, naming the nearest."""
    if name is None:
        return tuple(known)
    name = name.lower()
    if name not in known:
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
        raise SettingsError(
            f"there is no paper {name!r}",
            hint=f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}",
            wrong_usage=True,
        )
    return (name,)
