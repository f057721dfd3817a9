"""The compiled gPC-EKF of load transfer: equal to plain Python, to the Kalman filter where it is linear, and to the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.load_transfer.filtering import (
    NAMES,
    FilterSettings,
    collocation_of,
    run_filter,
    table_settings,
)
from pipelines.estimators.load_transfer.kernels import HFLTM, LTM, MLTM
from pipelines.models.load_transfer import Motion, vertical_at_cg
from pipelines.models.roll import GRAVITY
from pipelines.reproduce.load_transfer.plant import SIZE, Matched, forces, forces_at, matched_drive, truth
from pipelines.reproduce.load_transfer.study import least_squares, working_settings
from pipelines.results import FloatArray

MODELS = (LTM, MLTM, HFLTM)


def drive(seconds: float, seed: int = 0) -> Matched:
    return matched_drive(seconds, np.random.default_rng(seed), rate_hz=100.0)


def noisy(model: int, d: Matched, std: float, seed: int = 1) -> FloatArray:
    clean = forces(model, d)
    return clean + std * np.random.default_rng(seed).standard_normal(clean.shape)


def plain(
    model: int, d: Matched, measured: FloatArray, settings: FilterSettings, rate_hz: float
) -> FloatArray:
    """The same recursion with numpy's matrices and the whole-array models, a sample at a time."""
    chosen = collocation_of(model, settings, np.random.default_rng(3))
    steps = 1000.0 / rate_hz
    start = np.array(settings.start)
    count = len(start)
    x = np.zeros((count, len(chosen.indices)))
    x[:, 0] = start[:, 0]
    width = start[:, 1] / np.sqrt(3)
    x[range(count), range(1, count + 1)] = width
    noise = np.full(4, settings.variance) / steps
    if model != HFLTM:
        noise = np.append(noise, settings.bounce_variance / steps)
    for k in range(len(measured)):
        held = x.copy()
        x[range(count), range(1, count + 1)] += np.array(settings.added) * width * steps
        turning = abs(d.motion.accel_y[k]) / GRAVITY > settings.calm
        masses = [i for i, name in enumerate(NAMES[model]) if not name.startswith(("h_", "C"))]
        if turning:
            x[masses, 1:] = 0.0
        row = Motion(
            *(
                getattr(d.motion, n)[k : k + 1]
                for n in ("accel_x", "accel_y", "vertical", "roll", "pitch", "speed")
            )
        )
        if model != LTM:
            row = replace(row, vertical=vertical_at_cg(d.corners[k : k + 1], x[:4, 0], SIZE))
        one = Matched(row, d.corners[k : k + 1], d.masses)
        values = np.array([forces_at(model, one, p)[0] for p in (chosen.matrix @ x.T)])
        z = measured[k]
        if model != HFLTM:
            values = np.column_stack((values, values.sum(axis=1)))
            z = np.append(z, z.sum())
        y = (chosen.inverse @ values).T
        inner = y[:, 1:] @ y[:, 1:].T + np.diag(noise)
        cross = x[:, 1:] @ y[:, 1:].T
        gain = np.linalg.solve(inner, cross.T).T
        x[:, 0] += gain @ (z - y[:, 0])
        if settings.form == 0:
            x[:, 1:] -= gain @ y[:, 1:]
        else:
            lower = np.linalg.cholesky(inner)
            x[:, 1:] -= (
                cross @ np.linalg.inv(lower).T @ np.linalg.inv(lower + np.diag(np.sqrt(noise))) @ y[:, 1:]
            )
        for i, name in enumerate(NAMES[model]):
            g = abs(row.accel_y[0] if name.startswith("h_r") else row.accel_x[0]) / GRAVITY
            if name.startswith(("h_", "C")) and g < settings.gate:
                x[i] = held[i]
            if turning and i in masses:
                x[i] = held[i]
    return x[:, 0]


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("form", [0, 1])
def test_the_kernel_equals_plain_python(model: int, form: int) -> None:
    d = drive(4.0)
    measured = noisy(model, d, 20.0)
    settings = replace(table_settings(model), factor=4.0, form=form, variance=1e4, bounce_variance=4e4)
    run = run_filter(model, d.motion, d.corners, measured, SIZE, settings, 100.0, np.random.default_rng(3))
    assert run.track[-1] == pytest.approx(plain(model, d, measured, settings, 100.0), rel=1e-6)


@pytest.mark.parametrize("model", MODELS)
def test_the_gated_kernel_equals_plain_python(model: int) -> None:
    d = drive(6.0)
    measured = noisy(model, d, 20.0)
    settings = replace(
        table_settings(model), factor=4.0, variance=1e4, bounce_variance=4e4, gate=0.1, calm=0.1
    )
    run = run_filter(model, d.motion, d.corners, measured, SIZE, settings, 100.0, np.random.default_rng(3))
    assert run.track[-1] == pytest.approx(plain(model, d, measured, settings, 100.0), rel=1e-6)
    free = replace(settings, gate=0.0, calm=np.inf)
    other = run_filter(model, d.motion, d.corners, measured, SIZE, free, 100.0, np.random.default_rng(3))
    assert np.abs(run.track[-1] / other.track[-1] - 1).max() > 1e-4


