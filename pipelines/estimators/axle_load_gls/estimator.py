"""CG height, position and mass from axle loads over a whole drive: the offline companion to Wu et al."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from parsers.drive import Drive
from pipelines.estimators.axle_load_gls.answers import (
    Errors,
    answers,
    draw_answers,
    static_moments,
    unknown,
    usual_moment,
)
from pipelines.estimators.axle_load_gls.balance import (
    FORCE_DOUBT,
    Balance,
    Known,
    better_form,
    by_force,
    doubted,
)
from pipelines.estimators.axle_load_gls.data import (
    AxleData,
    collect,
    load_channels,
    speed_channels,
)
from pipelines.estimators.axle_load_gls.evidence import Seen, evidence
from pipelines.estimators.axle_load_gls.figures import (
    assumptions,
    figures,
    height_track,
    load_scatter,
    traces,
)
from pipelines.estimators.axle_load_gls.known import (
    HEAVY_KG,
    Pitch,
    drag_moment,
    loaded_mass,
    measured_pitch,
    pitch_inertia,
    usual_pitch,
)
from pipelines.estimators.axle_load_gls.road import without_small_holes
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.models.axle_load import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.signals import prepare_signals
from pipelines.results import Assumption, Estimate, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

LOADS: tuple[str, ...] = (
    "axle_load_rear", "axle_load_front", "tire_normal_force_rl", "tire_normal_force_fl", "suspension_force_rl",
    "suspension_force_fl",
)  # fmt: skip
FORCES: tuple[str, ...] = (
    "accel_x", "speed", "gps_speed_3d", "gps_speed_2d", "wheel_speed_rl", "wheel_speed_fl",
)  # fmt: skip
BESIDE: tuple[str, ...] = (
    "accel_x", "accel_y", "accel_z", "yaw_rate", "pitch", "pitch_rate", "road_grade", "altitude", "suspension_deflection_fl",
    "suspension_deflection_fr", "suspension_deflection_rl", "suspension_deflection_rr",
)  # fmt: skip
FLAT_STD = 0.01
DRAWS = 8000
MOST_OPEN = 0.5

SETTINGS: tuple[Setting, ...] = (
    Setting("cutoff_hz", 1.0, "Hz", "zero-phase low-pass of all signals with an accelerometer", 0.2, 10.0),
    Setting("speed_cutoff_hz", 5.0, "Hz", "the same where only the speed is there", 0.2, 40.0),
    Setting("huber", 1.345, "std", "residuals beyond this count less (Huber)", 0.5, 100.0),
    Setting("least_excitation", 0.2, "m/s²", "spread of force along the road below which no height is given", 0.0, 5.0),
    Setting("most_lateral", 3.0, "m/s²", "lateral acceleration beyond which rows are left out", 0.1, 100.0),
    Setting("load_scale_std", 0.01, "share", "scale error of an axle load sensor", 0.0, 0.5),
    Setting("load_offset_std", 0.01, "share", "offset of an axle load sensor, of its mean load", 0.0, 0.5),
    Setting("force_scale_std", 0.005, "share", "scale error of accelerometer or speed", 0.0, 0.5),
    Setting("accel_offset_std", 0.1, "m/s²", "offset of the accelerometer, its mounting counted in", 0.0, 5.0),
    Setting("model_std", 0.007, "share", "what the balance itself may be wrong by, of the height", 0.0, 0.5),
)  # fmt: skip


@dataclass(frozen=True)
class _Solved:
    """One drive's balance and what was taken along. offset: of the accelerometer, as the log alone shows it."""

    data: AxleData
    balance: Balance
    pitch: Pitch
    errors: Errors
    offset: tuple[float, float] | None
    notes: tuple[Assumption, ...]


