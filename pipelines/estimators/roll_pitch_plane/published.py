"""Roll and pitch plane by the gPC-EKF for regression systems as the dissertation has it: a witness, sample by sample.

Its own spread knows the samples' noise and the additions, nothing of friction, links or of the height at which the lateral
acceleration is measured. What the estimate wanders by and allowances for these are put on top.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.drive import Drive
from pipelines.chaos.bases import legendre
from pipelines.chaos.collocation import collocate
from pipelines.chaos.space import Space
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.roll_pitch_plane.answers import Said, answer, unknown
from pipelines.estimators.roll_pitch_plane.data import CORNERS, FORCE_NEEDS, Planes, collect
from pipelines.estimators.roll_pitch_plane.known import (
    RADIUS,
    Draws,
    inertia_prior,
    inertia_prior_of,
    tracks,
    wheelbase,
)
from pipelines.estimators.roll_pitch_plane.settings import prepare_planes
from pipelines.filters.gpc_regression import RegressionFilter, RegressionRun, gpc_regression
from pipelines.filters.gpc_update import PUBLISHED
from pipelines.models.roll import GRAVITY
from pipelines.models.roll_plane import BOTH_PLANES, both_planes_regressors
from pipelines.prepare.prepared import Prepared
from pipelines.results import Assumption, Estimate, FloatArray, ParameterEstimate, Track
from pipelines.vehicles.usual import usual_unsprung
from pipelines.vehicles.vehicle import Vehicle

NAMES = (
    "sprung_mass_kg",
    "roll_inertia_kgm2",
    "pitch_inertia_kgm2",
    "roll_arm_m",
    "pitch_arm_m",
    "cg_lateral_offset_m",
)
ORDER, FACTOR = 2, 4.0
ADDITIONS = np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 0.5])
"""Table 3.10: c_4 of the height is half of c_1 .. c_3; lengths are taken like the height."""

MODEL_SHARE = {"sprung_mass_kg": 0.02, "roll_inertia_kgm2": 0.15, "pitch_inertia_kgm2": 0.12, "roll_arm_m": 0.08,
               "pitch_arm_m": 0.1}  # fmt: skip
PLACE_STD_M = 0.015
SENSOR_HEIGHT_STD_M = 0.15
SENSOR_PLACE_SHARE = 0.15
"""Allowances on top of the filter's own spread: shares for what the model leaves out, m for the lateral place, and how far
above or below the CG the accelerometers sit, and before or behind it, in wheelbases."""

SETTINGS: tuple[Setting, ...] = (
    Setting("cutoff_hz", 5.0, "Hz", "zero-phase low-pass of all signals", 0.5, 20.0),
    Setting("noise_variance", 0.1, "(m/s²)², (rad/s²)²", "R of Table 3.10, of all outputs", 1e-6, 100.0),
    Setting("addition", 1e-4, "share", "c_1 of Table 3.10: of the prior's half width a sample", 0.0, 0.1),
    Setting("least_excitation", 0.25, "m/s²", "spread of lateral, longitudinal acceleration below which no arm is given", 0.0, 5.0),
    Setting("least_angular", 0.05, "rad/s²", "spread of angular acceleration below which no inertia is given", 0.0, 5.0),
)  # fmt: skip


@dataclass(frozen=True)
class Start:
    """The prior before the first sample: parameter = middle + half mu, mu uniform on -1..1. (7,) each."""

    middle: FloatArray
    half: FloatArray


class GpcRollPlane:
    """The estimator "gpc_roll_plane"."""

    name: str = "gpc_roll_plane"
    title: str = "Roll and pitch plane by gPC-EKF, as published"
    source: str = "gPC dissertation, 3.6-3.8 (70)-(79) and 6.1-6.2 (101)-(104), signs set right"
    signal_needs: tuple[Need, ...] = (
        *FORCE_NEEDS,
        Need(("accel_y",), "the lateral specific force that rolls the body"),
        Need(("accel_x",), "the longitudinal specific force that pitches the body"),
        Need(
            (CORNERS[0], "roll_rate"), "the roll acceleration: body accelerations over all wheels, or a gyro"
        ),
        Need(
            (CORNERS[0], "pitch_rate"),
            "the pitch acceleration: body accelerations over all wheels, or a gyro",
        ),
    )
    vehicle_needs: tuple[Need, ...] = (
        Need(("track_front_m", "track_rear_m"), "the struts' lever"),
        Need(("wheelbase_m",), "the struts' lever"),
    )
    parameters: tuple[str, ...] = NAMES
    settings: tuple[Setting, ...] = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Strut forces and accelerations on one fine clock."""
        return prepare_planes(drive, {"cutoff_hz": _value(settings, "cutoff_hz")}, "accel_y")

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Run the filter over the drive."""
        planes = collect(prepared, tracks(vehicle), wheelbase(vehicle))
        lacks = None
        if planes is None:
            lacks = "; ".join(prepared.notes) or "the forces of all four struts are nowhere there together"
        elif not {"roll_acc", "pitch_acc"} <= set(planes.columns):
            lacks = "no roll and pitch acceleration: it needs body accelerations over all four wheels, or the rates"
        elif not planes.loads.sum() > 0:
            lacks = "the struts' forces do not carry the vehicle: their sum is not above zero (signs, zero at rest)"
        if planes is None or lacks is not None:
            words = lacks or ""
            nothing = {n: unknown(n, words, vehicle, inertia_prior_of(n, vehicle)) for n in NAMES}
            return Estimate(self.name, "ran", words, nothing, witness=True)
        start = starting(planes, vehicle)
        run = _filtered(planes, start, settings)
        draws = Draws(vehicle, rng)
        found = _answers(run, start, planes, draws, settings, vehicle)
        return Estimate(
            self.name, "ran", "the filter ran over the drive; a witness: friction and links are not in its model", found,
            tracks=_tracks(run, planes),
            assumptions=(
                *draws.assumptions,
                *(Assumption(f"start: {n}", f"{m:.4g} ± {h:.3g} (uniform)", "vehicle file and usual vehicles")
                  for n, m, h in zip(BOTH_PLANES.parameters, start.middle, start.half, strict=True)),
                Assumption("angular acceleration", planes.how["roll_acc"], "log"),
            ),
            diagnostics={f"{n}_spread": float(s) for n, s in zip(BOTH_PLANES.parameters, run.spread[-1], strict=True)},
            used_fraction=len(planes.time_s) / max(planes.drive_rows, 1), witness=True,
        )  # fmt: skip


def _value(settings: Settings, name: str) -> float:
    return float(settings.get(name, next(s.default for s in SETTINGS if s.name == name)))


def starting(planes: Planes, vehicle: Vehicle) -> Start:
    """Where the filter starts: the mean load, the vehicle file's or usual inertias, usual arms."""
    mass = float(planes.loads.sum()) / GRAVITY
    length = wheelbase(vehicle)
    behind = length * (float(planes.loads[2:].sum() / planes.loads.sum()) - 0.5)
    roll, pitch = (inertia_prior(n, vehicle) for n in ("roll_inertia_kgm2", "pitch_inertia_kgm2"))
    inertias = (
        1.6 * mass if pitch is None else 0.9 * pitch.value,
        0.36 * mass if roll is None else 0.85 * roll.value,
    )
    middle = np.array([mass, *inertias, 0.55, 0.55, 0.0, behind])
    half = np.array([0.1 * mass, 0.4 * inertias[0], 0.4 * inertias[1], 0.35, 0.35, 0.1, 0.1 * length])
    return Start(middle, half)


