"""Axle loads of straight driving (Wu et al., (1)-(2)) from the longitudinal specific force, which holds the grade already."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pipelines.bayes.priors import Known
from pipelines.models.axle_load import GRAVITY, GRAVITY_SHARE
from pipelines.models.described.common import about, usual
from pipelines.models.record import Given, Model, ModelParameter
from pipelines.results import FloatArray
from pipelines.vehicles.usual import usual_radius, usual_rolling
from pipelines.vehicles.vehicle import Quantity, Vehicle

PARAMETERS = (
    ModelParameter("mass_kg", "Mass", "kg", 100.0, 80_000.0, 0.01),
    ModelParameter("cg_to_front_axle_m", "CG to front axle", "m", 0.05, 15.0, 0.01),
    ModelParameter("cg_height_m", "CG height above ground", "m", 0.1, 5.0, 0.03),
)


def _usual(of: Callable[[Vehicle], tuple[float, float]]) -> Callable[[Vehicle], Quantity]:
    """What vehicles of its kind have, where the file is silent."""
    return lambda vehicle: Quantity(*of(vehicle), "usual")


GIVEN = (
    Given("wheelbase_m", "the lever of the load transfer"),
    Given(
        "rolling_resistance",
        "it moves load to the rear axle, as if the CG were further back",
        _usual(usual_rolling),
    ),
    Given("wheel_radius_m", "the lever of rolling resistance", _usual(usual_radius)),
    Given(
        "gravity_mps2",
        "what a load makes of a mass",
        Quantity(GRAVITY, GRAVITY_SHARE * GRAVITY, "anywhere on earth"),
    ),
    Given(
        "accel_x_zero_mps2", "an accelerometer's zero reads as the CG's place", Quantity(0.0, 0.05, "usual")
    ),
)
"""The last two are no vehicle's: they are allowances."""


def predict(values: FloatArray, inputs: FloatArray, step_s: float, given: Mapping[str, float]) -> FloatArray:
    """Front and rear axle load (Q, n, 2) in N from the longitudinal specific force (n, 1): static, without memory."""
    mass, behind, height = (column[:, None] for column in values.T)
    length, gravity = given["wheelbase_m"], given["gravity_mps2"]
    rolling = given["rolling_resistance"] * given["wheel_radius_m"]
    force = inputs[None, :, 0] - given["accel_x_zero_mps2"]
    rear = mass * (gravity * (behind + rolling) + height * force) / length
    return np.stack((mass * gravity - rear, rear), axis=2)


def priors(vehicle: Vehicle) -> dict[str, Known]:
    """The empty vehicle's mass and up to as much again; its CG inside the wheelbase; any height."""
    mass, length, height = (vehicle.get(key) for key in ("mass_kg", "wheelbase_m", "cg_height_m"))
    low, high = (0.8 * mass.value, 2.2 * mass.value) if mass is not None else (500.0, 50_000.0)
    base = length.value if length is not None else 3.0
    found = {
        "mass_kg": usual("mass_kg", low, high, "from the empty vehicle's to twice that"),
        "cg_to_front_axle_m": usual("cg_to_front_axle_m", 0.2 * base, 0.85 * base, "inside of the wheelbase"),
        "cg_height_m": usual("cg_height_m", 0.3, 3.0, "any vehicle"),
    }
    if height is not None:
        found["cg_height_m"] = about("cg_height_m", height, 0.1, 5.0, 0.1)
    return found


MODEL = Model(
    name="axle_load",
    title="Axle loads from longitudinal acceleration",
    source="Wu et al., equations (1)-(2), with the specific force in place of acceleration and grade",
    parameters=PARAMETERS,
    inputs=("accel_x",),
    outputs=("axle_load_front", "axle_load_rear"),
    given=GIVEN,
    predict=predict,
    priors=priors,
    band_hz=(0.0, 0.7),
    cutoff_hz=2.0,
    settle_s=0.0,
    note="wheel spin and pitching are left out; the loads' offsets count as load",
    centred=False,
    least_input=0.2,
)
