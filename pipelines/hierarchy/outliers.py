"""Vehicles that stand out: each against the others of its kind, or against its own data sheet where there are too few."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.hierarchy.distance import MANY, Crowd, crowd, distance
from pipelines.hierarchy.records import Outlier, VehicleKnowledge
from pipelines.parameters import PARAMETERS
from pipelines.results import ParameterEstimate

FEWEST = 4
"""Vehicles of a kind from which on they are compared with each other."""

CHANCE = 0.01
"""False-alarm rate of a vehicle: it stands out where one as far by chance, among all its parameters, is less likely."""

TYPICAL = ("mass_kg", "cg_height_m", "cg_to_front_axle_m", "cg_lateral_offset_m")
"""Parameters of which a vehicle's typical load is compared: the median of its drives."""

FITTED = "imu_"
"""Begins the names of what belongs to the recorder: where it sits is no matter of the vehicle, but the data sheet may be wrong."""

LOADED = "typical "
"""Before the name of a parameter with the load that the vehicle usually has."""

TELLS = 0.9
"""Spread over that before the drives beyond which the drives said nothing."""


@dataclass(frozen=True)
class _Figure:
    """What is compared: said by the drives alone (the prior divided out where known). sheet: what was known before."""

    parameter: str
    title: str
    unit: str
    value: float
    std: float
    shown: float
    sheet: tuple[float, float] | None
    sheet_score: float


@dataclass(frozen=True)
class _Finding:
    """The farthest of a vehicle's figures. chance: that any of them is as far (Šidák)."""

    figure: _Figure
    score: float
    chance: float
    centre: float
    spread: float


def _figure(
    name: str, estimate: ParameterEstimate, title: str, unit: str, doubt: float = 0.0
) -> _Figure | None:
    """None where the drives said nothing of it. doubt: of the estimate's spread, what is no matter of information."""
    value, std, prior = estimate.value, estimate.std, estimate.prior
    if value is None or std is None or not std > 0 or estimate.status == "not_identifiable":
        return None
    if prior is None or not prior.std > 0:
        return _Figure(name, title, unit, value, std, value, None, 0.0)
    if std > TELLS * prior.std:
        return None
    # normal laws: posterior = prior x what the drives say, so a shared data sheet does not make vehicles alike
    told = math.sqrt(max(std**2 - doubt**2, 1e-6 * std**2))
    information = 1 / told**2 - 1 / prior.std**2
    alone = (value / told**2 - prior.value / prior.std**2) / information
    # what a doubt leaves open of the answer is as much larger of what the drives alone say as that lies farther from the prior
    open_ = doubt / (1 - (told / prior.std) ** 2)
    # the answer moves from the prior by chance with what the spread lost, and by what is doubted
    moved = (value - prior.value) / math.hypot(math.sqrt(prior.std**2 - told**2), doubt)
    sheet = (prior.value, prior.std)
    return _Figure(name, title, unit, alone, math.hypot(information**-0.5, open_), value, sheet, moved)


def _typical(vehicle: VehicleKnowledge, name: str) -> _Figure | None:
    """The median of the drives' answers; its interval is a drive's own, as drives share most of their errors."""
    found = [
        (estimate.value, estimate.std)
        for answers in vehicle.drives.values()
        if (estimate := answers.get(name)) is not None and estimate.status != "not_identifiable"
        if estimate.value is not None and estimate.std is not None and estimate.std > 0
    ]
    if not found:
        return None
    values, stds = np.array(found).T
    spread = float(np.hypot(np.median(stds), np.std(values) / math.sqrt(len(values))))
    spec, value = PARAMETERS[name], float(np.median(values))
    title = f"{spec.title} as usually loaded"
    return _Figure(LOADED + name, title, spec.unit, value, spread, value, None, 0.0)


