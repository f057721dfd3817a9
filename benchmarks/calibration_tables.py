"""What a calibration study found: coverage, medians, the verdict against each method, the reliability diagram.

Works on the study's records alone (one a drive, as its JSON-lines file holds them).
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np

from pipelines.parameters import PARAMETERS

Record = dict[str, Any]
LEVELS = (0.50, 0.80, 0.95)
FAR = 4.0
ALLOWED = 0.05
"""LEVELS: intervals whose coverage is counted. FAR: std from which an answer is confidently wrong. ALLOWED: how far coverage
may lie from its level (the issue's)."""
VERDICT = "verdict"
SHOWN = ("cg_height_m", "mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "roll_stiffness_nmprad")


@dataclass(frozen=True)
class Answer:
    """One parameter of one drive by one method. size: what errors are related to."""

    seed: int
    text: str
    sensors: str
    name: str
    truth: float
    size: float
    value: float
    std: float
    low: float
    high: float
    status: str
    prior_std: float | None
    inner: tuple[tuple[float, float], ...] = ()

    @property
    def z(self) -> float:
        """Error in standard deviations."""
        return (self.value - self.truth) / self.std

    @property
    def score(self) -> float:
        """|z| of a normal distribution at whose level the answer's own interval just holds the truth."""
        if not self.inner:
            return abs(self.z)
        bounds = [self.value, *(i[self.truth > self.value] for i in (*self.inner, (self.low, self.high)))]
        away = np.maximum.accumulate(np.abs(np.array(bounds) - self.value))
        scores = [0.0, *(NormalDist().inv_cdf(0.5 + level / 2) for level in LEVELS)]
        far = abs(self.truth - self.value)
        return float(np.interp(far, away, scores)) if far < away[-1] else scores[-1] * far / float(away[-1])

    @property
    def error(self) -> float:
        """Error over its size."""
        return (self.value - self.truth) / self.size

    def inside(self, level: float) -> bool:
        """Whether the interval of this level holds the truth: the answer's own; Gaussian where it tells none."""
        if level == LEVELS[-1]:
            return self.low <= self.truth <= self.high
        if self.inner:
            low, high = self.inner[LEVELS.index(level)]
            return low <= self.truth <= high
        return abs(self.z) <= NormalDist().inv_cdf(0.5 + level / 2)


def answers_of(records: Iterable[Record], method: str = VERDICT) -> list[Answer]:
    """All answers of a method that have a truth, figures and a spread."""
    found = []
    for record in records:
        for name, given in record["answers"].get(method, {}).items():
            value, std, low, high, status, prior_std, *inner = given
            truth = record["truth"].get(name)
            if truth is None or not std or not math.isfinite(std):
                continue
            size = record["sizes"].get(name, abs(truth))
            found.append(
                Answer(
                    record["plan"]["seed"], record["text"], record["plan"]["sensors"], name, truth, size, value, std,
                    low, high, status, prior_std, tuple((a, b) for a, b in inner),
                )
            )  # fmt: skip
    return found


def by_name(answers: Iterable[Answer]) -> dict[str, list[Answer]]:
    """Answers by parameter, in the order of the parameters' table."""
    groups: dict[str, list[Answer]] = defaultdict(list)
    for answer in answers:
        groups[answer.name].append(answer)
    return {name: groups[name] for name in PARAMETERS if name in groups}


def _line(cells: Iterable[object]) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    return "\n".join([_line(head), _line(["---"] * len(head)), *(_line(row) for row in rows)])


def coverage_table(answers: Sequence[Answer]) -> str:
    """A line a parameter: how many, bias and error, coverage of each level, rms of z, the worst, how many beyond FAR."""
    rows = []
    for name, group in by_name(answers).items():
        z = np.array([a.z for a in group])
        error = 100 * np.array([a.error for a in group])
        covered = [np.mean([a.inside(level) for a in group]) for level in LEVELS]
        worst = group[int(np.argmax(np.abs(z)))]
        rows.append(
            (name, len(group), f"{error.mean():+.2f}", f"{np.median(np.abs(error)):.2f}", f"{np.mean(z):+.2f}",
             *(_marked(c, level, len(group)) for c, level in zip(covered, LEVELS, strict=True)),
             f"{np.sqrt(np.mean(z**2)):.2f}", f"{abs(worst.z):.1f} (seed {worst.seed})", int(np.sum(np.abs(z) > FAR)))
        )  # fmt: skip
    levels = [f"{100 * level:.0f} % holds" for level in LEVELS]
    return _table(
        (
            "parameter",
            "drives",
            "bias %",
            "median error %",
            "mean z",
            *levels,
            "rms z",
            "worst z",
            f"beyond {FAR:g}",
        ),
        rows,
    )


def sensors_table(answers: Sequence[Answer], least: int = 4) -> str:
    """The main parameters by sensor set: how many, bias and error, mean and rms of z; what is off where."""
    groups: dict[tuple[str, str], list[Answer]] = defaultdict(list)
    for a in answers:
        if a.name in SHOWN:
            groups[a.name, a.sensors].append(a)
    rows = []
    for (name, sensors), group in sorted(
        groups.items(), key=lambda item: (SHOWN.index(item[0][0]), item[0][1])
    ):
        if len(group) >= least:
            z, error = np.array([a.z for a in group]), 100 * np.array([a.error for a in group])
            rows.append(
                (name, sensors, len(group), f"{error.mean():+.2f}", f"{np.median(np.abs(error)):.2f}",
                 f"{z.mean():+.2f}", f"{np.sqrt(np.mean(z**2)):.2f}", f"{np.abs(z).max():.1f}")
            )  # fmt: skip
    return _table(
        ("parameter", "sensors", "drives", "bias %", "median error %", "mean z", "rms z", "worst z"), rows
    )


def _marked(covered: float, level: float, count: int) -> str:
    """A coverage; with * where it lies farther from its level than is allowed and chance explains (2 std)."""
    chance = 2 * math.sqrt(level * (1 - level) / count)
    return f"{covered:.2f}{'*' if abs(covered - level) > max(ALLOWED, chance) else ''}"


def far_table(records: Sequence[Record], statuses: Sequence[str] = ("identified",)) -> str:
    """Every answer of the verdict beyond FAR standard deviations, the farthest first."""
    far = [a for a in answers_of(records) if abs(a.z) > FAR and a.status in statuses]
    far.sort(key=lambda a: -abs(a.z))
    return _table(
        ("drive", "parameter", "status", "z", "value", "std", "truth"),
        (
            (a.text, a.name, a.status, f"{a.z:+.1f}", f"{a.value:.4g}", f"{a.std:.2g}", f"{a.truth:.4g}")
            for a in far
        ),
    )


def methods_table(records: Sequence[Record], least: int = 5) -> str:
    """Each method's RMSE against the verdict's on the same drives, where the method gave the parameter.

    The interval of the ratio is that of 400 paired bootstrap draws: a ratio above 1 within it is chance.
    """
    rng = np.random.default_rng(0)
    verdict = {(r["text"], a.name): a for r in records for a in answers_of([r])}
    names = sorted({m for r in records for m in r["answers"]} - {VERDICT})
    rows = []
    for method in names:
        pairs: dict[str, list[tuple[float, float]]] = defaultdict(list)
        for record in records:
            for a in answers_of([record], method):
                ours = verdict.get((record["text"], a.name))
                if a.status != "not_identifiable" and ours is not None:
                    pairs[a.name].append((ours.error, a.error))
        for name, group in pairs.items():
            if len(group) < least:
                continue
            errors = np.array(group) ** 2
            ratio = math.sqrt(errors[:, 0].mean() / errors[:, 1].mean())
            draws = errors[rng.integers(0, len(group), (400, len(group)))].mean(axis=1)
            low, high = np.quantile(np.sqrt(draws[:, 0] / draws[:, 1]), [0.05, 0.95])
            ours_rms, theirs = 100 * np.sqrt(errors.mean(axis=0))
            rows.append(
                (name, method, len(group), f"{ours_rms:.2f}", f"{theirs:.2f}", f"{ratio:.2f}", f"{low:.2f}-{high:.2f}",
                 "worse" if low > 1 else "")
            )  # fmt: skip
    rows.sort(key=lambda row: (list(PARAMETERS).index(str(row[0])), -float(str(row[5]))))
    return _table(
        (
            "parameter",
            "method",
            "drives",
            "verdict RMSE %",
            "method RMSE %",
            "ratio",
            "90 % of the ratio",
            "",
        ),
        rows,
    )


def narrower(records: Sequence[Record]) -> tuple[list[Answer], int]:
    """Of the answers with a prior that say that something was learned: those not narrower than it, and how many there are."""
    learned = [a for a in answers_of(records) if a.status != "not_identifiable" and a.prior_std]
    return [a for a in learned if a.std >= (a.prior_std or 0)], len(learned)


def medians_table(records: Sequence[Record]) -> str:
    """Medians of |error| and of the 95 % interval's half-width, a line a parameter, whatever the status."""
    groups = by_name(answers_of(records))
    rows = []
    for name in SHOWN:
        group = groups.get(name, [])
        if not group:
            continue
        # the lateral place in mm, all else in per cent of its size
        unit, factor = ("mm", 1000.0) if name == "cg_lateral_offset_m" else ("%", 100.0)
        size = np.array([1.0 if unit == "mm" else a.size for a in group])
        error = factor * np.array([a.value - a.truth for a in group]) / size
        half = factor * np.array([(a.high - a.low) / 2 for a in group]) / size
        inside = np.mean([a.low <= a.truth <= a.high for a in group])
        said = Counter(a.status for a in group)
        rows.append(
            (name, len(group), f"{np.median(np.abs(error)):.2f} {unit}", f"{np.mean(error):+.2f}",
             f"{np.quantile(np.abs(error), 0.95):.2f}", f"{np.median(half):.2f} {unit}", f"{inside:.2f}",
             ", ".join(f"{count} {status}" for status, count in said.most_common()))
        )  # fmt: skip
    return _table(
        (
            "parameter",
            "drives",
            "median error",
            "bias",
            "95th",
            "median half-width of 95 %",
            "95 % holds",
            "status",
        ),
        rows,
    )


def save_reliability(answers: Sequence[Answer], path: Path, least: int = 40) -> None:
    """The reliability diagram: which share of the intervals of a level holds the truth. A grey line a parameter with at
    least so many answers, the mean of all in blue, and the band in which chance leaves a line of the median count."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from reports.figures.style import AMBER, BLUE, PALE, SOFT, new_figure, styled

    levels = np.arange(0.05, 1.0, 0.05)
    bounds = np.array([NormalDist().inv_cdf(0.5 + level / 2) for level in levels])
    groups = {name: np.array([a.score for a in group]) for name, group in by_name(answers).items()}
    with styled():
        figure = new_figure(4.2, 3.8)
        axes = figure.subplots()
        counts = [len(z) for z in groups.values() if len(z) >= least] or [len(answers)]
        chance = 2 * np.sqrt(levels * (1 - levels) / float(np.median(counts)))
        axes.fill_between(100 * levels, 100 * (levels - chance), 100 * (levels + chance), color=PALE, alpha=0.5, lw=0,
                          label="by chance (95 %)")  # fmt: skip
        axes.plot([0, 100], [0, 100], color=SOFT, lw=0.7, ls="--", label="honest")
        named = False
        for z in groups.values():
            if len(z) >= least:
                share = (z[:, None] <= bounds).mean(axis=0)
                axes.plot(100 * levels, 100 * share, color=AMBER, lw=0.5, alpha=0.7,
                          label=None if named else "each parameter")  # fmt: skip
                named = True
        pooled = np.concatenate(list(groups.values())) if groups else np.zeros(0)
        axes.plot(
            100 * levels,
            100 * (pooled[:, None] <= bounds).mean(axis=0),
            color=BLUE,
            lw=1.6,
            label="all together",
        )
        axes.set(xlim=(0, 100), ylim=(0, 100), xlabel="interval's level [%]", ylabel="share that holds the truth [%]",
                 title=f"{len(answers)} answers called identified")  # fmt: skip
        axes.legend(loc="upper left")
        path.parent.mkdir(parents=True, exist_ok=True)
        FigureCanvasAgg(figure).print_figure(path, dpi=110, facecolor="white")