@pytest.mark.parametrize(("gate", "calm"), [(0.1, 0.1), (0.0, np.inf)])
def test_masses_that_are_held_in_turns_do_not_take_jacking_for_weight(gate: float, calm: float) -> None:
    """Links that carry 4 % of the weight at 0.4 g: the plain filter's mass is short by what it saw, the gated one's is not."""
    d = drive(60.0)
    lifted = 1 - 0.25 * (d.motion.accel_y / GRAVITY) ** 2
    measured = noisy(MLTM, d, 20.0) - (1 - lifted[:, None]) * d.masses * GRAVITY
    settings = replace(working_settings(MLTM, 1e4), form=0, gate=gate, calm=calm)
    run = run_filter(MLTM, d.motion, d.corners, measured, SIZE, settings, 100.0, np.random.default_rng(0))
    error = run.track[-1][:4].sum() / d.masses.sum() - 1
    if gate > 0:
        assert abs(error) < 2e-3
    else:
        assert error < -5e-3


def test_least_squares_ends_where_it_ends_wherever_it_begins() -> None:
    d = drive(20.0)
    measured = noisy(MLTM, d, 25.0)
    cold, covariance = least_squares(MLTM, d, measured, 25.0)
    warm, _ = least_squares(MLTM, d, measured, 25.0, truth(MLTM, d))
    assert np.all(np.abs(warm - cold) < 0.02 * np.sqrt(np.diag(covariance)))


@pytest.mark.parametrize("model", MODELS)
def test_it_finds_what_was_planted_as_least_squares_does(model: int) -> None:
    d = drive(30.0)
    measured = noisy(model, d, 25.0)
    variance = 25.0**2 * 10
    run = run_filter(
        model,
        d.motion,
        d.corners,
        measured,
        SIZE,
        working_settings(model, variance),
        100.0,
        np.random.default_rng(0),
    )
    true = truth(model, d)
    batch, covariance = least_squares(model, d, measured, 25.0)
    assert np.abs(batch - true).max() > 0
    assert np.all(np.abs(batch - true) < 4 * np.sqrt(np.diag(covariance)))
    heavy = 3 if model == LTM else 4
    assert run.track[-1][:heavy] == pytest.approx(true[:heavy], rel=2e-3)


def test_gauss_newton_is_linear_least_squares_where_the_model_is_linear() -> None:
    """Without arms' products: masses alone on the corners' accelerations."""
    d = drive(5.0)
    quiet = Matched(
        replace(d.motion, accel_x=0 * d.motion.roll, accel_y=0 * d.motion.roll), d.corners, d.masses
    )
    measured = d.masses * d.corners + np.random.default_rng(0).normal(0, 20, d.corners.shape)
    expected = (d.corners * measured).sum(axis=0) / (d.corners**2).sum(axis=0)
    slopes = np.stack(
        [forces_at(HFLTM, quiet, np.r_[unit, np.zeros(5)]).ravel() for unit in np.eye(4)], axis=1
    )
    assert np.linalg.lstsq(slopes, measured.ravel(), rcond=None)[0] == pytest.approx(expected)


def test_printed_settings_leave_products_unresolved() -> None:
    """Table 6.1 as printed: mass is found, a product's factors are not."""
    d = matched_drive(20.0, np.random.default_rng(5))
    measured = noisy(LTM, d, 3.2)
    errors = []
    for settings in (table_settings(LTM), working_settings(LTM, 10.0)):
        run = run_filter(LTM, d.motion, d.corners, measured, SIZE, settings, 1000.0, np.random.default_rng(0))
        errors.append(np.abs(run.track[-1] / truth(LTM, d) - 1))
    assert errors[0][0] < 0.02
    assert errors[0][-1] > 5 * errors[1][-1]
    assert errors[1][:3].max() < 1e-3


def test_the_gate_holds_arms_on_a_straight_road() -> None:
    d = drive(10.0)
    straight = Motion(
        0 * d.motion.roll,
        0 * d.motion.roll,
        d.motion.vertical,
        0 * d.motion.roll,
        0 * d.motion.roll,
        d.motion.speed,
    )
    measured = d.masses * d.corners + 300.0
    for gate, moves in ((0.05, False), (0.0, True)):
        settings = replace(table_settings(HFLTM), gate=gate, factor=4.0, form=1, variance=1e4)
        shaken = replace(straight, accel_y=np.full(len(measured), 0.3))
        run = run_filter(HFLTM, shaken, d.corners, measured, SIZE, settings, 100.0, np.random.default_rng(0))
        arms = run.track[:, 4:7]
        assert (np.abs(arms - 1.0).max() > 1e-3) == moves
