"""Does an angle change as the gyro about its axis turns? A scale of one of them that is wrong by a factor.

The gyro's integral is the angle's change, whatever the road does under the wheels: both are of one body against the horizon. A roll angle of half
its size halves the roll gradient, with a spread of some per cent, and looks odd nowhere else: stiff vehicles lean so.
Which of the two is wrong the log does not tell, so nothing is repaired, and what hangs on them is no surer than that.

Compared is the change over 0.4 s with the gyro's integral over it (Simpson's rule), which leaves noise and drift out. Filters and late channels
turn the one against the other: beside the gyro stands its derivative, and a channel that lags may be as much smaller as a filter of
first order with that lag makes it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from parsers.checks.grid import CELL_S, Grid, make_grid
from parsers.drive import Decision, Drive
from pipelines.joint.kept import KeptRelations
from pipelines.prepare.block_slope import block_slopes
from pipelines.prepare.decided import decided
from pipelines.results import Estimate, FloatArray, ParameterEstimate
from pipelines.verdict.widened import by_share

USUAL = 0.12
"""What honest sensors, a unit that is askew, and what is left of filters and sampling make the two differ by at most."""
SURE = 5.0
FOLLOWS = 0.97
"""Correlation of the two from which a scale is told: noise of the gyro makes the slope smaller by its square at most."""
LEAST_RADPS = 0.012
"""rms of the gyro beside its derivative: half a degree of roll each way in two seconds comes to twice that."""
TURNS_RADPS = 0.15
"""A body that leans feels that share of its turning about the pitch axis: above it pitch is not compared."""
LATE_CELLS = 4
HALF = 2
SIMPSON = np.array([1.0, 4.0, 2.0, 4.0, 1.0]) / 12
"""Over 2 HALF cells."""

_ROLL = (
    "roll_gradient_degpg", "roll_arm_m", "roll_center_height_m", "cg_height_m", "sprung_cg_height_m", "roll_stiffness_nmprad",
    "roll_damping_nmsprad", "roll_damping_ratio", "roll_natural_frequency_hz", "roll_inertia_kgm2",
)  # fmt: skip
_PITCH = ("pitch_arm_m", "cg_height_m", "sprung_cg_height_m", "pitch_inertia_kgm2")
HANG_ON_IT = {"roll": frozenset(_ROLL), "pitch": frozenset(_PITCH)}
BY_ANGLE = {
    "roll": frozenset(
        ("roll_map", "gpc_bayesian_map", "marginalized_particle_filter", "brake_roll_batch", "integrated_observer")
    ),
    "pitch": frozenset(("load_balance",)),
}  # fmt: skip
"""Estimators that read the angle, or the gyro in its place. All others take turning accelerations alone from the gyro."""
BY_TURNING = frozenset(("roll_inertia_kgm2", "pitch_inertia_kgm2"))
"""What hangs on the gyro whoever tells it."""


@dataclass(frozen=True)
class AngleDoubt:
    """axis: "roll" or "pitch". off: by what share of itself what hangs on the two may be wrong. found, evidence: as in `Decision`."""

    axis: str
    off: float
    found: str
    evidence: str

    @property
    def decision(self) -> Decision:
        """As it stands in the import record: nothing was done about it."""
        action = (
            f"left as it is: the log does not tell which of them is wrong; results of {self.axis} are marked"
        )
        return Decision(self.axis, "unit", self.found, action, self.evidence, applied=False)

    def hangs(self, name: str, sources: Collection[str]) -> bool:
        """Whether a parameter that these estimators tell hangs on the two."""
        by = BY_ANGLE[self.axis]
        return name in HANG_ON_IT[self.axis] and (name in BY_TURNING or not by.isdisjoint(sources))


def angle_doubts(drive: Drive) -> tuple[AngleDoubt, ...]:
    """What speaks against the scale of roll, of pitch, or of their gyros."""
    found = (_doubt(drive, axis) for axis in ("roll", "pitch"))
    return tuple(each for each in found if each is not None)


def _ahead(grid: Grid, values: FloatArray, cells: int) -> FloatArray:
    """(n,) what stands `cells` later; NaN where the log has a gap between."""
    n = len(values)
    at = np.arange(n) + cells
    inside = (at >= 0) & (at < n)
    at = np.clip(at, 0, n - 1)
    whole = np.abs(grid.time_s[at] - grid.time_s - cells * CELL_S) < CELL_S / 2
    return np.where(inside & whole, values[at], np.nan)


def _compared(grid: Grid, axis: str) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
    """The angle's change (n,) and the gyro's mean (n,) over the same 2 HALF cells, rad/s, and what may stand beside them."""
    angle, gyro, yaw = grid.columns[axis], grid.columns[f"{axis}_rate"], grid.get("yaw_rate")
    if axis == "pitch" and yaw is not None:
        gyro = np.where(np.abs(yaw) > TURNS_RADPS, np.nan, gyro)
    change = (_ahead(grid, angle, HALF) - _ahead(grid, angle, -HALF)) / (2 * HALF * CELL_S)
    around = range(-HALF, HALF + 1)
    mean = sum((w * _ahead(grid, gyro, k) for w, k in zip(SIMPSON, around, strict=True)), np.zeros(len(gyro)))
    # a unit that is mounted askew reads some of the turning about its roll axis
    return change, mean, [yaw] if axis == "roll" and yaw is not None else []


def _aligned(grid: Grid, change: FloatArray, mean: FloatArray) -> tuple[float, float, FloatArray] | None:
    """Correlation with the gyro where the angle is moved by whole cells as they go together best, the delay in s, the moved angle's change."""
    best: tuple[float, float, FloatArray] | None = None
    for cells in range(-LATE_CELLS, LATE_CELLS + 1):
        moved = _ahead(grid, change, cells)
        good = np.isfinite(moved) & np.isfinite(mean)
        if int(good.sum()) < 2:
            continue
        a, b = moved[good] - moved[good].mean(), mean[good] - mean[good].mean()
        size = float(np.sqrt(a @ a) * np.sqrt(b @ b))
        if 0 < size < math.inf and (best is None or float(a @ b) / size > best[0]):
            best = (float(a @ b) / size, cells * CELL_S, moved)
    return best


