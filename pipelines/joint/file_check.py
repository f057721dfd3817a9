"""Does the vehicle file go with the log? What a figure that does not makes of the intervals.

Priors are relations like any other. For the unknowns of a stated figure, u in prior standard deviations at the mode and S their
posterior covariance, what the log says without that prior lies u / (1 - S) off it with the variance S / (1 - S), so that

    chi² = u' (I - S)⁻¹ u

in the directions that the log saw at all. An unknown may end a harmless 1.9 standard deviations off and still contradict the
log by 4, if the log pulls hard; springs that are too soft front and rear alike show in their sum.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from pipelines.joint.conflict import LIKELY, UNLIKELY, Check
from pipelines.joint.posterior import Joint
from pipelines.joint.vehicle.unknowns import Known
from pipelines.results import FloatArray, RelationCheck
from pipelines.vehicles.unheard_of import odd_axles
from pipelines.vehicles.vehicle import Vehicle

SEEN = 0.05
"""Share of a prior's variance that the log must have taken for a direction to count."""

LEFT = 0.04
"""Precision that is left to a prior in conflict: its spread five times as wide."""

SOURCE = "stated figures"

LIGHTER = "an empty mass above the laden one"
BARS = "stated anti-roll bars"
UNSPRUNG = "stated unsprung masses"
"""The group of axles' masses, which is asked for where no such vehicle has them: other errors of theirs move nothing but what is sprung."""
STATED: Mapping[str, Mapping[str, str]] = {
    "stated mass": {"mass_kg": "empty_mass"},
    "stated spring rates": {f"spring_rate_{a}_npm": f"spring_{a}" for a in ("front", "rear")},
    BARS: {f"anti_roll_stiffness_{a}_nmprad": f"bar_{a}" for a in ("front", "rear")},
    "stated place of the CG": {"cg_to_front_axle_m": "empty_x"},
    "stated height of the CG": {"cg_height_m": "empty_h"},
    "stated roll centres": {f"roll_center_height_{a}_m": f"roll_center_{a}" for a in ("front", "rear")},
    "stated tracks": {f"track_{a}_m": f"track_{a}" for a in ("front", "rear")},
    "stated wheelbase": {"wheelbase_m": "wheelbase"},
    "stated roll inertia": {"roll_inertia_kgm2": "roll_inertia"},
    "stated brake gain": {"brake_gain_nmppa": "brake_gain"},
}
"""Figures of the vehicle file that go wrong together, and the unknowns that hold them."""

LOAD = "stated load"
"""The group of the load: a driver who is not counted, a pallet that was left. What is aboard otherwise lies elsewhere, too."""
ANYWHERE: Mapping[str, tuple[float, str]] = {
    "load_x": (0.35, "wheelbase"), "load_y": (0.16, "track_front"), "load_h": (0.35, "empty_h")
}  # fmt: skip
"""Spread of a load's place where nobody says it, over what it is measured by."""

LOAD_PLACES: Mapping[str, str] = {"behind_front_axle_m": "load_x", "left_m": "load_y", "height_m": "load_h"}


def of_any(known: Known, name: str) -> float:
    """Spread of a load's place along one axis where nobody says it, m. name: its unknown."""
    share, of = ANYWHERE[name]
    return share * float(known.mean[known.index(of)])


def _unsure(vehicle: Vehicle, key: str) -> bool:
    """Whether the file states this of the load, and not as exact."""
    stated = vehicle.load.get(key)
    return stated is not None and stated.std > 0


def stated_unknowns(vehicle: Vehicle) -> dict[str, tuple[str, ...]]:
    """The unknowns of each group of figures that the vehicle file states; the load's as far as it is not stated as exact."""
    found = {
        title: tuple(unknown for key, unknown in figures.items() if vehicle.get(key) is not None)
        for title, figures in STATED.items()
    }
    if _unsure(vehicle, "mass_kg"):
        places = (unknown for key, unknown in LOAD_PLACES.items() if _unsure(vehicle, key))
        found[LOAD] = ("load", *places)
    found[UNSPRUNG] = tuple(f"unsprung_{axle}" for axle in odd_axles(vehicle))
    return {title: names for title, names in found.items() if names}


