"""Mass, CG position and arms from the strut forces of a whole drive: the batch companion to LTM, MLTM and HFLTM."""

from __future__ import annotations

import math

import numpy as np

from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.load_transfer.answers import (
    GIVEN,
    USUAL_ARM,
    Errors,
    Standing,
    about_cg,
    assumptions,
    contradiction,
    level_doubt,
    parameter,
    rolling_shift,
    sensors_covariance,
    unknown,
    whole_vehicle,
)
from pipelines.estimators.load_transfer.batch import ACROSS, ALONG, BRAKING, DRAG, STATIC, BatchFit, fit
from pipelines.estimators.load_transfer.data import (
    FORCES,
    Known,
    StrutData,
    collect,
    known_of,
    prepare_struts,
)
from pipelines.estimators.load_transfer.evidence import evidence
from pipelines.estimators.load_transfer.figures import force_traces, mass_tracks
from pipelines.estimators.load_transfer.noise import with_noise
from pipelines.joint.vehicle.hubs import hubs_past_of
from pipelines.models.axle_load import patch_shift
from pipelines.models.braking import AIR_DENSITY
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.results import Estimate, FloatArray, ParameterEstimate
from pipelines.vehicles.usual import STRUT_SCALE, STRUT_ZERO_N
from pipelines.vehicles.vehicle import Vehicle

SETTINGS: tuple[Setting, ...] = (
    Setting("cutoff_hz", 3.0, "Hz", "zero-phase low-pass of all signals", 0.3, 20.0),
    Setting("force_scale_std", STRUT_SCALE, "share", "scale error of a strut force sensor", 0.0, 0.5),
    Setting("force_offset_std", STRUT_ZERO_N, "N", "offset of a strut force sensor", 0.0, 5000.0),
    Setting(
        "model_std", 0.002, "share", "what the balances themselves may be wrong by, of the mass", 0.0, 0.2
    ),
)

NEEDS: tuple[Need, ...] = (
    Need((FORCES[0],), "the force of the front left strut"),
    Need((FORCES[1],), "the force of the front right strut"),
    Need((FORCES[2],), "the force of the rear left strut"),
    Need((FORCES[3],), "the force of the rear right strut"),
    Need(("accel_z", "accel_z_sprung_fl"), "the vertical acceleration that the struts carry against"),
)
VEHICLE_NEEDS: tuple[Need, ...] = (Need(("wheelbase_m",), "load transfer is m A_x h / L"),)

CAMBER = 0.3
ARM_DOUBT = 0.04
LIFT_M2 = 0.13
LEAST_STRETCHES = 4
"""CAMBER: std of the share of the unsprung masses' height that leans on the body in a turn. ARM_DOUBT: share of the pitch arm
that links and tyres may hide. LIFT_M2: what
lift may pass for in drag area. LEAST_STRETCHES: of 8 s, below which only the static loads are given."""


def value_of(settings: Settings, table: tuple[Setting, ...], name: str) -> float:
    """A setting, or its default."""
    return float(settings.get(name, next(s.default for s in table if s.name == name)))


class LoadTransferBatch:
    """The estimator "load_transfer_batch"."""

    name: str = "load_transfer_batch"
    title: str = "Load transfer on the struts, whole drive"

    source: str = (
        "companion to the gPC dissertation, chapters 6-8 (106)-(140): vertical, pitch and roll balance of the body on its "
        "strut forces, robust least squares over the whole drive"
    )
    signal_needs: tuple[Need, ...] = NEEDS
    vehicle_needs: tuple[Need, ...] = VEHICLE_NEEDS
    parameters: tuple[str, ...] = GIVEN
    settings: tuple[Setting, ...] = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Strut forces with everything beside them on one clock."""
        return prepare_struts(drive, None, value_of(settings, SETTINGS, "cutoff_hz"))

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Fit all four forces at once. A drive that cannot tell ends with "not_identifiable" and the reason."""
        del rng  # nothing is drawn
        known = known_of(vehicle)
        data = None if known is None else collect(prepared, known)
        if data is None or known is None:
            reason = "; ".join(prepared.notes) or "no stretch holds all four suspension forces"
            return self._nothing(reason, vehicle)
        errors = Errors(
            value_of(settings, SETTINGS, "force_scale_std"), value_of(settings, SETTINGS, "force_offset_std")
        )
        found = with_noise(fit(data), data, prepared.cutoff_hz)
        standing = _standing(found, data, known, vehicle, errors, value_of(settings, SETTINGS, "model_std"))
        wrong = contradiction(standing, data, vehicle)
        if wrong is not None:
            return self._nothing(wrong, vehicle)
        parameters = self._parameters(found, standing, data, known, vehicle)
        moving = data.moving and found.blocks >= LEAST_STRETCHES
        return Estimate(
            self.name, "ran", "the strut forces of the whole drive were fitted", parameters,
            tracks=mass_tracks(found, data, known, parameters),
            traces=force_traces(self.name, data, prepared, found.fitted),
            assumptions=assumptions(data, known, errors), diagnostics=_figures(found, data),
            used_fraction=data.size / max(data.drive_rows, 1),
            evidence=evidence(found, data, known, standing, moving),
        )  # fmt: skip

    def _parameters(
        self, found: BatchFit, standing: Standing, data: StrutData, known: Known, vehicle: Vehicle
    ) -> dict[str, ParameterEstimate]:
        words = "mean strut forces with motion taken out, and the vehicle file's unsprung masses"
        if not data.moving:
            words = "strut forces at standstill (the road's slope is not known), and the vehicle file's unsprung masses"
        answers = {
            name: parameter(name, value, std, words, known, vehicle, self.name)
            for name, (value, std) in whole_vehicle(standing, known).items()
        }
        if not data.moving or found.blocks < LEAST_STRETCHES:
            why = "it needs a drive with cornering and braking of half a minute or more"
            return answers | {n: unknown(n, why, vehicle) for n in GIVEN if n not in answers}
        sprung = float(standing.loads.sum()) / GRAVITY
        roll, pitch = roll_arm(found, sprung, known), pitch_arm(found, sprung, known, vehicle)
        answers["roll_arm_m"] = parameter(
            "roll_arm_m", *roll, "roll moment of the struts over lateral acceleration, sprung CG above the roll axis",
            known, vehicle, self.name,
        )  # fmt: skip
        answers["pitch_arm_m"] = parameter(
            "pitch_arm_m", *pitch, "pitch moment of the struts in braking, sprung CG above the links' pitch axis",
            known, vehicle, self.name,
        )  # fmt: skip
        if data.speed is None:
            answers["drag_area_m2"] = unknown("drag_area_m2", "it needs the speed", vehicle)
        else:
            drag = drag_area(found, sprung, known)
            why = "pitch moment of the struts that goes with speed squared; lift is not told from drag"
            answers["drag_area_m2"] = parameter("drag_area_m2", *drag, why, known, vehicle, self.name)
        return answers

    def _nothing(self, reason: str, vehicle: Vehicle) -> Estimate:
        return Estimate(self.name, "ran", reason, {n: unknown(n, reason, vehicle) for n in GIVEN})


