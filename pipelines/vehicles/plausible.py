"""Figures of a vehicle file that no road vehicle, robot or kart has: mostly a figure in another unit."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from parsers.errors import VehicleError
from pipelines.vehicles.keys import ZERO_KEYS, ZERO_OR_MORE
from pipelines.vehicles.measured import known_body

if TYPE_CHECKING:
    from pipelines.vehicles.vehicle import Quantity, Vehicle

_LENGTH = "m, not in mm or cm"
_BAR = "N·m/rad, not per degree; 0 where there is none"
# key -> (least, greatest, the unit in words); from a small robot to a loaded truck
SPANS: Mapping[str, tuple[float, float, str]] = {
    "mass_kg": (5.0, 200e3, "kg"),
    "unsprung_mass_front_kg": (0.1, 20e3, "kg"),
    "unsprung_mass_rear_kg": (0.1, 20e3, "kg"),
    "cg_to_front_axle_m": (0.02, 20.0, _LENGTH),
    "cg_height_m": (0.02, 5.0, _LENGTH),
    "cg_lateral_offset_m": (-1.0, 1.0, _LENGTH),
    "wheelbase_m": (0.1, 20.0, _LENGTH),
    "track_front_m": (0.1, 5.0, _LENGTH),
    "track_rear_m": (0.1, 5.0, _LENGTH),
    "spring_base_front_m": (0.05, 5.0, _LENGTH),
    "spring_base_rear_m": (0.05, 5.0, _LENGTH),
    "roll_center_height_front_m": (-2.0, 3.0, _LENGTH),
    "roll_center_height_rear_m": (-2.0, 3.0, _LENGTH),
    "pitch_center_height_m": (-3.0, 5.0, _LENGTH),
    "pitch_center_height_drive_m": (-3.0, 5.0, _LENGTH),
    "roll_inertia_kgm2": (0.05, 1e6, "kg·m²"),
    "pitch_inertia_kgm2": (0.05, 1e7, "kg·m²"),
    "roll_stiffness_nmprad": (50.0, 1e8, "N·m/rad, not per degree or in kN·m"),
    "roll_damping_nmsprad": (1.0, 1e7, "N·m·s/rad"),
    "spring_rate_front_npm": (100.0, 1e7, "N/m at the wheel, not in N/mm"),
    "spring_rate_rear_npm": (100.0, 1e7, "N/m at the wheel, not in N/mm"),
    "spring_rate_front_bump_npm": (50.0, 2e7, "N/m at the wheel, not in N/mm"),
    "spring_rate_front_rebound_npm": (50.0, 2e7, "N/m at the wheel, not in N/mm"),
    "spring_rate_rear_bump_npm": (50.0, 2e7, "N/m at the wheel, not in N/mm"),
    "spring_rate_rear_rebound_npm": (50.0, 2e7, "N/m at the wheel, not in N/mm"),
    "bump_stop_clearance_front_m": (1e-4, 1.0, _LENGTH),
    "bump_stop_clearance_rear_m": (1e-4, 1.0, _LENGTH),
    "roll_center_drop_front": (-10.0, 15.0, "m of the roll centre a m that the body goes down"),
    "roll_center_drop_rear": (-10.0, 15.0, "m of the roll centre a m that the body goes down"),
    "damper_rate_front_nspm": (5.0, 1e6, "N·s/m a wheel, not in N·s/mm"),
    "damper_rate_rear_nspm": (5.0, 1e6, "N·s/m a wheel, not in N·s/mm"),
    "anti_roll_stiffness_front_nmprad": (0.0, 1e8, _BAR),
    "anti_roll_stiffness_rear_nmprad": (0.0, 1e8, _BAR),
    "tire_vertical_rate_npm": (1e3, 1e12, "N/m of one tyre, not in N/mm"),
    "patch_path_front_mprad": (-1.0, 1.5, "m a rad, not mm a degree"),
    "patch_path_rear_mprad": (-1.0, 1.5, "m a rad, not mm a degree"),
    "patch_path_pitch_mprad": (-1.5, 2.0, "m a rad, not mm a degree"),
    "wheel_recession_front": (-1.5, 1.5, "m back a m up, not mm"),
    "wheel_recession_rear": (-1.5, 1.5, "m back a m up, not mm"),
    "tire_longitudinal_rate_npm": (1e3, 1e12, "N/m of one tyre, not in N/mm"),
    "tire_lateral_rate_npm": (1e3, 1e12, "N/m of one tyre, not in N/mm"),
    "wheel_radius_m": (0.02, 2.0, _LENGTH),
    "wheel_inertia_kgm2": (1e-5, 1e3, "kg·m²"),
    "steering_ratio": (0.2, 100.0, "degrees of the steering wheel a degree of the wheels"),
    "brake_gain_nmppa": (1e-8, 1.0, "N·m/Pa of all wheels, not per bar"),
    "drag_area_m2": (0.005, 50.0, "m²"),
    "rolling_resistance": (0.0, 0.3, "newtons a newton, not in %"),
    "load.mass_kg": (0.0, 200e3, "kg"),
    "load.height_m": (0.0, 8.0, _LENGTH),
    "load.behind_front_axle_m": (-5.0, 20.0, _LENGTH),
    "load.left_m": (-3.0, 3.0, _LENGTH),
    "trailer.mass_kg": (0.0, 200e3, "kg"),
    "trailer.drag_area_m2": (0.0, 50.0, "m²"),
    "sensors.imu_behind_front_axle_m": (-10.0, 30.0, _LENGTH),
    "sensors.imu_left_m": (-3.0, 3.0, _LENGTH),
    "sensors.imu_above_ground_m": (-1.0, 8.0, _LENGTH),
    "sensors.imu_roll_deg": (-15.0, 15.0, "degrees"),
    "sensors.imu_pitch_deg": (-15.0, 15.0, "degrees"),
    **{f"sensors.{key}": (-0.5, 0.5, _LENGTH) for key in ZERO_KEYS},
}
NEVER_NOUGHT = (
    "mass_kg", "wheelbase_m", "track_front_m", "track_rear_m", "wheel_radius_m", "cg_height_m", "cg_to_front_axle_m",
    "spring_rate_front_npm", "spring_rate_rear_npm", "tire_vertical_rate_npm", "roll_stiffness_nmprad", "roll_inertia_kgm2",
    "pitch_inertia_kgm2",
)  # fmt: skip
_G = 9.81
_MOST_LOAD = 3.0
_MOST_SAG_M = 1.2
_WIDEST_BASE = 1.1
_LEAST_DAMPING = 0.1
"""N·m·s/rad a kg: an eighth of the softest dampers of cars."""
_RADII = (0.18, 0.9)
"""Radii of gyration over track and wheelbase: measured vehicles have 0.35 to 0.55 and some 0.4 to 0.65."""
_LEAST_BAR = 0.5
"""N·m/rad a kg of the vehicle: a quarter of what the thinnest bars of cars have, and more than nearly all of them have a degree."""
_LEAST_ROLL_ARM_M = 0.15
_CAR_BASE_M, _NARROWEST_M = (2.2, 3.6), 0.95
"""Wheelbases of cars and vans (narrow tractors have shorter, karts much shorter ones), and a track below that of the narrowest."""


HEAVIEST_KG = 5500.0
"""More than any empty passenger car weighs, armoured and electric ones too."""
HEAVIEST_CARRIER_KG = 12e3
"""The same of vans and pickups."""


def check_plausible(vehicle: Vehicle, path: Path) -> None:
    """Raise VehicleError for a figure that cannot be in the unit of its key: it names key, figure, span and unit."""
    for table, quantities in (
        ("vehicle", vehicle.quantities),
        ("load", vehicle.load),
        ("trailer", vehicle.trailer),
        ("sensors", vehicle.sensors),
    ):
        for key, quantity in quantities.items():
            span = SPANS.get(key if table == "vehicle" else f"{table}.{key}")
            # of what a simple simulator may leave out, none at all is no mistaken unit
            none = quantity.value == 0.0 and key in ZERO_OR_MORE
            if span is not None and not none and not span[0] <= quantity.value <= span[1]:
                text = f"found {quantity.value:g}, expected {span[0]:g} to {span[1]:g}"
                raise VehicleError(
                    text, path=path, place=f"[{table}] {key}", hint=f"this key is in {span[2]}"
                )
    _check_spreads(vehicle.quantities, path)
    _check_bases(vehicle.quantities, path)
    _check_roll_axis(vehicle.quantities, path)
    _check_tracks(vehicle.quantities, path)
    mass = vehicle.get("mass_kg")
    if mass is not None:
        _check_body(mass, vehicle.body, path)
        _check_springs(mass, vehicle.quantities, path)
        _check_inertias(mass, vehicle.quantities, path)
        _check_load(mass, vehicle.load, path)


def _check_body(mass: Quantity, body: str | None, path: Path) -> None:
    """A mass that no vehicle of this body has: a digit too many, or a lorry's."""
    style = known_body(body)
    if style is None:
        return
    most = HEAVIEST_CARRIER_KG if style in ("Van", "Pickup") else HEAVIEST_KG
    if mass.value > most:
        raise VehicleError(
            f"found {mass.value:g}: nothing with the body {style} weighs more than {most:g} kg empty", path=path,
            place="[vehicle] mass_kg", hint="this key is in kg; a lorry's body is a truck, a bus or a tractor",
        )  # fmt: skip


