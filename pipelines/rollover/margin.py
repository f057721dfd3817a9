"""The rollover coefficient over a drive with all that is uncertain about it, and how near each side came to lifting.

(*) of `limits` is linear in what is drawn once the drive's columns are known, so that one small matrix of draws and one
matrix of columns give the coefficient of every draw at every time.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from pipelines.prepare.prepared import BoolArray
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray, ParameterEstimate, Trace
from pipelines.rollover.body import Body
from pipelines.rollover.draws import LEVELS, SEED, summary
from pipelines.rollover.lean import SWING_STD
from pipelines.rollover.limits import SIDES, rollover_coefficient
from pipelines.rollover.motion import SCALE_STD, Motion
from pipelines.rollover_results import TurnMargin, TurnSide

FAR = 5.0
"""Rows whose coefficient is this many standard deviations below the drive's peak cannot hold any draw's peak."""

BLOCK = 4096
MOST_NEAR = 200_000
"""Rows that are looked at for a draw's peak, those that may be highest first: one of a hundred hours lies among so many."""

AT_LIMIT = 0.1
"""Weight of the drives that reach the limit, over the even density of those that end below it."""
EXCURSION, LIFTED = 0.8, 1.0
"""Shares moved across between which a side comes near to lifting, and from which its wheels are off."""
TRACE_ROWS, BAND_DRAWS = 1200, 800
LIMIT_SHOWN = 3.0


def columns(motion: Motion, body: Body) -> FloatArray:
    """(n, 11): 1, A, phi, (1 + A²) phi, phi''/f_z, psi''/f_z, A |A c|, c |A c|, A (1 + c²), and of phi, phi''/f_z what is guessed.

    c: the coefficient of the nominal body.
    """
    b = body.nominal()
    lateral, roll = motion.lateral, motion.roll
    coefficient = rollover_coefficient(lateral, roll, b.track, b.offset, b.height + b.spin + b.give, b.lever)
    coefficient = np.clip(coefficient + 2 * b.inertia / b.track * motion.roll_acceleration, -1.0, 1.0)
    lifted = np.abs(lateral * coefficient)
    return np.column_stack(
        [
            np.ones(len(lateral)), lateral, roll, (1 + lateral**2) * roll, motion.roll_acceleration,
            motion.yaw_acceleration, lateral * lifted, coefficient * lifted, lateral * (1 + coefficient**2), motion.swing, motion.swing_acceleration,
        ]
    )  # fmt: skip


def coefficients(motion: Motion, body: Body) -> FloatArray:
    """(11, draws): what multiplies `columns` to give the rollover coefficient (160) of every draw, by (*)."""
    rng = np.random.default_rng(SEED + 1)
    count = len(body.height)
    gain = 1 + motion.roll_gain * rng.standard_normal(count)
    if motion.steady:
        gain = gain * body.gradient / np.median(body.gradient)
    scale = 1 + SCALE_STD * rng.standard_normal(count)
    tilt = motion.roll_std * rng.standard_normal(count)
    bias = motion.bias_g * rng.standard_normal(count) - tilt
    swing = SWING_STD * rng.standard_normal(count)
    middle = body.nominal()
    high = body.height + body.spin
    ahead = body.imu_ahead - middle.imu_ahead
    above = (body.imu_above - body.lever) - (middle.imu_above - middle.lever)
    per = 2 / body.track
    rows = [
        body.offset - high * bias - body.lever * tilt,
        -high * scale,
        -body.lever * gain,
        high * (gain - 1),
        body.inertia - high * above,
        high * ahead,
        -body.jacking,
        # the wheels draw inwards by 2 axis / B of the rise, so that the same moment is a larger share
        2 * body.axis / body.track * body.jacking,
        # a wheel that carries 1 + c of its share goes as much further aside, with that load
        -body.give,
        (high - body.lever) * swing,
        body.inertia * swing,
    ]
    # axles that lean on their tyres move the CG on in proportion to the share itself
    return np.asarray(per * np.vstack(rows) * body.model * (1 + 2 * body.tilt / body.track))


