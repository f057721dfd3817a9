"""The three-degree-of-freedom base-excitation model, (86)-(100), as the general engine runs it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

import numpy as np

from parsers.signals import WHEELS
from pipelines.bayes.priors import Distribution, Known, Normal, Uniform
from pipelines.models.base_excitation_3dof import COLUMNS, Geometry, corner_response
from pipelines.models.record import Given, Model, ModelParameter
from pipelines.results import FloatArray
from pipelines.vehicles.anti_roll import usual_bar
from pipelines.vehicles.vehicle import Quantity, Vehicle

ASYMMETRY = 0.28
FRICTION_N = 50.0
"""What dampers of cars have more in extension than their mean (0.2 to 0.35), and a wheel's usual dry friction."""

HEAVE_HZ = (0.8, 2.6)
UNSPRUNG_SHARE = 0.1
"""Where the vehicle file gives no mass: natural frequencies of bodies on their springs."""

PARAMETERS = (
    ModelParameter("sprung_mass_kg", "Sprung mass", "kg", 50.0, 60_000.0, 0.04),
    ModelParameter("sprung_pitch_inertia_kgm2", "Pitch inertia of the sprung mass", "kg·m²", 20.0, 500_000.0, 0.08),
    ModelParameter("sprung_roll_inertia_kgm2", "Roll inertia of the sprung mass", "kg·m²", 5.0, 100_000.0, 0.15),
    ModelParameter("sprung_cg_behind_front_axle_m", "Sprung CG behind the front axle", "m", 0.1, 10.0, 0.02),
    ModelParameter("damper_front_nspm", "Damper, front, mean of both directions", "N·s/m", 50.0, 100_000.0, 0.1, True),
    ModelParameter("damper_rear_nspm", "Damper, rear, mean of both directions", "N·s/m", 50.0, 100_000.0, 0.1, True),
)  # fmt: skip

GIVEN = (
    Given("spring_rate_front_npm", "masses and inertias come in proportion to the springs"),
    Given("spring_rate_rear_npm", "masses and inertias come in proportion to the springs"),
    Given("wheelbase_m", "pitch moments"),
    Given("track_front_m", "roll moments", Quantity(1.55, 0.05, "usual for cars")),
    Given("track_rear_m", "roll moments", Quantity(1.55, 0.05, "usual for cars")),
    Given("anti_roll_stiffness_front_nmprad", "roll stiffness beside the springs", partial(usual_bar, "front")),
    Given("anti_roll_stiffness_rear_nmprad", "roll stiffness beside the springs", partial(usual_bar, "rear")),
)  # fmt: skip


def table_of(values: FloatArray, given: Mapping[str, float]) -> FloatArray:
    """The physical model's table (Q, 14) from parameters (Q, 6) in the order of PARAMETERS."""
    table = np.zeros((len(values), len(COLUMNS)))
    table[:, :4] = values[:, :4]
    table[:, 5], table[:, 6] = given["spring_rate_front_npm"], given["spring_rate_rear_npm"]
    for column, damper in ((7, values[:, 4]), (9, values[:, 5])):
        table[:, column] = (1 + ASYMMETRY) * damper
        table[:, column + 1] = (1 - ASYMMETRY) * damper
    table[:, 11] = given["anti_roll_stiffness_front_nmprad"]
    table[:, 12] = given["anti_roll_stiffness_rear_nmprad"]
    table[:, 13] = FRICTION_N
    return table


def predict(values: FloatArray, inputs: FloatArray, step_s: float, given: Mapping[str, float]) -> FloatArray:
    """Body accelerations over the wheels (Q, n, 4) from the hubs' (n, 4)."""
    geometry = Geometry(given["wheelbase_m"], given["track_front_m"], given["track_rear_m"])
    return corner_response(table_of(values, given), inputs, geometry, step_s)


def _about(value: float, share: float) -> Distribution:
    return Normal(value, share * value, 0.2 * value, 4 * value)


