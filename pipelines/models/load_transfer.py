"""Suspension forces by load transfer: the LTM, MLTM and HFLTM of the gPC dissertation, signs corrected, whole arrays.

    LTM    (106)-(110)  one mass at the CG, one roll and one pitch arm
    MLTM   (117)-(132)  a mass over each wheel, with that corner's own vertical acceleration
    HFLTM  (137)-(140)  as MLTM with three roll and two pitch arms; drag and angles are left to the quick arms

Derived again from a rigid body on four vertical struts: a lateral specific force A_y (left +) at h_r above the roll axis
takes m A_z A_y h_r / B from the left wheels, shared by the axles as the mass is; a longitudinal one takes
m A_z A_x h_p / L from the front wheels, shared by the sides as the mass is; a body leaning by phi moves its CG by h_r phi.
The dissertation's phi is right side down as ours, its theta is nose UP and ours nose DOWN, its A_x and A_y are in g and
those of the road plane: an accelerometer in the leaning body reads A_y + phi already, so that its reading goes with
angles of 0, or level accelerations (`level`) with the angles. C is rho C_d A / 2, in N per (m/s)^2.

Symbols: m mass, a, b CG to front and rear axle, l, r CG to left and right track, L wheelbase, B track, h_r, h_p arms.
All forces are (n, 4): fl, fr, rl, rr. Struts carry the SPRUNG mass.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray


@dataclass(frozen=True)
class Size:
    """Wheelbase and track, m."""

    wheelbase: float
    track: float


@dataclass(frozen=True)
class Motion:
    """What loads the struts, all (n,) or one figure, SI, ISO 8855.

    accel_x, accel_y: in the road plane, m/s². vertical: specific force at the CG, m/s² (9.81 at rest). roll, pitch: of
    the body against the road, rad (+ right side down, + nose down). speed: m/s.
    """

    accel_x: FloatArray
    accel_y: FloatArray
    vertical: FloatArray
    roll: FloatArray
    pitch: FloatArray
    speed: FloatArray

    @property
    def along(self) -> FloatArray:
        """A_x + theta with theta nose up, in g: what shifts load to the rear."""
        return np.asarray(self.accel_x / GRAVITY - self.pitch)

    @property
    def across(self) -> FloatArray:
        """A_y + phi in g: what shifts load to the right."""
        return np.asarray(self.accel_y / GRAVITY + self.roll)


def level(
    accel_x: FloatArray, accel_y: FloatArray, vertical: FloatArray, roll: FloatArray, pitch: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Longitudinal and lateral specific force in the road plane from those read in the leaning body, (n,) m/s²."""
    along = accel_x * np.cos(pitch) + vertical * np.sin(pitch)
    across = accel_y * np.cos(roll) - vertical * np.sin(roll)
    return np.asarray(along), np.asarray(across)


def _spread(front: FloatArray, left: FloatArray, across: FloatArray, along: FloatArray) -> FloatArray:
    """(n, 4) transfers: `across` N from left to right shared by the axles, `along` N from front to rear by the sides."""
    rear, right = 1 - front, 1 - left
    return np.stack(
        np.broadcast_arrays(
            -front * across - left * along,
            front * across - right * along,
            -rear * across + left * along,
            rear * across + right * along,
        ),
        axis=-1,
    )


def ltm_forces(
    motion: Motion, size: Size, mass: float, behind: float, left: float, roll_arm: float, pitch_arm: float, drag: float
) -> FloatArray:  # fmt: skip
    """(106)-(109): strut forces, N. behind: a, left: l, both m; drag: C in N per (m/s)^2."""
    front_share = np.asarray(1 - behind / size.wheelbase)
    left_share = np.asarray(1 - left / size.track)
    weight = mass * np.asarray(motion.vertical)
    across = weight * motion.across * roll_arm / size.track
    along = (weight * motion.along + drag * motion.speed**2) * pitch_arm / size.wheelbase
    standing = _static(front_share, left_share) * weight[..., None]
    return np.asarray(standing + _spread(front_share, left_share, across, along))


