"""Signs of roll rate and pitch rate, to be looked at when those of the angles and accelerations are settled."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from parsers.channels import FloatArray
from parsers.checks.grid import Grid, Together, compare
from parsers.checks.leaning import CANNOT_TELL, told_by
from parsers.checks.signs import SignResult, varied
from parsers.checks.springs import springs_tilt
from parsers.drive import Decision

_MIN_TILT = 0.003
_LEAST = 0.5
_LEAST_PUSHED = 0.6
# rate, its angle, the acceleration behind it, and the sign with which that goes
_RATES = (("roll_rate", "roll", "accel_y", 1), ("pitch_rate", "pitch", "accel_x", -1))


def rate_signs(grid: Grid) -> SignResult:
    """Roll rate and pitch rate against the change of their angles, else of the springs, else of the acceleration behind them."""
    inverted: set[str] = set()
    decisions: list[Decision] = []
    unchecked: list[str] = []
    for rate, angle, push, sense in _RATES:
        if grid.get(rate) is None:
            continue
        said, found = _told(grid, rate, _witnesses(grid, angle, push, sense))
        if found is None:
            unchecked.append(f"sign of {rate}: {said}")
        elif found.sign < 0:
            inverted.add(rate)
            evidence = f"correlation {found.correlation:.2f} over {found.seconds:.0f} s"
            text = f"{rate} has the sign opposite to {said}"
            decisions.append(Decision(rate, "sign", text, "inverted", evidence, applied=True))
    return SignResult(frozenset(inverted), tuple(decisions), tuple(unchecked))


@dataclass(frozen=True)
class _Witness:
    """What a rate may be held against. says: (n,) of the rate. least: correlation from which it tells. by_road: whether roads go into
    it otherwise than into the rate."""

    name: str
    says: FloatArray
    least: float
    by_road: bool


def _told(grid: Grid, rate: str, witnesses: Iterable[_Witness]) -> tuple[str, Together | None]:
    """The first witness with which a rate goes together clearly, and how; else why there is none."""
    turning = grid.columns[rate]
    for each in witnesses:
        found = compare(turning, each.says)
        if found is None or abs(found.correlation) < each.least:
            continue
        if each.by_road and rate == "roll_rate":
            found = told_by(grid, found, (turning, each.says), each.least)
        return (each.name, found) if found else (CANNOT_TELL, None)
    return "the drive moves it too little", None


def _witnesses(grid: Grid, angle: str, push: str, sense: int) -> Iterator[_Witness]:
    tilt, driving = grid.get(angle), grid.get(push)
    springs = springs_tilt(grid, angle) if tilt is None else None
    if tilt is not None and varied(tilt, _MIN_TILT):
        yield _Witness(f"the change of {angle}", grid.rate(tilt), _LEAST, by_road=False)
    if springs is not None and varied(springs, _MIN_TILT):
        said = f"the change of {angle} that the springs show"
        yield _Witness(said, grid.rate(springs), _LEAST, by_road=True)
    if driving is not None and varied(driving, 1.0):
        said = f"the change of {push}" + (" (braking tips the nose down)" if sense < 0 else "")
        yield _Witness(said, sense * grid.rate(driving), _LEAST_PUSHED, by_road=True)
