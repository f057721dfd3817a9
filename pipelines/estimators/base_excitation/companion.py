"""Sprung mass by base excitation over the whole drive at once: the companion of the published method.

Four corners: heave of the rigid body, errors in all accelerometers allowed for (batch_heave.py).
Fewer: each corner by output error with both damper slopes, the residual whitened, gain and delay of the accelerometers as
nuisance parameters (batch_corner.py); both wheels of an axle as one, in which the anti-roll bar cancels.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pipelines.estimators.base import Setting, Settings
from pipelines.estimators.base_excitation.answers import (
    CORNER_MASSES,
    SPLIT_SHARE,
    answer,
    body_answers,
    corner_answer,
    figure,
    nothing,
)
from pipelines.estimators.base_excitation.batch_corner import CornerFit, Nuisance, fit_corner
from pipelines.estimators.base_excitation.batch_figures import (
    corner_trace,
    corner_track,
    heave_trace,
    heave_track,
)
from pipelines.estimators.base_excitation.batch_heave import NAMES, HeaveFit, fit_heave
from pipelines.estimators.base_excitation.batch_parts import (
    figures_of,
    groups,
    joined,
    not_rough,
    sticking,
    why_not,
)
from pipelines.estimators.base_excitation.batch_whole import (
    MODEL_ERROR,
    SQRT_12,
    body_of,
    mean_damping,
    refused,
    rougher,
)
from pipelines.estimators.base_excitation.data import (
    AXLES,
    RideData,
    collect_ride,
    spring_assumptions,
)
from pipelines.estimators.base_excitation.evidence import CornerSeen, corner_evidence, heave_evidence
from pipelines.estimators.base_excitation.method import RideMethod
from pipelines.prepare.prepared import Prepared
from pipelines.results import Assumption, Estimate, ParameterEstimate, Track
from pipelines.vehicles.vehicle import Vehicle

SETTINGS: tuple[Setting, ...] = (
    Setting("cutoff_hz", 50.0, "Hz", "zero-phase low-pass of all signals", 10.0, 500.0),
    Setting("band_low_hz", 0.4, "Hz", "lowest frequency that is fitted", 0.3, 2.0),
    Setting("band_high_hz", 25.0, "Hz", "highest frequency that is fitted on single corners", 5.0, 100.0),
    Setting("heave_high_hz", 3.0, "Hz", "the same for heave: above it guides and tyres have their say", 2.0, 100.0),
    Setting("block_s", 10.0, "s", "length of the blocks that the drive is cut into", 4.0, 60.0),
    Setting(
        "least_excitation",
        1.5,
        "m/s²",
        "hub acceleration (RMS over 4 s) from which a block is used",
        0.0,
        10.0,
    ),
    Setting(
        "gain_std",
        0.005,
        "share",
        "how far the accelerometers' scales may differ from one another",
        0.0,
        0.1,
    ),
    Setting("delay_std_s", 0.005, "s", "how late one kind of accelerometer may come against the other", 0.0, 0.1),
    Setting("friction_std_n", 100.0, "N", "how large a wheel's suspension friction is usual", 0.0, 2000.0),
    Setting(
        "coupling",
        0.15,
        "share",
        "what inertia and anti-roll bars may do to a wheel's apparent mass where not all four are seen (two thirds of it for a "
        "whole axle); 0 on a bench",
        0.0,
        1.0,
    ),
)  # fmt: skip
BENCH_ERROR = 0.002
DAMPING_ERROR = 0.05
"""What inertia and links leave of a mass on a bench, and of a damping, as shares."""


class BaseExcitationBatch(RideMethod):
    """The estimator "base_excitation_batch"."""

    name: str = "base_excitation_batch"
    title: str = "Base excitation, whole drive at once"

    source: str = (
        "model of Pence, Fathy, Stein, eqs. (1)-(2), with two damper slopes; output error on a corner, compensated least "
        "squares on the heave of four, both in a frequency band with the residual's own spectrum as weight"
    )
    parameters: tuple[str, ...] = (
        "sprung_mass_kg", "mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", *CORNER_MASSES,
        "suspension_damping_nspm",
    )  # fmt: skip

    settings: tuple[Setting, ...] = SETTINGS

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Estimate. A drive that cannot tell ends with parameters "not_identifiable" and the reason."""

        def value(name: str) -> float:
            return self.value(settings, name)

        data = collect_ride(prepared, vehicle, value("least_excitation"))
        if data.why_not:
            return self._nothing(data, vehicle, data.why_not)
        nuisance = Nuisance(value("gain_std"), value("delay_std_s"), value("friction_std_n"))
        band = (value("band_low_hz"), min(value("band_high_hz"), 0.6 * prepared.cutoff_hz))
        block_s = value("block_s")
        if len(data.corners) == 4:
            low = (band[0], min(value("heave_high_hz"), band[1]))
            heave = fit_heave(data, nuisance, block_s=block_s, band_hz=low)
            return self._whole(prepared, data, vehicle, heave, nuisance)
        return self._parts(prepared, data, vehicle, nuisance, block_s, band, value("coupling"))

    def _nothing(
        self, data: RideData, vehicle: Vehicle, reason: str, figures: Mapping[str, float] | None = None
    ) -> Estimate:
        found = nothing(self.parameters, vehicle, reason)
        figures = {"hub_rms_mps2": data.hub_rms, **(figures or {})}
        return Estimate(
            self.name, "ran", reason, found, assumptions=spring_assumptions(data), diagnostics=figures
        )

    def _whole(
        self,
        prepared: Prepared,
        data: RideData,
        vehicle: Vehicle,
        fit: HeaveFit | None,
        nuisance: Nuisance,
    ) -> Estimate:
        """Four corners."""
        if fit is None:
            return self._nothing(data, vehicle, "fewer than three blocks of lively motion without a gap")
        figures = {
            "explained_share": fit.explained,
            "clear_share": fit.clarity,
            "blocks": float(fit.blocks.count),
            "accelerometer_noise_mps2": fit.noise_mps2,
            "hub_rms_mps2": data.hub_rms,
            **{name: float(v) for name, v in zip(NAMES, fit.values, strict=True)},
        }
        why = refused(data, fit, vehicle)
        if why:
            return self._nothing(data, vehicle, why, figures)
        covariance = fit.covariance.copy()
        for number, pair in enumerate(AXLES.values()):
            quantity = data.springs[pair[0]]
            moved = fit.spring_slopes[number] * quantity.std / quantity.value
            covariance += np.outer(moved, moved)
        found, assumed = body_answers(body_of(fit, covariance, vehicle, data.hub_rms), vehicle, self.name)
        found["suspension_damping_nspm"] = mean_damping(fit, covariance, vehicle, self.name)
        spread = found["sprung_mass_kg"].std or math.inf
        return Estimate(
            estimator=self.name,
            status="ran",
            reason="the heave of four corners was fitted",
            parameters=found,
            tracks=heave_track(fit, prepared.time_s, found["sprung_mass_kg"].value or fit.sprung_kg, spread),
            traces=heave_trace(fit, prepared.time_s),
            assumptions=(*spring_assumptions(data), assumed, *self._assumed(nuisance)),
            diagnostics=figures,
            used_fraction=fit.blocks.count * fit.blocks.rows / max(len(prepared.time_s), 1),
            evidence=(heave_evidence(fit, data, vehicle),),
        )

    def _parts(
        self,
        prepared: Prepared,
        data: RideData,
        vehicle: Vehicle,
        nuisance: Nuisance,
        block_s: float,
        band: tuple[float, float],
        coupling: float,
    ) -> Estimate:
        """Fewer than four corners: what each one carries, as it seems; both wheels of an axle as one."""
        found = nothing(self.parameters, vehicle, "it needs body and hub accelerations at all four wheels")
        figures: dict[str, float] = {"hub_rms_mps2": data.hub_rms}
        assumptions = list(spring_assumptions(data))
        dampings: list[tuple[float, float]] = []
        best: tuple[str, CornerFit, float] | None = None
        seen: list[CornerSeen] = []
        reasons = []
        # without inertia and bars around it a corner is on a bench, whose ground and friction are its own
        bench = coupling == 0.0
        unlike = "" if bench else not_rough(data)
        if unlike:
            return self._nothing(data, vehicle, unlike, figures)
        model = 0.0 if bench else MODEL_ERROR * rougher(data.hub_rms)
        for wheels in groups(data.corners):
            corner = joined(data, wheels)
            fit = fit_corner(corner, nuisance, block_s=block_s, band_hz=band)
            sticks = 0.0 if bench else sticking(corner, nuisance.friction_std_n, band[0])
            why = why_not(fit, sticks)
            label = "+".join(wheels)
            if fit is None or why:
                reasons.append(f"{label}: {why}")
                continue
            chance = math.hypot(self._corner_chance(fit, wheels, coupling), model, sticks / SQRT_12)
            quantity = data.springs[wheels[0]]
            share = math.hypot(chance, quantity.std / quantity.value)
            # the fit's mass is that of the springs alone: the middle of what friction may add is taken
            mass = (1 + sticks / 2) * fit.mass_kg
            seen.append(CornerSeen(wheels, mass, chance * mass, quantity.value))
            for w in wheels:
                answered, assumed = self._corner(w, mass, fit, share, len(wheels), vehicle)
                found[answered.name] = answered
                assumptions.append(assumed)
            damping = float(fit.values[1] + fit.values[2]) / 2
            scatter = (
                math.sqrt(float(fit.covariance[1, 1] + fit.covariance[2, 2] + 2 * fit.covariance[1, 2])) / 2
            )
            dampings.append((damping, math.hypot(scatter, math.hypot(share, DAMPING_ERROR) * damping)))
            figures |= {**figures_of(fit, label), f"{label}_friction_stiffness_share": sticks}
            if best is None:
                best = (wheels[0], fit, share)
        if best is None:
            return self._nothing(data, vehicle, "; ".join(reasons) or "no wheel could be fitted")
        damping = sum(d for d, _ in dampings) / len(dampings)
        std = math.hypot(*(s for _, s in dampings)) / len(dampings)
        found["suspension_damping_nspm"] = answer(
            "suspension_damping_nspm", figure(damping, std), vehicle, self.name, "mean of both directions"
        )
        told = self._parts_told(prepared, found, figures, best, tuple(dict.fromkeys(assumptions)), nuisance)
        relation = corner_evidence(seen, SPLIT_SHARE)
        return replace(told, evidence=() if relation is None else (relation,))

    def _parts_told(
        self,
        prepared: Prepared,
        found: dict[str, ParameterEstimate],
        figures: dict[str, float],
        best: tuple[str, CornerFit, float],
        assumptions: tuple[Assumption, ...],
        nuisance: Nuisance,
    ) -> Estimate:
        wheel, fit, share = best
        name = f"corner_mass_{wheel}_kg"
        hub = (found[name].value or fit.mass_kg) - fit.mass_kg
        track: tuple[Track, ...] = corner_track(name, fit, prepared.time_s, hub, share)
        return Estimate(
            estimator=self.name,
            status="ran",
            reason="single corners were fitted",
            parameters=found,
            tracks=track,
            traces=corner_trace(fit, prepared.time_s),
            assumptions=(*assumptions, *self._assumed(nuisance)),
            diagnostics=figures,
            used_fraction=fit.blocks.count * fit.blocks.rows / max(len(prepared.time_s), 1),
        )

    @staticmethod
    def _corner_chance(fit: CornerFit, wheels: tuple[str, ...], coupling: float) -> float:
        """Standard deviation of a corner's sprung mass as a share of it, its spring taken as exact."""
        coupled = 2 * coupling / 3 if len(wheels) == 2 else coupling
        return math.hypot(fit.relative_std, coupled, BENCH_ERROR)

    def _corner(
        self, wheel: str, mass: float, fit: CornerFit, share: float, wheels: int, vehicle: Vehicle
    ) -> tuple[ParameterEstimate, Assumption]:
        whole = "its axle as a whole" if wheels == 2 else "this wheel alone"
        said = (
            f"{whole}, {fit.blocks.count} blocks: pitch and roll inertia"
            f"{'' if wheels == 2 else ' and the anti-roll bar'} may change what it seems to carry"
        )
        # left and right of an axle cannot be told apart by their mean
        uneven = 0.05 if wheels == 2 else 0.0
        return corner_answer(wheel, figure(mass, math.hypot(share, uneven) * mass), vehicle, self.name, said)

    @staticmethod
    def _assumed(nuisance: Nuisance) -> tuple[Assumption, ...]:
        words = f"scales within {nuisance.gain_std:.2%}, delay within {1000 * nuisance.delay_std_s:g} ms, one standard deviation"
        return (
            Assumption("accelerometers of body and hubs against one another", words, "settings"),
            Assumption("suspension friction", f"within {nuisance.friction_std_n:g} N a wheel", "settings"),
        )
