"""Is the vehicle one that there is? A height far beyond all of its body style, or a front-driven car with its weight behind, is a wrong figure in the vehicle file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipelines.results import ParameterEstimate
from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.measured import known_body, measured_vehicles
from pipelines.vehicles.vehicle import Vehicle

LOW, HIGH = 0.92, 1.35
"""Share of the lowest measured CG height of a body style, of all vehicles of it, below which none is taken to be; and of the highest: a
load on the roof lifts it by a fifth at most."""

FEWEST = 20
"""Measured vehicles of a style from which on it has a lowest and a highest."""

SURELY = 1.64
"""Standard deviations by which the answer must lie beyond."""


FRONT_DRIVEN, REARWARD = 0.9, 0.56
"""Share of the drive at the front from which on a car is front-driven, and the CG's place over the wheelbase behind which none of these
has it when empty: tyres that pull need the weight, and a rear engine drives the rear axle."""

REAR_HEAVY, UNMEASURED = "the vehicle file has", "no measured"
"""How the reasons begin of what is found here."""

ALONG = (
    "cg_to_front_axle_m",
    "corner_mass_fl_kg",
    "corner_mass_fr_kg",
    "corner_mass_rl_kg",
    "corner_mass_rr_kg",
)
"""What the stated place of the empty vehicle's CG goes into as it stands."""


def beyond_measured(
    parameters: Mapping[str, ParameterEstimate], vehicle: Vehicle
) -> dict[str, ParameterEstimate]:
    """The answers without surety where the vehicle file has a CG that no such vehicle has: too far back, too low or too high."""
    return _too_low_or_high(_too_far_back(parameters, vehicle), vehicle)


def _too_far_back(
    parameters: Mapping[str, ParameterEstimate], vehicle: Vehicle
) -> dict[str, ParameterEstimate]:
    """A front-driven car whose file has the CG in its rear half: it was measured from the rear axle, and springs tell but the load."""
    found = dict(parameters)
    place, length, front = (
        vehicle.get(key) for key in ("cg_to_front_axle_m", "wheelbase_m", "drive_front_share")
    )
    if place is None or length is None or front is None or kind_of(vehicle) != "car":
        return found
    share = place.value / length.value
    if front.value < FRONT_DRIVEN or share < REARWARD:
        return found
    words = (
        f"{REAR_HEAVY} {share:.0%} of the empty weight of a front-driven car at the rear: was cg_to_front_axle_m measured "
        "from the rear axle? "
    )
    return found | {name: refused(found[name], words) for name in ALONG if name in found}


def _too_low_or_high(
    parameters: Mapping[str, ParameterEstimate], vehicle: Vehicle
) -> dict[str, ParameterEstimate]:
    """The answers; none of them is identified where the CG stands where it stands in no measured vehicle of the body style.

    Balances tell products (mass times height, stiffness over both): one figure of the file that is wrong by a factor goes into all.
    """
    found, height = dict(parameters), parameters.get("cg_height_m")
    style = known_body(vehicle.body)
    if (
        style is None
        or height is None
        or height.value is None
        or height.std is None
        or height.status == "not_identifiable"
    ):
        return found
    table = measured_vehicles()
    same = table.height[np.array([body == style for body in table.body])]
    if len(same) < FEWEST:
        return found
    lowest, highest = float(same.min()), float(same.max())
    if height.value + SURELY * height.std < LOW * lowest:
        where, limit = "low", lowest
    elif height.value - SURELY * height.std > HIGH * highest:
        where, limit = "high", highest
    else:
        return found
    words = (
        f"{UNMEASURED} {style} has its CG so {where} ({height.value:.2f} m; the {where}est of {len(same)}: {limit:.2f} m): check the vehicle "
        "file's mass, rates and lengths and the log's units; "
    )
    return {name: refused(entry, words) for name, entry in found.items()}


def refused(entry: ParameterEstimate, words: str) -> ParameterEstimate:
    """An answer that is weak at best from here on. One that was no surer says so to whoever joins it with other drives alone."""
    marked = replace(entry, refused=words + entry.refused)
    return (
        replace(marked, status="weak", reason=words + entry.reason)
        if entry.status == "identified"
        else marked
    )
