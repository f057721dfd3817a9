"""Doubts of the vehicle file: stated figures that are wrong by several of their spreads, an empty vehicle unlike the measured ones."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pipelines.joint.doubts.weighed import WIDER, WRONG_FILE, Doubt, Place, elsewhere, wider
from pipelines.joint.file_check import BARS, LOAD, UNSPRUNG, of_any, stated_unknowns
from pipelines.joint.vehicle.no_bars import NOT_LOOKED_UP, bars_not_looked_up
from pipelines.joint.vehicle.unknowns import AXLES, Known
from pipelines.vehicles.kinds import usual_load
from pipelines.vehicles.kinematics import spring_curve
from pipelines.vehicles.unheard_of import TRACK_OPEN, front_share, odd_axles, tracks_apart, usual_place
from pipelines.vehicles.usual import usual_unsprung
from pipelines.vehicles.vehicle import Vehicle

OFTEN_WRONG = {"stated mass": 0.05, "stated spring rates": 0.05, LOAD: 0.05}
"""The same of what data sheets mean in several ways: kerb, empty or permitted mass; rates at the spring or at the wheel. Who states where
the CG lies across has weighed the wheels, and who states wheel rates above and below ride height has had them measured at the wheel. And of
a load, which who wrote it down did not drive with."""

WEIGHED = 0.005
"""The same of where the CG lies along, in the file of a vehicle whose wheels were weighed."""

FAR_OFF: dict[str, tuple[float, float]] = {"stated mass": (0.08, 0.03)}
"""Where figures are told more closely than people err: how far off they then are, a share of the figure, and the chance of it. A mass that was
written down with the driver in it, from another trim or with a digit changed is off by as much whether it is said to be sure to 2 or to 0.3 %."""

SURE = 1e-4
"""Spread over a figure below which it was stated as exact."""

UNHEARD_OF = 0.5
"""The same of a figure that no such vehicle has."""
PLACE, TRACKS = "stated place of the CG", "stated tracks"

UNLIKE, FARTHER = 0.06, 2.0
"""Chance that an empty vehicle is unlike the measured ones of its kind, and its CG height's spread over theirs then: about the lines by
style and mass the measured heights lie as Student's law of 7 degrees of freedom has it, three of theirs beyond three spreads for one of
a normal law's."""


def chance_wrong(title: str, vehicle: Vehicle) -> float:
    """Chance beforehand that stated figures are wrong: as data sheets are, or as rigs are where the file holds what only those find."""
    if title == "stated spring rates" and all(spring_curve(vehicle.quantities, axle) for axle in AXLES):
        return WRONG_FILE
    if not_as_stated(title, vehicle):
        return UNHEARD_OF
    if vehicle.get("cg_lateral_offset_m") is not None:
        weighed = {"stated mass": WRONG_FILE, PLACE: WEIGHED}
        return weighed.get(title, OFTEN_WRONG.get(title, WRONG_FILE))
    return OFTEN_WRONG.get(title, WRONG_FILE)


def exact(known: Known, names: Iterable[str]) -> bool:
    """Whether any of these unknowns is stated without a spread: then it is no unknown, and nothing is said of it."""
    rows = [known.index(name) for name in names]
    return any(known.std[row] < SURE * abs(known.mean[row]) for row in rows)


def not_as_stated(title: str, vehicle: Vehicle) -> dict[str, tuple[float, float]]:
    """The unknowns of stated figures that no such vehicle has: where they have them; nothing for figures that may be."""
    if title == PLACE:
        usual = usual_place(vehicle)
        return {} if usual is None or front_share(vehicle) is None else {"empty_x": usual}
    if title == TRACKS:
        found = tracks_apart(vehicle)
        return {} if found is None else {f"track_{axle}": (found[0], TRACK_OPEN * found[0]) for axle in AXLES}
    mass = vehicle.get("mass_kg")
    if title != UNSPRUNG or mass is None:
        return {}
    return {f"unsprung_{axle}": usual_unsprung(vehicle, axle, mass.value) for axle in odd_axles(vehicle)}


def file_doubts(joint: Place, vehicle: Vehicle) -> list[Doubt]:
    """Every stated figure: each of a pair by itself, and both wrong alike. A load that is not the stated one is any that such vehicles carry."""
    found = []
    for title, names in stated_unknowns(vehicle).items():
        text, chance = f"{title} wrong", chance_wrong(title, vehicle)
        if title == LOAD:
            kilos = float(joint.known.mean[joint.known.index("empty_mass")])
            usual = usual_load(vehicle, kilos)
            anywhere = {
                n: (float(joint.known.mean[joint.known.index(n)]), of_any(joint.known, n)) for n in names[1:]
            }
            found.append(elsewhere(text, joint.known, {"load": (usual.mean, usual.std), **anywhere}, chance))
        elif title == BARS and (bars := bars_not_looked_up(joint.known, vehicle)):
            found.append(elsewhere(text, joint.known, bars, NOT_LOOKED_UP))
        elif where := not_as_stated(title, vehicle):
            if not exact(joint.known, where):
                found.append(elsewhere(text, joint.known, where, chance))
        else:
            found += [*wider(text, names, chance), *_far_off(joint.known, title, names)]
    return found


def _far_off(known: Known, title: str, names: tuple[str, ...]) -> list[Doubt]:
    """A figure that is off by what people err by, where five of its own spreads are less."""
    if title not in FAR_OFF:
        return []
    share, chance = FAR_OFF[title]
    rows = [known.index(name) for name in names]
    apart = share * np.abs(known.mean[rows]) / known.std[rows]
    if apart.min() <= WIDER:
        return []
    return [Doubt(f"{title} wrong", names, np.zeros(len(names)), np.diag(apart**-2.0), chance)]


def unlike_measured(_: Place, vehicle: Vehicle) -> list[Doubt]:
    """An empty CG higher or lower than those of measured vehicles, where the vehicle file has none of its own."""
    if vehicle.get("cg_height_m") is not None:
        return []
    text = "an empty CG height unlike those of measured vehicles"
    return [Doubt(text, ("empty_h",), np.zeros(1), np.eye(1) * FARTHER**-2, UNLIKE)]
