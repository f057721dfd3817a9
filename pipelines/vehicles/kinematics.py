"""What a kinematics and compliance rig tells beyond rates at ride height: how wheel rates rise with travel, where bump stops begin,
how roll centres come down with the body, which way wheels' loads go as it rolls."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from parsers.errors import VehicleError

if TYPE_CHECKING:
    from pipelines.results import FloatArray
    from pipelines.vehicles.vehicle import Quantity, Vehicle

AXLES = ("front", "rear")
TRAVEL_M = 0.05
"""How far above and below ride height (the empty vehicle's) the file gives a wheel rate."""

KINK_FROM, KINK = 0.12, 1.3
"""Share by which a wheel's rate grows both ways from ride height from which on a kink there is possible (helper springs, leaves that come
to lie on each other), and how far of what is above it the rates between the three stated ones may be off (spread). A rate that grows
straight from the kink lies a quarter of its growth above the parabola at half the travel."""

STEEPEST = 2.5
"""Rate at TRAVEL_M over that at ride height, or the reverse, beyond which a stop must be in it."""

PAIRS = {
    "patch_path_{}_mprad": "a rigid axle's, whose wheels do not move in its axes, is that of its links: its roll centre's height",
    "wheel_recession_{}": "0 for an axle whose wheel centres go straight up",
    "roll_center_drop_{}": "0 for an axle whose roll centre keeps its height, as beam axles' do",
    "bump_stop_clearance_{}_m": "an axle without bump stops has the whole of its travel for it",
}
"""Keys that tell only together, front and rear."""

Spread = tuple[float, float]
"""Mean and standard deviation."""

SPREADS = ((-2.0, 0.06), (-1.0, 0.24), (0.0, 0.4), (1.0, 0.24), (2.0, 0.06))
"""Where a stop may begin beside its stated place, in spreads of that, and how likely."""


def rate_keys(axle: str) -> tuple[str, str, str]:
    """Keys of an axle's wheel rate at ride height, TRAVEL_M above and TRAVEL_M below it."""
    return f"spring_rate_{axle}_npm", f"spring_rate_{axle}_bump_npm", f"spring_rate_{axle}_rebound_npm"


def spring_curve(quantities: Mapping[str, Quantity], axle: str) -> tuple[Spread, Spread] | None:
    """q [N/m²] and c [N/m³] of an axle's spring force k d + q d² + c d³ at the wheel; None where the file is silent.

    The rate k + 2 q d + 3 c d² at d = ± TRAVEL_M gives both. The stated spreads are beside the rate at ride height: a rig's
    error of scale is in all three rates and is that of k. Where the rate grows much both ways it may have a kink, through which no cubic passes.
    """
    rates = [quantities.get(key) for key in rate_keys(axle)]
    if any(rate is None for rate in rates):
        return None
    rest, bump, rebound = (rate for rate in rates if rate is not None)
    bent = KINK * kink(quantities, axle) * rest.value
    spread = float(np.hypot(np.hypot(bump.std, rebound.std), 2**0.5 * bent))
    square = (bump.value - rebound.value) / (4 * TRAVEL_M)
    cube = (bump.value + rebound.value - 2 * rest.value) / (6 * TRAVEL_M**2)
    return (square, spread / (4 * TRAVEL_M)), (cube, spread / (6 * TRAVEL_M**2))


def kink(quantities: Mapping[str, Quantity], axle: str) -> float:
    """Share by which an axle's wheel rate grows both ways beyond what curved springs do, 0 where it does not or the file is silent."""
    rates = [quantities.get(key) for key in rate_keys(axle)]
    if any(rate is None for rate in rates):
        return 0.0
    rest, bump, rebound = (rate.value for rate in rates if rate is not None)
    return max((bump + rebound) / (2 * rest) - 1 - KINK_FROM, 0.0)


def free_travel(vehicle: Vehicle) -> dict[str, float] | None:
    """axle -> m of a wheel's deflection from which on its bump stop may be touched; None unless both axles' is stated, and where
    deflections are nought on the loaded vehicle.

    Two of its standard deviations below the figure: a stop that is looked for too early is found as none, one too late is missed.
    """
    if vehicle.deflection_zero == "loaded":
        return None
    told = {axle: vehicle.get(f"bump_stop_clearance_{axle}_m") for axle in AXLES}
    found = {axle: max(q.value - 2 * q.std, 0.0) for axle, q in told.items() if q is not None}
    return found if len(found) == len(AXLES) else None


def stop_places(vehicle: Vehicle) -> dict[str, Spread] | None:
    """axle -> m of a wheel's deflection at which its bump stop begins, mean and spread; None as in `free_travel`."""
    if free_travel(vehicle) is None:
        return None
    told = {axle: vehicle.get(f"bump_stop_clearance_{axle}_m") for axle in AXLES}
    return {axle: (q.value, q.std) for axle, q in told.items() if q is not None}


def share_beyond(travel: Mapping[str, FloatArray], places: Mapping[str, Spread]) -> float:
    """Share of the rows, (n,) deflections of each wheel, in which any wheel is beyond its place, expected over the places' spreads."""
    if not places:
        return 0.0
    share = 0.0
    for off, chance in SPREADS:
        beyond = [travel[wheel] > at + off * std for wheel, (at, std) in places.items()]
        share += chance * float(np.mean(np.any(beyond, axis=0)))
    return share


def check_kinematics(quantities: Mapping[str, Quantity], path: Path) -> None:
    """Raise VehicleError where only a part of what belongs together is stated, or rates have a stop in them."""
    for axle in AXLES:
        rest, *ends = rate_keys(axle)
        stated = [key for key in ends if key in quantities]
        if stated and (missing := [key for key in (rest, *ends) if key not in quantities]):
            raise VehicleError(
                f"stated without {' and '.join(missing)}", path=path, place=f"[vehicle] {stated[0]}",
                hint="a spring's curve takes its rate at ride height, 50 mm above and 50 mm below it",
            )  # fmt: skip
        for key in stated:
            over = quantities[key].value / quantities[rest].value
            if not 1 / STEEPEST <= over <= STEEPEST:
                raise VehicleError(
                    f"{over:.3g} times the rate at ride height", path=path, place=f"[vehicle] {key}",
                    hint="give the spring's own rate, without the bump stop, and bump_stop_clearance",
                )  # fmt: skip
    for pattern, hint in PAIRS.items():
        keys = [pattern.format(axle) for axle in AXLES]
        if len(there := [key for key in keys if key in quantities]) == 1:
            other = next(key for key in keys if key not in quantities)
            raise VehicleError(f"stated without {other}", path=path, place=f"[vehicle] {there[0]}", hint=hint)
