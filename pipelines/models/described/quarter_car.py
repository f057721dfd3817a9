"""One wheel's corner by base excitation (Pence, Fathy & Stein, (1)-(2)): the front left one, as an example of a small model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipelines.bayes.priors import Known, Normal
from pipelines.models.base_excitation import between_samples, body_response
from pipelines.models.described.common import sprung_share, usual
from pipelines.models.record import Given, Model, ModelParameter
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

PARAMETERS = (
    ModelParameter("corner_sprung_mass_kg", "Mass that the corner seems to carry", "kg", 10.0, 20_000.0, 0.1),
    ModelParameter("damper_extension_nspm", "Damper in extension", "N·s/m", 20.0, 200_000.0, 0.1),
    ModelParameter("damper_compression_nspm", "Damper in compression", "N·s/m", 20.0, 200_000.0, 0.1),
)
GIVEN = (Given("spring_rate_front_npm", "the mass comes in proportion to the spring"),)


def predict(values: FloatArray, inputs: FloatArray, step_s: float, given: Mapping[str, float]) -> FloatArray:
    """Body acceleration over the wheel (Q, n, 1) from the hub's (n, 1)."""
    hub = np.ascontiguousarray(inputs[:, 0])
    middle = between_samples(hub)
    spring = given["spring_rate_front_npm"]
    out = np.empty((len(values), len(hub), 1))
    for q, (mass, extension, compression) in enumerate(values):
        dampers = (float(extension), float(compression))
        out[q, :, 0] = body_response(hub, step_s, float(mass), spring, dampers, middle=middle)
    return out


def priors(vehicle: Vehicle) -> dict[str, Known]:
    """A quarter of the sprung mass, more or less; dampers from the vehicle file, with other slopes either way."""
    mass, damper = vehicle.get("mass_kg"), vehicle.get("damper_rate_front_nspm")
    quarter = 0.25 * sprung_share(vehicle) * (mass.value if mass is not None else 1_600.0)
    found = {
        "corner_sprung_mass_kg": usual("corner_sprung_mass_kg", 0.4 * quarter, 2.5 * quarter, "0.4 to 2.5 of a quarter"),
        "damper_extension_nspm": usual("damper_extension_nspm", 2 * quarter, 25 * quarter, "2 to 25 N·s/m a kg"),
        "damper_compression_nspm": usual("damper_compression_nspm", 1 * quarter, 20 * quarter, "1 to 20 N·s/m a kg"),
    }  # fmt: skip
    if damper is not None:
        for name, share in (("damper_extension_nspm", 1.3), ("damper_compression_nspm", 0.7)):
            value = share * damper.value
            found[name] = Known(
                name, Normal(value, 0.3 * value, 0.15 * value, 4 * value), True, damper.source
            )
    return found


MODEL = Model(
    name="quarter_car",
    title="One corner over its hub (front left)",
    source="Pence, Fathy & Stein, equations (1)-(2), two damper slopes",
    parameters=PARAMETERS,
    inputs=("accel_z_unsprung_fl",),
    outputs=("accel_z_sprung_fl",),
    given=GIVEN,
    predict=predict,
    priors=priors,
    band_hz=(0.5, 12.0),
    cutoff_hz=40.0,
    settle_s=3.0,
    note="the mass holds a part of the body's inertias and of the anti-roll bar: it is not the corner's static share",
    least_input=1.0,
    least_explained=0.6,
)
