"""The joint posterior's unknowns as they truly are of a plant's vehicle, and how far a relation is from what they predict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.vehicle_data import paths
from pipelines.evidence import Evidence
from pipelines.joint.vehicle.unknowns import Known, before_the_log
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray
from pipelines.simulation.loads import Load
from pipelines.simulation.logs.drive import Choice, SimulatedLog, default_mount, preset, simulate_log
from pipelines.simulation.logs.vehicle import sheet_values
from pipelines.simulation.plant.vehicle import PlantVehicle
from pipelines.simulation.sensors.truth import Mount
from pipelines.vehicles.vehicle import Vehicle


def random_drive(
    seed: int, manoeuvres: tuple[str, ...], vehicles: tuple[str, ...], sensors: str,
    change: Callable[[PlantVehicle, int], PlantVehicle] | None = None,
) -> SimulatedLog:  # fmt: skip
    """A preset with a load anywhere in it. Manoeuvres and vehicles take turns. change: of the preset, by the seed."""
    rng = np.random.default_rng([88, seed])
    vehicle = preset(vehicles[(seed // len(manoeuvres)) % len(vehicles)])
    load = Load(
        rng.uniform(0.03, 0.15) * vehicle.mass_kg, rng.uniform(0.3, 0.9) * vehicle.wheelbase_m,
        rng.uniform(-0.3, 0.3), rng.uniform(0.6, 1.6),
    )  # fmt: skip
    vehicle = vehicle if change is None else change(vehicle, seed)
    return simulate_log(
        Choice(manoeuvres[seed % len(manoeuvres)], vehicle, (load,), sensors=sensors, seed=seed)
    )


@dataclass(frozen=True)
class Truth:
    """values: all unknowns; those in `told` are the plant's, the others are as expected before the log with `std`."""

    values: Mapping[str, float]
    told: frozenset[str]
    std: Mapping[str, float]


def _of_the_plant(plant: PlantVehicle, loads: Sequence[Load], mount: Mount) -> dict[str, float]:
    sheet = sheet_values(plant)
    found = {
        "wheelbase": plant.wheelbase_m, "track_front": plant.track_front_m, "track_rear": plant.track_rear_m,
        "radius": sheet["wheel_radius_m"], "wheel_inertia": sheet["wheel_inertia_kgm2"], "empty_mass": plant.mass_kg,
        "unsprung_front": 2 * plant.unsprung_mass_front_kg, "unsprung_rear": 2 * plant.unsprung_mass_rear_kg,
        "empty_x": sheet["cg_to_front_axle_m"],
        "empty_y": plant.sprung_mass_kg * plant.sprung_cg_left_m / plant.mass_kg, "empty_h": plant.cg_height_m,
        "pitch_center_brake": sheet["pitch_center_height_m"],
        "pitch_center_drive": sheet["pitch_center_height_drive_m"],
        "pitch_path": paths(plant)["patch_path_pitch_mprad"][0],
        "drag": plant.drag_area_m2,
        "rolling": plant.rolling_resistance, "tyre_rate": sheet["tire_vertical_rate_npm"], "brake_gain": plant.brake_gain_nmppa,
        "imu_x": mount.behind_front_axle_m, "imu_y": mount.left_m, "imu_h": mount.above_ground_m,
    }  # fmt: skip
    for axle in ("front", "rear"):
        rate = sheet[f"spring_rate_{axle}_npm"]
        found |= {
            f"spring_{axle}": rate, f"square_{axle}": 0.0, f"cube_{axle}": rate * plant.spring_stiffening_pm2,
            f"bar_{axle}": sheet[f"anti_roll_stiffness_{axle}_nmprad"],
            f"roll_center_{axle}": sheet[f"roll_center_height_{axle}_m"],
            # a standing tyre is a spring: what a slip would give, over its relaxation length
            f"standing_{axle}": 0.25 * GRAVITY * plant.mass_kg / plant.relaxation_lateral_m
            * (plant.cornering_stiffness_front_prad if axle == "front" else plant.cornering_stiffness_rear_prad),
        }  # fmt: skip
    total = sum(load.mass_kg for load in loads)
    found["load"] = total
    found |= {"roll_inertia": sheet["roll_inertia_kgm2"], "pitch_inertia": sheet["pitch_inertia_kgm2"]}
    for name, key in (("load_x", "behind_front_axle_m"), ("load_y", "left_m"), ("load_h", "above_ground_m")):
        # a load of nothing may be anywhere
        found[name] = sum(load.mass_kg * getattr(load, key) for load in loads) / total if total else 1.0
    return found


