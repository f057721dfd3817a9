"""What axle_load_gls hands to the joint posterior: it gives the estimator's own answer back, and says what is true."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from plant_axle_load import Lorry, Sensors, motion, record, vehicle
from true_unknowns import joined

from pipelines.estimators.axle_load_gls.estimator import AxleLoadGls
from pipelines.joint.vehicle.unknowns import before_the_log, body_of
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Quantity, Vehicle

BOTH = ("speed", "road_grade", "accel_x", "axle_load_front", "axle_load_rear")
REAR = ("speed", "road_grade", "accel_x", "axle_load_rear")
LORRY = Lorry()


def height(values: Mapping[str, float]) -> float:
    return body_of(values, None).whole_h


def place(values: Mapping[str, float]) -> float:
    return body_of(values, None).whole_x


def mass(values: Mapping[str, float]) -> float:
    return body_of(values, None).mass


def lorry_file(*, vague: bool = False) -> Vehicle:
    """The lorry's file; vague: height and mass hardly known."""
    made = vehicle(LORRY)
    share = 0.5 if vague else 0.01
    known = {
        **made.quantities,
        "mass_kg": Quantity(LORRY.mass, share * LORRY.mass, "test"),
        "cg_height_m": Quantity(1.0, 1.0, "test"),
        "cg_to_front_axle_m": Quantity(2.0, 2.0, "test"),
        "pitch_center_height_m": Quantity(0.175, 0.03, "test"),
    }
    return replace(made, quantities=known, load={**made.load, "height_m": Quantity(1.0, 0.5, "test")})


def run(file: Vehicle, names: tuple[str, ...], seed: int = 0, size: float = 1.3) -> Estimate:
    estimator = AxleLoadGls()
    drive = record(LORRY, motion(size=size), Sensors(), names, seed)
    return estimator.estimate(estimator.prepare(drive, {}), file, {}, np.random.default_rng(seed))


def test_alone_it_gives_back_the_estimators_own_figures() -> None:
    file = lorry_file(vague=True)
    found = run(file, BOTH)
    assert [(e.kind, e.carrier) for e in found.evidence] == [
        ("pitch", "axle loads"),
        ("vertical", "axle loads"),
    ]
    posterior = joined(before_the_log(file), found.evidence)
    for name, output in (("cg_height_m", height), ("cg_to_front_axle_m", place), ("mass_kg", mass)):
        own = found.parameters[name]
        assert own.value is not None
        assert own.std is not None
        value, std = posterior.of(output)
        assert abs(value - own.value) < 0.3 * own.std, name
        # the joint takes the sensors' scales for half as sure again
        assert 0.8 * own.std < std < 1.9 * own.std, name


def test_with_the_same_priors_it_is_the_estimators_posterior() -> None:
    file = lorry_file()
    found = run(file, REAR)
    assert [(e.kind, e.carrier) for e in found.evidence] == [("pitch", "rear axle load")]
    posterior = joined(before_the_log(file), found.evidence)
    own = found.parameters["cg_height_m"]
    assert own.value is not None
    assert own.std is not None
    value, std = posterior.of(height)
    assert abs(value - own.value) < 0.3 * own.std
    assert std == pytest.approx(own.std, rel=0.3)


def test_the_rear_axle_alone_teaches_an_unknown_load() -> None:
    made = lorry_file()
    file = replace(
        made, load={}, quantities={**made.quantities, "cg_to_front_axle_m": Quantity(1.5, 0.01, "test")}
    )
    known = before_the_log(file)
    found = run(file, REAR)
    before, after = joined(known, ()).of(height), joined(known, found.evidence).of(height)
    assert after[1] < 0.2 * before[1]
    assert abs(after[0] - LORRY.height) < 2.5 * after[1]


def test_a_calm_drive_tells_the_mean_load_alone_and_no_height() -> None:
    file = lorry_file()
    found = run(file, REAR, size=0.02)
    relation = found.evidence[0]
    assert found.parameters["cg_height_m"].status == "not_identifiable"
    assert len(relation.observed) == 1
    known = before_the_log(file)
    before, after = joined(known, ()), joined(known, found.evidence)
    assert after.of(height)[1] > 0.98 * before.of(height)[1]
    assert after.of(place)[1] < 0.1 * before.of(place)[1]


def test_loads_that_follow_no_force_tell_nothing() -> None:
    drive = record(LORRY, motion(), Sensors(), REAR)
    load = drive.signals["axle_load_rear"]
    turned = replace(load, values=2 * float(np.mean(load.values)) - load.values)
    wrong = replace(drive, signals={**drive.signals, "axle_load_rear": turned})
    estimator = AxleLoadGls()
    found = estimator.estimate(estimator.prepare(wrong, {}), lorry_file(), {}, np.random.default_rng(0))
    assert found.evidence == ()


@pytest.mark.parametrize("names", [BOTH, REAR])
def test_it_predicts_many_vehicles_at_once(names: tuple[str, ...]) -> None:
    file = lorry_file()
    known = before_the_log(file)
    rng = np.random.default_rng(1)
    many = known.mean + 0.3 * known.std * rng.standard_normal((5, len(known.mean)))
    for relation in run(file, names).evidence:
        own = {o.name: np.full(5, o.mean) for o in relation.own}
        found = relation.predict(dict(zip(known.names, many.T, strict=True)) | own)
        first = relation.predict(
            dict(zip(known.names, many[2].tolist(), strict=True)) | {o.name: o.mean for o in relation.own}
        )
        assert found.shape == (len(relation.observed), 5)
        assert np.allclose(found[:, 2], first)
