"""Figures that remember what followed from them say the same as any other mapping."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Mapping
from dataclasses import fields

import numpy as np
import pytest

from pipelines.joint.posterior import values_at
from pipelines.joint.vehicle.body import body_of
from pipelines.joint.vehicle.laden import pressed, rate_under_load, roll_center, widened
from pipelines.joint.vehicle.remembered import Remembered, once
from pipelines.joint.vehicle.unknowns import before_the_log
from tests.pipelines.joint_parts import vehicle


def test_a_figure_is_reckoned_once_until_one_changes() -> None:
    asked: list[str] = []

    @once
    def doubled(p: Mapping[str, float], name: str) -> float:
        asked.append(name)
        return 2 * p[name]

    p = Remembered({"mass": 3.0, "height": 0.5})
    assert [doubled(p, name) for name in ("mass", "mass", "height")] == [6.0, 6.0, 1.0]
    assert asked == ["mass", "height"]
    p["mass"] = 4.0
    assert doubled(p, "mass") == 8.0
    assert doubled({"mass": 1.0}, "mass") == doubled({"mass": 1.0}, "mass") == 2.0
    assert asked == ["mass", "height", "mass", "mass", "mass"]


def test_a_copy_remembers_nothing() -> None:
    p = Remembered({"mass": 3.0})
    p.memo["what", "key"] = 1.0
    for other in (Remembered(p), {**p, "mass": 4.0}, p | {"mass": 4.0}):
        assert not getattr(other, "memo", {})
    for sent in (pickle.loads(pickle.dumps(p)), copy.deepcopy(p), copy.copy(p)):
        assert type(sent) is dict
        assert sent == {"mass": 3.0}


@pytest.mark.parametrize("function", [pressed, rate_under_load, roll_center, widened])
@pytest.mark.parametrize("axle", ["front", "rear"])
def test_vehicles_that_remember_are_the_same_vehicles(function: object, axle: str) -> None:
    known = before_the_log(vehicle())
    values = values_at(known, np.random.default_rng(3).standard_normal((20, len(known.names))))
    assert callable(function)
    for _ in range(2):
        assert np.array_equal(function(values, axle), function(dict(values), axle))


@pytest.mark.parametrize("sag", [None, 0.02])
def test_a_body_that_is_remembered_is_the_same_body(sag: float | None) -> None:
    known = before_the_log(vehicle())
    values = values_at(known, np.random.default_rng(4).standard_normal((20, len(known.names))))
    first, again = body_of(values, sag), body_of(dict(values), sag)
    assert body_of(values, sag) is first
    for field in fields(first):
        assert np.array_equal(getattr(first, field.name), getattr(again, field.name))
