"""A suspension map: what a drive with measuring wheels taught of how a vehicle's suspension carries it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pipelines.results import FloatArray
from pipelines.suspension_mapping.regressors import Shape, Springs

SPREAD: tuple[str, ...] = ("constant", "lateral", "longitudinal", "quick", "hop")
"""What the residual's variance grows with: nothing, a_y², a_x², (rate of a_y)², (deflection's speed)²; see `spread`."""


@dataclass(frozen=True)
class Seen:
    """What a regressor was in training: its lowest and highest value (0.1 and 99.9 %), mean and standard deviation."""

    low: float
    high: float
    mean: float
    std: float


@dataclass(frozen=True)
class WheelMap:
    """One wheel. coefficients: regressor -> value; covariance (p, p) in their order; seen: regressor -> range.

    spread: the residual's variance, N² and N² a unit of what it grows with, in the order of SPREAD. factor: on the
    residual's standard deviation so that 1.96 of it held 95 % of the held-out residuals. carried_n: mean force on the
    suspension in training. zero_n: standard deviation of what the zeros drift from drive to drive. rms_n, peak_n, peak_s:
    of the training's residual; held_out_n: rms over manoeuvres that were left out.
    """

    coefficients: Mapping[str, float]
    covariance: FloatArray
    seen: Mapping[str, Seen]
    spread: tuple[float, ...]
    factor: float
    carried_n: float
    zero_n: float
    rms_n: float
    peak_n: float
    peak_s: float
    held_out_n: float


@dataclass(frozen=True)
class MapPart:
    """The mapping from one kind of sensors: struts, or springs (deflections alone). springs: wheel -> law, for the latter.

    held_out: form -> rms over left-out manoeuvres, over all wheels; the form with the least was chosen.
    """

    kind: str
    form: str
    wheels: Mapping[str, WheelMap]
    springs: Mapping[str, Springs]
    held_out: Mapping[str, float]


@dataclass(frozen=True)
class TrainingDrive:
    """A drive that a map was trained on."""

    log: str
    sha256: str
    duration_s: float


@dataclass(frozen=True)
class SuspensionMap:
    """A map file's content. parts: "struts" and "springs", what the training drives had. band_hz: low-pass of all signals."""

    vehicle: str
    band_hz: float
    shape: Shape
    training: tuple[TrainingDrive, ...]
    parts: Mapping[str, MapPart]
    zero_from: str
