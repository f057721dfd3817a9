"""From the joined posterior to answers: those of each drive, and those of the vehicle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipelines.hierarchy.join import Joined
from pipelines.hierarchy.own_outputs import outputs_at
from pipelines.hierarchy.parts import FILE
from pipelines.hierarchy.posterior import DrivePart, VehiclePosterior, inverse
from pipelines.hierarchy.records import DriveTold, VehicleParameter
from pipelines.joint.answers import FAIR, GOOD, OPENED, SEEN_BY, left_of, prior_record, status_of
from pipelines.joint.information import NEVER_NEGATIVE, Spread
from pipelines.joint.kept import KeptRelations
from pipelines.joint.vehicle.empty import FIGURES, Figure, figure_at
from pipelines.joint.ways.other_vehicle import ANOTHERS
from pipelines.parameters import spread_text
from pipelines.results import FloatArray, Identification, ParameterEstimate, Prior
from pipelines.verdict.combine import ASIDE

SOURCE = "hierarchy"
SOURCE_BEFORE = "vehicle file and what is known of vehicles"
WHOLE = "cg_height_m"
"""The parameter whose entry is refused where all of a verdict is."""
POSITIVE = (*NEVER_NEGATIVE, "_n", "_npm", "drag_area_m2", "imu_above_ground_m")
MAY_BE_NONE = "anti_roll"
"""How names of the vehicle's figures end that are above nought in every vehicle, and begin that are nought in those without a bar."""
LATERAL = "cg_lateral_offset_m"
NO_DRAWS: FloatArray = np.zeros(0)
WITH = "with all {count} drives of the vehicle: ± {std}, this drive alone {alone}"


@dataclass(frozen=True)
class Seen:
    """What the joined drives have in common for answers. kinds: physics of their relations; priors: parameter -> prior."""

    kinds: frozenset[str]
    priors: Mapping[str, Prior]


def seen_by(drives: Sequence[DriveTold]) -> Seen:
    """Of the drives that were joined, in order."""
    kinds: set[str] = set()
    priors: dict[str, Prior] = {}
    for drive in drives:
        if drive.kept is not None:
            pairs = zip(drive.kept.kind, drive.kept.source, strict=True)
            kinds |= {kind for kind, source in pairs if source != FILE}
        for name, entry in drive.verdict.items():
            if entry.prior is not None:
                priors.setdefault(name, entry.prior)
    return Seen(frozenset(kinds), priors)


def _lateral(kept: KeptRelations) -> bool:
    """Whether the drive's own relations see to which side its load lies: those of other physics that hang on it tell how heavy it is, and
    what is left of where it may lie then was known before."""
    if "load_y" not in kept.names:
        return False
    leans = np.array([kind in SEEN_BY[LATERAL] for kind in kept.kind], dtype=bool)
    return bool(np.any(np.abs(kept.rows[leans, kept.names.index("load_y")]) > 0))


def _alone(entry: ParameterEstimate | None) -> str:
    if entry is None or entry.std is None:
        return "says nothing"
    if entry.status == "not_identifiable":
        return f"adds little to what was known (± {spread_text(entry.std)})"
    return f"± {spread_text(entry.std)}"


def _says_more_alone(drive: DriveTold, own: ParameterEstimate | None, std: float) -> bool:
    """Whether a drive's own verdict, which was sampled as it is not normal, is narrower than what its linear relations and
    all other drives make: going over to these lost more than the others bring."""
    curved = drive.kept is not None and not drive.kept.normal
    told = own is not None and own.std is not None and own.status != "not_identifiable"
    return curved and told and own is not None and own.std is not None and own.std <= std


def _before(part: DrivePart) -> dict[str, Prior]:
    """What a drive's parameters were known to before any log: of those, too, that no drive's verdict has."""
    values, gradients = outputs_at(part.names, part.mean, part.std, part.given)
    return {
        name: Prior(value, float(np.linalg.norm(gradients[name] * part.std)), SOURCE_BEFORE)
        for name, value in values.items()
    }


