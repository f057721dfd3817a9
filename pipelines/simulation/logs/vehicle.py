"""Vehicle files and the plant: a data sheet with its errors from a plant's vehicle, and a plant's vehicle from a file."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from parsers.errors import VehicleError
from pipelines.parameters import PARAMETERS
from pipelines.simulation.loads import truth
from pipelines.simulation.plant.vehicle import PRESETS, PlantVehicle
from pipelines.simulation.records import GRAVITY
from pipelines.simulation.sensors.truth import Mount
from pipelines.vehicles.vehicle import Vehicle

RELATIVE: Mapping[str, float] = {
    "mass_kg": 0.01, "unsprung_mass_front_kg": 0.05, "unsprung_mass_rear_kg": 0.05, "wheelbase_m": 0.002,
    "track_front_m": 0.005, "track_rear_m": 0.005, "roll_inertia_kgm2": 0.05, "pitch_inertia_kgm2": 0.05,
    "roll_stiffness_nmprad": 0.02, "spring_rate_front_npm": 0.02, "spring_rate_rear_npm": 0.02,
    "damper_rate_front_nspm": 0.08, "damper_rate_rear_nspm": 0.08, "anti_roll_stiffness_front_nmprad": 0.04,
    "anti_roll_stiffness_rear_nmprad": 0.04, "tire_vertical_rate_npm": 0.05, "wheel_radius_m": 0.005,
    "wheel_inertia_kgm2": 0.1, "steering_ratio": 0.01, "brake_gain_nmppa": 0.03, "drag_area_m2": 0.05,
    "rolling_resistance": 0.1,
}  # fmt: skip
"""How far a data sheet's figure may lie from the vehicle's, std over value."""

ABSOLUTE: Mapping[str, float] = {
    "cg_to_front_axle_m": 0.01, "roll_center_height_front_m": 0.02, "roll_center_height_rear_m": 0.02,
    "pitch_center_height_m": 0.02, "pitch_center_height_drive_m": 0.03, "brake_front_share": 0.01,
    "drive_front_share": 0.01,
}  # fmt: skip
"""The same, std in the figure's own unit."""

PLACE_STD_M = 0.01
BASE_STD_M = 0.01
RIGID = 1.0
"""Share of the body's lean that a rigid axle takes from its wheels."""
_VALUE = re.compile(r"value = ([^,]+),")
_LOAD_STD = 0.03
_SHARES = ("brake_front_share", "drive_front_share")
_FARTHEST = 2.5
"""A data sheet is never off by more than so many std: a factory checks."""


def rolling_radii_m(vehicle: PlantVehicle) -> tuple[float, float]:
    """Nominal rolling radius of the front and the rear wheels: unloaded radius less a third of the static squash."""
    rear = vehicle.mass_kg * GRAVITY * vehicle.cg_to_front_axle_m / vehicle.wheelbase_m
    front = vehicle.mass_kg * GRAVITY - rear
    return (
        vehicle.wheel_radius_front_m - front / (6 * vehicle.tire_vertical_rate_front_npm),
        vehicle.wheel_radius_rear_m - rear / (6 * vehicle.tire_vertical_rate_rear_npm),
    )


def _drive_axis_height_m(vehicle: PlantVehicle) -> float:
    """As PlantVehicle.pitch_axis_height_m, for driving."""
    share, behind = vehicle.drive_front_share, vehicle.sprung_cg_behind_front_axle_m
    rear = -vehicle.side_slope_drive_rear * (vehicle.wheelbase_m - behind)
    return share * vehicle.side_slope_drive_front * behind + (1 - share) * rear


def sheet_values(vehicle: PlantVehicle) -> dict[str, float]:
    """The empty vehicle's exact figures by the vehicle file's keys (no CG height: data sheets do not give it)."""
    empty = truth(vehicle, ())
    return {
        "mass_kg": empty["mass_kg"],
        "unsprung_mass_front_kg": 2 * vehicle.unsprung_mass_front_kg,
        "unsprung_mass_rear_kg": 2 * vehicle.unsprung_mass_rear_kg,
        "cg_to_front_axle_m": empty["cg_to_front_axle_m"],
        "wheelbase_m": vehicle.wheelbase_m,
        "track_front_m": vehicle.track_front_m,
        "track_rear_m": vehicle.track_rear_m,
        "roll_center_height_front_m": vehicle.roll_center_height_front_m,
        "roll_center_height_rear_m": vehicle.roll_center_height_rear_m,
        "pitch_center_height_m": vehicle.pitch_axis_height_m,
        "pitch_center_height_drive_m": _drive_axis_height_m(vehicle),
        "roll_inertia_kgm2": empty["roll_inertia_kgm2"],
        "pitch_inertia_kgm2": empty["pitch_inertia_kgm2"],
        "roll_stiffness_nmprad": empty["roll_stiffness_nmprad"],
        "spring_rate_front_npm": vehicle.spring_rate_front_npm,
        "spring_rate_rear_npm": vehicle.spring_rate_rear_npm,
        "damper_rate_front_nspm": 0.5
        * (vehicle.damper_compression_front_nspm + vehicle.damper_extension_front_nspm),
        "damper_rate_rear_nspm": 0.5
        * (vehicle.damper_compression_rear_nspm + vehicle.damper_extension_rear_nspm),
        "anti_roll_stiffness_front_nmprad": vehicle.anti_roll_stiffness_front_nmprad,
        "anti_roll_stiffness_rear_nmprad": vehicle.anti_roll_stiffness_rear_nmprad,
        "tire_vertical_rate_npm": 0.5
        * (vehicle.tire_vertical_rate_front_npm + vehicle.tire_vertical_rate_rear_npm),
        "wheel_radius_m": float(np.mean(rolling_radii_m(vehicle))),
        "wheel_inertia_kgm2": 0.5 * (vehicle.wheel_inertia_front_kgm2 + vehicle.wheel_inertia_rear_kgm2),
        "steering_ratio": vehicle.steering_ratio,
        "brake_gain_nmppa": vehicle.brake_gain_nmppa,
        "brake_front_share": vehicle.brake_front_share,
        "drive_front_share": vehicle.drive_front_share,
        "drag_area_m2": vehicle.drag_area_m2,
        "rolling_resistance": vehicle.rolling_resistance,
    }


