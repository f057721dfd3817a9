"""Doubts of the physics: a log that comes from a simple model, which leaves out pieces that real vehicles have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import combinations

from pipelines.joint.doubts.weighed import Doubt, Figures, Place, elsewhere
from pipelines.joint.vehicle.unknowns import AXLES, Known
from pipelines.vehicles.vehicle import Vehicle

SIMPLE = 0.15
"""Chance beforehand that a log comes from a simple model, which leaves each piece of physics out or not, as a coin falls. Authors who were asked
to write a simulator of their own, blind to this code, wrote whole ones nearly always (heights of data sheets +1 to +2.5 % where this was 0.25)."""

BARE = 0.06
"""Chance beforehand that it has wheel loads by m a h / L, as textbooks do: wheels and gravity out, the rest as a coin falls."""

WHEELS, STILL = "wheels that take no torque to spin up", "patches that stay under their wheels"
UPRIGHT = "no gravity that tips a pitched body"
LEAN, HUBS = "no gravity that tips a leaning body", "no braked wheels' inertia in the springs"
SELDOM, COIN = 0.1, 0.5
"""Chance that a simple model leaves out weight that tips a leaning body, where the springs tell (what the accelerometer reads and the
springs have nothing of is an author's mistake rather than his choice), and any other piece, loads by m a h / t among them."""
TYRES = "tyre normal forces"

BETWEEN = " and "

PATCH, GAIN = "patch_lag", "axle_pitch_gain"
PATCH_SIDE, LEAN_PATH, HUBS_PAST = "patch_side", "lean_path", "hubs_past"


def physics_doubts(joint: Place, vehicle: Vehicle) -> list[Doubt]:
    """Simple authors leave out some pieces, every choice of them alike but for a textbook's. A vehicle on the road has them all."""
    pieces = {} if vehicle.real else _left_out(joint, vehicle)
    by_loads = any(e.kind == "roll" and e.carrier == TYRES for e in joint.evidence)
    out = {text: SELDOM if text == LEAN and not by_loads else COIN for text in pieces}
    found = []
    for chosen in (c for n in range(1, len(pieces) + 1) for c in combinations(pieces, n)):
        figures = {name: value for text in chosen for name, value in pieces[text].items()}
        each = {text: chance if text in chosen else 1 - chance for text, chance in out.items()}
        chance = SIMPLE * math.prod(each.values())
        if {WHEELS, STILL} & {*chosen} and UPRIGHT in chosen:
            chance += BARE * math.prod(p for text, p in each.items() if text not in (WHEELS, STILL, UPRIGHT))
        found.append(elsewhere(BETWEEN.join(chosen), joint.known, figures, chance))
    return found


def _left_out(joint: Place, vehicle: Vehicle) -> dict[str, Figures]:
    """The pieces of physics that simple models leave out, and where their unknowns are then."""
    known = joint.known
    # who had these measured has a vehicle on the road, or a model of all of it
    tyres = vehicle.get("tire_longitudinal_rate_npm") is not None
    pitches = vehicle.get("patch_path_pitch_mprad") is not None
    kilos, radius = (float(known.mean[known.index(n)]) for n in ("empty_mass", "radius"))
    low = 0.02 * radius
    centres = {
        "pitch_center_height_m": ("pitch_center_brake", low),
        "pitch_center_height_drive_m": ("pitch_center_drive", low),
    }
    spins = vehicle.get("wheel_inertia_kgm2") is not None
    pieces = {
        STILL if spins else WHEELS: {} if tyres else _plain_wheels(known, vehicle, spins),
        UPRIGHT: {} if pitches else _upright(joint),
        LEAN: {} if pitches or tyres or not _asks(joint, LEAN_PATH) else _level(known),
        HUBS: _silent(vehicle, {"wheel_recession_front": (HUBS_PAST, 0.1)}, 1.0)
        if _asks(joint, HUBS_PAST)
        else {},
        # a model with a pitch centre in braking is not without one in driving
        "no anti-dive": _silent(vehicle, centres) if vehicle.get("pitch_center_height_m") is None else {},
        "a roll axis in the ground": _silent(
            vehicle, {f"roll_center_height_{a}_m": (f"roll_center_{a}", low) for a in AXLES}
        ),
        "no unsprung masses": _silent(
            vehicle, {f"unsprung_mass_{a}_kg": (f"unsprung_{a}", 0.002 * kilos) for a in AXLES}
        ),
    }
    return {text: figures for text, figures in pieces.items() if figures}


def _silent(vehicle: Vehicle, figures: Mapping[str, tuple[str, float]], at: float = 0.0) -> Figures:
    """Unknowns that are nought, or `at`, but for those that the vehicle file states: key -> (unknown, spread)."""
    return {name: (at, spread) for key, (name, spread) in figures.items() if vehicle.get(key) is None}


def _asks(joint: Place, name: str) -> bool:
    """Whether a relation hangs on an unknown."""
    return any(name in e.unknowns for e in joint.evidence)


def _plain_wheels(known: Known, vehicle: Vehicle, spins: bool) -> Figures:
    """Wheels without inertia, unless it is stated (spins), over patches that stay under them.

    Who leaves one way of a patch out knows none that he does not state.
    """
    still = {"tire_lateral_rate_npm": (PATCH_SIDE, 0.1 * float(known.std[known.index(PATCH_SIDE)]))}
    weightless = {} if spins else {"wheel_inertia": (0.0, 0.05)}
    return {**weightless, PATCH: (0.0, 0.002), **_silent(vehicle, still)}


def _level(known: Known) -> Figures:
    """Springs and loads of tyres by m a h alone: the accelerometer reads gravity's share as the body leans, they have nothing of it."""
    mean = dict(zip(known.names, known.mean.tolist(), strict=True))
    arm = mean["empty_h"] - 0.5 * (mean["roll_center_front"] + mean["roll_center_rear"])
    return {LEAN_PATH: (arm, 0.15 * arm)}


def _upright(joint: Place) -> Figures:
    """Gravity that does not tip the pitched body: the body pitches about its CG.

    Axle loads have the body's pitch as a gain on the force (`axle_pitch_gain`). Against an accelerometer, which reads gravity's
    share, the loads of such a model lie lower by that gain, as if the patches were shifted.
    """
    known = joint.known
    height = float(known.mean[known.index("empty_h")])
    figures: Figures = {"pitch_path": (height, 0.15 * height)}
    if GAIN not in known.names:
        return figures
    gain = float(known.mean[known.index(GAIN)])
    felt = any({GAIN, "offset_x", PATCH} <= {*e.unknowns, *(o.name for o in e.own)} for e in joint.evidence)
    lower = height * gain / (1 + gain)
    more = {PATCH: (-lower, 0.25 * lower)} if felt else {GAIN: (0.0, 0.1 * gain)}
    return {**figures, **more}