def _filtered(planes: Planes, start: Start, settings: Settings) -> RegressionRun:
    c = planes.columns
    phi = both_planes_regressors(
        c["total"], (c["roll_moment"], c["pitch_moment"]), (c["fx"], c["fy"], c["fz"])
    )
    outputs = np.column_stack((c["fz"], c["roll_acc"], c["pitch_acc"]))
    points = collocate(Space((legendre(),) * len(start.middle)), ORDER, factor=FACTOR)
    how = RegressionFilter(
        BOTH_PLANES, points, start.middle, start.half, np.full(3, _value(settings, "noise_variance")),
        _value(settings, "addition") * ADDITIONS, PUBLISHED,
    )  # fmt: skip
    return gpc_regression(phi, outputs, how, every=max(1, round(planes.rate_hz)))


def _answers(
    run: RegressionRun, start: Start, planes: Planes, draws: Draws, settings: Settings, vehicle: Vehicle
) -> dict[str, ParameterEstimate]:
    if len(run.track) < 2:
        words = "the drive is too short"
        return {n: unknown(n, words, vehicle, inertia_prior_of(n, vehicle)) for n in NAMES}
    late = run.track[len(run.track) // 2 :]
    lost = {
        n
        for n, value, middle, half in zip(
            BOTH_PLANES.parameters, run.track[-1], start.middle, start.half, strict=True
        )
        if not abs(value - middle) <= half
    }
    last = dict(zip(BOTH_PLANES.parameters, run.track[-1], strict=True))
    own = dict(zip(BOTH_PLANES.parameters, np.hypot(run.spread[-1], late.std(axis=0)), strict=True))
    mass = last["sprung_mass_kg"]
    values = {
        n: draws.normal(last[n], np.hypot(own[n], MODEL_SHARE.get(n, 0.0) * abs(last[n]))) for n in NAMES[:5]
    }
    side = draws.normal(last["cg_lateral_offset_m"], np.hypot(own["cg_lateral_offset_m"], PLACE_STD_M))
    unsprung = [
        np.maximum(draws.of(f"unsprung_mass_{a}_kg", usual_unsprung(draws.vehicle, a, mass)), 0.0)
        for a in ("front", "rear")
    ]
    wheels = unsprung[0] + unsprung[1]
    values["cg_lateral_offset_m"] = side * mass / (mass + wheels)
    # the filter's inertias are the body's, about the accelerometer's height; the reference is the whole vehicle's
    high = draws.normal(0.0, SENSOR_HEIGHT_STD_M)
    below = draws.of("wheel_radius_m", RADIUS) - 0.65
    track, length = tracks(vehicle), wheelbase(vehicle)
    front = 0.5 * length + last["cg_behind_middle_m"]
    roll = 0.25 * (unsprung[0] * track[0] ** 2 + unsprung[1] * track[1] ** 2) + wheels * below**2
    pitch = unsprung[0] * front**2 + unsprung[1] * (length - front) ** 2 + wheels * below**2
    values["roll_inertia_kgm2"] = values["roll_inertia_kgm2"] + mass * last["roll_arm_m"] * high + roll
    ahead = draws.normal(0.0, SENSOR_PLACE_SHARE * length) * mass * last["cg_behind_middle_m"]
    values["pitch_inertia_kgm2"] = (
        values["pitch_inertia_kgm2"] + mass * last["pitch_arm_m"] * high + ahead + pitch
    )
    return {n: _said(n, values[n], n in lost, planes, settings, vehicle) for n in NAMES}


def _said(
    name: str, values: FloatArray, lost: bool, planes: Planes, settings: Settings, vehicle: Vehicle
) -> ParameterEstimate:
    c = planes.columns
    column, least, what = {
        "roll_inertia_kgm2": ("roll_acc", "least_angular", "roll acceleration"),
        "pitch_inertia_kgm2": ("pitch_acc", "least_angular", "pitch acceleration"),
        "roll_arm_m": ("fy", "least_excitation", "lateral acceleration"),
        "pitch_arm_m": ("fx", "least_excitation", "longitudinal acceleration"),
    }.get(name, ("fz", "", ""))
    lacks = None
    spread = float(np.std(c[column]))
    if least and spread < _value(settings, least):
        lacks = (
            f"the {what} changes by {spread:.2g} (standard deviation): {_value(settings, least):g} is needed"
        )
    elif lost or not np.isfinite(values).all():
        lacks = "the filter left the range in which it started: struts and accelerations go together too closely to tell it"
    words = "as published; interval: the filter's spread, its wander over the second half, and allowances for links and friction"
    inertia = name.endswith("inertia_kgm2")
    shares = {"sprung_mass_kg": (0.03, 0.1), "cg_lateral_offset_m": (0.02, 0.06)}.get(name, (0.1, 0.5))
    scale = tracks(vehicle)[0] if name == "cg_lateral_offset_m" else None
    low = -2.0 if name == "cg_lateral_offset_m" else 0.0
    said = Said(
        *shares, words, lacks, scale, low=low, prior=inertia_prior(name, vehicle) if inertia else None
    )
    return answer(name, values, said, vehicle, "gpc_roll_plane")


def _tracks(run: RegressionRun, planes: Planes) -> tuple[Track, ...]:
    """The filter's own estimate and spread, a row about a second; of the body alone."""
    every = max(1, round(planes.rate_hz))
    time_s = planes.time_s[every - 1 :: every][: len(run.track)]
    found = []
    for name in NAMES:
        i = BOTH_PLANES.parameters.index(name)
        value, half = run.track[:, i], 1.96 * run.spread[:, i]
        found.append(Track(name, time_s, value, value - half, value + half))
    return tuple(found)