def true_unknowns(made: SimulatedLog, vehicle: Vehicle) -> Truth:
    """Of a simulated drive. vehicle: its file, from which what is not the plant's takes its prior."""
    known = before_the_log(vehicle)
    plant = _of_the_plant(made.choice.vehicle, made.choice.loads, default_mount(made.choice.vehicle))
    values = known.at(np.zeros(len(known.names))) | plant
    std = dict(zip(known.names, known.std.tolist(), strict=True))
    return Truth(values, frozenset(plant), std)


def misfit(evidence: Evidence, truth: Truth) -> tuple[FloatArray, FloatArray]:
    """(m,) observed less predicted, and its (m, m) covariance: the relation's own and what is not told of the plant."""
    values = dict(truth.values) | {own.name: own.mean for own in evidence.own}
    std = {own.name: own.std for own in evidence.own} | {
        n: truth.std[n] for n in evidence.unknowns if n in truth.std and n not in truth.told
    }
    expected = evidence.predict(values)
    covariance = evidence.covariance.copy()
    for name, spread in std.items():
        step = 1e-3 * spread
        up = evidence.predict(values | {name: values[name] + step})
        slope = (up - expected) / step
        covariance = covariance + np.outer(slope, slope) * spread**2
    return evidence.observed - expected, covariance


def chi2(evidence: Evidence, truth: Truth) -> tuple[float, int]:
    """Misfit in standard deviations², and of how many numbers."""
    off, covariance = misfit(evidence, truth)
    return float(off @ np.linalg.solve(covariance, off)), len(off)


@dataclass(frozen=True)
class Posterior:
    """A Gaussian posterior of the unknowns and of a relation's own ones."""

    names: tuple[str, ...]
    mean: FloatArray
    covariance: FloatArray

    def of(self, output: Callable[[Mapping[str, float]], float]) -> tuple[float, float]:
        """Value and standard deviation of something that follows from the unknowns."""
        values = dict(zip(self.names, self.mean.tolist(), strict=True))
        size = np.sqrt(np.diag(self.covariance))
        value = output(values)
        steps = 1e-4 * size
        slope = np.array([
            (output(values | {n: values[n] + s}) - value) / s if s > 0 else 0.0
            for n, s in zip(self.names, steps, strict=True)
        ])  # fmt: skip
        return value, float(np.sqrt(slope @ self.covariance @ slope))


def joined(known: Known, relations: Sequence[Evidence], widen: float = 1.0) -> Posterior:
    """Gauss-Newton over relations and what was known before. widen: factor on the prior's standard deviations."""
    own = list({o.name: o for r in relations for o in r.own if o.name not in known.names}.values())
    names = (*known.names, *(o.name for o in own))
    mean = np.concatenate((known.mean, [o.mean for o in own]))
    std = np.concatenate((widen * known.std, [o.std for o in own]))
    u = np.zeros(len(names))
    for _ in range(6):
        curvature, gradient = np.eye(len(names)), u.copy()
        values = dict(zip(names, (mean + std * u).tolist(), strict=True))
        for r in relations:
            expected = r.predict(values)
            steps = 1e-4 * std
            slope = np.column_stack([
                (r.predict(values | {n: values[n] + s}) - expected) / 1e-4 for n, s in zip(names, steps, strict=True)
            ])  # fmt: skip
            inverse = np.linalg.inv(r.covariance)
            curvature += slope.T @ inverse @ slope
            gradient -= slope.T @ inverse @ (r.observed - expected)
        u = u - np.linalg.solve(curvature, gradient)
    return Posterior(names, mean + std * u, np.linalg.inv(curvature) * np.outer(std, std))