def _static(front: FloatArray, left: FloatArray) -> FloatArray:
    """(4,) shares of a lumped mass over the wheels."""
    return np.array(
        [front * left, front * (1 - left), (1 - front) * left, (1 - front) * (1 - left)], dtype=np.float64
    )


def position(masses: FloatArray, size: Size) -> tuple[float, float, float]:
    """(124), (125): mass, a and l from the corner masses (4,)."""
    fl, fr, rl, rr = (float(m) for m in masses)
    total = fl + fr + rl + rr
    return total, (rl + rr) / total * size.wheelbase, (fr + rr) / total * size.track


def rotation(corners: FloatArray, size: Size) -> tuple[FloatArray, FloatArray]:
    """(102), (104) with their missing 1/2: roll (right side down) and pitch (nose DOWN) acceleration, (n,) rad/s²."""
    fl, fr, rl, rr = (corners[..., i] for i in range(4))
    return (fl + rl - fr - rr) / (2 * size.track), (rl + rr - fl - fr) / (2 * size.wheelbase)


def vertical_at_cg(corners: FloatArray, masses: FloatArray, size: Size) -> FloatArray:
    """(117): vertical specific force at the CG from those over the struts (n, 4), for a rigid body."""
    _, behind, left = position(masses, size)
    roll, pitch = rotation(corners, size)
    right, ahead = size.track - left, size.wheelbase - behind
    mean = corners.mean(axis=-1)
    return np.asarray(mean + 0.5 * (right - left) * roll - 0.5 * (ahead - behind) * pitch)


def corners_from_imu(
    accel_z: FloatArray, roll_acceleration: FloatArray, pitch_acceleration: FloatArray,
    place: tuple[float, float], size: Size,
) -> FloatArray:  # fmt: skip
    """Vertical specific force over the struts (n, 4) from one unit at `place` (m behind the front axle, left of the middle)."""
    columns = []
    for behind, left in ((0.0, 0.5), (0.0, -0.5), (1.0, 0.5), (1.0, -0.5)):
        arm_y, arm_x = left * size.track - place[1], behind * size.wheelbase - place[0]
        columns.append(accel_z + arm_y * roll_acceleration + arm_x * pitch_acceleration)
    return np.stack(columns, axis=-1)


def mltm_forces(
    motion: Motion, corners: FloatArray, size: Size, masses: FloatArray, roll_arm: float, pitch_arm: float, drag: float
) -> FloatArray:  # fmt: skip
    """(128)-(131): strut forces, N. corners: (n, 4) vertical specific force over each strut; masses (4,) kg.

    motion.vertical is z'' of (117).
    """
    total = float(masses.sum())
    front, left = np.asarray((masses[0] + masses[1]) / total), np.asarray((masses[0] + masses[2]) / total)
    weight = total * np.asarray(motion.vertical)
    across = weight * motion.across * roll_arm / size.track
    along = (weight * motion.along + drag * motion.speed**2) * pitch_arm / size.wheelbase
    return np.asarray(masses * corners + _spread(front, left, across, along))


def hfltm_forces(
    motion: Motion, corners: FloatArray, size: Size, masses: FloatArray, arms: FloatArray
) -> FloatArray:
    """(137)-(140): strut forces, N. arms: (5,) roll fl, fr, rear, pitch front, rear; the motion's angles are not used."""
    fl, fr, rl, rr = masses
    across = np.asarray(motion.vertical * motion.accel_y / (GRAVITY * size.track))
    along = np.asarray(motion.vertical * motion.accel_x / (GRAVITY * size.wheelbase))
    moved = np.stack(
        (
            -(fl + fr) * across * arms[0] - (fl + rl) * along * arms[3],
            (fl + fr) * across * arms[1] - (fr + rr) * along * arms[3],
            -(rl + rr) * across * arms[2] + (fl + rl) * along * arms[4],
            (rl + rr) * across * arms[2] + (fr + rr) * along * arms[4],
        ),
        axis=-1,
    )
    return np.asarray(masses * corners + moved)


def bounce(masses: FloatArray, corners: FloatArray) -> FloatArray:
    """(122), (132): sum of the strut forces, (n,) N."""
    return np.asarray(corners @ masses)
