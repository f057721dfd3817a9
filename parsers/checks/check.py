"""All checks of signals against physics, in the order in which they build on each other."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

from parsers.checks.axle_scales import unlike_axles, unlike_sides
from parsers.checks.codes import Span, nines_free, possible, spans_of_codes, without_codes
from parsers.checks.dead_brakes import dead_brakes
from parsers.checks.flat_tops import Limits
from parsers.checks.force_scales import unlike_gains
from parsers.checks.frozen import SPEEDS, frozen
from parsers.checks.grid import Grid, make_grid
from parsers.checks.held import fixes
from parsers.checks.hubs import hub_motion
from parsers.checks.impossible_speed import impossible_speed
from parsers.checks.late import late
from parsers.checks.mounting import judge_signs
from parsers.checks.net_torque import net_torque
from parsers.checks.no_places import no_altitude, no_places
from parsers.checks.offsets import offsets, stuck, weightless
from parsers.checks.scrambled import scrambled
from parsers.checks.sizes import pressure_faults, size_faults
from parsers.checks.slow_speed import slow_speeds
from parsers.checks.speed_scale import speed_scale
from parsers.checks.spikes import calm, clean
from parsers.checks.stray_speed import stray_speed
from parsers.checks.torque_signs import torque_signs
from parsers.checks.travel import wrong_travel
from parsers.checks.travel_range import impossible_travel
from parsers.checks.twins import twins
from parsers.checks.unit_faults import unit_faults
from parsers.checks.upright import not_upright
from parsers.checks.wheel_forces import exchanged_forces
from parsers.checks.wheel_signs import OddWheels, odd_wheels
from parsers.drive import Decision, Signal


@dataclass(frozen=True)
class Checked:
    """signals: as they are used from here on. unchecked: checks that had too little to go by, as sentences. turned: signals
    whose sign was changed."""

    signals: dict[str, Signal]
    decisions: tuple[Decision, ...]
    unchecked: tuple[str, ...]
    turned: tuple[str, ...]


@dataclass(frozen=True)
class Findings:
    """What the checks decided, to be applied to samples in this order.

    factors: signal -> what its values are multiplied by. Then impossible samples go (`parsers.checks.spikes`; spans: the
    ranges, SI, of signals whose codes for "no value" lie in the usual one), and `inverted` signals change their sign. left_out: signals that are not used at all; wild: those of them that are mostly
    beyond what a road vehicle can do, or are something else than their name says. units, spikes, rest: the decisions
    in order, as if all were applied; limits: where signals are cut off, times their factor; `spikes` belong to the samples that were looked at, the others to the whole.
    """

    factors: Mapping[str, float]
    inverted: frozenset[str]
    left_out: frozenset[str]
    units: tuple[Decision, ...]
    spikes: tuple[Decision, ...]
    rest: tuple[Decision, ...]
    unchecked: tuple[str, ...]
    wild: frozenset[str] = frozenset()
    limits: Mapping[str, Limits] = field(default_factory=dict)
    spans: Mapping[str, Span] = field(default_factory=dict)

    def turned(self, used: Iterable[str]) -> tuple[str, ...]:
        """Those of the signals used whose sign is changed."""
        return tuple(sorted(self.inverted.intersection(used)))


def check_signals(
    signals: Mapping[str, Signal], *, fix: bool, units_stated: Mapping[str, bool]
) -> tuple[dict[str, Signal], tuple[Decision, ...]]:
    """The signals and decisions of `check_all`."""
    checked = check_all(signals, fix=fix, units_stated=units_stated)
    return checked.signals, checked.decisions


def check_all(
    signals: Mapping[str, Signal],
    *,
    fix: bool,
    units_stated: Mapping[str, bool],
    units_taken: Mapping[str, float] | None = None,
) -> Checked:
    """Find wrong units, signs, impossible samples, offsets and stuck channels; repair what is beyond doubt.

    units_stated: signal -> whether the log, a profile or a map says its unit (absent: yes). units_taken: signal -> factor to
    SI of the unit that it was taken in (absent: SI). With fix=False the signals come back untouched, and every decision has applied=False. Signals that lose all samples are left out.
    """
    found, work = decide(signals, units_stated, units_taken)
    decisions = (*found.units, *found.spikes, *found.rest)
    if not fix:
        return Checked(dict(signals), as_applied(decisions, fix=False), found.unchecked, ())
    return Checked(work, decisions, found.unchecked, found.turned(work))


def unchecked(signals: Mapping[str, Signal], units_stated: Mapping[str, bool]) -> tuple[str, ...]:
    """Which checks had too little motion to go by, as sentences."""
    return decide(signals, units_stated)[0].unchecked


def as_applied(decisions: Iterable[Decision], *, fix: bool) -> tuple[Decision, ...]:
    """The decisions as they read where they are applied (fix) or only said."""
    if fix:
        return tuple(decisions)
    return tuple(replace(each, action=_undone(each), applied=False) for each in decisions)


def _undone(decision: Decision) -> str:
    return f"left as it is (--no-fix); would be: {decision.action}" if decision.applied else decision.action


def _wheels_put_right(
    work: Mapping[str, Signal], grid: Grid, taken: Mapping[str, float]
) -> tuple[dict[str, Signal], Grid, OddWheels, list[Decision]]:
    """The signals with deflections of the wrong sign turned, the grid of these, what was turned, and what of all signals stands still or
    is of another scale: one fault is told, as it looks like the next. taken: see `check_all`."""
    work = dict(work)
    present = make_grid(fixes(work), grid)
    still = frozen(work, present)
    if not any(each.applied for each in still):
        still += twins(work, present)
    if not any(each.applied for each in still):
        still += impossible_travel(present, taken)
    odd = OddWheels()
    if not any(each.applied for each in still):
        odd = odd_wheels(present)
        still += odd.left_out
    if odd.inverted:
        work = _scaled(work, dict.fromkeys(odd.inverted, -1.0))
        present = make_grid(fixes(work), grid)
    if not any(each.applied for each in still):
        sides = unlike_sides(work, present)
        still += sides
        if not any(each.applied for each in sides):
            still += unlike_axles(work, present) or wrong_travel(work, present)
    return work, present, odd, still + _forces(present, {each.signal for each in still if each.applied})


def _forces(grid: Grid, dead: Collection[str]) -> list[Decision]:
    """Vertical forces that are another wheel's or of another gain. dead: signals that are left out already."""
    if not set(SPEEDS).isdisjoint(dead):
        return []
    exchanged = exchanged_forces(grid, dead)
    return exchanged + unlike_gains(grid, {*dead, *(each.signal for each in exchanged)})


