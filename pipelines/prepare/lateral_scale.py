"""Does lateral acceleration go with yaw rate and speed? Scales that differ, a channel that comes late, one that is another.

An accelerometer in a body that leans reads f_y = v r + v_y' + g sin(roll), with v_y' of next to no mean over bends. A gain that is
wrong by a fifth, of accelerometer, gyro or speed, puts every roll gradient and arm off by as much and looks odd nowhere else.
Which of the three is wrong the log does not tell: so it is said, nothing is repaired, and what hangs on it is no surer than that.
"""

from __future__ import annotations

import math

import numpy as np

from parsers.checks.grid import CELL_S, make_grid
from parsers.checks.motion import smooth, vehicle_speed
from parsers.drive import Drive
from parsers.quantiles import median
from pipelines.models.roll import GRAVITY
from pipelines.prepare.block_slope import BLOCK_S, LEAST_BLOCKS, block_slopes
from pipelines.prepare.gravity import LACKS, LEAST_MPS, NAMES, lacks_gravity, tilt_of
from pipelines.prepare.scale_doubt import ScaleDoubt
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

USUAL = 0.08
"""What sideslip, bank and honest sensors make the scales differ by at most."""
LEVEL = 0.05
"""The same where an angle against the horizon shows gravity's part: 115 random drives of the plant gave 0.965 to 1.018."""
GRIPPING = 5.0
"""m/s² of turning up to which that holds: at the limit of grip sideslip grows in step with the lean, and took 8 % away."""
BANKED = 0.7
"""Roads that bank in their bends take that much of what is felt, where no angle against the horizon shows it."""
LEANING = 1.3
"""Without an angle gravity's part is unknown: some 0.1 of it a degree and a half of roll a m/s²."""
LEAST_LATERAL = 0.7
"""m/s², rms: below it offsets and banks outweigh the bends."""
LEAST_LEVEL = 0.3
"""The same where an angle against the horizon shows what banks do."""
FOLLOWS, STRANGE = 0.95, 0.4
"""Correlation with v r from which a scale is told, and below which the channel is something else."""
LATE_CELLS = 8
LATE_MPS = 12.0
"""A unit that sits 2 m from the CG leads or follows by 2 m over the speed: below it that looks like a delay."""
LATE_S, LATE_GAIN = 0.3, 0.01
"""A delay is called one from LATE_S on, where it explains LATE_GAIN more of the correlation than none does."""

HANG_ON_IT = ("roll_gradient_degpg", "roll_arm_m", "cg_height_m", "sprung_cg_height_m")
SURE = 3.0
HEAVY, NO_SCALE = 0.04, 0.4
"""By what share gravity may look larger or smaller by offsets, hills and a unit's own scale; and by what share it is a unit's fault."""
LEAST_SAMPLES = 100
GRAVITYS_PART = 0.12
"""Of lateral acceleration as a body that leans by 7 degrees a g feels it."""


def _correlation(a: FloatArray, b: FloatArray) -> float | None:
    """None where too few cells have both, or one of them stands still: that is no correlation of 0."""
    good = np.isfinite(a) & np.isfinite(b)
    if int(good.sum()) < LEAST_BLOCKS * int(BLOCK_S / CELL_S):
        return None
    a, b = a[good] - a[good].mean(), b[good] - b[good].mean()
    size = math.sqrt(float(a @ a)) * math.sqrt(float(b @ b))
    return float(a @ b) / size if 0 < size < math.inf else None


def _delay(felt: FloatArray, turning: FloatArray) -> tuple[float, float, float] | None:
    """Seconds by which `felt` comes after `turning`, the correlation there, and without a delay.

    None where the log does not tell the correlation at every delay: the right one may be among those that are missing.
    """
    n = len(felt)
    if n <= 2 * LATE_CELLS:
        return None
    inner = slice(LATE_CELLS, n - LATE_CELLS)
    found: dict[int, float] = {}
    for lag in range(-LATE_CELLS, LATE_CELLS + 1):
        together = _correlation(felt[inner], turning[LATE_CELLS - lag : n - LATE_CELLS - lag])
        if together is None:
            return None
        found[lag] = together
    best = max(found, key=found.__getitem__)
    return best * CELL_S, found[best], found[0]


