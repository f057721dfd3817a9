"""Drives and bookkeeping for the tests of the full plant: demands, free motion, momentum from the raw states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.columns import columns, energy, turns
from pipelines.simulation.plant.run import Setup, prepare, run_from, standing
from pipelines.simulation.plant.vehicle import PlantVehicle
from pipelines.simulation.records import GRAVITY, Air, Demand, straight_road

STEP_S = 0.01


def demand(
    duration_s: float,
    *,
    speed: float | FloatArray = 0.0,
    steer: float | FloatArray = 0.0,
    brake: float | FloatArray = 0.0,
    torque: float | FloatArray = 0.0,
) -> Demand:
    """A demand at 100 Hz from constants or arrays."""
    rows = round(duration_s / STEP_S) + 1

    def full(value: float | FloatArray) -> FloatArray:
        return np.broadcast_to(np.asarray(value, dtype=np.float64), (rows,)).copy()

    return Demand(STEP_S, full(steer), full(speed), full(brake), full(torque))


def clock(duration_s: float) -> FloatArray:
    """Times of `demand`'s rows."""
    return np.arange(round(duration_s / STEP_S) + 1) * STEP_S


def sine_with_dwell(amplitude_rad: float, speed: float, duration_s: float = 6.0) -> Demand:
    """0.7 Hz with a dwell of 500 ms at the second peak, from 1 s on; the speed control lets go at 0.5 s."""
    t = clock(duration_s) - 1.0
    quarter, end = 0.75 / 0.7, 1 / 0.7 + 0.5
    wave = np.where((t >= 0) & (t < quarter), np.sin(1.4 * np.pi * t), 0.0)
    wave -= np.where((t >= quarter) & (t < quarter + 0.5), 1.0, 0.0)
    wave += np.where((t >= quarter + 0.5) & (t < end), np.sin(1.4 * np.pi * (t - 0.5)), 0.0)
    target = np.where(t < -0.5, speed, np.nan)
    return demand(duration_s, steer=amplitude_rad * wave, speed=target)


def without_losses(vehicle: PlantVehicle) -> PlantVehicle:
    """No damper, no friction, no drag: what is left must keep its energy."""
    names = (
        "damper_compression_front_nspm", "damper_extension_front_nspm", "damper_compression_rear_nspm",
        "damper_extension_rear_nspm", "friction_n", "tire_damping_nspm",
        "drag_area_m2", "rolling_resistance",
    )  # fmt: skip
    return replace(vehicle, **dict.fromkeys(names, 0.0))


@dataclass(frozen=True)
class Motion:
    """A run from a state of the test's choice."""

    setup: Setup
    states: FloatArray
    extras: FloatArray

    @property
    def energy(self) -> FloatArray:
        """(n,) J."""
        return energy(self.states, self.extras, self.setup.body, self.setup.wheels)

    @property
    def columns(self) -> Mapping[str, FloatArray]:
        """As in a PlantRun."""
        rest = float(self.setup.rest.coordinates[0])
        return columns(self.states, self.extras, self.setup.body, self.setup.wheels, rest)


def free_motion(
    vehicle: PlantVehicle,
    offsets: Mapping[int, float],
    *,
    friction: float = 0.0,
    duration_s: float = 3.0,
    step_s: float = 0.001,
    rate_hz: float = 100.0,
    drive: Demand | None = None,
    air: Air | None = None,
) -> Motion:
    """From rest plus offsets (by state index) on a flat road, both feet off unless `drive` says more."""
    if drive is None:
        drive = demand(duration_s, speed=np.nan)
    setup = prepare(vehicle, drive, straight_road(400, friction), air)
    rows = round(duration_s * rate_hz) + 1
    return Motion(setup, *run_from(setup, standing(setup, offsets), rows, rate_hz, step_s))


