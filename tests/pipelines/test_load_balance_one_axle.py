"""load_balance where the deflections of one axle alone are there: what its springs carry against all that loads it."""

from __future__ import annotations

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file

from pipelines.estimators.load_balance.data import collect
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.estimators.load_balance.relations import (
    one_axle_terms,
    pitch_moments,
    relations,
    vertical_forces,
)
from pipelines.joint.vehicle.unknowns import before_the_log, body_of
from pipelines.results import FloatArray

ESTIMATOR = LoadBalance()
G = 9.80665


@pytest.fixture(scope="module")
def driven() -> tuple[Car, dict[str, FloatArray]]:
    rng = np.random.default_rng(5)
    car = Car()
    return car, simulate(car, demand(330, rng), rng)


@pytest.mark.parametrize("axle", ["front", "rear"])
def test_the_other_axles_forces_drop_out(axle: str) -> None:
    car = Car()
    known = before_the_log(vehicle_file(car, None))
    p = known.at(np.random.default_rng(3).standard_normal(len(known.names)))
    terms = one_axle_terms(axle, known)(p)
    other = "r" if axle == "front" else "f"
    largest = max(abs(terms[f"d_{axle[0]}{side}"]) for side in "lr")
    for name in ("d", "d2", "d3", "stop", "bump", "rebound", "stick"):
        for side in "lr":
            assert abs(terms[f"{name}_{other}{side}"]) < 1e-9 * max(
                largest, abs(terms[f"{name}_{axle[0]}{side}"])
            )


@pytest.mark.parametrize("axle", ["front", "rear"])
def test_it_is_a_sum_of_the_vertical_and_the_pitch_balance(axle: str) -> None:
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names)))
    body = body_of(p, None)
    sign, lever = (1.0, p["wheelbase"] - body.x) if axle == "front" else (-1.0, body.x)
    pitch, vertical = pitch_moments("deflection", p, body), vertical_forces("deflection", p, body)
    terms = one_axle_terms(axle, known)(p)
    for name in pitch.keys() | vertical.keys():
        expected = sign * pitch.get(name, 0.0) + lever * vertical.get(name, 0.0)
        assert terms[name] == pytest.approx(expected, abs=1e-6), name


@pytest.mark.parametrize("axle", ["front", "rear"])
def test_at_rest_it_is_the_axles_load(axle: str) -> None:
    """Standing still, springs that carry L S = W times the other axle's distance: the lever rule."""
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names)))
    body, end = body_of(p, None), axle[0]
    share = p["wheelbase"] - body.x if axle == "front" else body.x
    carried = body.sprung * G * share / p["wheelbase"]
    empty = p["empty_x"] / p["wheelbase"]
    bare = G * (p["empty_mass"] * (1 - empty if axle == "front" else empty) - p[f"unsprung_{axle}"])
    d = (carried - bare) / (2 * p[f"spring_{axle}"])
    terms = one_axle_terms(axle, known)(p)
    row = {"one": 1.0, "fz": G, f"d_{end}l": d, f"d_{end}r": d, f"d2_{end}l": d * d, f"d2_{end}r": d * d}
    row |= {f"d3_{end}l": d**3, f"d3_{end}r": d**3}
    assert sum(terms[name] * value for name, value in row.items()) == pytest.approx(
        0.0, abs=0.02 * carried * p["wheelbase"]
    )


@pytest.mark.parametrize(
    ("lost", "axle"), [("suspension_deflection_f", "rear"), ("suspension_deflection_r", "front")]
)
def test_recovers_what_was_planted(driven: tuple[Car, dict[str, FloatArray]], lost: str, axle: str) -> None:
    car, columns = driven
    for seed in (1, 2):
        rng = np.random.default_rng(seed)
        drive = logged(columns, rng, "suspension_force", lost)
        file = vehicle_file(car, rng)
        prepared = ESTIMATOR.prepare(drive, {})
        known = before_the_log(file)
        names = [r.name for r in relations(collect(prepared, known, 2.0), known)]
        assert names == [f"{axle} axle by {axle} spring deflections"]
        found = ESTIMATOR.estimate(prepared, file, {}, np.random.default_rng(0)).parameters
        for name in ("mass_kg", "cg_to_front_axle_m", "cg_height_m"):
            answer = found[name]
            assert answer.value is not None
            assert answer.std is not None
            assert answer.reference is not None
            assert abs(answer.value - answer.reference) < 3 * answer.std, name
        assert found["mass_kg"].status != "not_identifiable"
        alone = logged(columns, np.random.default_rng(seed), "suspension_force", "suspension_deflection")
        torques = ESTIMATOR.estimate(
            ESTIMATOR.prepare(alone, {}), file, {}, np.random.default_rng(0)
        ).parameters
        before, after = torques["mass_kg"].std, found["mass_kg"].std
        assert before is not None
        assert after is not None
        assert after < before


def test_one_wheel_alone_tells_nothing(driven: tuple[Car, dict[str, FloatArray]]) -> None:
    car, columns = driven
    drive = logged(
        columns,
        np.random.default_rng(1),
        "suspension_force",
        "suspension_deflection_r",
        "suspension_deflection_fl",
    )
    known = before_the_log(vehicle_file(car, None))
    data = collect(ESTIMATOR.prepare(drive, {}), known, 2.0)
    assert data.one_axle == ()
    assert relations(data, known) == ()


def test_gravity_that_stands_for_an_accelerometer_is_not_turned(
    driven: tuple[Car, dict[str, FloatArray]],
) -> None:
    """What is read along the body's normal is brought to the road's by its lean; gravity is there already."""
    car, columns = driven
    known = before_the_log(vehicle_file(car, None))
    for lost, turned in (("suspension_force", True), ("accel_z", False)):
        drive = logged(columns, np.random.default_rng(1), "suspension_force", lost)
        data = collect(ESTIMATOR.prepare(drive, {}), known, 2.0)
        balance = next(r for r in relations(data, known) if r.name.startswith("vertical"))
        table = dict(zip(balance.columns, balance.table.T, strict=True))
        assert bool(np.ptp(table["fz"]) > 0) == turned
        assert bool(np.any(table.get("fz_tilt", np.zeros(1)))) == turned
