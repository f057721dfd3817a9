"""The kernels of Park & Choi's observer: against plain Python, against batch least squares, and on known motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.filters.bilinear_rls import bilinear_rls
from pipelines.filters.linear_response import linear_response
from pipelines.filters.roll_adaptation import AdaptationGains, adapt_roll, gamma_of
from pipelines.models.roll import GRAVITY, RollCoefficients, discretise

DEGREES = 180 / np.pi
GAINS = AdaptationGains(1008.0, 1950 * DEGREES, 245 * DEGREES, 0.08572)
MASS, ARM = 1755.0, 0.637 - 0.08572


def slow_rls(y, terms, active, start, covariance, forgetting):
    """Equations (17)-(20) with matrices, symmetric P, no variance above its start."""
    theta, p = np.array(start, dtype=float), np.diag(covariance).astype(float)
    eta = np.array(forgetting)
    history = []
    for k in range(len(y)):
        if active[k]:
            a, b, c = terms[k]
            f = np.array([a + c * theta[1], b + c * theta[0]])
            predicted = a * theta[0] + b * theta[1] + c * theta[0] * theta[1]
            total = f @ p @ f
            gain = np.linalg.inv(np.diag(eta) + total * np.eye(2)) @ p @ f
            theta = theta + gain * (y[k] - predicted)
            p = np.diag(1 / eta) @ (np.eye(2) - np.outer(gain, f)) @ p
            p = 0.5 * (p + p.T)
            scale = np.minimum(1.0, np.sqrt(np.array(covariance) / np.diag(p)))
            p = p * np.outer(scale, scale)
        history.append(theta.copy())
    return np.array(history)


@pytest.mark.parametrize("forgetting", [(0.995, 0.999), (1.0, 1.0), (0.98, 0.98)])
def test_the_compiled_rls_equals_plain_python(forgetting):
    rng = np.random.default_rng(3)
    terms = rng.standard_normal((400, 3))
    truth = (0.7, -1.3)
    y = terms @ np.array([*truth, truth[0] * truth[1]]) + 0.05 * rng.standard_normal(400)
    active = rng.random(400) > 0.2
    ours, spread = bilinear_rls(
        y, terms, active, start=(0.5, -1.0), covariance=(0.5, 2.0), forgetting=forgetting
    )
    plain = slow_rls(y, terms, active, (0.5, -1.0), (0.5, 2.0), forgetting)
    np.testing.assert_allclose(ours, plain, rtol=1e-9, atol=1e-12)
    assert (spread > 0).all()
    assert (spread <= np.array([0.5, 2.0]) * (1 + 1e-12)).all()


def test_with_equal_forgetting_a_linear_problem_ends_at_weighted_least_squares():
    rng = np.random.default_rng(4)
    eta, rows = 0.99, 300
    terms = np.column_stack([rng.standard_normal((rows, 2)), np.zeros(rows)])
    y = terms[:, :2] @ np.array([2.0, -0.4]) + 0.1 * rng.standard_normal(rows)
    ours, _ = bilinear_rls(
        y,
        terms,
        np.ones(rows, bool),
        start=(0.0, 0.0),
        covariance=(1e6, 1e6),
        forgetting=(eta, eta),
        limited=False,
    )
    weight = eta ** np.arange(rows - 1, -1, -1)
    x = terms[:, :2]
    batch = np.linalg.solve((x * weight[:, None]).T @ x, (x * weight[:, None]).T @ y)
    np.testing.assert_allclose(ours[-1], batch, rtol=1e-4)


def test_an_unexcited_parameter_stays_where_it_is_in_spite_of_forgetting():
    rng = np.random.default_rng(5)
    rows = 20_000
    terms = np.zeros((rows, 3))
    terms[:, 0] = 1e-4 * rng.standard_normal(rows)
    terms[:, 1] = rng.standard_normal(rows)
    y = 1.5 * terms[:, 1] + 0.1 * rng.standard_normal(rows)
    theta, _ = bilinear_rls(
        y, terms, np.ones(rows, bool), start=(0.0, 0.0), covariance=(1.0, 1.0), forgetting=(0.995, 0.999)
    )
    assert abs(theta[-1, 0]) < 0.1
    assert theta[-1, 1] == pytest.approx(1.5, abs=0.02)


def test_wrong_shapes_and_factors_are_refused():
    y, terms, active = np.zeros(5), np.zeros((5, 3)), np.ones(5, bool)
    with pytest.raises(ValueError, match="fit together"):
        bilinear_rls(y, terms[:4], active, start=(0, 0), covariance=(1, 1), forgetting=(1, 1))
    with pytest.raises(ValueError, match="forgetting"):
        bilinear_rls(y, terms, active, start=(0, 0), covariance=(1, 1), forgetting=(1.1, 1))


def test_gamma_is_that_of_equation_29():
    assert gamma_of(1008.0, 1950 * DEGREES, 245 * DEGREES, 12_000.0) == pytest.approx(20.397, abs=1e-3)
    with pytest.raises(ValueError, match="real solution"):
        gamma_of(1008.0, 1950 * DEGREES, 245 * DEGREES, 0.0)


def roll_motion(seconds: float, frequency_hz: float, offset: float = 0.0):
    """Lateral acceleration, roll rate and turning of a body that rolls by (21), without noise."""
    rate = 100.0
    t = np.arange(round(seconds * rate)) / rate
    f = 4.0 * np.sin(2 * np.pi * frequency_hz * t) * np.minimum(1.0, t / 3)
    moment = MASS * ARM
    roll = RollCoefficients(
        GAINS.stiffness_nmprad / moment, GAINS.damping_nmsprad / moment, GAINS.inertia_kgm2 / moment
    )
    phi, before, after = discretise(roll, 1 / rate)
    state = linear_response(f, phi, before, after, 1 / roll.a, (np.array([0]), np.array([len(f)])))
    return f, state[:, 1] + offset, f - GRAVITY * state[:, 0], state[:, 0]


def run(f, rate, turning, *, mass=MASS, gains=GAINS, braking=None, long=None, reset=True, start=0.08572):
    rows = len(f)
    nobody = np.zeros(rows, bool)
    return adapt_roll(
        f, rate, turning, np.full(rows, mass), np.full(rows, 0.637) if long is None else long,
        nobody if braking is None else braking, ~nobody, (np.array([0]), np.array([rows])), gains,
        rate_hz=100.0, height_m=start, reset=reset,
    )  # fmt: skip


def test_the_adaptation_converges_to_the_height_without_noise():
    f, rate, turning, roll = roll_motion(120.0, 0.3)
    found = run(f, rate, turning)
    assert found.height[-1] == pytest.approx(0.637, abs=0.004)
    assert np.abs(found.roll - roll)[-500:].max() < 0.002
    # it starts at the roll centre, and comes nearer all the time
    checks = found.height[[500, 2000, 5000, 11_000]]
    assert (np.diff(np.abs(checks - 0.637)) < 0).all()


def test_the_adaptation_settles_where_mass_times_arm_is_right():
    f, rate, turning, _ = roll_motion(120.0, 0.3)
    found = run(f, rate, turning, mass=1610.0)
    assert found.height[-1] - 0.08572 == pytest.approx(ARM * MASS / 1610.0, abs=0.005)


def steps_of_cornering(offset: float):
    """Ten seconds to the left, ten to the right, with steady roll between, and a gyro that is off."""
    t = np.arange(12_000) / 100.0
    f = np.interp(t % 40, [0, 2, 10, 14, 30, 34, 40], [0, 4, 4, -4, -4, 0, 0])
    moment = MASS * ARM
    roll = RollCoefficients(GAINS.stiffness_nmprad / moment, GAINS.damping_nmsprad / moment, 1008.0 / moment)
    phi, before, after = discretise(roll, 0.01)
    state = linear_response(f, phi, before, after, 1 / roll.a, (np.array([0]), np.array([len(f)])))
    return f, state[:, 1] + offset, f - GRAVITY * state[:, 0]


def test_drift_prevention_removes_a_gyro_offset():
    f, rate, turning = steps_of_cornering(0.004)
    with_it = run(f, rate, turning)
    without = run(f, rate, turning, gains=replace(GAINS, steady_radps=0.0))
    assert abs(with_it.height[-1] - 0.637) < 0.03
    assert abs(with_it.angle).max() < 0.1
    assert abs(without.angle[-1]) > 0.3
    assert abs(without.height[-1] - 0.637) > 3 * abs(with_it.height[-1] - 0.637)


def test_without_the_reset_the_height_runs_off_after_a_stop():
    f, rate, turning, _ = roll_motion(60.0, 0.3)
    braking = np.zeros(len(f), bool)
    braking[300:500] = True
    f = np.where(braking, 0.0, f)
    with_it = run(f, rate, turning, braking=braking)
    without = run(f, rate, turning, braking=braking, reset=False)
    assert with_it.height[499] == pytest.approx(0.637, abs=0.005)
    assert abs(with_it.height[-1] - 0.637) < 0.03
    assert without.height[-1] > 0.637 + 0.2


def test_the_synthesis_follows_the_braking_estimate_with_its_low_pass():
    rows = 200
    zero = np.zeros(rows)
    found = run(zero, zero, zero, braking=np.ones(rows, bool))
    t = np.arange(1, rows + 1) / 100.0
    np.testing.assert_allclose(found.height, 0.637 + (0.08572 - 0.637) * np.exp(-10 * np.pi * t), rtol=1e-9)


def test_rows_that_are_not_active_leave_the_arm_alone():
    f, rate, turning, _ = roll_motion(20.0, 0.3)
    rows = len(f)
    nobody = np.zeros(rows, bool)
    found = adapt_roll(
        f, rate, turning, np.full(rows, MASS), np.zeros(rows), nobody, nobody, (np.array([0]), np.array([rows])), GAINS,
        rate_hz=100.0, height_m=0.5,
    )  # fmt: skip
    assert (found.height == 0.5).all()
    with pytest.raises(ValueError, match="segment"):
        adapt_roll(
            f, rate, turning, np.full(rows, MASS), np.zeros(rows), nobody, nobody,
            (np.array([0]), np.array([rows + 1])), GAINS, rate_hz=100.0, height_m=0.5,
        )  # fmt: skip


def test_the_linear_response_equals_the_exact_ramp():
    rate, k = 50.0, RollCoefficients(100.0, 8.0, 1.0)
    t = np.arange(400) / rate
    phi, before, after = discretise(k, 1 / rate)
    out = linear_response(t, phi, before, after, 1 / k.a, (np.array([0]), np.array([400])))
    # the ramp's own response: t/a - b/a² after the transient
    assert out[-1, 0] == pytest.approx(t[-1] / 100 - 8.0 / 100**2, rel=1e-6)
    assert out[-1, 1] == pytest.approx(0.01, rel=1e-6)
