"""The full-vehicle plant: a drive with known truth, from a vehicle, what its driver does, and the road.

    run = simulate(PRESETS["suv"], demand, straight_road(500), loads=[Load(120, 1.6, 0.0, 1.85)])

The model is described in `motion` (body, wheels on guides), `wheel` (suspension, wheel spin), `tyre` and
`plant_driver`; the truth comes from `loads.truth`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.loads import Load, loaded, sprung_cg, truth
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.body import PlantVehicle
from pipelines.simulation.plant.columns import columns
from pipelines.simulation.plant.integrate import integrate
from pipelines.simulation.plant.static import Posture, posture
from pipelines.simulation.records import Air, Demand, PlantRun, Road

PATCH_M = 0.12
"""Length of the contact patch, over which a tyre takes the mean of the road's roughness."""
SETTLE_STANDING_S = 2.0
SETTLE_MOVING_S = 5.0

_ROAD_FIELDS = (
    "curvature_1pm", "grade_rad", "bank_rad", "left_m", "right_m", "friction_left", "friction_right"
)  # fmt: skip
_DEMAND_FIELDS = (
    "steering_wheel_angle_rad", "target_speed_mps", "brake_pressure_pa", "drive_torque_nm"
)  # fmt: skip


@dataclass(frozen=True)
class Setup:
    """All that the kernels need of one drive. Shapes: (BODY_SIZE,), (4, WHEEL_SIZE), (n, 5), (m, 7)."""

    vehicle: PlantVehicle
    rest: Posture
    body: FloatArray
    wheels: FloatArray
    demand: FloatArray
    road: FloatArray
    grids: tuple[float, float]


def simulate(
    vehicle: PlantVehicle,
    demand: Demand,
    road: Road,
    *,
    loads: Sequence[Load] = (),
    air: Air | None = None,
    rate_hz: float = 100.0,
    step_s: float = 0.001,
) -> PlantRun:
    """Drive `vehicle` with its loads over `road` as `demand` says; every name of RUN_COLUMNS at rate_hz. air: None = still, 1.2 kg/m³.

    step_s: the longest integration step. The run begins settled: standing, or rolling at target_speed_mps[0] when
    demand.steady_at_start or that speed is above 0. It ends early where the vehicle rolls over.
    Raises ValueError, naming the field, where an input has a wrong shape, is not finite, or a step is not positive.
    """
    if not (math.isfinite(rate_hz) and rate_hz > 0):
        raise ValueError(f"rate_hz is {rate_hz}, expected more than 0")
    if not (math.isfinite(step_s) and 0 < step_s <= 0.002):
        raise ValueError(f"step_s is {step_s}, expected more than 0 and at most 0.002")
    setup = prepare(loaded(vehicle, loads), demand, road, air)
    rows = math.floor(demand.duration_s * rate_hz + 1e-9) + 1
    states, extras = run_from(setup, settle(setup, step_s), rows, rate_hz, step_s)
    return PlantRun(
        rate_hz=rate_hz,
        time_s=np.arange(len(states)) / rate_hz,
        columns=columns(states, extras, setup.body, setup.wheels, float(setup.rest.coordinates[0])),
        truth=truth(vehicle, loads, setup.rest),
        sprung_cg_m=sprung_cg(setup.vehicle, setup.rest),
    )


def prepare(full: PlantVehicle, demand: Demand, road: Road, air: Air | None = None) -> Setup:
    """Check a drive's inputs and bring them into the kernels' form. `full`: the vehicle with its loads.

    Raises ValueError, naming the field.
    """
    asked, ground = _demand(demand), _road(road)
    body, wheels = at.pack(full)
    through = air or Air()
    body[at.DRAG] *= through.density_kgpm3 / at.AIR_DENSITY
    body[at.WIND_X], body[at.WIND_Y] = through.wind_ahead_mps, through.wind_left_mps
    body[at.FOLLOW] = float(np.any(ground[:, at.R_CURVATURE] != 0))
    return Setup(full, posture(full), body, wheels, asked, ground, (1 / demand.step_s, 1 / road.step_m))


def settle(setup: Setup, step_s: float) -> FloatArray:
    """(STATES,) the drive's first state: at rest or rolling steadily on the road's first row, dry friction relaxed.

    The kernel runs with the road and the demand held at their first rows.
    """
    speed = float(setup.demand[0, at.D_TARGET])
    speed = max(speed, 0.0) if math.isfinite(speed) else 0.0
    y = standing(setup)
    y[at.VX] = speed
    y[at.SPIN : at.SPIN + 4] = at.spins_at(setup.wheels, speed)
    body = setup.body.copy()
    body[at.DRY_ON] = body[at.ROAD_ON] = 0.0
    hold = setup.demand[:2].copy()
    hold[1] = hold[0]
    hold[:, at.D_SLOPE] = 0.0
    hold[:, at.D_TARGET] = speed
    if speed > 0:
        hold[:, at.D_BRAKE] = hold[:, at.D_DRIVE] = 0.0
    held = Setup(setup.vehicle, setup.rest, body, setup.wheels, hold, setup.road, setup.grids)
    duration = SETTLE_MOVING_S if speed > 0 else SETTLE_STANDING_S
    run_from(held, y, round(duration * 10) + 1, 10.0, step_s)
    for index in (at.X, at.Y, at.HEADING, at.DISTANCE, at.ALTITUDE):
        y[index] = 0.0
    return y


