"""CG height and position by the HEKF-EKF, as Wu et al. publish it."""

from __future__ import annotations

import math

import numpy as np

from parsers.drive import Drive
from pipelines.estimators.axle_load_gls.answers import unknown
from pipelines.estimators.axle_load_gls.balance import noise_of
from pipelines.estimators.axle_load_gls.data import AxleData, collect, load_channels, speed_channels
from pipelines.estimators.axle_load_gls.estimator import BESIDE, LOADS
from pipelines.estimators.axle_load_gls.known import loaded_mass, measured_mass
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.hekf_ekf.answers import (
    Filtered,
    published_answers,
    published_assumptions,
    published_figures,
)
from pipelines.filters.hekf import HekfSettings, hekf_ekf, load_noise_process
from pipelines.models.axle_load import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.signals import prepare_signals
from pipelines.results import Estimate, FloatArray
from pipelines.vehicles.vehicle import Vehicle

DRAWS = 4000
USUAL_HEIGHT_SHARE, USUAL_AXLE_SHARE = 0.2, 0.45
LEAST_SPEED_NOISE = 0.01

SETTINGS: tuple[Setting, ...] = (
    Setting("rate_hz", 50.0, "Hz", "steps of the filter (0.02 s in the paper)", 2.0, 1000.0),
    Setting("huber", 1.345, "std", "gamma of the Huber weight; large = plain EKF", 0.1, 1e6),
    Setting("weight", 0.9, "share", "weight of the first filter's height", 0.0, 1.0),
    Setting("feedback", 1.0, "0 or 1", "the weighted height starts both filters' next step", 0.0, 1.0),
    Setting("start_variance", 0.1, "m²", "variance of starting height and position", 1e-4, 10.0),
    Setting("least_excitation", 0.2, "m/s²", "spread of force along the road below which no height is given", 0.0, 5.0),
    Setting("most_lateral", 3.0, "m/s²", "lateral acceleration beyond which rows are left out", 0.1, 100.0),
    Setting("load_scale_std", 0.01, "share", "scale error of the axle load sensor", 0.0, 0.5),
)  # fmt: skip


def value(settings: Settings, name: str) -> float:
    """A setting, or its default."""
    return float(settings.get(name, next(s.default for s in SETTINGS if s.name == name)))


