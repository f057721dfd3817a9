"""A posterior by the model itself, where no polynomial is close enough: importance sampling over a bent sheet.

A model of which only some combinations of its parameters are seen has a posterior like a bent sheet: as thin as the data are good
across, as wide as the priors along. A polynomial of a low order over a box does not hold one, and its posterior is too narrow as often
as it is too wide. Here draws are laid along the sheet (heavy-tailed, in the directions that the data hardly see), each is moved across to where
the data want it (Gauss-Newton, all draws at once), and drawn about there by the curvature of the place. Weights by the model's own likelihood
make this exact, as far as enough draws carry weight and the sheet does not fold back over itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipelines.bayes.posterior import TAIL, Posterior, student_draws
from pipelines.bayes.priors import Priors
from pipelines.results import FloatArray

All = Callable[[FloatArray], FloatArray]
"""Coordinates (Q, d) -> residuals (Q, N) of all data over their spread."""

DRAWS, ROUNDS, ENOUGH = 800, 4, 150.0
"""Draws of a round; the most rounds, each laid by the weights of the one before; equally weighted draws that a posterior must be worth."""

AT_ONCE = 64
"""Draws that the model is run at together: bounds memory."""

STIFF = 9.0
"""What the data say of a direction over what the prior says, from which it counts as across the sheet."""

BROADER, ACROSS_STEPS, FURTHEST = 1.3, 4, 1.0
"""Draws are laid so much broader than what they stand for. Gauss-Newton steps across the sheet; the longest of them, in prior spreads."""

STEPS, STEP = 30, 1e-4
"""Of Gauss-Newton to the densest point; of derivatives, in prior spreads of the coordinates."""


@dataclass(frozen=True)
class _Sheet:
    """top (d,): the densest point. along (d, u), across (d, s): directions, in prior spreads. seen (u,): what the data say of `along`."""

    top: FloatArray
    along: FloatArray
    across: FloatArray
    seen: FloatArray

    def place(self, u: FloatArray, s: FloatArray) -> FloatArray:
        """(n, d) coordinates."""
        return np.asarray(self.top + u @ self.along.T + s @ self.across.T)


@dataclass(frozen=True)
class _Weighed:
    """Draws (n, d) in coordinates and along the sheet (n, u); the logarithm of prior and likelihood over the density they are drawn from."""

    draws: FloatArray
    u: FloatArray
    ratio: FloatArray

    @property
    def weights(self) -> FloatArray:
        """(n,) sum to 1."""
        found = np.exp(self.ratio - self.ratio.max())
        return np.asarray(found / found.sum())


def worth(weights: FloatArray) -> float:
    """How many equally weighted draws."""
    return float(1 / np.sum(weights**2))


def spreads(priors: Priors) -> FloatArray:
    """(d,) of the priors, in coordinates."""
    return np.array([i.distribution.std / (abs(i.distribution.mean) if i.log else 1.0) for i in priors.items])


def misfit(everything: All, coordinates: FloatArray) -> FloatArray:
    """(n,) sum of squares of the residuals, a few runs at a time; infinite where the model gives no finite prediction."""
    found = np.empty(len(coordinates))
    for first in range(0, len(coordinates), AT_ONCE):
        rows = slice(first, first + AT_ONCE)
        with np.errstate(over="ignore", invalid="ignore"):
            found[rows] = np.sum(everything(coordinates[rows]) ** 2, axis=1)
    return np.where(np.isfinite(found), found, np.inf)


def densest(priors: Priors, everything: All, start: FloatArray) -> FloatArray:
    """The MAP (d,) in coordinates by Gauss-Newton on the model itself, from `start`; no lower than that."""
    low, high = priors.hard()
    step = STEP * spreads(priors)

    def log_at(points: FloatArray) -> FloatArray:
        return priors.log_density(points) - 0.5 * misfit(everything, points)

    place, best, damping = start, float(log_at(start[None])[0]), 1e-6
    d = len(start)
    for _ in range(STEPS):
        around = np.vstack((place[None], place + np.diag(step), place - np.diag(step)))
        left = everything(around)
        slopes = ((left[1 : d + 1] - left[d + 1 :]) / (2 * step[:, None])).T
        gradient, bent = _prior_slopes(priors, place, step)
        curvature = slopes.T @ slopes + np.diag(bent)
        scale = np.diag(np.maximum(np.diag(curvature), 1e-12))
        wanted = gradient - slopes.T @ left[0]
        ladder = damping * 10.0 ** np.arange(8)
        trials = np.array([place + np.linalg.solve(curvature + lift * scale, wanted) for lift in ladder])
        trials = np.clip(trials, low, high)
        values = log_at(trials)
        k = int(np.nanargmax(values))
        if not values[k] > best:
            break
        gained, place, best, damping = (
            values[k] - best,
            trials[k],
            float(values[k]),
            max(ladder[k] * 0.1, 1e-9),
        )
        if gained < 1e-4:
            break
    return place


def _prior_slopes(priors: Priors, place: FloatArray, step: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(d,) gradient and negative curvature of the log prior; nought at a bound."""
    wide = 10 * step
    log = priors.log_density(np.vstack((place[None], place + np.diag(wide), place - np.diag(wide))))
    ahead, behind = log[1 : len(place) + 1], log[len(place) + 1 :]
    with np.errstate(invalid="ignore"):
        gradient, bent = (ahead - behind) / (2 * wide), -(ahead - 2 * log[0] + behind) / wide**2
    fine = np.isfinite(gradient) & np.isfinite(bent)
    return np.where(fine, gradient, 0.0), np.where(fine, np.maximum(bent, 0.0), 0.0)


