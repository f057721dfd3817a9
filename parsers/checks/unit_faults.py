"""Wrong units: the smallest set of known unit mistakes that makes all evidence fit.

Every signal may carry one of the mistakes that loggers make (deg/s published as rad/s, g as m/s², km/h as m/s).
A mistake costs something, the more so where the log states the unit; evidence that does not fit costs more. The
cheapest explanation wins, and is applied only where going back on any of its parts would cost clearly more.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations

from parsers.checks.evidence import Evidence, collect
from parsers.checks.grid import Grid
from parsers.checks.road_wheels import COST, FACTOR, STEERING, road_wheels
from parsers.drive import Decision, Signal
from parsers.signals import SIGNALS
from parsers.units import STANDARD_GRAVITY

_DEG = math.pi / 180
# quantity -> ((factor to SI, what the values are, what they were taken for), …)
_MISTAKES: dict[str, tuple[tuple[float, str, str], ...]] = {
    "acceleration": ((STANDARD_GRAVITY, "g", "m/s²"), (1 / STANDARD_GRAVITY, "m/s²", "g")),
    "angular_rate": ((_DEG, "deg/s", "rad/s"), (1 / _DEG, "rad/s", "deg/s")),
    "angle": ((_DEG, "deg", "rad"), (1 / _DEG, "rad", "deg")),
    "speed": (
        (1 / 3.6, "km/h", "m/s"),
        (3.6, "m/s", "km/h"),
        (0.44704, "mph", "m/s"),
        (1852 / 3600, "knots", "m/s"),
        (1 / 3.6 / 0.44704, "km/h", "mph"),
        (3.6 * 0.44704, "mph", "km/h"),
    ),
}
_SI_TAKEN = ("m/s²", "rad/s", "rad", "m/s")
_COST_STATED = 2.0
_COST_ASSUMED = 1.0
_COST_INVERSE = 0.5
_COST_ALONE = 2.0
_MARGIN = 1.5
_CLOSE = 1.3
_BEARS_OUT = 1.2
_FELT = 0.3
"""Evidence whose penalty changes by less says nothing."""
_LEAST_OF_PAIRS, _LEAST_ALONE = 0.5, 0.8
_WHEELS = "wheels"
_SENSED = ("acceleration", "angular_rate")
_MAX_ROUNDS = 8

Factors = dict[str, float]


@dataclass(frozen=True)
class UnitProblem:
    """What is to be explained. sensors: signals that one sensor gives, and that were taken in one unit, by sensor."""

    evidence: tuple[Evidence, ...]
    choices: Mapping[str, tuple[float, ...]]
    stated: Mapping[str, bool]
    sensors: tuple[tuple[str, ...], ...]

    def cost(self, factors: Factors) -> float:
        """Cost of an explanation."""
        total = sum(each.penalty(factors) for each in self.evidence)
        for sensor in self.sensors:
            used = [factors.get(name, 1.0) for name in sensor]
            for factor in set(used) - {1.0}:
                if sensor == (STEERING,) and factor == FACTOR:
                    total += COST
                    continue
                stated = any(
                    self.stated.get(n, True) for n, f in zip(sensor, used, strict=True) if f == factor
                )
                total += _COST_STATED if stated else _COST_ASSUMED
                total += _COST_INVERSE if factor in (1 / _DEG, 1 / STANDARD_GRAVITY, 3.6) else 0.0
            total += _COST_ALONE * (len(used) - Counter(used).most_common(1)[0][1])
        return total


def unit_faults(
    signals: Mapping[str, Signal], grid: Grid, stated: Mapping[str, bool], taken: Mapping[str, float]
) -> tuple[dict[str, float], list[Decision]]:
    """Factors by which signals must be multiplied, and all decisions (those in doubt are not applied).

    taken: signal -> factor to SI of the unit that it was taken in (absent: SI).
    """
    problem = _problem(signals, grid, stated, taken)
    best = _solve(problem)
    factors: dict[str, float] = {}
    decisions: list[Decision] = []
    changed = [name for name, factor in best.items() if factor != 1.0]
    clear = {name for name in changed if _clear(problem, name, best)}
    for name in changed:
        sure = name in clear and _borne_out(problem, name, best, clear)
        felt = [] if sure or _quantity(name) != "speed" else _felt(problem, name)
        others = {**best, name: 1.0}
        if felt and all(_fits(each, others) for each in felt):
            continue  # what is felt along and across bears the speed out: a path that says otherwise is the poorer witness
        if felt and _fits(felt[0], others):
            decisions += [_not_the_speed(name, felt[0], each) for each in felt[1:]]
            continue
        if name == STEERING and best[name] == FACTOR:
            about = [e for e in problem.evidence if name in e.powers and e.penalty({}) > _FELT]
            decisions.append(road_wheels("; ".join(e.words() for e in about), sure=sure))
            continue
        for signal in _members(name, signals):
            decisions.append(_decision(signal, name, best[name], problem, sure))
            if sure:
                factors[signal] = best[name]
    decisions += _unexplained(problem, best)
    return factors, decisions


def _problem(
    signals: Mapping[str, Signal], grid: Grid, stated: Mapping[str, bool], taken: Mapping[str, float]
) -> UnitProblem:
    evidence = tuple(collect(grid))
    names = {name for each in evidence for name in each.powers}
    by_sensor: dict[tuple[str, str, float], list[str]] = {}
    for name, signal in signals.items():
        quantity = SIGNALS[name].quantity
        axis = quantity in _SENSED and name[:6] in ("accel_", "roll_r", "pitch_", "yaw_ra") and len(name) < 11
        if axis or name in ("roll", "pitch"):
            # one sensor gives its axes in one unit: those that were taken in different ones do not share a mistake
            alike = (signal.group or signal.source, quantity, taken.get(name, 1.0))
            by_sensor.setdefault(alike, []).append(name)
    sensors = [tuple(members) for members in by_sensor.values()]
    sensors += [(name,) for name in sorted(names) if not any(name in sensor for sensor in sensors)]
    named = [name for sensor in sensors for name in sensor]
    flags = {name: stated.get(_members(name, signals)[0], True) for name in named}
    # what was taken for SI because nothing was said cannot be SI that was taken for something else
    # and what the log says is in deg/s was not read as rad/s
    in_si = {name: math.isclose(taken.get(_members(name, signals)[0], 1.0), 1.0) for name in named}
    choices = {
        name: (
            1.0,
            *(
                row[0]
                for row in _MISTAKES[_quantity(name)]
                if (in_si if row[2] in _SI_TAKEN else flags)[name]
            ),
        )
        for name in named
    }
    if STEERING in choices:
        choices[STEERING] = (*choices[STEERING], FACTOR)
    return UnitProblem(evidence, choices, flags, tuple(sensors))


def _quantity(name: str) -> str:
    return "speed" if name == _WHEELS else SIGNALS[name].quantity


def _members(name: str, signals: Mapping[str, Signal]) -> list[str]:
    """The signals behind a name of the problem: the wheels' speeds share one unit."""
    if name == _WHEELS:
        return [each for each in signals if each.startswith("wheel_speed_")]
    return [name]


