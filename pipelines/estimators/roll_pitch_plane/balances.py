"""The three balances of a drive as least squares: what the struts carry, their roll moment, their pitch moment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.estimators.roll_pitch_plane.data import Planes
from pipelines.estimators.roll_pitch_plane.fit import Column, LinearFit, fit
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray

FRICTION_SHARE = 0.015
JACK_STD = 0.04
JACK_SIDE_STD = 0.01
LATE_STD_S = 0.012
PRODUCT_SHARE = 0.1
CURVE_AT, CURVE_SHARE = 5.0, 0.08
DRAG_LEVER = (0.35, 0.35)
ASKEW_STD = 0.02
USUAL_ARM_M = 0.6
PIVOT_M, SWING_RADPS = (0.2, 0.2), 8.0
GYRATION = 1.2
ACCEL_NOISE = 0.05
ACCEL_HZ = 100.0
"""Before the log. FRICTION_SHARE: dry friction that a force sensor may miss, of a corner's load. JACK: what the links
carry of the vertical force, kg a kg of braking or driving, and a m/s² of lateral acceleration. LATE: delay between
sensors. PRODUCT: product of inertia, of m 1 m². CURVE: by how much load transfer may bend by 5 m/s². DRAG_LEVER: moment of
drag and lift about the struts' middle, N m a (m/s)². ASKEW: how far the inertial unit is turned, rad. USUAL_ARM_M: of load
transfer, give or take as much. PIVOT: height about which the body nods over its wheels, m: round ones stay under their hubs, feet that
are points of the body at the road. SWING: of a body on its springs. GYRATION: yaw less roll inertia, m² a kg. ACCEL_NOISE: of an accelerometer, m/s² a sample
at ACCEL_HZ."""


@dataclass(frozen=True)
class Wheels:
    """What is taken off the roll moment before the fit: spin (inertia of all wheels over their radius, kg m) times the share
    `gyroscope` of its gyroscopic moment; feet, N m a rad of lean: the wheels' feet move sideways under a leaning body."""

    spin: float
    gyroscope: float
    feet: float = 0.0


def _friction(planes: Planes, name: str) -> tuple[Column, ...]:
    if name not in planes.columns:
        return ()
    corner = float(np.mean(planes.loads))
    return (Column("friction", planes.columns[name], 0.0, FRICTION_SHARE * max(corner, 1.0)),)


def carried(planes: Planes) -> LinearFit | None:
    """Sum of the struts' forces = m_s f_z + what the links take while braking, driving and cornering."""
    c = planes.columns
    mass = float(planes.loads.sum()) / GRAVITY
    columns = (
        Column("mass", c["fz"]),
        Column("jack_brake", np.where(planes.braking, c["fx"], 0.0), 0.0, JACK_STD * mass),
        Column("jack_drive", np.where(planes.braking, 0.0, c["fx"]), 0.0, JACK_STD * mass),
        Column("jack_side", c["fy"] ** 2, 0.0, JACK_SIDE_STD * mass),
        *_friction(planes, "total_friction"),
    )
    return fit(c["total"], columns, planes.block)


def _bent(values: FloatArray, moment: float) -> Column:
    """Load transfer that grows with the acceleration: body and wheels move sideways, axes move with the body."""
    return Column("curve", values * np.abs(values), 0.0, CURVE_SHARE * moment / CURVE_AT)


def usual_size(values: FloatArray) -> float:
    """Size of an acceleration (n,) at which a straight line through nought fits load transfer that bends: 0 without rows."""
    power = float(np.sum(values**2))
    return float(np.sum(np.abs(values) ** 3)) / power if power > 0 else 0.0


def _accel_noise(planes: Planes) -> float:
    """Variance that a usual accelerometer's noise leaves below the cutoff."""
    return ACCEL_NOISE**2 * min(1.0, planes.rate_hz / 2 / ACCEL_HZ)


