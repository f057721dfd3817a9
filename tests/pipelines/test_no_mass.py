"""A vehicle file without a mass: stiffness and inertia are told only where the log tells the mass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.evidence import Evidence
from pipelines.joint.inference import infer
from pipelines.joint.no_mass import GIVE_MASS, SCALED
from pipelines.results import ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle
from tests.pipelines.joint_parts import linear, of_output, vehicle


def _entries(file: Vehicle, *more: Evidence) -> dict[str, ParameterEstimate]:
    per_kilo = of_output(
        lambda out: np.log(out["roll_stiffness_nmprad"] / out["mass_kg"]),
        float(np.log(45.0)),
        0.02,
        kind="roll",
    )
    found = infer([per_kilo, *more], file, np.random.default_rng(0))
    assert found is not None
    return dict(found.parameters)


def _no_mass() -> Vehicle:
    """Tracks and wheelbase alone, as of a vehicle of which nobody says what it is."""
    whole = vehicle()
    few = {k: v for k, v in whole.quantities.items() if k.startswith(("wheelbase", "track"))}
    return replace(whole, body=None, quantities=few)


def test_nothing_that_goes_with_the_mass_is_told_where_nothing_tells_it() -> None:
    told = _entries(_no_mass())
    assert told["mass_kg"].status == "not_identifiable"
    scaled = [entry for name, entry in told.items() if name.endswith(SCALED)]
    assert len(scaled) > 8
    for entry in scaled:
        assert (entry.value, entry.low, entry.status) == (None, None, "not_identifiable")
        assert "mass_kg" in entry.reason
    assert all("inf" not in entry.reason for entry in told.values())
    assert GIVE_MASS in told["cg_height_m"].reason


def test_a_log_that_tells_the_mass_tells_what_goes_with_it() -> None:
    kilos = linear({"empty_mass": 1.0, "load": 1.0}, 2100.0, 30.0)
    told = _entries(_no_mass(), replace(kilos, kind="longitudinal"))
    assert told["mass_kg"].value == pytest.approx(2100.0, rel=0.02)
    stiffness = told["roll_stiffness_nmprad"]
    assert stiffness.value is not None
    assert stiffness.value == pytest.approx(45.0 * 2100.0, rel=0.06)


def test_a_file_with_a_mass_is_as_ever() -> None:
    told = _entries(vehicle())
    assert told["roll_stiffness_nmprad"].value is not None
    assert GIVE_MASS not in told["roll_stiffness_nmprad"].reason
