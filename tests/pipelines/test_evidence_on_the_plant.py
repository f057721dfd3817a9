"""Relations of the estimators on the full plant: as far from what its true figures predict as they claim, and no farther."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from true_unknowns import chi2, joined, misfit, random_drive, true_unknowns

from pipelines.estimators.axle_load_gls.estimator import AxleLoadGls
from pipelines.estimators.base import Estimator
from pipelines.estimators.base_excitation.companion import BaseExcitationBatch
from pipelines.estimators.brake_roll.estimator import BrakeRollBatch
from pipelines.estimators.load_transfer.companion import LoadTransferBatch
from pipelines.estimators.roll_pitch_plane.pitch import PitchPlane
from pipelines.estimators.roll_pitch_plane.roll import RollPlane
from pipelines.evidence import Evidence
from pipelines.joint.vehicle.unknowns import before_the_log, body_of
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.simulation.logs.drive import SimulatedLog
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

CARS = ("suv", "sedan", "van")
DRIVES = 3
CASES: dict[str, tuple[Estimator, tuple[str, ...], tuple[str, ...], str]] = {
    "axle": (AxleLoadGls(), ("truck_flat", "truck_slope"), ("truck",), "axle_load"),
    "ride": (BaseExcitationBatch(), ("off_road", "rough_straight"), CARS, "vertical"),
    "braking": (BrakeRollBatch(), ("launch_and_stop", "slalom"), CARS, "ins"),
    "struts": (LoadTransferBatch(), ("launch_and_stop", "slalom"), CARS, "struts"),
    "roll plane": (RollPlane(), ("slalom", "off_road"), CARS, "everything"),
    "pitch plane": (PitchPlane(), ("launch_and_stop", "off_road"), CARS, "everything"),
}  # fmt: skip
Made = tuple[SimulatedLog, Vehicle, tuple[Evidence, ...]]


def driven(estimator: Estimator, made: SimulatedLog) -> tuple[Vehicle, tuple[Evidence, ...]]:
    vehicle = parse_vehicle(made.sheet, Path("vehicle.toml"))
    prepared = estimator.prepare(drive_of(made.log), {})
    return vehicle, estimator.estimate(prepared, vehicle, {}, np.random.default_rng(0)).evidence


@pytest.fixture(scope="module", name="drives", params=tuple(CASES))
def _drives(request: pytest.FixtureRequest) -> list[Made]:
    estimator, manoeuvres, vehicles, sensors = CASES[request.param]
    found = []
    for seed in range(DRIVES):
        made = random_drive(seed, manoeuvres, vehicles, sensors)
        found.append((made, *driven(estimator, made)))
    return found


def test_relations_say_what_is_true(drives: list[Made]) -> None:
    total, numbers = 0.0, 0
    for made, vehicle, relations in drives:
        truth = true_unknowns(made, vehicle)
        for relation in relations:
            off, covariance = misfit(relation, truth)
            assert np.abs(off / np.sqrt(np.diag(covariance))).max() < 3.5
            value, count = chi2(relation, truth)
            total, numbers = total + value, numbers + count
    assert numbers >= 2
    # a spread that is wide by four times would be as useless as one that is narrow
    assert 0.02 < total / numbers < 1.8


def test_relations_are_whole(drives: list[Made]) -> None:
    for _, vehicle, relations in drives:
        known = before_the_log(vehicle)
        for relation in relations:
            assert set(relation.unknowns) <= {*known.names, *(o.name for o in relation.own)}
            assert np.linalg.eigvalsh(relation.covariance).min() > 0
            values = known.at(np.zeros(len(known.names))) | {o.name: o.mean for o in relation.own}
            base = relation.predict(values)
            spreads = dict(zip(known.names, known.std, strict=True)) | {o.name: o.std for o in relation.own}
            moved = {
                n for n, std in spreads.items()
                if not np.allclose(relation.predict(values | {n: values[n] + 0.1 * std}), base, rtol=1e-12, atol=0)
            }  # fmt: skip
            assert moved <= set(relation.unknowns)
            many = relation.predict({n: np.full(3, v) for n, v in values.items()})
            assert np.allclose(many, base[:, None])


def test_a_rear_axle_load_teaches_height_and_load_of_a_truck() -> None:
    estimator, manoeuvres, vehicles, sensors = CASES["axle"]
    made = random_drive(0, manoeuvres, vehicles, sensors)
    vehicle, relations = driven(estimator, made)
    known = before_the_log(vehicle)
    for output, name in (
        (lambda v: body_of(v, None).whole_h, "cg_height_m"),
        (lambda v: body_of(v, None).mass, "mass_kg"),
    ):
        before, after = joined(known, ()).of(output), joined(known, relations).of(output)
        assert after[1] < 0.75 * before[1]
        assert abs(after[0] - made.run.truth[name]) < 2.5 * after[1]


def test_a_drive_that_cannot_tell_tells_nothing() -> None:
    circle = random_drive(1, ("steady_circle",), ("suv",), "vertical")
    assert driven(BaseExcitationBatch(), circle)[1] == ()
    straight = random_drive(1, ("launch_and_stop",), ("suv",), "struts")
    assert driven(RollPlane(), straight)[1] == ()
    by_kind = {r.kind: len(r.observed) for r in driven(LoadTransferBatch(), straight)[1]}
    # nothing rolled: of the roll moment only its mean, and the diagonals
    assert by_kind == {"vertical": 1, "pitch": 3, "roll": 2}
