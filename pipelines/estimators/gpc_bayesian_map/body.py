"""What is special about the three-degree-of-freedom model on a real vehicle: stiffer springs, and whole-vehicle answers.

The body rolls about its roll axis and not about its CG, as the model has it: tyres hold the axles sideways. What the model calls
roll inertia is J + m arm² on a log, twice the body's own, and has to be taken apart again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipelines.bayes.priors import Priors
from pipelines.estimators.base_excitation.answers import mass_prior
from pipelines.estimators.base_excitation.data import BUSHES, stiffer, unsprung_masses
from pipelines.estimators.gpc_bayesian_map.data import ModelData
from pipelines.models.roll import GRAVITY
from pipelines.results import Assumption, Prior
from pipelines.vehicles.priors import measured_cg_height, measured_pitch_inertia, measured_roll_inertia
from pipelines.vehicles.vehicle import Quantity, Vehicle

SQRT_12 = math.sqrt(12)
MOST_STIFFER = 0.25
"""The largest stiffness beyond the springs with which anything is told: high roll centres, heavy axles on leaf springs."""

HELD = (0.9, 0.2)
"""Share of m arm² that the tyres' hold puts into the roll inertia, and its spread: they give way sideways, too."""

SPRUNG_HIGHER = 1.06
ROLL_AXIS_M = (0.1, 0.07)
ANY_HEIGHT_M = (0.75, 0.25)
"""Sprung CG over the whole vehicle's CG; roll axis above ground and CG height where nothing is known of them."""

TRAVEL_HZ, FREE_TRAVEL_M, STOP_ERROR = 0.4, 0.03, 0.08
"""A loaded car's wheel is free to travel so far; beyond it may meet its stop, surely at twice that; the error that this makes."""

DRY_SHARE, STICKING, LEAST_TRAVEL_M = 0.02, 0.25, 0.002
"""Dry friction of a wheel as a share of its load; how much of it is held rather than slid over."""

PLACE_ERROR = 0.02
"""What the CG's place may be off by beside what the fit says, as a share of the wheelbase."""


@dataclass(frozen=True)
class Figure:
    """A whole-vehicle figure: value, standard deviation, how it was made, what was known before."""

    value: float
    std: float
    said: str
    prior: Prior | None = None


def stiffening(figures: Mapping[str, Quantity], vehicle: Vehicle) -> tuple[float, float]:
    """How much stiffer than its springs the front and the rear axle may be, as a share, under a usual body."""
    mass = vehicle.get("mass_kg")
    length, behind = vehicle.get("wheelbase_m"), vehicle.get("cg_to_front_axle_m")
    share = behind.value / length.value if behind is not None and length is not None else 0.5
    spring = sum(figures[f"spring_rate_{a}_npm"].value for a in ("front", "rear"))
    body = 0.95 * mass.value if mass is not None else 2 * spring / (2 * math.pi * 1.4) ** 2
    return stiffer((1 - share) * body, share * body, vehicle)


def stiffened(figures: Mapping[str, Quantity], more: tuple[float, float]) -> dict[str, Quantity]:
    """The given figures with springs as stiff as bushes, friction and guides make them: the middle of what they may add."""
    out = dict(figures)
    for axle, extra in zip(("front", "rear"), more, strict=True):
        key = f"spring_rate_{axle}_npm"
        q = figures[key]
        # half of what they may add; of bushes and friction a part only, as this model has friction of its own
        factor = 1 + (extra - BUSHES) / 2
        std = math.hypot(q.std * factor, q.value * extra / SQRT_12)
        source = f"{q.source}; bushes and guides may add up to {extra:.0%}"
        out[key] = Quantity(q.value * factor, std, source, q.std_stated)
    return out


def travel(data: ModelData) -> float:
    """How far the wheels travel in compression, in m: the 99th percentile of all four, above TRAVEL_HZ."""
    found = []
    for first, past in (run for group in data.groups for run in group):
        rows = slice(int(data.blocks.first[first]), int(data.blocks.first[past - 1]) + data.blocks.rows)
        apart = data.inputs[rows] - data.outputs[rows]
        f = np.fft.rfftfreq(len(apart), data.step_s)
        twice = -((2 * np.pi * np.where(f > 0, f, 1.0)) ** 2)
        keep = f**4 / (f**4 + TRAVEL_HZ**4) / twice
        found.append(np.fft.irfft(np.fft.rfft(apart, axis=0) * keep[:, None], len(apart), axis=0).ravel())
    return float(np.quantile(np.concatenate(found), 0.99))


