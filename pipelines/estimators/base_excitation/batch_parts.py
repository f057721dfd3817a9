"""Single corners of a vehicle for the batch fit: which go together, and whether a fit can be used."""

from __future__ import annotations

import numpy as np

from pipelines.estimators.base_excitation.batch_corner import Corner, CornerFit
from pipelines.estimators.base_excitation.data import AXLES, RideData

LEAST_EXPLAINED = 0.5
"""Share of the measured motion (for heave: of the springs' force) that must follow from the model."""


def groups(corners: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Whole axles as pairs, the other wheels alone."""
    found: list[tuple[str, ...]] = []
    for pair in AXLES.values():
        there = tuple(w for w in pair if w in corners)
        if there:
            found.append(there)
    return found


def joined(data: RideData, wheels: tuple[str, ...]) -> Corner:
    """One corner, or the mean of an axle's two."""
    sprung = np.mean([data.sprung[w] for w in wheels], axis=0)
    unsprung = np.mean([data.unsprung[w] for w in wheels], axis=0)
    return Corner(sprung, unsprung, data.stretches, data.rate_hz, data.springs[wheels[0]].value, data.lively)


def why_not(fit: CornerFit | None) -> str:
    """Why a corner's fit cannot be used; "" where it can."""
    if fit is None:
        return "fewer than three blocks of lively motion without a gap"
    if fit.explained < LEAST_EXPLAINED:
        return (
            f"the body's acceleration does not follow from the hub's ({max(fit.explained, 0):.0%} of it does): check "
            "channels and signs, or drive over rougher ground"
        )
    if fit.at_bound:
        return "no mass with a natural frequency of 0.3 to 5 Hz fits: check the spring rate and the units"
    return ""


def figures_of(fit: CornerFit, label: str) -> dict[str, float]:
    """Diagnostics of a corner's fit."""
    names = ("extension_nspm", "compression_nspm", "friction_n", "gain", "delay_s")
    figures = {f"{label}_{name}": float(v) for name, v in zip(names, fit.values[1:], strict=True)}
    return {
        f"{label}_sprung_mass_kg": fit.mass_kg,
        f"{label}_sprung_mass_chance_kg": fit.mass_kg * fit.relative_std,
        **figures,
        f"{label}_explained_share": fit.explained,
        f"{label}_accelerometer_noise_mps2": fit.noise_mps2,
        f"{label}_steps": float(fit.steps),
        f"{label}_converged": float(fit.converged),
    }
