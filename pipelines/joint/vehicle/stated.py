"""What the vehicle file states of combinations of unknowns: it binds them as a relation of the drive would."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from pipelines.evidence import Evidence, Kind, Values
from pipelines.joint.vehicle.outputs import roll_damping_of, roll_stiffness_of
from pipelines.joint.vehicle.suspension import levels
from pipelines.joint.vehicle.unknowns import AXLES
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle

DEPENDS = tuple(f"{part}_{axle}" for part in ("spring", "bar", "track") for axle in AXLES)


DAMPED_BY = tuple(f"{part}_{axle}" for part in ("bump", "rebound", "spring_base", "track") for axle in AXLES)


def _roll_stiffness(values: Values) -> FloatArray:
    # a data sheet's stiffness is that of the empty vehicle as it stands
    return (
        np.atleast_2d(roll_stiffness_of(values, empty=True))
        if np.ndim(values["bar_front"])
        else np.array([roll_stiffness_of(values, empty=True)])
    )


def stated_relations(vehicle: Vehicle) -> tuple[Evidence, ...]:
    """What the file states of several unknowns together."""
    return (*_stated_roll_stiffness(vehicle), *_stated_roll_damping(vehicle), *_stated_level(vehicle))


def stated_beside(evidence: Sequence[Evidence], vehicle: Vehicle) -> tuple[Evidence, ...]:
    """What the file states, as far as a drive's relations can take it.

    The unit's level is that of the empty vehicle. A load has the body lean, which deflections at both axles tell; without them it is in
    the offset that the relations share (a nose that 500 kg lift by 1.3 degrees), and that is not the stated one.
    """
    used = {name for e in evidence for name in e.unknowns}
    told = {"zero_fl", "zero_rl"} <= used
    return tuple(e for e in stated_relations(vehicle) if told or e.title not in LEVELS)


LEVEL: Mapping[str, tuple[Kind, str, str, float]] = {
    "imu_roll_deg": ("roll", "askew_roll", "offset_y", -1.0),
    "imu_pitch_deg": ("pitch", "askew_pitch", "offset_x", 1.0),
}
"""Key: kind, and the unknowns that make what an accelerometer shows on level ground: how askew it sits, and its offset by its sign."""


def shown_on_level_ground(key: str, values: Values) -> FloatArray:
    """Degrees that a key of `LEVEL` is, () or (n,): f_y = g askew - offset of a unit that leans to the right, f_x = -(g askew + offset)
    of one that looks down."""
    _, askew, offset, sign = LEVEL[key]
    return np.asarray(np.degrees(np.asarray(values[askew]) + sign * np.asarray(values[offset]) / GRAVITY))


def _level(key: str, values: Values) -> FloatArray:
    shown = shown_on_level_ground(key, values)
    return np.atleast_2d(shown) if np.ndim(shown) else np.array([float(shown)])


def _stated_level(vehicle: Vehicle) -> tuple[Evidence, ...]:
    """How far from level the inertial unit stood on level ground: its mounting and its accelerometer's offset in one figure."""
    found = []
    for key, (kind, askew, offset, _) in LEVEL.items():
        told = vehicle.sensors.get(key)
        if told is not None:
            spread = np.array([[max(told.std, LEAST_LEVEL_DEG) ** 2]])
            found.append(
                Evidence(
                    kind, "vehicle file", f"stated {key}", "vehicle file", np.array([told.value]), spread,
                    partial(_level, key), (askew, offset),
                )
            )  # fmt: skip
    return tuple(found)


LEVELS = tuple(f"stated {key}" for key in LEVEL)
"""Titles of what is stated of the unit's level."""

LEAST_LEVEL_DEG = 0.01
"""No garage's floor is more level."""


def _stated_total(
    name: str, total: Quantity, predict: Callable[[Values], FloatArray], depends: tuple[str, ...]
) -> Evidence:
    """The relation of a stated sum over both axles to the unknowns that make it up."""
    spread = np.array([[max(total.std, 1e-3 * total.value) ** 2]])
    return Evidence(
        "roll",
        "vehicle file",
        f"stated {name}",
        "vehicle file",
        np.array([total.value]),
        spread,
        predict,
        depends,
    )


def _stated_roll_stiffness(vehicle: Vehicle) -> tuple[Evidence, ...]:
    """The roll stiffness where the file states it and not the springs and bars that make it up.

    With springs and bars stated as well it is most likely their sum, and would count them twice.
    """
    total = vehicle.get("roll_stiffness_nmprad")
    parts = [vehicle.get(f"spring_rate_{axle}_npm") for axle in AXLES]
    parts += [vehicle.get(f"anti_roll_stiffness_{axle}_nmprad") for axle in AXLES]
    if total is None or all(part is not None for part in parts):
        return ()
    if any(levels(vehicle, axle) for axle in AXLES):
        # it is the empty vehicle's, and such springs grow with the load
        return ()
    return (_stated_total("roll stiffness", total, _roll_stiffness, DEPENDS),)


def _roll_damping(values: Values) -> FloatArray:
    found = roll_damping_of(values)
    return np.atleast_2d(found) if np.ndim(values["bump_front"]) else np.array([float(found)])


def _stated_roll_damping(vehicle: Vehicle) -> tuple[Evidence, ...]:
    """The roll damping where the file states it and not the dampers that make it up."""
    total = vehicle.get("roll_damping_nmsprad")
    if total is None or all(vehicle.get(f"damper_rate_{axle}_nspm") is not None for axle in AXLES):
        return ()
    return (_stated_total("roll damping", total, _roll_damping, DAMPED_BY),)
