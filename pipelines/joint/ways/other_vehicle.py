"""Is the file another vehicle's? Then none of its figures holds, and what the log tells with them is of nobody.

Vehicles ride on springs that go by their mass, and turn over by inertias that go by mass and size: with the file of another one the
balances often agree with each other, and only what has no such law (the wheelbase that the road shows, the steering ratio) stands out.
A sedan with a van's file had its wheelbase blamed alone, and its mass told 50 % too large, identified. So all of the file is opened
at once, bound as vehicles are, and compared with the file as it stands and with one wrong figure.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipelines.evidence import Evidence, Values
from pipelines.joint.doubts.stated_figures import exact
from pipelines.joint.file_check import BARS, stated_unknowns
from pipelines.joint.posterior import Joint, find_mode
from pipelines.joint.vehicle.plain_names import plain_name
from pipelines.joint.vehicle.unknowns import AXLES, Known
from pipelines.joint.ways.file_ways import OPEN, joined_again, opened
from pipelines.joint.ways.rigid_tyres import log_odds
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

NAME = "a vehicle file that is another vehicle's"
TEXT = f"{NAME}: the drive fits no vehicle with what it states, and was joined with all of its figures open"

LIKELY = 0.5
"""Chance from which on nothing that the posterior tells is an answer: what the file leaves open is wider than any interval of it."""

ANOTHERS = "the vehicle file seems to be another vehicle's"
"""With what the reason of an answer begins that is none for it."""

STATED_ALL = "stated"
"""What the titles of all groups of stated figures begin with: of none of them is the posterior's."""

CHANCE = 0.01
"""Beforehand."""

TURNS: tuple[tuple[float, float], ...] = ((0.12, 0.6), (0.2, 2.0), (math.inf, 15.0))
"""Steering ratio times wheelbase off by up to that share, with the wheelbase that comes out, and how much more often it is so with
another vehicle's file than with this one's: most cars have ratios of 14 to 17, variable racks are off by a tenth, one file in
seventy has a wrong ratio."""

UNLIKE = 0.2
"""From which share on the question is asked though nothing else contradicts the rest."""

FAR_OFF, RATHER = 0.04, 0.3
"""Share by which a wheelbase must be another for it to be rather another vehicle's than a slip of the pen, and the least chance of that
beside the slip: how far vehicles are alike is known too roughly for the log to leave it out. Three of 36 drives of a blind simulator with
other vehicles' files had their wheelbase blamed alone, or nothing, and masses up to 19 standard deviations off, identified."""

TURNED = 0.5
"""Least chance of another vehicle's file, beside the likeliest other cause of a contradiction, where the drive turns unlike the file's vehicle
too: one of the two would have to be chance."""

SHARE: Mapping[str, float] = {
    "wheelbase": 0.12, "track_front": 0.06, "track_rear": 0.06, "empty_mass": 0.4, "empty_h": 0.15, "spring_front": 0.5,
    "spring_rear": 0.5, "tyre_rate": 0.35, "unsprung_front": 0.35, "unsprung_rear": 0.35, "radius": 0.07, "wheel_inertia": 0.5,
    "roll_inertia": 0.45, "pitch_inertia": 0.5, "drag": 0.4, "brake_gain": 0.5, "bump_front": 0.5, "bump_rear": 0.5,
    "rebound_front": 0.5, "rebound_rear": 0.5,
}  # fmt: skip
"""Standard deviation over the file's figure: how far vehicles whose files lie in one folder differ."""

ALONG = 0.06
"""The same of the CG's place along, over the wheelbase."""

METRES: Mapping[str, float] = {
    "roll_center_front": 0.08, "roll_center_rear": 0.1, "pitch_center_brake": 0.06, "pitch_center_drive": 0.06, "imu_x": 0.5,
    "imu_h": 0.15,
}  # fmt: skip
SINKS = 0.5

BOUND: tuple[tuple[str, float, Mapping[str, int]], ...] = (
    *((f"spring_{axle}", 0.2, {"empty_mass": 1}) for axle in AXLES),
    *((f"unsprung_{axle}", 0.2, {"empty_mass": 1}) for axle in AXLES),
    ("tyre_rate", 0.2, {"empty_mass": 1}),
    ("brake_gain", 0.3, {"empty_mass": 1}),
    ("roll_inertia", 0.12, {"empty_mass": 1, "track_front": 2}),
    ("pitch_inertia", 0.12, {"empty_mass": 1, "wheelbase": 2}),
)
"""What goes by what, with which power, and how closely."""


