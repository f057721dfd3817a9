"""Values that cannot be: beyond what any road vehicle does, bursts that no vehicle could follow, or cut off at the end of a range.

A burst is removed only beyond doubt: it jumps away and back within a few samples, both jumps are larger than the
quantity can change in that time and than anything usual in the same signal. What is removed is never filled in.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.checks.codes import Span
from parsers.checks.flat_tops import Limits, flat_tops
from parsers.checks.grid import BoolArray
from parsers.checks.wording import show, times
from parsers.drive import Decision, Signal
from parsers.quantiles import at_least, quantile, spread_at_least
from parsers.signals import SIGNALS

_MAX_BURST = 5
USUAL_SHARE = 0.9
USUAL_FACTOR = 20.0
"""A jump is larger than so many times the step that this share of all steps stays below."""
LONG_STEP_S = 0.5
CODE_RANGE = 0.3
_BLOCK = 8192
_CODE_SAMPLES = 10
CODE_LEAST = 50.0
MOST_STRAY = 0.2
"""Where more than this share of a signal is impossible, its unit or scale is wrong, and samples are not stray."""
STRAY_AT_WORK = 0.02
"""The same of a brake pressure, which is nought most of the time: braking alone shows its unit."""
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
    # a kerb strikes upwards, and leaves less along and across
    "accel_x": (40.0, 0.0),
    "accel_y": (40.0, 0.0),
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
    (
        "stands at its largest value, where the sensor or the recorder cuts it off",
        "stand at its largest value, where the sensor or the recorder cuts it off",
    ),
)


@dataclass(frozen=True)
class Bounds:
    """What is impossible in a signal, by the signal as a whole. SI.

    low, high: its range. code: values from here up stand for "no value" (infinite where there is no such code). usual: a
    step of this size is always possible (infinite where no step is a jump).
    """

    low: float
    high: float
    code: float = np.inf
    usual: float = np.inf


@dataclass
class Tally:
    """How many samples of a signal were looked at, and those that are impossible: beyond the range, code, burst, cut off."""

    total: int = 0
    counts: list[int] = field(default_factory=lambda: [0] * len(_FOUND))
    largest: list[float] = field(default_factory=lambda: [0.0] * len(_FOUND))

    def add(
        self, values: FloatArray, masks: tuple[BoolArray, ...] | None, where: slice = slice(None)
    ) -> None:
        """Count the samples in `where`. masks: as from `impossible`, or `with_cut_off`."""
        self.total += len(values[where])
        for kind, mask in enumerate(masks or ()):
            bad = values[where][mask[where]]
            if len(bad):
                first = not self.counts[kind]
                self.counts[kind] += len(bad)
                large = float(bad[np.argmax(np.abs(bad))])
                if first or abs(large) > abs(self.largest[kind]):
                    self.largest[kind] = large

    def decisions(self, name: str) -> tuple[Decision, ...]:
        """What was found, written as applied."""
        return tuple(
            _decision(name, count, self.total, largest, *words)
            for count, largest, words in zip(self.counts, self.largest, _FOUND, strict=True)
            if count
        )


@dataclass(frozen=True)
class Cleaned:
    """A signal without its impossible samples (None where nothing is left), and what was found.

    wild: whether so much of it is impossible that none of it can be used. limits: where it is cut off, None where it is not."""

    signal: Signal | None
    decisions: tuple[Decision, ...]
    wild: bool = False
    limits: Limits | None = None


def clean(signal: Signal, span: Span | None = None) -> Cleaned:
    """Find impossible samples of one signal. The decisions are written as applied.

    span: its range, where codes within the signal's usual one make it narrower (`parsers.checks.codes`).
    """
    span = span or (SIGNALS[signal.name].low, SIGNALS[signal.name].high)
    bounds = bounds_of(signal, span)
    if bounds is None:
        beyond = _beyond(span, signal.values)
        largest = float(np.abs(signal.values).max())
        return Cleaned(None, (out_of_range(signal.name, float(beyond.mean()), largest),), wild=True)
    masks = impossible(signal.name, bounds, signal.time_ns, signal.values)
    limits = flat_tops(signal.name, signal.values if masks is None else signal.values[possible(masks)])
    every = with_cut_off(masks, signal.values, limits)
    if every is None:
        return Cleaned(signal, ())
    tally = Tally()
    tally.add(signal.values, every)
    good = possible(every)
    left = replace(signal, time_ns=signal.time_ns[good], values=signal.values[good]) if good.any() else None
    return Cleaned(left, tally.decisions(signal.name), limits=limits)


def with_cut_off(
    masks: tuple[BoolArray, ...] | None, values: FloatArray, limits: Limits | None
) -> tuple[BoolArray, ...] | None:
    """The masks of `impossible`, and that of values which are cut off; None where all samples are possible."""
    if limits is None:
        return masks
    none = np.zeros(len(values), dtype=np.bool_)
    return (*(masks or (none, none, none)), limits.reached(values))


def possible(masks: tuple[BoolArray, ...]) -> BoolArray:
    """Which samples no mask is about, (n,)."""
    return np.asarray(~np.logical_or.reduce(masks), dtype=np.bool_)


def bounds_of(signal: Signal, span: Span) -> Bounds | None:
    """What is impossible in a signal; None where so much is beyond its range that the range must be wrong."""
    time_ns, values = signal.time_ns, signal.values
    if float(values.min()) < span[0] or float(values.max()) > span[1]:
        beyond = _beyond(span, values)
        if beyond.mean() > most_stray(signal.name):
            return None
        time_ns, values = time_ns[~beyond], values[~beyond]
    code = _code_from(signal.name, time_ns, values)
    if code < np.inf:
        below = values < code
        time_ns, values = time_ns[below], values[below]
    return Bounds(*span, code, _usual(signal.name, values))


def most_stray(name: str) -> float:
    """Share of a signal that may be impossible with the rest of it being right."""
    return STRAY_AT_WORK if SIGNALS[name].quantity == "pressure" else MOST_STRAY


def _beyond(span: Span, values: FloatArray) -> BoolArray:
    return (values < span[0]) | (values > span[1])


def _usual(name: str, values: FloatArray) -> float:
    """The step that is always possible; infinite where no step of the signal is a jump anyway."""
    limits = step_limits(name)
    if limits is None or len(values) < 4:
        return np.inf
    steps = np.abs(np.diff(values))
    largest = float(steps.max())
    if largest <= limits[0] or largest <= USUAL_FACTOR * at_least(steps, USUAL_SHARE):
        return np.inf
    return USUAL_FACTOR * quantile(steps, USUAL_SHARE)


def impossible(
    name: str, bounds: Bounds, time_ns: IntArray, values: FloatArray
) -> tuple[BoolArray, BoolArray, BoolArray] | None:
    """Samples that cannot be, (n,) each: beyond the range, a code, inside a burst. None where all are possible."""
    if len(values) == 0:
        return None
    inside = float(values.min()) >= bounds.low and float(values.max()) <= min(bounds.high, bounds.code)
    if inside and bounds.usual == np.inf and bounds.code == np.inf:
        return None
    beyond = (values < bounds.low) | (values > bounds.high)
    code = ~beyond & (values >= bounds.code)
    burst = np.zeros(len(values), dtype=np.bool_)
    if bounds.usual < np.inf:
        rest = ~beyond & ~code
        for _ in range(2):  # a burst beside a burst shows when the first is gone
            keep = rest & ~burst
            found = _bursts(name, time_ns[keep], values[keep], bounds.usual)
            burst[np.flatnonzero(keep)[found]] = True
    return (beyond, code, burst) if (beyond | code | burst).any() else None


def calm(signal: Signal) -> Signal:
    """A signal without stray values, whatever its unit: for evidence that must not hang on spikes, never for use.

    A sample goes where it is further from the median of itself and its four neighbours than the signal's whole usual
    range, and than anything usual.
    """
    values = signal.values
    if len(values) < 20:
        return signal
    # so far a sample may be from its neighbours' median at any rate; mostly that is enough to know
    spread = spread_at_least(values, 0.02)
    if 2 * float(np.abs(np.diff(values)).max()) <= spread:
        return signal
    padded = np.concatenate([values[:1], values[:1], values, values[-1:], values[-1:]])
    away = np.empty(len(values))
    for start in range(0, len(values), _BLOCK):
        stop = min(start + _BLOCK, len(values))
        rows = [padded[start + k : stop + k] for k in range(5)]
        np.abs(values[start:stop] - _median_of_five(rows), out=away[start:stop])
    if float(away.max()) <= spread:
        return signal
    if float(away.max()) <= 12 * at_least(away, 0.9):
        return signal
    usual_range = quantile(values, 0.98) - quantile(values, 0.02)
    stray = away > max(12 * quantile(away, 0.9), usual_range, 1e-9)
    return replace(signal, time_ns=signal.time_ns[~stray], values=values[~stray]) if stray.any() else signal


def _median_of_five(rows: list[FloatArray]) -> FloatArray:
    """Median over five rows by comparisons alone (a sort of every column would cost ten times that)."""
    a, b, c, d, e = rows
    a, b = np.minimum(a, b), np.maximum(a, b)
    d, e = np.minimum(d, e), np.maximum(d, e)
    low, high = np.maximum(a, d), np.minimum(b, e)
    # the median of five is the median of the third value, the larger low and the smaller high
    return np.maximum(np.minimum(low, high), np.minimum(np.maximum(low, high), c))


def _decision(name: str, count: int, total: int, largest: float, one: str, many: str) -> Decision:
    return Decision(
        signal=name,
        kind="spikes",
        found=f"{times(count, 'sample')} of {name} {one if count == 1 else many}",
        action="removed, not filled in",
        evidence=f"largest {show(name, largest)}; {count / total:.2%} of the samples",
        applied=True,
    )


def out_of_range(name: str, share: float, largest: float) -> Decision:
    """Said of a signal that is beyond its range for too long. share: 0-1; largest: its largest magnitude."""
    return Decision(
        signal=name,
        kind="range",
        found=f"{'most' if share > 0.5 else 'much'} of {name} is beyond what a road vehicle can do: its unit or scale may be wrong",
        action="left out; say the unit in a mapping file",
        evidence=f"{share:.0%} of the samples, up to {show(name, largest)}",
        applied=True,
    )


def step_limits(name: str) -> tuple[float, float] | None:
    """What a step may be at any rate, and what comes to it per second; None for signals that may jump."""
    for start in sorted(_LIMITS, key=len, reverse=True):
        if name == start or (name.startswith(start + "_") and "unsprung" not in name):
            return _LIMITS[start]
    return None


def _bursts(name: str, time_ns: IntArray, values: FloatArray, usual: float) -> BoolArray:
    """Samples inside bursts of up to `_MAX_BURST` samples, shape (n,)."""
    found = np.zeros(len(values), dtype=np.bool_)
    limits = step_limits(name)
    if limits is None or len(values) < 4:
        return found
    steps = np.diff(values)
    dt = np.diff(time_ns) / 1e9
    # across a gap anything may change
    jump = (np.abs(steps) > np.maximum(limits[0] + limits[1] * dt, usual)) & (dt <= LONG_STEP_S)
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


def _code_from(name: str, time_ns: IntArray, values: FloatArray) -> float:
    """From where a speed's values are a code: its largest value, far above all others (255.996 km/h); else infinite."""
    if SIGNALS[name].quantity != "speed" or len(values) < 3:
        return np.inf
    top = float(values.max())
    if top < CODE_LEAST:
        return np.inf
    others = values[values < top - CODE_RANGE]
    dt = np.diff(time_ns) / 1e9
    short = dt[dt <= LONG_STEP_S]
    steps = np.abs(np.diff(values))
    usual = USUAL_FACTOR * quantile(steps, USUAL_SHARE)
    longest = float(short.max()) if len(short) else np.nan
    return code_from(name, top, float(others.max()) if len(others) else np.nan, len(others), longest, usual)


def code_from(name: str, top: float, below: float, others: int, longest_s: float, usual: float) -> float:
    """As `_code_from`, from figures of the whole signal.

    top: the largest value within the range; below, others: the largest of the values more than CODE_RANGE below it, and
    their number; longest_s: the longest step of at most LONG_STEP_S, NaN where there is none; usual: see `Bounds`.
    """
    limits = step_limits(name)
    if limits is None or others < _CODE_SAMPLES or top < CODE_LEAST:
        return np.inf
    near = 0.0 if np.isnan(longest_s) else max(limits[0] + limits[1] * longest_s, usual)
    return top - CODE_RANGE if top - below > near else np.inf
