"""How well the vehicle file knows the empty vehicle: the quality of the data that a study gives to the verdict.

sheet      what a data sheet says (`pipelines.simulation.logs.vehicle`): mass 1 %, CG along 10 mm, roll and pitch centres
           20 mm, bars 4 %, and nothing of the CG's height and lateral place.
measured   a vehicle that was weighed at its corners, tilted for its CG's height, and whose suspension was measured for
           kinematics and compliance. Spreads are those of such rigs and not of the simulated vehicle:

- corner scales: 0.1 % of their range each, fuel and ballast known to some kg: mass 0.25 %, CG 3 mm along and 2.5 mm across;
- height by lifting an axle or tilting (ISO 10392 and the like; springs held or their travel taken off): 1 %, the usual span
  of repeated tests by one laboratory; better rigs state 0.5 %;
- kinematics and compliance rigs: wheel travel to 0.1 mm and forces to 0.3 % give wheel and roll rates to 1-2 %, and the
  slopes of the contact patch's path, from which roll and pitch centres follow, to 0.005-0.01: 5 mm at half a track or half a
  wheelbase for the brakes, 8 mm for driving, where the shafts' torque comes in;
- what the wheels' loads take off an axle's roll stiffness, a newton of them: rates and bars less what the pads' forces in roll say, each
  to 0.5 % on one rig, 25 mm; the pads' way along as the body pitches, 10 mm a rad; wheels' centres along a metre of travel, 8 mm;
- the same rigs' camber a degree of roll: 0.05; wheel rates 50 mm above and below ride height beside that at it: 1 %; where bump
  stops begin: 3 mm; how far roll centres come down with the body: 0.1 m a m;
- a tyre rig's give of the patch, along and sideways 10 %;
- a scale for wheel, hub and half of the links: 1.5 %; tape and laser: 2 mm.

levelled   measured, and what the inertial unit shows with the empty vehicle on a level floor to 0.1 degrees (a bubble level of
surveyors, or the floor's own slope measured both ways).

zeroed     levelled, and what its deflection sensors show there to 0.3 mm, the mean of some readings after rolling in and rocking it.

Pads, drag, rolling resistance, inertias and dampers are no better known than before.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipelines.simulation.loads import truth
from pipelines.simulation.logs.vehicle import sheet_values
from pipelines.simulation.plant.vehicle import PlantVehicle
from pipelines.simulation.records import GRAVITY
from pipelines.vehicles.kinematics import AXLES, TRAVEL_M, rate_keys
from pipelines.vehicles.vehicle import Quantity, Vehicle

QUALITIES = ("sheet", "measured", "levelled", "zeroed")
RIG = "vehicle file (measured)"
FARTHEST = 2.5
"""Standard deviations beyond which a figure is never off: rigs are checked too."""

RATE_STD, DROP_STD, STOP_STD_M = 0.01, 0.1, 0.003
"""Of wheel rates above and below ride height (a share), of roll centres' drop, of where bump stops begin."""
EASED_STD_MPRAD, PATH_STD_MPRAD, SLOPE_STD = 0.025, 0.01, 0.008
"""Of what wheels' loads take off the roll stiffness, of their way in pitch, and of the hubs' along a metre of travel."""

BASE_STD_M = 0.003
"""Of how far a live axle's springs stand apart, where the sheet says it: a tape's, and a rig's roll rate beside its wheel rates."""

STIFF_NPM = 1e9
"""Of tyres whose load stays under the wheel, whatever they give."""

RELATIVE: Mapping[str, float] = {
    "mass_kg": 0.0025, "cg_height_m": 0.01, "unsprung_mass_front_kg": 0.015, "unsprung_mass_rear_kg": 0.015,
    "wheelbase_m": 0.0007, "track_front_m": 0.0013, "track_rear_m": 0.0013, "spring_rate_front_npm": 0.02,
    "spring_rate_rear_npm": 0.02, "anti_roll_stiffness_front_nmprad": 0.02, "anti_roll_stiffness_rear_nmprad": 0.02,
    "roll_stiffness_nmprad": 0.02, "tire_vertical_rate_npm": 0.03, "wheel_radius_m": 0.003,
}  # fmt: skip
"""Standard deviation over the value."""

ABSOLUTE_M: Mapping[str, float] = {
    "cg_to_front_axle_m": 0.003, "cg_lateral_offset_m": 0.0025, "roll_center_height_front_m": 0.005,
    "roll_center_height_rear_m": 0.005, "pitch_center_height_m": 0.005, "pitch_center_height_drive_m": 0.008,
    "camber_compensation": 0.05,
}  # fmt: skip
"""Standard deviation in the figure's own unit (m; a share)."""


LEVEL_DEG = 0.1
"""Standard deviation of a unit's reading on a level floor."""


def _with_readings(
    file: Vehicle, shown: Mapping[str, float], std: float, rng: np.random.Generator, errors: float
) -> Vehicle:
    """The vehicle file with sensors' readings on the empty vehicle, each off by its spread times `errors`."""
    found = dict(file.sensors)
    for key, value in shown.items():
        draw = float(np.clip(rng.standard_normal(), -FARTHEST, FARTHEST))
        found[key] = Quantity(value + errors * std * draw, std, RIG)
    return replace(file, sensors=found)


def levelled(
    file: Vehicle, shown: Mapping[str, float], rng: np.random.Generator, errors: float = 1.0
) -> Vehicle:
    """The vehicle file with what its inertial unit shows on level ground: the key in degrees, off by its spread times `errors`."""
    return _with_readings(file, shown, LEVEL_DEG, rng, errors)


ZERO_STD_M = 0.0003
"""Standard deviation of a deflection sensor's reading on the empty vehicle."""


