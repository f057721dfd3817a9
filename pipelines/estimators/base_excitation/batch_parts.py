"""Single corners of a vehicle for the batch fit: which go together, and whether a fit can be used."""

from __future__ import annotations

import numpy as np

from pipelines.estimators.base_excitation.batch_corner import Corner, CornerFit
from pipelines.estimators.base_excitation.data import AXLES, RideData

LEAST_EXPLAINED = 0.5
"""Share of the measured motion (for heave: of the springs' force) that must follow from the model."""

PRESLIDING_M, MOST_STIFFER = 0.001, 0.25
"""How far a suspension moves before its friction slips; the largest stiffness beyond the springs with which anything is said."""

LEAST_ROUGH = 0.6
HEAVE_EXPLAINED = 0.96
"""On a vehicle: share of the drive that must be rough; share of the heave that must follow from springs and dampers, or the
mass comes out low: 0.99 off road, 0.80-0.92 on roads, where it was 10 to 25 % low."""


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


def rough_share(data: RideData) -> float:
    """Share of the drive in which the hubs move enough."""
    rough = sum(int(data.lively[i:j].sum()) for i, j in data.stretches)
    return rough / max(sum(j - i for i, j in data.stretches), 1)


def not_rough(data: RideData) -> str:
    """Why a vehicle's drive as a whole tells no mass; "" where it may."""
    share = rough_share(data)
    if share >= LEAST_ROUGH:
        return ""
    return (
        f"only {share:.0%} of the drive is rough: bends, brakes and single bumps move the body by more than springs and "
        "dampers; drive straight over rough ground"
    )


def why_not(fit: CornerFit | None, stiffer: float = 0.0) -> str:
    """Why a corner's fit cannot be used; "" where it can. stiffer: what friction that sticks may add to its spring, as a share of it."""
    if fit is None:
        return "fewer than three blocks of lively motion without a gap"
    if fit.explained < LEAST_EXPLAINED:
        return (
            f"the body's acceleration does not follow from the hub's ({max(fit.explained, 0):.0%} of it does): check "
            "channels and signs, or drive over rougher ground"
        )
    if fit.at_bound:
        return "no mass with a natural frequency of 0.3 to 5 Hz fits: check the spring rate and the units"
    if stiffer > MOST_STIFFER:
        return (
            f"dry friction that sticks may be {stiffer:.0%} of the springs at so small a travel, and the mass comes in proportion to the "
            "stiffness: drive straight over rougher ground"
        )
    return ""


def sticking(corner: Corner, friction_n: float, low_hz: float) -> float:
    """What dry friction may add to a corner's spring, as a share of it: F over k times the travel's amplitude, which is at least 1 mm.

    Friction is a spring below its presliding travel, and beyond it one of at most F over the amplitude. friction_n: a usual wheel's.
    """
    power = seconds = 0.0
    for start, stop in corner.stretches:
        apart = corner.sprung[start:stop] - corner.unsprung[start:stop]
        if len(apart) < 2 * corner.rate_hz / low_hz:
            continue
        hertz = np.fft.rfftfreq(len(apart), 1 / corner.rate_hz)
        seen = hertz >= low_hz
        travel = np.abs(np.fft.rfft(apart))[seen] / (2 * np.pi * hertz[seen]) ** 2
        power += 2 * float(travel @ travel) / len(apart)
        seconds += len(apart)
    amplitude = float(np.sqrt(2 * power / seconds)) if seconds else 0.0
    return friction_n / (corner.spring_npm * max(amplitude, PRESLIDING_M))


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
