"""How far apart an axle's springs stand: as far as its wheels, but for rigid axles with springs between them; which axles are rigid."""

from __future__ import annotations

from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.vehicle import Quantity, Vehicle

RIGID_REAR = frozenset(("carrier", "heavy"))
"""Kinds of vehicles whose rear axle is rigid, as a rule."""
INSIDE = 0.95
"""Springs closer together than this share of the track stand on a rigid axle: those of single wheels are reckoned at the wheels."""
UNSAID = (0.9, 0.12)
"""Spring base over track of a rear axle that is rigid as a rule, where the file is silent: leaf springs stand at 0.65 to 0.75 of the track,
coils of live axles as close, and a rate that is reckoned at the wheels at all of it."""


def spring_base(vehicle: Vehicle, axle: str) -> Quantity | None:
    """Distance of the springs of an axle, as far as rolling goes, m: stated, else the track; None where neither is known.

    The wheel of an independent suspension has its spring's rate reckoned at the wheel; a rigid axle's springs stand where they are.
    """
    return vehicle.get(f"spring_base_{axle}_m") or vehicle.get(f"track_{axle}_m")


def narrowing(vehicle: Vehicle, axle: str) -> tuple[float, float]:
    """Spring base over track and its standard deviation: exactly 1 where the file states no spring base, or no track at all."""
    base = vehicle.get(f"spring_base_{axle}_m")
    tracks = [vehicle.get(f"track_{a}_m") for a in (axle, "front" if axle == "rear" else "rear")]
    track = tracks[0] or tracks[1]
    if base is None or track is None:
        return 1.0, 0.0
    return base.value / track.value, base.std / track.value


def usual_narrowing(vehicle: Vehicle, axle: str) -> tuple[float, float]:
    """Spring base over track and its standard deviation, with what is usual of a rigid rear axle whose base nobody states."""
    unsaid = vehicle.get(f"spring_base_{axle}_m") is None and rigid_axle(vehicle, axle)
    return UNSAID if unsaid else narrowing(vehicle, axle)


def rigid_axle(vehicle: Vehicle, axle: str) -> bool:
    """Whether a rigid beam joins the wheels of an axle: its springs stand well inside the track, or it is the rear axle of a vehicle that has one, as a rule."""
    return narrowing(vehicle, axle)[0] < INSIDE or (axle == "rear" and kind_of(vehicle) in RIGID_REAR)
