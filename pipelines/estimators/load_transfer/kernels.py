"""The gPC-EKF in regression form on strut forces, compiled (dissertation 3.6-3.7 with (118)-(140)).

At each sample, for parameters p with coefficients x (d, S):

    x[i, 1 + i] += c[i]                          the spread that (51), (58) add, so that the filter goes on learning
    P = x A'                                     parameters at the collocation points (50)
    Y = forces at these points,  y = Y inv(A)'   coefficients of the predicted outputs
    gpc_update(x, y, z, R)                       (37)-(40); predicted outputs are not updated (70)

Symbols: a, b, l, r, h_r, h_p, C as in pipelines.models.load_transfer. All outputs are fl, fr, rl, rr (and their sum).
"""

from __future__ import annotations

import numpy as np

from parsers.jit import kernel
from pipelines.filters.gpc_points import at_points, expand_row
from pipelines.filters.gpc_update import gpc_update_with
from pipelines.results import FloatArray

LTM, MLTM, HFLTM = 0, 1, 2

AZ, Z, ACROSS, ALONG, SPEED2, ROLLING, PITCHING, LEVEL_Y, LEVEL_X = 0, 4, 5, 6, 7, 8, 9, 10, 11
INPUTS = 12
"""Columns of the inputs: A_z over the four struts, z'' of the middle, A_y + phi and A_x + theta in g, V², roll and pitch
(nose down) acceleration, and A_y and A_x in g, of which the gate judges."""


@kernel
def _ltm(p: FloatArray, u: FloatArray, size: tuple[float, float], out: FloatArray) -> None:
    """(106)-(110). p: m, a, l, h_r, h_p, C, each (Q,)."""
    length, track = size
    for q in range(p.shape[1]):
        weight = p[0, q] * u[Z]
        front, left = 1.0 - p[1, q] / length, 1.0 - p[2, q] / track
        rear, right = 1.0 - front, 1.0 - left
        across = weight * u[ACROSS] * p[3, q] / track
        along = (weight * u[ALONG] + p[5, q] * u[SPEED2]) * p[4, q] / length
        out[0, q] = weight * front * left - front * across - left * along
        out[1, q] = weight * front * right + front * across - right * along
        out[2, q] = weight * rear * left - rear * across + left * along
        out[3, q] = weight * rear * right + rear * across + right * along
        if out.shape[0] > 4:
            out[4, q] = weight


@kernel
def _mltm(p: FloatArray, u: FloatArray, heave: float, size: tuple[float, float], out: FloatArray) -> None:
    """(128)-(132). p: the corner masses, h_r, h_p, C, each (Q,)."""
    length, track = size
    for q in range(p.shape[1]):
        fl, fr, rl, rr = p[0, q], p[1, q], p[2, q], p[3, q]
        total = fl + fr + rl + rr
        across = heave * u[ACROSS] * p[4, q] / track
        along = (heave * u[ALONG] + p[6, q] * u[SPEED2] / total) * p[5, q] / length
        out[0, q] = fl * u[0] - (fl + fr) * across - (fl + rl) * along
        out[1, q] = fr * u[1] + (fl + fr) * across - (fr + rr) * along
        out[2, q] = rl * u[2] - (rl + rr) * across + (fl + rl) * along
        out[3, q] = rr * u[3] + (rl + rr) * across + (fr + rr) * along
        if out.shape[0] > 4:
            out[4, q] = fl * u[0] + fr * u[1] + rl * u[2] + rr * u[3]


@kernel
def _hfltm(p: FloatArray, u: FloatArray, heave: float, size: tuple[float, float], out: FloatArray) -> None:
    """(137)-(140). p: the corner masses, h_rfl, h_rfr, h_rr, h_pf, h_pr, each (Q,)."""
    across, along = heave * u[LEVEL_Y] / size[1], heave * u[LEVEL_X] / size[0]
    for q in range(p.shape[1]):
        fl, fr, rl, rr = p[0, q], p[1, q], p[2, q], p[3, q]
        out[0, q] = fl * u[0] - (fl + fr) * across * p[4, q] - (fl + rl) * along * p[7, q]
        out[1, q] = fr * u[1] + (fl + fr) * across * p[5, q] - (fr + rr) * along * p[7, q]
        out[2, q] = rl * u[2] - (rl + rr) * across * p[6, q] + (fl + rl) * along * p[8, q]
        out[3, q] = rr * u[3] + (rl + rr) * across * p[6, q] + (fr + rr) * along * p[8, q]


