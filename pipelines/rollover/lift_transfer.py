"""Lift of a side told from load transfer alone: less sure than tyre forces, and of both wheels together only."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipelines.prepare.spans import runs
from pipelines.results import FloatArray
from pipelines.rollover.lift import LEAST_PROBABILITY, MOST_EVENTS, SHORTEST_S
from pipelines.rollover.limits import SIDES
from pipelines.rollover.margin import lifted
from pipelines.rollover.motion import Motion
from pipelines.rollover_results import TurnSide, WheelLift


def lifts_of_accelerations(
    table: FloatArray,
    factors: FloatArray,
    motion: Motion,
    peak: Mapping[TurnSide, FloatArray],
    weight_n: float | None,
) -> tuple[WheelLift, ...]:
    """Both wheels of a side by load transfer alone: stretches where the coefficient may have reached 1.

    table (n, 11), factors (11, draws) of `margin`; peak: side -> (draws,), to pass by sides that never came near.
    """
    mean, spread = factors.mean(axis=1), np.cov(factors)
    centre = table @ mean
    std = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", table, spread, table), 1e-12))
    period = float(np.median(np.diff(motion.time_s))) if len(motion.time_s) > 1 else 0.0
    found = []
    for side, sign in SIDES:
        if lifted(peak[side]) < LEAST_PROBABILITY:
            continue
        share = -sign * centre
        near = share + 1.645 * std >= 1.0
        for first, past in runs(near):
            if (past - first) * period < SHORTEST_S:
                continue
            best = (-sign * (table[first:past] @ factors)).max(axis=0)
            row = first + int(np.argmax(share[first:past]))
            least = None if weight_n is None else max(0.0, 0.5 * weight_n * (1 - float(share[row])))
            found.append(
                WheelLift(side, "side", float(motion.time_s[first]), (past - first) * period, least,
                          lifted(best), float(motion.lateral[row]), "load transfer with the verdict's parameters")
            )  # fmt: skip
    return tuple(
        sorted((e for e in found if e.probability >= LEAST_PROBABILITY), key=lambda e: e.start_s)[
            :MOST_EVENTS
        ]
    )
