"""What is known of a loaded vehicle without any log, where the load's mass is stated and no joint prior holds the parameter.

With the empty mass m, the load q at x_l and h_l, r = q / (m + q):

    mass                 m + q
    CG to front axle     x + r (x_l - x)
    CG height            h + r (h_l - h) less what the springs sag
    inertias             I + m r d² + q LOAD_GYRATION², with d from the vehicle's CG to the load's

A file without a mass has that of the measured vehicles, widely.
"""

from __future__ import annotations

import math

from pipelines.joint.vehicle.load_places import usual_height
from pipelines.results import Prior
from pipelines.vehicles.vehicle import Quantity, Vehicle

USUAL_MASS = (1700.0, 500.0)
USUAL_LENGTH, USUAL_TRACK, USUAL_CG = 2.7, 1.55, 0.65
PLACE, PLACE_STD, SIDE_STD = 0.6, 0.35, 0.16
"""Where the file is silent: of the wheelbase, where a load lies and how far it may lie off; of the track, how far off the middle."""

SAG_M = (0.13, 0.05)
"""How far springs of 1.3 Hz sink under a load as heavy as the vehicle, m: mean and standard deviation (springs get stiffer)."""

LOAD_GYRATION = (0.3, 0.1)
"""Radius of gyration of a load about its own CG, m."""


def _or(quantity: Quantity | None, usual: tuple[float, float]) -> tuple[float, float]:
    return usual if quantity is None else (quantity.value, quantity.std)


def _moved(
    empty: tuple[float, float],
    place: tuple[float, float],
    kilos: tuple[float, float],
    load: tuple[float, float],
) -> tuple[float, float]:
    """The common CG's coordinate of vehicle and load: mean and standard deviation."""
    total = kilos[0] + load[0]
    r = load[0] / total
    # of the share: the load's own doubt and the vehicle's
    share = math.hypot((1 - r) * load[1], r * kilos[1]) / total
    apart = place[0] - empty[0]
    std = math.hypot((1 - r) * empty[1], r * place[1], apart * share)
    return empty[0] + r * apart, std


def _inertia(name: str, empty: Prior, vehicle: Vehicle, kilos: tuple[float, float], load: Quantity) -> Prior:
    length, track = vehicle.get("wheelbase_m"), vehicle.get("track_front_m")
    high, unsure = usual_height(vehicle)
    height = _or(vehicle.get("cg_height_m"), (USUAL_CG, 0.1))
    up = _or(vehicle.load.get("height_m"), (high * height[0], unsure * height[0]))
    if name == "pitch_inertia_kgm2":
        lever = USUAL_LENGTH if length is None else length.value
        at = _or(vehicle.get("cg_to_front_axle_m"), (0.46 * lever, 0.05 * lever))
        off = _or(vehicle.load.get("behind_front_axle_m"), (PLACE * lever, PLACE_STD * lever))
    else:
        wide = USUAL_TRACK if track is None else track.value
        at, off = (0.0, 0.0), _or(vehicle.load.get("left_m"), (0.0, SIDE_STD * wide))
    both = kilos[0] * load.value / (kilos[0] + load.value)
    more, variance = (
        load.value * LOAD_GYRATION[0] ** 2,
        (2 * load.value * LOAD_GYRATION[0] * LOAD_GYRATION[1]) ** 2,
    )
    for here, there in ((at, off), (height, up)):
        d, std = there[0] - here[0], math.hypot(there[1], here[1])
        more += both * (d**2 + std**2)
        variance += (both * std) ** 2 * (4 * d**2 + 2 * std**2)
    variance += (more * load.std / max(load.value, 1.0)) ** 2
    return Prior(empty.value + more, math.sqrt(empty.std**2 + variance), empty.source)


def with_its_load(name: str, empty: Prior, vehicle: Vehicle) -> Prior:
    """The prior of the loaded vehicle from that of the empty one; the same where no load is stated or what it is does not hang on it."""
    load = vehicle.load.get("mass_kg")
    if load is None or load.value <= 0:
        return empty
    kilos = _or(vehicle.get("mass_kg"), USUAL_MASS)
    words = f"{empty.source.removesuffix(' (empty vehicle)')}, with the stated load"
    weight = (load.value, load.std)
    if name == "mass_kg":
        return Prior(empty.value + load.value, math.hypot(empty.std, load.std), words)
    if name.endswith("inertia_kgm2"):
        found = _inertia(name, empty, vehicle, kilos, load)
        return Prior(found.value, found.std, words)
    known = (empty.value, empty.std)
    if name == "cg_to_front_axle_m":
        # without a wheelbase the stated place tells about where the middle is
        length = vehicle.get("wheelbase_m")
        lever = empty.value / 0.46 if length is None else length.value
        place = _or(vehicle.load.get("behind_front_axle_m"), (PLACE * lever, PLACE_STD * lever))
        return Prior(*_moved(known, place, kilos, weight), words)
    if name == "cg_height_m":
        high, unsure = usual_height(vehicle)
        place = _or(vehicle.load.get("height_m"), (high * empty.value, unsure * empty.value))
        value, std = _moved(known, place, kilos, weight)
        share = load.value / kilos[0]
        return Prior(value - share * SAG_M[0], math.hypot(std, share * SAG_M[1]), words)
    return empty
