"""Parts of the roll model on drives that are too long to fit several models to: their liveliest stretches choose, and the words say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.roll_map import choose, fit
from pipelines.estimators.roll_map.choose import Asked, fit_models
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.model import STANDARD, Known, known_parameters
from pipelines.estimators.roll_map.spectrum import Shifter
from pipelines.estimators.roll_map.words import model_parts
from tests.pipelines.test_roll_map_parts import _planted


def _known(data: RollData, parts: frozenset[str]) -> tuple[Known, ...]:
    return known_parameters(data, None, 0.2, 0.05, None, parts)


@pytest.mark.parametrize(("planted", "asked"), [({"smoothing": 3e-3}, {"smoothing"}), ({}, set())])
def test_the_liveliest_stretches_choose(
    planted: dict[str, float], asked: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    data = _planted(planted, 3)
    monkeypatch.setattr(choose, "MOST_ROWS", data.size - 1)
    wanted: list[int] = []

    def liveliest(most: int) -> RollData:
        wanted.append(most)
        return data

    found = fit_models(data, Asked(_known, np.array([data.size]), liveliest))
    assert wanted == [data.size - 1]
    assert found.mixed is None
    assert found.verdict is not None
    assert found.verdict.liveliest_s == pytest.approx(data.size * data.step_s)
    assert found.verdict.supported == asked
    assert {k.name for k in found.known} >= STANDARD | asked
    assert ("smoothing" in {k.name for k in found.known}) == bool(asked)
    said = model_parts(found)
    assert "held-out stretches of the drive's liveliest 0.7 min" in said
    assert "springs that stiffen and dry friction" in said


def test_without_lively_stretches_the_usual_model_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    data = _planted({}, 2)
    monkeypatch.setattr(choose, "MOST_ROWS", 100)
    found = fit_models(data, Asked(_known, np.array([data.size]), lambda _: None))
    assert found.verdict is None
    assert {k.name for k in found.known} >= STANDARD
    assert model_parts(found) == ""


@pytest.mark.parametrize("short", [False, True])
def test_a_channel_that_begins_later_is_waited_for(short: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    data = _planted({}, 3)
    n = data.size
    starts, stops = np.array([0, 400]), np.array([400, n])
    if short:
        starts = np.arange(0, n - 39, 40)
        stops = starts + 40
    rate = data.rate.copy()
    rate[:400] = np.nan
    late = replace(
        data, starts=starts, stops=stops, rate=rate, whole_rate=rate,
        shifter=Shifter(data.accel, starts, stops, 1 / data.step_s, held=True),
    )  # fmt: skip
    monkeypatch.setattr(fit, "START_ROWS", 200)
    part = fit._part(late, 200)
    assert np.isfinite(part.rate).any()
    assert part.stops[-1] == part.size
    if not short:
        values = fit.fit_roll(late, _known(late, STANDARD), np.array([n])).values
        # the second segment does not begin at rest, as the model does
        assert values["a"] == pytest.approx(110, rel=0.15)
