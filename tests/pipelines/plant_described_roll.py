"""Drives by the described roll model's own equation, for what estimates its parameters."""

from __future__ import annotations

import numpy as np

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.models.described.roll import predict
from pipelines.prepare.lowpass import lowpass
from pipelines.vehicles.vehicle import Quantity, Vehicle


def roll_drive(
    seed: int, noise: float = 0.03, quick_hz: float = 1.2
) -> tuple[Drive, Vehicle, dict[str, float]]:
    """A slalom by the model's own equation with noise, and a file each of whose figures is wrong by what it says.

    noise: of the accelerometer at 50 Hz, m/s². quick_hz: up to where the driver steers.
    """
    rng = np.random.default_rng(seed)
    mass, arm, rate = rng.uniform(1300, 2300), rng.uniform(0.5, 0.8), 50.0
    stiffness = mass * arm * 9.81 / np.radians(rng.uniform(4, 7))
    inertia = mass * (arm * rng.uniform(0.6, 0.9)) ** 2
    damping = 2 * rng.uniform(0.2, 0.4) * np.sqrt(stiffness * (inertia + mass * arm**2))
    t = np.arange(0, 50, 1 / rate)
    force = lowpass(rng.normal(0, 1, len(t)), rate, quick_hz)
    force *= 2.5 / force.std()
    none = {"mass_kg": mass, "unsprung_mass_front_kg": 0.0, "unsprung_mass_rear_kg": 0.0}
    roll = predict(np.array([[stiffness, damping, inertia, arm, 0.5]]), force[:, None], 1 / rate, none)[
        0, :, 0
    ]
    time = (t * 1e9).astype(np.int64)
    columns = {"accel_y": force + rng.normal(0, noise, len(t)), "roll": roll + rng.normal(0, 0.0015, len(t))}
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
    true = {"roll_stiffness_nmprad": stiffness, "roll_damping_nmsprad": damping, "roll_arm_m": arm}
    return Drive(signals, record), vehicle, true