@dataclass(frozen=True)
class _InUnits:
    """Signals in the units that they turned out to have. work: times their `factors`; grid: as they came. told: signal -> whether its unit
    is known. pressure: what is said of the brake pressure alone."""

    work: dict[str, Signal]
    grid: Grid
    told: Mapping[str, bool]
    factors: Mapping[str, float]
    spans: Mapping[str, Span]
    units: list[Decision]
    pressure: list[Decision]


def _in_units(
    signals: Mapping[str, Signal], stated: Mapping[str, bool], taken: Mapping[str, float]
) -> _InUnits:
    """The first of what is decided: everything else compares sizes. stated, taken: see `check_all`."""
    work = {name: signal for name, signal in signals.items() if len(signal.values)}
    quiet = {name: calm(signal) for name, signal in work.items()}
    spans = nines_free(work) | spans_of_codes(quiet, stated)
    grid = make_grid(fixes({name: without_codes(signal, spans.get(name)) for name, signal in quiet.items()}))
    sized, units = size_faults(grid, stated)
    told = {name: stated.get(name, True) or name in sized for name in work}
    factors, more = unit_faults(work, grid.scaled(sized), told, taken)
    units += more
    factors = sized | factors
    units += impossible_speed(grid.scaled(factors), stated, factors)
    pressure = pressure_faults(grid.scaled(factors), stated, units)
    units += [each for each in pressure if not each.applied]
    doubted = {each.signal for each in units if each.kind == "unit"}
    units += speed_scale(grid.scaled(factors), doubted) or stray_speed(grid.scaled(factors), doubted)
    # in the unit that such a signal turned out to have, its codes are beyond the range at any rate
    spans = {name: possible(name, span) for name, span in spans.items() if name not in factors}
    return _InUnits(_scaled(work, factors), grid, told, factors, spans, units, pressure)


def decide(
    signals: Mapping[str, Signal], stated: Mapping[str, bool], taken: Mapping[str, float] | None = None
) -> tuple[Findings, dict[str, Signal]]:
    """What is wrong with signals, and the signals with all of it applied. stated, taken: see `check_all`."""
    taken = taken or {}
    other = slow_speeds(signals) | no_places(signals, stated) | no_altitude(signals, stated)
    if other := other | not_upright(signals):
        # as a speed it would say that rates are in another unit
        return _beside(other, *decide({n: s for n, s in signals.items() if n not in other}, stated, taken))
    return _decide(signals, stated, taken)


