"""The posterior that a drive's answers are taken from: the relations that count, the springs, tyres and sensors that the drive speaks for."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.special import softmax

from pipelines.evidence import Evidence
from pipelines.joint.channels import WRONG
from pipelines.joint.conflict import Check, check
from pipelines.joint.counted import counted
from pipelines.joint.doubts.carried import BELLOWS, LEVELS
from pipelines.joint.file_check import LOAD, file_check
from pipelines.joint.posterior import Joint, extended, find_mode
from pipelines.joint.vehicle.stated import stated_beside
from pipelines.joint.vehicle.unknowns import Known, before_the_log
from pipelines.joint.ways.bellows_way import TEXT as BELLOWS_TEXT
from pipelines.joint.ways.bellows_way import asked, bellows_ways
from pipelines.joint.ways.channel_ways import channel_ways
from pipelines.joint.ways.file_ways import BRAKE_GAIN, WHEELBASE, file_ways, joined_again
from pipelines.joint.ways.levelled import TEXT as LEVELLED
from pipelines.joint.ways.levelled import as_levelled, levelled_odds, rather_another_load
from pipelines.joint.ways.on_stops import NAME as STOPS
from pipelines.joint.ways.on_stops import TEXT as STOPS_TEXT
from pipelines.joint.ways.on_stops import stop_ways
from pipelines.joint.ways.other_vehicle import NAME as ANOTHER
from pipelines.joint.ways.other_vehicle import STATED_ALL, UNLIKE, least_odds, other_ways, turned_odds
from pipelines.joint.ways.other_vehicle import TEXT as ANOTHER_TEXT
from pipelines.joint.ways.rigid_tyres import CHANCE, rigid, rigid_odds
from pipelines.joint.ways.rigid_tyres import NAME as RIGID
from pipelines.joint.ways.rigid_tyres import TEXT as RIGID_TEXT
from pipelines.joint.ways.slip_way import NAME as SLIPS
from pipelines.joint.ways.slip_way import TEXT as SLIPS_TEXT
from pipelines.joint.ways.slip_way import slip_ways
from pipelines.joint.ways.towed import NAME as TOWED
from pipelines.joint.ways.towed import rather_heavy, towed_text, towed_ways
from pipelines.joint.ways.travel_scale import NAME as SCALED
from pipelines.joint.ways.travel_scale import opened, scale_odds, text_of
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

Modes = list[tuple[FloatArray, FloatArray]]
"""Mean (k,) and covariance (k, k) of each mode, the best first."""

SURE = 0.95
"""Chance with the log from which on rigid tyres, or deflections of a wrong scale, are taken for what there is."""

HEARD = CHANCE
"""Chance with the log up to which it has not spoken for a kind of vehicle or sensor, and the answers are those of the others."""

ASKED = 1e-3
"""Probability of a misfit below which the file is asked for its cause: above it chance, or a model's own error, is likelier."""

BY_FAR = 3.0
"""ln odds up to which two explanations of one thing both stay open."""

UNKNOWN = 0.3
"""Chance that a conflict is of nothing that is asked here: the answers as they were stay in by that."""

APART = 3.0
"""Distance in standard deviations from which on two ends of the search are two modes."""

STARTS = 4

MOVED = ("empty_h", "load_h", "load", "roll_center_front", "roll_inertia")
"""Unknowns that the search is started apart in: heights, where mirror solutions lie."""


@dataclass(frozen=True)
class _Way:
    """Tyres or sensors that are otherwise. odds: ln, over those that are as usual, with the log; joint: the posterior with them.

    known, whole: the unknowns and relations that it was joined with; text: what is said where there is no other way; opened: the group of
    stated figures that are not taken from the file, or the channel whose scale is not taken for known; alone: whether one channel or figure is otherwise, and nothing beside it.
    """

    name: str
    odds: float
    joint: Joint
    known: Known
    whole: tuple[Evidence, ...]
    text: Callable[[Joint], str]
    opened: str = ""
    alone: bool = False


