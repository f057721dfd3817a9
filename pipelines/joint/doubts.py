"""What if something that was taken for known is otherwise? Each such doubt by its own chance, as the log makes it.

A doubt replaces the prior of a few unknowns R, N(0, I) in prior standard deviations, by N(m, V): a stated figure that is wrong (V
wide), or a kind of physics that the log does not have (m elsewhere, V narrow). With the posterior's own mode u and covariance S,

    P = S_RR⁻¹ - I + V⁻¹,     v = P⁻¹ (S_RR⁻¹ u_R + V⁻¹ m)
    2 ln B = v' P v - u_R' S_RR⁻¹ u_R - m' V⁻¹ m - ln |P| - ln |S_RR| + ln |V⁻¹|

B is the log's odds for it over what was known, and B times its odds beforehand its weight w beside all others. A parameter
with gradient g, c = S_RR⁻¹ S_R: g, moves by c' (v - u_R) under it, its variance by c' (P⁻¹ - S_RR) c: it is told with the mean and
the variance over all of them. A doubt that the log does not see moves a parameter by its small odds; one that it speaks for,
by all it is worth.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Protocol

import numpy as np

from pipelines.evidence import Evidence
from pipelines.joint.channels import WRONG, channels_of
from pipelines.joint.file_check import BARS, LOAD, of_any, stated_unknowns
from pipelines.joint.no_bars import NOT_LOOKED_UP, bars_not_looked_up
from pipelines.joint.suspension import levelled_n, loaded_rate
from pipelines.joint.unknowns import AXLES, BY_SPRINGS, CORNERS, SPRINGS_CARRY, Known
from pipelines.results import FloatArray
from pipelines.vehicles.axle_loads import by_springs
from pipelines.vehicles.kinds import kind_of, usual_load
from pipelines.vehicles.kinematics import spring_curve
from pipelines.vehicles.vehicle import Vehicle

WRONG_FILE = 0.015
"""Chance beforehand that a stated figure (or a pair that belongs together), or a channel's scale, is wrong by several of its own spreads."""

OFTEN_WRONG = {"stated mass": 0.05, "stated spring rates": 0.05, LOAD: 0.05}
"""The same of what data sheets mean in several ways: kerb, empty or permitted mass; rates at the spring or at the wheel. Who states where
the CG lies across has weighed the wheels, and who states wheel rates above and below ride height has had them measured at the wheel. And of
a load, which who wrote it down did not drive with."""

SIMPLE = 0.25
"""Chance beforehand that a log comes from a simple model, which leaves each piece of physics out or not, as a coin falls."""

BARE = 0.1
"""Chance beforehand that it has wheel loads by m a h / L, as textbooks do: wheels and gravity out, the rest as a coin falls."""

LEVELLED = {"car": 0.003, "carrier": 0.03, "heavy": 0.4}
"""Chance beforehand that springs level themselves (air, by valve or compressor) where the vehicle file is silent: half of them at both
axles, half at the rear one."""
LEVELS = "springs that level themselves, so that deflections tell no load"

BELLOWS = "axle loads that are what the springs carry"

WHEELS, UPRIGHT = "wheels that take no torque to spin up", "no gravity that tips a pitched body"
LEAN, HUBS = "no gravity that tips a leaning body", "no braked wheels' inertia in the springs"
SELDOM, COIN = 0.1, 0.5
"""Chance that a simple model leaves out weight that tips a leaning body, where the springs tell (what the accelerometer reads and the
springs have nothing of is an author's mistake rather than his choice), and any other piece, loads by m a h / t among them."""
TYRES = "tyre normal forces"

WEIGHED = 0.005
"""The same of where the CG lies along, in the file of a vehicle whose wheels were weighed."""

WIDER = 5.0
"""A wrong figure's spread over the stated one."""