def _rates(planes: Planes, response: str, names: tuple[str, ...], usual: float) -> list[Column]:
    """Response and inputs may come at different delays: M(t + tau) = M + tau M'."""
    found = []
    for name in names:
        jumps = np.flatnonzero(np.diff(planes.time_s) > 1.5 / planes.rate_hz)
        rate = np.gradient(planes.columns[name]) * planes.rate_hz
        rate[np.concatenate((jumps, jumps + 1)).astype(np.int64)] = 0.0
        size = 1.0 if name == response else usual
        found.append(Column(f"late_{name}", rate, 0.0, LATE_STD_S * size))
    return found


def rolling(planes: Planes, mass: float, wheels: Wheels) -> LinearFit | None:
    """(101): the struts' roll moment from roll acceleration and specific forces; coefficients roll_acc, fy, fz …"""
    c = planes.columns
    known = -wheels.gyroscope * wheels.spin * c["vyaw"]
    if "lean" in c:
        known = known + wheels.feet * c["lean"]
    usual = USUAL_ARM_M * mass
    columns = [
        Column("roll_acc", c["roll_acc"], 0.4 * mass, mass, planes.noise["roll_acc"]),
        Column("fy", c["fy"], -usual, usual, _accel_noise(planes)),
        Column("fz", c["fz"]),
        Column("fx", c["fx"], 0.0, ASKEW_STD * usual),
        _bent(c["fy"], usual),
        *_rates(planes, "roll_moment", ("roll_moment", "fy"), usual),
        *_friction(planes, "roll_friction"),
    ]
    if "yaw_acc" not in planes.missing:
        columns.append(Column("yaw_acc", c["yaw_acc"], 0.0, PRODUCT_SHARE * mass + 0.5 * usual))
    return fit(c["roll_moment"] - known, tuple(columns), planes.block)


def pitching(planes: Planes, mass: float) -> LinearFit | None:
    """(103): the struts' pitch moment from pitch acceleration and specific forces; braking and driving apart."""
    c = planes.columns
    usual = USUAL_ARM_M * mass
    columns = [
        Column("pitch_acc", c["pitch_acc"], 1.5 * mass, 3 * mass, planes.noise["pitch_acc"]),
        Column("fx_brake", np.where(planes.braking, c["fx"], 0.0), usual, usual),
        Column("fx_drive", np.where(planes.braking, 0.0, c["fx"]), usual, usual),
        Column("fz", c["fz"]),
        Column("fy", c["fy"], 0.0, ASKEW_STD * usual),
        _bent(c["fx"], usual),
        *_rates(planes, "pitch_moment", ("pitch_moment", "fx"), usual),
        *_friction(planes, "pitch_friction"),
    ]
    # a body that rolls and yaws at once pitches: (I_xx - I_zz) p r, and I_xz r² with the sensor's place ahead of the CG
    for name, mean, std in (
        ("roll_yaw", -GYRATION * mass, 0.5 * GYRATION * mass),
        ("yaw_square", 0.0, usual),
    ):
        if name in c:
            columns.append(Column(name, c[name], mean, std))
    if "v2" not in planes.missing:
        columns.append(Column("v2", c["v2"], *DRAG_LEVER))
    # f_x holds the weight of a nodding body as if its feet went with it: those of round wheels stay behind
    nod = PIVOT_M[0] * GRAVITY * mass * c["nod"] if "nod" in c else 0.0
    return fit(c["pitch_moment"] - nod, tuple(columns), planes.block)


def pivot_doubt(planes: Planes, mass: float) -> float:
    """kg m² by which the pitch inertia is unsure, as nobody says about which height the body nods over its wheels."""
    acc = planes.columns["pitch_acc"]
    power = float(acc @ acc)
    if "nod" not in planes.columns or power <= 0:
        # a body that swings on its springs
        return PIVOT_M[1] * GRAVITY * mass / SWING_RADPS**2
    nod = planes.columns["nod"]
    return PIVOT_M[1] * GRAVITY * mass * abs(float((nod - nod.mean()) @ acc)) / power
