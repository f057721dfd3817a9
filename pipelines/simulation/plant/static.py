"""The plant's vehicle standing still, and its small motion: equilibrium, stiffness and inertia without the kernels.

The same geometry as in `motion`, written a second time from virtual work on flat ground, so that each checks the
other. Coordinates: height of the sprung CG, roll, pitch, and the four deflections.
"""

from __future__ import annotations

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


def rotation(roll: float | FloatArray, pitch: float | FloatArray) -> FloatArray:
    """(..., 3, 3) from body to road axes."""
    sr, cr, sp, cp = np.sin(roll), np.cos(roll), np.sin(pitch), np.cos(pitch)
    turn = np.zeros((*np.shape(sr), 3, 3))
    turn[..., 0, 0], turn[..., 0, 1], turn[..., 0, 2] = cp, sp * sr, sp * cr
    turn[..., 1, 1], turn[..., 1, 2] = cr, -sr
    turn[..., 2, 0], turn[..., 2, 1], turn[..., 2, 2] = -sp, cp * sr, cp * cr
    return turn


def paths(wheels: FloatArray, deflection: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(..., 4, 3) directions in which foot and hub go with deflection (..., 4), body axes, where the deflections are so."""
    turned, bent = wheels[:, at.SIDE_CURVE] * deflection, wheels[:, at.PATH_CURVE] * deflection
    foot, hub = np.ones((*np.shape(turned), 3)), np.ones((*np.shape(turned), 3))
    foot[..., 0], foot[..., 1] = wheels[:, at.FOOT_PATH_X] + turned, wheels[:, at.FOOT_PATH_Y] + bent
    hub[..., 0], hub[..., 1] = wheels[:, at.HUB_PATH_X] + turned, wheels[:, at.HUB_PATH_Y] + bent
    return foot, hub


def _places(q: FloatArray, wheels: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(..., 3, 3) body to road axes, (..., 4, 3) feet and hubs; q: (..., 7)."""
    turn = rotation(q[..., 1], q[..., 2])
    # a path that bends evenly has gone as far as its mean direction says
    foot_path, hub_path = paths(wheels, q[..., 3:] / 2)
    feet = wheels[:, at.FOOT_X : at.FOOT_Z + 1] + q[..., 3:, None] * foot_path
    hubs = wheels[:, at.HUB_X : at.HUB_Z + 1] + q[..., 3:, None] * hub_path
    back, upright = turn.swapaxes(-1, -2), rotation(q[..., 1], 0.0 * q[..., 1]).swapaxes(-1, -2)
    # round wheels stand under their hubs however the body pitches
    return turn, hubs @ back + (feet - hubs) @ upright, hubs @ back


def spring_forces(deflection: FloatArray, body: FloatArray, wheels: FloatArray) -> FloatArray:
    """(..., 4) static suspension forces, N, without dry friction."""
    d = np.asarray(deflection)
    force = wheels[:, at.PRELOAD] + wheels[:, at.SPRING] * d * (1 + body[at.STIFFENING] * d**2)
    force += body[at.BUMP_RATE] * (
        np.maximum(d - body[at.BUMP_AT], 0) + np.minimum(d + body[at.REBOUND_AT], 0)
    )
    return np.asarray(force + wheels[:, at.BAR] * (d - d[..., [1, 0, 3, 2]]))


def spring_rates(deflection: FloatArray, body: FloatArray, wheels: FloatArray) -> FloatArray:
    """(4,) local rates, N/m, without bars."""
    d = np.asarray(deflection)
    rate = wheels[:, at.SPRING] * (1 + 3 * body[at.STIFFENING] * d**2)
    return np.asarray(rate + body[at.BUMP_RATE] * ((d > body[at.BUMP_AT]) | (d < -body[at.REBOUND_AT])))


def _moment(places: FloatArray, forces: FloatArray) -> FloatArray:
    """(..., 3) moment of forces (..., 4, 3) at places (..., 4, 3)."""
    (x, y, z), (fx, fy, fz) = np.moveaxis(places, -1, 0), np.moveaxis(forces, -1, 0)
    return np.asarray(np.stack([y * fz - z * fy, z * fx - x * fz, x * fy - y * fx]).sum(axis=-1).T)


def _residual(q: FloatArray, body: FloatArray, wheels: FloatArray, lateral_mps2: float) -> FloatArray:
    """(n, 7) generalised forces in a steady turn of this lateral acceleration at postures q (n, 7); 0 in equilibrium."""
    turn, feet, hubs = _places(q, wheels)
    squash = np.maximum(-(q[:, :1] + feet[:, :, 2]), 0.0)
    normal = wheels[:, at.TIRE] * squash
    pull = np.array([0.0, -lateral_mps2, -GRAVITY])
    masses = wheels[:, at.UNSPRUNG]
    total = body[at.MASS] + masses.sum()
    # the tyres' lateral forces hold the turn without yaw; on an axle by load
    center = (hubs[:, :, 0] @ masses) / total
    front, rear = feet[:, :2, 0].mean(axis=1), feet[:, 2:, 0].mean(axis=1)
    axle = total * lateral_mps2 * np.stack([center - rear, front - center], axis=1) / (front - rear)[:, None]
    carried = np.repeat(normal.reshape(-1, 2, 2).sum(axis=2), 2, axis=1)
    lateral = np.repeat(axle, 2, axis=1) * normal / np.maximum(carried, 1e-9)
    force = np.stack([np.zeros_like(normal), lateral, normal], axis=-1)
    aside = body[at.PATCH_GIVE] * _across(q, body, wheels, lateral, normal)
    contact = feet + np.stack([np.zeros_like(aside), aside, squash], axis=-1)
    weight = masses[:, None] * pull
    moments = _moment(contact, force) + _moment(hubs, np.broadcast_to(weight, hubs.shape))
    moment = (moments[:, None, :] @ turn)[:, 0]
    # rolling wheels resist the turn: spin times yaw rate is acceleration over radius; and turn their carriers along their guides
    turned = lateral_mps2 * wheels[:, at.WHEEL_INERTIA] / (wheels[:, at.FREE_RADIUS] - squash / 3)
    moment[:, 0] += turned.sum(axis=1)
    foot_path, hub_path = paths(wheels, q[:, 3:])
    guide = ((force @ turn) * foot_path).sum(axis=2) + ((weight @ turn) * hub_path).sum(axis=2)
    guide += (normal * aside + turned) * wheels[:, at.CAMBER_RATE] - spring_forces(q[:, 3:], body, wheels)
    lift = normal.sum(axis=1) + total * pull[2]
    return np.column_stack([lift, moment[:, 0], moment[:, 1], guide])


def _across(
    q: FloatArray, body: FloatArray, wheels: FloatArray, lateral: FloatArray, normal: FloatArray
) -> FloatArray:
    """(n, 4) deflections of rolling tyres across, m, far from sliding: what their forces ask beside what leaning wheels push."""
    loads = np.maximum(normal, 1e-9)
    softer = np.clip(1 - body[at.LOSS_STIFFNESS] * (loads / wheels[:, at.NOMINAL] - 1), 0.4, 1.4)
    lean = q[:, 1:2] + wheels[:, at.CAMBER_RATE] * q[:, 3:]
    turning = np.any(lateral != 0, axis=1, keepdims=True)
    pushed = lateral / loads + body[at.CAMBER] * lean * turning
    return np.asarray(body[at.SIGMA_Y] * pushed / (wheels[:, at.STIFFNESS_Y] * softer))


STEP = 1e-6


def slopes(function: Callable[[FloatArray], FloatArray], q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What a function (n, 7) -> (n, m) gives at q (7,), and its Jacobian (m, 7) by central differences, in a single call."""
    steps = STEP * np.eye(len(q))
    found = function(np.vstack([q, q + steps, q - steps]))
    up, down = found[1 : 1 + len(q)], found[1 + len(q) :]
    return found[0], (up - down).T / (2 * STEP)


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
            left, stiffness = slopes(residual, q)
        else:
            left = residual(q[None])[0]
        move = np.linalg.solve(stiffness, left)
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
    return -slopes(lambda q: _residual(q, body, wheels, 0.0), posture(vehicle).coordinates)[1]
