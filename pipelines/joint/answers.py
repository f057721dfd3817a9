"""From the joint posterior to answers: values with intervals, statuses, reasons, and what was learned of each."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.evidence import Evidence, Kind
from pipelines.joint.conflict import Check, held
from pipelines.joint.information import NEVER_NEGATIVE, Spread, bits
from pipelines.joint.no_mass import GIVE_MASS
from pipelines.joint.posterior import Joint
from pipelines.joint.tails import density, freedom_of
from pipelines.parameters import is_positive, spread_text
from pipelines.results import (
    FloatArray,
    Identification,
    Interval,
    Learned,
    NextMeasurement,
    ParameterEstimate,
    Prior,
    Share,
)

GOOD, FAIR = 0.5, 0.75
"""What is left of the 95 % interval before the log, up to which a parameter is identified, and weak."""

GOOD_ALONE: Mapping[str, tuple[float, float]] = {
    "cg_lateral_offset_m": (0.03, 0.1), "roll_center_height_m": (0.012, 0.1)
}  # fmt: skip
"""m: largest spreads for "identified" and "weak" where a share of the value says nothing. Roll centres are some 0.1 m above ground."""

LARGEST: Mapping[str, float] = {
    "mass_kg": 0.035, "sprung_mass_kg": 0.035, "cg_height_m": 0.06, "sprung_cg_height_m": 0.07,
    "cg_to_front_axle_m": 0.05, "roll_stiffness_nmprad": 0.08, "roll_arm_m": 0.08, "roll_inertia_kgm2": 0.12,
    "roll_damping_nmsprad": 0.2, "pitch_arm_m": 0.08, "pitch_inertia_kgm2": 0.12, "drag_area_m2": 0.15,
    "corner_mass_fl_kg": 0.06, "corner_mass_fr_kg": 0.06, "corner_mass_rl_kg": 0.06, "corner_mass_rr_kg": 0.06,
}  # fmt: skip
"""Relative spread beyond which nothing is called identified, however little was known before."""

SAMPLED = 1.07
"""Factor on sampled spreads: on ridges that open out the sampler's came out up to 7 % too narrow (benchmarks/joint_mcmc.py)."""

NARROWER = 0.98
"""Share of what is known up to which a measurement that would follow counts as help."""

HARDLY = 0.05
"""Bits below which a relation is not named, and a parameter counts as not learned."""

SEEN_BY: Mapping[str, tuple[Kind, ...]] = {
    "cg_lateral_offset_m": ("roll",),
    "cg_to_front_axle_m": ("pitch", "axle", "ride"),
    "cg_height_m": ("pitch", "axle", "roll"), "sprung_cg_height_m": ("pitch", "axle", "roll"),
    "roll_arm_m": ("pitch", "axle", "roll"),
    "roll_stiffness_nmprad": ("roll",), "roll_damping_nmsprad": ("roll",), "roll_inertia_kgm2": ("roll",),
    "roll_center_height_m": ("roll",), "pitch_arm_m": ("pitch", "axle"), "pitch_inertia_kgm2": ("pitch", "axle", "ride"),
    "drag_area_m2": ("longitudinal", "pitch"),
}  # fmt: skip
"""The physics that sees a parameter. What a known mass alone makes of it (how much load there is, put where loads are) is
what was known before, however narrow."""

MASS_SEEN_BY: tuple[Kind, ...] = ("vertical", "axle", "longitudinal")
"""The physics that sees a mass: where it is there, nothing of it is missing, whatever it leaves open."""

NOT_LEVEL = (
    "horizon",
    "quick spring deflections",
    "gyro and quick spring deflections",
    "suspension forces in quick motion",
)
"""Carriers of roll that tell changes only: where the body hangs at rest, and so to which side the load lies, they do not see."""

STIFFENED = "roll_stiffness_nmprad"
"""Springs are progressive, or reach their stops: what was known before the log is of a vehicle with the load that is usual, and its
tails are those of loads on the stops. A light load takes them off and shows nothing of the springs: so it goes by spreads."""

LOADED = ("roll_inertia_kgm2", "pitch_inertia_kgm2")
"""Inertias of the vehicle with its load: the empty one's, which a drive may not tell, and the load's, of which a drive that shows the
mass tells most. Before the log they are of the usual load."""

