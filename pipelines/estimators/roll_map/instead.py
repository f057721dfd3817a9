"""Which roll angle is told where the first does not tell the gradient: roads bank and turn an angle against the horizon, and no springs'."""

from __future__ import annotations

from pipelines.prepare.prepared import Prepared
from pipelines.prepare.roll_angle import RollSource
from pipelines.results import Estimate

GRADIENT = "roll_gradient_degpg"

WHOLE = 0.98
"""Share of the rows in which deflections must be there to stand for the angle."""


def tells(estimate: Estimate) -> bool:
    """Whether an answer holds a roll gradient."""
    return estimate.parameters[GRADIENT].status != "not_identifiable"


def beside_horizon(ranked: tuple[RollSource, ...], prepared: Prepared) -> bool:
    """Whether the first angle is against the horizon, and the next one that of the springs, there nearly always."""
    if len(ranked) < 2 or ranked[0].against != "horizon" or ranked[1].kind != "deflections":
        return False
    return prepared.share_of(ranked[1].angle) > WHOLE