def travel_error(travel_m: float, sprung_kg: float, spring_npm: float) -> float:
    """What travel does to masses and inertias, as a share: stops and stiffening springs where it is long, and where it is short dry
    friction, which holds like a spring of its force over the travel."""
    stops = STOP_ERROR * min(max((travel_m - FREE_TRAVEL_M) / FREE_TRAVEL_M, 0.0), 1.0)
    dry = DRY_SHARE * sprung_kg * GRAVITY / 4
    return math.hypot(stops, STICKING * dry / (spring_npm * max(travel_m, LEAST_TRAVEL_M)))


def _arm(vehicle: Vehicle) -> tuple[float, float]:
    """Sprung CG above the roll axis: mean and standard deviation in m, with a load that may lie anywhere."""
    mass = vehicle.get("mass_kg")
    stated = vehicle.get("cg_height_m")
    if stated is not None:
        height, std = stated.value, math.hypot(stated.std, 0.03 * stated.value)
    else:
        known = measured_cg_height(vehicle.body, mass.value if mass is not None else None, vehicle.powertrain)
        height, std = (known.value, known.std) if known is not None else ANY_HEIGHT_M
        std = math.hypot(std, 0.04 * height)
    axes = [q for a in ("front", "rear") if (q := vehicle.get(f"roll_center_height_{a}_m")) is not None]
    axis = sum(q.value for q in axes) / len(axes) if axes else ROLL_AXIS_M[0]
    off = max((q.std for q in axes), default=ROLL_AXIS_M[1])
    return max(SPRUNG_HIGHER * height - axis, 0.05), math.hypot(SPRUNG_HIGHER * std, off)


def whole_vehicle(
    values: Mapping[str, float], stds: Mapping[str, float], vehicle: Vehicle, priors: Priors
) -> tuple[dict[str, Figure], Assumption]:
    """Answers by parameter name from the model's parameters."""
    sprung, sprung_std = values["sprung_mass_kg"], stds["sprung_mass_kg"]
    behind = values["sprung_cg_behind_front_axle_m"]
    (front, rear), hubs_std, assumed = unsprung_masses(vehicle, sprung)
    mass = sprung + front + rear
    length = vehicle.get("wheelbase_m")
    assert length is not None, "the model needs it"
    place = (sprung * behind + rear * length.value) / mass
    place_std = math.hypot(sprung / mass * stds["sprung_cg_behind_front_axle_m"], PLACE_ERROR * length.value)
    prior = mass_prior(vehicle)
    known = next(item for item in priors.items if item.name == "sprung_cg_behind_front_axle_m")
    before = Prior(known.distribution.mean, known.distribution.std, known.source)
    empty = vehicle.get("mass_kg")
    found = {
        "sprung_mass_kg": Figure(sprung, sprung_std, "heave, pitch and roll of the body over its hubs"),
        "mass_kg": Figure(mass, math.hypot(sprung_std, hubs_std), "sprung and unsprung mass", prior),
        "cg_to_front_axle_m": Figure(place, place_std, "how heave and pitch of the body go together", before),
    }
    pitch, pitch_std = values["sprung_pitch_inertia_kgm2"], stds["sprung_pitch_inertia_kgm2"]
    hubs = front * place**2 + rear * (length.value - place) ** 2
    found["pitch_inertia_kgm2"] = Figure(
        pitch + sprung * (place - behind) ** 2 + hubs,
        math.hypot(pitch_std, 0.1 * hubs),
        "of the whole vehicle about its CG: the sprung mass's and that of the hubs at their distances",
        measured_pitch_inertia(empty.value if empty is not None else None, length.value),
    )
    found["roll_inertia_kgm2"] = _roll(values, stds, vehicle, (front, rear))
    return found, assumed


def _roll(
    values: Mapping[str, float], stds: Mapping[str, float], vehicle: Vehicle, hubs: tuple[float, float]
) -> Figure:
    """Roll inertia of the whole vehicle about its CG, from that about the roll axis."""
    sprung = values["sprung_mass_kg"]
    seen, seen_std = values["sprung_roll_inertia_kgm2"], stds["sprung_roll_inertia_kgm2"]
    arm, arm_std = _arm(vehicle)
    held, held_std = HELD
    moved = held * sprung * arm**2
    own = seen - moved
    tracks = [q.value for a in ("front", "rear") if (q := vehicle.get(f"track_{a}_m")) is not None]
    width = sum(tracks) / len(tracks) if tracks else 1.55
    of_hubs = sum(hubs) * (width**2 / 4 + 0.3**2)
    std = math.hypot(seen_std, held_std * sprung * arm**2, 2 * held * sprung * arm * arm_std, 0.15 * of_hubs)
    mass = vehicle.get("mass_kg")
    return Figure(
        own + of_hubs,
        std,
        f"the body rolls about its roll axis with {seen:.0f} ± {seen_std:.0f} kg·m²; about its CG, {arm:.2f} ± {arm_std:.2f} m "
        "above, it is so much less",
        measured_roll_inertia(mass.value if mass is not None else None, width),
    )
