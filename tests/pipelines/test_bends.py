"""Parameters that are products of unknowns are told by draws: by hand, and against draws of the same posterior."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.joint.bends import bent
from pipelines.joint.inference import infer
from pipelines.joint.information import slopes
from pipelines.joint.posterior import find_mode, values_at
from pipelines.joint.vehicle.outputs import outputs_of
from pipelines.joint.vehicle.unknowns import before_the_log
from tests.pipelines.joint_parts import linear, vehicle

KNOWN = before_the_log(vehicle())


def test_a_load_of_next_to_nothing_leaves_the_place_open_although_its_slope_is_nought() -> None:
    # a load whose mass is as unsure as its place: at the mode the slope by its place is next to nothing
    joint = find_mode([linear({"load": 1.0}, 30.0, 80.0)], KNOWN)
    middle, gradients = slopes(joint)
    # one drawing's spread scatters by 2.5 %
    tellings = [bent(joint, middle, gradients, np.random.default_rng(seed)) for seed in range(12)]
    assert all("mass_kg" not in told for told in tellings)
    places = [told["cg_to_front_axle_m"] for told in tellings]
    flat = np.sqrt(gradients["cg_to_front_axle_m"] @ joint.covariance @ gradients["cg_to_front_axle_m"])
    u = (
        joint.u
        + np.random.default_rng(2).standard_normal((40_000, len(joint.u)))
        @ np.linalg.cholesky(joint.covariance).T
    )
    whole = outputs_of(values_at(joint.known, u), {})["cg_to_front_axle_m"]
    spreads = [np.std(place) for place in places]
    assert np.mean(spreads) == pytest.approx(np.std(whole), rel=0.03)
    assert max(spreads) < 1.12 * np.std(whole)
    assert np.mean(places) == pytest.approx(np.mean(whole), abs=0.03 * np.std(whole))
    assert np.std(whole) > 1.3 * flat


def test_the_verdicts_interval_holds_what_bends() -> None:
    found = infer([linear({"load": 1.0}, 30.0, 80.0)], vehicle(), np.random.default_rng(0))
    assert found is not None
    joint = find_mode([linear({"load": 1.0}, 30.0, 80.0)], KNOWN)
    gradient = slopes(joint)[1]["cg_to_front_axle_m"]
    flat = float(np.sqrt(gradient @ joint.covariance @ gradient))
    std = found.parameters["cg_to_front_axle_m"].std
    assert std is not None
    assert std > 1.3 * flat