def _figure(key: str, true: float, errors: float, rng: np.random.Generator) -> str:
    """One line of a data sheet: what it says, and how sure that is."""
    draw = float(np.clip(rng.standard_normal(), -_FARTHEST, _FARTHEST))
    if key in _SHARES:
        # one driven axle is no measured figure
        std = ABSOLUTE[key] if 0 < true < 1 else 0.0
        value = min(max(true + errors * std * draw, 0.0), 1.0)
        return f"{{value = {value:.6g}, std = {std:.3g}}}"
    if key in ABSOLUTE:
        return f"{{value = {true + errors * ABSOLUTE[key] * draw:.6g}, std = {ABSOLUTE[key]:.3g}}}"
    value = true * (1 + errors * RELATIVE[key] * draw)
    return f"{{value = {value:.6g}, std = {RELATIVE[key] * abs(value):.3g}}}"


def data_sheet(
    vehicle: PlantVehicle,
    mount: Mount,
    rng: np.random.Generator,
    *,
    errors: float = 1.0,
    load: tuple[float, float] | None = None,
    reference: Mapping[str, float] | None = None,
    title: str = "A simulated vehicle: what a data sheet would say of it.",
) -> str:
    """A vehicle file's text: figures off by what their std says, times `errors` (0 = exact figures, still with their std).

    load: mass and CG height of the load where it is told. reference: the loaded vehicle's truth.
    """
    # JSON's text is TOML's too
    name, body = (json.dumps(text) for text in (f"{vehicle.name} (simulated)", vehicle.body))
    lines = [f"# {title}", "[vehicle]", f"name = {name}", f"body = {body}"]
    for key, true in sheet_values(vehicle).items():
        figure = _figure(key, true, errors, rng)
        lines.append(f"{key} = {figure}")
        if key == "track_rear_m" and vehicle.camber_compensation_rear == RIGID:
            # a live axle's springs: the plant's rates are those at the wheels
            lines.append(
                f"spring_base_rear_m = {{value = {_VALUE.findall(figure)[0]}, std = {BASE_STD_M:g}}}"
            )
    if load is not None:
        # an empty vehicle is a load of 0 kg at no height in particular
        mass, height = load
        lines += ["", "[load]", f"mass_kg = {{value = {mass:.6g}, std = {max(_LOAD_STD * mass, 1.0):.3g}}}"]
        if mass > 0:
            lines.append(f"height_m = {{value = {height:.4g}, std = 0.05}}")
    places = {
        "imu_behind_front_axle_m": mount.behind_front_axle_m,
        "imu_left_m": mount.left_m,
        "imu_above_ground_m": mount.above_ground_m,
    }
    lines += ["", "[sensors]"]
    for key, true in places.items():
        value = true + errors * PLACE_STD_M * float(np.clip(rng.standard_normal(), -_FARTHEST, _FARTHEST))
        lines.append(f"{key} = {{value = {value:.4f}, std = {PLACE_STD_M}}}")
    if reference is not None:
        lines += ["", "[reference]  # the truth, of the loaded vehicle"]
        lines += [f"{name} = {value:.8g}" for name, value in reference.items() if name in PARAMETERS]
    return "\n".join(lines) + "\n"


_SAME = frozenset(
    {
        "wheelbase_m", "track_front_m", "track_rear_m", "roll_center_height_front_m", "roll_center_height_rear_m",
        "spring_rate_front_npm", "spring_rate_rear_npm", "anti_roll_stiffness_front_nmprad",
        "anti_roll_stiffness_rear_nmprad", "steering_ratio", "brake_gain_nmppa", "brake_front_share",
        "drive_front_share", "drag_area_m2", "rolling_resistance",
    }
)  # fmt: skip


_HARDEST_TYRE_NPM = 3e7
"""A tyre that gives a tenth of a millimetre: a wheel on a harder one hops quicker than the plant's steps can follow."""


