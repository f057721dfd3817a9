"""CG height and mass from braking and roll over a whole drive, in one batch: the companion of Park & Choi's observer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from parsers.drive import Drive
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.brake_roll.answers import Found, answer
from pipelines.estimators.brake_roll.data import BrakeRollData, collect_data, prepare_drive
from pipelines.estimators.brake_roll.evidence import bends_share, evidence
from pipelines.estimators.brake_roll.figures import batch_figures, batch_scatters, batch_traces
from pipelines.estimators.brake_roll.parts import lateral_part, mass_part, slip_part
from pipelines.estimators.brake_roll.vehicle import BrakeRollVehicle, known_of
from pipelines.estimators.roll_map.vehicle import VehiclePart, before_the_log
from pipelines.prepare.prepared import Prepared
from pipelines.results import Assumption, Estimate
from pipelines.vehicles.vehicle import Vehicle

OVERSAMPLED = 8
NAMES = ("cg_height_m", "mass_kg", "roll_gradient_degpg", "roll_stiffness_nmprad")

SETTINGS: tuple[Setting, ...] = (
    Setting("cutoff_hz", 5.0, "Hz", "zero-phase low-pass of all signals", 1.0, 20.0),
    Setting("slip_bend", 0.25, "-", "b of the slip curve: 0 = straight, as the paper takes it", -0.5, 2.0),
    Setting("slip_bend_std", 0.2, "-", "its standard deviation", 1e-6, 1.0),
    Setting("slip_load", 0.1, "-", "p: share by which slip stiffness over load falls per relative load", -1.0, 1.0),
    Setting("slip_load_std", 0.2, "-", "its standard deviation: front and rear tyres are alike as well as this says", 1e-6, 1.0),
    Setting("squash", 0.25, "-", "share of a tyre's deflection by which its rolling radius falls", -1.0, 1.0),
    Setting("squash_std", 0.12, "-", "its standard deviation", 1e-6, 1.0),
    Setting("drive_torque_std", 0.05, "-", "relative standard deviation of the drive torque's scale", 1e-4, 0.5),
    Setting("scale_std", 0.005, "-", "relative error between accelerometer and yaw rate times speed", 1e-6, 0.1),
    Setting("draws", 60000, "draws", "draws of the vehicle that carry what is known of it", 1000, 1e6),
)  # fmt: skip


def value_of(settings: Settings, name: str) -> float:
    """A setting or its default."""
    default = next(s.default for s in SETTINGS if s.name == name)
    return float(settings.get(name, default))


class BrakeRollBatch:
    """The estimator "brake_roll_batch"."""

    name = "brake_roll_batch"
    title = "Braking and roll, joint batch"
    source = (
        "companion of Park, Choi: An Integrated Observer for Real-Time Estimation of Vehicle Center of Gravity Height, "
        "eqs. (1)-(10), (21), (37): least squares over the drive with the sensors' errors as parameters; mass by the "
        "longitudinal balance"
    )
    signal_needs = (
        Need(("accel_y", "accel_x"), "lateral acceleration for roll, or longitudinal acceleration for braking"),
        Need(("roll_rate", "brake_pressure", "brake_torque", "brake_torque_fl", "drive_torque"),
             "the roll motion, or the torques of brakes and engine"),
    )  # fmt: skip
    vehicle_needs = (Need(("mass_kg",), "the empty vehicle's mass: what braking and roll move"),)
    parameters = NAMES
    settings = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Motion, wheel speeds, brakes and speed at eight times the low-pass."""
        cutoff = value_of(settings, "cutoff_hz")
        first = prepare_drive(drive, OVERSAMPLED * cutoff, cutoff)
        if first.cutoff_hz >= cutoff or not first.segments:
            return first
        return replace(
            prepare_drive(drive, OVERSAMPLED * first.cutoff_hz, first.cutoff_hz), notes=first.notes
        )

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Fit the parts that the drive allows and join them with what is known of the vehicle."""
        before = before_the_log(vehicle, rng, round(value_of(settings, "draws")))
        known = known_of(vehicle)
        if known is None or not prepared.segments:
            why = (
                "the vehicle's mass is not known: give mass_kg in a vehicle file"
                if known is None
                else "; ".join(prepared.notes) or "no stretch holds the signals without a gap"
            )
            return self._nothing(why, before, vehicle, known)
        data = collect_data(prepared, known)
        slip, why_slip = slip_part(prepared, data, known, settings, before, vehicle)
        lateral, why_lateral = lateral_part(prepared, data, known, vehicle, settings)
        mass, why_mass = mass_part(data, known, settings, vehicle)
        bends = bends_share(lateral, data) if lateral is not None else 1.0
        found = Found(slip, lateral, mass, why_slip, why_lateral, why_mass, bends)
        if slip is None and lateral is None and mass is None:
            reason = "; ".join(dict.fromkeys((why_slip, why_lateral, why_mass)))
            return self._nothing(reason, before, vehicle, known)
        parameters, reason = answer(found, before, known, vehicle, rng)
        return Estimate(
            self.name, "ran", reason, parameters,
            traces=batch_traces(prepared.time_s, data, found),
            scatters=batch_scatters(found, known),
            assumptions=_assumptions(data, known, settings),
            diagnostics=batch_figures(data, found),
            used_fraction=_used(data, found),
            evidence=evidence(found, data, known, value_of(settings, "drive_torque_std"), vehicle),
        )  # fmt: skip

    def _nothing(
        self, reason: str, before: VehiclePart, vehicle: Vehicle, known: BrakeRollVehicle | None
    ) -> Estimate:
        """The answer of a drive that cannot tell."""
        answers = before.unknown(NAMES, reason, vehicle.reference)
        given = () if known is None else known.assumptions
        return Estimate(self.name, "ran", reason, answers, assumptions=given)


def _used(data: BrakeRollData, found: Found) -> float:
    """Share of the drive in any of the fits."""
    used = np.zeros(len(data.time_s), dtype=bool)
    if found.lateral is not None:
        used |= found.lateral.used & (np.abs(data.f_y if data.f_y is not None else 0.0) > 0.3)
    if found.slip is not None and data.f_x is not None:
        used |= data.rows & (data.f_x < -0.7)
    if found.mass is not None:
        used |= data.rows & (data.f_x is not None)
    return float(np.mean(used)) if len(used) else 0.0


def _assumptions(data: BrakeRollData, known: BrakeRollVehicle, settings: Settings) -> tuple[Assumption, ...]:
    """What was taken as given."""
    true = data.true
    found = list(known.assumptions)
    found.append(
        Assumption(
            "tyres' slip curve",
            f"bend {value_of(settings, 'slip_bend'):g} ± {value_of(settings, 'slip_bend_std'):g}, load "
            f"{value_of(settings, 'slip_load'):g} ± {value_of(settings, 'slip_load_std'):g}; front and rear alike",
            "settings of brake_roll_batch",
        )
    )
    if true is not None:
        words = f"{true.name}, {1000 * true.delay_s:.0f} ms late" if true.told else true.name
        found.append(Assumption("true speed", words, "aligned with accel_x" if true.told else "as it is"))
    found.extend(Assumption("data", note, "prepared drive") for note in data.notes)
    return tuple(found)
