"""From an estimator's fitted parameters to evidence: what the log itself said of them, the fit's own priors taken out.

A fit with normal priors has the posterior precision D + P, with P the priors' and D the log's. D is found by division of
the two Gaussians. Seen in the directions in which the posterior is white, P is a diagonal of shares s between 0 (all is
from the log) and 1 (all is from the prior), and each direction is divided by itself:

    y = (z - s z0) / (1 - s),    variance 1 / (1 - s)

with z the fitted and z0 the prior's place in that direction. Where residuals hang together, so that the posterior is wider than by
white noise, the division is that of the white one, whose estimate it is, and the log's share alone is widened: with W the wider
posterior's covariance in these directions, the variance is D^-1 (W - S) D^-1 with D = 1 - s and S = s on their diagonals. A direction that is mostly prior is left out, so that no
precision can come out negative, and none is made up from the difference of two nearly equal ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from pipelines.evidence import Evidence, Kind, Unknown, Values
from pipelines.joint.vehicle.outputs import body_at
from pipelines.joint.vehicle.poles import past_the_springs
from pipelines.joint.vehicle.unknowns import Body
from pipelines.results import FloatArray

MOST_PRIOR = 0.7
"""Share of a direction's precision that may be the prior's: beyond it the rest is as unsure as the covariances are."""

Parameters = Callable[[Values], Sequence[float | FloatArray]]
"""From the unknowns by name to an estimator's parameters, each a number or (n,)."""


@dataclass(frozen=True)
class Told:
    """What a log told of k parameters: rows (m, k) @ parameters = observed (m,) + noise with covariance (m, m)."""

    rows: FloatArray
    observed: FloatArray
    covariance: FloatArray


def without_prior(
    values: FloatArray,
    covariance: FloatArray,
    prior_mean: FloatArray,
    prior_std: FloatArray,
    most_prior: float = MOST_PRIOR,
    white: FloatArray | None = None,
) -> Told | None:
    """Divide a posterior (k,), (k, k) by its independent priors (k,), (k,); inf = none. None where the log told nothing.

    white: (k, k) the posterior's covariance by white noise alone, where `covariance` is wider. Raises ValueError where a covariance is
    not positive definite.
    """
    wider, covariance = covariance, covariance if white is None else white
    size = np.sqrt(np.diag(covariance))
    if not (np.all(np.isfinite(size)) and np.all(size > 0)):
        raise ValueError("the covariance of the fitted parameters has no positive diagonal")
    spread, axes = np.linalg.eigh(covariance / np.outer(size, size))
    if spread[0] <= 0:
        raise ValueError("the covariance of the fitted parameters is not positive definite")
    # whiten @ parameters has covariance 1
    whiten = (axes / np.sqrt(spread)).T / size
    root = (axes * np.sqrt(spread)).T * size
    # what was as good as given stays a direction of nothing but prior
    precision = 1 / np.maximum(np.asarray(prior_std, dtype=np.float64), 1e-6 * size) ** 2
    shares, turn = np.linalg.eigh(root * precision @ root.T)
    rows = turn.T @ whiten
    kept = np.clip(shares, 0.0, None) <= most_prior
    if not kept.any():
        return None
    # P z0 in the same directions; where there is no prior its mean has no say
    pull = turn.T @ root @ (precision * np.where(precision > 0, prior_mean, 0.0))
    own = 1 - np.clip(shares[kept], 0.0, None)
    observed = ((rows @ values)[kept] - pull[kept]) / own
    if white is None:
        return Told(rows[kept], observed, np.diag(1 / own))
    root = np.sqrt(own)
    shown = (rows[kept] @ wider @ rows[kept].T - np.diag(1 - own)) / np.outer(root, root)
    grown, axes = np.linalg.eigh(shown)
    # in no direction surer than by white noise
    return Told(rows[kept], observed, (axes * np.maximum(grown, 1.0)) @ axes.T / np.outer(root, root))


def loaded_body(values: Values) -> Body:
    """The loaded vehicle; its figures are (n,) where the unknowns are."""
    return body_at(values, {})


def hubs_past(values: Values) -> float | FloatArray:
    """kg m of the hubs' inertia that pass the springs by (`past_the_springs`), of one vehicle or of many."""
    return past_the_springs(cast("Mapping[str, float]", values))


def stacked(parts: Sequence[float | FloatArray]) -> FloatArray:
    """(m,) of numbers, or (m, n) where any is (n,)."""
    return np.stack(np.broadcast_arrays(*parts)).astype(np.float64)


def evidence_of(
    kind: Kind,
    carrier: str,
    title: str,
    source: str,
    told: Told,
    parameters: Parameters,
    unknowns: tuple[str, ...],
    own: tuple[Unknown, ...] = (),
    given: Mapping[str, float] | None = None,
) -> Evidence:
    """What was told of a fit's parameters, as a relation; parameters: what they would be for a given vehicle.

    unknowns: of the vehicle that they depend on; own: those of this relation besides; given: see `Evidence`.
    """
    rows = told.rows

    def predict(values: Values) -> FloatArray:
        return np.asarray(rows @ stacked(parameters(values)))

    names = tuple(dict.fromkeys((*unknowns, *(o.name for o in own))))
    return Evidence(
        kind, carrier, title, source, told.observed, told.covariance, predict, names, own, given or {}
    )


def direct(values: Sequence[float], covariance: FloatArray) -> Told:
    """Parameters that were fitted without a prior, as they are: (k,), (k, k)."""
    return Told(np.eye(len(values)), np.asarray(values, dtype=np.float64), np.asarray(covariance))