UNLIKE, FARTHER = 0.06, 2.0
"""Chance that an empty vehicle is unlike the measured ones of its kind, and its CG height's spread over theirs then: about the lines by
style and mass the measured heights lie as Student's law of 7 degrees of freedom has it, three of theirs beyond three spreads for one of
a normal law's."""

BETWEEN = " and "
Figures = Mapping[str, tuple[float, float]]
"""Unknowns by name: where they are, and how surely; SI."""

PATCH, GAIN = "patch_lag", "axle_pitch_gain"
PATCH_SIDE, LEAN_PATH, HUBS_PAST = "patch_side", "lean_path", "hubs_past"

NAMED = 0.7
"""Weight from which on a doubt is named."""

HEARD = 1e-6
"""Weight up to which a doubt moves nothing."""


class Place(Protocol):
    """A posterior: its unknowns, u (k,) in prior standard deviations with covariance (k, k), and the relations behind it."""

    @property
    def known(self) -> Known:
        """The unknowns."""

    @property
    def u(self) -> FloatArray:
        """The mode."""

    @property
    def covariance(self) -> FloatArray:
        """Of u."""

    @property
    def evidence(self) -> Sequence[Evidence]:
        """The relations; empty where they have no unknowns of their own."""


@dataclass(frozen=True)
class Doubt:
    """Another prior of the unknowns `names`. mean: (r,); precision: (r, r); both in prior standard deviations."""

    text: str
    names: tuple[str, ...]
    mean: FloatArray
    precision: FloatArray
    chance: float


@dataclass(frozen=True)
class Weighed:
    """A doubt after the log. weight: its share of all; rows: of its unknowns; gain: (r, k), S_RR⁻¹ S_R:; moved: (r,), v - u_R;
    spread: (r, r), P⁻¹ - S_RR."""

    doubt: Doubt
    weight: float
    rows: tuple[int, ...]
    gain: FloatArray
    moved: FloatArray
    spread: FloatArray

    def on(self, gradient: FloatArray) -> tuple[float, float]:
        """Shift and change of the variance of a parameter with gradient (k,)."""
        c = self.gain @ gradient
        return float(c @ self.moved), float(c @ self.spread @ c)


def chance_wrong(title: str, vehicle: Vehicle) -> float:
    """Chance beforehand that stated figures are wrong: as data sheets are, or as rigs are where the file holds what only those find."""
    if title == "stated spring rates" and all(spring_curve(vehicle.quantities, axle) for axle in AXLES):
        return WRONG_FILE
    if vehicle.get("cg_lateral_offset_m") is not None:
        weighed = {"stated mass": WRONG_FILE, "stated place of the CG": WEIGHED}
        return weighed.get(title, OFTEN_WRONG.get(title, WRONG_FILE))
    return OFTEN_WRONG.get(title, WRONG_FILE)


def _file_doubts(joint: Place, vehicle: Vehicle) -> list[Doubt]:
    """Every stated figure: each of a pair by itself, and both wrong alike. A load that is not the stated one is any that such vehicles carry."""
    found = []
    for title, names in stated_unknowns(vehicle).items():
        text, chance = f"{title} wrong", chance_wrong(title, vehicle)
        if title == LOAD:
            kilos = float(joint.known.mean[joint.known.index("empty_mass")])
            usual = usual_load(vehicle, kilos)
            anywhere = {
                n: (float(joint.known.mean[joint.known.index(n)]), of_any(joint.known, n)) for n in names[1:]
            }
            found.append(_physics(text, joint.known, {"load": (usual.mean, usual.std), **anywhere}, chance))
        elif title == BARS and (bars := bars_not_looked_up(joint.known, vehicle)):
            found.append(_physics(text, joint.known, bars, NOT_LOOKED_UP))
        else:
            found += _wider(text, names, chance)
    return found