class HekfEkf:
    """The estimator "hekf_ekf"."""

    name: str = "hekf_ekf"
    title: str = "HEKF-EKF on speed and axle load (Wu et al.)"

    source: str = (
        "Wu, Sun, Li, Zheng: Real-time center of gravity estimation for intelligent connected vehicle based on HEKF-EKF, "
        "Electronics 12 (2023) 386, eqs. (2)-(18)"
    )

    @property
    def signal_needs(self) -> tuple[Need, ...]:
        """Rear axle load and speed."""
        speeds = ("speed", "gps_speed_3d", "gps_speed_2d", "wheel_speed_rl", "wheel_speed_fl")
        return (
            Need(LOADS, "the load of an axle, whole or of both its wheels"),
            Need(speeds, "the speed, which is what the filter observes"),
        )

    vehicle_needs: tuple[Need, ...] = (
        Need(("wheelbase_m",), "load transfer is m h a / L"),
        Need(("mass_kg",), "only m h and m a are identifiable, the mass must be given"),
    )
    parameters: tuple[str, ...] = ("cg_height_m", "cg_to_front_axle_m")

    settings: tuple[Setting, ...] = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Load and speed at the filter's rate, little smoothed: the filter is made for noise."""
        signals = drive.signals
        rear, front = load_channels(signals, "rear"), load_channels(signals, "front")
        speeds = speed_channels(signals)
        wanted = [*(rear or front), *speeds]
        if not speeds:
            wanted.append("speed")
        rate = value(settings, "rate_hz")
        cutoff = 0.4 * rate
        first = prepare_signals(drive, wanted, rate_hz=rate, cutoff_hz=cutoff, optional=[*BESIDE, *front])
        if first.cutoff_hz >= cutoff or not first.segments:
            return first
        return prepare_signals(
            drive,
            wanted,
            rate_hz=2.5 * first.cutoff_hz,
            cutoff_hz=first.cutoff_hz,
            optional=[*BESIDE, *front],
        )

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Filter the drive once, forward. The interval is widened far beyond the filter's own covariance."""
        data = None
        if prepared.segments:
            lateral = value(settings, "most_lateral")
            data = collect(prepared, vehicle, by_speed=True, most_lateral=lateral, one_axle=True)
        scale = value(settings, "load_scale_std")
        mass = measured_mass(prepared, vehicle, scale, rng, DRAWS) or loaded_mass(vehicle, rng, DRAWS)
        if data is None or mass is None:
            reason = "; ".join(prepared.notes) or "no stretch holds an axle load and a speed while driving"
            unknowns = {name: unknown(name, reason, vehicle) for name in self.parameters}
            return Estimate(self.name, "ran", reason, unknowns, witness=True)
        filtered = _filter(data, vehicle, float(np.mean(mass.draws)), settings)
        spread = float(np.std(data.force()))
        told = None
        if spread < value(settings, "least_excitation"):
            told = (
                f"the force along the road changes by {spread:.2f} m/s² (standard deviation): the filter keeps "
                f"the height that it was started with"
            )
        found, tracks, traces = published_answers(filtered, data, vehicle, mass, scale, told)
        return Estimate(
            estimator=self.name,
            status="ran",
            reason=told or "the filter ran over the drive",
            parameters=found,
            tracks=tracks,
            traces=traces,
            assumptions=published_assumptions(filtered, data, vehicle, mass),
            diagnostics={**published_figures(filtered, data), "force_spread_mps2": spread},
            used_fraction=data.size / max(data.drive_rows, 1),
            witness=True,
        )


def _rear_load(data: AxleData, mass: float) -> FloatArray:
    """Rear axle load; from the front one and the weight where only that is measured."""
    if data.share_rear > 0:
        return data.load
    return np.asarray(mass * GRAVITY * np.cos(data.grade) + data.load)


def _filter(data: AxleData, vehicle: Vehicle, mass: float, settings: Settings) -> Filtered:
    """Noise levels from the signals themselves, starting values from the vehicle file or usual ones, and the run."""
    assert data.speed is not None
    wheelbase = vehicle.quantities["wheelbase_m"].value
    height, axle = vehicle.get("cg_height_m"), vehicle.get("cg_to_front_axle_m")
    h0 = USUAL_HEIGHT_SHARE * wheelbase if height is None else height.value
    a0 = USUAL_AXLE_SHARE * wheelbase if axle is None else axle.value
    radius, factor = vehicle.get("wheel_radius_m"), vehicle.get("rolling_resistance")
    rolling = 0.0 if radius is None or factor is None else radius.value * factor.value
    speed_std = max(noise_of(data.speed, data.starts), LEAST_SPEED_NOISE)
    load_std = noise_of(data.load, data.starts)
    process = load_noise_process(wheelbase, data.dt, load_std, mass, h0)
    wide = value(settings, "start_variance")
    chosen = HekfSettings(
        (float(data.speed[0]), h0, a0), (speed_std**2, wide, wide), (process, 0.0, 0.0), speed_std**2,
        value(settings, "huber"), value(settings, "weight"), value(settings, "feedback") > 0.5,
    )  # fmt: skip
    load = _rear_load(data, mass)
    arguments = (data.speed, load, data.grade, data.dt, mass, wheelbase, rolling)
    track = hekf_ekf(*arguments, chosen, data.starts)
    plain = HekfSettings(
        chosen.start, chosen.start_variance, chosen.process, chosen.speed_variance, math.inf, 1.0, False
    )
    ekf = hekf_ekf(*arguments, plain, data.starts)
    return Filtered(track, ekf, chosen, rolling, speed_std, load_std, radius is None or factor is None)