SOURCE = "vehicle file and what is known of the load"
OPENED, MOVED = 1.25, 1.0
"""Spread over that before the log, and standard deviations off it, from which on a drive that narrows nothing leaves open what the file seemed to know:
one of its figures is doubted."""

OF_NO_VEHICLE = "what this drive shows against the vehicle file is of no vehicle"

GRID = 121
NAMED = 3
"""Relations named in a reason; the report's table has all of them."""


NEEDS: Mapping[str, str] = {
    "mass": "it needs suspension deflections with spring rates, suspension or tyre forces, axle loads, or drive and brake "
    "torque with the longitudinal acceleration",
    "height": "it needs braking and accelerating, or cornering, seen by suspension deflections (with spring rates) or by "
    "suspension, tyre or axle forces, or roll against the horizon with a known roll stiffness",
    "place": "it needs suspension deflections with spring rates, or suspension, tyre or axle forces",
    "pitch": "it needs quick braking and accelerating seen by suspension deflections, forces or the pitch rate",
    "drag": "it needs steady driving at several speeds with drive torque",
    "motion": "it needs quick roll motion (0.5-1 Hz steering) with lateral acceleration and roll, roll rate or deflections",
}


@dataclass(frozen=True)
class Told:
    """What the posterior holds of one parameter: mean and spread with all widening, draws where it was sampled.

    inner: the intervals of `INNER`, once the doubts are in.
    """

    value: float
    std: float
    low: float
    high: float
    draws: FloatArray | None
    inner: tuple[Interval, ...] = ()


def _needs(name: str) -> str:
    if name in ("roll_damping_nmsprad", "roll_inertia_kgm2"):
        return NEEDS["motion"]
    if name in ("pitch_inertia_kgm2", "drag_area_m2"):
        return NEEDS["pitch" if "pitch" in name else "drag"]
    if "mass_kg" in name or name.startswith("corner_mass"):
        return NEEDS["mass"]
    return NEEDS["height" if any(w in name for w in ("height", "arm", "stiffness")) else "place"]


def told(
    value: float,
    gradient: FloatArray,
    joint: Joint,
    checks: Sequence[Check],
    factor: float,
    draws: FloatArray | None,
    rough: float,
) -> Told:
    """The parameter's mean and interval: Laplace's, or of draws (n,); widened for contradictions.

    rough: factor on the draws' spread, for what a sampler comes out too narrow by.
    """
    more = held(joint, checks, gradient)
    if draws is None:
        std = math.sqrt(factor**2 * float(gradient @ joint.covariance @ gradient) + more)
        return Told(value, std, value - 1.96 * std, value + 1.96 * std, None)
    mean, own = float(np.mean(draws)), float(np.std(draws))
    wide = math.sqrt((rough * factor) ** 2 + more / max(own, 1e-300) ** 2)
    spread = mean + wide * (draws - mean)
    low, high = (float(q) for q in np.quantile(spread, (0.025, 0.975)))
    return Told(mean, wide * own, low, high, spread)


def left_of(name: str, prior: Spread, std: float, low: float, high: float) -> float:
    """Share of the 95 % interval before the log that an answer's is as wide as; of the spread for a `STIFFENED` one."""
    if name == STIFFENED:
        return std / max(prior.std, 1e-12)
    before = prior.interval
    return (high - low) / max(before[1] - before[0], 1e-12)


def status_of(
    name: str, value: float, std: float, left: float | None, kinds: Collection[Kind]
) -> Identification:
    """Identified, weak or not: against what was known, and on its own.

    left: share of the interval before that is left (`left_of`), None where nothing was known. kinds: of the relations there.
    """
    if name in SEEN_BY and not set(SEEN_BY[name]) & set(kinds):
        return "not_identifiable"
    ratio = 0.0 if left is None else left
    status: Identification = (
        "identified" if ratio <= GOOD else "weak" if ratio <= FAIR else "not_identifiable"
    )
    close, near = GOOD_ALONE.get(name, (math.inf, math.inf))
    if std > near:
        return "not_identifiable"
    relative = std / max(abs(value), 1e-12)
    largest = LARGEST.get(name, math.inf)
    if status == "identified" and (std > close or (name not in GOOD_ALONE and relative > largest)):
        status = "weak"
    if left is None and name not in GOOD_ALONE and relative > 3 * min(largest, 0.1):
        return "not_identifiable"
    return status


