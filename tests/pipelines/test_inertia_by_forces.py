"""Roll inertia where struts' forces were set against roll acceleration: the doubt about what swings with the body is halved."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from true_unknowns import random_drive

from pipelines.estimators.roll_pitch_plane.roll import RollPlane
from pipelines.joint.information import slopes
from pipelines.joint.posterior import Joint, find_mode
from pipelines.joint.vehicle.outputs import INERTIA_BY_FORCES, outputs_of
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.simulation.loads import truth
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

INERTIA = "roll_inertia_kgm2"


def by_factor(given: dict[str, float]) -> float:
    """Relative change of the inertia for a factor that is 8 % more."""
    known = before_the_log(Vehicle("test", "SUV", {}))
    values = known.at(np.zeros(len(known.names)))
    more = values | {"inertia_factor": 1.08}
    return float(outputs_of(more, given)[INERTIA] / outputs_of(values, given)[INERTIA]) - 1


def told(joint: Joint) -> tuple[float, float]:
    """The roll inertia and its spread."""
    value, gradient = (part[INERTIA] for part in slopes(joint))
    return float(value), float(np.sqrt(gradient @ joint.covariance @ gradient))


def test_motion_alone_tells_no_inertia_better_than_what_swings() -> None:
    assert by_factor({}) == pytest.approx(0.08)
    assert by_factor({INERTIA_BY_FORCES: 0.5}) == pytest.approx(0.04)


def test_forces_tell_the_roll_inertia_better_and_hold_it() -> None:
    z, ratios = [], []
    for seed in range(3):
        made = random_drive(seed, ("slalom", "off_road"), ("suv", "sedan", "van"), "everything")
        vehicle = parse_vehicle(made.sheet, Path("vehicle.toml"))
        method = RollPlane()
        result = method.estimate(
            method.prepare(drive_of(made.log), {}), vehicle, {}, np.random.default_rng(0)
        )
        joint = find_mode(result.evidence, before_the_log(vehicle))
        value, std = told(joint)
        ratios.append(std / told(replace(joint, given={}))[1])
        car = made.choice.vehicle
        z.append((value - truth(car, made.choice.loads)["roll_inertia_kgm2"]) / std)
    assert max(ratios) < 0.9
    assert np.abs(z).max() < 3.0