def _decide(
    signals: Mapping[str, Signal], stated: Mapping[str, bool], taken: Mapping[str, float]
) -> tuple[Findings, dict[str, Signal]]:
    """`decide`, of signals that are what their names say."""
    first = _in_units(signals, stated, taken)
    work, spikes, wild, limits = _cleaned(first.work, first.spans)
    wild |= {each.signal: each for each in first.pressure if each.applied}
    wild |= {each.signal: each for each in first.units if each.applied and each.kind == "range"}
    wild |= scrambled(work) | hub_motion(work)
    if wild:
        # what they seemed to say of the others' units is worth nothing; what was said of their own is the likeliest reason
        own = {each.signal: each.found for each in first.units if not each.applied}
        wild = {n: replace(d, evidence=f"{d.evidence}; {own[n]}") if n in own else d for n, d in wild.items()}
        return _beside(wild, *decide({n: s for n, s in signals.items() if n not in wild}, stated, taken))
    if (light := weightless(work)) is not None:
        wild[light.signal] = light
        del work[light.signal]
    work, present, odd, still = _wheels_put_right(work, first.grid, taken)
    dead = {each.signal: each for each in still if each.applied}
    if not dead.keys().isdisjoint(SPEEDS):
        # others' units and signs were judged by it
        return _beside(dead, *decide({n: s for n, s in signals.items() if n not in dead}, stated, taken))
    if dead:
        wild |= dead
        work = {name: signal for name, signal in work.items() if name not in dead}
        present = make_grid(fixes(work), first.grid)
    signs = judge_signs(present)
    pushes = torque_signs(work, signs.grid)
    inverted = signs.inverted | {each.signal for each in pushes}
    grid = signs.grid.scaled({each.signal: -1.0 for each in pushes})
    work = _scaled(work, dict.fromkeys(inverted, -1.0))
    idle = stuck(work, grid) + dead_brakes(work, grid)
    twice = net_torque({n: s for n, s in work.items() if n not in {each.signal for each in idle}}, grid)
    wild |= {each.signal: each for each in twice if each.applied}
    rest = [*odd.decisions, *signs.decisions, *pushes]
    rest += [
        *wild.values(),
        *(each for each in (*still, *twice) if not each.applied),
        *idle,
    ]
    left_out = frozenset(wild) | signs.exchanged | {each.signal for each in idle if each.applied}
    rest += late(grid, left_out)
    rest += offsets(grid.without(left_out))
    unsure = (
        # of a signal that is left out nobody asks the sign
        *(text for text in signs.unchecked if text.split(":")[0].removeprefix("sign of ") not in left_out),
        *_unsaid(n for n in work if not first.told[n] and n not in first.factors and n not in left_out),
    )
    findings = Findings(
        first.factors,
        inverted ^ odd.inverted,
        left_out,
        tuple(first.units),
        tuple(spikes),
        tuple(rest),
        unsure,
        frozenset(wild) | signs.exchanged,
        limits,
        first.spans,
    )
    return findings, {name: signal for name, signal in work.items() if name not in left_out}


def _unsaid(unstated: Iterable[str]) -> list[str]:
    """That nobody says these signals' units, in one sentence."""
    if not (names := list(unstated)):
        return []
    many = len(names) > 1
    return [
        f"unit{'s' if many else ''} of {', '.join(names)}: the log does not say {'them' if many else 'it'}"
    ]


def _cleaned(
    signals: Mapping[str, Signal], spans: Mapping[str, Span]
) -> tuple[dict[str, Signal], list[Decision], dict[str, Decision], dict[str, Limits]]:
    """The signals without impossible samples, what was decided of those, of signals that are wild, and where any are cut off."""
    work: dict[str, Signal] = {}
    spikes: list[Decision] = []
    wild: dict[str, Decision] = {}
    limits: dict[str, Limits] = {}
    for name, signal in signals.items():
        cleaned = clean(signal, spans.get(name))
        if cleaned.wild:
            wild[name] = cleaned.decisions[0]
        else:
            spikes += cleaned.decisions
        if cleaned.limits is not None:
            limits[name] = cleaned.limits
        if cleaned.signal is not None:
            work[name] = cleaned.signal
    return work, spikes, wild, limits


def _beside(
    wild: Mapping[str, Decision], found: Findings, work: dict[str, Signal]
) -> tuple[Findings, dict[str, Signal]]:
    """What was found of the other signals, and that some are left out."""
    whole = replace(
        found,
        # one decision may be about several signals
        rest=(*dict.fromkeys(wild.values()), *found.rest),
        left_out=found.left_out | wild.keys(),
        wild=found.wild | wild.keys(),
    )
    return whole, work


def _scaled(signals: Mapping[str, Signal], factors: Mapping[str, float]) -> dict[str, Signal]:
    return {
        name: replace(signal, values=signal.values * factors[name]) if name in factors else signal
        for name, signal in signals.items()
    }