def lifted(peak: FloatArray) -> float:
    """Probability that the share moved across reached 1. peak: (draws,) what accelerations say it was at most.

    The share itself cannot pass 1: however hard a vehicle is turned that stays on its wheels, it ends there. So what is
    known of it before is even from 0 to 1 with an atom of AT_LIMIT at 1, and the draws are how far the
    measurement may be off: P = c n(z) / (c n(z) + s N(z)), z = (1 - mean) / s.
    """
    mean, std = float(np.median(peak)), max(float(np.std(peak)), 1e-6)
    z = (1 - mean) / std
    if z < -8:
        return 1.0
    density = math.exp(-0.5 * z * z) / math.sqrt(2 * math.pi) / std
    below = 0.5 * math.erfc(-z / math.sqrt(2))
    return AT_LIMIT * density / (AT_LIMIT * density + below)


def before_lift(centre: FloatArray) -> BoolArray:
    """Rows that say how near a side came: in every excursion all up to the lift, none after it.

    centre: (n,) the share moved across. With a side's wheels off, it is 1 whatever the body does, and what the relation
    says is the error of the tilting body's roll angle.
    """
    kept = np.ones(len(centre), dtype=bool)
    for first, past in runs(centre > EXCURSION):
        beyond = np.flatnonzero(centre[first:past] >= LIFTED)
        if len(beyond):
            kept[first + int(beyond[0]) + 1 : past] = False
    return kept


def peaks(table: FloatArray, factors: FloatArray, side: float) -> tuple[FloatArray, int]:
    """Largest -side x coefficient of every draw over the drive (draws,), and the row of the mean's.

    table: (n, 11) columns; factors: (11, draws).
    """
    mean = factors.mean(axis=1)
    spread = np.cov(factors)
    centre = -side * (table @ mean)
    kept = before_lift(centre)
    std = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", table, spread, table), 0.0))
    near = np.flatnonzero(kept & (centre + FAR * std >= np.max((centre - FAR * std)[kept])))
    if len(near) > MOST_NEAR:
        bound = (centre + FAR * std)[near]
        near = np.sort(near[np.argpartition(bound, -MOST_NEAR)[-MOST_NEAR:]])
    best = np.full(factors.shape[1], -np.inf)
    for start in range(0, len(near), BLOCK):
        block = -side * (table[near[start : start + BLOCK]] @ factors)
        np.maximum(best, block.max(axis=0), out=best)
    return best, int(near[np.argmax(centre[near])])


@dataclass(frozen=True)
class DriveMargin:
    """A drive against one body's draws. table (n, 11), factors (11, draws); peak: side -> (draws,)."""

    motion: Motion
    body: Body
    table: FloatArray
    factors: FloatArray
    peak: dict[TurnSide, FloatArray]
    row: dict[TurnSide, int]

    @property
    def coefficient(self) -> FloatArray:
        """(n,) mean over the draws."""
        return np.asarray(self.table @ self.factors.mean(axis=1))

    @property
    def reached(self) -> dict[TurnSide, float]:
        """Probability that each side's wheels carried nothing at some time."""
        return {side: lifted(values) for side, values in self.peak.items()}

    @property
    def either(self) -> FloatArray:
        """(draws,) the larger of both sides' peaks."""
        return np.maximum(self.peak["left"], self.peak["right"])


def measure(motion: Motion, body: Body) -> DriveMargin:
    """Columns, draws and both sides' peaks."""
    table, factors = columns(motion, body), coefficients(motion, body)
    peak: dict[TurnSide, FloatArray] = {}
    row: dict[TurnSide, int] = {}
    for side, sign in SIDES:
        peak[side], row[side] = peaks(table, factors, sign)
    return DriveMargin(motion, body, table, factors, peak, row)


def _as_acceleration(body: Body, share: FloatArray) -> FloatArray:
    """A share of the coefficient as lateral acceleration in g, by (163)."""
    return np.asarray(share * body.track / (2 * (body.height + body.spin + 2 * body.give)))


