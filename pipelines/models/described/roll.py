"""Roll of the body from its lateral acceleration, with no tyres and no yaw: Berntorp et al., (1)-(4), as a simulation."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from parsers.jit import kernel
from pipelines.bayes.priors import Known, Normal
from pipelines.models.described.common import about, sprung_share, usual
from pipelines.models.record import Given, Model, ModelParameter
from pipelines.models.roll import RollCoefficients, discretise
from pipelines.results import FloatArray
from pipelines.vehicles.usual import usual_unsprung
from pipelines.vehicles.vehicle import Quantity, Vehicle

PARAMETERS = (
    ModelParameter("roll_stiffness_nmprad", "Roll stiffness", "N·m/rad", 2_000.0, 5_000_000.0, 0.15),
    ModelParameter("roll_damping_nmsprad", "Roll damping", "N·m·s/rad", 50.0, 500_000.0, 0.2),
    ModelParameter("sprung_roll_inertia_kgm2", "Roll inertia of the sprung mass about its CG", "kg·m²", 10.0, 100_000.0, 0.3),
    ModelParameter("roll_arm_m", "Sprung CG height above roll axis", "m", 0.05, 3.0, 0.15),
    ModelParameter("imu_above_roll_axis_m", "Accelerometer above the roll axis", "m", -1.0, 3.0, 0.1, True),
)  # fmt: skip
"""Model errors are large: tyres give way in series with the suspension, a fifth of the roll angle on a car."""


def _usual_hubs(axle: str) -> Callable[[Vehicle], Quantity]:
    """An axle's unsprung mass where the vehicle file is silent."""

    def found(vehicle: Vehicle) -> Quantity:
        mass = vehicle.get("mass_kg")
        heavy = 1_600.0 if mass is None else mass.value
        return Quantity(*usual_unsprung(vehicle, axle, heavy), "usual share of the mass")

    return found


GIVEN = (
    Given("mass_kg", "the moment that rolls the body"),
    *(
        Given(f"unsprung_mass_{a}_kg", "what of the mass does not roll", _usual_hubs(a))
        for a in ("front", "rear")
    ),
)
LEAST_M = 0.02
TRACK_M, HUB_BELOW_M, ROLL_AXIS_M, LEAST_PLACE_STD_M = 1.55, 0.3, (0.1, 0.07), 0.02
"""LEAST_M: of the effective lever, c. Where the vehicle file is silent: track, hubs below the vehicle's CG, height of the roll axis; and how well
anyone knows where an accelerometer sits."""


@kernel
def _roll(phi: FloatArray, before: FloatArray, after: FloatArray, force: FloatArray, out: FloatArray) -> None:
    """x[k+1] = phi x[k] + before f[k] + after f[k+1] for every row; out (q, n): the angle."""
    for q in range(out.shape[0]):
        x = v = 0.0
        for k in range(len(force)):
            out[q, k] = x
            if k + 1 < len(force):
                f, g = force[k], force[k + 1]
                x, v = (
                    phi[q, 0, 0] * x + phi[q, 0, 1] * v + before[q, 0] * f + after[q, 0] * g,
                    phi[q, 1, 0] * x + phi[q, 1, 1] * v + before[q, 1] * f + after[q, 1] * g,
                )


def predict(values: FloatArray, inputs: FloatArray, step_s: float, given: Mapping[str, float]) -> FloatArray:
    """Roll angle (Q, n, 1) in rad that follows from the lateral specific force (n, 1) on the body."""
    mass = given["mass_kg"] - given["unsprung_mass_front_kg"] - given["unsprung_mass_rear_kg"]
    count = len(values)
    phi, before, after = np.empty((count, 2, 2)), np.empty((count, 2)), np.empty((count, 2))
    for q, (stiffness, damping, inertia, arm, above) in enumerate(values):
        moment = mass * arm
        # a sensor so high that the roll itself would lead it cannot be
        c = max(inertia / moment + arm - above, LEAST_M)
        coefficients = RollCoefficients(stiffness / moment, damping / moment, c)
        phi[q], before[q], after[q] = discretise(coefficients, step_s)
    out = np.empty((count, len(inputs)))
    _roll(phi, before, after, np.ascontiguousarray(inputs[:, 0]), out)
    return out[:, :, None]


