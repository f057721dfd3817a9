"""The part of a relation's error that is the same in every drive of a vehicle.

A relation's covariance holds noise and what its physics leaves out, and only the noise is new in every drive. What is left out is
this vehicle's: with 20 drives taken as independent an interval would shrink around a biased value. So a share RHO of each
relation's error is common to all drives: relation r sees the vehicle as u + δ_r, the same δ_r in every drive, with

    δ_r ~ N(0, Q_r),   Q_r = RHO (mean over drives of J' J)⁻¹,

J (m, k) its whitened rows by u. In a drive that is like the others the common error then has covariance J Q J' = RHO I, and
the drive's own I - J Q J', so that one drive alone is as sure as before; one that told little has mostly noise of its own; and
no drive's error is more common than RHO.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.results import FloatArray

RHO = 0.8
"""Share of the variance of every relation's error that is the vehicle's: see docs/fleet_model.md for the fleets behind it."""

LEAST = 1e-8
"""Of the largest eigenvalue of the mean information: directions below it were seen by no drive."""


def common_directions(slopes: Sequence[FloatArray], rho: float) -> FloatArray:
    """(k, q) square root of Q. slopes: (m_d, k) of each drive that has the relation, by the same unknowns."""
    information = sum(j.T @ j for j in slopes) / len(slopes)
    size, axes = np.linalg.eigh(information)
    seen = size > LEAST * max(float(size[-1]), 1e-300)
    return np.asarray(np.sqrt(rho) * axes[:, seen] / np.sqrt(size[seen]))


def shared_error(slope: FloatArray, directions: FloatArray, rho: float) -> tuple[FloatArray, FloatArray]:
    """Common error of one drive's relation, (m, q) by the directions' N(0, I), and (m, m) covariance of the drive's own."""
    left, size, right = np.linalg.svd(slope @ directions, full_matrices=False)
    common = (left * np.minimum(size, np.sqrt(rho))) @ right
    return common, np.asarray(np.eye(len(slope)) - common @ common.T)
