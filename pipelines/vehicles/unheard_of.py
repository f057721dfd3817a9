"""Figures of a file that no such vehicle has, though each by itself could be some vehicle's: where its CG lies, what its axles weigh.

Cars driven by their front wheels have 58 to 66 % of their empty mass on them, those driven by the rear ones 46 to 56 %, with the engine
behind the rear axle down to 35 %; vans and pickups 50 to 65 %. Lorries and tractors have no such bounds. An axle with its wheels is 4 to
8 % of a car's mass, up to 12 % if it is a live one, more of a racing car's or a buggy's.
"""

from __future__ import annotations

from pipelines.vehicles.kinds import Kind, kind_of
from pipelines.vehicles.spring_base import rigid_axle
from pipelines.vehicles.vehicle import Vehicle

MOST_FRONT, LEAST_FRONT = 0.7, 0.3
"""Shares of the empty mass on the front axle that hardly any such vehicle goes beyond: chassis cabs without a body, buggies."""

USUAL, SPREAD = 0.42, 0.06
"""Where the CG is behind the front axle, over the wheelbase: mean and standard deviation."""

ROAD_M = (1.8, 4.6)
"""Wheelbases of road cars, vans and pickups: what is shorter is a kart or a robot, which may have it anywhere."""


def _on_the_road(vehicle: Vehicle) -> bool:
    """Whether the vehicle is as long as road vehicles are; where nobody says, it is one."""
    length = vehicle.get("wheelbase_m")
    return length is None or length.value >= ROAD_M[0]


def usual_place(vehicle: Vehicle) -> tuple[float, float] | None:
    """Where such an empty vehicle's CG is behind its front axle and how surely, m; None where any place is as good."""
    length = vehicle.get("wheelbase_m")
    if length is None or kind_of(vehicle) == "heavy" or length.value > ROAD_M[1] or not _on_the_road(vehicle):
        return None
    return USUAL * length.value, SPREAD * length.value


def front_share(vehicle: Vehicle) -> float | None:
    """Share of the empty mass that the file puts on the front axle, where no car, van or pickup has it so; else None."""
    place, length = vehicle.get("cg_to_front_axle_m"), vehicle.get("wheelbase_m")
    if place is None or length is None or usual_place(vehicle) is None:
        return None
    share = 1.0 - place.value / length.value
    return None if LEAST_FRONT <= share <= MOST_FRONT else share


MOST_UNSPRUNG: dict[Kind, tuple[float, float]] = {
    "car": (0.13, 0.13),
    "carrier": (0.115, 0.145),
    "heavy": (0.15, 0.22),
}
"""Share of the empty mass that an axle with its wheels is at the most, front and rear: off-roaders' live axles are 12 % of theirs."""

LIVE, LIGHT_KG, LIGHT = 0.03, 800.0, 0.22
"""What a live axle, if the file has one, may be more; an empty mass below which a vehicle may be all wheels, and their share then."""

LEAST_UNSPRUNG = 0.012

AXLES = ("front", "rear")


def odd_axles(vehicle: Vehicle) -> dict[str, float]:
    """Axles that the file has lighter or heavier than hardly any such vehicle has, and their share of the empty mass."""
    mass = vehicle.get("mass_kg")
    if mass is None or not _on_the_road(vehicle):
        return {}
    found = {}
    for axle, most in zip(AXLES, MOST_UNSPRUNG[kind_of(vehicle)], strict=True):
        stated = vehicle.get(f"unsprung_mass_{axle}_kg")
        if mass.value < LIGHT_KG:
            most = LIGHT
        elif kind_of(vehicle) == "car" and rigid_axle(vehicle, axle):
            most += LIVE
        share = LEAST_UNSPRUNG if stated is None else stated.value / mass.value
        if not LEAST_UNSPRUNG <= share <= most:
            found[axle] = share
    return found


TRACKS_APART: dict[Kind, float] = {"car": 0.125, "carrier": 0.17}
"""What tracks front and rear hardly ever differ by more than, over their mean (a Citroën DS's by 14 %); twin tyres make vans' differ by
14 % and lorries' by more."""

TRACK_OPEN = 0.06
"""Share of their mean that each may be off by where they differ by more."""


def tracks_apart(vehicle: Vehicle) -> tuple[float, float] | None:
    """The mean of two tracks that no such vehicle has together, and by which share of it they differ; else None."""
    front, rear = vehicle.get("track_front_m"), vehicle.get("track_rear_m")
    most = TRACKS_APART.get(kind_of(vehicle))
    if front is None or rear is None or most is None or not _on_the_road(vehicle):
        return None
    mean = 0.5 * (front.value + rear.value)
    apart = (front.value - rear.value) / mean
    return (mean, apart) if abs(apart) > most else None
