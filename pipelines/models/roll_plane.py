"""The roll plane: the simple model (71)-(73) of the gPC dissertation, and the roll balance (101)-(102) with signs set right.

Axes ISO 8855, roll + right side down, pitch + nose down; forces of the struts on the body, + up; lengths m.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.models.power_products import PowerProducts
from pipelines.results import FloatArray

SIMPLE = PowerProducts(
    ("mass_kg", "pitch_inertia_kgm2", "roll_inertia_kgm2", "cg_height_m"),
    np.array([[-1, 0, 0, 0], [0, 0, -1, 0], [0, -1, 0, 0], [1, 0, -1, 1], [1, -1, 0, 1]]),
)
"""Coefficients (85), in order: 1/m, 1/J_r, 1/J_p, m h / J_r, m h / J_p. J_r is the roll inertia, J_p the pitch inertia: the
text and (75) swap the names J_theta and J_phi. The height is that above the axis about which the struts' forces turn
the body: the roll and the pitch axis."""


BOTH_PLANES = PowerProducts(
    (
        "sprung_mass_kg", "pitch_inertia_kgm2", "roll_inertia_kgm2", "roll_arm_m", "pitch_arm_m", "cg_lateral_offset_m",
        "cg_behind_middle_m",
    ),
    np.array(
        [
            [-1, 0, 0, 0, 0, 0, 0],
            [0, 0, -1, 0, 0, 0, 0],
            [0, -1, 0, 0, 0, 0, 0],
            [1, 0, -1, 1, 0, 0, 0],
            [1, -1, 0, 0, 1, 0, 0],
            [1, 0, -1, 0, 0, 1, 0],
            [1, -1, 0, 0, 0, 0, 1],
        ]
    ),
)  # fmt: skip
"""(101) and (103) beside the vertical balance, with the CG's place as parameters: 1/m, 1/J_r, 1/J_p, m h_r / J_r, m h_p / J_p,
m l / J_r, m d / J_p; d: how far the CG lies behind the middle of the wheelbase."""


@dataclass(frozen=True)
class Plane:
    """Distances of the wheels from the CG: left, right (l, r), front axle, rear axle (a, b), m."""

    left: float
    right: float
    front: float
    rear: float


def strut_moments(forces: FloatArray, plane: Plane) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sum (n,) [N], roll moment and pitch moment about the CG (n,) [N m] of strut forces (n, 4): fl, fr, rl, rr.

    The right sides of (71)-(73) without the accelerations.
    """
    fl, fr, rl, rr = forces.T
    total = fl + fr + rl + rr
    roll = plane.left * (fl + rl) - plane.right * (fr + rr)
    pitch = -plane.front * (fl + fr) + plane.rear * (rl + rr)
    return np.asarray(total), np.asarray(roll), np.asarray(pitch)


def simple_regressors(
    forces: FloatArray, accel_x: FloatArray, accel_y: FloatArray, plane: Plane
) -> FloatArray:
    """(84), corrected: phi (n, 3, 5) for the outputs z'', roll'', pitch'' and the coefficients of `SIMPLE`.

    Printed, the roll moment stands beside A_x and the pitch moment beside A_y: errors above 1000 %. In (73) A_x is + when
    it turns the nose down, which is minus the specific force: give accel_x as -f_x.
    """
    total, roll, pitch = strut_moments(forces, plane)
    phi = np.zeros((len(total), 3, 5))
    phi[:, 0, 0] = total
    phi[:, 1, 1], phi[:, 1, 3] = roll, accel_y
    phi[:, 2, 2], phi[:, 2, 4] = pitch, accel_x
    return phi


def both_planes_regressors(
    total: FloatArray,
    moments: tuple[FloatArray, FloatArray],
    accels: tuple[FloatArray, FloatArray, FloatArray],
) -> FloatArray:
    """phi (n, 3, 7) of `BOTH_PLANES` for the outputs f_z, roll'', pitch''.

    total: sum of the struts' forces; moments: roll and pitch about the middle; accels: specific forces f_x, f_y, f_z.
    """
    roll, pitch = moments
    fx, fy, fz = accels
    phi = np.zeros((len(total), 3, 7))
    phi[:, 0, 0] = total
    phi[:, 1, 1], phi[:, 1, 3], phi[:, 1, 5] = roll, fy, -fz
    phi[:, 2, 2], phi[:, 2, 4], phi[:, 2, 6] = pitch, -fx, -fz
    return phi


def roll_acceleration(corner_accels: FloatArray, track_m: tuple[float, float]) -> FloatArray:
    """(102) with its missing half and signs for roll + right side down: (n,) rad/s².

    corner_accels: (n, 4) vertical accelerations of the body over fl, fr, rl, rr. track_m: front, rear. Their mean is
    the printed formula where both tracks are B. Exact for a rigid body and small angles.
    """
    front = (corner_accels[:, 0] - corner_accels[:, 1]) / track_m[0]
    rear = (corner_accels[:, 2] - corner_accels[:, 3]) / track_m[1]
    return np.asarray(0.5 * (front + rear))


def strut_roll_moment(forces: FloatArray, track_m: tuple[float, float]) -> FloatArray:
    """Roll moment of the struts about the vehicle's middle, (n,) N m: sum of y_i F_i. forces: (n, 4)."""
    left = np.array([track_m[0], -track_m[0], track_m[1], -track_m[1]]) / 2
    return np.asarray(forces @ left)


def roll_moment_needed(
    roll_accel: FloatArray,
    accel_y: FloatArray,
    accel_z: FloatArray,
    inertia: float,
    mass_arm: float,
    mass_left: float,
) -> FloatArray:
    """(101) with signs set right, solved for the struts' roll moment about the middle, (n,) N m.

        sum y_i F_i = J roll'' - m h_r f_y + m l f_z

    In body axes: roll and bank then need no term of their own (f_y holds g sin roll; the printed phi h_r m A_z is that
    part, for an A_y that is level), and the static term is + (CG left of the middle: the left struts carry more).
    inertia: J of the sprung mass about its CG. mass_arm: m h_r, CG above the roll axis. mass_left: m l, CG left of the
    middle. accel_y, accel_z: specific force at the sprung CG, m/s².
    """
    return np.asarray(inertia * roll_accel - mass_arm * accel_y + mass_left * accel_z)