def _answer(
    name: str, value: float, std: float, drive: DriveTold, before: Prior, seen: Seen, count: int
) -> ParameterEstimate | None:
    """One parameter of one drive with all drives joined; None where it is not to be shown."""
    own = drive.verdict.get(name)
    prior: Prior | None = own.prior if own is not None and own.prior is not None else seen.priors.get(name)
    if own is None and prior is None and before.std > 0:
        prior = before
    spread = None if prior is None else Spread(prior.value, prior.std, NO_DRAWS)
    kinds: frozenset[str] = seen.kinds
    if name == LATERAL and drive.kept is not None and not _lateral(drive.kept):
        kinds = frozenset()
    half = 1.96 * std
    left = None if spread is None else left_of(name, spread, std, value - half, value + half)
    status = status_of(name, value, std, left, kinds)  # type: ignore[arg-type]
    if name.endswith(NEVER_NEGATIVE) and value <= half:
        status = "not_identifiable"
    if own is None and (name in ASIDE and status == "not_identifiable"):
        return None
    if _says_more_alone(drive, own, std):
        return own
    # what a drive told by itself, with the tails of its own draws, other drives that narrow it do not take back
    if (
        status == "weak"
        and own is not None
        and own.status == "identified"
        and own.std is not None
        and std <= own.std
    ):
        status = "identified"
    wrong = refused(drive, name)
    if wrong and status == "identified":
        status = "weak"
    if ANOTHERS in wrong:
        status = "not_identifiable"
    reason = wrong + WITH.format(count=count, std=spread_text(std), alone=_alone(own))
    if status == "not_identifiable":
        if own is None or own.std is None or std >= own.std:
            return own
        # of this drive alone hardly anything is seen; that of the vehicle which its other drives saw holds for it as well
        reason = f"{wrong}this drive adds little; what is known of the vehicle by all its {count} drives: ± {spread_text(std)}"
    sources = tuple(dict.fromkeys((*(own.sources if own is not None else ()), SOURCE)))
    return ParameterEstimate(
        name, value, std, value - half, value + half, status, reason,
        None if spread is None else (prior or prior_record(spread)),
        None if own is None else own.reference, tuple(s for s in sources if s != "prior"),
    )  # fmt: skip


def refused(drive: DriveTold, name: str) -> str:
    """Why a drive's own verdict calls a parameter identified no more, however narrow: its vehicle file or its log is wrong. Or empty.

    Joined with drives that have the same file it is no righter. What the verdict has no entry for is as doubtful as its height: what
    says that a file or a log is wrong as a whole stands with each.
    """
    own = drive.verdict.get(name, drive.verdict.get(WHOLE))
    return "" if own is None else own.refused


def _known_before(own: ParameterEstimate) -> bool:
    """Whether a parameter that a drive does not tell has the figures that were known before, which say nothing of the drive."""
    if own.status != "not_identifiable":
        return False
    return own.prior is None or (own.value, own.std) == (own.prior.value, own.prior.std)


def _covariance(kept: KeptRelations) -> FloatArray:
    """(k, k) of a drive's unknowns by its own linear relations, in standard deviations before the log."""
    slope = kept.rows * kept.std
    return inverse(np.eye(len(kept.std)) + slope.T @ slope)


def doubted(drive: DriveTold) -> dict[str, float]:
    """Variance by parameter that the drive's own verdict has beyond its linear relations', SI.

    It added that because relations contradict each other, or as a sensor or a figure of the file may be wrong. Both live on: other drives
    do not say which of the drive's relations is wrong, and joining it with none must not make it surer. So does that of what the
    drive does not tell: a doubt that leaves nothing to tell is no smaller than one that leaves a wide answer. It is about the relations' own
    value, which is what is joined; where doubts move the drive's answer off that, this counts as well.
    """
    kept = drive.kept
    if kept is None:
        return {}
    covariance = _covariance(kept)
    values, gradients = outputs_at(kept.names, kept.mode, kept.std, kept.given)
    found = {}
    for name, gradient in gradients.items():
        g = gradient * kept.std
        linear = kept.inflation**2 * float(g @ covariance @ g)
        found[name] = max(
            (std**2 + (value - values[name]) ** 2 - linear for value, std in _left(drive, name)), default=0.0
        )
    return {name: max(variance, 0.0) for name, variance in found.items()}


def _left(drive: DriveTold, name: str) -> list[tuple[float, float]]:
    """What the drive itself leaves of a parameter, as value and standard deviation: by its verdict, where the figures there are its own,
    and by what it handed on."""
    own = drive.verdict.get(name)
    found = []
    if own is not None and own.value is not None and own.std is not None and not _known_before(own):
        found.append((own.value, own.std))
    if drive.kept is not None and name in drive.kept.told:
        found.append(drive.kept.told[name])
    return [pair for pair in found if not any(math.isnan(figure) for figure in pair)]


