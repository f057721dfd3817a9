"""Roll inertia, roll arm, sprung mass and lateral place from the struts' roll moment over a whole drive."""

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
from pipelines.estimators.roll_pitch_plane.balances import Wheels, carried, rolling
from pipelines.estimators.roll_pitch_plane.data import CORNERS, FORCE_NEEDS, Planes, collect
from pipelines.estimators.roll_pitch_plane.evidence import roll_evidence
from pipelines.estimators.roll_pitch_plane.figures import assumptions, diagnostics, growing, traces
from pipelines.estimators.roll_pitch_plane.fit import LinearFit
from pipelines.estimators.roll_pitch_plane.known import (
    FEET,
    GYROSCOPE,
    LEAN,
    LEAN_GAIN,
    NET_MOMENT,
    ROLL_CENTER,
    ROLL_RADPS,
    TRACK,
    WHEEL_INERTIA,
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
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.results import Estimate, FloatArray, ParameterEstimate, Track
from pipelines.vehicles.vehicle import Quantity, Vehicle

NAMES = ("roll_inertia_kgm2", "roll_arm_m", "sprung_mass_kg", "cg_lateral_offset_m")


QUIET_SHARE = 0.01
LEAST_POWER = 0.01
"""Residual as a share of a side's load times its lever below which the mean moment tells the lateral place all the same; variance of the
lateral acceleration, m²/s⁴, below which its lean is not measured."""


@dataclass(frozen=True)
class RollFit:
    """One drive's roll balance with what it was made from."""

    planes: Planes
    load: LinearFit
    roll: LinearFit
    wheels: Wheels


class RollPlane:
    """The estimator "roll_plane"."""

    name: str = "roll_plane"
    title: str = "Roll plane from strut forces, whole drive"
    source: str = (
        "gPC dissertation, 6.1, (101)-(102) with signs set right, as least squares over the drive with the noise of the "
        "roll acceleration taken out; links, delays and friction as unknowns"
    )
    signal_needs: tuple[Need, ...] = (
        *FORCE_NEEDS,
        Need(("accel_y",), "the lateral specific force that rolls the body"),
        Need(
            (CORNERS[0], "roll_rate"), "the roll acceleration: body accelerations over all wheels, or a gyro"
        ),
    )
    vehicle_needs: tuple[Need, ...] = (Need(("track_front_m", "track_rear_m"), "the struts' lever"),)
    parameters: tuple[str, ...] = NAMES
    settings: tuple[Setting, ...] = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Strut forces and lateral acceleration on one fine clock, the rest as there."""
        return prepare_planes(drive, settings, "accel_y")

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Fit and explain. A drive that cannot tell ends with parameters "not_identifiable" and the reason."""
        found = fit_roll(prepared, vehicle)
        if isinstance(found, str):
            parameters = {n: unknown(n, found, vehicle, inertia_prior_of(n, vehicle)) for n in NAMES}
            return Estimate(self.name, "ran", found, parameters)
        draws = Draws(vehicle, rng)
        errors = unexplained(sensor_errors(settings), found.roll, found.load.value("mass"))
        masses = draw_masses(draws, found.planes, found.load, errors)
        parameters = _answers(found, masses, draws, errors, vehicle, setting(settings, "least_lateral"))
        told = parameters["roll_inertia_kgm2"].status != "not_identifiable"
        return Estimate(
            self.name, "ran", f"the struts' roll moment was fitted to {100 * found.roll.explained:.1f} %", parameters,
            tracks=_tracks(found, parameters), traces=traces(found.planes, found.roll, "roll_moment", "roll"),
            assumptions=assumptions(prepared, found.planes, draws.assumptions, "roll_acc"),
            diagnostics=diagnostics(found.roll), used_fraction=len(found.planes.time_s) / max(found.planes.drive_rows, 1),
            evidence=roll_evidence(found.roll, found.planes, found.wheels, found.load.value("mass"), errors) if told else (),
        )  # fmt: skip


def _tracks(found: RollFit, parameters: Mapping[str, ParameterEstimate]) -> tuple[Track, ...]:
    mass = found.load.value("mass")

    def refit(planes: Planes) -> LinearFit | None:
        return rolling(planes, mass, found.wheels)

    return (
        *growing(found.planes, refit, parameters["roll_inertia_kgm2"], "roll_acc", 1.0),
        *growing(found.planes, refit, parameters["roll_arm_m"], "fy", -1 / mass),
    )


def fit_roll(prepared: Prepared, vehicle: Vehicle) -> RollFit | str:
    """The roll balance of a drive, or why there is none."""
    planes = collect(prepared, tracks(vehicle), wheelbase(vehicle))
    if planes is None:
        return "; ".join(prepared.notes) or "the forces of all four struts are nowhere there together"
    if "roll_acc" not in planes.columns:
        return "no roll acceleration: it needs body accelerations over all four wheels, or a roll rate"
    load = carried(planes)
    if load is None:
        return "the drive is too short: 20 s of forces and accelerations are needed"
    if not load.value("mass") > 0:
        return (
            "the struts' forces do not carry the vehicle: their sum is not above zero (signs, zero at rest)"
        )
    inertia, radius = vehicle.get("wheel_inertia_kgm2"), vehicle.get("wheel_radius_m")
    spin = 4 * (inertia.value if inertia else WHEEL_INERTIA[0]) / (radius.value if radius else 0.33)
    centers = [vehicle.get(f"roll_center_height_{axle}_m") for axle in ("front", "rear")]
    axis = sum(ROLL_CENTER[0] if q is None else q.value for q in centers) / 2
    feet = FEET[0] * axis * load.value("mass") * GRAVITY if "lean" in planes.columns else 0.0
    wheels = Wheels(spin, GYROSCOPE[0] if "vyaw" not in planes.missing else 0.0, feet)
    roll = rolling(planes, load.value("mass"), wheels)
    if roll is None:
        return "the drive is too short: 20 s of forces and accelerations are needed"
    return RollFit(planes, load, roll, wheels)


@dataclass(frozen=True)
class _Body:
    """Draws of what the coefficients mean, (DRAWS,) each."""

    inertia: FloatArray
    whole_inertia: FloatArray
    arm: FloatArray
    left: FloatArray


def _body(found: RollFit, m: Masses, draws: Draws, errors: SensorErrors, vehicle: Vehicle) -> _Body:
    c = coefficient_draws(found.roll, draws.rng)
    track = tracks(vehicle)
    mean_track = 0.5 * (track[0] + track[1])
    known = vehicle.get("track_front_m") or vehicle.get("track_rear_m") or Quantity(TRACK[0], TRACK[1], "")
    wider = draws.normal(1.0, known.std / known.value)
    scale = m.force_scale / draws.normal(1.0, errors.accel_scale)
    moment = -c["fy"] * scale * wider
    lean = np.clip(draws.normal(*LEAN), 0.0, 1.0)
    hubs = m.unsprung * m.radius * lean
    # parts of these were taken off before the fit
    gyro = m.spin * (draws.normal(*GYROSCOPE) - found.wheels.gyroscope)
    place = m.static[:, 2:].sum(axis=1) / m.static.sum(axis=1)
    axis = (1 - place) * draws.of("roll_center_height_front_m", ROLL_CENTER)
    axis = axis + place * draws.of("roll_center_height_rear_m", ROLL_CENTER)
    feet = np.clip(draws.normal(*FEET), 0.0, 1.1) * axis * m.sprung * GRAVITY - found.wheels.feet
    arm = (moment * draws.normal(1.0, errors.arm_model) - hubs - gyro) / m.sprung
    arm = arm + feet * _lean_gain(found.planes, draws) / m.sprung
    height = axis + arm
    above = draws.place("imu_above_ground_m", float(np.median(height)), 0.2) - height
    doubt = found.roll.doubt("roll_acc", NET_MOMENT * float(np.std(found.planes.columns["roll_moment"])))
    inertia = (
        (c["roll_acc"] + draws.normal(0.0, doubt)) * scale * wider
        + moment * above
        + hubs * (arm - lean * m.radius)
        + feet / ROLL_RADPS**2
    )
    inertia = inertia * draws.normal(1.0, errors.inertia_model)
    # static: the coefficient of f_z is m l, with the sensors' zeros and scales on top
    offset = (m.static - found.planes.loads) @ (0.5 * mean_track * np.array([1.0, -1.0, 1.0, -1.0]))
    askew = moment * draws.normal(0.0, errors.accel_offset)
    left = (c["fz"] * GRAVITY * wider + offset + askew) / (m.sprung * GRAVITY)
    drop = m.unsprung / m.whole * (height - m.radius)
    hub_y = 0.25 * (m.front * track[0] ** 2 + m.rear * track[1] ** 2) * wider**2
    whole = inertia + m.sprung * drop**2 + m.unsprung * (height - drop - m.radius) ** 2 + hub_y
    return _Body(inertia, whole, arm, left * m.sprung / m.whole)


def _lean_gain(planes: Planes, draws: Draws) -> FloatArray:
    """Lean of the body against its axles a m/s² of lateral acceleration, as measured, or as usual."""
    fy, lean = planes.columns["fy"], planes.columns.get("lean")
    power = float(np.sum((fy - fy.mean()) ** 2))
    if lean is None or power < LEAST_POWER * len(fy):
        return draws.normal(*LEAN_GAIN)
    slope = float(np.sum((fy - fy.mean()) * lean)) / power
    return draws.normal(slope, 0.1 * abs(slope))


def _answers(
    found: RollFit, masses: Masses, draws: Draws, errors: SensorErrors, vehicle: Vehicle, least_lateral: float
) -> dict[str, ParameterEstimate]:
    body = _body(found, masses, draws, errors, vehicle)
    roll, planes = found.roll, found.planes
    spread = float(np.std(planes.columns["fy"]))
    told = float(roll.told[roll.names.index("roll_acc")])
    load_moment = found.load.value("mass") * GRAVITY * tracks(vehicle)[0] / 2
    quiet = float(np.std(roll.residual)) < QUIET_SHARE * load_moment
    bad = unlike(roll) if roll.explained < LEAST_EXPLAINED else None
    lateral = bad
    if spread < least_lateral:
        lateral = f"the lateral acceleration changes by {spread:.2f} m/s² (standard deviation): cornering of {least_lateral:g} m/s² is needed"
    inertia = bad
    if inertia is None and told < LEAST_TOLD:
        inertia = (
            f"of the roll acceleration, beside what goes with the lateral acceleration, {100 * (1 - told):.0f} % is noise: quick "
            "steering or a rough road would tell the inertia"
        )
    words = "of the whole vehicle about its CG; from the struts' roll moment against the roll acceleration, wheels added"
    links = "sprung CG above the roll axis: strut forces do not see what goes through the roll centres"
    prior = inertia_prior("roll_inertia_kgm2", vehicle)
    track = tracks(vehicle)[0]
    said = {
        "roll_inertia_kgm2": (body.whole_inertia, Said(0.08, 0.3, words, inertia, low=0.0, prior=prior)),
        "roll_arm_m": (body.arm, Said(0.06, 0.2, links, lateral, low=0.02, high=3.0)),
        "sprung_mass_kg": (masses.sprung, Said(0.02, 0.06, "what the struts carry over the drive", low=0.0)),
        "cg_lateral_offset_m": (
            body.left,
            Said(0.006, 0.02, "from the struts' mean roll moment with lateral acceleration taken out", None if quiet else bad, scale=track, low=-track / 2, high=track / 2),
        ),
    }  # fmt: skip
    return {n: answer(n, values, how, vehicle, "roll_plane") for n, (values, how) in said.items()}
