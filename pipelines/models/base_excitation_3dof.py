"""Heave, pitch and roll of the body over four hubs whose vertical accelerations are known: the dissertation, (86)-(100).

Worked out again, ISO 8855 (theta > 0 nose down, phi > 0 left side up), x_i forward and y_i left of the sprung CG:

    m_s z'' = sum F_i,    J_p theta'' = -sum x_i F_i,    J_r phi'' = sum y_i F_i,
    F_i = -k_i e_i - d_i(e_i') - bars,    e_i = z - x_i theta + y_i phi - (hub i's height), + extension

with all accelerations against the ground: in coordinates relative to the hubs each line has its own inertia force, so that (89)
needs -m_s z_u'' (printed without the mass), and the second (97) is (98), for F_rr. Four hub heights are a plane under the CG,
(86)-(88), and a warp w that (86)-(88) leave out: e_i holds -x_i y_i w besides. A rigid body cannot follow the warp; its forces cancel only
where k_f a = k_r b. No spring holds the warp, so that its integral drifts: it is taken above a tenth of a hertz, or left out as published.

Beyond the dissertation: dampers with a slope for either direction, anti-roll bars, dry friction, tracks that differ. All may be 0 or equal.
Because only accelerations are known, masses and inertias come in proportion to springs, dampers and bars (5.1.2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.jit import kernel, lean_kernel
from pipelines.models.base_excitation import between_samples
from pipelines.results import FloatArray

COLUMNS: tuple[str, ...] = (
    "sprung_mass_kg", "sprung_pitch_inertia_kgm2", "sprung_roll_inertia_kgm2", "sprung_cg_behind_front_axle_m",
    "sprung_cg_left_m", "spring_rate_front_npm", "spring_rate_rear_npm", "damper_extension_front_nspm",
    "damper_compression_front_nspm", "damper_extension_rear_nspm", "damper_compression_rear_nspm",
    "anti_roll_stiffness_front_nmprad", "anti_roll_stiffness_rear_nmprad", "friction_n",
)  # fmt: skip
"""What a row of the model's table holds: rates, slopes and friction are those of one wheel."""

STICK_MPS = 0.01
"""Speed over which friction changes its sign."""

WARP_HZ = 0.1
Three = tuple[float, float, float]


@dataclass(frozen=True)
class Geometry:
    """What is exactly known of the vehicle, in m."""

    wheelbase_m: float
    track_front_m: float
    track_rear_m: float


@lean_kernel
def _force(spring: float, extension: float, compression: float, friction: float, e: float, v: float) -> float:
    """A suspension's push on the body at extension e and its rate v, without the bar."""
    push = -spring * e - (extension if v > 0.0 else compression) * v
    if friction > 0.0:
        push -= friction * v / np.sqrt(v * v + STICK_MPS * STICK_MPS)
    return push


@lean_kernel
def _axle(
    spring: float, extension: float, compression: float, bar: float, friction: float,
    x: float, left: float, right: float, s: FloatArray, e_w: float, v_w: float,
) -> Three:  # fmt: skip
    """Sum of an axle's two forces, sum of x F, sum of y F. s: z, theta, phi and their rates; e_w, v_w: warp over x."""
    e, v = s[0] - x * s[1], s[3] - x * s[4]
    e_l, v_l = e + left * (s[2] - e_w), v + left * (s[5] - v_w)
    e_r, v_r = e + right * (s[2] - e_w), v + right * (s[5] - v_w)
    track = left - right
    of_bar = bar * (e_l - e_r) / (track * track)
    f_l = _force(spring, extension, compression, friction, e_l, v_l) - of_bar
    f_r = _force(spring, extension, compression, friction, e_r, v_r) + of_bar
    return f_l + f_r, x * (f_l + f_r), left * f_l + right * f_r


@lean_kernel
def _body(p: FloatArray, sides: FloatArray, length: float, s: FloatArray, w: float, w_rate: float) -> Three:
    """The body's accelerations against the ground: z'', theta'', phi''. sides: y of fl, fr, rl, rr."""
    ahead, behind = p[3], p[3] - length
    f = _axle(
        p[5], p[7], p[8], p[11], p[13], ahead, sides[0], sides[1], s, ahead * w, ahead * w_rate
    )  # fmt: skip
    r = _axle(
        p[6], p[9], p[10], p[12], p[13], behind, sides[2], sides[3], s, behind * w, behind * w_rate
    )  # fmt: skip
    return (f[0] + r[0]) / p[0], -(f[1] + r[1]) / p[1], (f[2] + r[2]) / p[2]


@lean_kernel
def _plane(u: FloatArray, row: int, p: FloatArray, length: float) -> Three:
    """The hubs' plane under the CG, (86)-(88). u (n, 4): middle of the front and of the rear axle, slope across each."""
    share = p[3] / length
    front, rear = u[row, 0] + p[4] * u[row, 2], u[row, 1] + p[4] * u[row, 3]
    return (
        (1.0 - share) * front + share * rear,
        (rear - front) / length,
        (1.0 - share) * u[row, 2] + share * u[row, 3],
    )


