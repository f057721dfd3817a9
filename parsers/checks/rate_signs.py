"""Signs of roll rate and pitch rate, to be looked at when those of the angles and accelerations are settled."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import Grid, Together, compare
from parsers.checks.leaning import CANNOT_TELL, swift_tells, told_by
from parsers.checks.motion import smooth
from parsers.checks.signs import SignResult, varied
from parsers.checks.springs import springs_tilt
from parsers.drive import Decision

_MIN_TILT = 0.003
_LEAST = 0.5
_LEAST_PUSHED = 0.6
_TURNS_RADPS = 0.05
_LEANS, _SMALL = 0.1, 0.3
"""rad that roads and bodies lean in bends, and share of a pitch rate up to which the turning that a leaning gyro sees of it is nothing: on a
banked circuit of one direction it is most of the pitch rate, and right ones were turned round."""
# rate, its angle, the acceleration behind it, and the sign with which that goes
_RATES = (("roll_rate", "roll", "accel_y", 1), ("pitch_rate", "pitch", "accel_x", -1))


def rate_signs(grid: Grid, untold: Collection[str] = ()) -> SignResult:
    """Roll rate and pitch rate against the change of their angles, else of the springs, else of the acceleration behind them.

    untold: angles, and accelerations, whose own sign nothing told. A rate is not held against such a one: where the rate's own sign is told it tells that of the
    angle, else neither is.
    """
    inverted: set[str] = set()
    decisions: list[Decision] = []
    unchecked: list[str] = []
    told: set[str] = set()
    for rate, angle, push, sense in _RATES:
        if grid.get(rate) is None:
            continue
        said, found = _told(grid, rate, _witnesses(grid, angle, push, sense, untold))
        along = _along(grid, rate, angle) if angle in untold else None
        if found is None and along is not None:
            unchecked.append(f"sign of {rate}: {_both(angle, along)}")
            if along.sign < 0:
                decisions.append(_contradicted(rate, angle, along))
        elif found is None:
            unchecked.append(f"sign of {rate}: {said}")
        else:
            if found.sign < 0:
                inverted.add(rate)
                decisions.append(_inverted(rate, f"{rate} has the sign opposite to {said}", found))
            if along is not None:
                told.add(angle)
            if along is not None and along.sign * found.sign < 0:
                inverted.add(angle)
                text = f"the change of {angle} has the sign opposite to {rate}, which goes with {said}"
                decisions.append(_inverted(angle, text, along))
    return SignResult(frozenset(inverted), tuple(decisions), tuple(unchecked), told=frozenset(told))


def _along(grid: Grid, rate: str, angle: str) -> Together | None:
    """How an angle's change goes with its rate; None where that is not clear."""
    tilt = grid.columns[angle]
    found = compare(grid.columns[rate], grid.rate(tilt)) if varied(tilt, _MIN_TILT) else None
    return found if found is not None and abs(found.correlation) >= _LEAST else None


def _both(angle: str, along: Together) -> str:
    how = "goes with" if along.sign > 0 else "is opposite to"
    return f"it {how} the change of {angle}, and the drive tells neither's own sign"


def _evidence(found: Together) -> str:
    return f"correlation {found.correlation:.2f} over {found.seconds:.0f} s"


def _inverted(name: str, text: str, found: Together) -> Decision:
    return Decision(name, "sign", text, "inverted", _evidence(found), applied=True)


def _contradicted(rate: str, angle: str, along: Together) -> Decision:
    text = f"{rate} has the sign opposite to the change of {angle}"
    action = "left as they are: which of the two is wrong the drive does not tell; say it in a mapping file"
    return Decision(rate, "sign", text, action, _evidence(along), applied=False)


@dataclass(frozen=True)
class _Witness:
    """What a rate may be held against. says: (n,) of the rate. least: correlation from which it tells. by_road: whether roads go into
    it otherwise than into the rate. pushes: whether it is the acceleration behind the rate."""

    name: str
    says: FloatArray
    least: float
    by_road: bool
    pushes: bool = False


def _told(grid: Grid, rate: str, witnesses: Iterable[_Witness]) -> tuple[str, Together | None]:
    """The first witness with which a rate goes together clearly, and how; else why there is none."""
    turning = _off_bends(grid, grid.columns[rate]) if rate == "pitch_rate" else grid.columns[rate]
    unclear: list[str] = []
    for each in witnesses:
        found = _pitched(turning, each) if rate == "pitch_rate" else compare(turning, each.says)
        unclear += [each.name] if found is not None else []
        if found is None or abs(found.correlation) < each.least:
            if each.pushes and (swiftly := swift_tells(turning, each.says)) is not None:
                return each.name, swiftly
            continue
        if each.by_road and rate == "roll_rate":
            found = told_by(grid, found, (turning, each.says), each.least)
        return (each.name, found) if found else (CANNOT_TELL, None)
    if not unclear:
        return "the drive moves it too little", None
    return (
        f"it goes clearly with nothing that would tell it ({', '.join(unclear)}): other things turn it, as roads do",
        None,
    )


def _off_bends(grid: Grid, turning: FloatArray) -> FloatArray:
    """A pitch rate (n,) without bends, where a gyro that leans by φ sees ψ' sin φ of the turning, if that may be much of it."""
    yaw = grid.get("yaw_rate")
    if yaw is None or _LEANS * _rms(yaw) < _SMALL * _rms(turning):
        return turning
    return np.where(np.abs(smooth(yaw)) > _TURNS_RADPS, np.nan, turning)


def _rms(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite**2))) if len(finite) else 0.0


def _pitched(turning: FloatArray, witness: _Witness) -> Together | None:
    """How a pitch rate goes with a witness: as they are, where what is slower than half a second does not say otherwise, else by that.

    A stiff vehicle pitches at several Hz, where a tenth of a second turns signs round, and an accelerometer above the pitch axis feels it.
    """
    whole, slow = compare(turning, witness.says), compare(smooth(turning), smooth(witness.says))
    if whole is None or slow is None or abs(slow.correlation) < witness.least:
        return whole if slow is None or whole is None or slow.sign == whole.sign else slow
    return whole if whole.sign == slow.sign and abs(whole.correlation) >= witness.least else slow


def _witnesses(grid: Grid, angle: str, push: str, sense: int, untold: Collection[str]) -> Iterator[_Witness]:
    tilt, driving = (None if name in untold else grid.get(name) for name in (angle, push))
    springs = springs_tilt(grid, angle) if tilt is None else None
    if tilt is not None and varied(tilt, _MIN_TILT):
        yield _Witness(f"the change of {angle}", grid.rate(tilt), _LEAST, by_road=False)
    if springs is not None and varied(springs, _MIN_TILT):
        said = f"the change of {angle} that the springs show"
        yield _Witness(said, grid.rate(springs), _LEAST, by_road=True)
    if driving is not None and varied(driving, 1.0):
        said = f"the change of {push}" + (" (braking tips the nose down)" if sense < 0 else "")
        yield _Witness(said, sense * grid.rate(driving), _LEAST_PUSHED, by_road=True, pushes=True)
