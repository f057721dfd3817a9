"""All settings over noise seeds against the Cramér-Rao bound; and on a car that the model is not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.reproduce.base import Progress, StudyRow, study_row
from pipelines.reproduce.gpc_map.methods import Method, bound, measured
from pipelines.reproduce.gpc_map.setup import NAMES, SETTINGS, UNITS, Bench, Setting
from pipelines.results import FloatArray

RATIO_TARGET = 2.0


@dataclass(frozen=True)
class Runs:
    """MAP (runs, 3) and 95 % intervals (runs, 3, 2)."""

    values: FloatArray
    intervals: FloatArray


def repeated(
    place: Bench, method: Method, runs: int, rng: np.random.Generator, *, seven: bool = False
) -> Runs:
    """Over so many draws of noise."""
    values, intervals = [], []
    for _ in range(runs):
        found = method.fit(measured(place, rng, seven=seven), rng)
        last = found.steps[-1]
        values.append(last.map_value)
        intervals.append(np.column_stack((last.low, last.high)))
    return Runs(np.array(values), np.array(intervals))


def _rows(
    words: str, way: str, place: Bench, seconds: float, found: Runs, target: float | None, remark: str
) -> list[StudyRow]:
    limits = bound(place, seconds)
    return [
        study_row(
            words, way, name, unit, float(place.car.truth[j]), found.values[:, j], found.intervals[:, j],
            float(limits[j]), target, remark,
        )
        for j, (name, unit) in enumerate(zip(NAMES, UNITS, strict=True))
    ]  # fmt: skip


def study(place: Bench, runs: int, rng: np.random.Generator, progress: Progress) -> list[StudyRow]:
    """Eight settings on the matched body; then the seven-degree-of-freedom car, with and without its warp in the model."""
    rows: list[StudyRow] = []
    for number, setting in enumerate(SETTINGS):
        progress(f"study: run {setting.run}", 0.2 + 0.08 * number)
        words = f"run {setting.run}: order {setting.order}, {setting.intervals} x {setting.interval_s:g} s"
        found = repeated(place, Method(place, setting), runs, rng)
        rows += _rows(words, "domain follows", place, setting.seconds, found, RATIO_TARGET, "")
    setting = Setting(0, SETTINGS[0].mean, 4, 12.0, 2, (0.0,) * 3, (0.0,) * 3)
    for number, warp in enumerate((False, True)):
        progress("study: seven degrees of freedom", 0.86 + 0.06 * number)
        method = Method(place, setting, warp=warp)
        found = repeated(place, method, runs, rng, seven=True)
        words = "seven-degree-of-freedom car, 24 s"
        way = "with the hubs' warp" if warp else "hubs as a plane, (86)-(88)"
        remark = "" if warp else "The interval knows nothing of what the model leaves out."
        rows += _rows(words, way, place, setting.seconds, found, None, remark)
    return rows
