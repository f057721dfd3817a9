"""The plant's vehicle standing still, and its small motion: equilibrium, stiffness and inertia without the kernels.

The same geometry as in `motion`, written a second time from virtual work on flat ground, so that each checks the
other. Coordinates: height of the sprung CG, roll, pitch, and the four deflections.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.body import PlantVehicle
from pipelines.simulation.records import GRAVITY


@dataclass(frozen=True)
class Posture:
    """At rest, or in a steady turn.

    coordinates: (7,) height of the sprung CG over the road, roll, pitch, deflections. feet, hubs: (4, 3) from the
    sprung CG in road axes. tire_forces: (4,) normal, N.
    """

    coordinates: FloatArray
    feet: FloatArray
    hubs: FloatArray
    tire_forces: FloatArray


def rotation(roll: float, pitch: float) -> FloatArray:
    """(3, 3) from body to road axes."""
    sr, cr, sp, cp = math.sin(roll), math.cos(roll), math.sin(pitch), math.cos(pitch)
    return np.array([[cp, sp * sr, sp * cr], [0.0, cr, -sr], [-sp, cp * sr, cp * cr]])


def paths(wheels: FloatArray, deflection: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(4, 3) directions in which foot and hub go with deflection, body axes, where the deflections are so."""
    one, turned, bent = (
        np.ones(4),
        wheels[:, at.SIDE_CURVE] * deflection,
        wheels[:, at.PATH_CURVE] * deflection,
    )
    foot = np.column_stack([wheels[:, at.FOOT_PATH_X] + turned, wheels[:, at.FOOT_PATH_Y] + bent, one])
    hub = np.column_stack([wheels[:, at.HUB_PATH_X] + turned, wheels[:, at.HUB_PATH_Y] + bent, one])
    return foot, hub


