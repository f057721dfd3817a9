"""Codes for "no value" that nothing declares: values that stand apart from all others, where no vehicle can be.

They go before units are judged: a second of 0x7FFF makes a signal large, and says nothing of its unit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.checks.grid import BoolArray
from parsers.drive import Signal
from parsers.signals import SIGNALS

USUAL_MOST: dict[str, float] = {
    "roll": 0.7, "pitch": 0.7, "roll_rate": 2.5, "pitch_rate": 2.5, "yaw_rate": 2.5,
    "steering_wheel_angle": 17.0, "speed": 75.0, "gps_speed_2d": 75.0, "accel_x": 13.0, "accel_y": 13.0,
}  # fmt: skip
"""SI: a drive reaches more at most for moments, and never stands at one and the same value there."""
NINES = frozenset(float(n) for n in (9999, 99_999, 999_999, 32_767, 32_768, 65_535))
"""What loggers write for "no value", either sign: torques and forces may be as large, but not at that one value, apart from all others."""
STAND_S = 0.2
_MOST = 0.5
"""Where more than this share of a signal is said to be a code, it is rather the rest that is odd."""

Span = tuple[float, float]


def code_free(signal: Signal, *, stated: bool) -> Span | None:
    """The range (SI) beyond which all of a signal's values are codes; None where it has none.

    Such values are as far from all others as those spread, or further. Beyond `USUAL_MOST` they stand at one value, too,
    for `STAND_S` or longer at a time; beyond what the signal can be at all they need not, where the log states the unit
    (a wrong unit leads through the values between, a code does not).
    """
    values, spec = signal.values, SIGNALS[signal.name]
    if len(values) < 3:
        return None
    most = USUAL_MOST.get(signal.name, np.inf)
    usual, whole = (max(-most, spec.low), min(most, spec.high)), (spec.low, spec.high)
    if float(values.min()) >= usual[0] and float(values.max()) <= usual[1]:
        return None
    if most < np.inf:
        span = _between(values, _beyond(values, usual) & _standing(signal.time_ns, values))
        if span is not None:
            return span
    return _between(values, _beyond(values, whole)) if stated else None


def nines_free(signals: Mapping[str, Signal]) -> dict[str, Span]:
    """The ranges (SI) of torques and forces up to `NINES`, which single samples may be."""
    found = {}
    for name, signal in signals.items():
        if SIGNALS[name].quantity in ("torque", "force") and len(signal.values) > 2:
            ends = float(signal.values.min()), float(signal.values.max())
            nines = [end for end in ends if abs(end) in NINES]
            span = _between(signal.values, np.isin(signal.values, nines)) if nines else None
            if span is not None:
                found[name] = span
    return found


def without_codes(signal: Signal, span: Span | None) -> Signal:
    """A signal without its samples beyond a range."""
    if span is None:
        return signal
    kept = (signal.values >= span[0]) & (signal.values <= span[1])
    return replace(signal, time_ns=signal.time_ns[kept], values=signal.values[kept])


def possible(name: str, span: Span) -> Span:
    """What of a range a signal can be (SI)."""
    return max(span[0], SIGNALS[name].low), min(span[1], SIGNALS[name].high)


def spans_of_codes(signals: Mapping[str, Signal], stated: Mapping[str, bool]) -> dict[str, Span]:
    """`code_free` of each signal that has codes. stated: signal -> whether its unit is known (absent: yes)."""
    found = {name: code_free(each, stated=stated.get(name, True)) for name, each in signals.items()}
    return {name: span for name, span in found.items() if span is not None}


def _beyond(values: FloatArray, span: Span) -> BoolArray:
    return (values < span[0]) | (values > span[1])


def _between(values: FloatArray, codes: BoolArray) -> Span | None:
    """The range up to the codes; None where none or most are codes, or where they adjoin the others."""
    share = float(codes.mean())
    if not 0 < share <= _MOST:
        return None
    rest, code = values[~codes], values[codes]
    low, high = float(rest.min()), float(rest.max())
    if float(np.maximum(code - high, low - code).min()) < high - low:
        return None
    below = float(code[code < low].max(initial=-np.inf))
    above = float(code[code > high].min(initial=np.inf))
    return float(np.nextafter(below, np.inf)), float(np.nextafter(above, -np.inf))


def _standing(time_ns: IntArray, values: FloatArray) -> BoolArray:
    """Which samples belong to a stretch of one and the same value of three samples and `STAND_S` or more, (n,)."""
    starts = np.flatnonzero(np.append(True, values[1:] != values[:-1]))
    counts = np.diff(np.append(starts, len(values)))
    lasting = (time_ns[starts + counts - 1] - time_ns[starts]) / 1e9 >= STAND_S
    return np.repeat(lasting & (counts >= 3), counts)
