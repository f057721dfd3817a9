"""Posteriors like bent sheets, which no low-order polynomial holds: by runs of the model itself, beside a grid's; roll, told by three of five."""

from __future__ import annotations

import numpy as np

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.bayes.exact import exact
from pipelines.bayes.priors import Known, Normal, Priors
from pipelines.bayes.sequence import Choice, estimate
from pipelines.estimators.gpc_bayesian_map.estimator import DEFAULTS, GpcBayesianMap
from pipelines.models.described.roll import predict
from pipelines.prepare.lowpass import lowpass
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle

THIN = 0.004


def bent(values: FloatArray, interval: int) -> FloatArray:
    """Only a + sin(1.5 b) is seen, to THIN."""
    return ((values[:, :1] + np.sin(1.5 * values[:, 1:])) - 0.3) / THIN


def test_a_bent_sheet_has_the_moments_of_its_grid() -> None:
    priors = Priors((Known("a", Normal(0.0, 1.0)), Known("b", Normal(0.1, 0.4))))
    found = estimate(priors, bent, 1, Choice(order=3, near_order=2), np.random.default_rng(0))
    told, close, _ = exact(priors, lambda c: bent(priors.values(c), 0), found.posterior)
    assert close
    # on the sheet a = 0.3 - sin(1.5 b), and so thin is it that its width hardly counts
    b = np.linspace(-2.4, 2.6, 20001)
    a = 0.3 - np.sin(1.5 * b)
    weight = np.exp(-0.5 * a**2 - 0.5 * ((b - 0.1) / 0.4) ** 2)
    weight /= weight.sum()
    mean = np.array([weight @ a, weight @ b])
    std = np.sqrt([weight @ (a - mean[0]) ** 2, weight @ (b - mean[1]) ** 2])
    assert np.all(np.abs(told.mean - mean) < 0.1 * std)
    np.testing.assert_allclose(told.std, std, rtol=0.1)
    assert np.abs(bent(told.map_value[None], 0)).max() < 0.5


def roll_drive(seed: int) -> tuple[Drive, Vehicle, dict[str, float]]:
    """A slalom by the model's own equation with noise, and a file each of whose figures is wrong by what it says."""
    rng = np.random.default_rng(seed)
    mass, arm, rate = rng.uniform(1300, 2300), rng.uniform(0.5, 0.8), 50.0
    stiffness = mass * arm * 9.81 / np.radians(rng.uniform(4, 7))
    inertia = mass * (arm * rng.uniform(0.6, 0.9)) ** 2
    damping = 2 * rng.uniform(0.2, 0.4) * np.sqrt(stiffness * (inertia + mass * arm**2))
    t = np.arange(0, 50, 1 / rate)
    force = lowpass(rng.normal(0, 1, len(t)), rate, 1.2)
    force *= 2.5 / force.std()
    none = {"mass_kg": mass, "unsprung_mass_front_kg": 0.0, "unsprung_mass_rear_kg": 0.0}
    roll = predict(np.array([[stiffness, damping, inertia, arm, 0.5]]), force[:, None], 1 / rate, none)[
        0, :, 0
    ]
    time = (t * 1e9).astype(np.int64)
    columns = {"accel_y": force + rng.normal(0, 0.03, len(t)), "roll": roll + rng.normal(0, 0.0015, len(t))}
    signals = {k: Signal(k, time, v, "made") for k, v in columns.items()}
    record = ImportRecord("made", (), "", "complete", 0, {}, (), "made", None, float(t[-1]), ())

    def stated(value: float, share: float) -> Quantity:
        return Quantity(value * (1 + share * rng.normal()), share * value, "made")

    figures = {
        "mass_kg": stated(mass, 0.005), "roll_stiffness_nmprad": stated(stiffness, 0.1),
        "roll_damping_nmsprad": stated(damping, 0.2), "roll_inertia_kgm2": stated(inertia, 0.1),
        "unsprung_mass_front_kg": Quantity(0.5, 0.1, "made"), "unsprung_mass_rear_kg": Quantity(0.5, 0.1, "made"),
        "roll_center_height_front_m": Quantity(0.0, 0.001, "made"), "roll_center_height_rear_m": Quantity(0.0, 0.001, "made"),
    }  # fmt: skip
    vehicle = Vehicle(quantities=figures, sensors={"imu_above_ground_m": Quantity(0.5, 0.02, "made")})
    return Drive(signals, record), vehicle, {"roll_stiffness_nmprad": stiffness, "roll_arm_m": arm}


def test_roll_parameters_that_only_come_together_are_as_wide_as_the_figures_that_part_them() -> None:
    method, settings = GpcBayesianMap("roll"), {**DEFAULTS, "model_error_scale": 0.0}
    off = []
    for seed in range(10):
        drive, vehicle, true = roll_drive(seed)
        found = method.estimate(method.prepare(drive, settings), vehicle, settings, np.random.default_rng(0))
        assert found.diagnostics["surrogate_error"] < 0.25
        for name, value in true.items():
            entry = found.parameters[name]
            assert entry.value is not None
            assert entry.std is not None
            off.append((entry.value - value) / entry.std)
    assert np.sqrt(np.mean(np.square(off))) < 1.5
    assert np.mean(np.abs(off) < 1.96) >= 0.85
