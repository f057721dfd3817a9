"""How far a parameter's marginal is from normal: the density along the ridge that the parameter leaves free.

A straight line through a curved ridge (load times its place is known, each alone is not) falls off although the
parameter's own marginal is normal. So the point two standard deviations off is let fall back on the ridge by Gauss-Newton
steps that leave the parameter where it is, and only the rest of the loss counts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from pipelines.joint.posterior import Joint, log_density, parts_at
from pipelines.results import FloatArray

REACH = (-2.0, 2.0)
STEPS = 2


def _settle(joint: Joint, start: FloatArray, gradient: FloatArray) -> list[FloatArray]:
    """The start (k,), and where the steps lead that leave `gradient` @ u as it is."""
    path = [start]
    for _ in range(STEPS):
        u = path[-1]
        slope, curvature = u.copy(), np.eye(len(u))
        for here in parts_at(joint.evidence, joint.known, u, [part.whitener for part in joint.parts]):
            slope -= here.slope.T @ here.residual
            curvature += here.information
        move, along = np.linalg.solve(curvature, np.column_stack([slope, gradient])).T
        path.append(u - move + along * float(gradient @ move) / float(gradient @ along))
    return path


def departure(joint: Joint, gradients: Mapping[str, FloatArray], names: Sequence[str]) -> float:
    """Worst difference in nats of a profile from the mode's parabola (2 nats deep there) at two standard deviations."""
    density = log_density(joint)
    worst = 0.0
    for name in names:
        g = gradients[name]
        along = joint.covariance @ g
        length = math.sqrt(max(float(g @ along), 1e-300))
        for reach in REACH:
            path = _settle(joint, joint.u + reach * along / length, g)
            with np.errstate(all="ignore"):
                found = density(np.array(path))
            top = float(np.max(found[np.isfinite(found)], initial=-math.inf)) + joint.cost
            worst = max(worst, abs(top + 0.5 * reach**2))
    return worst