def lateral_doubt(drive: Drive, vehicle: Vehicle) -> ScaleDoubt | None:
    """What speaks against the lateral acceleration, the yaw rate or the speed; None where they go together or are not there."""
    signals = {n: drive.signals[n] for n in NAMES if n in drive.signals and len(drive.signals[n].values)}
    if any(d.kind == "sign" and not d.applied and d.signal in signals for d in drive.record.decisions):
        # with a sign known to be wrong and left so (`--no-fix`), gravity's part counts the wrong way: no scale is to blame
        return None
    if not {"accel_y", "yaw_rate"} <= signals.keys():
        return None
    tilt = tilt_of(signals, "roll", vehicle)
    grid = make_grid(signals | ({"roll": tilt} if tilt is not None else {}))
    speed, yaw, lateral = vehicle_speed(grid), grid.get("yaw_rate"), grid.get("accel_y")
    if speed is None or yaw is None or lateral is None:
        return None
    moving = np.abs(speed) > LEAST_MPS
    felt, turning = np.where(moving, smooth(lateral), np.nan), smooth(speed * yaw)
    lag = _delay(felt, turning)
    if lag is None:
        return None
    there = lag[1]
    if there < STRANGE:
        return _strange(felt, turning, there)
    quick = np.where(np.abs(speed) > LATE_MPS, felt, np.nan)
    late, best, at_once = (_delay(quick, turning) if _moves(quick, turning) else None) or (0.0, 0.0, 0.0)
    if abs(late) >= LATE_S - CELL_S / 2 and best - at_once > LATE_GAIN and best > FOLLOWS:
        side = "after" if late > 0 else "before"
        text = f"accel_y comes {abs(late):.1f} s {side} yaw_rate × speed: one of the channels is late"
        return ScaleDoubt(0.15, text, f"correlation {best:.3f} there, {at_once:.3f} without a delay")
    if there < FOLLOWS:
        return None
    # the sideslip's change lags behind the steering, in part in step with the yaw rate's second derivative (`gravity.shares`)
    turn = grid.rate(smooth(yaw))
    others = np.column_stack([grid.rate(turning), turn, grid.rate(turn)])
    angle = grid.get("roll")
    found = [block_slopes(turning, (felt,), others, LEAST_LATERAL)]
    horizon = tilt is not None and not tilt.source.startswith("derived")
    if angle is not None:
        whole = turning + GRAVITY * np.sin(smooth(angle))
        gripping = np.where(np.abs(turning) < GRIPPING, felt, np.nan) if horizon else felt
        found.append(block_slopes(whole, (gripping,), others, LEAST_LEVEL if horizon else LEAST_LATERAL))
    told = [each for each in found if each is not None]
    if not told:
        return None
    if horizon and found[-1] is not None:
        # gravity's part is known: bends that bank explain nothing
        told, low, high = [found[-1]], 1 - LEVEL, 1 + LEVEL
    else:
        low, high = 1 - USUAL if horizon else BANKED, 1 + USUAL if len(told) > 1 else LEANING
    outside = [max(low - t.values[0], t.values[0] - high, 0.0) - SURE * t.std for t in told]
    if min(outside) <= 0:
        return None
    last = told[-1]
    scale = last.values[0]
    if scale < 1 and horizon and lacks_gravity(drive, vehicle):
        # the same where the body leans with the turning: `with_gravity` gives it back, which is right for either
        return None
    by = "yaw_rate × speed" if found[-1] is None or angle is None else "yaw_rate × speed and gravity's part"
    text = f"accel_y is {scale:.2f} times {by}: the scale of one of them is wrong"
    return ScaleDoubt(abs(scale - 1), text, f"slope {scale:.3f} ± {last.std:.3f} over {last.seconds:.0f} s")


def wrong_weight(drive: Drive) -> ScaleDoubt | None:
    """What an inertial unit says that shows another gravity in the mean than there is; None where it shows that, or its axes are not all there."""
    axes = [drive.signals.get(f"accel_{axis}") for axis in "xyz"]
    values = [each.values[np.isfinite(each.values)] for each in axes if each is not None]
    if len(values) < len(axes) or min(map(len, values)) < LEAST_SAMPLES:
        return None
    weight = math.sqrt(sum(median(each) ** 2 for each in values))
    off = weight / GRAVITY - 1
    if not HEAVY < abs(off) < NO_SCALE:
        return None
    found = f"the accelerations show a gravity of {weight:.2f} m/s² in the mean: their scale is wrong by {off:+.0%}"
    return ScaleDoubt(
        abs(off), found, f"of accel_x, accel_y and accel_z together; {GRAVITY:.2f} m/s² is right"
    )


def _moves(felt: FloatArray, turning: FloatArray) -> bool:
    """Whether both are as large as bends make them, where both are there."""
    both = np.isfinite(felt) & np.isfinite(turning)
    return bool(both.any()) and min(float(np.std(each[both])) for each in (felt, turning)) > LEAST_LATERAL


def _strange(felt: FloatArray, turning: FloatArray, there: float) -> ScaleDoubt | None:
    """Both move as in bends and do not go together: one of them is something else."""
    if not _moves(felt, turning):
        return None
    text = "accel_y does not follow yaw_rate × speed: one of the channels is something else, or another axis"
    return ScaleDoubt(1.0, text, f"correlation {there:.2f} at the best delay")


def left_without_gravity(drive: Drive) -> ScaleDoubt | None:
    """What a lateral acceleration that surely lacks gravity's part, and was left so, makes of results; None for any other."""
    left = (d for d in drive.record.decisions if d.signal == "accel_y" and d.found.endswith(LACKS))
    said = next((d for d in left if not d.applied), None)
    return None if said is None else ScaleDoubt(GRAVITYS_PART, said.found, said.evidence)
