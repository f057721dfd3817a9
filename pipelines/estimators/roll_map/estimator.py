"""Roll dynamics by batch maximum a posteriori, on the model of Berntorp et al.

First stage: the coefficients a = K/(m h), b = D/(m h), c = I/(m h) + h - z of the roll motion, with offsets, delays
and noises as parameters, from the likelihood of the Kalman innovations. Second stage: the vehicle, by weighted draws
from what is known of it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from parsers.drive import Drive
from parsers.signals import SUSPENSION_DEFLECTIONS
from pipelines.estimators.base import Need, Setting, Settings
from pipelines.estimators.roll_map.answers import coefficients_of
from pipelines.estimators.roll_map.choose import Asked, fit_best
from pipelines.estimators.roll_map.data import RollData, collect
from pipelines.estimators.roll_map.evidence import Motion, evidence_of
from pipelines.estimators.roll_map.figures import fit_traces, gradient_track, height_track, roll_scatter
from pipelines.estimators.roll_map.fit import RollFit
from pipelines.estimators.roll_map.instead import GRADIENT, beside_horizon, tells
from pipelines.estimators.roll_map.model import OPTIONS, Known, known_parameters
from pipelines.estimators.roll_map.motion import friction_damping
from pipelines.estimators.roll_map.stiffer_outside import of_free_springs
from pipelines.estimators.roll_map.vehicle import VehiclePart, before_the_log, explain_vehicle, usable
from pipelines.estimators.roll_map.words import (
    assumptions_of_fit,
    conflicts,
    like_tilting_ground,
    model_parts,
    not_following,
    said_of_drive,
    with_what_looks_wrong,
)
from pipelines.estimators.roll_map.yaw import yaw_lever
from pipelines.models.roll import DEGREES
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.roll_angle import RollSource, rank_roll
from pipelines.prepare.roll_rate import off_pitch
from pipelines.prepare.signals import prepare_signals
from pipelines.results import Estimate, FloatArray, Scatter, Track
from pipelines.vehicles.vehicle import Vehicle

DEFLECTION_PAIRS = (SUSPENSION_DEFLECTIONS[:2], SUSPENSION_DEFLECTIONS[2:])
TRACK_POINTS = 120
LEAST_EXPLAINED = 0.2
"""Share of the roll signal's variance that must follow from the lateral acceleration."""

LEAST_STIFFNESS = 2 * 9.80665
"""a = K/(m h) in (m/s²)/rad below which the answer is refused: tilting ground gives a = g whatever the springs are, and
a sprung vehicle with less than twice that leans over 28 degrees a g, which none does (lorries reach about 10)."""

SETTINGS: tuple[Setting, ...] = (
    Setting(
        "cutoff_hz",
        8.0,
        "Hz",
        "zero-phase low-pass of all signals; they are then taken at twice this rate",
        2.0,
        40.0,
    ),
    Setting(
        "least_excitation",
        0.3,
        "m/s²",
        "lateral acceleration (RMS over 6 s) from which a stretch is used",
        0.0,
        5.0,
    ),
    Setting(
        "least_spread",
        0.3,
        "m/s²",
        "spread of lateral acceleration below which nothing is estimated",
        0.0,
        5.0,
    ),
    Setting(
        "max_delay_s",
        0.2,
        "s",
        "largest delay of the roll channel, beyond what a roll rate shows of it",
        0.0,
        1.0,
    ),
    Setting("delay_std_s", 0.05, "s", "how large a delay of the roll channel is usual", 0.001, 1.0),
    Setting(
        "max_rows",
        40000,
        "samples",
        "most samples that are fitted; the liveliest stretches are taken",
        1000,
        1e6,
    ),
    Setting("draws", 100000, "draws", "draws of the vehicle in the second stage", 1000, 2e6),
)


def _value(settings: Settings, name: str) -> float:
    default = next(s.default for s in SETTINGS if s.name == name)
    return float(settings.get(name, default))