class AxleLoadGls:
    """The estimator "axle_load_gls"."""

    name: str = "axle_load_gls"
    title: str = "Axle loads, generalised least squares"

    source: str = (
        "companion to Wu, Sun, Li, Zheng: Real-time center of gravity estimation for intelligent connected vehicle "
        "based on HEKF-EKF, eqs. (1)-(4), over the whole drive, with wheel spin, drag and pitch"
    )
    signal_needs: tuple[Need, ...] = (
        Need(LOADS, "the load of at least one axle, whole or of both its wheels"),
        Need(FORCES, "the force along the road: an accelerometer, or a speed with the road's grade"),
    )

    vehicle_needs: tuple[Need, ...] = (Need(("wheelbase_m",), "load transfer is m h a / L"),)
    parameters: tuple[str, ...] = ("cg_height_m", "cg_to_front_axle_m", "mass_kg")

    settings: tuple[Setting, ...] = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Axle loads with the accelerometer where there is one, else with the speed."""
        signals = drive.signals
        wanted = [*load_channels(signals, "rear"), *load_channels(signals, "front")]
        speeds = speed_channels(signals)
        with_accel = "accel_x" in signals
        wanted += ["accel_x"] if with_accel else speeds
        cutoff = value(settings, "cutoff_hz" if with_accel else "speed_cutoff_hz")
        # at twice the cutoff the low-passed noise is nearly white again, which the fit's noise model takes it for
        first = prepare_signals(
            drive, wanted, rate_hz=2 * cutoff, cutoff_hz=cutoff, optional=[*speeds, *BESIDE]
        )
        if first.cutoff_hz >= cutoff or not first.segments:
            return first
        cutoff = first.cutoff_hz
        again = prepare_signals(
            drive, wanted, rate_hz=2 * cutoff, cutoff_hz=cutoff, optional=[*speeds, *BESIDE]
        )
        return replace(again, notes=tuple(dict.fromkeys((*first.notes, *again.notes))))

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Fit and explain. A drive that cannot tell ends with parameters "not_identifiable" and the reason."""
        wheelbase = vehicle.get("wheelbase_m")
        prepared = without_small_holes(prepared)
        accel = prepared.columns.get("accel_x")
        integrate = accel is None or not np.isfinite(accel).any()
        data = None
        if prepared.segments and wheelbase is not None:
            data = collect(
                prepared, vehicle, by_speed=integrate, most_lateral=value(settings, "most_lateral")
            )
        if data is None or wheelbase is None:
            reason = "; ".join(prepared.notes) or "no stretch holds an axle load and the force along the road"
            return self._nothing(reason, vehicle)
        mass = loaded_mass(vehicle, rng, DRAWS)
        solved = _solve(prepared, data, vehicle, settings, integrate)
        data, balance = solved.data, solved.balance
        moments, covariance = balance.moments, balance.covariance
        told = _no_height(balance, value(settings, "least_excitation"))
        if told is not None:
            empty = vehicle.get("mass_kg")
            usual = usual_moment(data, wheelbase.value, None if empty is None else empty.value)
            moments, covariance = static_moments(data, wheelbase.value, usual)
        draws = draw_answers(
            data,
            moments,
            covariance,
            integrate,
            vehicle,
            wheelbase,
            mass,
            solved.pitch,
            solved.errors,
            rng,
            DRAWS,
        )
        found = answers(draws, balance, wheelbase.value, vehicle, told)
        missing = {
            name: unknown(name, self._no_mass(name), vehicle) for name in self.parameters if name not in found
        }
        height = found["cg_height_m"]
        track = () if height.status == "not_identifiable" else height_track(data, balance, height)
        seen = Seen(data, balance, solved.pitch, solved.errors, solved.offset, wheelbase.value, integrate)
        still = balance.force_spread < value(settings, "least_excitation")
        return Estimate(
            estimator=self.name,
            status="ran",
            reason=told or "the load transfer was fitted",
            parameters={**found, **missing},
            tracks=track,
            traces=traces(data, balance, prepared),
            scatters=load_scatter(data, balance, wheelbase.value),
            assumptions=assumptions(
                data, solved.pitch, solved.errors, mass, vehicle, wheelbase, solved.notes
            ),
            diagnostics=figures(data, balance),
            used_fraction=data.size / max(data.drive_rows, 1),
            evidence=evidence(seen, draws, told is None, still),
        )

    @staticmethod
    def _no_mass(name: str) -> str:
        return "the mass needs the load of both axles" if name == "mass_kg" else "see the other parameters"

    def _nothing(self, reason: str, vehicle: Vehicle) -> Estimate:
        parameters: dict[str, ParameterEstimate] = {n: unknown(n, reason, vehicle) for n in self.parameters}
        return Estimate(self.name, "ran", reason, parameters)


