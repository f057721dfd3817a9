"""Second stage: from the roll coefficients to the vehicle, by weighted draws.

Everything but the springs' and dampers' roll rates is drawn from what was known; the coefficients a, b are drawn from
the first stage's likelihood given what the draw says of c; K and D then follow exactly. Draws are weighted by how
well c fits, and by the priors of K and D where there are any. The curved ridge between height, inertia and stiffness,
and its mirror image, need no approximation that way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.roll_map.priors import VehicleDraws
from pipelines.models.roll_series import AXLES_MOMENT
from pipelines.results import FloatArray, Prior

KNEE = 0.15
"""Spread of the dampers' rate at a drive's working point over that at low speed: knees take 10 to 30 % off in hard steering,
dry friction adds as much in soft (measured on simulated cars with both)."""


@dataclass(frozen=True)
class RollLikelihood:
    """What the log says of (a, b, c) or (a, b, c, rate gain), in information form: exp(-x'Λx/2 + η'x).

    The weak priors of the fit are taken out. vague, vague_mean: the weak priors of a and b alone, (2,), which keep
    the draws finite where the log says nothing. against_axles: the angle was the body's against its axles.
    """

    information: FloatArray
    linear: FloatArray
    vague: FloatArray
    vague_mean: FloatArray
    against_axles: bool
    centre: FloatArray


@dataclass(frozen=True)
class Posterior:
    """Weighted draws. values: name -> (n,). weight: (n,), sums to one. effective: effective number of draws."""

    values: dict[str, FloatArray]
    weight: FloatArray
    effective: float


def pure_likelihood(
    mean: FloatArray, covariance: FloatArray, prior_mean: FloatArray, prior_std: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Take a Gaussian prior out of a Gaussian posterior: information and linear term of what the data said.

    Directions in which the prior knew as much as the posterior get no information (never a negative one).
    """
    scale = prior_std
    information = np.linalg.inv(covariance / np.outer(scale, scale)) - np.eye(len(mean))
    values, vectors = np.linalg.eigh(0.5 * (information + information.T))
    values = np.where(values > 1e-3, values, 0.0)
    whitened = (mean - prior_mean) / scale
    # the data's own centre in each direction: pulled away from the prior by as much as the prior had pulled it
    along = vectors.T @ whitened
    centre = np.where(values > 0, along * (1 + values) / np.maximum(values, 1e-300), 0.0)
    pure = vectors @ np.diag(values) @ vectors.T
    matrix = pure / np.outer(scale, scale)
    linear = (vectors @ (values * centre)) / scale + matrix @ prior_mean
    return np.asarray(matrix), np.asarray(linear)