def zeroed(
    file: Vehicle, shown: Mapping[str, float], rng: np.random.Generator, errors: float = 1.0
) -> Vehicle:
    """The vehicle file with what its deflection sensors show with the empty vehicle: the key in m, off by its spread times `errors`."""
    return _with_readings(file, shown, ZERO_STD_M, rng, errors)


def upright(plant: PlantVehicle) -> float:
    """The share of the body's roll by which wheels stay upright, as the hubs' masses feel it."""
    hubs = plant.unsprung_mass_front_kg, plant.unsprung_mass_rear_kg
    shares = plant.camber_compensation_front, plant.camber_compensation_rear
    return float(np.average(shares, weights=hubs))


def curves(plant: PlantVehicle, file: Mapping[str, Quantity]) -> dict[str, tuple[float, float]]:
    """True figure and std of the springs' curves, stops and roll centres' travel, by the vehicle file's keys.

    file: with the rates at ride height that the rig found: its error of scale is in all three.
    """
    found = {}
    # the plant's spring force is k d (1 + s d²), alike either way
    rise = 1 + 3 * plant.spring_stiffening_pm2 * TRAVEL_M**2
    for axle in AXLES:
        rest, *ends = rate_keys(axle)
        rate = file[rest].value * rise
        found |= dict.fromkeys(ends, (rate, RATE_STD * rate))
        found[f"roll_center_drop_{axle}"] = (getattr(plant, f"roll_center_drop_{axle}"), DROP_STD)
        found[f"bump_stop_clearance_{axle}_m"] = (plant.bump_clearance_m, STOP_STD_M)
    return found


def paths(plant: PlantVehicle) -> dict[str, tuple[float, float]]:
    """True figure and std of the ways that wheels' loads and hubs go, and of the tyres' give along, by the vehicle file's keys.

    The plant's wheels are round: loads stand under hubs, which go along straight lines in the body's side view. Its tyres' patches lag by the rolling radius less
    the hub's height, two thirds of the squash, of force over load. What pads under wheels that stay upright feel holds the hubs' weight as well.
    """
    ahead, length = truth(plant, ())["cg_to_front_axle_m"], plant.wheelbase_m
    springs = [sum(plant.preloads_n[i : i + 2]) / GRAVITY for i in (0, 2)]
    hubs = plant.unsprung_mass_front_kg, plant.unsprung_mass_rear_kg
    stay = plant.camber_compensation_front, plant.camber_compensation_rear
    aside = [2 * m / s * c * plant.wheel_radius_m for m, s, c in zip(hubs, springs, stay, strict=True)]
    front, rear = plant.side_slope_drive_front, plant.side_slope_drive_rear
    vertical = 0.5 * (plant.tire_vertical_rate_front_npm + plant.tire_vertical_rate_rear_npm)
    return {
        "patch_path_front_mprad": (plant.roll_center_height_front_m + aside[0], EASED_STD_MPRAD),
        "patch_path_rear_mprad": (plant.roll_center_height_rear_m + aside[1], EASED_STD_MPRAD),
        "patch_path_pitch_mprad": (
            float(np.mean(plant.hub_heights_m)) + ahead * (length - ahead) / length * (front - rear),
            PATH_STD_MPRAD,
        ),
        "wheel_recession_front": (-front, SLOPE_STD),
        "wheel_recession_rear": (-rear, SLOPE_STD),
        "tire_longitudinal_rate_npm": (1.5 * vertical, 0.1 * 1.5 * vertical),
    }


def lateral_rate(plant: PlantVehicle) -> float:
    """Side force over the way across of the middle of a tyre's load, N/m: mean of the axles, empty."""
    if plant.patch_give == 0:
        return STIFF_NPM
    load = plant.mass_kg * GRAVITY / 4
    slopes = 0.5 * (plant.cornering_stiffness_front_prad + plant.cornering_stiffness_rear_prad)
    return slopes * load / (plant.relaxation_lateral_m * plant.patch_give)


def measured(file: Vehicle, plant: PlantVehicle, rng: np.random.Generator, errors: float = 1.0) -> Vehicle:
    """The vehicle file with what the rigs found in place of the data sheet's figures, each off by its spread times `errors`.

    plant: the empty vehicle as it is. What no rig here measures stays as it was.
    """
    empty = truth(plant, ())
    true = {**sheet_values(plant), **{k: empty[k] for k in ("cg_height_m", "cg_lateral_offset_m")}}
    true["camber_compensation"] = upright(plant)
    found = dict(file.quantities)
    for key in (*RELATIVE, *ABSOLUTE_M):
        std = ABSOLUTE_M.get(key, RELATIVE.get(key, 0.0) * abs(true[key]))
        draw = float(np.clip(rng.standard_normal(), -FARTHEST, FARTHEST))
        value = true[key] + errors * std * draw
        found[key] = Quantity(min(value, 1.0) if key == "camber_compensation" else value, std, RIG)
    for key, (value, std) in (curves(plant, found) | paths(plant)).items():
        draw = float(np.clip(rng.standard_normal(), -FARTHEST, FARTHEST))
        found[key] = Quantity(value + errors * std * draw, std, RIG)
    if "spring_base_rear_m" in found:
        draw = float(np.clip(rng.standard_normal(), -FARTHEST, FARTHEST))
        found["spring_base_rear_m"] = Quantity(
            plant.track_rear_m + errors * BASE_STD_M * draw, BASE_STD_M, RIG
        )
    lateral = lateral_rate(plant)
    draw = float(np.clip(rng.standard_normal(), -FARTHEST, FARTHEST))
    found["tire_lateral_rate_npm"] = Quantity(lateral * (1 + 0.1 * errors * draw), 0.1 * lateral, RIG)
    return replace(file, quantities=found)