def _wider(text: str, names: tuple[str, ...], chance: float) -> list[Doubt]:
    """Unknowns that lie wider about what was known: all alike, or each by itself."""
    size = len(names)
    alike = np.full((size, size), 1 / size)
    ways = [np.eye(size) - (1 - WIDER**-2) * alike]
    if size > 1:
        ways.append(np.eye(size) * WIDER**-2)
    return [Doubt(text, names, np.zeros(size), precision, chance / len(ways)) for precision in ways]


def _channel_doubts(joint: Place) -> list[Doubt]:
    """Every torque and force of the log: its scale off by several of the spreads that such have."""
    return [
        doubt
        for channel, (scales, _) in channels_of(joint.evidence).items()
        for doubt in _wider(WRONG.format(channel), scales, WRONG_FILE)
    ]


def _unlike_measured(vehicle: Vehicle) -> list[Doubt]:
    """An empty CG higher or lower than those of measured vehicles, where the vehicle file has none of its own."""
    if vehicle.get("cg_height_m") is not None:
        return []
    text = "an empty CG height unlike those of measured vehicles"
    return [Doubt(text, ("empty_h",), np.zeros(1), np.eye(1) * FARTHER**-2, UNLIKE)]


def _physics(text: str, known: Known, figures: Figures, chance: float) -> Doubt:
    """Unknowns that are elsewhere."""
    rows = [known.index(name) for name in figures]
    value = np.array([figures[name][0] for name in figures])
    spread = np.array([figures[name][1] for name in figures])
    mean = (value - known.mean[rows]) / known.std[rows]
    return Doubt(text, tuple(figures), mean, np.diag((known.std[rows] / spread) ** 2), chance)


def _silent(vehicle: Vehicle, figures: Mapping[str, tuple[str, float]], at: float = 0.0) -> Figures:
    """Unknowns that are nought, or `at`, but for those that the vehicle file states: key -> (unknown, spread)."""
    return {name: (at, spread) for key, (name, spread) in figures.items() if vehicle.get(key) is None}


def _left_out(joint: Place, vehicle: Vehicle) -> dict[str, Figures]:
    """The pieces of physics that simple models leave out, and where their unknowns are then."""
    known = joint.known
    # who had these measured has a vehicle on the road, or a model of all of it
    tyres = vehicle.get("tire_longitudinal_rate_npm") is not None
    pitches = vehicle.get("patch_path_pitch_mprad") is not None
    kilos, radius = (float(known.mean[known.index(n)]) for n in ("empty_mass", "radius"))
    low = 0.02 * radius
    centres = {
        "pitch_center_height_m": ("pitch_center_brake", low),
        "pitch_center_height_drive_m": ("pitch_center_drive", low),
    }
    pieces = {
        WHEELS: {} if tyres else _plain_wheels(known, vehicle),
        UPRIGHT: {} if pitches else _upright(joint),
        LEAN: {} if pitches or tyres or not _asks(joint, LEAN_PATH) else _level(known),
        HUBS: _silent(vehicle, {"wheel_recession_front": (HUBS_PAST, 0.1)}, 1.0)
        if _asks(joint, HUBS_PAST)
        else {},
        # a model with a pitch centre in braking is not without one in driving
        "no anti-dive": _silent(vehicle, centres) if vehicle.get("pitch_center_height_m") is None else {},
        "a roll axis in the ground": _silent(
            vehicle, {f"roll_center_height_{a}_m": (f"roll_center_{a}", low) for a in AXLES}
        ),
        "no unsprung masses": _silent(
            vehicle, {f"unsprung_mass_{a}_kg": (f"unsprung_{a}", 0.002 * kilos) for a in AXLES}
        ),
    }
    return {text: figures for text, figures in pieces.items() if figures}


def _asks(joint: Place, name: str) -> bool:
    """Whether a relation hangs on an unknown."""
    return any(name in e.unknowns for e in joint.evidence)