def misfit(u: FloatArray, covariance: FloatArray) -> tuple[float, int]:
    """chi² of k unknowns' priors against the log, u (k,) and covariance (k, k) at the mode, and its degrees of freedom."""
    taken, axes = np.linalg.eigh(np.eye(len(u)) - covariance)
    seen = taken > SEEN
    along = axes.T @ u
    return float(np.sum(along[seen] ** 2 / taken[seen])), int(seen.sum())


def worse_test(u: FloatArray, covariance: FloatArray) -> tuple[float, float, int]:
    """Probability, chi² and degrees of freedom of the worse of two tests: each figure by itself, and all wrong alike."""
    from scipy.stats import chi2 as law

    alike = np.ones((1, len(u))) / math.sqrt(len(u))
    both = (misfit(u, covariance), misfit(alike @ u, alike @ covariance @ alike.T))
    worse = min((float(law.sf(amount, n)) if n else 1.0, amount, n) for amount, n in both)
    # either of two may be as unlikely by chance
    return (worse[0] if len(u) == 1 else 1 - (1 - worse[0]) ** 2, *worse[1:])


def _released(joint: Joint, rows: list[int]) -> FloatArray:
    """(k,) what u moves by when the priors of these unknowns are given five times their spread."""
    curvature = np.linalg.inv(joint.covariance)
    pull = np.zeros(len(joint.u))
    pull[rows] = (1 - LEFT) * joint.u[rows]
    curvature[rows, rows] -= 1 - LEFT
    return np.asarray(np.linalg.solve(curvature, pull))


def _lighter_than_empty(joint: Joint, vehicle: Vehicle) -> tuple[Check, ...]:
    """Whether the log has the laden vehicle lighter than the file the empty one: no load is less than nothing.

    A load's prior is normal and holds such loads; its own misfit is no test, as a load three times the usual one is no contradiction.
    """
    from scipy.stats import chi2 as law

    row = joint.known.names.index("load")
    left = float(joint.covariance[row, row])
    if vehicle.get("mass_kg") is None or 1 - left < SEEN:
        return ()
    # without the load's own prior
    mean = joint.known.mean[row] + joint.known.std[row] * joint.u[row] / (1 - left)
    std = joint.known.std[row] * math.sqrt(left / (1 - left))
    amount = min(float(mean) / std, 0.0) ** 2
    probability = float(law.sf(amount, 1))
    if probability >= UNLIKELY:
        return ()
    wider = math.sqrt(amount / float(law.isf(LIKELY, 1)))
    record = RelationCheck(LIGHTER, SOURCE, 1, amount, probability, wider, "contradicts the log")
    # either the file is wrong, or what the log has of the mass: then nobody is aboard, and all else follows
    nobody = -float(joint.known.mean[row]) / float(joint.known.std[row])
    return (Check(record, joint.covariance[:, row] / left * (nobody - float(joint.u[row]))),)


def file_check(joint: Joint, vehicle: Vehicle) -> tuple[Check, ...]:
    """The stated figures that contradict the log, as relations in conflict; none where all go with it."""
    from scipy.stats import chi2 as law

    found = [*_lighter_than_empty(joint, vehicle)]
    for title, names in stated_unknowns(vehicle).items():
        rows = [joint.known.names.index(name) for name in names]
        probability, amount, count = worse_test(joint.u[rows], joint.covariance[np.ix_(rows, rows)])
        if probability >= UNLIKELY:
            continue
        wider = math.sqrt(amount / float(law.isf(LIKELY, count)))
        record = RelationCheck(title, SOURCE, count, amount, probability, wider, "contradicts the log")
        found.append(Check(record, _released(joint, rows)))
    return tuple(found)
