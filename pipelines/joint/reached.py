"""The posterior that a drive's answers are taken from: the relations that count, the springs and tyres that the drive speaks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.evidence import Evidence
from pipelines.joint.conflict import Check, check
from pipelines.joint.counted import counted
from pipelines.joint.levelled import TEXT as LEVELLED
from pipelines.joint.levelled import as_levelled
from pipelines.joint.posterior import Joint, extended, find_mode
from pipelines.joint.rigid_tyres import HEARD, OPEN, SURE, TEXT, rigid, rigid_chance
from pipelines.joint.stated import stated_relations
from pipelines.joint.unknowns import Known, before_the_log
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

Modes = list[tuple[FloatArray, FloatArray]]
"""Mean (k,) and covariance (k, k) of each mode, the best first."""

APART = 3.0
"""Distance in standard deviations from which on two ends of the search are two modes."""

STARTS = 4

MOVED = ("empty_h", "load_h", "load", "roll_center_front", "roll_inertia")
"""Unknowns that the search is started apart in: heights, where mirror solutions lie."""


@dataclass(frozen=True)
class Reached:
    """A drive's posterior. kept: the drive's relations; stated: the file's; dropped: (relation, why) of those not counted.

    vehicle and known: with the springs and tyres that the drive speaks for. checks: each relation against the rest; before_tyres: the
    same with tyres that give. stiff, chance: the posterior with rigid tyres where the drive leaves them open. found: in words.
    """

    vehicle: Vehicle
    known: Known
    kept: tuple[Evidence, ...]
    stated: tuple[Evidence, ...]
    dropped: tuple[tuple[str, str], ...]
    joint: Joint
    modes: Modes
    checks: tuple[Check, ...]
    before_tyres: tuple[Check, ...]
    stiff: Joint | None
    chance: float
    found: tuple[str, ...]


def _starts(known: Known, rng: np.random.Generator) -> list[FloatArray]:
    """The prior's mean, and points up to two standard deviations off in heights and load."""
    size = len(known.names)
    rows = [known.names.index(n) for n in MOVED]
    found = [np.zeros(size)]
    for _ in range(STARTS - 1):
        start = np.zeros(size)
        start[rows] = rng.uniform(-2, 2, len(rows))
        found.append(start)
    return found


def _modes(evidence: Sequence[Evidence], known: Known, rng: np.random.Generator) -> tuple[Joint, Modes]:
    """The best mode, and all that lie apart from each other: (mean, covariance) each."""
    ends = [find_mode(evidence, known, [start]) for start in _starts(extended(known, evidence), rng)]
    ends.sort(key=lambda end: end.cost)
    best = ends[0]
    modes = [(best.u, best.covariance)]
    for end in ends[1:]:
        away = [float((end.u - u) @ np.linalg.solve(c, end.u - u)) for u, c in modes]
        if end.converged and end.cost < best.cost + 12 and min(away) > APART**2:
            modes.append((end.u, end.covariance))
    return best, modes


def reach(evidence: Sequence[Evidence], vehicle: Vehicle, rng: np.random.Generator) -> Reached | None:
    """Join the relations of one drive with what was known of the vehicle; None where no relation can be used.

    Raises LinAlgError where no vehicle that is known of fits the relations.
    """
    known, stated = before_the_log(vehicle), stated_relations(vehicle)
    kept, dropped = counted(evidence, known)
    if not kept:
        return None
    whole, found = (*kept, *stated), []
    joint, modes = _modes(whole, known, rng)
    levelled = as_levelled(joint, vehicle)
    if levelled is not None:
        vehicle, known = levelled, before_the_log(levelled)
        joint, modes = _modes(whole, known, rng)
        found.append(LEVELLED)
    checks = before_tyres = check(joint)
    chance, stiff = rigid_chance(joint, whole, known)
    if chance > SURE:
        known, stiff = rigid(known), None
        joint, modes = _modes(whole, known, rng)
        checks = check(joint)
        found.insert(0, TEXT)
    elif stiff is not None and chance > HEARD:
        found.insert(0, OPEN.format(chance=chance))
    else:
        stiff = None
    return Reached(
        vehicle, known, kept, stated, dropped, joint, modes, checks, before_tyres, stiff, chance, tuple(found)
    )