def plant_vehicle(vehicle: Vehicle) -> PlantVehicle:
    """A plant's vehicle from a vehicle file: the preset of the nearest body, with every figure that the file states.

    Raises VehicleError where the figures together are no vehicle.
    """
    base = next((p for p in PRESETS.values() if p.body == vehicle.body), next(iter(PRESETS.values())))
    q = {key: quantity.value for key, quantity in vehicle.quantities.items()}
    changes: dict[str, float | str] = {key: value for key, value in q.items() if key in _SAME}
    changes["name"] = vehicle.name or "vehicle"
    wheelbase = q.get("wheelbase_m", base.wheelbase_m)
    for axle in ("front", "rear"):
        if (unsprung := q.get(f"unsprung_mass_{axle}_kg")) is not None:
            changes[f"unsprung_mass_{axle}_kg"] = unsprung / 2
        if (rate := q.get(f"damper_rate_{axle}_nspm")) is not None:
            slopes = [f"damper_{way}_{axle}_nspm" for way in ("compression", "extension")]
            mean = sum(getattr(base, slope) for slope in slopes) / 2
            changes |= {slope: getattr(base, slope) * rate / mean for slope in slopes}
        if (rate := q.get("tire_vertical_rate_npm")) is not None:
            changes[f"tire_vertical_rate_{axle}_npm"] = min(rate, _HARDEST_TYRE_NPM)
        if (inertia := q.get("wheel_inertia_kgm2")) is not None:
            changes[f"wheel_inertia_{axle}_kgm2"] = inertia
        if (radius := q.get("wheel_radius_m")) is not None:
            squash = getattr(base, f"wheel_radius_{axle}_m") - rolling_radii_m(base)[axle == "rear"]
            changes[f"wheel_radius_{axle}_m"] = radius + squash
    try:
        return _as_stated(_with_masses(_replaced(base, changes), base, q, wheelbase), q)
    except ValueError as error:
        raise VehicleError(f"the plant cannot be made from it: {error}", path=vehicle.path) from error


def _replaced(vehicle: PlantVehicle, changes: Mapping[str, float | str]) -> PlantVehicle:
    behind = vehicle.sprung_cg_behind_front_axle_m
    scale = float(changes.get("wheelbase_m", vehicle.wheelbase_m)) / vehicle.wheelbase_m
    return replace(vehicle, sprung_cg_behind_front_axle_m=behind * scale, **changes)  # type: ignore[arg-type]


def _with_masses(
    vehicle: PlantVehicle, base: PlantVehicle, q: Mapping[str, float], wheelbase: float
) -> PlantVehicle:
    """Set the sprung mass and its CG so that the whole vehicle has the stated mass and CG; inertias grow with the mass."""
    front, rear = 2 * vehicle.unsprung_mass_front_kg, 2 * vehicle.unsprung_mass_rear_kg
    total = q.get("mass_kg", vehicle.mass_kg)
    sprung = total - front - rear
    if sprung <= 0:
        raise ValueError(f"mass_kg is {total:g}, the unsprung masses {front + rear:g}")
    behind, height = vehicle.sprung_cg_behind_front_axle_m, vehicle.sprung_cg_height_m
    if "cg_to_front_axle_m" in q:
        behind = (q["cg_to_front_axle_m"] * total - rear * wheelbase) / sprung
    if "cg_height_m" in q:
        wheels = front * vehicle.wheel_radius_front_m + rear * vehicle.wheel_radius_rear_m
        height = (q["cg_height_m"] * total - wheels) / sprung
    share = sprung / base.sprung_mass_kg
    longer = (wheelbase / base.wheelbase_m) ** 2
    return replace(
        vehicle,
        sprung_mass_kg=sprung,
        sprung_cg_behind_front_axle_m=behind,
        sprung_cg_height_m=height,
        sprung_roll_inertia_kgm2=base.sprung_roll_inertia_kgm2 * share,
        sprung_pitch_inertia_kgm2=base.sprung_pitch_inertia_kgm2 * share * longer,
        sprung_yaw_inertia_kgm2=base.sprung_yaw_inertia_kgm2 * share * longer,
    )


def _as_stated(vehicle: PlantVehicle, q: Mapping[str, float]) -> PlantVehicle:
    """Take out what tyres that give way leave between a stated figure of the whole vehicle and the standing plant's."""
    lever = vehicle.mass_kg / vehicle.sprung_mass_kg
    for key, field, factor in (
        ("cg_height_m", "sprung_cg_height_m", lever),
        ("cg_to_front_axle_m", "sprung_cg_behind_front_axle_m", lever),
        ("roll_inertia_kgm2", "sprung_roll_inertia_kgm2", 1.0),
        ("pitch_inertia_kgm2", "sprung_pitch_inertia_kgm2", 1.0),
    ):
        if key in q:
            missing = (q[key] - truth(vehicle, ())[key]) * factor
            vehicle = replace(vehicle, **{field: getattr(vehicle, field) + missing})
    return vehicle
