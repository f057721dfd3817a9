"""Parts of the roll model on drives that are too long to fit several models to: their liveliest stretches choose, and the words say so."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.roll_map import choose
from pipelines.estimators.roll_map.choose import Asked, fit_models
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.model import STANDARD, Known, known_parameters
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

    fit = fit_models(data, Asked(_known, np.array([data.size]), liveliest))
    assert wanted == [data.size - 1]
    assert fit.mixed is None
    assert fit.verdict is not None
    assert fit.verdict.liveliest_s == pytest.approx(data.size * data.step_s)
    assert fit.verdict.supported == asked
    assert {k.name for k in fit.known} >= STANDARD | asked
    assert ("smoothing" in {k.name for k in fit.known}) == bool(asked)
    said = model_parts(fit)
    assert "held-out stretches of the drive's liveliest 0.7 min" in said
    assert "springs that stiffen and dry friction" in said


def test_without_lively_stretches_the_usual_model_stands(monkeypatch: pytest.MonkeyPatch) -> None:
    data = _planted({}, 2)
    monkeypatch.setattr(choose, "MOST_ROWS", 100)
    fit = fit_models(data, Asked(_known, np.array([data.size]), lambda _: None))
    assert fit.verdict is None
    assert {k.name for k in fit.known} >= STANDARD
    assert model_parts(fit) == ""
