"""What a model says of itself, so that an estimator that knows no vehicle can run it on a log: the record of the registry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pipelines.bayes.priors import Known
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle

Predict = Callable[[FloatArray, FloatArray, float, Mapping[str, float]], FloatArray]
"""(parameters (Q, d), inputs (n, i), step in s, given figures) -> predicted outputs (Q, n, o), from rest. A pure function."""


@dataclass(frozen=True)
class ModelParameter:
    """A parameter that a model is run at. low, high: what the model can be run at at all; priors must lie within.

    Worked with by its logarithm where low is above 0. model_error: what the model leaves out, as a share of the value; it goes
    into the interval. nuisance: estimated, but no answer of its own.
    """

    name: str
    title: str
    unit: str
    low: float
    high: float
    model_error: float = 0.03
    nuisance: bool = False


@dataclass(frozen=True)
class Given:
    """A vehicle quantity that the model takes as known, its uncertainty going into the interval.

    default: used where the vehicle file is silent, or what makes it of the rest of the file; None = the model cannot run without it.
    """

    key: str
    why: str
    default: Quantity | Callable[[Vehicle], Quantity] | None = None


@dataclass(frozen=True)
class Model:
    """A model function and all that must be known to run it on canonical signals.

    inputs, outputs: signals in the order of the function's columns. band_hz: where it holds. settle_s: how long it takes to forget
    where it started. centred: whether each input's mean is taken off (accelerations about rest). least_input: mean RMS of the
    inputs in the band from which a stretch is used, in their unit. least_explained: share of the outputs in the band that must
    follow from the model. priors: of every parameter, from a vehicle file; settings go over them.
    cutoff_hz: the low-pass of inputs and outputs alike. note: what cannot be told apart, in words. noisy_inputs: whether what the inputs
    show above the band is their noise, which then is in the band as well; an interval holds what it does.
    """

    name: str
    title: str
    source: str
    parameters: tuple[ModelParameter, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    given: tuple[Given, ...]
    predict: Predict
    priors: Callable[[Vehicle], Mapping[str, Known]]
    band_hz: tuple[float, float]
    cutoff_hz: float
    settle_s: float
    note: str = ""
    centred: bool = True
    least_input: float = 0.0
    least_explained: float = 0.8
    noisy_inputs: bool = False

    def parameter(self, name: str) -> ModelParameter:
        """By name. Raises KeyError."""
        return next(p for p in self.parameters if p.name == name)

    def figures(self, vehicle: Vehicle) -> dict[str, Quantity]:
        """The given quantities: the vehicle file's, or the defaults. Those that are missing are left out."""
        found = {}
        for given in self.given:
            usual = given.default(vehicle) if callable(given.default) else given.default
            quantity = vehicle.get(given.key) or usual
            if quantity is not None:
                found[given.key] = quantity
        return found