def _sheet(priors: Priors, everything: All, top: FloatArray) -> _Sheet:
    """Which directions the data see, at the densest point."""
    unit = spreads(priors)
    step = STEP * unit
    left = everything(np.vstack((top + np.diag(step), top - np.diag(step))))
    slopes = (left[: len(top)] - left[len(top) :]) / (2 * STEP)
    seen, vectors = np.linalg.eigh(slopes @ slopes.T)
    stiff = seen > STIFF
    turned = unit[:, None] * vectors
    return _Sheet(top, turned[:, ~stiff], turned[:, stiff], np.maximum(seen[~stiff], 0.0))


def _student(spread: FloatArray, root: FloatArray) -> FloatArray:
    """(n,) logarithm of the density of draws made as `spread` (n, k) times root' (k, k) or (n, k, k)."""
    k = spread.shape[1]
    constant = math.lgamma((TAIL + k) / 2) - math.lgamma(TAIL / 2) - 0.5 * k * math.log(TAIL * math.pi)
    size = np.log(np.abs(np.diagonal(root, axis1=-2, axis2=-1))).sum(axis=-1)
    return np.asarray(constant - 0.5 * (TAIL + k) * np.log1p(np.sum(spread**2, axis=1) / TAIL) - size)


def _moved_across(
    everything: All, sheet: _Sheet, u: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Where the data want each draw across the sheet (n, s), and the root of the spread there (n, s, s)."""
    n, k = len(u), sheet.across.shape[1]
    s, roots = np.zeros((n, k)), np.tile(np.eye(k), (n, 1, 1))
    many = max(1, AT_ONCE // (k + 1))
    for first in range(0, n, many):
        rows = slice(first, min(first + many, n))
        for _ in range(ACROSS_STEPS):
            at = np.stack(
                [sheet.place(u[rows], s[rows] + move) for move in (np.zeros(k), *(STEP * np.eye(k)))]
            )
            left = everything(np.clip(at.reshape(-1, len(sheet.top)), low, high)).reshape(*at.shape[:2], -1)
            slopes = (left[1:] - left[0]) / STEP
            curvature = np.einsum("pnr,qnr->npq", slopes, slopes) + 1e-9 * np.eye(k)
            step = -np.linalg.solve(curvature, np.einsum("pnr,nr->np", slopes, left[0])[..., None])[..., 0]
            s[rows] += (
                step * np.minimum(1.0, FURTHEST / np.maximum(np.linalg.norm(step, axis=1), 1e-12))[:, None]
            )
        roots[rows] = np.linalg.inv(np.swapaxes(np.linalg.cholesky(curvature), 1, 2))
    return s, roots


def _weigh(
    priors: Priors, everything: All, sheet: _Sheet, about: tuple[FloatArray, FloatArray], turn: int
) -> _Weighed:
    """Draws along the sheet about a mean with a covariance, moved across, with the model run at them. turn: another set each."""
    mean, covariance = about
    d, k = len(sheet.top), len(mean)
    root = BROADER * np.linalg.cholesky(covariance + 1e-12 * np.eye(k))
    first, second = np.split(student_draws(DRAWS, (k, d - k), turn), [k], axis=1)
    low, high = priors.runs()
    u = mean + first @ root.T
    middle, roots = _moved_across(everything, sheet, u, low, high)
    roots = np.asarray(BROADER * roots, dtype=np.float64)
    draws = sheet.place(u, middle + np.einsum("npq,nq->np", roots, second))
    drawn = _student(first, np.asarray(root, dtype=np.float64)) + _student(second, roots)
    fine = np.all((draws >= low) & (draws <= high), axis=1)
    fine[fine] = np.isfinite(priors.log_density(draws[fine]))
    draws, u, drawn = draws[fine], u[fine], drawn[fine]
    log = priors.log_density(draws) + priors.log_stretch(draws) - 0.5 * misfit(everything, draws)
    return _Weighed(draws, u, np.where(np.isfinite(log), log - drawn, -np.inf))


def exact(priors: Priors, everything: All, start: Posterior) -> tuple[Posterior, bool, int]:
    """The posterior by the model's own likelihood, whether enough draws carry it, and how often the model was run over all data.

    start: a surrogate's posterior; kept, with its MAP put right, where too few draws carry weight.
    """
    domain = start.surrogate.domain
    top = densest(priors, everything, priors.coordinates(start.map_value))
    sheet = _sheet(priors, everything, top)
    about = (np.zeros(len(sheet.seen)), np.diag(1 / (1 + sheet.seen)))
    right = replace(start, map_value=priors.values(top), map_xi=domain.into(top[None])[0])
    runs = 0
    for turn in range(ROUNDS):
        found = _weigh(priors, everything, sheet, about, turn)
        runs += DRAWS * (1 + ACROSS_STEPS * (1 + sheet.across.shape[1]))
        if not np.isfinite(found.ratio).any():
            break
        weights = found.weights
        if worth(weights) >= ENOUGH:
            unit = float(np.linalg.slogdet(np.hstack((sheet.along, sheet.across)))[1])
            evidence = (
                found.ratio.max() + np.log(np.exp(found.ratio - found.ratio.max()).sum() / DRAWS) + unit
            )
            told = replace(
                right, xi=domain.into(found.draws), values=priors.values(found.draws), weights=weights,
                log_evidence=float(evidence), effective=worth(weights),
            )  # fmt: skip
            return told, True, runs
        mean = weights @ found.u
        spread = ((found.u - mean) * weights[:, None]).T @ (found.u - mean)
        about = (mean, spread + 0.1 * about[1])
    return right, False, runs
