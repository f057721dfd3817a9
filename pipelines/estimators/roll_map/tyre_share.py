"""What tyres add to a roll against the axles: drawn from what is known of them, and weighed by the gyro beside the springs.

An angle from deflections lacks the tyres' part, a sixth of a car's roll. A gyro turns with the whole body: its rate over that of the
springs' angle is 1 / (share of the suspension). Where no gyro tells, tyres that hardly give stay possible: on racing tyres, on
rims, and in many a simulator.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pipelines.estimators.roll_map.answers import Coefficients
from pipelines.estimators.roll_map.posterior import with_discrepancy
from pipelines.results import FloatArray, Prior

BANKED, BANKED_STD = 0.1, 0.2
"""Share of the body's roll in bends that the road's own lean takes off what a gyro sees, where nothing shows more of it: none in town
and in most simulators, a third and more where country roads are banked by 4 to 5 %, which looks like tyres that do not give."""

BANKED_ALONE = (0.05, 0.12)
"""The same where nothing but the gyro tells tyres that give from rigid ones: a wider one would leave the latter their chance beforehand, and
the roll gradient of a simulator with rigid tyres was 25 % off at 4.5 standard deviations."""

IMPOSSIBLE, LEANING, LEANING_STD = 0.93, 0.3, 0.3
"""Gain of the gyro over the springs' own rate below which no tyres, rigid ones neither, explain it: the road leans, and how much is
hardly known (6 % in bends of 3 m/s² is as much as a body rolls), or the deflections show more than there is."""

LEANS, BENDS = 0.97, 0.4
"""Gain below which, and share of bends above which, the gyro is taken to turn with a road that leans: it then tells of neither tyres nor springs."""

BANKED_LAG_S = 0.03
"""s of delay of the springs' roll that bends of a leaning road may look like: it stands for damping, by a times that. On a blind simulator's
country roads drives of 10 minutes had b 4 to 6 below the vehicle's of 6, that is 30 to 45 ms."""

RIGID = 0.1
"""Chance beforehand that tyres do not give in roll, where no vehicle is known."""

RIGID_TOO = {True: 0.0, False: 0.05}
"""The same beside a vehicle's draws, which hold some already, by whether the vehicle file states the tyres' rate."""

FILE_WRONG, OFF = 0.1, 0.35
"""Chance that stated springs and bars are not the vehicle's, and by what share of them they then are off."""

STIFFENS = 0.05
"""How far a load, curved springs and friction take the roll stiffness of a drive from the stated one."""

FEWEST = 100.0
"""Effective draws below which a gyro's gain is one that none of the tyres has, and tells nothing of them."""


def off_banked_roads(
    coefficients: Coefficients, banked_share: float, usual: tuple[float, float] = (BANKED, BANKED_STD)
) -> Coefficients:
    """The gyro's gain as on flat ground, and damping as unsure as such roads leave it.

    A road that leans into its bends turns the body against the horizon the other way than its springs do. What was steered
    on flat ground is quicker than such bends: there a gain below `IMPOSSIBLE` is that of deflections of a wrong scale.
    usual: share that bends of roads take off any other gain, and its spread.
    """
    slow = min(max(banked_share, 0.0), 1.0)
    delayed = np.zeros((len(coefficients.mean), 1))
    delayed[1] = BANKED_LAG_S * slow * coefficients.mean[0]
    mean, covariance = with_discrepancy(
        coefficients.mean, coefficients.covariance, coefficients.prior_mean, coefficients.prior_std, delayed
    )
    coefficients = replace(coefficients, mean=mean, covariance=covariance)
    if "rate_gain" not in coefficients.names:
        return coefficients
    i = coefficients.names.index("rate_gain")
    lean, unsure = (LEANING, LEANING_STD) if coefficients.mean[i] < IMPOSSIBLE else usual
    c, flat = coefficients, np.ones(len(coefficients.mean))
    flat[i] = 1 - lean * slow
    # on flat ground the gain is larger, and so is the weak prior that the fit had of it
    ground = replace(
        c, mean=c.mean / flat, covariance=c.covariance / np.outer(flat, flat), prior_mean=c.prior_mean / flat, prior_std=c.prior_std / flat,
    )  # fmt: skip
    error = np.zeros((len(flat), 1))
    error[i] = unsure * slow * ground.mean[i]
    mean, covariance = with_discrepancy(
        ground.mean, ground.covariance, ground.prior_mean, ground.prior_std, error
    )
    return replace(ground, mean=mean, covariance=covariance)


def turns_with_the_road(coefficients: Coefficients, banked_share: float) -> bool:
    """Whether the gyro's gain is one that a road makes that leans into its bends, and the drive is of such bends."""
    i = coefficients.names.index("rate_gain")
    return bool(banked_share > BENDS and coefficients.mean[i] < LEANS)


def gain_alone(coefficients: Coefficients) -> tuple[float, float]:
    """The gyro's gain and its variance by the data alone, without the fit's weak prior; infinite where they tell nothing."""
    i = coefficients.names.index("rate_gain")
    weak = 1 / coefficients.prior_std[i] ** 2
    whole = 1 / coefficients.covariance[i, i]
    if whole <= weak:
        return float(coefficients.prior_mean[i]), math.inf
    mean = (coefficients.mean[i] * whole - coefficients.prior_mean[i] * weak) / (whole - weak)
    return float(mean), float(1 / (whole - weak))


def by_stated_stiffness(stiffness: FloatArray, stated: Prior) -> FloatArray:
    """Likelihood (n,) of draws by the suspension's roll stiffness that they give, against the stated one, which may be wrong.

    What an angle tells of the stiffness hangs on the mass and the arm of each draw; springs and bars are known better than the arm,
    and the tyres' share of the roll is the springs' stiffness over that of the tyres.
    """
    std = math.hypot(stated.std, STIFFENS * stated.value)
    wide = math.hypot(std, OFF * stated.value)
    away = stiffness - stated.value
    right, wrong = (np.exp(-0.5 * (away / each) ** 2) / each for each in (std, wide))
    return np.asarray((1 - FILE_WRONG) * right + FILE_WRONG * wrong)


def drawn_tyres(
    gain: FloatArray,
    loss: FloatArray,
    coefficients: Coefficients,
    banked_share: float,
    *,
    rigid: float,
    rng: np.random.Generator,
    likely: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Draws (n,) of the gain and of what tyres take off c, as known beforehand, to those after the gyro; some of them rigid.

    rigid: the share that becomes so. likely: (n,) of each draw beside the gyro, None where all are alike.
    """
    none = rng.random(len(gain)) < rigid
    gain, loss = np.where(none, 1.0, gain), np.where(none, 0.0, loss)
    weight = np.ones(len(gain)) if likely is None else likely
    # a gain below `IMPOSSIBLE` is no tyres' doing, so nothing of them
    if "rate_gain" in coefficients.names and (
        coefficients.mean[coefficients.names.index("rate_gain")] >= IMPOSSIBLE
    ):
        seen, variance = gain_alone(off_banked_roads(coefficients, banked_share, BANKED_ALONE))
        by_gyro = weight * np.exp(-0.5 * (gain - seen) ** 2 / variance)
        weight = by_gyro if _enough(by_gyro) else weight
    if weight.min() == weight.max() or not _enough(weight):
        return gain, loss
    rows = rng.choice(len(gain), len(gain), p=weight / weight.sum())
    return gain[rows], loss[rows]


def _enough(weight: FloatArray) -> bool:
    total = float(weight.sum())
    return total > 0 and total**2 >= FEWEST * float(np.sum(weight**2))
