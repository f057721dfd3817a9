"""Loads anywhere on a vehicle, what they make of it, and the truth that an estimator is judged against."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from parsers.signals import WHEELS
from pipelines.results import FloatArray
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.body import PlantVehicle
from pipelines.simulation.plant.linear import roll_frequency_hz, roll_gradient_degpg
from pipelines.simulation.plant.static import Posture, posture, spring_rates
from pipelines.simulation.records import GRAVITY


@dataclass(frozen=True)
class Load:
    """A box of even density, fixed to the body. SI.

    behind_front_axle_m, left_m, above_ground_m: its middle, with the empty vehicle at rest. length (along), width
    (across) and height of the box. Raises ValueError, naming the field, where one cannot be.
    """

    mass_kg: float
    behind_front_axle_m: float
    left_m: float
    above_ground_m: float
    length_m: float = 0.6
    width_m: float = 0.6
    height_m: float = 0.3

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        for name in ("mass_kg", "length_m", "width_m", "height_m"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise ValueError(f"{name} of a load is {getattr(self, name)}, expected 0 or more")
        for name in ("behind_front_axle_m", "left_m", "above_ground_m"):
            if not math.isfinite(getattr(self, name)):
                raise ValueError(f"{name} of a load is {getattr(self, name)}, expected a finite number")


def loaded(vehicle: PlantVehicle, loads: Sequence[Load]) -> PlantVehicle:
    """The vehicle with its loads: sprung mass, CG and inertias; the springs stay those that carry it empty.

    The sprung CG's place is given in the empty vehicle's posture, in which the body's axes are fixed; the sag follows
    from equilibrium (`plant_static.posture`).
    """
    if not loads:
        return vehicle
    masses = np.array([vehicle.sprung_mass_kg, *(load.mass_kg for load in loads)])
    # forward, left, up
    places = np.array(
        [
            (-vehicle.sprung_cg_behind_front_axle_m, vehicle.sprung_cg_left_m, vehicle.sprung_cg_height_m),
            *((-load.behind_front_axle_m, load.left_m, load.above_ground_m) for load in loads),
        ]
    )
    center = masses @ places / masses.sum()
    own = [
        (
            vehicle.sprung_roll_inertia_kgm2,
            vehicle.sprung_pitch_inertia_kgm2,
            vehicle.sprung_yaw_inertia_kgm2,
            vehicle.sprung_product_xz_kgm2,
        ),
        *(_box(load) for load in loads),
    ]
    x, y, z = (places - center).T
    inertia = np.array(own).sum(axis=0)
    inertia += [masses @ (y**2 + z**2), masses @ (x**2 + z**2), masses @ (x**2 + y**2), masses @ (x * z)]
    return replace(
        vehicle,
        sprung_mass_kg=float(masses.sum()),
        sprung_cg_behind_front_axle_m=float(-center[0]),
        sprung_cg_left_m=float(center[1]),
        sprung_cg_height_m=float(center[2]),
        sprung_roll_inertia_kgm2=float(inertia[0]),
        sprung_pitch_inertia_kgm2=float(inertia[1]),
        sprung_yaw_inertia_kgm2=float(inertia[2]),
        sprung_product_xz_kgm2=float(inertia[3]),
        spring_preload_n=vehicle.preloads_n,
    )


def _box(load: Load) -> tuple[float, float, float, float]:
    length, width, height = load.length_m**2, load.width_m**2, load.height_m**2
    part = load.mass_kg / 12
    return part * (width + height), part * (length + height), part * (length + width), 0.0


def sprung_cg(vehicle: PlantVehicle, at_rest: Posture) -> tuple[float, float, float]:
    """Sprung CG at rest: behind the front wheels' feet, left of the middle between the tracks, above ground."""
    front = at_rest.feet[:2, 0].mean()
    share = front / (front - at_rest.feet[2:, 0].mean())
    middle = (1 - share) * at_rest.feet[:2, 1].mean() + share * at_rest.feet[2:, 1].mean()
    return float(front), float(-middle), float(at_rest.coordinates[0])


def roll_axis_height_m(vehicle: PlantVehicle, at_rest: Posture) -> float:
    """Height of the roll axis above ground under the sprung CG, at rest: as far down as the springs' deflections bring it."""
    front, rear = (float(at_rest.coordinates[k : k + 2].mean()) for k in (3, 5))
    share = vehicle.sprung_cg_behind_front_axle_m / vehicle.wheelbase_m
    down = (1 - share) * vehicle.roll_center_drop_front * front + share * vehicle.roll_center_drop_rear * rear
    return vehicle.roll_axis_height_m - down