def _solve(problem: UnitProblem) -> Factors:
    """Cheapest explanation found by changing one signal, one sensor or two signals at a time."""
    best: Factors = dict.fromkeys(problem.choices, 1.0)
    cost = problem.cost(best)
    for _ in range(_MAX_ROUNDS):
        if cost < _COST_ASSUMED:  # no mistake costs less than that
            break
        moves = [({**best, **move}) for move in _moves(problem, best)]
        costs = [problem.cost(move) for move in moves]
        if not costs or min(costs) > cost - 1e-9:
            break
        cost = min(costs)
        best = moves[costs.index(cost)]
    return best


def _moves(problem: UnitProblem, best: Factors) -> Iterator[Factors]:
    """Changes of signals that some misfitting evidence is about, and of those of the same sensor."""
    amiss = {name for each in problem.evidence if each.penalty(best) > _FELT for name in each.powers}
    amiss |= {name for sensor in problem.sensors if amiss & set(sensor) for name in sensor}
    amiss |= {name for name, factor in best.items() if factor != 1.0}
    singles = [{n: factor} for n, factors in problem.choices.items() if n in amiss for factor in factors]
    yield from singles
    for sensor in problem.sensors:
        if len(sensor) > 1 and amiss & set(sensor):
            for factor in problem.choices[sensor[0]]:
                yield dict.fromkeys(sensor, factor)
    for first, second in combinations(singles, 2):
        if first.keys() != second.keys():
            yield first | second


def _clear(problem: UnitProblem, name: str, best: Factors) -> bool:
    """Whether going back on one part of the cheapest explanation would cost clearly more."""
    margin = min(problem.cost({**best, name: other}) for other in _rivals(problem, name, best))
    return margin - problem.cost(best) >= _MARGIN and _close(problem, name, best)