@kernel
def _respond(
    table: FloatArray, tracks: FloatArray, length: float, u: FloatArray, middle: FloatArray, warp: FloatArray,
    warp_middle: FloatArray, step: float, out: FloatArray,
) -> None:  # fmt: skip
    """Runge-Kutta of order 4, one step a sample, every row of `table` (q, 14) from rest; out (q, n, 4): corners' z''.

    warp, warp_middle (n, 2): the hubs' warp and its rate at the samples and half-way between them.
    """
    state, mid, total = np.zeros(6), np.zeros(6), np.zeros(6)
    sides = np.zeros(4)
    n = u.shape[0]
    for q in range(table.shape[0]):
        p = table[q]
        for i in range(4):
            sides[i] = (0.5 if i % 2 == 0 else -0.5) * tracks[i // 2] - p[4]
        state[:] = 0.0
        for k in range(n):
            for stage in range(4):
                share = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
                if stage == 0:
                    mid[:] = state
                    hub, w, rate = _plane(u, k, p, length), warp[k, 0], warp[k, 1]
                elif stage == 3:
                    hub, w, rate = _plane(u, k + 1, p, length), warp[k + 1, 0], warp[k + 1, 1]
                else:
                    hub, w, rate = _plane(middle, k, p, length), warp_middle[k, 0], warp_middle[k, 1]
                a = _body(p, sides, length, mid, w, rate)
                if stage == 0:
                    for i in range(4):
                        x = p[3] if i < 2 else p[3] - length
                        out[q, k, i] = a[0] - x * a[1] + sides[i] * a[2]
                    if k + 1 == n:
                        break
                weight = step / 6.0 * (1.0 if share == 0.0 or share == 1.0 else 2.0)
                ahead = step * (0.5 if stage < 2 else 1.0)
                for i in range(3):
                    pace, grow = mid[3 + i], a[i] - hub[i]
                    total[i] = (0.0 if stage == 0 else total[i]) + weight * pace
                    total[3 + i] = (0.0 if stage == 0 else total[3 + i]) + weight * grow
                    mid[i] = state[i] + ahead * pace
                    mid[3 + i] = state[3 + i] + ahead * grow
            if k + 1 < n:
                for i in range(6):
                    state[i] += total[i]


def hub_columns(hubs: FloatArray, geometry: Geometry) -> FloatArray:
    """(n, 4) from the hubs' fl, fr, rl, rr (n, 4): middle of the front and of the rear axle, slope across each."""
    fl, fr, rl, rr = hubs.T
    return np.ascontiguousarray(
        np.column_stack(
            (
                (fl + fr) / 2,
                (rl + rr) / 2,
                (fl - fr) / geometry.track_front_m,
                (rl - rr) / geometry.track_rear_m,
            )
        )
    )


def warp_of(u: FloatArray, length_m: float, step_s: float) -> FloatArray:
    """The hubs' warp and its rate (n, 2) above WARP_HZ, from `hub_columns` of their accelerations."""
    n = len(u)
    acceleration = (u[:, 2] - u[:, 3]) / length_m
    f = np.fft.rfftfreq(n, step_s)
    s = 2j * np.pi * np.where(f > 0, f, 1.0)
    spectrum = np.fft.rfft(acceleration) * f**4 / (f**4 + WARP_HZ**4)
    return np.ascontiguousarray(
        np.column_stack((np.fft.irfft(spectrum / s**2, n), np.fft.irfft(spectrum / s, n)))
    )


def corner_response(
    table: FloatArray, hubs: FloatArray, geometry: Geometry, step_s: float, *, warp: bool = True
) -> FloatArray:
    """Vertical accelerations (Q, n, 4) in m/s² of the body over the wheels fl, fr, rl, rr, from rest.

    table: (Q, 14), columns as in COLUMNS. hubs: (n, 4) m/s², no gravity. warp: False leaves it out as (86)-(88) do.
    Raises ValueError for fewer than 4 samples, another width, or a mass, inertia or track that is not above 0.
    """
    if hubs.ndim != 2 or hubs.shape[1] != 4 or len(hubs) < 4:
        raise ValueError("at least four samples of four hubs are needed")
    if table.ndim != 2 or table.shape[1] != len(COLUMNS):
        raise ValueError(f"a row of the table has {len(COLUMNS)} figures")
    tracks = np.array([geometry.track_front_m, geometry.track_rear_m])
    if not (np.all(table[:, :3] > 0) and np.all(tracks > 0) and geometry.wheelbase_m > 0 and step_s > 0):
        raise ValueError("masses, inertias, wheelbase, tracks and the step must be above 0")
    u = hub_columns(np.asarray(hubs, dtype=np.float64), geometry)
    twist = warp_of(u, geometry.wheelbase_m, step_s) if warp else np.zeros((len(u), 2))
    out = np.empty((len(table), len(u), 4))
    _respond(
        np.ascontiguousarray(table, dtype=np.float64), tracks, geometry.wheelbase_m, u, _middle(u), twist, _middle(twist),
        step_s, out,
    )  # fmt: skip
    return out


def _middle(columns: FloatArray) -> FloatArray:
    return np.ascontiguousarray(np.column_stack([between_samples(c) for c in columns.T]))