def listed(names: Sequence[str]) -> str:
    """The first few, and how many more there are."""
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")


def lacks_of(name: str, seen: bool, following: Sequence[NextMeasurement]) -> str:
    """What is missing. seen: the drive has relations that see the parameter; following: what would narrow it, the best first."""
    if not seen:
        return _needs(name)
    if not following:
        return "the relations that see it are there, and what is known of the vehicle leaves them open"
    action = following[0].action
    return f"what would help most: {action[:1].lower()}{action[1:].rstrip('.')}"


def reason_of(
    name: str, status: Identification, shares: Sequence[Share], file_std: float, std: float, lacks: str
) -> str:
    """In words: which relations brought it, and what it would have been without; where it is wide, what it lacks."""
    brought = [s for s in shares if s.bits > HARDLY]
    words = listed([f"{s.relation} (± {spread_text(s.std_without)} without it)" for s in brought])
    if not words:
        words = "all relations alike: " + listed([s.relation for s in shares])
    if status == "not_identifiable":
        if math.isinf(file_std):
            # nothing at all is known beforehand of a vehicle of no mass
            return f"{GIVE_MASS}; {lacks}"
        if std < 0.02 * file_std:
            return f"known before to ± {spread_text(file_std)}"
        return f"this drive adds little to what was known; {lacks}"
    if status == "weak":
        return f"from {words}; the interval is still wide; {lacks}"
    return f"from {words}"


def prior_record(prior: Spread, *, whole: bool = False) -> Prior:
    """As results hold it. whole: with the spread of all of it, tails included, as the answers that are the prior alone have it."""
    return Prior(prior.mean, prior.whole_std if whole else prior.std, SOURCE)


def _by_tails(answer: Told, prior: Spread) -> bool:
    """Whether an answer is narrower than what was known before by its tails alone: then all of that is what it is held against."""
    return prior.std < answer.std < prior.whole_std


def _positive(name: str) -> bool:
    return is_positive(name) or name.endswith(NEVER_NEGATIVE)


def _of_no_vehicle(name: str, answer: Told) -> bool:
    """Whether figures of what is above nought in every vehicle lie below it, or reach it within half a spread: a wrong log or file makes such."""
    return _positive(name) and answer.value <= 0.5 * answer.std


def _opened_by_drive(name: str, answer: Told, prior: Spread | None, kinds: Collection[Kind]) -> str:
    """Of a parameter that the drive does not tell, why its figures are not those of the file alone; else empty."""
    if prior is None:
        return ""
    if name != STIFFENED:
        away = abs(answer.value - prior.mean)
        if answer.std > OPENED * prior.whole_std:
            return "what this drive shows pulls away from what was known before it, which leaves it more open than that did"
        if away > MOVED * prior.whole_std:
            return "what this drive shows leaves it elsewhere than what was known before, and no surer"
        if name in LOADED and answer.std <= prior.whole_std and set(kinds) & set(MASS_SEEN_BY):
            return f"the figures are what is known of the empty vehicle's {name.split('_')[0]} inertia, under the load that this drive shows"
        return ""
    if answer.std > prior.std:
        return "the load that this drive shows leaves it more open than the vehicle file alone"
    if "vertical" in kinds:
        return (
            "the figures are what the vehicle file says of the springs under the load that this drive shows"
        )
    return ""