def standing(setup: Setup, offsets: Mapping[int, float] | None = None) -> FloatArray:
    """(STATES,) at rest on flat ground; `offsets` are added by state index (`plant_layout`), to start from elsewhere."""
    y = np.zeros(at.STATES)
    q = setup.rest.coordinates
    y[at.HEIGHT], y[at.ROLL], y[at.PITCH] = q[:3]
    y[at.DEFLECTION : at.DEFLECTION + 4] = q[3:]
    for index, value in (offsets or {}).items():
        y[index] += value
    return y


def run_from(
    setup: Setup, state: FloatArray, rows: int, rate_hz: float, step_s: float
) -> tuple[FloatArray, FloatArray]:
    """Run the plant from a state (changed in place): states (n, STATES) and extras (n, AUX_SIZE), n <= rows.

    The step is the longest that fits a row and is not above step_s.
    """
    stride = max(math.ceil(1 / (rate_hz * step_s) - 1e-9), 1)
    states, extras = np.empty((rows, at.STATES)), np.empty((rows, at.AUX_SIZE))
    times = (0.0, 1 / (rate_hz * stride), stride)
    scratch, work = np.zeros((5, 128)), np.zeros((10, 8))
    whole = integrate(
        state, times, setup.body, setup.wheels, setup.demand, setup.road, setup.grids, scratch, work, states, extras
    )  # fmt: skip
    return states[:whole], extras[:whole]


def _positive(value: float, name: str) -> None:
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name} is {value}, expected more than 0")


def _column(value: FloatArray, name: str, rows: int, may_be_nan: bool = False) -> FloatArray:
    column = np.asarray(value, dtype=np.float64)
    if column.shape != (rows,):
        raise ValueError(f"{name} has shape {column.shape}, expected ({rows},)")
    if np.any(np.isinf(column)) or (not may_be_nan and np.any(np.isnan(column))):
        raise ValueError(f"{name} holds a value that is not finite")
    return column


def _demand(demand: Demand) -> FloatArray:
    """(n, 5) with the target speed's slope."""
    _positive(demand.step_s, "demand.step_s")
    rows = len(np.atleast_1d(demand.target_speed_mps))
    if rows < 2:
        raise ValueError(f"demand.target_speed_mps has {rows} rows, expected 2 or more")
    packed = np.zeros((rows, 5))
    for index, name in enumerate(_DEMAND_FIELDS):
        packed[:, index] = _column(getattr(demand, name), f"demand.{name}", rows, name == "target_speed_mps")
    if np.any(packed[:, at.D_BRAKE] < 0):
        raise ValueError("demand.brake_pressure_pa is below 0")
    slope = np.gradient(packed[:, at.D_TARGET], demand.step_s)
    packed[:, at.D_SLOPE] = np.where(np.isfinite(slope), slope, 0.0)
    return packed


def _road(road: Road) -> FloatArray:
    """(m, 7) with the roughness as a contact patch meets it."""
    _positive(road.step_m, "road.step_m")
    rows = len(np.atleast_1d(road.curvature_1pm))
    if rows < 2:
        raise ValueError(f"road.curvature_1pm has {rows} rows, expected 2 or more")
    packed = np.zeros((rows, 7))
    for index, name in enumerate(_ROAD_FIELDS):
        packed[:, index] = _column(getattr(road, name), f"road.{name}", rows)
    for name, index in (("friction_left", at.R_GRIP_LEFT), ("friction_right", at.R_GRIP_RIGHT)):
        if np.any(packed[:, index] < 0):
            raise ValueError(f"road.{name} is below 0")
    for name, index in (("grade_rad", at.R_GRADE), ("bank_rad", at.R_BANK)):
        if np.any(np.abs(packed[:, index]) > 0.8):
            raise ValueError(f"road.{name} is beyond 0.8 rad")
    width = min(int(PATCH_M / road.step_m) // 2 * 2 + 1, (rows - 1) // 2 * 2 + 1)
    if width > 1:
        for index in (at.R_LEFT, at.R_RIGHT):
            padded = np.pad(packed[:, index], width // 2, mode="edge")
            total = np.concatenate([[0.0], np.cumsum(padded)])
            packed[:, index] = (total[width:] - total[:-width]) / width
    return packed
