"""Do the tyres give? Many simulators' do not, and then roll against the road is roll against the axles.

A tyre's rate is an unknown, but no normal prior of it reaches "infinite": a drive of such a simulator contradicts itself. So the
relations are joined a second time with tyres that give nothing, and the two are compared by what they make of the drive,

    ln odds = cost - cost' + ½ (ln |S'| - ln |S|)

with the costs at both modes (priors in them) and S their covariances (Laplace). Both fits have as many unknowns. Where the odds leave
it open, the answers hold both fits by their chances.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipelines.evidence import Evidence
from pipelines.joint.posterior import Joint, find_mode
from pipelines.joint.vehicle.unknowns import Known

CHANCE = 0.05
"""Chance beforehand that a log comes from a simulator whose tyres do not give."""

STATED_CHANCE, STATED = 0.01, 0.15
"""The same where the vehicle file states the tyres' rate, which then is known to less than STATED of it: authors of rigid tyres have none."""

PULLED = 0.3
"""Prior standard deviations by which a log must have the tyres harder for the second fit to be worth its time."""

STIFFER = 30.0
"""Times the usual rate that stands for rigid: the body's roll on its tyres is then below one per cent of all roll."""

TYRES = "tyre_rate"
NAME = "tyres that do not give"
TEXT = f"{NAME}: the drive fits no others, and was joined with rigid ones"


def rigid(known: Known) -> Known:
    """The unknowns with tyres that give nothing."""
    row = known.index(TYRES)
    mean, std = known.mean.copy(), known.std.copy()
    mean[row] *= STIFFER
    std[row] = 0.05 * mean[row]
    return replace(known, mean=mean, std=std)


def log_odds(soft: Joint, stiff: Joint) -> float:
    """ln odds of the log for rigid tyres over those that give, nothing beforehand in them."""
    sizes = [float(np.linalg.slogdet(j.covariance)[1]) for j in (stiff, soft)]
    return soft.cost - stiff.cost + 0.5 * (sizes[0] - sizes[1])


def rigid_odds(soft: Joint, evidence: Sequence[Evidence], known: Known) -> tuple[float, Joint] | None:
    """ln odds with the log that its tyres give nothing, and the posterior with such. soft: the one with tyres that give.

    None, without a second fit, where no relation knows the tyres' rate, or would have it no harder.
    """
    pulled = soft.u[soft.known.index(TYRES)]
    if pulled < PULLED or not any(TYRES in e.unknowns for e in evidence):
        return None
    stiff = find_mode(evidence, rigid(known), [soft.u])
    row = known.index(TYRES)
    chance = STATED_CHANCE if known.std[row] < STATED * known.mean[row] else CHANCE
    return log_odds(soft, stiff) + math.log(chance / (1 - chance)), stiff


TYRES_PART = 0.18
"""Of the roll against the road, where tyres give: what an angle against the axles lacks."""

OPEN = (0.05, 0.95)
"""Chances of tyres that do not give between which neither kind is left out."""


def tyres_open(joint: Joint, others: Sequence[tuple[float, Joint]]) -> float:
    """Share by which a roll gradient by deflections may be off (standard deviation), the tyres' part of it being there or not.

    others: the other posteriors that were heard, with their chances. Nought where one kind is as good as left out.
    """
    every = ((1 - sum(chance for chance, _ in others), joint), *others)
    rates = [float(j.known.mean[j.known.index(TYRES)]) for _, j in every]
    hard = sum(
        chance for (chance, _), rate in zip(every, rates, strict=True) if rate > 0.5 * STIFFER * min(rates)
    )
    return TYRES_PART * math.sqrt(hard * (1 - hard)) if OPEN[0] < hard < OPEN[1] else 0.0