def drive_answers(joined: Joined) -> dict[str, dict[str, ParameterEstimate]]:
    """Of every drive all answers: those of the joined posterior where the drive is in it, else its own."""
    found = {drive.drive_id: dict(drive.verdict) for drive in joined.drives}
    posterior = joined.posterior
    if posterior is None or len(posterior.parts) < 2:
        return found
    by_id = {drive.drive_id: drive for drive in joined.drives}
    seen = seen_by([by_id[name] for name in posterior.drives])
    for i, drive_id in enumerate(posterior.drives):
        drive = by_id[drive_id]
        values, gradients = posterior.outputs(i)
        names = list(values)
        _, covariance = posterior.functional({i: np.stack([gradients[n] for n in names])})
        more, before = doubted(drive), _before(posterior.parts[i])
        for name, variance in zip(names, np.diag(covariance).tolist(), strict=True):
            std = math.sqrt(posterior.inflation**2 * variance + more.get(name, 0.0))
            entry = _answer(name, values[name], std, drive, before[name], seen, len(posterior.parts))
            if entry is not None:
                found[drive_id][name] = entry
    for drive_id in joined.left_out:
        found[drive_id] = {
            name: replace(e, reason=f"this drive alone, as it contradicts the vehicle's others; {e.reason}")
            for name, e in found[drive_id].items()
        }
    return found


def alone_std(part: DrivePart, turned: FloatArray) -> float:
    """Spread of a figure of the vehicle by one drive alone. turned: (K,) its slopes by the shared unknowns, s of N(0, I)."""
    seen = part.a @ turned
    spread = np.eye(len(seen)) + part.f @ part.f.T + part.a @ part.a.T
    return math.sqrt(max(float(turned @ turned - seen @ np.linalg.solve(spread, seen)), 0.0))


def _vehicle_place(posterior: VehiclePosterior, i: int) -> tuple[FloatArray, FloatArray]:
    """(k,) the vehicle's own unknowns, a drive's scatter left out, and their (k, K) slopes by the shared ones, SI."""
    part = posterior.parts[i]
    by_shared = part.std[:, None] * part.shared
    return part.mean + by_shared @ posterior.s, by_shared


def _last_with(figure: Figure, posterior: VehiclePosterior) -> int | None:
    rows = [i for i, part in enumerate(posterior.parts) if set(figure.needs) <= set(part.names)]
    return rows[-1] if rows else None


def _status(std: float, before: float) -> Identification:
    ratio = std / max(before, 1e-300)
    return "identified" if ratio <= GOOD else "weak" if ratio <= FAIR else "not_identifiable"


def vehicle_answers(joined: Joined) -> dict[str, VehicleParameter]:
    """What belongs to the vehicle, in the order of reports."""
    posterior = joined.posterior
    if posterior is None:
        return {}
    found = {}
    joint = set(posterior.drives)
    drives = {
        d.drive_id: (d.kept, _covariance(d.kept))
        for d in joined.drives
        if d.kept is not None and d.drive_id in joint
    }
    for figure in FIGURES:
        i = _last_with(figure, posterior)
        answer = None if i is None else _vehicle_answer(figure, i, joined, posterior, drives)
        if answer is not None:
            found[figure.name] = answer
    return found


def _refused_by_most(figure: Figure, joined: Joined, posterior: VehiclePosterior) -> str:
    """Why a figure of the vehicle is not identified however narrow: half or more of the drives that it is from say that its file or their log
    is wrong. Or empty. That of the empty vehicle is refused where that of the loaded one is."""
    by_id = {drive.drive_id: drive for drive in joined.drives}
    said = [refused(by_id[name], figure.name.removeprefix("empty_")) for name in posterior.drives]
    found = [words for words in said if words]
    if not found or 2 * len(found) < len(said):
        return ""
    return f"in {len(found)} of {len(said)} drives {found[0]}" if len(said) > 1 else found[0]


