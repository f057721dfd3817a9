"""Where no sensor shows how the body swings, no balance may tell its inertia by what usual springs would make of the accelerations."""

from __future__ import annotations

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file

from pipelines.analyze import run_estimator
from pipelines.estimators.load_balance.data import collect
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.joint.reached import reach
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.verdict.combine import verdict_of

RATES = (
    "spring_rate_front_npm", "spring_rate_rear_npm", "anti_roll_stiffness_front_nmprad", "anti_roll_stiffness_rear_nmprad",
)  # fmt: skip


@pytest.mark.parametrize(("stiffer", "inertia"), [(1.0, 2500.0), (2.5, 4500.0), (0.6, 3500.0)])
def test_inertias_are_not_told_by_guessed_motion(stiffer: float, inertia: float) -> None:
    """Weighed wheels and accelerometers alone: such a car was told 1550 ± 275 kg m² for 2500, and a lorry 18 400 ± 3200 for 40 500."""
    rng = np.random.default_rng(1)
    car = Car(spring_front=29e3 * stiffer, spring_rear=32e3 * stiffer, pitch_inertia=inertia)
    drive = logged(
        simulate(car, demand(200.0, rng), rng), rng, "suspension_deflection", "roll_rate", "pitch_rate"
    )
    file = vehicle_file(car, None, *RATES)
    estimate = run_estimator(LoadBalance(), drive, file, {}, 0)
    verdict = verdict_of([estimate], file)
    reached = reach(estimate.evidence, file, rng)
    assert reached is not None
    joint = reached.joint
    for axis in ("pitch", "roll"):
        told = verdict.parameters.get(f"{axis}_inertia_kgm2")
        # the wheels' loads tell how much is on board, and so may narrow what a load adds, but the vehicle's own inertia stays as known before
        assert told is None or told.status != "identified", axis
        row = joint.known.index(f"{axis}_inertia")
        assert abs(joint.u[row]) < 0.5, axis
        assert joint.covariance[row, row] > 0.9**2, axis
    height = verdict.parameters["cg_height_m"]
    assert height.value is not None
    assert height.std is not None
    assert abs(height.value - car.truth()["cg_height_m"]) < 1.4 * height.std


def test_what_is_guessed_and_what_is_measured_go_by_different_names() -> None:
    rng = np.random.default_rng(2)
    car = Car()
    columns = simulate(car, demand(60.0, rng), rng)
    known = before_the_log(vehicle_file(car, None))
    for left_out, names in (
        (("suspension_deflection", "roll_rate", "pitch_rate"), {"guessed_roll_acc", "guessed_pitch_acc"}),
        (("suspension_deflection", "pitch_rate"), {"roll_acc", "guessed_pitch_acc"}),
        (("roll_rate", "pitch_rate"), {"roll_acc", "pitch_acc"}),
        (("suspension_deflection",), {"roll_acc", "pitch_acc"}),
    ):
        data = collect(LoadBalance().prepare(logged(columns, rng, *left_out), {}), known, 2.0)
        assert {n for n in data.columns if n.removeprefix("guessed_") in ("roll_acc", "pitch_acc")} == names
