"""Tyre normal force of a corner from its suspension: (146)-(150) of the dissertation on gPC estimation, Chapter 9.

    F = m_u (g + a_u) + S + H_y m a_y + H_x m a_x                                    (146)

S: suspension force, m_u, a_u: the unsprung mass and its vertical acceleration, m: the whole vehicle's mass. What the links
carry past the springs, below the roll and pitch centres, is the load transfer H_y m a_y + H_x m a_x:

    H_y = -/+ (share of the axle) h_rc / B  eta_1     (147)   left -, right +
    H_x = -/+ (share of the side) h_pc / L  eta_2     (148)   front -, rear +

with A_y > 0 to the left and A_x > 0 forward (ISO 8855): the print has all signs +, which opposes its own (106) unless A_x and
A_y are turned. A turn to the left unloads the left side, braking (A_x < 0) loads the front. The factors

    eta_1 = (1 - sign(A_y x) x)^2 (1 - sign(A_y (D_rl - D_rr)) (D_rl - D_rr) / B)^2    (149)
    eta_2 = (1 - sign(A_y x) x)^2                                                       (150)

are printed with x = (h_s + mean D) / h_s, which would make eta about zero for a small deflection; only
x = (mean deviation of D) / h_s, the part by which the ride height h_s has changed, makes sense, and is used here.
"""

from __future__ import annotations

import numpy as np

from parsers.jit import kernel
from pipelines.results import FloatArray

GRAVITY = 9.80665

LEFT = {"fl": True, "fr": False, "rl": True, "rr": False}
FRONT = {"fl": True, "fr": True, "rl": False, "rr": False}
ACROSS = {"fl": "fr", "fr": "fl", "rl": "rr", "rr": "rl"}
"""The other wheel of the axle."""
BEHIND = {"fl": "rl", "fr": "rr", "rl": "fl", "rr": "fr"}
"""The other wheel of the side."""


def eta_lateral(accel_y: FloatArray, heave: FloatArray, lean: FloatArray) -> FloatArray:
    """(149). heave: x, mean deviation of the deflections over h_s; lean: (D_rl - D_rr) / B; all (n,), no unit."""
    turned = 1.0 - np.sign(accel_y * lean) * lean
    return np.asarray(eta_longitudinal(accel_y, heave) * turned**2)


def eta_longitudinal(accel_y: FloatArray, heave: FloatArray) -> FloatArray:
    """(150), with A_y as printed. heave: x as in `eta_lateral`; (n,)."""
    return np.asarray((1.0 - np.sign(accel_y * heave) * heave) ** 2)


def lateral_height(wheel: str, axle_share: float, height_m: float, track_m: float) -> float:
    """(147) without eta: H_y, + where a left turn loads the wheel. axle_share: of the mass, on the wheel's axle (b/L at the front)."""
    return (-1.0 if LEFT[wheel] else 1.0) * axle_share * height_m / track_m


def longitudinal_height(wheel: str, side_share: float, height_m: float, wheelbase_m: float) -> float:
    """(148) without eta: H_x, + where accelerating loads the wheel. side_share: of the mass, on the wheel's side (r/B at the left)."""
    return (-1.0 if FRONT[wheel] else 1.0) * side_share * height_m / wheelbase_m


def ground_force(
    suspension_force: FloatArray,
    unsprung_kg: float,
    unsprung_accel: FloatArray,
    lateral: FloatArray,
    longitudinal: FloatArray,
) -> FloatArray:
    """(146). suspension_force N; unsprung_accel m/s², 0 at rest; lateral, longitudinal: H m a with eta, N; all (n,)."""
    return np.asarray(suspension_force + unsprung_kg * (GRAVITY + unsprung_accel) + lateral + longitudinal)


@kernel
def _dahl(deflection: FloatArray, starts: FloatArray, travel: float, out: FloatArray) -> None:
    state = 0.0
    for k in range(deflection.shape[0]):
        if starts[k] > 0.5:
            state = 0.0
        else:
            move = deflection[k] - deflection[k - 1]
            # exact for a move in one direction: the state goes to the side it moves to, a travel at a time
            side = 1.0 if move > 0.0 else -1.0
            state = side + (state - side) * np.exp(-abs(move) / travel)
        out[k] = state


def dry_friction(deflection: FloatArray, starts: FloatArray, travel_m: float) -> FloatArray:
    """Dahl's dry friction from -1 (extending) to +1 (compressing), the smoothed sign of the deflection's velocity; (n,).

    It turns over while the deflection moves by `travel_m`, so that noise at rest does not turn it. deflection (n,) m;
    starts (n,): 1 where a stretch begins, from which on nothing is known and the state is 0.
    """
    out = np.empty(len(deflection))
    _dahl(np.ascontiguousarray(deflection), starts, travel_m, out)
    return out
