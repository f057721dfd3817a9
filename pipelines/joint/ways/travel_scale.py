"""Do the deflections show the wheels' travel? Sensors at the damper or on a lever, inches, a gain of another range: all are off alike.

A balance sees no more of it than of other spring rates. A gyro that turns with the same body sees the scale by itself; without one the
stated rates and heights alone may contradict it, as far as they are known. The relations are joined a second time, with the scale open,

    s_w ~ N(1, S),    S⁻¹ = W⁻² I + D' C⁻¹ D

with D the differences of the wheels' scales, known as before (C), and W so wide that their mean is open to `OPEN_STD`; and the two fits
are compared as those of rigid tyres are. Z, the mass that the prior lacks as the second factor is none of a prior, is made up for.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipelines.evidence import Evidence, Values
from pipelines.joint.doubts.weighed import WRONG_FILE
from pipelines.joint.posterior import Joint, find_mode
from pipelines.joint.vehicle.unknowns import CORNERS, Known
from pipelines.joint.ways.rigid_tyres import log_odds
from pipelines.results import FloatArray

GYRO_BESIDE_SPRINGS = "gyro and quick spring deflections"
"""Carrier of a roll motion that was seen by both."""

OPEN_STD = 0.25
"""Spread of a wrong scale about 1: a motion ratio, or a range."""

NAMES = tuple(f"scale_{wheel}" for wheel in CORNERS)
NAME = "deflections of a wrong scale"
ALIKE = "deflections that are off alike"
DIFFERENCES = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 1.0, -1.0, 0.0], [0.0, 0.0, 1.0, -1.0]])


def opened(known: Known) -> tuple[Known, Evidence]:
    """The unknowns with the deflections' scale open, and what binds the wheels' scales to each other."""
    rows = [known.index(name) for name in NAMES]
    each = known.std[rows]
    std = known.std.copy()
    std[rows] = OPEN_STD * math.sqrt(len(rows))

    def predict(values: Values) -> FloatArray:
        return np.asarray(DIFFERENCES @ np.array([np.asarray(values[name]) for name in NAMES]))

    spread = DIFFERENCES @ np.diag(each**2) @ DIFFERENCES.T
    alike = Evidence(
        "roll", "vehicle file", ALIKE, "vehicle file", np.zeros(len(DIFFERENCES)), spread, predict, NAMES
    )
    return replace(known, std=std), alike


def _lacking(known: Known, alike: Evidence) -> float:
    """ln of the mass that the open prior lacks: ½ ln |I + W D' C⁻¹ D W|."""
    wide = DIFFERENCES * known.std[[known.index(name) for name in NAMES]]
    precision = wide.T @ np.linalg.solve(alike.covariance, wide)
    return 0.5 * float(np.linalg.slogdet(np.eye(len(NAMES)) + precision)[1])


def scale_odds(right: Joint, evidence: Sequence[Evidence], known: Known) -> tuple[float, Joint] | None:
    """ln odds with the log for deflections of a wrong scale, and the posterior with it open. right: the one with the scale as stated.

    None, without a second fit, where no relation has it.
    """
    if not any(set(NAMES) & {*e.unknowns} for e in evidence):
        return None
    free, alike = opened(known)
    open_ = find_mode([*evidence, alike], free, near=[right.u])
    odds = log_odds(right, open_) + _lacking(free, alike)
    return odds + math.log(WRONG_FILE / (1 - WRONG_FILE)), open_


def shown(joint: Joint) -> float:
    """How much of the travel the deflections show, by a posterior with their scale open."""
    rows = [joint.known.index(name) for name in NAMES]
    return 1 / float(np.mean(joint.known.mean[rows] + joint.known.std[rows] * joint.u[rows]))


def text_of(joint: Joint) -> str:
    """What is said where the drive fits no other."""
    return (
        f"{NAME}: they show some {shown(joint):.2f} of the wheels' travel (levers, units, range?); the drive fits no other, and "
        "was joined with their scale open"
    )
