"""Does longitudinal acceleration go with the change of speed? A gain of accelerometer or speed that is wrong by a tenth and more.

An accelerometer reads f_x = v' - v_y r + g sin(pitch + grade). What pedals change within some seconds is no grade, and away from bends v_y r is
little; the body dives with what brakes it, which makes the slope of f_x on v' 1.02 to 1.10. Outside of that one of the two scales is
wrong: masses by torque, heights and pitch arms are then off by as much, and nothing else looks odd. Which of the two the log does not
tell (both accelerations against one speed are `parsers.checks.speed_scale`): it is said, and what hangs on it is no surer than that.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from parsers.checks.grid import compare, make_grid
from parsers.checks.motion import smooth, vehicle_speed
from parsers.checks.pedals import quickly
from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.joint.answers import HARDLY
from pipelines.prepare.block_slope import block_slopes
from pipelines.prepare.scale_doubt import ScaleDoubt
from pipelines.results import Estimate, JointVerdict

DIVES = 1.045
"""Slope of honest sensors in the mean, by the body's dive and the wheels' slip: 1.00 to 1.10 on 127 random drives of the plant and 40 of a
blind author's two simulators."""
LOW, HIGH = 0.96, 1.13
"""Slopes between which scales are called right."""
SURE = 3.0
FOLLOWS = 0.97
"""Correlation from which on a scale is told; honest sensors have 0.99 and more. Late channels and half a drive's worth of stray values have less."""
LEAST = 0.3
"""m/s², rms of what pedals change."""
TURNS = 1.5
"""m/s² of turning from which on sideslip takes part."""
MOVES = 2.0
"""m/s."""
NAMES = ("accel_x", "yaw_rate", "speed", *(f"wheel_speed_{wheel}" for wheel in WHEELS))

ALONG = ("pitch", "axle", "longitudinal")
HEIGHTS = ("cg_height_m", "sprung_cg_height_m", "pitch_arm_m", "roll_arm_m", "pitch_inertia_kgm2")
"""Hang on it where a relation of `ALONG` brought them."""
MASSES = (
    "mass_kg",
    "sprung_mass_kg",
    *(f"corner_mass_{wheel}_kg" for wheel in WHEELS),
)
"""The same where forces along the road did."""


def longitudinal_doubt(drive: Drive) -> ScaleDoubt | None:
    """What speaks against the scale of longitudinal acceleration or speed; None where they go together, or the drive does not tell."""
    signals = {n: drive.signals[n] for n in NAMES if n in drive.signals and len(drive.signals[n].values)}
    if "accel_x" not in signals or any(
        d.signal in signals and not d.applied and d.kind in ("sign", "scale") for d in drive.record.decisions
    ):
        return None
    grid = make_grid(signals)
    speed, along, yaw = vehicle_speed(grid), grid.get("accel_x"), grid.get("yaw_rate")
    if speed is None or along is None:
        return None
    driven = np.abs(speed) > MOVES
    if yaw is not None:
        driven &= ~(np.abs(speed * smooth(yaw)) > TURNS)
    change, felt = quickly(grid.rate(smooth(speed))), quickly(smooth(along))
    together = compare(felt, change, driven, centred=False)
    if together is None or together.correlation < FOLLOWS:
        return None
    # slip and dive come with a delay: in part in step with how quickly the change of speed changes
    told = block_slopes(np.where(driven, change, np.nan), (felt,), grid.rate(change)[:, None], LEAST)
    if told is None or max(LOW - told.values[0], told.values[0] - HIGH) <= SURE * told.std:
        return None
    scale = told.values[0] / DIVES
    text = f"accel_x is {scale:.2f} times the change of speed: the scale of one of them is wrong"
    evidence = f"slope {told.values[0]:.3f} ± {told.std:.3f} over {told.seconds:.0f} s, of {LOW} to {HIGH} that diving bodies make"
    return ScaleDoubt(abs(scale - 1), text, evidence, "accel_x", "braking and driving")


def hanging_along(
    estimates: Sequence[Estimate], joint: JointVerdict | None, names: Collection[str]
) -> tuple[str, ...]:
    """Those of the parameters that longitudinal acceleration brought. estimates: with their relations; joint: what each brought."""
    told = {e.title: e.kind for estimate in estimates for e in estimate.evidence}

    def brought(name: str, kinds: Collection[str]) -> bool:
        shares = joint.learned[name].shares if joint is not None and name in joint.learned else ()
        return any(s.bits > HARDLY and told.get(s.relation) in kinds for s in shares)

    return tuple(
        name
        for name in names
        if (name in HEIGHTS and brought(name, ALONG)) or (name in MASSES and brought(name, ("longitudinal",)))
    )
