"""The gPC-EKF for regression and its companions: slow twins, closed forms, planted truth, noise on inputs."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.chaos.bases import hermite, legendre
from pipelines.chaos.collocation import Collocation, collocate
from pipelines.chaos.space import Space
from pipelines.filters.gpc_regression import RegressionFilter, gpc_regression
from pipelines.filters.gpc_update import PUBLISHED, SQUARE_ROOT
from pipelines.filters.products_batch import cramer_rao, fit_products
from pipelines.models.power_products import PowerProducts
from pipelines.models.roll_plane import SIMPLE, Plane, simple_regressors, strut_moments
from pipelines.results import FloatArray

LINEAR = PowerProducts(("p", "q"), np.array([[1, 0], [0, 1]]))
MIXED = PowerProducts(("m", "j", "h"), np.array([[-1, 0, 0], [0, -1, 0], [1, -1, 1]]))
TRUTH = np.array([2.0, 0.7, 0.5])


def points(dimensions: int, order: int = 2, *, gaussian: bool = False) -> Collocation:
    return collocate(Space((hermite() if gaussian else legendre(),) * dimensions), order)


def mixed(
    rows: int, seed: int, noise: float, input_noise: float = 0.0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Regressors seen, outputs, and true regressors of MIXED with two outputs."""
    rng = np.random.default_rng(seed)
    phi = np.zeros((rows, 2, 3))
    phi[:, 0, 0] = 3 * rng.standard_normal(rows)
    phi[:, 1, 1:] = 1.5 * rng.standard_normal((rows, 2))
    y = phi @ MIXED.coefficients(TRUTH) + noise**0.5 * rng.standard_normal((rows, 2))
    seen = phi.copy()
    seen[:, 1, 2] += input_noise**0.5 * rng.standard_normal(rows)
    return seen, y, phi


def slow_filter(phi: FloatArray, z: FloatArray, how: RegressionFilter) -> FloatArray:
    """(19), (20), (37)-(40), (70), (78) in plain numpy: the parameters' coefficients after all samples (n, S)."""
    at = how.collocation
    x = at.inverse @ (how.middle + how.half * at.points)
    for k in range(len(z)):
        if how.addition is not None:
            x = x + at.inverse @ (how.addition * how.half * at.points)
        values = at.matrix @ x
        outputs = np.stack([phi[k] @ how.model.coefficients(row) for row in values])
        y = at.inverse @ outputs
        total = y[1:].T @ y[1:] + np.diag(how.noise)
        gain = x[1:].T @ y[1:] @ np.linalg.inv(total)
        x = x.copy()
        x[0] += gain @ (z[k] - y[0])
        x[1:] -= y[1:] @ gain.T
    return np.asarray(x.T)


def test_compiled_equals_plain_python() -> None:
    phi, z, _ = mixed(25, 0, 0.05)
    how = RegressionFilter(
        MIXED, points(3), np.array([1.8, 0.8, 0.6]), np.array([0.4, 0.2, 0.2]), np.array([0.05, 0.08]),
        np.array([1e-3, 2e-3, 1e-3]), PUBLISHED,
    )  # fmt: skip
    found = gpc_regression(phi, z, how).coefficients
    assert np.allclose(found, slow_filter(phi, z, how), rtol=1e-9, atol=1e-12)


def test_square_root_form_is_the_kalman_filter_on_a_linear_model() -> None:
    rng = np.random.default_rng(1)
    phi = rng.standard_normal((40, 1, 2))
    z = phi @ np.array([1.0, -2.0]) + 0.3 * rng.standard_normal((40, 1))
    how = RegressionFilter(
        LINEAR,
        points(2, 1, gaussian=True),
        np.array([0.5, 0.5]),
        np.array([2.0, 1.0]),
        np.array([0.09]),
        None,
        SQUARE_ROOT,
    )
    run = gpc_regression(phi, z, how)
    information = np.diag([0.25, 1.0]) + phi[:, 0].T @ phi[:, 0] / 0.09
    right = np.array([0.5 / 4, 0.5]) + phi[:, 0].T @ z[:, 0] / 0.09
    covariance = np.linalg.inv(information)
    assert np.allclose(run.track[-1], covariance @ right, rtol=1e-8)
    assert np.allclose(run.spread[-1], np.sqrt(np.diag(covariance)), rtol=1e-7)


def test_published_form_collapses_below_the_posterior() -> None:
    rng = np.random.default_rng(1)
    phi = rng.standard_normal((40, 1, 2))
    z = phi @ np.array([1.0, -2.0]) + 0.3 * rng.standard_normal((40, 1))
    args = (LINEAR, points(2, 1), np.array([0.5, 0.5]), np.array([2.0, 3.0]), np.array([0.09]), None)
    published = gpc_regression(phi, z, RegressionFilter(*args, PUBLISHED)).spread[-1]
    right = gpc_regression(phi, z, RegressionFilter(*args, SQUARE_ROOT)).spread[-1]
    assert (published < 0.8 * right).all()


