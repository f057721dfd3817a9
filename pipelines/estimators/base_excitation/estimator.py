"""Sprung mass by base excitation, as published: Pence, Fathy & Stein, with its sum over four corners.

The measured hub acceleration is the known input, so that neither the road nor a suspension force is needed. The
figures stand beside the verdict: noise in the filtered regressors pulls the published estimate low, by 3-8 % on the
paper's own set-up, and its interval says so.
"""

from __future__ import annotations

import math

import numpy as np

from pipelines.estimators.base import Setting, Settings
from pipelines.estimators.base_excitation.answers import (
    CORNER_MASSES,
    BodyFigures,
    answer,
    body_answers,
    corner_answer,
    figure,
    nothing,
)
from pipelines.estimators.base_excitation.data import (
    AXLES,
    RideData,
    collect_ride,
    spring_assumptions,
    stiffer,
)
from pipelines.estimators.base_excitation.method import RideMethod
from pipelines.estimators.base_excitation.rls import (
    FilterChoice,
    RlsFit,
    combined_std,
    corner_regression,
    heave_regression,
    run_rls,
)
from pipelines.prepare.prepared import Prepared
from pipelines.results import Assumption, Estimate, FloatArray, ParameterEstimate, Trace, Track
from pipelines.vehicles.vehicle import Vehicle

SETTINGS: tuple[Setting, ...] = (
    Setting("natural_radps", 6.0, "rad/s", "natural frequency of the filter Λ (good: 3-10)", 0.5, 50.0),
    Setting("damping_ratio", 0.1, "-", "damping ratio of the filter Λ (good: 0.05-0.25)", 0.005, 1.0),
    Setting(
        "cutoff_hz", 50.0, "Hz", "zero-phase low-pass of all signals before the filters", 10.0, 500.0
    ),
    Setting(
        "least_excitation", 0.4, "m/s²", "hub acceleration (RMS over 4 s) from which a stretch is used", 0.0, 10.0
    ),
    Setting(
        "coupling", 0.15, "share", "what inertia and anti-roll bars may do to a wheel's apparent mass; 0 on a bench", 0.0, 1.0
    ),
)  # fmt: skip
MODEL_ERROR = 0.03
"""What a linear damper and no friction may cost, as a share of the mass (a damper of slopes 1 : 3 costs 4 %)."""

DAMPING_ERROR = 0.1
MOST_STIFFER = 0.25
"""Largest stiffness beyond the springs with which anything is said."""


