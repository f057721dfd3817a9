"""Parameters that are not straight in the unknowns as far as these may be off: told by draws of the unknowns.

A posterior that is normal in its unknowns is not so in their products. What a load moves the CG by is its mass times its
distance; a load of next to nothing moves it by nothing wherever it lies, so that the slope at the mode says that the CG is
known. With a load of 60 ± 80 kg anywhere between the axles it is not.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipelines.joint.posterior import FARTHEST, Joint, values_at
from pipelines.joint.vehicle.outputs import outputs_of
from pipelines.results import FloatArray

PAIRS = 2000
"""Draws, each with its mirror image about the mode: what is even in them (a product) is not in error by what is odd."""

BENT = 0.02
"""Share of a parameter's variance from which on its second order counts: what that adds, or the square of what it moves the mean by."""


def bent(
    joint: Joint, middle: Mapping[str, float], gradients: Mapping[str, FloatArray], rng: np.random.Generator
) -> dict[str, FloatArray]:
    """Draws (n,) of the parameters that bend, by name. middle, gradients: of all at the mode, the latter (k,) each.

    The unknowns are drawn from the normal distribution at the mode; a parameter's second order is in its draws' mean and spread.
    """
    size = len(joint.u)
    steps = rng.standard_normal((PAIRS, size)) @ np.linalg.cholesky(joint.covariance).T
    steps = np.concatenate([steps, -steps])
    inside = np.abs(joint.u + steps).max(axis=1) < FARTHEST
    steps = steps[inside]
    with np.errstate(all="ignore"):
        columns = outputs_of(values_at(joint.known, joint.u + steps), joint.given)
    found = {}
    for name, gradient in gradients.items():
        column = np.broadcast_to(columns[name], len(steps))
        if not np.isfinite(column).all():
            continue
        straight = steps @ gradient
        more = column - middle[name] - straight
        variance = float(gradient @ joint.covariance @ gradient)
        excess = float(np.var(more) + 2 * np.cov(straight, more)[0, 1])
        if max(excess, float(np.mean(more)) ** 2) > BENT * variance:
            found[name] = np.array(column)
    return found