def figure_doubted(figure: Figure, kept: KeptRelations, covariance: FloatArray) -> float:
    """Variance of a figure of the vehicle that a drive's doubts add to its linear relations', SI. covariance: `_covariance`."""
    pair = kept.empty.get(figure.name)
    if pair is None or any(math.isnan(x) for x in pair) or not set(figure.needs) <= set(kept.names):
        return 0.0
    value, slope = figure_at(figure, kept.names, kept.mode, kept.std)
    g = slope * kept.std
    return max(pair[1] ** 2 + (pair[0] - value) ** 2 - kept.inflation**2 * float(g @ covariance @ g), 0.0)


def _common_doubt(
    figure: Figure, drives: Sequence[tuple[KeptRelations, FloatArray]], singles: Sequence[float], before: float
) -> float:  # fmt: skip
    """Standard deviation that the drives' doubts leave in a figure of the vehicle: their mean, each by what its drive tells.

    They have the vehicle file, its kind of springs and mostly the sensors in common: what is wrong in one of them is wrong in the others, and
    no number of drives averages it. drives: with their `_covariance`; singles: what each alone leaves.
    """
    sizes = np.sqrt([figure_doubted(figure, *drive) for drive in drives])
    told = np.array([max(max(single, 1e-9 * before) ** -2 - before**-2, 0.0) for single in singles])
    weights = told / told.sum() if told.sum() > 0 else np.full(len(sizes), 1 / max(len(sizes), 1))
    return float(weights @ sizes)


def _vehicle_answer(
    figure: Figure,
    i: int,
    joined: Joined,
    posterior: VehiclePosterior,
    drives: Mapping[str, tuple[KeptRelations, FloatArray]],
) -> VehicleParameter | None:
    """None where nothing of it is the vehicle's."""
    part = posterior.parts[i]
    at, by_shared = _vehicle_place(posterior, i)
    value, gradient = figure_at(figure, part.names, at, part.std)
    turned = gradient @ by_shared
    start, slope = figure_at(figure, part.names, part.mean, part.std)
    before = float(np.linalg.norm(slope @ by_shared))
    wider = posterior.inflation if len(posterior.parts) > 1 else 1.0
    std = wider * math.sqrt(float(turned @ posterior.s_covariance @ turned))
    if min(std, before) < 1e-9 * abs(value):
        return None
    having = [p for p in posterior.parts if set(figure.needs) <= set(p.names)]
    singles = [alone_std(p, turned) for p in having]
    doubt = _common_doubt(figure, [drives[p.drive_id] for p in having], singles, before)
    # of what is not told, a doubt is shown that opens what was known before, as in a drive's own verdict
    untold = _state(figure, value, std, before) == "not_identifiable"
    if untold and math.hypot(std, doubt) <= OPENED * before:
        doubt = math.sqrt(max(before**2 - std**2, 0.0)) if math.hypot(std, doubt) > before else doubt
    std = math.hypot(std, doubt)
    single = math.hypot(float(np.median(singles)), doubt) if singles else None
    status = _state(figure, value, std, before)
    wrong = _refused_by_most(figure, joined, posterior)
    if wrong and status == "identified":
        status = "weak"
    if ANOTHERS in wrong:
        status = "not_identifiable"
    reason = wrong + _vehicle_reason(status, len(posterior.parts), single, std, before)
    prior = Prior(start, before, SOURCE_BEFORE)
    estimate = ParameterEstimate(
        figure.name, value, std, value - 1.96 * std, value + 1.96 * std, status, reason, prior, None, (SOURCE,)
    )  # fmt: skip
    return VehicleParameter(estimate, figure.title, figure.unit, single, len(posterior.parts), doubt)


def _state(figure: Figure, value: float, std: float, before: float) -> Identification:
    """Of what no vehicle has less than nothing of, an interval that reaches nought says nothing."""
    positive = figure.name.endswith(POSITIVE) and not figure.name.startswith(MAY_BE_NONE)
    return "not_identifiable" if positive and value <= 1.96 * std else _status(std, before)


def _vehicle_reason(
    status: Identification, count: int, single: float | None, std: float, before: float
) -> str:
    words = "one drive" if count == 1 else f"{count} drives"
    if status == "not_identifiable" and std > OPENED * before:
        return f"what {words} doubt{'s' if count == 1 else ''} leaves it more open than what was known of it"
    if status == "not_identifiable":
        return f"{words} add{'s' if count == 1 else ''} little to what was known of it"
    return f"from {words}" + (f"; one alone has a spread {single / std:.2g} x as large" if single else "")