class BaseExcitation(RideMethod):
    """The estimator "base_excitation"."""

    name: str = "base_excitation"
    title: str = "Base excitation, recursive least squares"

    source: str = (
        "Pence, Fathy, Stein: Sprung mass estimation for off-road vehicles via base-excitation suspension dynamics and "
        "recursive least squares, eqs. (1)-(7); on four corners their sum, which is heave"
    )
    parameters: tuple[str, ...] = (
        "sprung_mass_kg",
        "mass_kg",
        "cg_to_front_axle_m",
        *CORNER_MASSES,
        "suspension_damping_nspm",
    )

    settings: tuple[Setting, ...] = SETTINGS

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Estimate. A drive that cannot tell ends with parameters "not_identifiable" and the reason."""
        data = collect_ride(prepared, vehicle, self.value(settings, "least_excitation"))
        choice = FilterChoice(self.value(settings, "natural_radps"), self.value(settings, "damping_ratio"))
        if data.why_not:
            return self._nothing(data, vehicle, data.why_not)
        corners = {w: run_rls(corner_regression(data, w, choice), data.rate_hz) for w in data.corners}
        heave = run_rls(heave_regression(data, choice), data.rate_hz) if len(data.corners) == 4 else None
        fits = {w: fit for w, fit in corners.items() if fit is not None}
        if not fits or (len(data.corners) == 4 and heave is None):
            reason = "fewer than ten seconds of lively motion remain after the filters have settled"
            return self._nothing(data, vehicle, reason)
        if heave is not None:
            return self._whole(prepared, data, vehicle, heave, fits, choice)
        return self._corners(prepared, data, vehicle, fits, choice, self.value(settings, "coupling"))

    def _nothing(self, data: RideData, vehicle: Vehicle, reason: str) -> Estimate:
        return Estimate(
            self.name,
            "ran",
            reason,
            nothing(self.parameters, vehicle, reason),
            diagnostics={"hub_rms_mps2": data.hub_rms},
            witness=True,
        )

    def _whole(
        self,
        prepared: Prepared,
        data: RideData,
        vehicle: Vehicle,
        heave: RlsFit,
        corners: dict[str, RlsFit],
        choice: FilterChoice,
    ) -> Estimate:
        """Four corners: the sum of their equations."""
        front, front_std = combined_std(heave, [1, 0, 0, 0], MODEL_ERROR)
        rear, rear_std = combined_std(heave, [0, 1, 0, 0], MODEL_ERROR)
        sprung = front + rear
        if min(front, rear) <= 0:
            reason = "the fit gave a negative mass: the accelerations do not follow from one another; check channels and signs"
            return self._nothing(data, vehicle, reason)
        springs = spring_spread(heave, data)
        # chance of both axles, the model's error and the springs; the tilt goes up only
        chance = float(np.hypot(heave.scatter[0], heave.scatter[1]))
        std = math.sqrt(chance**2 + (MODEL_ERROR * sprung) ** 2 + springs**2)
        ahead, behind = stiffer(front, rear, vehicle)
        if max(ahead, behind) > MOST_STIFFER:
            reason = (
                f"the guides may make the suspension {max(ahead, behind):.0%} stiffer than its springs (high roll centres), and "
                "the mass comes in proportion to the stiffness"
            )
            return self._nothing(data, vehicle, reason)
        hidden = ahead * front + behind * rear
        uneven = front * rear / sprung**2 * max(ahead, behind) / math.sqrt(3)
        noise = float(heave.other_end[0] + heave.other_end[1])
        upwards = noise + hidden
        place_std = math.hypot(math.hypot(front_std, rear_std) / sprung / 2, uneven)
        said = (
            f"sum of four corners over {len(heave.residual) / data.rate_hz:.0f} s; noise pulls least squares low, "
            f"by up to {noise:.0f} kg here; bushes and guides may hide {hidden:.0f} kg; {MODEL_ERROR:.0%} for linear dampers "
            "without friction"
        )
        body = BodyFigures(
            front, rear, math.hypot(front_std, springs / 2), math.hypot(rear_std, springs / 2), std, upwards,
            (rear / sprung, place_std), None, said,
        )  # fmt: skip
        found, assumed = body_answers(body, vehicle, self.name, witness=True)
        damping, damping_std = combined_std(heave, [0, 0, 0.5, 0.5], DAMPING_ERROR)
        found["suspension_damping_nspm"] = answer(
            "suspension_damping_nspm",
            figure(damping, damping_std),
            vehicle,
            self.name,
            "mean of both axles and directions",
        )
        figures = {f"corner_apparent_sprung_mass_{w}_kg": float(fit.theta[0]) for w, fit in corners.items()}
        figures["corner_sum_sprung_mass_kg"] = sum(figures.values())
        track = heave.track[:, 0] + heave.track[:, 1]
        return self._told(
            prepared, data, found, ("sprung_mass_kg", track, std, upwards), heave, figures, choice, (assumed,)
        )

    def _corners(
        self,
        prepared: Prepared,
        data: RideData,
        vehicle: Vehicle,
        fits: dict[str, RlsFit],
        choice: FilterChoice,
        coupling: float,
    ) -> Estimate:
        """Fewer than four corners: what each one carries, as it seems."""
        found = nothing(self.parameters, vehicle, "it needs body and hub accelerations at all four wheels")
        assumptions: list[Assumption] = []
        figures: dict[str, float] = {}
        track: tuple[str, FloatArray, float, float] | None = None
        first = next(iter(fits))
        for w, fit in fits.items():
            value, upwards = float(fit.theta[0]), float(fit.other_end[0])
            if value <= 0:
                continue
            quantity = data.springs[w]
            share = math.hypot(MODEL_ERROR, coupling, quantity.std / quantity.value)
            std = math.hypot(float(fit.scatter[0]), share * value)
            said = (
                f"wheel {w} alone over {len(fit.residual) / data.rate_hz:.0f} s: pitch and roll inertia and the anti-roll "
                f"bar make it seem lighter or heavier ({coupling:.0%} allowed for); noise pulls it low, by up to {upwards:.0f} kg"
            )
            seen = figure(value, std, upwards)
            found[f"corner_mass_{w}_kg"], assumed = corner_answer(w, seen, vehicle, self.name, said)
            assumptions.append(assumed)
            figures[f"corner_apparent_sprung_mass_{w}_kg"] = value
            if w == first:
                hub = (found[f"corner_mass_{w}_kg"].value or value) - value
                track = (f"corner_mass_{w}_kg", fit.track[:, 0] + hub, std, upwards)
        pairs = [combined_std(fit, [0, 1], DAMPING_ERROR) for fit in fits.values()]
        damping, spread = (
            sum(p[0] for p in pairs) / len(pairs),
            math.hypot(*(p[1] for p in pairs)) / len(pairs),
        )
        found["suspension_damping_nspm"] = answer(
            "suspension_damping_nspm",
            figure(damping, math.hypot(spread, coupling * damping)),
            vehicle,
            self.name,
            "mean of the wheels that were measured",
        )
        if track is None:
            return self._nothing(data, vehicle, "no wheel gave a positive mass: check channels and signs")
        return self._told(
            prepared, data, found, track, fits[first], figures, choice, tuple(dict.fromkeys(assumptions))
        )

    def _told(
        self,
        prepared: Prepared,
        data: RideData,
        found: dict[str, ParameterEstimate],
        track: tuple[str, FloatArray, float, float],
        fit: RlsFit,
        figures: dict[str, float],
        choice: FilterChoice,
        assumptions: tuple[Assumption, ...],
    ) -> Estimate:
        """The estimate with its figures for the report."""
        name, values, std, upwards = track
        seen_s = prepared.time_s[fit.track_rows]
        share = np.sqrt(len(values) / np.arange(1, len(values) + 1))
        rows = fit.regression.rows
        columns = {"spring term": fit.regression.y, "residual": fit.residual}
        filters = Assumption(
            "filter Λ",
            f"natural frequency {choice.natural_radps:g} rad/s, damping ratio {choice.damping_ratio:g}",
            "settings",
        )
        return Estimate(
            estimator=self.name,
            status="ran",
            reason="the regression ran on the lively stretches",
            parameters=found,
            tracks=(
                Track(
                    name, seen_s, values, values - 1.96 * std * share, values + upwards + 1.96 * std * share
                ),
            ),
            traces=(
                Trace(
                    "base excitation fit",
                    prepared.time_s[rows],
                    columns,
                    dict.fromkeys(columns, "N"),
                    "filtered by 1/Λ",
                ),
            ),
            assumptions=(*spring_assumptions(data), *assumptions, filters),
            diagnostics={
                **figures,
                "hub_rms_mps2": data.hub_rms,
                "residual_share": float(np.var(fit.residual)) / max(float(np.var(fit.regression.y)), 1e-30),
            },
            used_fraction=len(rows) / max(len(prepared.time_s), 1),
            witness=True,
        )


def spring_spread(heave: RlsFit, data: RideData) -> float:
    """Standard deviation of the sprung mass in kg from that of the spring rates: the estimate is linear in them."""
    inverse = np.linalg.pinv(heave.regression.phi)
    total = 0.0
    for number, pair in enumerate(AXLES.values()):
        quantity = data.springs[pair[0]]
        moved = inverse @ heave.regression.parts[:, number]
        total += (float(moved[0] + moved[1]) * quantity.std / quantity.value) ** 2
    return math.sqrt(total)
