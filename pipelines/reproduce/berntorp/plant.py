"""The sine with dwell on the full plant, and what K, D and h of a vehicle are that has no such three numbers.

The estimator's model has one body on one spring and one damper, which turns about an axis on the ground. The plant has
sprung and unsprung masses, a roll axis above ground, tyres in series with the springs, stiffening springs with stops,
dampers with two slopes and a knee, dry friction, and tyres that saturate. Its K, D and h are therefore defined:

    h  height of the whole vehicle's CG
    K  m g h over the steady roll per g of sensed lateral acceleration (small angles, tyres included)
    D  what the dampers (mean of their slopes before the knee) and the tyres take, for a unit of roll rate, when the
       body moves in the shape in which it leans in a steady turn
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipelines.models.roll import DEGREES, GRAVITY
from pipelines.reproduce.berntorp.setup import DURATION_S, STEP_S, Motion, RollBody
from pipelines.results import FloatArray
from pipelines.simulation.loads import truth
from pipelines.simulation.manoeuvres.base import figures_of
from pipelines.simulation.manoeuvres.sine_with_dwell import SCALARS, SPEED_MPS, dwell_wave
from pipelines.simulation.manoeuvres.steering_ramps import slow_ramp_angle_rad
from pipelines.simulation.plant.linear import small_motion
from pipelines.simulation.plant.presets import PRESETS
from pipelines.simulation.plant.run import simulate
from pipelines.simulation.plant.static import posture
from pipelines.simulation.plant.vehicle import PlantVehicle
from pipelines.simulation.records import Demand, PlantRun, straight_road

BEFORE_S = 0.5
SMALL_MPS2 = 0.05
_SUV = PRESETS["suv"]
_DAMPERS = [f"damper_{way}_{axle}_nspm" for way in ("compression", "extension") for axle in ("front", "rear")]

HIGH_SUV = replace(
    _SUV,
    name="high SUV",
    sprung_mass_kg=1620.0,
    sprung_cg_height_m=0.785,
    sprung_roll_inertia_kgm2=360.0,
    unsprung_mass_front_kg=45.0,
    unsprung_mass_rear_kg=45.0,
    spring_rate_front_npm=18_500.0,
    spring_rate_rear_npm=20_000.0,
    anti_roll_stiffness_front_nmprad=5_000.0,
    anti_roll_stiffness_rear_nmprad=2_000.0,
    bump_clearance_m=0.09,
    rebound_clearance_m=0.10,
    **{name: 1.45 * getattr(_SUV, name) for name in _DAMPERS},
)
"""The plant's SUV, made higher, softer and narrower in its masses, so that K, D and h lie inside the paper's box and h
well above sqrt(I_x / m). The paper's own vehicle is in a reference that it does not print."""


def effective(vehicle: PlantVehicle) -> RollBody:
    """K, D, h of a vehicle of the plant as defined above, with its mass and the roll inertia of the whole."""
    true, rest = truth(vehicle, ()), posture(vehicle)
    mass, height = true["mass_kg"], true["cg_height_m"]
    steady = GRAVITY * DEGREES / true["roll_gradient_degpg"]
    lean = np.subtract(
        *(posture(vehicle, side * SMALL_MPS2, rest.coordinates).coordinates for side in (1, -1))
    )
    shape = lean / lean[1]
    _, damping, _ = small_motion(vehicle, rest)
    return RollBody(
        steady * mass * height, float(shape @ damping @ shape), height, mass, true["roll_inertia_kgm2"]
    )


def _ground_acceleration(run: PlantRun) -> FloatArray:
    """(n,) lateral acceleration at the ground below the sprung CG, less gravity's part: the a_y of (1)."""
    c = run.columns
    rates = np.column_stack([c[f"{axis}_rate_radps"] for axis in ("roll", "pitch", "yaw")])
    turns = np.column_stack([c[f"{axis}_acceleration_radps2"] for axis in ("roll", "pitch", "yaw")])
    place = np.array([0.0, 0.0, -run.sprung_cg_m[2]])
    moved = np.cross(turns, place) + np.cross(rates, np.cross(rates, place))
    roll = c["roll_rad"]
    return np.asarray((c["accel_y_mps2"] + moved[:, 1] - GRAVITY * np.sin(roll)) / np.cos(roll))


def drive(vehicle: PlantVehicle, scalar: float = SCALARS[1]) -> Motion:
    """One sine with dwell at 80 km/h, both feet off, `scalar` times the standard's angle A; DURATION_S of it."""
    angle = scalar * slow_ramp_angle_rad(figures_of(vehicle), 0.3 * GRAVITY, SPEED_MPS)
    quiet = round(BEFORE_S / STEP_S)
    rows = round(DURATION_S / STEP_S) + 1
    wave = angle * dwell_wave(1.0)
    steering = np.concatenate((np.zeros(quiet), wave, np.zeros(max(rows - len(wave), 0) + 1)))
    speed = np.full(len(steering), np.nan)
    speed[0] = SPEED_MPS
    nothing = np.zeros(len(steering))
    demand = Demand(STEP_S, steering, speed, nothing, nothing)
    run = simulate(vehicle, demand, straight_road(200.0, 0.9), rate_hz=1 / STEP_S)
    rows_used = slice(quiet, quiet + rows)
    return Motion(
        _ground_acceleration(run)[rows_used],
        run.columns["roll_rad"][rows_used],
        run.columns["roll_rate_radps"][rows_used],
        np.asarray((run.columns["wheel_steer_fl_rad"] + run.columns["wheel_steer_fr_rad"])[rows_used] / 2),
    )


def simpler() -> dict[str, PlantVehicle]:
    """The vehicle with one thing after another taken out of the plant, and with all of them."""
    linear = {"spring_stiffening_pm2": 0.0, "bump_rate_npm": 0.0}
    dry = {"friction_n": 0.0}
    even = {
        f"damper_{way}_{axle}_nspm": 0.5
        * sum(getattr(HIGH_SUV, f"damper_{w}_{axle}_nspm") for w in ("compression", "extension"))
        for way in ("compression", "extension")
        for axle in ("front", "rear")
    } | {"damper_blow_off": 1.0}
    hard = {f"tire_vertical_rate_{axle}_npm": 2.5e6 for axle in ("front", "rear")}
    low = {f"roll_center_height_{axle}_m": 0.0 for axle in ("front", "rear")}
    parts = {
        "linear springs, no stops": linear,
        "no dry friction": dry,
        "dampers with one slope": even,
        "tyres ten times as hard": hard,
        "roll axis at ground level": low,
    }
    found = {name: replace(HIGH_SUV, **changes) for name, changes in parts.items()}
    found["all of these"] = replace(HIGH_SUV, **{k: v for part in parts.values() for k, v in part.items()})
    return found