def _check_spreads(quantities: Mapping[str, Quantity], path: Path) -> None:
    """A spread as large as the figure, of one that cannot be nought."""
    for key in NEVER_NOUGHT:
        known = quantities.get(key)
        if known is not None and known.std >= known.value:
            raise VehicleError(
                f"std {known.std:g} is not less than the value {known.value:g}", path=path, place=f"[vehicle] {key}",
                hint="a figure that is hardly known is better left out: what is usual is taken then",
            )  # fmt: skip


def _check_load(mass: Quantity, load: Mapping[str, Quantity], path: Path) -> None:
    """A load that no such vehicle carries."""
    known = load.get("mass_kg")
    if known is not None and known.value > _MOST_LOAD * mass.value:
        raise VehicleError(
            f"found {known.value:g}: no vehicle of {mass.value:g} kg carries more than {_MOST_LOAD:g} times its own mass",
            path=path, place="[load] mass_kg", hint="[vehicle] mass_kg is that of the empty vehicle, this one of what is in it",
        )  # fmt: skip


def _check_roll_axis(quantities: Mapping[str, Quantity], path: Path) -> None:
    """Roll centres above the CG: the body would lean into the bend."""
    height = quantities.get("cg_height_m")
    centers = [quantities.get(f"roll_center_height_{axle}_m") for axle in ("front", "rear")]
    known = [each.value for each in centers if each is not None]
    if height is not None and len(known) == 2 and 0.5 * sum(known) >= height.value:
        raise VehicleError(
            f"found {known[1]:g} (front {known[0]:g}): the CG is at {height.value:g} m, and no body hangs under its roll axis",
            path=path, place="[vehicle] roll_center_height_rear_m", hint="heights above ground, of the empty vehicle",
        )  # fmt: skip