@dataclass(frozen=True)
class Reached:
    """A drive's posterior. kept: the drive's relations; stated: the file's; dropped: (relation, why) of those not counted.

    vehicle and known: with the springs, tyres and deflections that the drive speaks for. checks: each relation against the rest;
    before: the same with tyres that give and a scale that is right. others: chance and posterior each, beside `joint`, where the
    drive leaves open which of them it is. opened: of `joint` and of each of them, the
    group of stated figures that it does not take from the file. found: in words. another: chance that the file is another vehicle's.
    """

    vehicle: Vehicle
    known: Known
    kept: tuple[Evidence, ...]
    stated: tuple[Evidence, ...]
    dropped: tuple[tuple[str, str], ...]
    joint: Joint
    modes: Modes
    checks: tuple[Check, ...]
    before: tuple[Check, ...]
    others: tuple[tuple[float, Joint], ...]
    opened: tuple[str, ...]
    found: tuple[str, ...]
    another: float = 0.0


def _starts(known: Known, rng: np.random.Generator) -> list[FloatArray]:
    """The prior's mean, and points up to two standard deviations off in heights and load."""
    size = len(known.names)
    rows = [known.names.index(n) for n in MOVED]
    found = [np.zeros(size)]
    for _ in range(STARTS - 1):
        start = np.zeros(size)
        start[rows] = rng.uniform(-2, 2, len(rows))
        found.append(start)
    return found


def _modes(evidence: Sequence[Evidence], known: Known, rng: np.random.Generator) -> tuple[Joint, Modes]:
    """The best mode, and all that lie apart from each other: (mean, covariance) each."""
    ends = [find_mode(evidence, known, [start]) for start in _starts(extended(known, evidence), rng)]
    ends.sort(key=lambda end: end.cost)
    best = ends[0]
    modes = [(best.u, best.covariance)]
    for end in ends[1:]:
        away = [float((end.u - u) @ np.linalg.solve(c, end.u - u)) for u, c in modes]
        if end.converged and end.cost < best.cost + 12 and min(away) > APART**2:
            modes.append((end.u, end.covariance))
    return best, modes


def reach(evidence: Sequence[Evidence], vehicle: Vehicle, rng: np.random.Generator) -> Reached | None:
    """Join the relations of one drive with what was known of the vehicle; None where no relation can be used.

    Raises LinAlgError where no vehicle that is known of fits the relations.
    """
    known = before_the_log(vehicle)
    kept, dropped = counted(evidence, known)
    stated = stated_beside(kept, vehicle)
    if not kept:
        return None
    whole, found = (*kept, *stated), []
    joint, modes = _modes(whole, known, rng)
    levelled, raised = as_levelled(joint, vehicle), None
    if levelled is not None and levelled[1]:
        lifted = before_the_log(levelled[0])
        high, ends = _modes(whole, lifted, rng)
        raised = _raised(joint, high, lifted, whole, known, vehicle)
        if raised is not None and _no_trailer(raised, joint, whole, known, vehicle):
            vehicle, known, joint, modes, raised = levelled[0], lifted, high, ends, None
            found.append(LEVELLED)
    checks = before = check(joint)
    plain, left = _weighed(_ways(joint, whole, known, vehicle))
    if left:
        # what looks like tyres or sensors may be the file, and a file's figure something that is not asked
        heard = {way.name for _, way in left}
        plain, left = _weighed(
            [*(way for _, way in left), *_springs_or_file(joint, (kept, stated), known, vehicle, raised)]
        )
        if left and not left[0][1].alone and left[0][1].name not in heard:
            plain, left = _beside_unknown(plain, left)
    elif raised is not None or _unusual(joint, checks, vehicle):
        plain, left = _weighed([*_springs_or_file(joint, (kept, stated), known, vehicle, raised)])
        if not (left and _settles(*left[0], vehicle)):
            plain, left = _beside_unknown(plain, left)
    if left and left[0][0] > SURE:
        left, found = left[:1], [left[0][1].text(left[0][1].joint), *found]
    else:
        words = "{} (odds {:.0%}): the answers hold " + ("both" if len(left) == 1 else "all of them")
        found = [*(words.format(way.name, chance) for chance, way in left), *found]
    opened = ""
    if left and plain <= HEARD:
        (plain, way), *left = left
        known, opened = way.known, way.opened
        if opened == STATED_ALL:
            stated = way.whole[len(kept) :]
        elif opened == WHEELBASE:
            # the length that the road shows, and what goes by it, instead of the file's
            stated = (*stated, *(e for e in way.whole if e.kind == "length"))
        joint, modes = _modes(way.whole, known, rng)
        checks = check(joint)
    total = plain + sum(chance for chance, _ in left)
    another = sum(
        (plain if opened == STATED_ALL else 0.0, *(c for c, way in left if way.opened == STATED_ALL))
    )
    if asked(whole, vehicle):
        # both kinds were joined, each by a fit of its own: no doubt along straight lines beside them
        vehicle = replace(vehicle, axle_load_by="tires")
    return Reached(
        vehicle, known, kept, stated, dropped, joint, modes, checks, before,
        tuple((chance / total, way.joint) for chance, way in left), (opened, *(way.opened for _, way in left)), tuple(found),
        another / total,
    )  # fmt: skip