@kernel
def _heave(x: FloatArray, u: FloatArray) -> float:
    """z'' of (117) with the CG where the mean masses put it."""
    fl, fr, rl, rr = x[0, 0], x[1, 0], x[2, 0], x[3, 0]
    total = max(fl + fr + rl + rr, 1.0)
    # (r - l) / 2 times roll'' and (a - b) / 2 times pitch'' nose down; ROLLING, PITCHING hold them times B and L
    side, end = (fl + rl - fr - rr) / total, (rl + rr - fl - fr) / total
    heave: float = u[Z] + 0.5 * side * u[ROLLING] + 0.5 * end * u[PITCHING]
    return heave


@kernel
def _held(u: FloatArray, gate: FloatArray) -> int:
    """0: free. 1: held, below the least |A_y| or |A_x|. 2: held and taken as known, above the largest |A_y|. gate (3,), in g."""
    across, along = abs(u[LEVEL_Y]), abs(u[LEVEL_X])
    if across > gate[2]:
        return 2
    return 1 if across < gate[0] or along < gate[1] else 0


@kernel
def _widen(x: FloatArray, u: FloatArray, gates: FloatArray, added: FloatArray, held: FloatArray) -> None:
    """Add the spread that time adds, (51), (58), and keep what is held."""
    for i in range(x.shape[0]):
        hold = _held(u, gates[i])
        if hold > 0:
            held[i] = x[i]
        x[i, 1 + i] += added[i]
        if hold == 2:
            # the others must not learn from it what it is not allowed to
            x[i, 1:] = 0.0


@kernel
def _write(x: FloatArray, row: int, track: FloatArray, spread: FloatArray) -> None:
    """Means and standard deviations of all parameters, into one row."""
    for i in range(x.shape[0]):
        track[row, i] = x[i, 0]
        total = 0.0
        for s in range(1, x.shape[1]):
            total += x[i, s] * x[i, s]
        spread[row, i] = np.sqrt(total)


@kernel
def run(
    model: int,
    inputs: FloatArray,
    measured: FloatArray,
    size: tuple[float, float],
    x: FloatArray,
    added: FloatArray,
    noise: FloatArray,
    matrix: FloatArray,
    inverse: FloatArray,
    form: int,
    gates: FloatArray,
    every: int,
    track: FloatArray,
    spread: FloatArray,
    predicted: FloatArray,
) -> None:
    """Filter a drive. x (d, S) in place.

    inputs (n, INPUTS), measured (n, m); size: L and B. added (d,): c; noise (m,): R. matrix (S, Q): terms at the points,
    inverse (Q, S): its pseudo-inverse turned. gates (d, 3): `_held`, in g.
    track, spread (n // every, d): means and standard deviations after every `every`-th sample. predicted (n, m): outputs
    before each update.
    """
    d, terms = x.shape
    points, m = matrix.shape[1], measured.shape[1]
    p, values, y = np.empty((d, points)), np.empty((m, points)), np.empty((m, terms))
    held = np.empty((d, terms))
    work, none = np.empty((m, m + 4)), np.empty((0, 0))
    row, left = 0, every
    for k in range(measured.shape[0]):
        u = inputs[k]
        _widen(x, u, gates, added, held)
        at_points(x, matrix, p)
        if model == LTM:
            _ltm(p, u, size, values)
        elif model == MLTM:
            _mltm(p, u, _heave(x, u), size, values)
        else:
            _hfltm(p, u, _heave(x, u), size, values)
        for j in range(m):
            expand_row(values, j, inverse, y, j)
            predicted[k, j] = y[j, 0]
        gpc_update_with(x, y, measured[k], noise, form, none, none, work)
        for i in range(d):
            if _held(u, gates[i]) > 0:
                x[i] = held[i]
        left -= 1
        if left == 0:
            _write(x, row, track, spread)
            row += 1
            left = every