def momentum(motion: Motion) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Linear and angular momentum (about the world's origin), and the force and moment of road, gravity and drag on it.

    All (n, 3), world axes, on a flat road without rolling resistance; from raw states, written apart from the plant.
    """
    y, extras, body, wheels = motion.states, motion.extras, motion.setup.body, motion.setup.wheels
    turn = turns(y)
    c, s = np.cos(y[:, at.HEADING]), np.sin(y[:, at.HEADING])
    zero, one = np.zeros(len(y)), np.ones(len(y))
    world = np.moveaxis(np.array([[c, -s, zero], [s, c, zero], [zero, zero, one]]), -1, 0)
    turn = world @ turn

    def out(vector: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("nij,nj->ni", turn, vector))

    center = np.column_stack([y[:, at.X], y[:, at.Y], y[:, at.HEIGHT]])
    speed = np.einsum("nij,nj->ni", world, y[:, at.VX : at.VZ + 1])
    rates = y[:, at.P : at.R + 1]
    inertia = np.array(
        [[body[at.IXX], 0, -body[at.IXZ]], [0, body[at.IYY], 0], [-body[at.IXZ], 0, body[at.IZZ]]]
    )
    mass = body[at.MASS]
    linear = mass * speed
    angular = mass * np.cross(center, speed) + out(rates @ inertia)
    weight = np.array([0.0, 0.0, -GRAVITY])
    through = speed - [body[at.WIND_X], body[at.WIND_Y], 0.0]
    drag = -body[at.DRAG] * np.linalg.norm(through[:, :2], axis=1)[:, None] * through * [1, 1, 0]
    force = mass * weight + drag
    moment = np.cross(center, force)
    for i in range(4):
        d, v = y[:, at.DEFLECTION + i, None], y[:, at.DEFLECTION_RATE + i, None]
        row = wheels[i]
        bent = d * [row[at.SIDE_CURVE], row[at.PATH_CURVE], 0.0]
        hub_path = np.array([row[at.HUB_PATH_X], row[at.HUB_PATH_Y], 1.0]) + bent
        foot_path = np.array([row[at.FOOT_PATH_X], row[at.FOOT_PATH_Y], 1.0]) + bent
        place = row[at.HUB_X : at.HUB_Z + 1] + d * (hub_path - bent / 2)
        hub = center + out(place)
        moving = speed + out(np.cross(rates, place) + v * hub_path)
        unsprung = row[at.UNSPRUNG]
        linear = linear + unsprung * moving
        axle = out(np.broadcast_to([0.0, 1.0, 0.0], (len(y), 3)))
        spin = row[at.WHEEL_INERTIA] * y[:, at.SPIN + i]
        angular = angular + unsprung * np.cross(hub, moving) + spin[:, None] * axle
        below = row[at.FOOT_X : at.FOOT_Z + 1] + d * (foot_path - bent / 2) - place
        sin_roll, cos_roll = np.sin(y[:, at.ROLL]), np.cos(y[:, at.ROLL])
        leaning = np.column_stack(
            [
                zero,
                cos_roll * below[:, 1] - sin_roll * below[:, 2],
                sin_roll * below[:, 1] + cos_roll * below[:, 2],
            ]
        )
        foot = hub + np.einsum("nij,nj->ni", world, leaning)
        squash = np.maximum(-foot[:, 2], 0.0)
        foot[:, 2] += squash
        steer, long, lat = (extras[:, k + i] for k in (at.W_STEER, at.W_LONG, at.W_LAT))
        steer = np.arctan(steer)
        given = body[at.PATCH_GIVE] * y[:, at.U_Y + i]
        aside = np.column_stack([-given * np.sin(steer), given * np.cos(steer), 0 * given])
        foot = foot + np.einsum("nij,nj->ni", world, aside)
        local = np.column_stack(
            [
                long * np.cos(steer) - lat * np.sin(steer),
                long * np.sin(steer) + lat * np.cos(steer),
                extras[:, at.W_NORMAL + i],
            ]
        )
        road = np.einsum("nij,nj->ni", world, local)
        force = force + road + unsprung * weight
        moment = moment + np.cross(foot, road) + np.cross(hub, unsprung * weight)
    return linear, angular, force, moment