def test_planted_parameters_come_back() -> None:
    phi, z, _ = mixed(4000, 2, 0.01)
    how = RegressionFilter(
        MIXED,
        points(3),
        np.array([1.8, 0.8, 0.6]),
        np.array([0.4, 0.2, 0.2]),
        np.full(2, 0.01),
        None,
        SQUARE_ROOT,
    )
    run = gpc_regression(phi, z, how, every=100)
    assert run.track.shape == (40, 3)
    assert np.allclose(run.track[-1], TRUTH, atol=4 * run.spread[-1].max(), rtol=0)
    assert np.allclose(run.track[-1], TRUTH, rtol=0.01)
    # nothing excites: the prior stays
    still = gpc_regression(np.zeros_like(phi), np.zeros_like(z), how)
    assert np.allclose(still.track[-1], how.middle)
    assert np.allclose(still.spread[-1], how.half / 3**0.5, rtol=1e-6)


def test_input_noise_is_taken_out_of_filter_and_batch() -> None:
    seen, z, phi = mixed(30_000, 3, 0.2, input_noise=0.3)
    noise, given = np.full(2, 0.2), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.3]])
    start = np.array([1.8, 0.8, 0.6])

    def height(values: FloatArray) -> float:
        return float(values[2] / TRUTH[2] - 1)

    def filtered(input_noise: FloatArray | None) -> float:
        how = RegressionFilter(
            MIXED, points(3), start, np.array([0.4, 0.2, 0.2]), noise, None, SQUARE_ROOT, input_noise
        )
        return height(gpc_regression(seen, z, how).track[-1])

    assert filtered(None) < -0.08
    assert abs(filtered(given)) < 0.02
    assert height(fit_products(MIXED, seen, z, noise, start).values) < -0.08
    right = fit_products(MIXED, seen, z, noise, start, given)
    assert right.converged
    assert abs(height(right.values)) < 0.02
    bound = cramer_rao(MIXED, phi, TRUTH, noise, given)
    assert np.all((right.std > 0.8 * bound) & (right.std < 1.5 * bound))


def test_batch_without_input_noise_is_least_squares_of_free_coefficients() -> None:
    """As many parameters as coefficients: the non-linear fit is the linear one, taken through the products."""
    model = PowerProducts(("a", "b"), np.array([[-1, 0], [1, 1]]))
    rng = np.random.default_rng(4)
    phi = rng.standard_normal((300, 1, 2))
    y = phi @ model.coefficients(np.array([2.0, 3.0])) + 0.1 * rng.standard_normal((300, 1))
    linear = np.linalg.lstsq(phi[:, 0], y[:, 0], rcond=None)[0]
    found = fit_products(model, phi, y, np.array([0.01]), np.array([1.0, 1.0]))
    assert np.allclose(model.coefficients(found.values), linear, rtol=1e-7)


def test_slopes_are_derivatives() -> None:
    values, step = np.array([2950.0, 2250.0, 650.0, 0.5]), 1e-6
    for i in range(4):
        up, down = values.copy(), values.copy()
        up[i] *= 1 + step
        down[i] /= 1 + step
        numeric = (SIMPLE.coefficients(up) - SIMPLE.coefficients(down)) / (2 * step)
        assert np.allclose(SIMPLE.slopes(values)[:, i], numeric, rtol=1e-5, atol=1e-12)


def test_simple_model_is_the_printed_equations() -> None:
    """(71)-(73) by hand."""
    forces, plane = np.array([[100.0, 200.0, 300.0, 500.0]]), Plane(0.7, 0.8, 1.2, 1.5)
    total, roll, pitch = strut_moments(forces, plane)
    assert total[0] == 1100
    assert roll[0] == pytest.approx(0.7 * 400 - 0.8 * 700)
    assert pitch[0] == pytest.approx(-1.2 * 300 + 1.5 * 800)
    m, jp, jr, h = values = np.array([1000.0, 2000.0, 600.0, 0.5])
    y = simple_regressors(forces, np.array([1.5]), np.array([-2.0]), plane) @ SIMPLE.coefficients(values)
    assert y[0] == pytest.approx([1100 / m, (roll[0] - 2 * m * h) / jr, (pitch[0] + 1.5 * m * h) / jp])


def test_wrong_set_up_is_refused() -> None:
    phi, z, _ = mixed(10, 0, 0.1)
    good = {"middle": np.ones(3), "half": np.ones(3), "noise": np.ones(2)}
    with pytest.raises(ValueError, match="variance above 0"):
        gpc_regression(phi, z, RegressionFilter(MIXED, points(3), **{**good, "noise": np.zeros(2)}))
    with pytest.raises(ValueError, match="one variable"):
        gpc_regression(phi, z, RegressionFilter(MIXED, points(2), **good))
    with pytest.raises(ValueError, match="fit together"):
        gpc_regression(phi[:, :1], z, RegressionFilter(MIXED, points(3), **good))
    with pytest.raises(ValueError, match="form"):
        gpc_regression(phi, z, RegressionFilter(MIXED, points(3), **good, form=2))
    with pytest.raises(ValueError, match="one column"):
        PowerProducts(("a",), np.array([[1, 2]]))