def _plain_wheels(known: Known, vehicle: Vehicle) -> Figures:
    """Wheels without inertia over patches that stay under them: who leaves one way of a patch out knows none that he does not state."""
    still = {"tire_lateral_rate_npm": (PATCH_SIDE, 0.1 * float(known.std[known.index(PATCH_SIDE)]))}
    return {"wheel_inertia": (0.0, 0.05), PATCH: (0.0, 0.002), **_silent(vehicle, still)}


def _level(known: Known) -> Figures:
    """Springs and loads of tyres by m a h alone: the accelerometer reads gravity's share as the body leans, they have nothing of it."""
    mean = dict(zip(known.names, known.mean.tolist(), strict=True))
    arm = mean["empty_h"] - 0.5 * (mean["roll_center_front"] + mean["roll_center_rear"])
    return {LEAN_PATH: (arm, 0.15 * arm)}


def _upright(joint: Place) -> Figures:
    """Gravity that does not tip the pitched body: the body pitches about its CG.

    Axle loads have the body's pitch as a gain on the force (`axle_pitch_gain`). Against an accelerometer, which reads gravity's
    share, the loads of such a model lie lower by that gain, as if the patches were shifted.
    """
    known = joint.known
    height = float(known.mean[known.index("empty_h")])
    figures: Figures = {"pitch_path": (height, 0.15 * height)}
    if GAIN not in known.names:
        return figures
    gain = float(known.mean[known.index(GAIN)])
    felt = any({GAIN, "offset_x", PATCH} <= {*e.unknowns, *(o.name for o in e.own)} for e in joint.evidence)
    lower = height * gain / (1 + gain)
    more = {PATCH: (-lower, 0.25 * lower)} if felt else {GAIN: (0.0, 0.1 * gain)}
    return {**figures, **more}


def _physics_doubts(joint: Place, vehicle: Vehicle) -> list[Doubt]:
    """Simple authors leave out some pieces, every choice of them alike but for a textbook's."""
    pieces = _left_out(joint, vehicle)
    by_loads = any(e.kind == "roll" and e.carrier == TYRES for e in joint.evidence)
    out = {text: SELDOM if text == LEAN and not by_loads else COIN for text in pieces}
    found = []
    for chosen in (c for n in range(1, len(pieces) + 1) for c in combinations(pieces, n)):
        figures = {name: value for text in chosen for name, value in pieces[text].items()}
        each = {text: chance if text in chosen else 1 - chance for text, chance in out.items()}
        chance = SIMPLE * math.prod(each.values())
        if {WHEELS, UPRIGHT} <= {*chosen}:
            chance += BARE * math.prod(p for text, p in each.items() if text not in (WHEELS, UPRIGHT))
        found.append(_physics(BETWEEN.join(chosen), joint.known, figures, chance))
    return found


def _levelling(joint: Place, vehicle: Vehicle) -> list[Doubt]:
    """Deflections that have nothing to do with the load."""
    if vehicle.self_levelling is not None or vehicle.deflection_zero == "loaded":
        return []
    known = joint.known
    kilos = float(known.mean[known.index("empty_mass")])
    chance, spread = 0.5 * LEVELLED[kind_of(vehicle)], levelled_n(vehicle, kilos)

    def law(name: str) -> tuple[float, float]:
        row = known.index(name)
        return float(known.mean[row]), float(known.std[row])

    both = {f"zero_{wheel}": (0.0, spread) for wheel in CORNERS}
    both |= {f"spring_{a}": loaded_rate(a, law(f"spring_{a}"), law("load"), kilos) for a in AXLES}
    rear = {name: both[name] for name in ("zero_rl", "zero_rr", "spring_rear")}
    return [_physics(LEVELS, known, figures, chance) for figures in (both, rear)]


def _bellows(joint: Place, vehicle: Vehicle) -> list[Doubt]:
    """Axle loads that lack what the links carry in braking and driving."""
    if vehicle.axle_load_by is not None or not any(BY_SPRINGS in e.unknowns for e in joint.evidence):
        return []
    return [_physics(BELLOWS, joint.known, {BY_SPRINGS: SPRINGS_CARRY}, by_springs(vehicle))]