def with_discrepancy(
    mean: FloatArray, covariance: FloatArray, prior_mean: FloatArray, prior_std: FloatArray, root: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Mean (k,) and covariance (k, k) of a Gaussian posterior whose data have an error of covariance root root' more, (k, m).

    The error is the data's: added to the posterior it would count for the prior as well, and a prior about as wide, taken out again
    (`pure_likelihood`), would leave data that say anything.
    """
    information, linear = pure_likelihood(mean, covariance, prior_mean, prior_std)
    reached = information @ root
    gain = np.linalg.solve(np.eye(root.shape[1]) + root.T @ reached, reached.T)
    # what stays of a direction that the data tell: information less that of the error in series with it
    information, linear = information - reached @ gain, linear - gain.T @ (root.T @ linear)
    weak = 1 / prior_std**2
    after = np.linalg.inv(information + np.diag(weak))
    return np.asarray(after @ (linear + weak * prior_mean)), 0.5 * (after + after.T)


def _tyre_share(
    d: VehicleDraws, suspension: FloatArray | None, road: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """κ = K / (K + K_tyre), and the moment arm M_e: K' φ = M_e f in a steady corner seen from the horizon.

    From the suspension's stiffness, or from the apparent coefficient a (`road`) by which K' = a M_e.
    """
    own = d.sprung * d.arm
    ground = d.sprung * d.roll_axis + d.unsprung * d.hub
    if suspension is not None:
        kappa = suspension / (suspension + d.tyre_roll)
    else:
        assert road is not None
        series = road * own / np.maximum(d.tyre_roll - road * ground, 0.2 * d.tyre_roll)
        kappa = np.minimum(series, 0.9)
    return np.asarray(kappa), np.asarray(own + kappa * ground)


def suspension_rates(
    d: VehicleDraws, a: FloatArray, b: FloatArray, *, against_axles: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """K and D of the suspension, and d log K / d log a, for each draw."""
    own = d.sprung * d.arm
    if against_axles:
        return a * own, b * own, np.ones_like(a)
    kappa, moment = _tyre_share(d, None, a)
    stiffness = a * moment / (1 - kappa)
    # twice the lean: tyres that carry the axles' part answer late as well (`roll_series`)
    damping = b * moment**2 / own / (1 - kappa) ** 2
    ground = d.sprung * d.roll_axis + d.unsprung * d.hub
    slope = 1 / np.maximum(1 - a * ground / d.tyre_roll, 0.2) / (1 - kappa)
    return np.asarray(stiffness), np.asarray(damping), np.asarray(slope)


def series_loss(kappa: FloatArray, a: float, b: float) -> FloatArray:
    """What tyres in series with damped springs take off the apparent c: the ω² term of K(1 - K/K_tyre …)."""
    return np.asarray((1 + AXLES_MOMENT) * kappa / (1 - kappa) * b**2 / a)


def expected_rest(
    d: VehicleDraws, a: float, b: float, *, against_axles: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """c, the rate gain (suspension over road stiffness) and the series loss that each draw predicts near a, b."""
    near = np.full(len(d.mass), a)
    if against_axles:
        kappa, moment = _tyre_share(d, near * d.sprung * d.arm, None)
    else:
        kappa, moment = _tyre_share(d, None, near)
    reach = d.arm - d.imu
    loss = series_loss(kappa, a, b)
    c = (d.body_inertia + reach * (moment - kappa * d.unsprung * d.hub)) / moment - loss
    ratio = (1 - kappa) * d.sprung * d.arm / moment
    if against_axles:
        loss = np.zeros_like(c)
        c = (d.body_inertia / (d.sprung * d.arm) + reach) / ratio
    return np.asarray(c), np.asarray(1 / ratio), loss


def _conditioned(
    likelihood: RollLikelihood, rest: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """a, b given the rest of the coefficients (k, n), drawn; and the log-likelihood of the rest."""
    matrix = likelihood.information.copy()
    matrix[:2, :2] += np.diag(likelihood.vague)
    linear = likelihood.linear.copy()
    linear[:2] += likelihood.vague * likelihood.vague_mean
    inner = np.linalg.inv(matrix[:2, :2])
    mean = inner @ (linear[:2, None] - matrix[:2, 2:] @ rest)
    schur = matrix[2:, 2:] - matrix[2:, :2] @ inner @ matrix[:2, 2:]
    pull = linear[2:] - matrix[2:, :2] @ inner @ linear[:2]
    score = pull @ rest - 0.5 * np.einsum("in,ij,jn->n", rest, schur, rest)
    root = np.linalg.cholesky(0.5 * (inner + inner.T))
    drawn = mean + root @ rng.standard_normal((2, rest.shape[1]))
    return drawn[0], drawn[1], score


def _log_normal(value: FloatArray, prior: Prior) -> FloatArray:
    std = max(prior.std, 1e-6 * abs(prior.value))
    return np.asarray(-0.5 * ((value - prior.value) / std) ** 2)


def sample_posterior(
    d: VehicleDraws,
    likelihood: RollLikelihood,
    stiffness: Prior | None,
    damping: Prior | None,
    rng: np.random.Generator,
) -> Posterior:
    """Weight the draws of the vehicle by the log's likelihood and by the priors of K and D."""
    near_a, near_b = float(likelihood.centre[0]), float(likelihood.centre[1])
    c, gain, _ = expected_rest(d, near_a, near_b, against_axles=likelihood.against_axles)
    rest = np.vstack([c, gain])[: len(likelihood.linear) - 2]
    a, b, log_weight = _conditioned(likelihood, rest, rng)
    good = d.possible & (a > 1.0) & (b > 0.0) & (c > 0.0)
    a, b = np.where(good, a, 100.0), np.where(good, b, 5.0)
    k, damp, slope = suspension_rates(d, a, b, against_axles=likelihood.against_axles)
    # draws that cannot be (an axis above the CG) may give negative rates: they carry no weight below
    k, damp, slope = (np.where(good, x, 1.0) for x in (k, damp, slope))
    # b is that of the drive's own speeds and friction; what is reported, and what a vehicle file states, are the dampers' rates
    damp = damp * np.exp(KNEE * rng.standard_normal(len(damp)))
    # densities of K and D turned into densities of a and b
    if stiffness is not None:
        log_weight = log_weight + _log_normal(k, stiffness) + np.log(k * slope / a)
    if damping is not None:
        log_weight = log_weight + _log_normal(damp, damping) + np.log(damp / b)
    log_weight = np.where(good & np.isfinite(log_weight), log_weight, -np.inf)
    top = float(log_weight.max())
    if not math.isfinite(top):
        return Posterior({}, np.zeros(len(a)), 0.0)
    weight = np.exp(log_weight - top)
    weight /= weight.sum()
    values = {
        "cg_height_m": d.height,
        "sprung_cg_height_m": d.sprung_height,
        "roll_arm_m": d.arm,
        "roll_center_height_m": d.roll_axis,
        "mass_kg": d.mass,
        "sprung_mass_kg": d.sprung,
        "roll_inertia_kgm2": d.inertia,
        "roll_stiffness_nmprad": k,
        "roll_damping_nmsprad": damp,
        "mirror": d.body_inertia / (d.sprung * d.arm**2),
    }
    return Posterior(values, weight, float(1 / np.sum(weight**2)))


def quantiles(values: FloatArray, weight: FloatArray, levels: Sequence[float] | FloatArray) -> FloatArray:
    """Weighted quantiles."""
    order = np.argsort(values)
    share = np.cumsum(weight[order])
    share = (share - 0.5 * weight[order]) / share[-1]
    return np.asarray(np.interp(levels, share, values[order]))


def moments(values: FloatArray, weight: FloatArray) -> tuple[float, float]:
    """Weighted mean and standard deviation."""
    mean = float(weight @ values)
    return mean, math.sqrt(max(float(weight @ (values - mean) ** 2), 0.0))