def value(settings: Settings, name: str) -> float:
    """A setting, or its default."""
    return float(settings.get(name, next(s.default for s in SETTINGS if s.name == name)))


def _no_height(balance: Balance, least: float) -> str | None:
    """Why this drive tells no height, in words; None where it does."""
    variance, moment = float(balance.covariance[0, 0]), float(balance.moments[0])
    share = math.sqrt(max(variance, 0.0)) / max(abs(moment), 1e-9)
    if balance.force_spread < least:
        return (
            f"the force along the road changes by {balance.force_spread:.2f} m/s² (standard deviation): the height "
            f"needs braking and driving of {least:g} m/s² or hills"
        )
    if not share < MOST_OPEN or moment <= 0:
        return "the axle load does not follow the force along the road: no load transfer to be seen"
    return None


def _solve(
    prepared: Prepared, data: AxleData, vehicle: Vehicle, settings: Settings, integrate: bool
) -> _Solved:
    """The balance, the pitch gain and the sensors' errors of one drive."""
    wheelbase = vehicle.quantities["wheelbase_m"].value
    empty = vehicle.get("mass_kg")
    usual = usual_moment(data, wheelbase, None if empty is None else empty.value)
    kilograms = usual[0] / (0.22 * wheelbase)
    mean, std, note = drag_moment(vehicle, 0.22 * wheelbase, kilograms > HEAVY_KG)
    huber = value(settings, "huber")
    inertia = pitch_inertia(vehicle, wheelbase, kilograms)
    known = Known((mean, std), (inertia[0], inertia[1]))
    if integrate:
        data, balance = better_form(data, wheelbase, known, huber)
    else:
        balance = doubted(by_force(data, wheelbase, known, huber), FORCE_DOUBT)
    pitch = measured_pitch(prepared, data, wheelbase)
    if pitch is None:
        axle = vehicle.get("cg_to_front_axle_m")
        height = float(np.clip(balance.moments[0] / kilograms, 0.1 * wheelbase, 0.5 * wheelbase))
        pitch = usual_pitch(vehicle, wheelbase, 0.5 * wheelbase if axle is None else axle.value, height)
    seen = _force_offset(data, integrate, pitch)
    mean_load = max(data.front or 0.0, data.rear or 0.0)
    errors = Errors(
        value(settings, "load_scale_std"), value(settings, "load_offset_std") * mean_load,
        value(settings, "force_scale_std"), _expected_offset(data, integrate, seen, value(settings, "accel_offset_std")),
        value(settings, "model_std"),
    )  # fmt: skip
    notes = [Assumption("force normal to the road", data.vertical_words, "log")]
    if data.speed is not None:
        notes.append(note)
    if data.pitch_accel is not None:
        notes.append(Assumption("pitch inertia", f"{inertia[0]:.0f} ± {inertia[1]:.0f} kg·m²", inertia[2]))
    return _Solved(data, balance, pitch, errors, seen, tuple(notes))


def _force_offset(data: AxleData, integrate: bool, pitch: Pitch) -> tuple[float, float] | None:
    """The accelerometer's constant error, m/s², as speed and grade show it, and its doubt; None where they do not."""
    if integrate or data.speed is None:
        return None
    assert data.accel is not None
    source = data.grade_source
    measured = source.kind == "road_grade"
    angle = source.angle[data.rows] if measured else np.zeros(data.size)
    force = data.speed_rate() + GRAVITY * np.sin(angle)
    doubt = GRAVITY * (source.std if measured else FLAT_STD)
    return float(np.mean(data.accel - (1 + pitch.gain) * force)), doubt


def _expected_offset(
    data: AxleData, integrate: bool, seen: tuple[float, float] | None, std: float
) -> tuple[float, float]:
    """Constant error of the force along the road, m/s²: the grade's, or the accelerometer's with what is usual."""
    if integrate:
        return 0.0, GRAVITY * data.grade_source.std
    if seen is None or std <= 0:
        return 0.0, std
    weight = std**2 / (std**2 + seen[1] ** 2)
    return weight * seen[0], math.sqrt(weight) * seen[1]
