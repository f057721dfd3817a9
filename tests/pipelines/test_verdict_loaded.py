"""What nobody gave is known of the loaded vehicle, not of the empty one, where the file states the load."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.results import Estimate, Prior
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.verdict.combine import combine
from pipelines.verdict.loaded import with_its_load

NOBODY = [Estimate("roll_map", "skipped", "no lateral acceleration")]
LOAD = {
    "mass_kg": Quantity(400, 10, "vehicle file"),
    "behind_front_axle_m": Quantity(2.4, 0.1, "vehicle file"),
}


def test_a_stated_load_moves_the_place_without_a_mass_in_the_file() -> None:
    vehicle = Vehicle(
        body="SUV", quantities={"cg_to_front_axle_m": Quantity(1.349, 0.013, "vehicle file")}, load=LOAD
    )
    place = combine(NOBODY, vehicle)["cg_to_front_axle_m"]
    assert place.value is not None
    assert place.std is not None
    assert abs(place.value - (1700 * 1.349 + 400 * 2.4) / 2100) < 0.01
    # the mass that the file does not give is in the spread
    assert place.std > 0.03
    assert place.prior is not None
    assert "with the stated load" in place.prior.source


def test_the_loaded_vehicle_is_that_of_draws() -> None:
    vehicle = Vehicle(
        quantities={
            "mass_kg": Quantity(1800, 36, "vehicle file"),
            "wheelbase_m": Quantity(2.8, 0.01, "vehicle file"),
        },
        load=LOAD,
    )
    mass = with_its_load("mass_kg", Prior(1800, 36, "vehicle file (empty vehicle)"), vehicle)
    assert (mass.value, mass.std) == (2200, pytest.approx(np.hypot(36, 10)))
    rng = np.random.default_rng(0)
    m, q, at, x = (rng.normal(*pair, 200_000) for pair in ((1800, 36), (400, 10), (2.4, 0.1), (1.3, 0.02)))
    drawn = (m * x + q * at) / (m + q)
    place = with_its_load("cg_to_front_axle_m", Prior(1.3, 0.02, "vehicle file (empty vehicle)"), vehicle)
    assert place.value == pytest.approx(drawn.mean(), abs=0.001)
    assert place.std == pytest.approx(drawn.std(), rel=0.02)
    inertia = with_its_load("pitch_inertia_kgm2", Prior(2700, 100, "vehicle file"), vehicle)
    assert 3000 < inertia.value < 3600
    assert inertia.std > 100


def test_no_load_changes_nothing() -> None:
    empty = Prior(1.3, 0.02, "vehicle file (empty vehicle)")
    assert with_its_load("cg_to_front_axle_m", empty, Vehicle()) is empty
    none = Vehicle(load={"mass_kg": Quantity(0, 5, "vehicle file")})
    assert with_its_load("cg_to_front_axle_m", empty, none) is empty
