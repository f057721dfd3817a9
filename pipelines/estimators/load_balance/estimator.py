"""Mass, CG position and height from the balance of vertical forces, pitch, roll and longitudinal motion.

One joint maximum a posteriori over every balance that the log supports, with the vehicle file's figures, the load,
the sensors' errors and the model's own errors as unknowns.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.load_balance.along import along_relation, pads_relation
from pipelines.estimators.load_balance.answers import answers, behind_the_axles, unanswered
from pipelines.estimators.load_balance.attitude import attitude_relation
from pipelines.estimators.load_balance.by_springs import by_both
from pipelines.estimators.load_balance.data import Columns, collect, speed_of
from pipelines.estimators.load_balance.evidence import evidence_of
from pipelines.estimators.load_balance.figures import traces, tracks
from pipelines.estimators.load_balance.one_road import road_evidence
from pipelines.estimators.load_balance.relations import relations
from pipelines.estimators.load_balance.solve import Fit, solve
from pipelines.joint.doubts.listed import said
from pipelines.joint.information import Spread, prior_spreads
from pipelines.joint.vehicle.stated import stated_relations
from pipelines.joint.vehicle.unknowns import Known, before_the_log
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.signals import prepare_signals
from pipelines.results import Assumption, Estimate, ParameterEstimate
from pipelines.vehicles.kinds import kind_of
from pipelines.vehicles.kinematics import free_travel
from pipelines.vehicles.vehicle import Vehicle

SOURCES: tuple[tuple[str, ...], ...] = (
    tuple(f"suspension_deflection_{w}" for w in WHEELS),
    tuple(f"suspension_force_{w}" for w in WHEELS),
    tuple(f"tire_normal_force_{w}" for w in WHEELS),
    ("axle_load_front", "axle_load_rear"),
)
TORQUES = ("brake_torque", "drive_torque", "brake_pressure")
OPTIONAL = (
    "accel_y", "accel_z", "pitch", "roll_rate", "pitch_rate", "yaw_rate", "speed", "gps_speed_2d", "brake_pressure",
    "brake_torque", "drive_torque",
    *(f"{kind}_{w}" for kind in ("wheel_speed", "brake_torque", "drive_torque") for w in WHEELS),
)  # fmt: skip

SETTINGS: tuple[Setting, ...] = (
    Setting("full_band_hz", 15.0, "Hz", "zero-phase low-pass before squares and damper halves are formed", 2.0, 40.0),
    Setting("band_hz", 2.0, "Hz", "zero-phase low-pass of every term of the balances", 0.3, 10.0),
    Setting("least_spread", 0.15, "m/s²", "spread of longitudinal or lateral acceleration below which no height is given",
            0.0, 5.0),
)  # fmt: skip

CONTRADICTED = 2.0
"""Factor on all intervals beyond which nothing is said: right signals gave 1.0 to 1.3, a dead deflection sensor or turned
signs 2 and more."""

CONTRADICTION = (
    "the balances contradict each other or the vehicle file: check the signals' signs, units and mounting, and the vehicle "
    "file's masses, springs and lengths"
)
HEAVY_KG = 3700.0
MASSES = ("mass_kg", "sprung_mass_kg")
HEIGHTS = ("cg_height_m", "sprung_cg_height_m", "roll_arm_m")
HEAVY = (
    "deflections do not tell it of a vehicle of this weight: the dry friction and progressive springs of such axles are as large "
    "as what load transfer moves (axle or tyre loads would tell it)"
)
"""Empty mass beyond which spring deflections are not taken for forces in load transfer, and what is said then."""

UNSEEN = (
    "it needs suspension deflections with spring_rate_front_npm and spring_rate_rear_npm, or suspension, tyre or axle forces; "
    "for the height the pitch rate with these rates and torques will do"
)


def _value(settings: Settings, name: str) -> float:
    default = next(s.default for s in SETTINGS if s.name == name)
    return float(settings.get(name, default))


class LoadBalance:
    """The estimator "load_balance"."""

    name: str = "load_balance"
    title: str = "Force and moment balances of the whole drive"

    source: str = (
        "Newton's and Euler's equations of the body on its suspension (vertical, pitch, roll, longitudinal), jointly with "
        "the vehicle's unknowns: maximum a posteriori on instruments"
    )

    @property
    def signal_needs(self) -> tuple[Need, ...]:
        """Something that carries the vehicle, or torques with the acceleration that they make."""
        carried = (*(names[0] for names in SOURCES), "suspension_deflection_rl")
        torque = (*TORQUES, *(f"{kind}_{w}" for kind in ("brake_torque", "drive_torque") for w in WHEELS))
        return (
            Need((*carried, *torque), "forces that carry, drive or brake the vehicle"),
            Need(("accel_x", "accel_y", *carried), "the accelerations that these forces make"),
        )

    vehicle_needs: tuple[Need, ...] = (Need(("wheelbase_m",), "the lever of pitch"),)
    parameters: tuple[str, ...] = (
        "mass_kg", "sprung_mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "cg_height_m", "sprung_cg_height_m",
        "roll_arm_m", "roll_stiffness_nmprad", *(f"corner_mass_{w}_kg" for w in WHEELS),
    )  # fmt: skip

    settings: tuple[Setting, ...] = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """The accelerations and the first complete set of vertical forces (else torques) on one clock; the rest as there."""
        signals = drive.signals
        first: tuple[str, ...] = next((names for names in SOURCES if all(n in signals for n in names)), ())
        wanted = [*first]
        if "accel_x" in signals:
            wanted.insert(0, "accel_x")
        if not first:
            torque = next((n for n in (*TORQUES, *OPTIONAL[-8:]) if n in signals), None)
            wanted += [] if torque is None else [torque]
        others = [n for names in SOURCES for n in names if n not in wanted]
        optional = [*others, *(n for n in OPTIONAL if n not in wanted)]
        band = _value(settings, "full_band_hz")
        return prepare_signals(drive, wanted, rate_hz=None, cutoff_hz=band, optional=optional)

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Fit all balances at once. A drive that cannot tell ends with parameters "not_identifiable" and the reason."""
        known = before_the_log(vehicle)
        priors = prior_spreads(known, stated_relations(vehicle), rng)
        if not prepared.segments:
            return self._nothing(
                known, priors, vehicle, "; ".join(prepared.notes) or "no usable stretch of the drive"
            )
        data = collect(
            prepared, known, min(_value(settings, "band_hz"), prepared.cutoff_hz),
            zero_loaded=vehicle.deflection_zero == "loaded", free_m=free_travel(vehicle),
            vehicle_kind=kind_of(vehicle),
        )  # fmt: skip
        along = along_relation(data, known)
        empty = vehicle.get("mass_kg")
        heavy = empty is not None and empty.value > HEAVY_KG and kind_of(vehicle) == "heavy"
        # on axles whose dry friction is as large, the body's nodding tells the load transfer no better than deflections do
        nod = None if heavy else attitude_relation(data, known)
        found = relations(data, known) + tuple(
            r for r in (nod, along, None if along is None else pads_relation(data, known)) if r is not None
        )
        if not found:
            return self._nothing(known, priors, vehicle, self._lacks(data, known))
        fit = solve(found, known)
        told = (*evidence_of(fit, data, heavy=heavy), *road_evidence(prepared, speed_of(prepared), known))
        # torques alone hardly tell a wheel that takes none from a per cent of mass
        first, *others = by_both(found, fit, vehicle, doubted=bool(data.kinds or data.one_axle))
        _, likelier, doubts = first
        parameters = answers(likelier, data, vehicle, priors, doubts, others)
        if not data.kinds and not data.one_axle:
            # torques tell the mass, the nose's motion the height; what they seem to tell of the place is the load's prior alone
            seen = MASSES if nod is None else (*MASSES, *HEIGHTS)
            parameters = {n: p for n, p in parameters.items() if n in seen}
        if fit.inflation > CONTRADICTED:
            reason = f"{CONTRADICTION} (misfit {fit.inflation:.1f} times what is usual)"
            return replace(
                self._nothing(known, priors, vehicle, reason),
                traces=traces(fit, data),
                diagnostics=self._figures(fit, data),
                evidence=told,
            )
        rest: dict[str, ParameterEstimate] = {}
        if "tyre" in data.kinds or "axle" in data.kinds:
            parameters = behind_the_axles(parameters, vehicle)
        if heavy:
            lost = HEIGHTS if data.kinds == ("deflection",) else ("roll_arm_m",)
            parameters = {n: p for n, p in parameters.items() if n not in lost}
            rest = dict(unanswered(known, lost, HEAVY, priors, vehicle.reference))
        left = tuple(n for n in self.parameters if n not in parameters and n not in rest)
        rest |= unanswered(known, left, UNSEEN, priors, vehicle.reference)
        used = max(len(r.relation.rows) for r in fit.reduced) / max(len(data.time_s), 1)
        return Estimate(
            self.name, "ran", self._reason(fit, known, said(doubts)), {**parameters, **rest},
            tracks=tracks(fit, data), traces=traces(fit, data),
            assumptions=(*known.assumptions, *self._travel(prepared, data), self._filter(prepared, settings)),
            diagnostics=self._figures(fit, data), used_fraction=used,
            evidence=told,
        )  # fmt: skip

    def _nothing(self, known: Known, priors: Mapping[str, Spread], vehicle: Vehicle, reason: str) -> Estimate:
        return Estimate(
            self.name, "ran", reason, unanswered(known, self.parameters, reason, priors, vehicle.reference),
            assumptions=known.assumptions,
        )  # fmt: skip

    @staticmethod
    def _travel(prepared: Prepared, data: Columns) -> tuple[Assumption, ...]:
        if "deflection" not in data.kinds and not data.one_axle:
            return ()
        checked = "roll_rate" in prepared.columns and "deflection" in data.kinds
        how = (
            "the roll rate beside them checks it"
            if checked
            else "nothing in this log checks it; a roll rate would"
        )
        return (Assumption("travel that the deflections show", "the wheels', at 1 : 1", how),)

    @staticmethod
    def _lacks(data: Columns, known: Known) -> str:
        if data.kinds == ("deflection",) and not known.springs:
            return (
                "suspension deflections tell forces only with spring_rate_front_npm and spring_rate_rear_npm"
            )
        return (
            "no balance can be made: forces and the accelerations they make are not there together for 20 s"
        )

    @staticmethod
    def _reason(fit: Fit, known: Known, otherwise: tuple[str, ...]) -> str:
        words = "balances used: " + ", ".join(r.relation.title for r in fit.reduced)
        if fit.inflation > 1.05:
            words += f"; they contradict each other or the vehicle file: all intervals are widened {fit.inflation:.1f} times"
        u = dict(zip(known.names, fit.u.tolist(), strict=True))
        far = [n for n, x in u.items() if abs(x) > 2.5]
        if far:
            words += "; far from what was expected: " + ", ".join(
                f"{n.replace('_', ' ')} ({u[n]:+.1f} standard deviations)" for n in far
            )
        if otherwise:
            words += "; the drive speaks for: " + ", ".join(otherwise)
        return words

    @staticmethod
    def _filter(prepared: Prepared, settings: Settings) -> Assumption:
        text = f"zero-phase low-pass at {prepared.cutoff_hz:.3g} Hz, all terms at {_value(settings, 'band_hz'):.3g} Hz"
        return Assumption("filter", text, "settings")

    @staticmethod
    def _figures(fit: Fit, data: Columns) -> dict[str, float]:
        values = fit.values()
        found = {"inflation": fit.inflation, "rest_s": data.rest_s, "sag_m": data.sag or 0.0}
        for r in fit.reduced:
            key = r.relation.name.replace(" ", "_")
            found[f"{key}_residual_std"] = float(np.std(r.residual))
            found[f"{key}_chi2"] = r.chi2
            found[f"{key}_correlation_rows"] = r.correlation_rows
        names = ("load", "load_x", "load_y", "load_h", "spring_front", "spring_rear", "pitch_center_brake",
                 "pitch_center_drive", "pitch_path", "roll_center_front", "roll_center_rear", "askew_pitch",
                 "askew_roll", "drive_scale", "brake_scale", "brake_gain", "drag")  # fmt: skip
        return found | {n: values[n] for n in names}
