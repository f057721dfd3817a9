"""Pitch inertia, pitch arm, sprung mass and longitudinal place from the struts' pitch moment over a whole drive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.drive import Drive
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.roll_pitch_plane.answers import (
    Masses,
    Said,
    SensorErrors,
    answer,
    coefficient_draws,
    draw_masses,
    unexplained,
    unknown,
)
from pipelines.estimators.roll_pitch_plane.balances import carried, pitching, pivot_doubt, usual_size
from pipelines.estimators.roll_pitch_plane.data import CORNERS, FORCE_NEEDS, Planes, collect
from pipelines.estimators.roll_pitch_plane.evidence import pitch_evidence
from pipelines.estimators.roll_pitch_plane.figures import assumptions, diagnostics, growing, traces
from pipelines.estimators.roll_pitch_plane.fit import LinearFit
from pipelines.estimators.roll_pitch_plane.known import (
    DRAWS,
    NET_MOMENT,
    PITCH_CENTER,
    WHEELBASE,
    Draws,
    inertia_prior,
    inertia_prior_of,
    tracks,
    wheelbase,
)
from pipelines.estimators.roll_pitch_plane.settings import (
    LEAST_EXPLAINED,
    LEAST_TOLD,
    SETTINGS,
    prepare_planes,
    sensor_errors,
    setting,
    unlike,
)
from pipelines.joint.vehicle.hubs import hubs_past_draws
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.results import Estimate, FloatArray, ParameterEstimate, Track
from pipelines.vehicles.vehicle import Quantity, Vehicle

NAMES = ("pitch_inertia_kgm2", "pitch_arm_m", "sprung_mass_kg", "cg_to_front_axle_m")
LINK_STD_M = 0.05
"""How much the axes of hub and foot differ in height: what the unsprung masses' inertia turns the body about."""


HARD_MPS2, HARD_SHARE = 3.5, 0.01
"""Deceleration from which the pitch arm bends, and by what share a m/s² more."""


@dataclass(frozen=True)
class PitchFit:
    """One drive's pitch balance with what it was made from."""

    planes: Planes
    load: LinearFit
    pitch: LinearFit


class PitchPlane:
    """The estimator "pitch_plane"."""

    name: str = "pitch_plane"
    title: str = "Pitch plane from strut forces, whole drive"
    source: str = (
        "gPC dissertation, 6.2, (103)-(104) with signs set right, as least squares over the drive with the noise of the "
        "pitch acceleration taken out; links, delays, drag and friction as unknowns"
    )
    signal_needs: tuple[Need, ...] = (
        *FORCE_NEEDS,
        Need(("accel_x",), "the longitudinal specific force that pitches the body"),
        Need(
            (CORNERS[0], "pitch_rate"),
            "the pitch acceleration: body accelerations over all wheels, or a gyro",
        ),
    )
    vehicle_needs: tuple[Need, ...] = (Need(("wheelbase_m",), "the struts' lever"),)
    parameters: tuple[str, ...] = NAMES
    settings: tuple[Setting, ...] = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Strut forces and longitudinal acceleration on one fine clock, the rest as there."""
        return prepare_planes(drive, settings, "accel_x")

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Fit and explain. A drive that cannot tell ends with parameters "not_identifiable" and the reason."""
        found = fit_pitch(prepared, vehicle)
        if isinstance(found, str):
            parameters = {n: unknown(n, found, vehicle, inertia_prior_of(n, vehicle)) for n in NAMES}
            return Estimate(self.name, "ran", found, parameters)
        draws = Draws(vehicle, rng)
        errors = unexplained(sensor_errors(settings), found.pitch, found.load.value("mass"))
        masses = draw_masses(draws, found.planes, found.load, errors)
        parameters = _answers(found, masses, draws, errors, vehicle, setting(settings, "least_longitudinal"))
        told = parameters["pitch_inertia_kgm2"].status != "not_identifiable"
        return Estimate(
            self.name, "ran", f"the struts' pitch moment was fitted to {100 * found.pitch.explained:.1f} %", parameters,
            tracks=_tracks(found, parameters), traces=traces(found.planes, found.pitch, "pitch_moment", "pitch"),
            assumptions=assumptions(prepared, found.planes, draws.assumptions, "pitch_acc"),
            diagnostics=diagnostics(found.pitch), used_fraction=len(found.planes.time_s) / max(found.planes.drive_rows, 1),
            evidence=pitch_evidence(found.pitch, found.planes, found.load.value("mass"), errors) if told else (),
        )  # fmt: skip


