"""What base_excitation_batch hands to the joint posterior: its own answer again, and a mass that moves with the springs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from plant_ride import RideCar, record, simulate, vehicle_of
from true_unknowns import joined

from parsers.drive import Drive
from pipelines.estimators.base_excitation.companion import BaseExcitationBatch
from pipelines.joint.vehicle.unknowns import before_the_log, body_of
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Quantity, Vehicle

CAR = RideCar()


def sprung(values: Mapping[str, float]) -> float:
    return body_of(values, None).sprung


def place(values: Mapping[str, float]) -> float:
    return body_of(values, None).whole_x


def car_file() -> Vehicle:
    """The car's file with a mass and a place that are hardly known, and no load in it."""
    made = vehicle_of(CAR)
    known = {
        **made.quantities, "mass_kg": Quantity(CAR.mass, 0.5 * CAR.mass, "test"),
        "cg_to_front_axle_m": Quantity(CAR.cg_to_front_axle, 1.0, "test"),
        # roll centres on the ground: no scrub
        "roll_center_height_front_m": Quantity(0.0, 0.001, "test"),
        "roll_center_height_rear_m": Quantity(0.0, 0.001, "test"),
    }  # fmt: skip
    return replace(made, quantities=known, load={"mass_kg": Quantity(0.0, 1.0, "test")})


@pytest.fixture(scope="module", name="drive")
def _drive() -> Drive:
    rng = np.random.default_rng(5)
    return record(*simulate(CAR, rng), rng)


def run(drive: Drive, file: Vehicle) -> Estimate:
    estimator = BaseExcitationBatch()
    return estimator.estimate(estimator.prepare(drive, {}), file, {}, np.random.default_rng(0))


def test_four_corners_give_back_mass_and_place(drive: Drive) -> None:
    file = car_file()
    found = run(drive, file)
    assert [(e.kind, e.carrier) for e in found.evidence] == [("ride", "hub accelerations")]
    posterior = joined(before_the_log(file), found.evidence)
    for name, output in (("sprung_mass_kg", sprung), ("cg_to_front_axle_m", place)):
        own = found.parameters[name]
        assert own.value is not None
        assert own.std is not None
        value, std = posterior.of(output)
        assert abs(value - own.value) < 0.4 * own.std, name
        # the joint does not know how curved the springs are
        assert 0.8 * own.std < std < 1.6 * own.std, name


def test_surer_springs_make_a_surer_mass(drive: Drive) -> None:
    file = car_file()
    exact = {
        key: replace(q, std=1e-4 * q.value) if key.startswith("spring_rate") else q
        for key, q in file.quantities.items()
    }
    sure = replace(file, quantities=exact)
    loose, tight = (joined(before_the_log(f), run(drive, f).evidence).of(sprung)[1] for f in (file, sure))
    assert tight < 0.95 * loose
    relation = run(drive, sure).evidence[0]
    same = run(drive, file).evidence[0]
    # the springs' doubt is the joint's, not the relation's
    assert np.allclose(relation.covariance, same.covariance)


def test_two_corners_tell_what_their_axle_carries(drive: Drive) -> None:
    rear = {n: s for n, s in drive.signals.items() if n.endswith(("_fl", "_fr"))}
    file = car_file()
    found = run(replace(drive, signals=rear), file)
    relation = found.evidence[0]
    assert len(relation.observed) == 1
    values = before_the_log(file).at(np.zeros(len(before_the_log(file).names)))
    true = CAR.sprung * (1 - CAR.behind / CAR.wheelbase) / 2
    assert float(relation.predict(values)[0]) == pytest.approx(true, rel=0.01)
    assert abs(float(relation.observed[0]) - true) < 2.5 * float(relation.covariance[0, 0]) ** 0.5


def test_a_smooth_road_tells_nothing() -> None:
    rng = np.random.default_rng(2)
    smooth = record(*simulate(CAR, rng, roughness_m=0.0005, seconds=60.0), rng)
    assert run(smooth, car_file()).evidence == ()
