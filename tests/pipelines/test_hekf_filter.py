"""The HEKF-EKF kernels: against plain Python, against the Kalman filter on a linear case, and against differences."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipelines.filters.hekf import HekfSettings, hekf_ekf, huber_random_walk, load_noise_process
from pipelines.filters.kalman import innovations
from pipelines.models.axle_load import acceleration_from_load, acceleration_jacobian, axle_loads
from pipelines.results import FloatArray

G = 9.80665
M, L, H, A, RF = 5762.0, 5.0, 1.03, 1.5, 0.004
DT = 0.02


def drive(seconds: float = 25.0, seed: int = 0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Noisy speed, noisy rear load, grade."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds / DT)) * DT
    acceleration = 1.6 * np.sin(0.7 * t)
    grade = 0.05 * np.sin(0.3 * t)
    speed = 10 + np.concatenate(([0.0], np.cumsum(acceleration[:-1]) * DT))
    load = axle_loads(M, L, A, H, acceleration, grade, RF)[1]
    noise = rng.standard_normal((2, len(t)))
    return speed + 0.1 * noise[0], load + 100 * noise[1], grade


def settings(**changes: object) -> HekfSettings:
    base: dict[str, object] = {
        "start": (10.0, 0.8, 1.3),
        "start_variance": (0.01, 0.1, 0.1),
        "process": (load_noise_process(L, DT, 100.0, M, 0.8), 0.0, 0.0),
        "speed_variance": 0.01,
    }
    return HekfSettings(**(base | changes))  # type: ignore[arg-type]


def slow(y: FloatArray, F: FloatArray, theta: FloatArray, s: HekfSettings) -> FloatArray:
    """Equations (5)-(18) with matrices, row by row: weighted height, a, and both heights."""
    x, P = np.array(s.start), np.diag(s.start_variance)
    z, S = np.array(s.start[:2]), np.diag(s.start_variance[:2])
    Q, R = np.diag(s.process), s.speed_variance
    out = []
    for k in range(len(y)):
        if k:
            before = (F[k - 1 : k], theta[k - 1 : k], M, L, RF)
            a = x[2]
            dv, dh, da = (float(part[0]) for part in acceleration_jacobian(*before, x[1], a))
            Fk = np.array([[1, DT * dh, DT * da], [0, 1, 0], [0, 0, 1]])
            x = x + np.array([DT * dv, 0, 0])
            P = Fk @ P @ Fk.T + Q
            dv, dh, _ = (float(part[0]) for part in acceleration_jacobian(*before, z[1], a))
            Gk = np.array([[1, DT * dh], [0, 1]])
            z = z + np.array([DT * dv, 0])
            S = Gk @ S @ Gk.T + Q[:2, :2]
        e = y[k] - x[0]
        psi = min(1.0, s.huber / max(abs(e) / math.sqrt(R), 1e-300))
        K = P[:, 0] / (P[0, 0] + R / psi)
        x, P = x + K * e, P - np.outer(K, P[0])
        C = S[:, 0] / (S[0, 0] + R)
        z, S = z + C * (y[k] - z[0]), S - np.outer(C, S[0])
        both = s.weight * x[1] + (1 - s.weight) * z[1]
        out.append((both, x[2], x[1], z[1]))
        if s.feedback:
            x[1] = z[1] = both
    return np.array(out)


@pytest.mark.parametrize("changes", [{}, {"huber": math.inf}, {"weight": 0.5, "feedback": False}])
def test_the_kernel_equals_the_equations_with_matrices(changes: dict[str, object]) -> None:
    y, F, theta = drive(5.0)
    y[100] += 3.0
    s = settings(**changes)
    track = hekf_ekf(y, F, theta, DT, M, L, RF, s)
    expected = slow(y, F, theta, s)
    found = np.column_stack((track.height, track.axle, track.height_first, track.height_second))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-10)


def test_jacobian_equals_finite_differences() -> None:
    _, F, theta = drive(5.0)
    _, by_height, by_axle = acceleration_jacobian(F, theta, M, L, RF, H, A)
    step = 1e-6
    for derivative, (dh, da) in ((by_height, (step, 0.0)), (by_axle, (0.0, step))):
        up = acceleration_from_load(F, theta, M, L, RF, H + dh, A + da)
        down = acceleration_from_load(F, theta, M, L, RF, H - dh, A - da)
        np.testing.assert_allclose((up - down) / (2 * step), derivative, rtol=1e-6, atol=1e-7)


def test_axle_loads_carry_the_weight_and_invert() -> None:
    _, _, theta = drive(5.0)
    acceleration = np.linspace(-3, 2, len(theta))
    front, rear = axle_loads(M, L, A, H, acceleration, theta, RF)
    np.testing.assert_allclose(front + rear, M * G * np.cos(theta), rtol=1e-12)
    np.testing.assert_allclose(acceleration_from_load(rear, theta, M, L, RF, H, A), acceleration, atol=1e-10)


def test_with_the_height_known_it_is_the_kalman_filter() -> None:
    """With h exactly known the model is linear in (v, a): the shipped Kalman filter must say the same."""
    y, F, _ = drive(10.0)
    theta = np.zeros(len(y))
    s = settings(start=(10.0, H, 1.3), start_variance=(0.01, 0.0, 0.1), huber=math.inf, weight=1.0)
    track = hekf_ekf(y, F, theta, DT, M, L, RF, s)
    phi = np.array([[1.0, -DT * G / H], [0.0, 1.0]])
    push = np.column_stack((DT * (F * L / (M * H) - G * RF / H), np.zeros(len(y))))
    error, _ = innovations(
        y[:, None], push, np.zeros((len(y), 1)), (np.array([0]), np.array([len(y)])), phi=phi,
        q=np.diag([s.process[0], 0.0]), c=np.array([[1.0, 0.0]]), r=np.array([s.speed_variance]),
        x0=np.array([[10.0, 1.3]]), p0=np.diag([0.01, 0.1]),
    )  # fmt: skip
    np.testing.assert_allclose(track.innovation[1:], error[1:, 0], atol=2e-5)


def test_scalar_filter_against_plain_python_and_its_limits() -> None:
    rng = np.random.default_rng(3)
    y = 15 + rng.laplace(0, 3, 400)
    for gamma in (1.345, math.inf):
        x, p, expected = 14.0, 2.0, []
        for value in y:
            p += 0.3
            e = value - x
            psi = min(1.0, gamma / (abs(e) / math.sqrt(9.0)))
            k = p / (p + 9.0 / psi)
            x, p = x + k * e, p - k * p
            expected.append(x)
        found = huber_random_walk(y, 0.3, 9.0, gamma, 14.0, 2.0)
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_recovers_what_was_planted_and_huber_shrugs_at_outliers() -> None:
    y, F, theta = drive(60.0)
    clean = hekf_ekf(y, F, theta, DT, M, L, RF, settings())
    assert abs(clean.height[-1] / H - 1) < 0.02
    assert abs(clean.axle[-1] / A - 1) < 0.01
    rng = np.random.default_rng(1)
    wild = y + np.where(rng.random(len(y)) < 0.1, 5.0, 0.0)
    errors = [
        abs(hekf_ekf(wild, F, theta, DT, M, L, RF, settings(huber=gamma, weight=1.0)).speed - y).mean()
        for gamma in (1.345, math.inf)
    ]
    assert errors[0] < 0.6 * errors[1]


def test_a_gap_restarts_the_speed_and_keeps_the_constants() -> None:
    y, F, theta = drive(40.0)
    starts = np.zeros(len(y))
    starts[1000] = 1.0
    y[1000:] += 7.0
    track = hekf_ekf(y, F, theta, DT, M, L, RF, settings(), starts)
    assert math.isnan(track.innovation[1000])
    assert abs(track.height[1001] - track.height[999]) < 0.05
    assert abs(track.height[-1] / H - 1) < 0.03


def test_wrong_inputs_are_refused() -> None:
    y, F, theta = drive(5.0)
    with pytest.raises(ValueError, match="same"):
        hekf_ekf(y[:-1], F, theta, DT, M, L, RF, settings())
    with pytest.raises(ValueError, match="positive"):
        hekf_ekf(y, F, theta, DT, M, L, RF, settings(speed_variance=0.0))