def _halves(known: Known) -> FloatArray:
    front, rear = 0.5 * known.track[0].value, 0.5 * known.track[1].value
    return np.array([front, -front, rear, -rear])


def _standing(
    found: BatchFit, data: StrutData, known: Known, vehicle: Vehicle, errors: Errors, model: float
) -> Standing:
    loads = found.coefficients[STATIC]
    rows = slice(4 * STATIC, 4 * STATIC + 4)
    covariance = found.covariance[rows, rows] + sensors_covariance(loads, errors)
    # what all balances miss alike changes all struts alike
    covariance = covariance + model**2 * np.outer(loads, loads)
    arms = (USUAL_ARM, USUAL_ARM)
    along, across = level_doubt(data, arms)
    shift = rolling_shift(vehicle, known) if data.moving else (0.0, 0.0)
    own = model * known.wheelbase.value
    return Standing(
        loads, covariance, (shift[0], math.hypot(shift[1], along, own)), (0.0, math.hypot(across, 0.5 * own))
    )


def roll_arm(found: BatchFit, sprung: float, known: Known) -> tuple[float, float]:
    """Sprung CG above the roll axis, m, and its standard deviation: the wheels' gyroscopic moment taken out."""
    moment, spread = found.combine(-_halves(known), ACROSS)
    radius, inertia = known.wheel_radius, known.wheel_inertia
    gyroscope = 4 * inertia.value / radius.value / sprung
    lean = CAMBER * known.unsprung_kg * radius.value / sprung
    doubt = (0.5 * gyroscope, lean, spread / sprung, 0.006 * moment / sprung)
    return moment / sprung - gyroscope, math.hypot(*doubt)


def pitch_arm(found: BatchFit, sprung: float, known: Known, vehicle: Vehicle) -> tuple[float, float]:
    """Sprung CG above the pitch axis of braking, m, and its standard deviation.

    Beside it the struts see what of the unsprung masses' inertia their links' arms do not take, the wheels' spin, and the tyres' patches.
    """
    both = np.zeros_like(found.coefficients)
    both[ALONG] = both[BRAKING] = about_cg(found, known)
    flat = both.ravel()
    arm = float(flat @ found.coefficients.ravel()) / sprung
    spread = math.sqrt(max(float(flat @ found.covariance @ flat), 0.0)) / sprung
    radius = known.wheel_radius.value
    past, past_std = hubs_past_of(vehicle)
    under = known.unsprung_kg / sprung
    spin = 4 * known.wheel_inertia.value / radius / sprung
    mass, rate = vehicle.get("mass_kg"), vehicle.get("tire_vertical_rate_npm")
    patch, patch_std = patch_shift(None if mass is None else mass.value, None if rate is None else rate.value)
    extra = under * radius * (1 - past) + spin + patch
    doubt = (spread, under * radius * past_std, 0.3 * spin, patch_std, ARM_DOUBT * abs(arm))
    return arm - extra, math.hypot(*doubt)


def drag_area(found: BatchFit, sprung: float, known: Known) -> tuple[float, float]:
    """Drag area, m², and its standard deviation: the force is taken to act as high as the arm of driving."""
    lever = about_cg(found, known)
    moment, spread = found.combine(lever, DRAG)
    arm, _ = found.combine(lever, ALONG)
    arm = max(arm / sprung, 0.1)
    area = moment / (0.5 * AIR_DENSITY * arm)
    return area, math.hypot(spread / (0.5 * AIR_DENSITY * arm), 0.25 * area, LIFT_M2)


def _figures(found: BatchFit, data: StrutData) -> dict[str, float]:
    heave = found.coefficients[1].sum() / (found.coefficients[STATIC].sum() / GRAVITY)
    figures = {
        "stretches": float(found.blocks),
        "samples": float(data.size),
        "heave_mass_over_static": float(heave),
        "downweighted_share": float(np.mean(found.weights < 1.0)),
        "level_doubt_along_mps2": data.offset_std[0],
        "level_doubt_across_mps2": data.offset_std[1],
        "cross_weight_kg": float(found.coefficients[STATIC] @ np.array([-0.25, 0.25, 0.25, -0.25]) / GRAVITY),
    }
    return figures | {
        f"residual_{w}_n": float(s) for w, s in zip(WHEELS, found.residual.std(axis=0), strict=True)
    }