def pitch_axis_height_m(vehicle: PlantVehicle, wheels: FloatArray, at_rest: Posture) -> float:
    """Height above ground of the axis about which braking pitches the body, at rest: where springs and tyres bring the links' poles.

    wheels: packed, of this vehicle. A tyre that is squashed further has the road's force act closer to its hub.
    """
    unladen = (wheels[:, at.PRELOAD] + wheels[:, at.UNSPRUNG] * GRAVITY) / wheels[:, at.TIRE]
    loads = at_rest.tire_forces / wheels[:, at.TIRE]
    turned = wheels[:, at.SIDE_CURVE] * at_rest.coordinates[3:] + wheels[:, at.BRAKE_TURN] * (loads - unladen)
    slopes = np.repeat([vehicle.side_slope_front, vehicle.side_slope_rear], 2) + turned
    front, rear = float(slopes[:2].mean()), float(slopes[2:].mean())
    ahead, share = vehicle.sprung_cg_behind_front_axle_m, vehicle.brake_front_share
    return share * front * ahead - (1 - share) * rear * (vehicle.wheelbase_m - ahead)


def truth(vehicle: PlantVehicle, loads: Sequence[Load], rest: Posture | None = None) -> dict[str, float]:
    """True parameters of the loaded vehicle at rest on flat ground, by the names of `pipelines.parameters`.

    roll_center_height_m: height above ground of the roll axis under the sprung CG. pitch_arm_m: above the axis that the
    side-view paths make for braking. roll_gradient and roll_natural_frequency: tyres included, of the linearised plant
    (`plant.linear`); beside m_s g arm they hold what else rolls the body, a few per cent: the hubs as far as they lean
    with it, and the rolling wheels' gyroscopic moment. rest: the loaded vehicle's, where it is known already. Raises
    ValueError where the vehicle does not stand under its load.
    """
    full = loaded(vehicle, loads)
    rest = rest or posture(full)
    body, wheels = at.pack(full)
    masses = wheels[:, at.UNSPRUNG]
    behind, left, height = sprung_cg(full, rest)
    total = full.mass_kg
    # the whole vehicle's CG from the sprung one, road axes
    shift = masses @ rest.hubs / total
    cg_height = height + float(shift[2])
    half = np.array([full.track_front_m, full.track_front_m, full.track_rear_m, full.track_rear_m]) / 2
    bars = full.anti_roll_stiffness_front_nmprad + full.anti_roll_stiffness_rear_nmprad
    dampers = 0.5 * (wheels[:, at.COMPRESSION] + wheels[:, at.EXTENSION])
    away = rest.hubs - shift
    roll_inertia = full.sprung_roll_inertia_kgm2 + full.sprung_mass_kg * float(shift[1] ** 2 + shift[2] ** 2)
    pitch_inertia = full.sprung_pitch_inertia_kgm2 + full.sprung_mass_kg * float(
        shift[0] ** 2 + shift[2] ** 2
    )
    axis = roll_axis_height_m(full, rest)
    values = {
        "cg_height_m": cg_height,
        "mass_kg": total,
        "sprung_mass_kg": full.sprung_mass_kg,
        "sprung_cg_height_m": height,
        "cg_to_front_axle_m": behind - float(shift[0]),
        "cg_lateral_offset_m": left + float(shift[1]),
        "roll_center_height_m": axis,
        "roll_arm_m": height - axis,
        "pitch_arm_m": height - pitch_axis_height_m(full, wheels, rest),
        "roll_stiffness_nmprad": float(half**2 @ spring_rates(rest.coordinates[3:], body, wheels)) + bars,
        "roll_damping_nmsprad": float(half**2 @ dampers),
        "roll_inertia_kgm2": roll_inertia + float(masses @ (away[:, 1] ** 2 + away[:, 2] ** 2)),
        "pitch_inertia_kgm2": pitch_inertia + float(masses @ (away[:, 0] ** 2 + away[:, 2] ** 2)),
        "suspension_damping_nspm": float(dampers.mean()),
        "drag_area_m2": full.drag_area_m2,
        "roll_gradient_degpg": roll_gradient_degpg(full, rest),
        "roll_natural_frequency_hz": roll_frequency_hz(full, rest),
    }
    corners = zip(WHEELS, rest.tire_forces, strict=True)
    return values | {f"corner_mass_{wheel}_kg": float(force / GRAVITY) for wheel, force in corners}
