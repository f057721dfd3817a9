"""Figures of a file that no such vehicle has, though each by itself could be some vehicle's: where its CG lies, what its axles weigh.

Cars driven by their front wheels have 58 to 66 % of their empty mass on them, those driven by the rear ones 46 to 56 %, with the engine
behind the rear axle down to 35 %; vans and pickups 50 to 65 %. Lorries and tractors have no such bounds. An axle with its wheels is 4 to
8 % of a car's mass, up to 12 % if it is a van's live one.
"""

from __future__ import annotations

from pipelines.vehicles.kinds import Kind, kind_of
from pipelines.vehicles.usual import usual_unsprung
from pipelines.vehicles.vehicle import Vehicle

MOST_FRONT, LEAST_FRONT = 0.68, 0.34
"""Shares of the empty mass on the front axle that no such vehicle goes beyond."""

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


UNSPRUNG_SPREADS = 3.5
"""What an axle's mass may be away from the usual of its kind, in standard deviations of that."""

AXLES = ("front", "rear")


def heavy_axles(vehicle: Vehicle) -> dict[str, float]:
    """Axles that the file has lighter or heavier than any such vehicle has, and their share of the empty mass."""
    mass = vehicle.get("mass_kg")
    if mass is None or not _on_the_road(vehicle):
        return {}
    found = {}
    for axle in AXLES:
        stated, (usual, std) = (
            vehicle.get(f"unsprung_mass_{axle}_kg"),
            usual_unsprung(vehicle, axle, mass.value),
        )
        # a simple simulator has none
        if stated is not None and stated.value > 0 and abs(stated.value - usual) > UNSPRUNG_SPREADS * std:
            found[axle] = stated.value / mass.value
    return found


TRACKS_APART: dict[Kind, float] = {"car": 0.09, "carrier": 0.12}
"""What tracks front and rear differ by at the most, over their mean; twin tyres make lorries' differ by more."""

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
