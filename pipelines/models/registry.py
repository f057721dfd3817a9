"""The models that the general engine can be given from a settings file: one line each, name -> "module:ATTRIBUTE"."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from functools import cache
from typing import cast

from pipelines.models.record import Model

_HERE = "pipelines.models.described"

MODELS: Mapping[str, str] = {
    "base_excitation_3dof": f"{_HERE}.base_excitation_3dof:MODEL",
    "quarter_car": f"{_HERE}.quarter_car:MODEL",
    "roll": f"{_HERE}.roll:MODEL",
    "axle_load": f"{_HERE}.axle_load:MODEL",
}


@cache
def model_at(line: str) -> Model:
    """The model that a registry line names. Loaded when first asked for."""
    module, _, attribute = line.partition(":")
    return cast("Model", getattr(importlib.import_module(module), attribute))


def model(name: str) -> Model:
    """The model of that name. Raises KeyError for an unknown one."""
    return model_at(MODELS[name])