def _places(q: FloatArray, wheels: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    turn = rotation(float(q[1]), float(q[2]))
    # a path that bends evenly has gone as far as its mean direction says
    foot_path, hub_path = paths(wheels, q[3:] / 2)
    feet = wheels[:, at.FOOT_X : at.FOOT_Z + 1] + q[3:, None] * foot_path
    hubs = wheels[:, at.HUB_X : at.HUB_Z + 1] + q[3:, None] * hub_path
    # round wheels stand under their hubs however the body pitches
    return turn, hubs @ turn.T + (feet - hubs) @ rotation(float(q[1]), 0.0).T, hubs @ turn.T


def spring_forces(deflection: FloatArray, body: FloatArray, wheels: FloatArray) -> FloatArray:
    """(4,) static suspension forces, N, without dry friction."""
    d = np.asarray(deflection)
    force = wheels[:, at.PRELOAD] + wheels[:, at.SPRING] * d * (1 + body[at.STIFFENING] * d**2)
    force += body[at.BUMP_RATE] * (
        np.maximum(d - body[at.BUMP_AT], 0) + np.minimum(d + body[at.REBOUND_AT], 0)
    )
    return np.asarray(force + wheels[:, at.BAR] * (d - d[[1, 0, 3, 2]]))


def spring_rates(deflection: FloatArray, body: FloatArray, wheels: FloatArray) -> FloatArray:
    """(4,) local rates, N/m, without bars."""
    d = np.asarray(deflection)
    rate = wheels[:, at.SPRING] * (1 + 3 * body[at.STIFFENING] * d**2)
    return np.asarray(rate + body[at.BUMP_RATE] * ((d > body[at.BUMP_AT]) | (d < -body[at.REBOUND_AT])))


def _residual(q: FloatArray, body: FloatArray, wheels: FloatArray, lateral_mps2: float) -> FloatArray:
    """(7,) generalised forces in a steady turn of this lateral acceleration; 0 in equilibrium."""
    turn, feet, hubs = _places(q, wheels)
    squash = np.maximum(-(q[0] + feet[:, 2]), 0.0)
    normal = wheels[:, at.TIRE] * squash
    pull = np.array([0.0, -lateral_mps2, -GRAVITY])
    masses = wheels[:, at.UNSPRUNG]
    total = body[at.MASS] + masses.sum()
    # the tyres' lateral forces hold the turn without yaw; on an axle by load
    center = (masses @ hubs[:, 0]) / total
    front, rear = feet[:2, 0].mean(), feet[2:, 0].mean()
    axle = total * lateral_mps2 * np.array([center - rear, front - center]) / (front - rear)
    lateral = (
        np.repeat(axle, 2) * normal / np.maximum(np.repeat([normal[:2].sum(), normal[2:].sum()], 2), 1e-9)
    )
    force = np.column_stack([np.zeros(4), lateral, normal])
    contact = feet + squash[:, None] * np.array([0.0, 0.0, 1.0])
    aside = body[at.PATCH_GIVE] * _across(q, body, wheels, lateral, normal)
    contact[:, 1] += aside
    weight = masses[:, None] * pull
    moment = turn.T @ (np.cross(contact, force) + np.cross(hubs, weight)).sum(axis=0)
    # rolling wheels resist the turn: spin times yaw rate is acceleration over radius
    moment[0] += lateral_mps2 * float(
        (wheels[:, at.WHEEL_INERTIA] / (wheels[:, at.FREE_RADIUS] - squash / 3)).sum()
    )
    foot_path, hub_path = paths(wheels, q[3:])
    guide = ((force @ turn) * foot_path).sum(axis=1) + ((weight @ turn) * hub_path).sum(axis=1)
    guide += normal * aside * wheels[:, at.CAMBER_RATE] - spring_forces(q[3:], body, wheels)
    return np.concatenate([[normal.sum() + total * pull[2], moment[0], moment[1]], guide])


def _across(
    q: FloatArray, body: FloatArray, wheels: FloatArray, lateral: FloatArray, normal: FloatArray
) -> FloatArray:
    """(4,) deflections of rolling tyres across, m, far from sliding: what their forces ask beside what leaning wheels push."""
    loads = np.maximum(normal, 1e-9)
    softer = np.clip(1 - body[at.LOSS_STIFFNESS] * (loads / wheels[:, at.NOMINAL] - 1), 0.4, 1.4)
    lean = q[1] + wheels[:, at.CAMBER_RATE] * q[3:]
    pushed = lateral / loads + body[at.CAMBER] * lean * float(np.any(lateral != 0))
    return np.asarray(body[at.SIGMA_Y] * pushed / (wheels[:, at.STIFFNESS_Y] * softer))


def slopes(function: Callable[[FloatArray], FloatArray], q: FloatArray) -> FloatArray:
    """Jacobian by central differences."""
    columns = []
    for k in range(len(q)):
        step = np.zeros(len(q))
        step[k] = 1e-6
        columns.append((function(q + step) - function(q - step)) / 2e-6)
    return np.column_stack(columns)


def posture(vehicle: PlantVehicle, lateral_mps2: float = 0.0, start: FloatArray | None = None) -> Posture:
    """Equilibrium on flat ground, at rest or in a steady turn (+ left) with its wheels' gyroscopic moment.

    start: (7,) coordinates near it, where known. Raises ValueError where there is none (the vehicle falls over, or a
    stop is far exceeded).
    """
    body, wheels = at.pack(vehicle)
    q = np.zeros(7) if start is None else np.array(start)
    if start is None:
        q[0] = vehicle.sprung_cg_height_m

    def residual(x: FloatArray) -> FloatArray:
        return _residual(x, body, wheels, lateral_mps2)

    stiffness, last = np.zeros((7, 7)), np.inf
    for _ in range(60):
        # far away the stops make it uneven; near, the last slopes serve
        if last > 2e-4:
            stiffness = slopes(residual, q)
        move = np.linalg.solve(stiffness, residual(q))
        last = float(np.abs(move).max())
        q = q - move * min(1.0, 0.03 / max(last, 1e-12))
        if last < 1e-11:
            break
    else:
        raise ValueError(f"{vehicle.name} does not find its rest under its load")
    _, feet, hubs = _places(q, wheels)
    squash = -(q[0] + feet[:, 2])
    if squash.min() <= 0 or abs(q[1]) > 0.3 or abs(q[2]) > 0.3:
        raise ValueError(f"{vehicle.name} does not stand on its four wheels under its load")
    return Posture(q, feet, hubs, wheels[:, at.TIRE] * squash)


def standing_stiffness(vehicle: PlantVehicle) -> FloatArray:
    """(7, 7) of springs, bars, tyres, gravity and the standing loads together, the feet free to slide on the road."""
    body, wheels = at.pack(vehicle)
    return -slopes(lambda q: _residual(q, body, wheels, 0.0), posture(vehicle).coordinates)