def _beside(doubt: Doubt, place: Doubt) -> Doubt:
    """Both at once, of unknowns that they do not share."""
    size = len(doubt.names), len(place.names)
    precision = np.zeros((sum(size), sum(size)))
    precision[: size[0], : size[0]] = doubt.precision
    precision[size[0] :, size[0] :] = place.precision
    mean = np.concatenate([doubt.mean, place.mean])
    return Doubt(doubt.text, (*doubt.names, *place.names), mean, precision, doubt.chance * place.chance)


def _weigh(joint: Place, doubt: Doubt, place: Doubt) -> tuple[float, Weighed]:
    """ln B, with the load's place beside it, and the doubt's effect, its weight not yet known."""
    both = _beside(doubt, place)
    rows = [joint.known.index(name) for name in both.names]
    spread, mode = joint.covariance[np.ix_(rows, rows)], joint.u[rows]
    inner = np.linalg.inv(spread)
    precision = inner - np.eye(len(rows)) + both.precision
    pull = both.precision @ both.mean
    after = np.linalg.inv(precision)
    moved = after @ (inner @ mode + pull)
    quadratic = moved @ precision @ moved - mode @ inner @ mode - both.mean @ pull
    sizes = [float(np.linalg.slogdet(m)[1]) for m in (both.precision, precision, spread)]
    gain = inner @ joint.covariance[rows]
    weighed = Weighed(
        replace(doubt, chance=both.chance), 0.0, tuple(rows), gain, moved - mode, after - spread
    )
    return 0.5 * float(quadratic + sizes[0] - sizes[1] - sizes[2]), weighed


def _load_places(known: Known) -> list[Doubt]:
    """Where the load may lie; nothing where that is one place."""
    return [_physics("", known, place.figures, place.chance) for place in known.places]


NOTHING = Doubt("", (), np.zeros(0), np.zeros((0, 0)), 1.0)
"""No doubt; no place."""


def doubts_of(joint: Place, vehicle: Vehicle, opened: str = "") -> tuple[Weighed, ...]:
    """All doubts with what the log makes of them. At most one is true: their weights and that of none sum to 1.

    Each is there as often as there are places for the load, and none of them too: what stays for the posterior as it is is nothing then.
    opened: a group of stated figures (`stated_unknowns`) that the posterior does not take from the file, or a channel whose scale it does not take
    for known: of that there is none.
    """
    doubts = [
        d
        for d in (
            *_file_doubts(joint, vehicle),
            *_unlike_measured(vehicle),
            *_channel_doubts(joint),
            *_levelling(joint, vehicle),
            *_bellows(joint, vehicle),
            *_physics_doubts(joint, vehicle),
        )
        if not opened or not d.text.startswith(opened)
    ]
    none = max(1 - sum(d.chance for d in doubts), 0.05)
    where = _load_places(joint.known)
    if where:
        doubts.append(replace(NOTHING, chance=none))
    found = [_weigh(joint, d, place) for d in doubts for place in where or [NOTHING]]
    logs = np.array([odds + math.log(w.doubt.chance) for odds, w in found])
    left = -math.inf if where else math.log(none)
    top = max(left, float(logs.max(initial=left)))
    shares = np.exp(logs - top)
    shares /= shares.sum() + math.exp(left - top)
    return tuple(replace(w, weight=float(s)) for s, (_, w) in zip(shares, found, strict=True))


def said(doubts: Sequence[Weighed]) -> tuple[str, ...]:
    """The doubts that the log speaks for, in words."""
    together: dict[str, float] = {}
    for d in doubts:
        for piece in d.doubt.text.split(BETWEEN) if d.doubt.text else ():
            together[piece] = together.get(piece, 0.0) + d.weight
    return tuple(
        f"{text} (odds {weight:.0%} among the causes weighed)"
        for text, weight in together.items()
        if weight > NAMED
    )
