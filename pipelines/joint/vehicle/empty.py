"""What belongs to a vehicle whatever its load: its parameters as they follow from the shared unknowns, empty as it stands."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pipelines.joint.vehicle.outputs import lacked_by_springs, roll_damping_of, roll_stiffness_of
from pipelines.joint.vehicle.unknowns import AXLES
from pipelines.results import FloatArray

Values = Mapping[str, FloatArray]


@dataclass(frozen=True)
class Figure:
    """A vehicle's parameter. of: from the unknowns by name, (n,) each, to (n,). needs: unknowns that must be there."""

    name: str
    title: str
    unit: str
    of: Callable[[Values], FloatArray]
    needs: tuple[str, ...]


def _plain(name: str, title: str, unit: str, unknown: str) -> Figure:
    return Figure(name, title, unit, lambda v: np.asarray(v[unknown]), (unknown,))


def _damper(axle: str) -> Figure:
    bump, rebound = f"bump_{axle}", f"rebound_{axle}"
    return Figure(
        f"damper_rate_{axle}_nspm", f"{axle} damper rate", "N·s/m",
        lambda v: np.asarray(0.5 * (np.asarray(v[bump]) + v[rebound])), (bump, rebound),
    )  # fmt: skip


def _bar(axle: str) -> Figure:
    """The bar itself: its unknown is less what springs that stand closer together than the wheels lack."""

    def of(values: Values) -> FloatArray:
        at_wheels = np.asarray(values[f"spring_{axle}"]) * values[f"track_{axle}"] ** 2
        return np.asarray(values[f"bar_{axle}"] + lacked_by_springs(at_wheels, values[f"spring_base_{axle}"]))

    needs = tuple(f"{part}_{axle}" for part in ("bar", "spring", "track", "spring_base"))
    return Figure(f"anti_roll_stiffness_{axle}_nmprad", f"{axle} anti-roll bar", "N·m/rad", of, needs)


def _stiffness(values: Values) -> FloatArray:
    return roll_stiffness_of(values, empty=True)


def _damping(values: Values) -> FloatArray:
    return roll_damping_of(values)


ROLL = tuple(f"{part}_{axle}" for part in ("spring", "bar", "track") for axle in AXLES)

FIGURES: tuple[Figure, ...] = (
    _plain("empty_mass_kg", "mass, empty", "kg", "empty_mass"),
    _plain("empty_cg_height_m", "CG height, empty", "m", "empty_h"),
    _plain("empty_cg_to_front_axle_m", "CG behind the front axle, empty", "m", "empty_x"),
    _plain("empty_cg_lateral_offset_m", "CG left of the middle, empty", "m", "empty_y"),
    Figure("roll_stiffness_nmprad", "roll stiffness, empty", "N·m/rad", _stiffness, ROLL),
    *(_plain(f"spring_rate_{a}_npm", f"{a} spring rate", "N/m", f"spring_{a}") for a in AXLES),
    *(_bar(a) for a in AXLES),
    Figure("roll_damping_nmsprad", "roll damping", "N·m·s/rad", _damping,
           tuple(f"{part}_{a}" for part in ("bump", "rebound", "track", "spring_base") for a in AXLES)),
    *(_damper(a) for a in AXLES),
    *(_plain(f"friction_{a}_n", f"{a} dry friction", "N", f"friction_{a}") for a in AXLES),
    *(_plain(f"roll_center_height_{a}_m", f"{a} roll centre", "m", f"roll_center_{a}") for a in AXLES),
    _plain("pitch_center_height_m", "pitch centre, braking", "m", "pitch_center_brake"),
    _plain("pitch_center_height_drive_m", "pitch centre, driving", "m", "pitch_center_drive"),
    _plain("roll_inertia_kgm2", "roll inertia, empty", "kg·m²", "roll_inertia"),
    _plain("pitch_inertia_kgm2", "pitch inertia, empty", "kg·m²", "pitch_inertia"),
    _plain("tire_vertical_rate_npm", "tyre rate", "N/m", "tyre_rate"),
    _plain("drag_area_m2", "drag area", "m²", "drag"),
    _plain("imu_behind_front_axle_m", "inertial unit behind the front axle", "m", "imu_x"),
    _plain("imu_left_m", "inertial unit left of the middle", "m", "imu_y"),
    _plain("imu_above_ground_m", "inertial unit above ground", "m", "imu_h"),
    *(_plain(f"imu_{axis}_rad", f"inertial unit askew in {axis}", "rad", f"askew_{axis}")
      for axis in ("roll", "pitch", "yaw")),
)  # fmt: skip
"""In the order in which reports list them."""

STEP = 1e-3


def figure_at(
    figure: Figure, names: tuple[str, ...], at: FloatArray, std: FloatArray
) -> tuple[float, FloatArray]:
    """A figure at (k,) unknowns and its derivative (k,) by them, SI. std: (k,) sizes of the steps' unit."""
    rows = [names.index(name) for name in figure.needs]
    moved = np.tile(at, (2 * len(rows) + 1, 1))
    step = np.arange(len(rows))
    moved[1 + step, rows] += STEP * std[rows]
    moved[1 + len(rows) + step, rows] -= STEP * std[rows]
    found = figure.of(dict(zip(names, moved.T, strict=True)))
    gradient = np.zeros(len(names))
    gradient[rows] = (found[1 : 1 + len(rows)] - found[1 + len(rows) :]) / (2 * STEP * std[rows])
    return float(found[0]), gradient