def _figures(vehicle: VehicleKnowledge) -> dict[str, _Figure]:
    found = [
        _figure(name, p.estimate, p.title, p.unit, p.doubt) for name, p in sorted(vehicle.vehicle.items())
    ]
    found += [_typical(vehicle, name) for name in TYPICAL]
    return {figure.parameter: figure for figure in found if figure is not None}


def _farthest(findings: Sequence[_Finding]) -> _Finding | None:
    """The least likely one; probabilities of all come in as those of one comparison."""
    if not findings:
        return None
    first = min(findings, key=lambda f: (f.chance, -abs(f.score), f.figure.parameter))
    chance = -math.expm1(len(findings) * math.log1p(-min(first.chance, 1 - 1e-12)))
    return _Finding(first.figure, first.score, chance, first.centre, first.spread)


class _Kind:
    """Vehicles of one kind, by parameter: who has it, in order, with values and standard deviations."""

    def __init__(self, vehicles: Sequence[tuple[str, Mapping[str, _Figure]]]) -> None:
        names = sorted({name for _, figures in vehicles for name in figures if not name.startswith(FITTED)})
        self.columns = {}
        for name in names:
            have = [(vehicle_id, f[name]) for vehicle_id, f in vehicles if name in f]
            place = {vehicle_id: i for i, (vehicle_id, _) in enumerate(have)}
            values, stds = (np.array([getattr(f, key) for _, f in have]) for key in ("value", "std"))
            # of many, one more or less does not move centre and spread
            whole = crowd(values, stds) if len(have) > MANY else None
            self.columns[name] = (place, values, stds, whole)

    def others(self, name: str, vehicle_id: str) -> Crowd | None:
        """What the others are like; None where there are too few."""
        place, values, stds, whole = self.columns[name]
        if whole is not None:
            return whole
        rest = np.arange(len(values)) != place[vehicle_id]
        return crowd(values[rest], stds[rest]) if rest.sum() >= FEWEST - 1 else None

    def count(self, name: str) -> int:
        """Vehicles that have the parameter."""
        return len(self.columns[name][0])


def _against_others(vehicle_id: str, own: Mapping[str, _Figure], kind: _Kind) -> _Finding | None:
    found = []
    for name, figure in own.items():
        others = None if name.startswith(FITTED) else kind.others(name, vehicle_id)
        if others is not None:
            away = distance(figure.value, figure.std, others)
            found.append(_Finding(figure, away.score, away.probability, away.centre, away.spread))
    return _farthest(found)


def _against_sheet(own: Mapping[str, _Figure]) -> _Finding | None:
    found = []
    for figure in own.values():
        if figure.sheet is not None:
            chance = math.erfc(abs(figure.sheet_score) / math.sqrt(2))
            found.append(_Finding(figure, figure.sheet_score, chance, *figure.sheet))
    return _farthest(found)


def _number(finding: _Finding, value: float) -> str:
    """A value as fine as what it is compared with is known: to two digits of the spread, where the parameter has no usual digits."""
    figure = finding.figure
    spec = PARAMETERS.get(figure.parameter.removeprefix(LOADED))
    digits = spec.digits if spec is not None else _digits(finding.spread)
    return f"{value:.{digits}f} {figure.unit}".strip()


def _digits(spread: float) -> int:
    """Decimals that show two digits of a spread."""
    return min(max(1 - math.floor(math.log10(spread)), 0), 6) if 0 < spread < math.inf else 3


def _chance(probability: float) -> str:
    if probability < 1e-4:
        return "less than 0.01 %"
    return f"{100 * probability:.0f} %" if probability >= 0.1 else f"{100 * probability:.2g} %"


def _inside(title: str) -> str:
    """A title within a sentence; abbreviations (CG) stay as they are."""
    return title if title[1:2].isupper() else title[:1].lower() + title[1:]


