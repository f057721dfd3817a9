"""What is known beside the log, as draws: masses, lengths, axes, places, and what sensors and model may be wrong by."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pipelines.results import Assumption, FloatArray, Prior
from pipelines.vehicles.priors import measured_pitch_inertia, measured_roll_inertia
from pipelines.vehicles.vehicle import Quantity, Vehicle

DRAWS = 4000
SILENT = "the vehicle file is silent: usual for road vehicles"
TRACK = (1.55, 0.08)
WHEELBASE = (2.7, 0.2)
RADIUS = (0.33, 0.03)
WHEEL_INERTIA = (1.2, 0.4)
ROLL_CENTER = (0.09, 0.06)
PITCH_CENTER = (0.09, 0.07)
LEAN = (0.3, 0.2)
GYROSCOPE = (0.7, 0.4)
FEET = (0.7, 0.35)
LEAN_GAIN = (0.0115, 0.004)
NET_MOMENT = 0.005
ROLL_RADPS = 8.8
"""Mean and standard deviation where the file is silent. LEAN: by what share
of the body's roll the wheels lean with it (0 a rigid axle). GYROSCOPE: what the struts see of the wheels' gyroscopic moment.
FEET: how far the wheels' feet move sideways under a leaning body as the roll centre says (1 independent wheels, 0 a rigid
axle with a Panhard rod). LEAN_GAIN: lean against the axles, rad a m/s². NET_MOMENT: what a balance may miss of a moment
that goes with the angular acceleration, as a share of the whole moment. ROLL_RADPS: frequency at which bodies roll."""


@dataclass
class Draws:
    """One quantity after another from the vehicle file or the usual, (DRAWS,) each, and a line for the report."""

    vehicle: Vehicle
    rng: np.random.Generator
    assumptions: list[Assumption] = field(default_factory=list)

    def normal(self, mean: float, std: float) -> FloatArray:
        """Draws of a Gaussian."""
        return np.asarray(mean + std * self.rng.standard_normal(DRAWS))

    def given(
        self, name: str, quantity: Quantity | None, mean: float, std: float, *, say: bool = True
    ) -> FloatArray:
        """A quantity of the file, else the usual."""
        known = quantity or Quantity(mean, std, SILENT)
        if say:
            self.assumptions.append(Assumption(name, f"{known.value:.4g} ± {known.std:.3g}", known.source))
        return self.normal(known.value, known.std)

    def of(self, key: str, usual: tuple[float, float]) -> FloatArray:
        """A quantity by its key in [vehicle]."""
        return self.given(key, self.vehicle.get(key), *usual)

    def place(self, key: str, mean: float, std: float) -> FloatArray:
        """A quantity of [sensors]."""
        return self.given(f"[sensors] {key}", self.vehicle.sensors.get(key), mean, std)


def tracks(vehicle: Vehicle) -> tuple[float, float]:
    """Front and rear track, m; the other axle's, then the usual, where the file gives none."""
    front, rear = vehicle.get("track_front_m"), vehicle.get("track_rear_m")
    other = front or rear
    usual = TRACK[0] if other is None else other.value
    return (usual if front is None else front.value), (usual if rear is None else rear.value)


def wheelbase(vehicle: Vehicle) -> float:
    """The wheelbase, m, or the usual one."""
    known = vehicle.get("wheelbase_m")
    return WHEELBASE[0] if known is None else known.value


LOADED = {"roll_inertia_kgm2": (0.08, 0.12), "pitch_inertia_kgm2": (0.05, 0.08)}
"""What an unknown load adds to the empty vehicle's inertia: share in the mean, and its spread."""


def inertia_prior(name: str, vehicle: Vehicle) -> Prior | None:
    """What is known of an inertia of the whole vehicle without the log: the file's, else measured vehicles of that mass."""
    stated = vehicle.get(name)
    mass = vehicle.get("mass_kg")
    if stated is not None:
        more, spread = (0.0, 0.0) if vehicle.load_stated else LOADED[name]
        std = float(np.hypot(stated.std, spread * stated.value))
        words = stated.source + ("" if vehicle.load_stated else ", with an unknown load")
        return Prior(stated.value * (1 + more), std, words)
    if mass is None:
        return None
    if name == "roll_inertia_kgm2":
        track = vehicle.get("track_front_m")
        return measured_roll_inertia(mass.value, None if track is None else track.value)
    return measured_pitch_inertia(mass.value)


def inertia_prior_of(name: str, vehicle: Vehicle) -> Prior | None:
    """The prior of an inertia, None for any other parameter."""
    return inertia_prior(name, vehicle) if name.endswith("inertia_kgm2") else None