def _doubt(drive: Drive, axis: str) -> AngleDoubt | None:
    """What speaks against one axis' scales; None where they go together, or the drive does not tell."""
    names = (axis, f"{axis}_rate", "yaw_rate")
    signals = {n: drive.signals[n] for n in names if n in drive.signals and len(drive.signals[n].values)}
    if not {axis, f"{axis}_rate"} <= signals.keys() or not all(signals[n].measured for n in names[:2]):
        return None
    grid = make_grid(signals)
    change, mean, beside = _compared(grid, axis)
    if (aligned := _aligned(grid, change, mean)) is None or aligned[0] < FOLLOWS:
        return None
    follows, late, moved = aligned
    bent = grid.rate(mean)
    told = block_slopes(mean, (moved,), np.column_stack([bent, *beside]), LEAST_RADPS)
    lag = block_slopes(bent, (moved,), np.column_stack([mean, *beside]), 0.0)
    if told is None or lag is None:
        return None
    quickness = float(np.nanstd(bent) / np.nanstd(mean))
    ratio = math.hypot(told.values[0], lag.values[0] * quickness)
    late -= lag.values[0] / ratio
    filtered = math.cos(min(abs(late) * quickness, math.pi / 3))
    low, high = (1 - USUAL) * follows**2 * filtered, (1 + USUAL) / filtered
    if max(low - ratio, ratio - high) <= SURE * told.std:
        return None
    text = f"{axis} changes by {ratio:.2f} times what {axis}_rate integrates to: the scale of one of them is wrong"
    evidence = f"slope {ratio:.3f} ± {told.std:.3f} over {told.seconds:.0f} s, correlation {follows:.3f}"
    return AngleDoubt(axis, max(abs(ratio - 1), abs(1 / ratio - 1)), text, evidence)


def with_angle_doubts(drive: Drive, doubts: Sequence[AngleDoubt]) -> Drive:
    """The drive with what was found in its record."""
    return decided(drive, [each.decision for each in doubts])


def kept_as_sure_as_angles(
    kept: KeptRelations | None, doubts: Sequence[AngleDoubt], verdict: Mapping[str, ParameterEstimate]
) -> KeptRelations | None:
    """What a drive leaves for others to be joined with, no surer than the scales that it rests on. verdict: of this drive."""
    if kept is None:
        return None
    sources = {name: verdict[name].sources if name in verdict else () for name in kept.told}
    for doubt in doubts:
        kept = kept.less_sure([name for name, by in sources.items() if doubt.hangs(name, by)], doubt.off)
    return kept


def as_sure_as_angles(
    told: Mapping[str, ParameterEstimate], doubts: Sequence[AngleDoubt], by: str | None = None
) -> dict[str, ParameterEstimate]:
    """Answers, where what hangs on an angle is no surer than its scale. by: the estimator that they are of; None for the verdict."""
    found = dict(told)
    for doubt in doubts:
        for name, entry in told.items():
            if doubt.hangs(name, entry.sources if by is None else (by,)):
                found[name] = by_share(found[name], doubt.off, doubt.found)
    return found


def estimates_as_sure(estimates: Sequence[Estimate], doubts: Sequence[AngleDoubt]) -> list[Estimate]:
    """Each estimator's own answers, no surer than the scales of the angles that it reads."""
    return [
        replace(each, parameters=as_sure_as_angles(each.parameters, doubts, each.estimator))
        for each in estimates
    ]
