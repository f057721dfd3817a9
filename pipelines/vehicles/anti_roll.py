"""Anti-roll bars of which the vehicle file says nothing: not the same as none."""

from __future__ import annotations

from pipelines.vehicles.spring_base import narrowing, rigid_axle, spring_base, usual_narrowing
from pipelines.vehicles.vehicle import Quantity, Vehicle

USUAL = (0.6, 0.5)
"""Roll stiffness of an axle's bar over that of its springs, reckoned at the wheels' track: mean and spread."""
CLOSE = (0.1, 0.5)
"""The same of a live axle whose springs may stand closer together than anybody said."""
BESIDE_CLOSE_SPRINGS = (0.3, 0.5)
"""The same over that of springs that are stated to stand closer together than the wheels, where they stand: many such axles have none."""
BESIDE_A_STATED = (0.3, 0.4)
"""The same where the other axle's bar is stated: who lists bars lists those that there are, as a rule."""


def silent_bar(vehicle: Vehicle, axle: str) -> tuple[float, float]:
    """What an axle's bar may add, over the roll stiffness of its springs on the wheels' track, where the file is silent: mean, std."""
    if rigid_axle(vehicle, axle):
        ratio = narrowing(vehicle, axle)[0]
        mean, spread = BESIDE_CLOSE_SPRINGS
        return CLOSE if ratio == 1 else (ratio**2 * mean, ratio**2 * spread)
    other = "rear" if axle == "front" else "front"
    return USUAL if vehicle.get(f"anti_roll_stiffness_{other}_nmprad") is None else BESIDE_A_STATED


def _on_wheels(vehicle: Vehicle, axle: str) -> float:
    """Roll stiffness of an axle's springs if they stood at the wheels, N m/rad."""
    spring = vehicle.get(f"spring_rate_{axle}_npm")
    track = vehicle.get(f"track_{axle}_m") or spring_base(vehicle, axle)
    rate = 30_000.0 if spring is None else spring.value
    return 0.5 * rate * (1.55 if track is None else track.value) ** 2


def closer_springs(vehicle: Vehicle, axle: str) -> tuple[float, float]:
    """What the springs of a rigid axle lack in roll where nobody states how far apart they stand, N m/rad: mean, std; else nothing."""
    if narrowing(vehicle, axle) == usual_narrowing(vehicle, axle):
        return 0.0, 0.0
    share, std = usual_narrowing(vehicle, axle)
    whole = _on_wheels(vehicle, axle)
    return (1 - share**2) * whole, 2 * share * std * whole


def usual_bar(axle: str, vehicle: Vehicle) -> Quantity:
    """An axle's bar in N m/rad where the file is silent; hardly known where it has no spring or no track either."""
    on_wheels = _on_wheels(vehicle, axle)
    mean, spread = silent_bar(vehicle, axle)
    return Quantity(mean * on_wheels, spread * on_wheels, "not given: usual beside its springs (0 = none)")
