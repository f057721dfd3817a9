"""What a parameter needs that no estimator gave, named by what the log lacks of it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from parsers.signals import WHEELS
from pipelines.results import Estimate


@dataclass(frozen=True)
class _Part:
    """words: what is needed; any_of: signals one of which is it, none where no signal is (the vehicle file, the manoeuvre)."""

    words: str
    any_of: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Way:
    """One way to a parameter. words: all of it; parts: what of it signals are. file: what it takes of the vehicle file besides."""

    words: str
    parts: tuple[_Part, ...] = ()
    file: str = ""


def _each(*names: str) -> tuple[str, ...]:
    return tuple(f"{name}_{wheel}" for name in names for wheel in WHEELS)


_FORCES = _Part("suspension forces", _each("suspension_force"))
_DEFLECTIONS = _Part("suspension deflections", _each("suspension_deflection"))
_LOADS = _Part("axle loads", ("axle_load_front", "axle_load_rear", *_each("tire_normal_force")))
_LATERAL = _Part("lateral acceleration", ("accel_y",))
_ALONG = _Part("longitudinal acceleration", ("accel_x",))
_DRIVEN = _Part("drive torque", ("drive_torque", *_each("drive_torque")))
_BRAKED = _Part("brake torque", ("brake_torque", "brake_pressure", *_each("brake_torque")))
_ROLL = _Part("roll or roll rate", ("roll", "roll_rate", *_each("suspension_deflection")))


def _alone(part: _Part, words: str = "", file: str = "") -> _Way:
    return _Way(words or part.words, (part,), file)


_OF_ROLL = "lateral acceleration, roll, and the vehicle's mass"
WAYS: Mapping[str, tuple[_Way, ...]] = {
    "cg_height_m": (
        _Way("roll motion with a known roll stiffness", (_LATERAL, _ROLL)),
        _alone(_LOADS, "braking with known axle loads"),
    ),
    "mass_kg": (
        _alone(_LOADS),
        _alone(_FORCES),
        _Way("longitudinal acceleration with drive and brake torques", (_ALONG, _DRIVEN, _BRAKED)),
    ),
    "cg_to_front_axle_m": (
        _alone(_LOADS, file="wheelbase"),
        _alone(_DEFLECTIONS, "suspension deflections of both axles", "wheelbase and spring rates"),
    ),
    "cg_lateral_offset_m": (
        _alone(_DEFLECTIONS, file="tracks and spring rates"),
        _alone(_FORCES, "suspension forces of both sides", "tracks"),
    ),
    "roll_gradient_degpg": (
        _Way("lateral acceleration and roll (or roll rate) while cornering", (_LATERAL, _ROLL)),
    ),
    "roll_natural_frequency_hz": (
        _Way("lateral acceleration and roll (or roll rate) in quick steering", (_LATERAL, _ROLL)),
    ),
    "roll_damping_ratio": (
        _Way("lateral acceleration and roll (or roll rate) in quick steering", (_LATERAL, _ROLL)),
    ),
    "roll_stiffness_nmprad": (_Way(_OF_ROLL, (_LATERAL, _ROLL)),),
    "roll_damping_nmsprad": (_Way(_OF_ROLL, (_LATERAL, _ROLL)),),
    "roll_inertia_kgm2": (_Way("quick roll motion and the vehicle's mass", (_LATERAL, _ROLL)),),
}
"""The core parameters, which the verdict always holds, and the ways to each one."""


MOST_TOLD = 4
"""Estimators whose lacks are told with a parameter; those of all of them stand with the estimators."""


def why_nobody(name: str, estimates: Sequence[Estimate], signals: Collection[str] = ()) -> str:
    """Why no estimator gave a parameter: what it needs, and what the estimators said that did not run: the MOST_TOLD that lack least.

    signals: of the log.
    """
    told = [f"{e.estimator} {e.status}: {e.reason}" for e in by_lack(estimates) if e.status != "ran"]
    rest = len(told) - MOST_TOLD
    more = [f"{rest} more did not run: see each estimator's own reason"] if rest > 0 else []
    return "; ".join((f"no estimator gave it: {_needs(name, signals)}", *told[:MOST_TOLD], *more))


def by_lack(estimates: Sequence[Estimate]) -> list[Estimate]:
    """Estimates, those whose reason lists the fewest lacks first, else in their order."""
    return sorted(estimates, key=lambda each: each.reason.count("; "))


def _needs(name: str, signals: Collection[str]) -> str:
    """The ways to a parameter, of which a part is in the log first: that one by what it lacks."""
    ways = WAYS.get(name)
    if ways is None:
        return "the signals for it are not there"
    begun = [text for way in ways if (text := _beside(way, signals))]
    others = [way.words for way in ways if not _beside(way, signals)]
    return f"it needs {', or '.join([*begun, *others])}"


def _beside(way: _Way, signals: Collection[str]) -> str:
    """What a way lacks beside what of it is there; "" where all of it is missing, or none."""
    there = [part.words for part in way.parts if set(part.any_of) & set(signals)]
    lacks = [part.words for part in way.parts if not set(part.any_of) & set(signals)]
    if not lacks and way.file:
        lacks = [f"the vehicle file's {way.file}"]
    if not there or not lacks:
        return ""
    return f"{' and '.join(lacks)} beside the {' and '.join(there)} that the log has"
