"""Small motion of the plant's vehicle: roll gradient, natural frequencies, and the whole linear model."""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.body import PlantVehicle
from pipelines.simulation.plant.static import Posture, paths, posture, rotation, spring_rates
from pipelines.simulation.records import GRAVITY

SMALL_MPS2 = 0.05


def roll_gradient_degpg(vehicle: PlantVehicle, rest: Posture | None = None) -> float:
    """Steady roll against the horizon, degrees a g of lateral acceleration sensed at the sprung CG, tyres included."""
    near = (rest or posture(vehicle)).coordinates
    left, right = (posture(vehicle, a, near).coordinates[1] for a in (SMALL_MPS2, -SMALL_MPS2))
    lean = (left - right) / 2
    sensed = SMALL_MPS2 * np.cos(lean) + GRAVITY * np.sin(lean)
    return float(np.degrees(lean) / sensed * GRAVITY)


def small_motion(
    vehicle: PlantVehicle, rest: Posture | None = None, *, feet_held: bool = True
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass, damping and stiffness (7, 7) about rest, without gravity's part.

    Coordinates as in `static`: height, roll, pitch, deflections. The body moves along, across and in yaw so that
    the feet of each axle stay where they are on average, or, with feet_held = False, as on ice. Damping: mean of each damper's slopes, and the tyres'.
    """
    body, wheels = at.pack(vehicle)
    rest = rest or posture(vehicle)
    turn = rotation(float(rest.coordinates[1]), float(rest.coordinates[2]))
    foot_path, hub_path = (p @ turn.T for p in paths(wheels, rest.coordinates[3:]))

    def motion(places: FloatArray, path: FloatArray) -> FloatArray:
        """(4, 3, 10) of points a unit of (forward, left, yaw) and of the seven coordinates."""
        move = np.zeros((4, 3, 10))
        move[:, 0, 0] = move[:, 1, 1] = move[:, 2, 3] = 1.0
        for k, axis in ((2, 2), (4, 0), (5, 1)):
            move[:, :, k] = np.cross(np.eye(3)[axis], places)
        for i in range(4):
            move[i, :, 6 + i] = path[i]
        return move

    # the road holds the tyres where they meet it, above the feet of the unloaded wheels
    contact = rest.feet * [1, 1, 0] - [0, 0, rest.coordinates[0]]
    feet, hubs = motion(contact, foot_path), motion(rest.hubs, hub_path)
    held = np.array([feet[:, 0].mean(axis=0), feet[:2, 1].mean(axis=0), feet[2:, 1].mean(axis=0)])
    mass = np.zeros((10, 10))
    mass[0, 0] = mass[1, 1] = mass[3, 3] = body[at.MASS]
    inertia = np.array(
        [[body[at.IXX], 0, -body[at.IXZ]], [0, body[at.IYY], 0], [-body[at.IXZ], 0, body[at.IZZ]]]
    )
    inertia = turn @ inertia @ turn.T
    for a, i in ((4, 0), (5, 1), (2, 2)):
        for b, j in ((4, 0), (5, 1), (2, 2)):
            mass[a, b] = inertia[i, j]
    for i in range(4):
        mass += wheels[i, at.UNSPRUNG] * hubs[i].T @ hubs[i]
    # forward, left and yaw from the seven
    tie = held if feet_held else mass[:3]
    follow = np.vstack([-np.linalg.solve(tie[:, :3], tie[:, 3:]), np.eye(7)])
    stiffness, damping = np.zeros((7, 7)), np.zeros((7, 7))
    rates = spring_rates(rest.coordinates[3:], body, wheels)
    for i in range(4):
        sink = (feet[i] @ follow)[2]
        stiffness += wheels[i, at.TIRE] * np.outer(sink, sink)
        damping += body[at.TIRE_DAMPING] * np.outer(sink, sink)
        stiffness[3 + i, 3 + i] += rates[i] + wheels[i, at.BAR]
        stiffness[3 + i, 3 + (i ^ 1)] -= wheels[i, at.BAR]
        damping[3 + i, 3 + i] += 0.5 * (wheels[i, at.COMPRESSION] + wheels[i, at.EXTENSION])
    return follow.T @ mass @ follow, damping, stiffness


def modes(mass: FloatArray, stiffness: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Undamped natural frequencies (7,) in Hz, rising, and shapes (7, 7) by column."""
    values, shapes = np.linalg.eig(np.linalg.solve(mass, stiffness))
    order = np.argsort(values.real)
    return np.sqrt(np.maximum(values.real[order], 0)) / (2 * np.pi), shapes.real[:, order]


def roll_frequency_hz(vehicle: PlantVehicle, rest: Posture | None = None) -> float:
    """Undamped frequency of the body's roll on springs and tyres, about its axis, without gravity's part."""
    mass, _, stiffness = small_motion(vehicle, rest)
    frequency, shapes = modes(mass, stiffness)
    energy = mass[1, 1] * shapes[1] ** 2 / np.einsum("ik,ij,jk->k", shapes, mass, shapes)
    bodily = np.argsort(frequency)[:3]
    return float(frequency[bodily[np.argmax(energy[bodily])]])
