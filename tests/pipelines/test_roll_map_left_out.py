"""Where inertia and damping of the motion fit badly with what is known they are left out: and then nothing of them was measured."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pipelines.estimators.roll_map import vehicle as stage
from pipelines.estimators.roll_map.answers import Coefficients, quick_enough
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.model import WEAK_PRIOR
from pipelines.estimators.roll_map.posterior import expected_rest
from pipelines.results import ParameterEstimate
from pipelines.vehicles.vehicle import Quantity, Vehicle

NAMES = ("a", "b", "c")
WEAK = np.array([WEAK_PRIOR[name] for name in NAMES])
FILE = Vehicle(
    quantities={
        key: Quantity(value, std, "vehicle file")
        for key, value, std in (
            ("mass_kg", 1500.0, 10.0), ("cg_height_m", 0.55, 0.005), ("track_front_m", 1.55, 0.005), ("track_rear_m", 1.55, 0.005),
            ("roll_center_height_front_m", 0.08, 0.005), ("roll_center_height_rear_m", 0.12, 0.005), ("roll_inertia_kgm2", 600.0, 120.0),
        )
    },
    load={"mass_kg": Quantity(75.0, 2.0, "vehicle file"), "height_m": Quantity(0.7, 0.05, "vehicle file")},
)  # fmt: skip
A, B = 95.0, 6.0


@pytest.mark.parametrize(("away", "left_out"), [(0.0, False), (2.9, True)])
def test_an_inertia_that_was_left_out_is_not_told(
    away: float, left_out: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A load that the statics narrow looks like learning of the inertia: what counts is whether the motion's inertia was used."""
    asked: list[tuple[bool, bool]] = []
    own = stage.vehicle_answers

    def noted(*args: Any) -> dict[str, ParameterEstimate]:
        asked.append(args[4])
        return own(*args)

    monkeypatch.setattr(stage, "vehicle_answers", noted)
    rng = np.random.default_rng(1)
    before = stage.before_the_log(FILE, rng, 4000)
    assert before.draws is not None
    possible = before.draws.possible
    usual = np.asarray(expected_rest(before.draws, A, B, against_axles=False)[0])[possible]
    mean = np.array([A, B, float(usual.mean()) + away * float(usual.std())])
    spread = np.array([0.5, 0.4, 0.15 * float(usual.std())])
    coefficients = Coefficients(NAMES, mean, np.diag(spread**2), *WEAK.T)
    assert quick_enough(coefficients) == (True, True)
    data = cast("RollData", SimpleNamespace(against_axles=False, banked_share=0.0))
    found, _, said = stage.explain_vehicle(before, coefficients, data, FILE, rng)
    assert any("were left out" in sentence for sentence in said) is left_out
    assert asked == [(not left_out, not left_out)]
    assert (found["roll_inertia_kgm2"].status == "not_identifiable") is left_out