def _tracks(found: PitchFit, parameters: Mapping[str, ParameterEstimate]) -> tuple[Track, ...]:
    mass = found.load.value("mass")

    def refit(planes: Planes) -> LinearFit | None:
        return pitching(planes, mass)

    return (
        *growing(found.planes, refit, parameters["pitch_inertia_kgm2"], "pitch_acc", 1.0),
        *growing(found.planes, refit, parameters["pitch_arm_m"], "fx_brake", 1 / mass),
    )


def fit_pitch(prepared: Prepared, vehicle: Vehicle) -> PitchFit | str:
    """The pitch balance of a drive, or why there is none."""
    planes = collect(prepared, tracks(vehicle), wheelbase(vehicle))
    if planes is None:
        return "; ".join(prepared.notes) or "the forces of all four struts are nowhere there together"
    if "pitch_acc" not in planes.columns:
        return "no pitch acceleration: it needs body accelerations over all four wheels, or a pitch rate"
    load = carried(planes)
    if load is None:
        return "the drive is too short: 20 s of forces and accelerations are needed"
    if not load.value("mass") > 0:
        return (
            "the struts' forces do not carry the vehicle: their sum is not above zero (signs, zero at rest)"
        )
    pitch = pitching(planes, load.value("mass"))
    if pitch is None:
        return "the drive is too short: 20 s of forces and accelerations are needed"
    return PitchFit(planes, load, pitch)


@dataclass(frozen=True)
class _Body:
    """Draws of what the coefficients mean, (DRAWS,) each."""

    whole_inertia: FloatArray
    arm: FloatArray
    behind: FloatArray


def _body(found: PitchFit, m: Masses, draws: Draws, errors: SensorErrors, vehicle: Vehicle) -> _Body:
    c = coefficient_draws(found.pitch, draws.rng)
    known = vehicle.get("wheelbase_m") or Quantity(WHEELBASE[0], WHEELBASE[1], "")
    longer = draws.normal(1.0, known.std / known.value)
    length = known.value * longer
    scale = m.force_scale / draws.normal(1.0, errors.accel_scale) * longer
    # a drive that brakes at one strength does not part the arm from its bend: the arm is that of the braking that was driven
    brake = (
        c["fx_brake"] + c["curve"] * usual_size(found.planes.columns["fx"][found.planes.braking])
    ) * scale
    drive = c["fx_drive"] * scale
    # beside the body: the unsprung masses at the height of their hubs, and the wheels' spin
    hubs = m.unsprung * (m.radius + draws.normal(0.0, LINK_STD_M)) + m.spin
    # of these the arms of the links take a part past the struts
    past = m.unsprung * m.radius * hubs_past_draws(vehicle, draws.rng, DRAWS)
    arm = (
        brake * draws.normal(1.0, float(np.hypot(errors.arm_model, _hard(found.planes)))) - hubs + past
    ) / m.sprung
    height = arm + draws.of("pitch_center_height_m", PITCH_CENTER)
    above = draws.place("imu_above_ground_m", float(np.median(height)), 0.2) - height
    doubt = found.pitch.doubt("pitch_acc", NET_MOMENT * float(np.std(found.planes.columns["pitch_moment"])))
    doubt = float(np.hypot(doubt, pivot_doubt(found.planes, found.load.value("mass"))))
    inertia = (c["pitch_acc"] + draws.normal(0.0, doubt)) * scale + 0.5 * (brake + drive) * above
    inertia = inertia + hubs * (height - m.radius)
    # static: the coefficient of f_z is m d about the middle of the wheelbase, the sensors' zeros and scales on top
    offset = (m.static - found.planes.loads) @ (0.5 * known.value * np.array([-1.0, -1.0, 1.0, 1.0]))
    askew = 0.5 * (brake + drive) * draws.normal(0.0, errors.accel_offset)
    behind = 0.5 * length + (c["fz"] * GRAVITY * longer + offset + askew) / (m.sprung * GRAVITY)
    # the vertical accelerometer sits off the CG, so that a part of its reading is pitch acceleration
    off = draws.place("imu_behind_front_axle_m", 0.5 * known.value, 0.15 * known.value) - behind
    inertia = (inertia + m.sprung * (behind - 0.5 * length) * off) * draws.normal(1.0, errors.inertia_model)
    whole_behind = (m.sprung * behind + m.rear * length) / m.whole
    drop = m.unsprung / m.whole * (height - m.radius)
    whole = inertia + m.sprung * ((behind - whole_behind) ** 2 + drop**2)
    whole = whole + m.unsprung * (height - drop - m.radius) ** 2
    whole = whole + m.front * whole_behind**2 + m.rear * (length - whole_behind) ** 2
    return _Body(whole, arm, whole_behind)