def turn_margins(
    found: DriveMargin,
    thresholds: Mapping[TurnSide, ParameterEstimate],
    reached: Mapping[TurnSide, float],
    reason: str,
) -> tuple[TurnMargin, ...]:
    """How near each side came. reached: side -> probability of having lifted."""
    told = found.body.told
    turns = []
    for side, _ in SIDES:
        peak, row = found.peak[side], found.row[side]
        turns.append(
            TurnMargin(
                side, thresholds[side],
                summary("least_margin_g", _as_acceleration(found.body, 1 - peak), told.status, reason, sources=told.sources),
                summary("peak_coefficient", np.minimum(peak, 1.0), told.status, reason, sources=told.sources),
                float(found.motion.time_s[row]), float(found.motion.lateral[row]), reached[side],
            )
        )  # fmt: skip
    return tuple(turns)


def shown_rows(values: FloatArray, segment: FloatArray) -> IntArray:
    """Rows to draw: the least and the greatest of each bucket, the ends of segments; at most about TRACE_ROWS."""
    count = len(values)
    if count <= TRACE_ROWS:
        return np.arange(count, dtype=np.int64)
    bucket = -(-2 * count // TRACE_ROWS)
    whole = count // bucket * bucket
    blocks = values[:whole].reshape(-1, bucket)
    start = np.arange(0, whole, bucket)
    ends = np.flatnonzero(np.diff(segment) != 0)[: TRACE_ROWS // 8]
    rows = [start + blocks.argmin(axis=1), start + blocks.argmax(axis=1), ends, ends + 1, [0, count - 1]]
    return np.asarray(np.unique(np.concatenate(rows)), dtype=np.int64)


def with_gaps(
    time_s: FloatArray, segment: FloatArray, values: dict[str, FloatArray]
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Columns with a NaN row between segments, so that no line crosses a gap."""
    places = np.flatnonzero(np.diff(segment) != 0) + 1
    if len(places) == 0:
        return time_s, values
    middle = 0.5 * (time_s[places - 1] + time_s[places])
    return np.insert(time_s, places, middle), {k: np.insert(v, places, np.nan) for k, v in values.items()}


def traces(found: DriveMargin, from_forces: FloatArray | None) -> tuple[Trace, ...]:
    """Lateral acceleration with both sides' limits at the moment's roll, (163), and the coefficient; with 95 % bands.

    from_forces: (n,) the coefficient by (158), where forces are known.
    """
    motion, body = found.motion, found.body
    rows = shown_rows(found.coefficient, motion.segment)
    some = slice(None, None, max(1, len(body.height) // BAND_DRAWS))
    draws = found.table[rows] @ found.factors[:, some]
    levels = (0.5, *LEVELS)
    middle, low, high = np.quantile(draws, levels, axis=1)
    lateral = motion.lateral[rows]
    margin: dict[str, FloatArray] = {"lateral_acceleration": lateral}
    for side, sign in SIDES:
        left = _as_acceleration(body, np.ones_like(body.height))[some] * (1 + sign * draws)
        for name, apart in zip(("", "_low", "_high"), np.quantile(sign * left, levels, axis=1), strict=True):
            margin[f"limit_{side}{name}"] = np.clip(lateral + apart, -LIMIT_SHOWN, LIMIT_SHOWN)
    share = {"coefficient": middle, "low": low, "high": high}
    if from_forces is not None:
        share["from_forces"] = from_forces[rows]
        share["residual"] = from_forces[rows] - middle
    time_s, segment = motion.time_s[rows], motion.segment[rows]
    margin_time, margin = with_gaps(time_s, segment, margin)
    share_time, share = with_gaps(time_s, segment, share)
    return (
        Trace("rollover margin", margin_time, margin, dict.fromkeys(margin, "g"),
              "Lateral acceleration along the road, and the limits at which the left (+) and the right wheels lift at the moment's body roll."),
        Trace("rollover coefficient", share_time, share, dict.fromkeys(share, ""),
              "Share of the weight moved across: -1 the left wheels carry nothing, +1 the right ones."),
    )  # fmt: skip
