"""From the plant's states to the columns of a PlantRun."""

from __future__ import annotations

import numpy as np

from parsers.signals import WHEELS
from pipelines.results import FloatArray
from pipelines.simulation.plant import layout as at
from pipelines.simulation.records import GRAVITY, RUN_COLUMNS

_STATES = {
    "distance_m": at.DISTANCE,
    "x_m": at.X,
    "y_m": at.Y,
    "altitude_m": at.ALTITUDE,
    "heading_rad": at.HEADING,
    "roll_against_road_rad": at.ROLL,
    "pitch_against_road_rad": at.PITCH,
    "roll_rate_radps": at.P,
    "pitch_rate_radps": at.Q,
    "yaw_rate_radps": at.R,
    "brake_pressure_pa": at.PRESSURE,
}
_EXTRAS = {
    "velocity_x_mps": at.CG_VX,
    "velocity_y_mps": at.CG_VY,
    "roll_acceleration_radps2": at.ALPHA_X,
    "pitch_acceleration_radps2": at.ALPHA_Y,
    "yaw_acceleration_radps2": at.ALPHA_Z,
    "accel_x_mps2": at.FORCE_X,
    "accel_y_mps2": at.FORCE_Y,
    "accel_z_mps2": at.FORCE_Z,
    "steering_wheel_angle_rad": at.WHEEL_ANGLE,
    "road_grade_rad": at.GRADE,
    "road_bank_rad": at.BANK,
}
_WHEEL_STATES = {
    "wheel_spin_{}_radps": at.SPIN,
    "suspension_deflection_{}_m": at.DEFLECTION,
    "suspension_velocity_{}_mps": at.DEFLECTION_RATE,
}
_WHEEL_EXTRAS = {
    "suspension_force_{}_n": at.W_FORCE,
    "tire_normal_force_{}_n": at.W_NORMAL,
    "tire_longitudinal_force_{}_n": at.W_LONG,
    "tire_lateral_force_{}_n": at.W_LAT,
    "accel_z_sprung_{}_mps2": at.W_SPRUNG,
    "accel_z_unsprung_{}_mps2": at.W_UNSPRUNG,
    "brake_torque_{}_nm": at.W_BRAKE,
    "drive_torque_{}_nm": at.W_DRIVE,
    "road_{}_m": at.W_ROAD,
}


def columns(
    states: FloatArray, extras: FloatArray, body: FloatArray, wheels: FloatArray, rest_height_m: float
) -> dict[str, FloatArray]:
    """Every name of RUN_COLUMNS -> (n,). states (n, STATES), extras (n, AUX_SIZE); rest_height_m: the sprung CG's."""
    found = {name: states[:, index].copy() for name, index in _STATES.items()}
    found |= {name: extras[:, index].copy() for name, index in _EXTRAS.items()}
    for i, wheel in enumerate(WHEELS):
        found |= {name.format(wheel): states[:, k + i].copy() for name, k in _WHEEL_STATES.items()}
        found |= {name.format(wheel): extras[:, k + i].copy() for name, k in _WHEEL_EXTRAS.items()}
        found[f"wheel_steer_{wheel}_rad"] = np.arctan(extras[:, at.W_STEER + i])
    found["speed_mps"] = np.hypot(found["velocity_x_mps"], found["velocity_y_mps"])
    found["heave_m"] = states[:, at.HEIGHT] - rest_height_m
    turn = turns(states)
    up = np.einsum("nij,ni->nj", turn, extras[:, at.UP_X : at.UP_Z + 1])
    found["pitch_rad"] = -np.arcsin(np.clip(up[:, 0], -1, 1))
    found["roll_rad"] = np.arctan2(up[:, 1], up[:, 2])
    found["energy_j"] = energy(states, extras, body, wheels)
    return {name: found[name] for name in RUN_COLUMNS}


def turns(states: FloatArray) -> FloatArray:
    """(n, 3, 3) from body to road axes."""
    sr, cr = np.sin(states[:, at.ROLL]), np.cos(states[:, at.ROLL])
    sp, cp = np.sin(states[:, at.PITCH]), np.cos(states[:, at.PITCH])
    zero = np.zeros(len(states))
    rows = [[cp, sp * sr, sp * cr], [zero, cr, -sr], [-sp, cp * sr, cp * cr]]
    return np.moveaxis(np.array(rows), -1, 0)


def energy(states: FloatArray, extras: FloatArray, body: FloatArray, wheels: FloatArray) -> FloatArray:
    """(n,) kinetic and potential energy, J: masses, spin, gravity, springs, stops, bars, tyres (standing deflection too)."""
    turn = turns(states)
    rates = states[:, at.P : at.R + 1]
    moved = np.einsum("nji,nj->ni", turn, states[:, at.VX : at.VZ + 1])
    up = np.einsum("nij,ni->nj", turn, extras[:, at.UP_X : at.UP_Z + 1])
    center = states[:, at.ALTITUDE] + states[:, at.HEIGHT] * extras[:, at.UP_Z]
    mass = body[at.MASS]
    inertia = np.diag([body[at.IXX], body[at.IYY], body[at.IZZ]])
    inertia[0, 2] = inertia[2, 0] = -body[at.IXZ]
    total = 0.5 * mass * (moved**2).sum(axis=1) + mass * GRAVITY * center
    total += 0.5 * np.einsum("ni,ij,nj->n", rates, inertia, rates)
    for i in range(4):
        d, v = states[:, at.DEFLECTION + i], states[:, at.DEFLECTION_RATE + i]
        bent = d[:, None] * [wheels[i, at.SIDE_CURVE], wheels[i, at.PATH_CURVE], 0.0]
        path = np.array([wheels[i, at.HUB_PATH_X], wheels[i, at.HUB_PATH_Y], 1.0]) + bent
        place = wheels[i, at.HUB_X : at.HUB_Z + 1] + d[:, None] * (path - bent / 2)
        speed = moved + np.cross(rates, place) + v[:, None] * path
        total += wheels[i, at.UNSPRUNG] * (
            0.5 * (speed**2).sum(axis=1) + GRAVITY * (center + (place * up).sum(axis=1))
        )
        total += 0.5 * wheels[i, at.WHEEL_INERTIA] * states[:, at.SPIN + i] ** 2
        total += wheels[i, at.PRELOAD] * d + wheels[i, at.SPRING] * (
            d**2 / 2 + body[at.STIFFENING] * d**4 / 4
        )
        beyond = np.maximum(d - body[at.BUMP_AT], 0) + np.minimum(d + body[at.REBOUND_AT], 0)
        total += 0.5 * body[at.BUMP_RATE] * beyond**2
        # each bar is met by both of its wheels
        total += 0.25 * wheels[i, at.BAR] * (d - states[:, at.DEFLECTION + (i ^ 1)]) ** 2
        foot = wheels[i, at.FOOT_X : at.FOOT_Z + 1]
        foot_path = np.array([wheels[i, at.FOOT_PATH_X], wheels[i, at.FOOT_PATH_Y], 1.0]) + bent / 2
        below = foot + d[:, None] * foot_path - place
        low = np.einsum("ni,ni->n", turn[:, 2, :], place)
        # the body's roll alone leans what is below the hub
        low += -turn[:, 1, 2] * below[:, 1] + turn[:, 1, 1] * below[:, 2]
        squash = np.maximum(extras[:, at.W_ROAD + i] - states[:, at.HEIGHT] - low, 0)
        total += 0.5 * wheels[i, at.TIRE] * squash**2
    return np.asarray(total)