def priors(vehicle: Vehicle) -> dict[str, Known]:
    """From the vehicle file where it speaks; a load may change inertia and arm, so their spreads are at least a tenth."""
    quantity = vehicle.get("mass_kg")
    mass = sprung_share(vehicle) * (quantity.value if quantity is not None else 1_600.0)
    found = {
        "roll_stiffness_nmprad": usual("roll_stiffness_nmprad", 15 * mass, 120 * mass, "15 to 120 N·m/rad a kg"),
        "roll_damping_nmsprad": usual("roll_damping_nmsprad", 0.8 * mass, 15 * mass, "0.8 to 15 N·m·s/rad a kg"),
        "sprung_roll_inertia_kgm2": usual("sprung_roll_inertia_kgm2", 0.15 * mass, 0.7 * mass, "0.15 to 0.7 m² times mass"),
        "roll_arm_m": usual("roll_arm_m", 0.25, 1.2, "usual for cars and vans"),
        "imu_above_roll_axis_m": Known(
            "imu_above_roll_axis_m", Normal(0.4, 0.25, -1.0, 3.0), False, "on the floor to under the roof"
        ),
    }  # fmt: skip
    for name in ("roll_stiffness_nmprad", "roll_damping_nmsprad"):
        known = vehicle.get(name)
        if known is not None:
            spec = next(p for p in PARAMETERS if p.name == name)
            found[name] = about(name, known, spec.low, spec.high, 0.1)
    inertia, place = _stated_inertia(vehicle), _stated_place(vehicle)
    if inertia is not None:
        spec = next(p for p in PARAMETERS if p.name == "sprung_roll_inertia_kgm2")
        found[spec.name] = about(spec.name, inertia, spec.low, spec.high, 0.1)
    if place is not None:
        found["imu_above_roll_axis_m"] = Known(
            "imu_above_roll_axis_m", Normal(place.value, place.std, -1.0, 3.0), False, place.source
        )
    return found


def _stated_inertia(vehicle: Vehicle) -> Quantity | None:
    """Roll inertia of the sprung mass by the whole vehicle's: its hubs stand half a track from the middle."""
    whole = vehicle.get("roll_inertia_kgm2")
    if whole is None:
        return None
    hubs, std = 0.0, whole.std
    for axle in ("front", "rear"):
        under = vehicle.get(f"unsprung_mass_{axle}_kg") or _usual_hubs(axle)(vehicle)
        track = vehicle.get(f"track_{axle}_m")
        square = 0.25 * (track.value if track is not None else TRACK_M) ** 2 + HUB_BELOW_M**2
        hubs += under.value * square
        std = float(np.hypot(std, under.std * square))
    return Quantity(max(whole.value - hubs, 0.3 * whole.value), std, f"{whole.source}, hubs taken off")


def _stated_place(vehicle: Vehicle) -> Quantity | None:
    """Accelerometer above the roll axis, by the heights of both above ground."""
    stated = vehicle.sensors.get("imu_above_ground_m")
    if stated is None:
        return None
    axes = [q for a in ("front", "rear") if (q := vehicle.get(f"roll_center_height_{a}_m")) is not None]
    axis = sum(q.value for q in axes) / len(axes) if axes else ROLL_AXIS_M[0]
    off = max((q.std for q in axes), default=ROLL_AXIS_M[1])
    std = float(np.hypot(max(stated.std, LEAST_PLACE_STD_M), off))
    return Quantity(stated.value - axis, std, "its height above ground, over the roll axis")


MODEL = Model(
    name="roll",
    title="Roll of the body from lateral acceleration",
    source="Berntorp et al., equations (1)-(4), without gravity, for a sensor on the body",
    parameters=PARAMETERS,
    inputs=("accel_y",),
    outputs=("roll",),
    given=GIVEN,
    predict=predict,
    priors=priors,
    band_hz=(0.1, 2.5),
    cutoff_hz=6.0,
    settle_s=2.0,
    note=(
        "only stiffness, damping and inertia over mass times arm are seen: without a prior on one of them all scale together; "
        "the roll angle against the road must not hold its bank"
    ),
    least_input=0.3,
    noisy_inputs=True,
)