def _bound(known: Known, name: str, spread: float, by: Mapping[str, int]) -> Evidence:
    """That an unknown goes by others as it does in the file's vehicle."""
    usual = {n: float(known.mean[known.index(n)]) for n in (name, *by)}

    def predict(values: Values) -> FloatArray:
        share = np.asarray(values[name]) / usual[name]
        for other, power in by.items():
            share = share / (np.asarray(values[other]) / usual[other]) ** power
        return share[None] if share.ndim else np.array([share])

    return Evidence(
        "length", "vehicle file", f"{plain_name(name)} by {' and '.join(map(plain_name, by))}", "vehicle file", np.ones(1), np.array([[spread**2]]), predict,
        (name, *by),
    )  # fmt: skip


def another(known: Known, vehicle: Vehicle) -> tuple[Known, tuple[Evidence, ...]]:
    """The unknowns of any vehicle somewhat like the file's, and what binds them. What is stated as exact stays so."""
    std = known.std.copy()
    for name, share in SHARE.items():
        row = known.index(name)
        if not exact(known, (name,)):
            std[row] = math.hypot(std[row], share * known.mean[row])
    more = {**METRES, **{f"sinks_{axle}": SINKS for axle in AXLES}}
    more["empty_x"] = ALONG * float(known.mean[known.index("wheelbase")])
    for name, metres in more.items():
        row = known.index(name)
        if not exact(known, (name,)):
            std[row] = math.hypot(std[row], metres)
    free = replace(known, std=std)
    bars = stated_unknowns(vehicle).get(BARS)
    if bars and not exact(known, bars):
        free = opened(free, bars, OPEN[BARS])
    return free, tuple(_bound(known, *each) for each in BOUND if known.mean[known.index(each[0])] > 0)


def _lacking(evidence: Sequence[Evidence], known: Known) -> float:
    """ln of the mass that a prior lacks which is a normal law times relations, no factor of it being one by itself."""
    if not evidence:
        return 0.0
    before = find_mode(evidence, known)
    return before.cost - 0.5 * float(np.linalg.slogdet(before.covariance)[1])


def _length(found: Joint, known: Known) -> float:
    """The wheelbase of a posterior over the file's."""
    row = known.index("wheelbase")
    return float(found.known.mean[row] + found.known.std[row] * found.u[row]) / float(known.mean[row])


def least_odds(odds: float, found: Joint, known: Known) -> float:
    """Least ln odds of another vehicle's file beside those of a wrong wheelbase, with its posterior; none where it is nearly the stated one."""
    if abs(_length(found, known) - 1) < FAR_OFF:
        return -math.inf
    return odds + math.log(RATHER / (1 - RATHER))


def _turns(found: Joint, known: Known, vehicle: Vehicle) -> float:
    """ln of how much likelier the drive's turning makes it."""
    if vehicle.turning is None:
        return 0.0
    off = abs(vehicle.turning / _length(found, known) - 1)
    return math.log(next(ratio for most, ratio in TURNS if off <= most))


def turned_odds(found: Joint, known: Known, vehicle: Vehicle, others: float) -> float:
    """Least ln odds of another vehicle's file, with its posterior, beside other causes of a contradiction (the ln odds of the likeliest); none
    where nothing else is likelier than no cause at all, or the drive turns as the file's vehicle does."""
    if others <= 0 or vehicle.turning is None or abs(vehicle.turning / _length(found, known) - 1) < UNLIKE:
        return -math.inf
    return others + math.log(TURNED / (1 - TURNED))


def other_ways(
    joint: Joint, drive: Sequence[Evidence], stated: Sequence[Evidence], known: Known, vehicle: Vehicle
) -> Iterator[tuple[float, Joint, Known, tuple[Evidence, ...]]]:
    """ln odds with the log that the file is another vehicle's, the posterior with that, unknowns and relations.

    drive: relations of the drive; stated: those that the file binds, none of which is this vehicle's then. Nothing where the file
    states too little to be anybody's.
    """
    if vehicle.get("mass_kg") is None or vehicle.get("wheelbase_m") is None:
        return
    free, bound = another(known, vehicle)
    whole = (*drive, *bound)
    found = joined_again(joint, whole, known, free)
    odds = log_odds(joint, found) + _lacking(bound, free) - _lacking(stated, known)
    before = math.log(CHANCE / (1 - CHANCE)) + _turns(found, known, vehicle)
    yield odds + before, found, free, whole


def without_answers(
    parameters: Mapping[str, ParameterEstimate], chance: float
) -> dict[str, ParameterEstimate]:
    """The answers of a drive whose file is another vehicle's by that chance: none, from LIKELY on, but what is left open."""
    if chance < LIKELY:
        return dict(parameters)
    words = f"{ANOTHERS} (odds {chance:.0%}), and what it states is what this hangs on; "
    return {
        name: replace(
            entry, status="not_identifiable", reason=words + entry.reason, refused=words + entry.refused
        )
        for name, entry in parameters.items()
    }