def _unusual(joint: Joint, checks: Sequence[Check], vehicle: Vehicle) -> bool:
    """Whether the drive turns unlike the file's vehicle, or anything contradicts the rest: then the file is asked for its cause."""
    turns = vehicle.turning is not None and abs(vehicle.turning - 1) > UNLIKE
    return turns or min(c.record.probability for c in (*checks, *file_check(joint, vehicle))) < ASKED


def _weighed(ways: list[_Way]) -> tuple[float, list[tuple[float, _Way]]]:
    """Chance of none of them, and those that are heard with theirs, the likeliest first."""
    plain, *chances = softmax([0.0, *(way.odds for way in ways)]).tolist()
    likely = sorted(zip(chances, ways, strict=True), key=lambda pair: -pair[0])
    return plain, [pair for pair in likely if pair[0] > HEARD]


def _settles(chance: float, way: _Way, vehicle: Vehicle) -> bool:
    """Whether it surely is one channel's scale, without which nothing contradicts the rest any more."""
    if not way.alone or chance <= SURE:
        return False
    return not any(c.in_conflict for c in (*check(way.joint), *file_check(way.joint, vehicle)))


def _beside_unknown(plain: float, left: list[tuple[float, _Way]]) -> tuple[float, list[tuple[float, _Way]]]:
    """The chances, where a conflict may be of something that is none of them: a road that banks, a channel that is another."""
    rest = sum(chance for chance, _ in left)
    if rest == 0 or plain >= UNKNOWN * (plain + rest):
        return plain, left
    return UNKNOWN, [(chance * (1 - UNKNOWN) / rest, way) for chance, way in left]


def _raised(
    joint: Joint, high: Joint, lifted: Known, whole: tuple[Evidence, ...], known: Known, vehicle: Vehicle
) -> _Way | None:
    """Springs that level themselves as one way among others; None where a stated load that is wrong explains the drive better."""
    if rather_another_load(joint, high, whole, known, vehicle):
        return None
    odds = levelled_odds(joint, high, vehicle)
    return _Way(LEVELS, odds, high, lifted, whole, lambda _: LEVELLED, alone=True)


def _perhaps_levelled(
    joint: Joint, whole: tuple[Evidence, ...], known: Known, vehicle: Vehicle
) -> _Way | None:
    """Springs that level themselves, where the drive does not speak for them by itself: one cause among others."""
    levelled = as_levelled(joint, vehicle)
    if levelled is None or levelled[1]:
        return None
    lifted = before_the_log(levelled[0])
    return _raised(joint, joined_again(joint, whole, known, lifted), lifted, whole, known, vehicle)


