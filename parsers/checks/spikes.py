"""Values that cannot be: beyond what any road vehicle does, or bursts that no vehicle could follow.

A burst is removed only beyond doubt: it jumps away and back within a few samples, both jumps are larger than the
quantity can change in that time and than anything usual in the same signal. What is removed is never filled in.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.checks.grid import BoolArray
from parsers.checks.wording import show, times
from parsers.drive import Decision, Signal
from parsers.signals import SIGNALS

_MAX_BURST = 5
_USUAL_FACTOR = 20.0
_LONG_STEP_S = 0.5
_CODE_SAMPLES = 10
_MOST_STRAY = 0.2
"""Where more than this share of a signal is impossible, its unit or scale is wrong, and samples are not stray."""
# quantity or signal -> (jump that is always allowed, change per second), SI; generous bounds of road vehicles
_LIMITS: dict[str, tuple[float, float]] = {
    "steering_wheel_angle": (0.7, 25.0),
    "roll": (0.1, 4.0),
    "pitch": (0.1, 4.0),
    "road_grade": (0.15, 1.0),
    "speed": (3.0, 25.0),
    "gps_speed_2d": (3.0, 25.0),
    "gps_speed_3d": (3.0, 25.0),
    "wheel_speed": (5.0, 200.0),
    "yaw_rate": (0.7, 40.0),
    "roll_rate": (1.2, 80.0),
    "pitch_rate": (1.2, 80.0),
    "accel": (80.0, 0.0),
    "brake_pressure": (5e6, 4e8),
    "suspension_deflection": (0.06, 8.0),
    "latitude": (1e-3, 2e-3),
    "longitude": (2e-3, 4e-3),
    "altitude": (100.0, 40.0),
}
_FOUND = (
    ("is beyond what a road vehicle can do", "are beyond what a road vehicle can do"),
    (
        "stands at a value that is reached by an impossible jump: a code for no value",
        "stand at one value that is reached by an impossible jump: a code for no value",
    ),
    (
        "jumps away and back faster than the vehicle can move",
        "jump away and back faster than the vehicle can move",
    ),
)


@dataclass(frozen=True)
class Cleaned:
    """A signal without its impossible samples (None where nothing is left), and what was found."""

    signal: Signal | None
    decisions: tuple[Decision, ...]


def clean(signal: Signal) -> Cleaned:
    """Find impossible samples of one signal. The decisions are written as applied."""
    spec = SIGNALS[signal.name]
    values = signal.values
    beyond = (values < spec.low) | (values > spec.high)
    if beyond.mean() > _MOST_STRAY:
        return Cleaned(signal, (_out_of_range(signal, beyond),))
    code = _code_values(signal, ~beyond)
    rest = ~beyond & ~code
    burst = np.zeros(len(values), dtype=np.bool_)
    for _ in range(2):  # a burst beside a burst shows when the first is gone
        keep = rest & ~burst
        inside = _bursts(signal.name, signal.time_ns[keep], values[keep])
        burst[np.flatnonzero(keep)[inside]] = True
    decisions = [
        _decision(signal, mask, *found)
        for mask, found in zip((beyond, code, burst), _FOUND, strict=True)
        if mask.any()
    ]
    if not decisions:
        return Cleaned(signal, ())
    good = rest & ~burst
    left = replace(signal, time_ns=signal.time_ns[good], values=values[good]) if good.any() else None
    return Cleaned(left, tuple(decisions))


def calm(signal: Signal) -> Signal:
    """A signal without stray values, whatever its unit: for evidence that must not hang on spikes, never for use.

    A sample goes where it is further from the median of itself and its four neighbours than the signal's whole usual
    range, and than anything usual.
    """
    values = signal.values
    if len(values) < 20:
        return signal
    padded = np.concatenate([values[:1], values[:1], values, values[-1:], values[-1:]])
    away = np.abs(values - _median_of_five([padded[k : k + len(values)] for k in range(5)]))
    low, high = np.quantile(values, [0.02, 0.98])
    usual = np.quantile(away, 0.9)
    stray = away > max(12 * float(usual), float(high - low), 1e-9)
    return replace(signal, time_ns=signal.time_ns[~stray], values=values[~stray]) if stray.any() else signal


def _median_of_five(rows: list[FloatArray]) -> FloatArray:
    """Median over five rows by comparisons alone (a sort of every column would cost ten times that)."""
    a, b, c, d, e = rows
    a, b = np.minimum(a, b), np.maximum(a, b)
    d, e = np.minimum(d, e), np.maximum(d, e)
    low, high = np.maximum(a, d), np.minimum(b, e)
    # the median of five is the median of the third value, the larger low and the smaller high
    return np.maximum(np.minimum(low, high), np.minimum(np.maximum(low, high), c))


def _decision(signal: Signal, mask: BoolArray, one: str, many: str) -> Decision:
    bad = signal.values[mask]
    largest = float(bad[np.argmax(np.abs(bad))])
    return Decision(
        signal=signal.name,
        kind="spikes",
        found=f"{times(len(bad), 'sample')} of {signal.name} {one if len(bad) == 1 else many}",
        action="removed, not filled in",
        evidence=f"largest {show(signal.name, largest)}; {mask.sum() / len(mask):.2%} of the samples",
        applied=True,
    )


def _out_of_range(signal: Signal, beyond: BoolArray) -> Decision:
    return Decision(
        signal=signal.name,
        kind="range",
        found=f"most of {signal.name} is beyond what a road vehicle can do: its unit or scale may be wrong",
        action="left as it is; say the unit in a mapping file",
        evidence=f"{beyond.mean():.0%} of the samples, up to {show(signal.name, float(np.abs(signal.values).max()))}",
        applied=False,
    )


def _limits(name: str) -> tuple[float, float] | None:
    for start in sorted(_LIMITS, key=len, reverse=True):
        if name == start or (name.startswith(start + "_") and "unsprung" not in name):
            return _LIMITS[start]
    return None


def _thresholds(name: str, time_ns: IntArray, steps: FloatArray) -> FloatArray | None:
    """What the step between two samples may be at most, shape (n - 1,); infinite across gaps."""
    limits = _limits(name)
    if limits is None or len(steps) < 3:
        return None
    dt = np.diff(time_ns) / 1e9
    usual = _USUAL_FACTOR * float(np.quantile(np.abs(steps), 0.9))
    allowed = np.maximum(limits[0] + limits[1] * dt, usual)
    return np.where(dt > _LONG_STEP_S, np.inf, allowed)


def _bursts(name: str, time_ns: IntArray, values: FloatArray) -> BoolArray:
    """Samples inside bursts of up to `_MAX_BURST` samples, shape (n,)."""
    found = np.zeros(len(values), dtype=np.bool_)
    steps = np.diff(values)
    allowed = _thresholds(name, time_ns, steps)
    if allowed is None:
        return found
    jump = np.abs(steps) > allowed
    if not jump.any():
        return found
    for length in range(1, _MAX_BURST + 1):
        count = len(steps) - length
        if count < 1:
            break
        out, back = steps[:count], steps[length:]
        change = np.abs(values[length + 1 :] - values[: len(values) - length - 1])
        smaller = np.minimum(np.abs(out), np.abs(back))
        hit = jump[:count] & jump[length:] & (out * back < 0) & (change < 0.3 * smaller)
        at = np.flatnonzero(hit)
        for place in range(1, length + 1):
            found[at + place] = True
    return found


def _code_values(signal: Signal, valid: BoolArray) -> BoolArray:
    """Speeds that stand at the signal's largest value, far above all others (255.996 km/h)."""
    mask = np.zeros(len(valid), dtype=np.bool_)
    if SIGNALS[signal.name].quantity != "speed" or int(valid.sum()) < 3:
        return mask
    values = signal.values
    top = float(values[valid].max())
    at_top = valid & (values >= top - 0.3)
    others = values[valid & ~at_top]
    if len(others) < _CODE_SAMPLES or top < 50 or float(np.ptp(values[at_top])) > 0.3:
        return mask
    allowed = _thresholds(signal.name, signal.time_ns[valid], np.diff(values[valid]))
    if allowed is None:
        return mask
    near = np.where(np.isfinite(allowed), allowed, 0.0).max()
    return at_top if top - float(others.max()) > near else mask