def estimate_of(
    name: str,
    answer: Told,
    prior: Spread | None,
    shares: Sequence[Share],
    reference: float | None,
    evidence: Sequence[Evidence],
    following: Sequence[NextMeasurement] = (),
    rests: str = "",
) -> ParameterEstimate:
    """The verdict's entry. evidence: the drive's relations that were counted; following: what would narrow it, the best first; rests:
    in words, the vehicle file's figures on which it rests and which the drive hardly checks (`pipelines.joint.rests`)."""
    blind = NOT_LEVEL if name == "cg_lateral_offset_m" else ()
    kinds = {e.kind for e in evidence if e.carrier not in blind}
    left = None if prior is None else left_of(name, prior, answer.std, answer.low, answer.high)
    status = status_of(name, answer.value, answer.std, left, kinds)
    if _positive(name) and answer.low <= 0:
        # of what no vehicle has less than nothing of, such an interval says nothing
        status = "not_identifiable"
    file_std = prior.std if prior is not None else math.inf
    witnesses = SEEN_BY.get(name, MASS_SEEN_BY if "mass" in name else ())
    lacks = lacks_of(name, bool(kinds & set(witnesses)), following)
    reason = reason_of(name, status, shares, file_std, answer.std, lacks)
    if prior is None and status == "not_identifiable":
        return ParameterEstimate(name, None, None, None, None, status, reason, None, reference, ())
    words = _opened_by_drive(name, answer, prior, kinds) if status == "not_identifiable" else ""
    if prior is not None and words and _of_no_vehicle(name, answer):
        reason, words = f"{OF_NO_VEHICLE}; {lacks}", ""
    if prior is not None and words:
        low, high = (max(answer.low, 0.0) if _positive(name) else answer.low), answer.high
        # whole, as all that is shown of what a drive does not tell
        return ParameterEstimate(
            name, answer.value, answer.std, low, high, status, f"{words}; {lacks}", prior_record(prior, whole=True), reference,
            ("prior",),
        )  # fmt: skip
    if prior is not None and status == "not_identifiable":
        # what the drive adds to it is no result of its own
        low, high = prior.shown
        return ParameterEstimate(
            name, prior.mean, prior.whole_std, low, high, status, f"{reason}; the figures are what was known before",
            prior_record(prior, whole=True), reference, ("prior",),
        )  # fmt: skip
    if rests:
        reason = f"{reason}; {rests}"
    record = None if prior is None else prior_record(prior, whole=_by_tails(answer, prior))
    who = tuple(dict.fromkeys(e.source for e in evidence))
    return ParameterEstimate(
        name, answer.value, answer.std, answer.low, answer.high, status, reason, record, reference, who,
        answer.inner,
    )  # fmt: skip


def as_known(entry: ParameterEstimate, prior: Spread) -> ParameterEstimate:
    """What a drive did not tell, with the figures that were known before. entry: its name, reason and reference."""
    low, high = prior.shown
    return ParameterEstimate(
        entry.name, prior.mean, prior.whole_std, low, high, "not_identifiable", entry.reason, prior_record(prior, whole=True), entry.reference,
        ("prior",),
    )  # fmt: skip


def _smooth(draws: FloatArray, grid: FloatArray) -> FloatArray:
    """Kernel density of draws with Silverman's width on their central part."""
    low, high = np.quantile(draws, (0.16, 0.84))
    width = max(1.06 * 0.5 * float(high - low) * len(draws) ** -0.2, 1e-12)
    z = (grid[:, None] - draws[None, :]) / width
    return np.asarray(np.exp(-0.5 * z * z).mean(axis=1) / (width * math.sqrt(2 * math.pi)))


def helping(
    following: Sequence[NextMeasurement], answer: Told, prior: Spread | None
) -> tuple[NextMeasurement, ...]:
    """Measurements that beat the answer, and what was known before where nothing was learned."""
    known = answer.std if prior is None else min(prior.std, answer.std)
    return tuple(step for step in following if step.std_after < NARROWER * known)


def learned_of(
    name: str,
    answer: Told,
    prior: Spread,
    shares: tuple[Share, ...],
    following: tuple[NextMeasurement, ...],
    *,
    whole: bool = False,
) -> Learned:
    """Bits, shares, what next, and both densities on one grid. Where nothing was learned no relation brought anything.

    whole: whether the answer was not told, so that its prior is shown with its tails (`prior_record`).
    """
    tails = not whole and _by_tails(answer, prior)
    gained = bits(prior.whole_std if tails else prior.std, answer.std)
    shares = shares if gained > 0 else ()
    following = helping(following, answer, prior)
    few = prior.draws[:1500]
    low, high = np.quantile(few, (0.005, 0.995))
    low, high = min(low, answer.value - 4 * answer.std), max(high, answer.value + 4 * answer.std)
    inside = np.linspace(answer.value - 4 * answer.std, answer.value + 4 * answer.std, GRID // 2)
    grid = np.unique(np.concatenate([np.linspace(low, high, GRID - len(inside)), inside]))
    if answer.draws is None:
        after = density((grid - answer.value) / max(answer.std, 1e-12), freedom_of(name)) / max(
            answer.std, 1e-12
        )
    else:
        after = _smooth(answer.draws, grid)
    return Learned(name, prior_record(prior, whole=whole or tails), gained, shares, following, grid, _smooth(few, grid), after)  # fmt: skip