class RollMap:
    """The estimator "roll_map"."""

    name: str = "roll_map"
    title: str = "Roll dynamics, batch maximum a posteriori"

    source: str = (
        "Berntorp, Chakrabarty, Di Cairano: Vehicle center-of-gravity height and dynamics estimation with uncertainty "
        "quantification by marginalized particle filter, eqs. (1)-(4); offline, by the Kalman innovations' likelihood"
    )

    @property
    def signal_needs(self) -> tuple[Need, ...]:
        """Lateral acceleration and something that sees roll."""
        angle = ("roll", "roll_rate", "suspension_deflection_fl", "suspension_deflection_rl")
        return (
            Need(("accel_y",), "lateral acceleration is what makes the body roll"),
            Need(angle, "the roll motion: an angle, a rate, or deflections of both wheels of an axle"),
        )

    vehicle_needs: tuple[Need, ...] = ()
    parameters: tuple[str, ...] = (
        "cg_height_m", "sprung_cg_height_m", "roll_arm_m", "roll_gradient_degpg", "roll_natural_frequency_hz",
        "roll_damping_ratio", "roll_stiffness_nmprad", "roll_damping_nmsprad", "roll_inertia_kgm2", "mass_kg",
        "sprung_mass_kg",
    )  # fmt: skip

    settings: tuple[Setting, ...] = SETTINGS

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Lateral acceleration and the best roll channel on one clock; the other roll channels where they are there."""
        signals = drive.signals
        pairs = [name for pair in DEFLECTION_PAIRS if all(w in signals for w in pair) for name in pair]
        if "roll" in signals:
            angle: list[str] = ["roll"]
        elif pairs:
            angle = pairs
        else:
            angle = ["roll_rate"]
        # beside deflections, forces show where a stop begins
        forces = [name.replace("deflection", "force") for name in pairs]
        optional = ["roll_rate", "yaw_rate", "speed", "accel_x", *pairs, *forces]
        cutoff = _value(settings, "cutoff_hz")
        # twice as dense as the likelihood takes them: it makes the low-pass good and thins them itself
        first = prepare_signals(
            drive, ["accel_y", *angle], rate_hz=4 * cutoff, cutoff_hz=cutoff, optional=optional
        )
        if first.cutoff_hz >= cutoff or not first.segments:
            return first
        cutoff = first.cutoff_hz
        again = prepare_signals(
            drive, ["accel_y", *angle], rate_hz=4 * cutoff, cutoff_hz=cutoff, optional=optional
        )
        return replace(again, notes=tuple(dict.fromkeys((*first.notes, *again.notes))))

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Fit and explain. A drive that cannot tell ends with parameters "not_identifiable" and the reason.

        A road that banks takes an angle against the horizon its answer, and none that springs show: then theirs is told. What the
        first says of the vehicle, bank and all, stays with it.
        """
        prepared = off_pitch(prepared, vehicle)
        ranked = rank_roll(prepared, vehicle) if prepared.segments else ()
        first = self._by(ranked, prepared, vehicle, settings, rng)
        if tells(first) or not beside_horizon(ranked, prepared):
            return first
        second = self._by(ranked[1:], prepared, vehicle, settings, rng)
        if not tells(second):
            return first
        instead = f"what is told and shown here is by the springs' angle, since by the one against the horizon {first.parameters[GRADIENT].reason}"
        return replace(
            second, evidence=first.evidence or second.evidence, reason=f"{second.reason}; {instead}"
        )

    def _by(
        self,
        ranked: tuple[RollSource, ...],
        prepared: Prepared,
        vehicle: Vehicle,
        settings: Settings,
        rng: np.random.Generator,
    ) -> Estimate:
        """With the first of some ways to a roll angle."""
        roll = ranked[0] if ranked else None
        data = None
        least = _value(settings, "least_excitation")
        if prepared.segments and (roll is not None or "roll_rate" in prepared.columns):
            data = collect(prepared, roll, least, round(_value(settings, "max_rows")))
        before = before_the_log(vehicle, rng, round(_value(settings, "draws")))
        spread = 0.0 if data is None else float(np.std(data.accel))
        seen = data is not None and (data.has_roll or data.has_rate)
        if data is None or not seen or spread < _value(settings, "least_spread"):
            return self._nothing(prepared, before, vehicle, spread, data)
        edges = np.unique(np.linspace(0, data.size, TRACK_POINTS + 1).round().astype(np.int64))[1:]

        def known(rows: RollData, parts: frozenset[str]) -> tuple[Known, ...]:
            return known_parameters(
                rows,
                self._rate_offset(prepared),
                _value(settings, "max_delay_s"),
                _value(settings, "delay_std_s"),
                yaw_lever(vehicle),
                parts,
            )

        def whole() -> RollData | None:
            return collect(prepared, roll, least, round(_value(settings, "max_rows")), wide=True)

        def liveliest(most: int) -> RollData | None:
            return collect(prepared, roll, least, most)

        data, fit = fit_best(data, whole, Asked(known, edges, liveliest))
        if fit.explained < LEAST_EXPLAINED:
            return self._nothing(prepared, before, vehicle, spread, data, not_following(data, fit, spread))
        if fit.values["a"] < LEAST_STIFFNESS:
            return self._nothing(prepared, before, vehicle, spread, data, like_tilting_ground(fit))
        return self._explain(prepared, data, fit, roll, ranked, vehicle, before, rng)

    @staticmethod
    def _rate_offset(prepared: Prepared) -> tuple[float, float] | None:
        """The roll rate's offset from standstill, with what it may drift by (0.1 deg/s)."""
        found = prepared.standstill_offset.get("roll_rate")
        return None if found is None else (found[0], math.hypot(found[1], math.radians(0.1)))

    def _nothing(
        self,
        prepared: Prepared,
        before: VehiclePart,
        vehicle: Vehicle,
        spread: float,
        data: RollData | None,
        why: str | None = None,
    ) -> Estimate:
        """The answer of a drive that cannot tell."""
        reason = why or said_of_drive(prepared, data, spread)
        parameters = before.unknown(self.parameters, reason, vehicle.reference)
        used = 0.0 if data is None else data.size / max(data.drive_rows, 1)
        figures = {"lateral_acceleration_spread_mps2": spread}
        return Estimate(
            self.name,
            "ran",
            reason,
            parameters,
            assumptions=before.assumptions,
            diagnostics=figures,
            used_fraction=used,
        )

    def _explain(
        self,
        prepared: Prepared,
        data: RollData,
        fit: RollFit,
        roll: RollSource | None,
        ranked: tuple[RollSource, ...],
        vehicle: Vehicle,
        before: VehiclePart,
        rng: np.random.Generator,
    ) -> Estimate:
        """Parameters, figures and words of a fit."""
        scale_std = 0.005 if roll is None or not data.has_roll else max(roll.scale_std, 0.003)
        coefficients = coefficients_of(fit, scale_std, data.against_axles)
        parameters, figures, sentences = explain_vehicle(before, coefficients, data, vehicle, rng)
        parameters = {
            **before.unknown(self.parameters, "see the roll gradient", vehicle.reference),
            **parameters,
        }
        seen_s = prepared.time_s[data.rows[fit.edges - 1]]
        odd = conflicts(data, fit)
        gradient = of_free_springs(parameters[GRADIENT], prepared, data.rows, vehicle)
        gradient = with_what_looks_wrong(gradient, odd)
        parameters[GRADIENT] = gradient
        tracks: list[Track] = [gradient_track(fit, seen_s, scale_std, data.against_axles, gradient.value)]
        if before.draws is not None and "cg_height_m" in parameters:
            few = before.fewer(6000)
            tracks.append(height_track(fit, seen_s, scale_std, few, before.rates, data.against_axles, rng))
        relative = math.sqrt(coefficients.covariance[0, 0]) / coefficients.mean[0]
        scatter = self._scatter(data, fit, ranked, relative, gradient.status != "not_identifiable")
        figures |= self._figures(data, fit)
        sentences = (*odd, *sentences, *filter(None, [model_parts(fit)]))
        reason = (
            " ".join(("the roll motion was fitted.", *sentences))
            if sentences
            else "the roll motion was fitted"
        )
        return Estimate(
            estimator=self.name,
            status="ran",
            reason=reason,
            parameters=parameters,
            tracks=tuple(tracks),
            traces=fit_traces(data, fit, prepared),
            scatters=() if scatter is None else (scatter,),
            assumptions=(*assumptions_of_fit(data, fit, roll, prepared), *before.assumptions),
            diagnostics=figures,
            used_fraction=data.size / max(data.drive_rows, 1),
            evidence=evidence_of(
                usable(before, coefficients, data.against_axles)[0],
                Motion(data.against_axles, data.banked_share, friction_damping(data, fit.values)),
                vehicle,
                self.name,
            ),
        )

    @staticmethod
    def _scatter(
        data: RollData, fit: RollFit, ranked: tuple[RollSource, ...], relative: float, told: bool
    ) -> Scatter | None:
        if not ranked:
            return None
        angle: FloatArray = ranked[0].angle[data.rows]
        return roll_scatter(data, fit, angle, ranked[0].how, relative, not data.has_roll, told)

    @staticmethod
    def _figures(data: RollData, fit: RollFit) -> dict[str, float]:
        i = fit.index("a")
        found = {
            "log_likelihood": -fit.cost,
            "explained_share": fit.explained,
            "quickness_radps": fit.quickness,
            "samples": float(data.size),
            "band_hz": data.band_hz,
            "whole_band": float(fit.whole_band),
            "scoring_steps": float(fit.steps),
            "converged": float(fit.converged),
            "correlation_factor_a": float(fit.covariance[i, i] / fit.white_covariance[i, i]),
            "roll_delay_s": fit.values["delay"],
            "roll_delay_std_s": fit.std("delay"),
            "frequency_at_sensor_hz": math.sqrt(fit.values["a"] / fit.values["c"]) / (2 * math.pi),
            **{name: fit.values[name] for name in ("a", "b", "c", *OPTIONS) if name in fit.values},
            **{f"{name}_std": fit.std(name) for name in ("a", "b", "c", *OPTIONS) if name in fit.values},
        }
        mean, covariance = fit.told
        for place, name in enumerate(("a", "b", "c")):
            found[f"{name}_of_models"] = float(mean[place])
            found[f"{name}_of_models_std"] = math.sqrt(covariance[place, place])
        if fit.verdict is not None:
            found["held_out_stretches"] = float(fit.verdict.stretches)
            found["weight_of_all_parts"] = fit.verdict.full_weight
            for name, gain in fit.verdict.gains.items():
                found[f"held_out_gain_{name}"] = gain.total
                found[f"held_out_t_{name}"] = float(np.clip(gain.t, -1e3, 1e3))
                found[f"supported_{name}"] = float(name in fit.verdict.supported)
        for name, scale in (
            ("roll_offset", DEGREES),
            ("rate_offset", DEGREES),
            ("rate_lag", 1.0),
            ("yaw_leak", 1.0),
            ("lever", 1.0),
        ):
            if name in fit.values:
                unit = {
                    "roll_offset": "deg",
                    "rate_offset": "degps",
                    "rate_lag": "s",
                    "yaw_leak": "share",
                    "lever": "m",
                }[name]
                found[f"{name}_{unit}"] = fit.values[name] * scale
        for name in ("log_roll_noise", "log_rate_noise", "log_push", "log_bank"):
            if name in fit.values:
                found[name.removeprefix("log_") + "_std"] = math.exp(fit.values[name])
        for column, name in enumerate(
            (["roll"] if data.has_roll else []) + (["rate"] if data.has_rate else [])
        ):
            e = fit.normalised[:, column]
            good = np.isfinite(e[1:]) & np.isfinite(e[:-1])
            if good.sum() > 2:
                found[f"{name}_innovation_autocorrelation"] = float(
                    np.corrcoef(e[1:][good], e[:-1][good])[0, 1]
                )
        return found