def _sprung_mass(vehicle: Vehicle, spring_npm: float) -> tuple[float, float, str]:
    """Range of the loaded sprung mass in kg, and where it is from."""
    mass = vehicle.get("mass_kg")
    if mass is None:
        low, high = (2 * spring_npm / (2 * math.pi * f) ** 2 for f in reversed(HEAVE_HZ))
        return low, high, f"heave between {HEAVE_HZ[0]:g} and {HEAVE_HZ[1]:g} Hz on the springs"
    hubs = [vehicle.get(f"unsprung_mass_{axle}_kg") for axle in ("front", "rear")]
    unsprung = sum(UNSPRUNG_SHARE / 2 * mass.value if q is None else q.value for q in hubs)
    empty = mass.value - unsprung
    return 0.8 * empty, 1.9 * empty, "from a fifth below the empty vehicle's to nearly twice that"


def priors(vehicle: Vehicle) -> dict[str, Known]:
    """Wide, as no drive of this vehicle was seen yet: masses from the vehicle file's empty mass, dampers from its rates."""
    springs = [q.value for a in ("front", "rear") if (q := vehicle.get(f"spring_rate_{a}_npm")) is not None]
    spring = sum(springs) if springs else 60_000.0
    low, high, why = _sprung_mass(vehicle, spring)
    middle = math.sqrt(low * high)
    wheelbase = vehicle.get("wheelbase_m")
    length = wheelbase.value if wheelbase is not None else 2.8
    tracks = [q.value for a in ("front", "rear") if (q := vehicle.get(f"track_{a}_m")) is not None]
    width = sum(tracks) / len(tracks) if tracks else 1.55
    place = vehicle.get("cg_to_front_axle_m")
    known = {
        "sprung_mass_kg": Known("sprung_mass_kg", Uniform(low, high), True, why),
        "sprung_pitch_inertia_kgm2": Known(
            "sprung_pitch_inertia_kgm2",
            Uniform(0.06 * middle * length**2, 0.6 * middle * length**2),
            True,
            "0.06 to 0.6 of mass times wheelbase squared",
        ),
        "sprung_roll_inertia_kgm2": Known(
            "sprung_roll_inertia_kgm2",
            Uniform(0.04 * middle * width**2, 0.9 * middle * width**2),
            True,
            "0.04 to 0.9 of mass times track squared",
        ),
        "sprung_cg_behind_front_axle_m": Known(
            "sprung_cg_behind_front_axle_m",
            Uniform(0.25 * length, 0.75 * length)
            if place is None
            else Normal(place.value, math.hypot(place.std, 0.04 * length), 0.15 * length, 0.85 * length),
            True,
            "middle half of the wheelbase" if place is None else "vehicle file, and a load anywhere",
        ),
    }
    for axle, rate in zip(("front", "rear"), (springs * 2)[:2] or (30_000.0,) * 2, strict=True):
        name, damper = f"damper_{axle}_nspm", vehicle.get(f"damper_rate_{axle}_nspm")
        usual = 0.3 * 2 * math.sqrt(rate * middle / 4)
        known[name] = (
            Known(name, _about(usual, 0.4), True, "usual damping")
            if damper is None
            else Known(
                name, _about(damper.value, 0.25), True, "vehicle file; blow-off and friction may change it"
            )
        )
    return known


MODEL = Model(
    name="base_excitation_3dof",
    title="Heave, pitch and roll of the body over four hubs",
    source="dissertation, equations (86)-(100), corrected; warp, anti-roll bars, damper asymmetry and friction beside",
    parameters=PARAMETERS,
    inputs=tuple(f"accel_z_unsprung_{w}" for w in WHEELS),
    outputs=tuple(f"accel_z_sprung_{w}" for w in WHEELS),
    given=GIVEN,
    predict=predict,
    priors=priors,
    band_hz=(0.5, 3.0),
    cutoff_hz=20.0,
    settle_s=3.0,
    note="masses and inertias come in proportion to springs, dampers and bars; the roll inertia is that about the roll axis",
    least_input=1.5,
    least_explained=0.85,
)
