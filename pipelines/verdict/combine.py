"""The verdict: one answer a parameter.

With one estimator it is that estimator's posterior; where several give a parameter, the first that identified it best
speaks and the others are named as witnesses. A joint posterior over all physical relations can take this place: the
result's shape stays the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pipelines.results import Estimate, ParameterEstimate, Prior
from pipelines.vehicles.priors import measured_cg_height, measured_roll_inertia
from pipelines.vehicles.vehicle import Vehicle

ORDER = ("identified", "weak", "not_identifiable")

MISSING: dict[str, str] = {
    "cg_height_m": "it needs roll motion with a known roll stiffness, or braking with known axle loads",
    "mass_kg": "it needs axle loads, suspension forces, or drive and brake torques",
    "cg_to_front_axle_m": "it needs axle loads or suspension deflections of both axles",
    "cg_lateral_offset_m": "it needs suspension deflections or forces of both sides",
    "roll_gradient_degpg": "it needs lateral acceleration and roll (or roll rate) while cornering",
    "roll_natural_frequency_hz": "it needs lateral acceleration and roll (or roll rate) in quick steering",
    "roll_damping_ratio": "it needs lateral acceleration and roll (or roll rate) in quick steering",
    "roll_stiffness_nmprad": "it needs lateral acceleration, roll, and the vehicle's mass",
    "roll_damping_nmsprad": "it needs lateral acceleration, roll, and the vehicle's mass",
    "roll_inertia_kgm2": "it needs quick roll motion and the vehicle's mass",
}
"""The core parameters, which the verdict always holds, and what each one needs."""


def _prior(name: str, vehicle: Vehicle) -> Prior | None:
    """What is known of a parameter without any log."""
    stated = vehicle.get(name)
    if stated is not None:
        return Prior(stated.value, stated.std, f"{stated.source} (empty vehicle)")
    mass = vehicle.get("mass_kg")
    mass_kg = None if mass is None else mass.value
    if name == "cg_height_m":
        return measured_cg_height(vehicle.body, mass_kg)
    if name == "roll_inertia_kgm2":
        return measured_roll_inertia(mass_kg)
    return None


def _unanswered(name: str, reason: str, vehicle: Vehicle) -> ParameterEstimate:
    """A parameter that no estimator gave: its prior, or no figures."""
    prior = _prior(name, vehicle)
    reference = vehicle.reference.get(name)
    if prior is None:
        return ParameterEstimate(
            name, None, None, None, None, "not_identifiable", reason, None, reference, ()
        )
    half = 1.96 * prior.std
    words = f"{reason}; the figures are the prior's"
    return ParameterEstimate(
        name,
        prior.value,
        prior.std,
        prior.value - half,
        prior.value + half,
        "not_identifiable",
        words,
        prior,
        reference,
        ("prior",),
    )


def _why_nobody(name: str, estimates: Sequence[Estimate]) -> str:
    """Why no estimator gave a parameter: what it needs, and what the estimators said that did not run."""
    told = [f"{e.estimator} {e.status}: {e.reason}" for e in estimates if e.status != "ran"]
    return "; ".join(
        (f"no estimator gave it: {MISSING.get(name, 'the signals for it are not there')}", *told)
    )


def combine(estimates: Sequence[Estimate], vehicle: Vehicle) -> dict[str, ParameterEstimate]:
    """One answer for every parameter that an estimator gave, and for the core ones that none did."""
    verdict: dict[str, ParameterEstimate] = {}
    for estimate in estimates:
        if estimate.status != "ran":
            continue
        for name, answer in estimate.parameters.items():
            before = verdict.get(name)
            if before is None:
                verdict[name] = answer
                continue
            better = ORDER.index(answer.status) < ORDER.index(before.status)
            best, other = (answer, before) if better else (before, answer)
            verdict[name] = replace(best, sources=tuple(dict.fromkeys((*best.sources, *other.sources))))
    for name in MISSING:
        if name not in verdict:
            verdict[name] = _unanswered(name, _why_nobody(name, estimates), vehicle)
    return verdict
