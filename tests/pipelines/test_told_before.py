"""What was known before the log, as it is told: no vehicle is lighter than its empty one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.joint.inference import infer
from pipelines.joint.information import prior_spreads
from pipelines.joint.vehicle.unknowns import before_the_log
from tests.pipelines.joint_parts import linear, vehicle


def test_a_mass_that_no_drive_tells_is_not_below_the_empty_vehicles() -> None:
    found = infer([linear({"imu_h": 1.0}, 0.5, 0.1)], vehicle(), np.random.default_rng(0))
    assert found is not None
    mass, sprung = (found.parameters[n] for n in ("mass_kg", "sprung_mass_kg"))
    assert mass.status == sprung.status == "not_identifiable"
    assert mass.low == pytest.approx(1900 - 2 * 19)
    assert sprung.low is not None
    assert 1600 < sprung.low < 1900 - 2 * 19
    assert mass.high is not None
    assert mass.high > 2200


def test_what_answers_are_held_against_is_as_it_was() -> None:
    """The normal law, tails below nothing included: posteriors have them too."""
    known = before_the_log(vehicle())
    spread = prior_spreads(known, (), np.random.default_rng(0))["mass_kg"]
    assert spread.interval[0] < spread.shown[0]
    assert spread.interval[1] == spread.shown[1]
    other = prior_spreads(known, (), np.random.default_rng(0))["cg_height_m"]
    assert other.interval == other.shown


def test_without_a_stated_mass_there_is_no_such_bound() -> None:
    file = vehicle()
    silent = replace(file, quantities={n: q for n, q in file.quantities.items() if n != "mass_kg"})
    spread = prior_spreads(before_the_log(silent), (), np.random.default_rng(0))["mass_kg"]
    assert spread.interval == spread.shown
