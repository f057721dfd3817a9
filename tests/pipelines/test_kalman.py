"""The compiled filter equals a plain one, and its likelihood is the joint normal density."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from pipelines.filters.kalman import innovations

Array = NDArray[np.float64]


def plain(y, push, feed, starts, stops, phi, q, c, r, x0, p0, clip=np.inf):  # type: ignore[no-untyped-def]
    """Textbook filter with matrices, one output after the other."""
    error, variance = np.full(y.shape, np.nan), np.full(y.shape, np.nan)
    for segment, (start, stop) in enumerate(zip(starts, stops, strict=True)):
        x, p = x0[segment].copy(), p0.copy()
        for k in range(start, stop):
            for output in range(y.shape[1]):
                if not np.isfinite(y[k, output]):
                    continue
                e = y[k, output] - feed[k, output] - c[output] @ x
                s = c[output] @ p @ c[output] + r[output]
                gain = p @ c[output] / s
                error[k, output], variance[k, output] = e, s
                x = x + gain * np.clip(e, -clip * np.sqrt(s), clip * np.sqrt(s))
                p = p - np.outer(gain, c[output] @ p)
            x = phi @ x + push[k]
            p = phi @ p @ phi.T + q
    return error, variance


def system(rng: np.random.Generator, n: int = 400) -> dict[str, Array]:
    phi = np.array([[0.98, 0.05, 0.0], [-0.6, 0.9, 0.0], [0.0, 0.0, 0.995]])
    q = np.diag([1e-5, 2e-3, 1e-6])
    c = np.array([[1.0, 0.0, 1.0], [0.1, 1.0, 0.0]])
    r = np.array([1e-3, 4e-3])
    return {
        "y": rng.standard_normal((n, 2)),
        "push": 0.01 * rng.standard_normal((n, 3)),
        "feed": 0.1 * rng.standard_normal((n, 2)),
        "phi": phi,
        "q": q,
        "c": c,
        "r": r,
        "x0": 0.1 * rng.standard_normal((2, 3)),
        "p0": np.diag([0.1, 0.2, 0.01]),
    }


@pytest.mark.parametrize("clip", [np.inf, 1.5])
def test_equals_the_plain_filter_with_holes_and_segments(clip: float) -> None:
    rng = np.random.default_rng(1)
    s = system(rng)
    s["y"][50:60, 0] = np.nan
    s["y"][300, :] = np.nan
    starts, stops = np.array([0, 180]), np.array([170, 400])
    error, variance = innovations(
        s["y"], s["push"], s["feed"], (starts, stops),
        phi=s["phi"], q=s["q"], c=s["c"], r=s["r"], x0=s["x0"], p0=s["p0"], clip=clip,
    )  # fmt: skip
    wanted, wanted_variance = plain(
        s["y"], s["push"], s["feed"], starts, stops, s["phi"], s["q"], s["c"], s["r"], s["x0"], s["p0"], clip
    )
    np.testing.assert_allclose(variance, wanted_variance, rtol=1e-7)
    np.testing.assert_allclose(error, wanted, rtol=1e-6, atol=1e-7)
    assert np.isnan(error[170:180]).all()


def test_columns_side_by_side_are_as_each_by_itself() -> None:
    rng = np.random.default_rng(5)
    s = system(rng)
    y = np.stack([s["y"], 3.0 * s["y"], rng.standard_normal(s["y"].shape)])
    y[:, 50:60, 0] = np.nan
    y[2, 200:205] = np.inf
    segments = (np.array([0, 180]), np.array([170, 400]))
    keys = {k: s[k] for k in ("phi", "q", "c", "r", "x0", "p0")}
    error, variance = innovations(y, None, None, segments, clip=2.0, **keys)
    for column, found in zip(y[:2], error, strict=False):
        alone, wanted = innovations(
            column, np.zeros((400, 3)), np.zeros((400, 2)), segments, clip=2.0, **keys
        )
        np.testing.assert_array_equal(found, alone)
        np.testing.assert_array_equal(variance, wanted)
    # what one column lacks alone is no output of it, and the others' gains stand
    assert np.isnan(error[2, 200:205]).all()
    assert np.isfinite(error[2, 206:]).all()


def test_likelihood_is_the_joint_density() -> None:
    """Innovations and variances give the density of all outputs together, built as one big matrix."""
    rng = np.random.default_rng(2)
    s = system(rng, 6)
    s["x0"] = s["x0"][:1]
    n, states = 6, 3
    mean_x, cov = [s["x0"][0]], np.zeros((n * states, n * states))
    cov[:states, :states] = s["p0"]
    for k in range(1, n):
        mean_x.append(s["phi"] @ mean_x[-1] + s["push"][k - 1])
        now, before = slice(k * states, (k + 1) * states), slice((k - 1) * states, k * states)
        cov[now, : k * states] = s["phi"] @ cov[before, : k * states]
        cov[: k * states, now] = cov[now, : k * states].T
        cov[now, now] = s["phi"] @ cov[before, before] @ s["phi"].T + s["q"]
    big = np.kron(np.eye(n), s["c"])
    mean = big @ np.concatenate(mean_x) + s["feed"].ravel()
    total = big @ cov @ big.T + np.kron(np.eye(n), np.diag(s["r"]))
    wanted = multivariate_normal(mean, total).logpdf(s["y"].ravel())
    error, variance = innovations(
        s["y"], s["push"], s["feed"], (np.array([0]), np.array([n])),
        phi=s["phi"], q=s["q"], c=s["c"], r=s["r"], x0=s["x0"], p0=s["p0"],
    )  # fmt: skip
    got = -0.5 * float(np.sum(error**2 / variance + np.log(2 * np.pi * variance)))
    assert got == pytest.approx(wanted, rel=1e-9)


def test_refuses_arrays_that_do_not_fit() -> None:
    s = system(np.random.default_rng(3), 10)
    keys = {k: s[k] for k in ("phi", "q", "c", "r", "p0")}
    with pytest.raises(ValueError, match="do not fit"):
        innovations(s["y"], s["push"][:5], s["feed"], (np.array([0]), np.array([10])), x0=s["x0"][:1], **keys)
    with pytest.raises(ValueError, match="leaves"):
        innovations(s["y"], s["push"], s["feed"], (np.array([0]), np.array([11])), x0=s["x0"][:1], **keys)
