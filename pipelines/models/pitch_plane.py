"""The pitch plane: the pitch balance (103)-(104) of the gPC dissertation with signs set right.

Axes ISO 8855, pitch + nose down; the dissertation has nose up here and nose down in (73). Forces of the struts on the
body, + up; lengths m.
"""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray


def pitch_acceleration(corner_accels: FloatArray, wheelbase_m: float) -> FloatArray:
    """(104) with its missing half and pitch + nose down: (n,) rad/s².

    corner_accels: (n, 4) vertical accelerations of the body over fl, fr, rl, rr. Exact for a rigid body, small angles.
    """
    fl, fr, rl, rr = corner_accels.T
    return np.asarray((rl + rr - fl - fr) / (2 * wheelbase_m))


def strut_pitch_moment(forces: FloatArray, wheelbase_m: float) -> FloatArray:
    """Pitch moment of the struts about the middle of the wheelbase, (n,) N m, + nose down. forces: (n, 4)."""
    fl, fr, rl, rr = forces.T
    return np.asarray(0.5 * wheelbase_m * (rl + rr - fl - fr))


def pitch_moment_needed(
    pitch_accel: FloatArray,
    accel_x: FloatArray,
    accel_z: FloatArray,
    inertia: float,
    mass_arm: float,
    mass_behind: float,
) -> FloatArray:
    """(103) with signs set right, solved for the struts' pitch moment about the middle of the wheelbase, (n,) N m.

        L/2 (F_r - F_f) = J pitch'' + m h_p f_x + m d f_z

    Braking (f_x < 0) asks for more force in front. In body axes pitch and grade need no term of their own: f_x holds
    them. inertia: J of the sprung mass about its CG. mass_arm: m h_p, CG above the pitch axis. mass_behind: m d, d how
    far the CG lies behind the middle of the wheelbase (a - L/2). accel_x, accel_z: specific force at the sprung CG, m/s².
    """
    return np.asarray(inertia * pitch_accel + mass_arm * accel_x + mass_behind * accel_z)
