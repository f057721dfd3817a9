"""Both estimators on the richer truck, knowing the vehicle as a data sheet does: mass, load sensor and rolling with errors."""

from __future__ import annotations

import numpy as np

from pipelines.estimators.axle_load_gls.estimator import AxleLoadGls
from pipelines.estimators.base import Estimator
from pipelines.estimators.hekf_ekf.estimator import HekfEkf
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.reproduce.base import StudyRow, study_row
from pipelines.reproduce.wu.plant import DT, Truck
from pipelines.reproduce.wu.study import Case, noisy
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle

MASS_STD, WHEELBASE_STD, LOAD_SCALE_STD, GRADE_STD = 0.01, 0.002, 0.01, 0.003
"""Errors drawn for each run: shares of mass, wheelbase and load; rad of grade."""


def _quantity(value: float, std: float) -> Quantity:
    return Quantity(value, std, "vehicle file")


def data_sheet(truck: Truck, rng: np.random.Generator, errors: float = 1.0) -> Vehicle:
    """A vehicle file of the truck with drawn errors (times `errors`); its load is stated to be none."""
    mass = truck.mass * (1 + errors * MASS_STD * rng.standard_normal())
    wheelbase = truck.wheelbase * (1 + errors * WHEELBASE_STD * rng.standard_normal())
    inertia = 0.5 * (truck.inertia_front + truck.inertia_rear)
    radius = 0.5 * (truck.radius_front + truck.radius_rear)
    return Vehicle(
        name="truck of Table 2",
        quantities={
            "mass_kg": _quantity(mass, MASS_STD * mass),
            "wheelbase_m": _quantity(wheelbase, WHEELBASE_STD * wheelbase),
            "wheel_radius_m": _quantity(radius, 0.01 * radius),
            "wheel_inertia_kgm2": _quantity(inertia, 0.2 * inertia),
            "rolling_resistance": _quantity(0.008, 0.003),
        },
        load={"mass_kg": _quantity(0.0, 0.0)},
        reference={"cg_height_m": truck.height, "cg_to_front_axle_m": truck.axle},
    )


def prepared_run(case: Case, rng: np.random.Generator, errors: float = 1.0) -> Prepared:
    """One noisy run on the filter's own grid, with a scale error of the load and an offset of the grade (times `errors`)."""
    sample = noisy(case, rng)
    run, n = case.run, len(case.run.speed)
    columns: dict[str, FloatArray] = {
        "speed": sample.speed,
        "axle_load_rear": sample.load * (1 + errors * LOAD_SCALE_STD * rng.standard_normal()),
        "road_grade": run.grade + errors * GRADE_STD * rng.standard_normal(),
    }
    return Prepared(
        rate_hz=1 / DT, cutoff_hz=0.5 / DT, time_s=run.time_s, columns=columns, segments=(Segment(0, n),), sources={},
        measured=frozenset(columns), standstill=np.zeros(n, dtype=bool),
    )  # fmt: skip


def companion_on(case: Case, truck: Truck, rng: np.random.Generator) -> tuple[float, float]:
    """Height and position in m by "axle_load_gls" on one noisy run, all figures of the vehicle exact; NaN without."""
    vehicle, prepared = data_sheet(truck, rng, 0.0), prepared_run(case, rng, 0.0)
    found = AxleLoadGls().estimate(prepared, vehicle, {}, rng).parameters
    height, axle = (found[name].value for name in ("cg_height_m", "cg_to_front_axle_m"))
    return float("nan") if height is None else height, float("nan") if axle is None else axle


def study_data_sheet(case: Case, truck: Truck, runs: int, rng: np.random.Generator) -> tuple[StudyRow, ...]:
    """Bias, RMSE and coverage of what `cogest analyze` would give. No bound: the errors are not the log's noise."""
    estimators: tuple[tuple[str, Estimator], ...] = (
        ("HEKF-EKF (published)", HekfEkf()),
        ("companion (GLS, Huber)", AxleLoadGls()),
    )
    truths = {"cg_height_m": truck.height, "cg_to_front_axle_m": truck.axle}
    values = {(m, p): np.full((runs, 3), np.nan) for m, _ in estimators for p in truths}
    for i in range(runs):
        vehicle, prepared = data_sheet(truck, rng), prepared_run(case, rng)
        for method, estimator in estimators:
            found = estimator.estimate(prepared, vehicle, {}, rng).parameters
            for parameter in truths:
                answer = found[parameter]
                if answer.status != "not_identifiable" and answer.value is not None:
                    values[method, parameter][i] = (answer.value, answer.low or np.nan, answer.high or np.nan)
    remark = "Mass and load sensor to 1 %, grade to 3 mrad; pitch, wheel spin and drag as usual for such a vehicle."
    return tuple(
        study_row(case.name, m, p, "m", truths[p], v[:, 0], v[:, 1:], None, None, remark)
        for (m, p), v in values.items()
    )
