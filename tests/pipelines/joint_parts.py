"""Relations made by hand for the tests of the joint posterior, and a vehicle file to join them with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipelines.evidence import Evidence, Kind, Values
from pipelines.joint.vehicle.outputs import outputs_of
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle


def vehicle(**more: tuple[float, float]) -> Vehicle:
    """A data sheet of an empty SUV with an unknown load."""
    figures = {
        "mass_kg": (1900.0, 19.0),
        "wheelbase_m": (2.8, 0.005),
        "track_front_m": (1.6, 0.008),
        "track_rear_m": (1.6, 0.008),
        "cg_to_front_axle_m": (1.3, 0.01),
        "wheel_radius_m": (0.35, 0.002),
        "spring_rate_front_npm": (35e3, 700.0),
        "spring_rate_rear_npm": (38e3, 760.0),
        "anti_roll_stiffness_front_nmprad": (20e3, 800.0),
        "anti_roll_stiffness_rear_nmprad": (8e3, 320.0),
        "roll_center_height_front_m": (0.07, 0.02),
        "roll_center_height_rear_m": (0.12, 0.02),
        **more,
    }
    known = {name: Quantity(value, std, "vehicle file") for name, (value, std) in figures.items()}
    return Vehicle(body="SUV", quantities=known)


def told_height(file: Vehicle) -> Vehicle:
    """The same with the load's height told, so that there is one place for it (`test_load_places`)."""
    return replace(file, load={**file.load, "height_m": Quantity(0.8, 0.3, "vehicle file")})


def linear(rows: dict[str, float], observed: float, std: float, source: str = "by hand") -> Evidence:
    """Evidence of a weighted sum of unknowns."""

    def predict(values: Values) -> FloatArray:
        total = sum(np.asarray(values[name]) * weight for name, weight in rows.items())
        return np.atleast_1d(total)[None] if np.ndim(total) else np.array([total])

    return Evidence(
        "vertical", "made up", f"{source} sum of {', '.join(rows)}", source, np.array([observed]),
        np.array([[std**2]]), predict, tuple(rows),
    )  # fmt: skip


def of_output(
    see: Callable[[dict[str, FloatArray]], FloatArray], observed: float, std: float, *, kind: Kind = "pitch",
    carrier: str = "made up", source: str = "by hand", title: str = "",
) -> Evidence:  # fmt: skip
    """Evidence of something that follows from the vehicle's parameters (all unknowns named)."""
    from pipelines.joint.vehicle.unknowns import before_the_log

    def predict(values: Values) -> FloatArray:
        seen = np.asarray(see(outputs_of(values, {})))
        return seen[None] if np.ndim(seen) else np.array([float(seen)])

    return Evidence(
        kind, carrier, title or f"{kind} by {carrier}", source, np.array([observed]), np.array([[std**2]]),
        predict, before_the_log(vehicle()).names,
    )  # fmt: skip