def _felt(problem: UnitProblem, name: str) -> list[Evidence]:
    """What accelerometers say of a speed, where both do: along and then across."""
    about = [each for each in problem.evidence if name in each.powers]
    along = [each for each in about if "accel_x" in each.powers]
    across = [each for each in about if {"accel_y", "yaw_rate"} <= each.powers.keys()]
    return [along[0], across[0]] if along and across else []


def _fits(each: Evidence, factors: Factors) -> bool:
    """Whether a ratio is, with factors of other signals, as near to 1 as no mistake of a speed's unit leaves it."""
    return abs(math.log(each.after(factors))) < math.log(_BEARS_OUT)


def _not_the_speed(name: str, along: Evidence, across: Evidence) -> Decision:
    """What is said where bends contradict a speed that is felt along: the yaw rate or the lateral acceleration is off."""
    return Decision(
        "yaw_rate", "scale", f"{' and '.join(across.powers)} do not fit together, and {name} is right by accel_x",
        "left as it is: say the unit or a factor in a mapping file", f"{across.words()}, expected near 1; {along.words()}", applied=False,
    )  # fmt: skip


def _borne_out(problem: UnitProblem, name: str, best: Factors, clear: Collection[str]) -> bool:
    """Whether evidence asks for a signal's repair: its own, or that of an axis of its sensor that is repaired as it is."""

    def own(each: str) -> bool:
        back = {**best, each: 1.0}
        return any(e.penalty(back) > e.penalty(best) + _FELT for e in problem.evidence if each in e.powers)

    beside = {
        each for sensor in problem.sensors if name in sensor for each in sensor if best[each] == best[name]
    }
    return any(own(each) for each in beside & set(clear)) if not own(name) else True


def _close(problem: UnitProblem, name: str, best: Factors) -> bool:
    """Whether every ratio that should be 1 is within `_CLOSE` of it, and in its range, after the repair.

    A signal against what no signal is behind (the path over ground) counts where it should be 1 within tenths.
    """
    return all(
        each.low <= each.after(best) <= each.high and abs(math.log(each.after(best))) < math.log(_CLOSE)
        for each in problem.evidence
        if name in each.powers
        and (_LEAST_OF_PAIRS if len(each.powers) > 1 else _LEAST_ALONE) < each.low < each.high < 2
    )


def _rivals(problem: UnitProblem, name: str, best: Factors) -> list[float]:
    """The factors that are to be ruled out by their cost: none at all, and those that make ratios come as close to 1.

    km/h, mph and knots lie within a factor of two, which the wide ranges of most ratios let pass.
    """
    others = [other for other in problem.choices[name] if other != best[name]]
    return [other for other in others if other == 1.0 or _close(problem, name, {**best, name: other})]


def _decision(signal: str, name: str, factor: float, problem: UnitProblem, sure: bool) -> Decision:
    _, true, taken = next(row for row in _MISTAKES[SIGNALS[signal].quantity] if row[0] == factor)
    before = [e for e in problem.evidence if name in e.powers and e.penalty({}) > 0.5]
    words = "; ".join(each.words() for each in sorted(before, key=lambda e: -e.penalty({}))[:2])
    by = f"multiplied by {factor:.4g}" if factor >= 1 else f"divided by {1 / factor:.4g}"
    return Decision(
        signal=signal,
        kind="unit",
        found=f"{signal} is in {true}, but was taken for {taken}"
        if sure
        else _perhaps(signal, factor, true, taken),
        action=by if sure else "left as it is: say the unit in a mapping file",
        evidence=words
        or f"the other {'speeds' if name == _WHEELS else 'axes of the same sensor'} are in {true}",
        applied=sure,
    )


def _perhaps(signal: str, factor: float, true: str, taken: str) -> str:
    """A doubt in words. What a log states is not known here, so that of two units other than SI only their factor is."""
    if taken in _SI_TAKEN:
        return f"{signal} may be in {true}, not in {taken}"
    large = f"{1 / factor:.2g} times too large" if factor < 1 else f"{factor:.2g} times too small"
    return f"{signal} may be {large}, as {true} taken for {taken} would be"


def _unexplained(problem: UnitProblem, best: Factors) -> Iterator[Decision]:
    """Ratios that no known mistake explains."""
    for each in problem.evidence:
        if len(each.powers) > 1 and each.penalty(best) > 0.6 * each.cost:
            name = next(iter(each.powers))
            for signal in [name] if name in SIGNALS else ["wheel_speed_fl"]:
                yield Decision(
                    signal=signal,
                    kind="scale",
                    found=f"{' and '.join(each.powers)} do not fit together, and no usual unit mistake explains it",
                    action="left as it is",
                    evidence=f"{each.words()}, expected {each.low:g} to {each.high:g}",
                    applied=False,
                )