def _check_bases(quantities: Mapping[str, Quantity], path: Path) -> None:
    """Springs that stand outside of the wheels."""
    for axle in ("front", "rear"):
        base, track = quantities.get(f"spring_base_{axle}_m"), quantities.get(f"track_{axle}_m")
        if base is not None and track is not None and base.value > _WIDEST_BASE * track.value:
            raise VehicleError(
                f"found {base.value:g}: the wheels stand {track.value:g} m apart", path=path,
                place=f"[vehicle] spring_base_{axle}_m", hint="it is the distance of a rigid axle's springs from each other",
            )  # fmt: skip


def _check_tracks(quantities: Mapping[str, Quantity], path: Path) -> None:
    """Half a track: from the middle to a wheel, as formulas have it. Nothing on a car's wheelbase is so narrow."""
    base = quantities.get("wheelbase_m")
    if base is None or not _CAR_BASE_M[0] <= base.value <= _CAR_BASE_M[1]:
        return
    for key in ("track_front_m", "track_rear_m"):
        track = quantities.get(key)
        if track is not None and track.value < _NARROWEST_M:
            raise VehicleError(
                f"found {track.value:g}: no vehicle on a wheelbase of {base.value:g} m is so narrow", path=path,
                place=f"[vehicle] {key}", hint="it is the distance of an axle's wheels from each other, not half of it",
            )  # fmt: skip