def _sheet_words(finding: _Finding | None) -> str:
    """What the vehicle's data sheet has against its drives, empty where they agree."""
    if finding is None or finding.chance >= CHANCE:
        return ""
    f = finding.figure
    # few files say how the recorder sits: what is known before is then what is usual
    says = "What is known of its recorder's place" if f.parameter.startswith(FITTED) else "Its data sheet"
    return (
        f"{says} contradicts its drives: {_inside(f.title)} {_number(finding, finding.centre)} ± "
        f"{_number(finding, finding.spread)} there, {_number(finding, f.shown)} from the drives "
        f"({abs(finding.score):.1f} standard deviations)."
    )


def _others_words(finding: _Finding, count: int) -> str:
    f = finding.figure
    side = "above" if finding.score > 0 else "below"
    stands = "Stands out" if finding.chance < CHANCE else "Goes with the others of its kind"
    return (
        f"{stands}: {_inside(f.title)} {_number(finding, f.value)} is {abs(finding.score):.1f} standard deviations {side} "
        f"the {_number(finding, finding.centre)} of {count} others; the farthest of its figures, and as far by chance in "
        f"{_chance(finding.chance)}."
    )


def _alone_words(finding: _Finding, count: int) -> str:
    f = finding.figure
    few = "The only vehicle" if count == 1 else f"One of only {count} vehicles"
    found = _sheet_words(finding) or (
        f"Goes with it: {_inside(f.title)} {_number(finding, f.shown)} is {abs(finding.score):.1f} standard deviations from "
        f"{_number(finding, finding.centre)}; the farthest of its figures."
    )
    return f"{few} of its kind: compared with its own data sheet. {found}"


def _outlier(vehicle_id: str, finding: _Finding, text: str) -> Outlier:
    shown = finding.figure.shown if finding.figure.sheet == (finding.centre, finding.spread) else None
    value = finding.figure.value if shown is None else shown
    return Outlier(
        0, vehicle_id, abs(finding.score), finding.chance, finding.figure.parameter, value, finding.centre,
        finding.spread, text,
    )  # fmt: skip


def _of_kind(vehicles: Sequence[tuple[str, Mapping[str, _Figure]]]) -> list[Outlier]:
    """Vehicles of one kind."""
    found, kind = [], _Kind(vehicles)
    for vehicle_id, own in vehicles:
        sheet, away = _against_sheet(own), _against_others(vehicle_id, own, kind)
        if away is not None:
            others = kind.count(away.figure.parameter) - 1
            text = f"{_others_words(away, others)} {_sheet_words(sheet)}".strip()
            found.append(_outlier(vehicle_id, away, text))
        elif sheet is not None:
            found.append(_outlier(vehicle_id, sheet, _alone_words(sheet, len(vehicles))))
    return found


def rank(vehicles: Sequence[VehicleKnowledge], kinds: Mapping[str, str] | None) -> tuple[Outlier, ...]:
    """Every vehicle that can be compared, the farthest first; the same whatever the order of `vehicles`.

    kinds: vehicle_id -> what vehicles must share to be compared (name and body); a vehicle that is not in it is of no kind
    but its own; None: all are of one kind. probability: that any of its parameters is as far by chance (Šidák), which
    orders the vehicles; score: the distance in joint standard deviations of the parameter that is the least likely.
    """
    groups: dict[str, list[tuple[str, Mapping[str, _Figure]]]] = {}
    for vehicle in sorted(vehicles, key=lambda v: v.vehicle_id):
        kind = "all" if kinds is None else kinds.get(vehicle.vehicle_id, f"alone: {vehicle.vehicle_id}")
        groups.setdefault(kind, []).append((vehicle.vehicle_id, _figures(vehicle)))
    found = [outlier for _, group in sorted(groups.items()) for outlier in _of_kind(group)]
    found.sort(key=lambda o: (o.probability, -o.score, o.vehicle_id))
    return tuple(
        Outlier(
            place, o.vehicle_id, o.score, o.probability, o.parameter, o.value, o.others, o.others_std, o.text
        )
        for place, o in enumerate(found, 1)
    )
