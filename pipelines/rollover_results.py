"""Typed results of the rollover page: limits, margins in turns, lifted wheels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pipelines.results import Assumption, ParameterEstimate, Trace

TurnSide = Literal["left", "right"]
LiftKind = Literal["side", "wheel", "bounce"]


@dataclass(frozen=True)
class RolloverLimit:
    """One limit of the lateral acceleration, in g, for turns to either side; both positive.

    name: as in results.json; equation: its number in the dissertation. In a left turn the left wheels lift.
    """

    name: str
    title: str
    equation: str
    left: ParameterEstimate
    right: ParameterEstimate


@dataclass(frozen=True)
class TurnMargin:
    """How near the drive came to the threshold in turns to one side.

    threshold_g: quasi-static, positive. least_margin_g: limit at the body roll of that moment less lateral acceleration,
    below 0 beyond it. peak_coefficient: largest share of the weight moved across, 1 = that side's wheels carry nothing;
    lateral_acceleration_g: in that moment. probability: of having reached 1 at any time.
    """

    turn: TurnSide
    threshold_g: ParameterEstimate
    least_margin_g: ParameterEstimate
    peak_coefficient: ParameterEstimate
    time_s: float
    lateral_acceleration_g: float
    probability: float


@dataclass(frozen=True)
class WheelLift:
    """One time that a wheel carried (almost) nothing.

    wheel: "fl" … "rr", or "left", "right" where only the sum of a side is known. kind: "side" = both wheels of the side
    at once, in a turn; "wheel" = this one alone, in a turn; "bounce" = a short unloading that no turn explains.
    probability: of its force having been nought, by the force's own interval. source: where the force is from.
    """

    wheel: str
    kind: LiftKind
    start_s: float
    duration_s: float
    least_force_n: float | None
    probability: float
    lateral_acceleration_g: float | None
    source: str


@dataclass(frozen=True)
class Exceedance:
    """Probability of having exceeded the rollover threshold during the drive; None = not known, `text` says why."""

    probability: float | None
    text: str
    assumptions: tuple[str, ...] = ()


@dataclass(frozen=True)
class CoefficientCheck:
    """The rollover coefficient from tyre forces against the one from accelerations: slope, rms of the difference."""

    slope: ParameterEstimate
    rms: float
    consistent: bool
    text: str


@dataclass(frozen=True)
class Rollover:
    """Rollover limits of the vehicle, and how near this drive came. None where not known.

    threshold_g: of the side that lifts first. peak_rollover_coefficient: largest size, the value of peak_coefficient.
    turns: left, right. lift_source: where the forces behind `lifts` are from, or why there are none. traces: margin and
    coefficient over the drive.
    """

    static_stability_factor: ParameterEstimate | None = None
    threshold_g: ParameterEstimate | None = None
    peak_lateral_acceleration_g: float | None = None
    peak_rollover_coefficient: float | None = None
    peak_time_s: float | None = None
    notes: tuple[str, ...] = ()
    peak_coefficient: ParameterEstimate | None = None
    coefficient_source: str = ""
    limits: tuple[RolloverLimit, ...] = ()
    turns: tuple[TurnMargin, ...] = ()
    lifts: tuple[WheelLift, ...] = ()
    lift_source: str = ""
    exceedance: Exceedance | None = None
    check: CoefficientCheck | None = None
    traces: tuple[Trace, ...] = ()
    assumptions: tuple[Assumption, ...] = ()