def _check_inertias(mass: Quantity, quantities: Mapping[str, Quantity], path: Path) -> None:
    """Inertias of no body that stands on these wheels: radii of gyration of a fifth of its width or length, or beyond its ends."""
    for key, names in (
        ("roll_inertia_kgm2", ("track_front_m", "track_rear_m")),
        ("pitch_inertia_kgm2", ("wheelbase_m",)),
    ):
        inertia, length = quantities.get(key), next((quantities[n] for n in names if n in quantities), None)
        if inertia is None or length is None:
            continue
        radius = (inertia.value / mass.value) ** 0.5
        if not _RADII[0] * length.value <= radius <= _RADII[1] * length.value:
            raise VehicleError(
                f"found {inertia.value:g}: of {mass.value:g} kg that is a radius of gyration of {radius:.2f} m, on {length.value:g} m",
                path=path, place=f"[vehicle] {key}", hint="this key is in kg·m², of the whole empty vehicle about its own CG",
            )  # fmt: skip


def _check_springs(mass: Quantity, quantities: Mapping[str, Quantity], path: Path) -> None:
    """Springs that could not carry the vehicle, or keep it upright, bars and dampers that do nothing."""
    for key in ("spring_rate_front_npm", "spring_rate_rear_npm"):
        rate = quantities.get(key)
        # an axle carries at least a fifth of the vehicle
        if rate is not None and rate.value * 2 * _MOST_SAG_M < 0.2 * mass.value * _G:
            text = f"found {rate.value:g}: a vehicle of {mass.value:g} kg would sink by more than {_MOST_SAG_M:g} m"
            raise VehicleError(
                text, path=path, place=f"[vehicle] {key}", hint=f"this key is in {SPANS[key][2]}"
            )
    for key in ("anti_roll_stiffness_front_nmprad", "anti_roll_stiffness_rear_nmprad"):
        bar = quantities.get(key)
        if bar is not None and 0.0 < bar.value < _LEAST_BAR * mass.value:
            text = f"found {bar.value:g}: no bar of a vehicle of {mass.value:g} kg is so thin"
            raise VehicleError(
                text, path=path, place=f"[vehicle] {key}", hint=f"this key is in {SPANS[key][2]}"
            )
    key = "roll_damping_nmsprad"
    damping = quantities.get(key)
    if damping is not None and damping.value < _LEAST_DAMPING * mass.value:
        text = f"found {damping.value:g}: a vehicle of {mass.value:g} kg would not stop rocking"
        raise VehicleError(
            text, path=path, place=f"[vehicle] {key}", hint="this key is in N·m·s/rad, not per degree"
        )
    key = "roll_stiffness_nmprad"
    roll = quantities.get(key)
    if roll is not None and roll.value < mass.value * _G * _LEAST_ROLL_ARM_M:
        text = f"found {roll.value:g}: a vehicle of {mass.value:g} kg would fall over"
        raise VehicleError(text, path=path, place=f"[vehicle] {key}", hint=f"this key is in {SPANS[key][2]}")