def _hard(planes: Planes) -> float:
    """What hard braking adds to the model's error of the arm, as a share: it dives until stops, tyres and axes move."""
    braked = np.abs(planes.columns["fx"][planes.braking])
    if not len(braked):
        return 0.0
    return HARD_SHARE * max(float(np.quantile(braked, 0.95)) - HARD_MPS2, 0.0)


def _answers(
    found: PitchFit, masses: Masses, draws: Draws, errors: SensorErrors, vehicle: Vehicle, least: float
) -> dict[str, ParameterEstimate]:
    body = _body(found, masses, draws, errors, vehicle)
    pitch, planes = found.pitch, found.planes
    spread = float(np.std(planes.columns["fx"]))
    told = float(pitch.told[pitch.names.index("pitch_acc")])
    bad = unlike(pitch) if pitch.explained < LEAST_EXPLAINED else None
    along = bad
    if spread < least:
        along = f"the longitudinal acceleration changes by {spread:.2f} m/s² (standard deviation): braking and driving of {least:g} m/s² are needed"
    elif not planes.braking.any():
        along = "the brakes are never on: the pitch arm is that of braking"
    inertia = bad
    if inertia is None and told < LEAST_TOLD:
        inertia = (
            f"of the pitch acceleration, beside what goes with the longitudinal acceleration, {100 * (1 - told):.0f} % is noise: "
            "a rough road would tell the inertia"
        )
    words = "of the whole vehicle about its CG; from the struts' pitch moment against the pitch acceleration, wheels added"
    links = "sprung CG above the axis about which braking pitches the body: strut forces do not see what the links carry"
    prior = inertia_prior("pitch_inertia_kgm2", vehicle)
    length = wheelbase(vehicle)
    said = {
        "pitch_inertia_kgm2": (body.whole_inertia, Said(0.08, 0.3, words, inertia, low=0.0, prior=prior)),
        "pitch_arm_m": (body.arm, Said(0.06, 0.2, links, along, low=0.02, high=3.0)),
        "sprung_mass_kg": (masses.sprung, Said(0.02, 0.06, "what the struts carry over the drive", low=0.0)),
        "cg_to_front_axle_m": (
            body.behind,
            Said(0.01, 0.03, "from the struts' mean pitch moment with longitudinal acceleration taken out; wheels added",
                 bad, scale=length, low=0.0, high=length),
        ),
    }  # fmt: skip
    return {n: answer(n, values, how, vehicle, "pitch_plane") for n, (values, how) in said.items()}
