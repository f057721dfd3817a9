"""Priors of a model's parameters: from a settings file's tables, over those that the model has from the vehicle file."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import replace

from pipelines.bayes.priors import Beta, Distribution, Known, Normal, Priors, Uniform
from pipelines.estimators.base import PriorEntry, PriorError
from pipelines.models.record import Model, ModelParameter
from pipelines.vehicles.vehicle import Vehicle

FORMS: Mapping[str, tuple[str, ...]] = {
    "uniform": ("low", "high"),
    "normal": ("value", "std"),
    "beta": ("low", "high", "a", "b"),
}


BEYOND = 0.25


SETTINGS_FILE = "settings file"
"""Source of a prior that the user wrote for this run."""


def _nearest(word: str, known: tuple[str, ...]) -> str:
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"


def distribution(entry: PriorEntry, spec: ModelParameter) -> Distribution:
    """A prior as written, within what the model can be run at. Raises PriorError that names what is wrong."""
    form = entry.get("distribution")
    if not isinstance(form, str) or form not in FORMS:
        known = tuple(FORMS)
        hint = _nearest(form, known) if isinstance(form, str) else f"known are {', '.join(known)}"
        raise PriorError(spec.name, f"found distribution {form!r}", hint)
    needed = FORMS[form]
    for key in entry:
        if key != "distribution" and key not in needed:
            raise PriorError(spec.name, f"unknown key {key!r}", _nearest(key, needed))
    figures: list[float] = []
    for key in needed:
        value = entry.get(key)
        if not isinstance(value, float):
            raise PriorError(
                spec.name, f"no number `{key}`", f"a {form} prior has {', '.join(needed)}, in {spec.unit}"
            )
        figures.append(value)
    try:
        return _made(form, figures, spec)
    except PriorError:
        raise
    except ValueError as error:
        raise PriorError(spec.name, str(error)) from error


def _made(form: str, figures: list[float], spec: ModelParameter) -> Distribution:
    allowed = f"the model can be run from {spec.low:g} to {spec.high:g} {spec.unit}"
    if form == "normal":
        value, std = figures
        if not spec.low < value < spec.high:
            raise PriorError(spec.name, f"found {value:g}", allowed)
        return Normal(value, std, spec.low, spec.high)
    if figures[0] < spec.low or figures[1] > spec.high:
        raise PriorError(spec.name, f"found {figures[0]:g} to {figures[1]:g}", allowed)
    return Uniform(*figures) if form == "uniform" else Beta(*figures)


def check_priors(model: Model, priors: Mapping[str, PriorEntry]) -> None:
    """Raise PriorError for a prior of a parameter that the model does not have, or one that cannot be."""
    names = tuple(p.name for p in model.parameters)
    for name, entry in priors.items():
        if name not in names:
            raise PriorError(
                name[:100], f"the model {model.name!r} has no such parameter", _nearest(name, names)
            )
        distribution(entry, model.parameter(name))


def _room(item: Known, spec: ModelParameter) -> tuple[float, float]:
    """Where a turned domain may reach: a part of the prior's width beyond it, as far as the model can be run."""
    low, high = item.distribution.reach
    if item.log:
        beyond = (high / low) ** BEYOND
        low, high = low / beyond, high * beyond
    else:
        beyond = BEYOND * (high - low)
        low, high = low - beyond, high + beyond
    return max(low, spec.low), min(high, spec.high)


def priors_of(model: Model, vehicle: Vehicle, written: Mapping[str, PriorEntry]) -> Priors:
    """The model's priors with those of the settings file in their places."""
    usual = model.priors(vehicle)
    items = []
    for spec in model.parameters:
        if spec.name in written:
            made = distribution(written[spec.name], spec)
            item = Known(spec.name, made, spec.low > 0 and made.reach[0] > 0, SETTINGS_FILE)
        else:
            item = usual[spec.name]
        items.append(replace(item, runs=_room(item, spec)))
    return Priors(tuple(items))