def _no_trailer(
    raised: _Way, joint: Joint, whole: tuple[Evidence, ...], known: Known, vehicle: Vehicle
) -> bool:
    """Whether springs that level themselves explain by far what a trailer would: mass that follows the torques and that the springs do not show."""
    return all(odds < raised.odds - BY_FAR for odds, *_ in towed_ways(joint, whole, known, vehicle))


def _springs_or_file(
    joint: Joint,
    relations: tuple[tuple[Evidence, ...], tuple[Evidence, ...]],
    known: Known,
    vehicle: Vehicle,
    raised: _Way | None,
) -> Iterator[_Way]:
    """Springs that are none any more under the load, figures of the file that may be wrong, one or all, slips that may be, what is towed,
    and channels of a wrong scale. relations: the drive's, and the file's; raised: springs that level themselves, where the drive speaks for them and it is not settled."""
    kept, stated = relations
    whole = (*kept, *stated)
    raised = raised or _perhaps_levelled(joint, whole, known, vehicle)
    if raised is not None:
        yield raised
    for axle, odds, found, free, seen in stop_ways(joint, whole, known, vehicle):
        yield _Way(STOPS.format(axle), odds, found, free, seen, partial(_on_stops, axle))
    # the road tells the wheelbase by itself, and no other figure with it
    measured, least = any(e.kind == "length" for e in whole), -math.inf
    causes = list[_Way]()
    for title, odds, found, free, joined in file_ways(joint, whole, known, vehicle):
        alone = title in (BRAKE_GAIN, LOAD) or (title == WHEELBASE and measured)
        if title == WHEELBASE:
            least = least_odds(odds, found, known)
        causes.append(
            _Way(f"{title} wrong", odds, found, free, joined, partial(_not_its, title), title, alone)
        )
    for odds, found, unsure in slip_ways(joint, whole, known):
        causes.append(_Way(SLIPS, odds, found, known, unsure, lambda _: SLIPS_TEXT, alone=True))
    for odds, found, free in towed_ways(joint, whole, known, vehicle):
        causes.append(_Way(TOWED, odds, found, free, whole, towed_text, alone=True))
    for name, odds, found, free in channel_ways(joint, whole, known):
        text = partial(_another_channel, name)
        causes.append(_Way(WRONG.format(name), odds, found, free, whole, text, name, alone=True))
    yield from causes
    for odds, found, free, joined in other_ways(joint, kept, stated, known, vehicle):
        told = max(
            odds, least, turned_odds(found, known, vehicle, max((way.odds for way in causes), default=0.0))
        )
        yield _Way(ANOTHER, told, found, free, joined, lambda _: ANOTHER_TEXT, STATED_ALL, alone=True)


def _on_stops(axle: str, _: Joint) -> str:
    return STOPS_TEXT.format(axle)


def _not_its(title: str, _: Joint) -> str:
    return f"{title} wrong: the drive fits no vehicle with what the file states, and was joined with it open"


def _another_channel(name: str, _: Joint) -> str:
    return f"{WRONG.format(name)} (range, gear, unit?): all else contradicts it, and the drive was joined with its scale open"


def _ways(joint: Joint, whole: tuple[Evidence, ...], known: Known, vehicle: Vehicle) -> list[_Way]:
    """What may be otherwise than the drive was joined with, where its relations tell."""
    ways = [
        _Way(BELLOWS, odds, found, free, whole, lambda _: BELLOWS_TEXT)
        for odds, found, free in bellows_ways(joint, whole, known, vehicle)
    ]
    stiff = None if vehicle.real else rigid_odds(joint, whole, known)
    if stiff is not None:
        ways.append(_Way(RIGID, *stiff, rigid(known), whole, lambda _: RIGID_TEXT))
    scaled = scale_odds(joint, whole, known)
    if scaled is not None:
        free, alike = opened(known)
        ways.append(_Way(SCALED, *scaled, free, (*whole, alike), text_of))
    if rather_heavy(joint):
        ways += [
            _Way(TOWED, odds, found, free, whole, towed_text, alone=True)
            for odds, found, free in towed_ways(joint, whole, known, vehicle)
        ]
    return ways
