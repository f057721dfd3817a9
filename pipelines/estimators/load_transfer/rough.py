"""What rough roads do to the published filters' figures, which their own covariance leaves out."""

from __future__ import annotations

import math

import numpy as np

from pipelines.estimators.load_transfer.batch import STATIC, fit
from pipelines.estimators.load_transfer.data import StrutData
from pipelines.estimators.load_transfer.noise import quick_part
from pipelines.results import FloatArray

QUICK_HZ = 1.0
QUICK_MASS = 2.0
"""Errors in the vertical acceleration that a mass is learned against shorten the mass by their power over gravity's. Of both force and acceleration
what is quicker than QUICK_HZ may be such."""

GYRATION = 0.37
"""Radius of gyration of bodies in roll over the track."""

APART = 2.0
"""Standard deviations from which a filter's mass contradicts the balance over the whole drive."""


def quick_mass_share(data: StrutData, loads: FloatArray) -> float:
    """Standard deviation of a filter's mass, as a share, from strut forces above 1 Hz. loads (4,): static, N."""
    power = float(np.mean([np.mean(quick_part(data.forces[:, i], data, QUICK_HZ) ** 2) for i in range(4)]))
    return QUICK_MASS * power / float(np.mean(loads)) ** 2


def roll_inertia_doubt(data: StrutData, across: FloatArray, arm: float, track: float) -> float:
    """m by which a roll arm may be off where a model has no I_x p'': what that moment is over m h A_y, squared, of the arm.

    The body that rolls about its axis moves its own accelerometer sideways: both grow with the road, and their product with the square.
    across (n,): lateral force in the road plane, m/s².
    """
    moved = (GYRATION * track) ** 2 * float(np.std(data.roll_acceleration))
    force = max(abs(arm), 0.1) * float(np.std(across))
    return max(abs(arm), 0.1) * (moved / max(force, 1e-6)) ** 2


def apart_from_the_whole_drive(data: StrutData, sprung_n: float, share: float) -> str | None:
    """In words, that the filter's sprung weight contradicts the companion's balance; None where it does not.

    share: the filter's own standard deviation, sensors left out, which both have.
    """
    found = fit(data)
    rows = slice(4 * STATIC, 4 * STATIC + 4)
    whole = float(found.coefficients[STATIC].sum())
    std = math.hypot(share * sprung_n, math.sqrt(max(float(found.covariance[rows, rows].sum()), 0.0)))
    if not abs(sprung_n - whole) > APART * std:
        return None
    return f"the balance over the whole drive has {whole / sprung_n - 1:+.1%} of the sprung mass"
