"""Is it a figure of the vehicle file, and not the tyres or the sensors? Each group of stated figures opened by itself, and joined again.

Rigid tyres and deflections of a wrong scale explain much that wrong spring rates, a mass with the load in it or another vehicle's roll
centres explain as well. So where the drive speaks for one of the first, these are asked too, and compared as those are. As a doubt
(`doubts`) a figure moves answers along straight lines by five of its spreads; here it may be anything that a vehicle has.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipelines.evidence import Evidence, Values
from pipelines.joint.doubts.stated_figures import PLACE, TRACKS, chance_wrong, exact, not_as_stated
from pipelines.joint.file_check import ANYWHERE, BARS, LOAD, UNSPRUNG, of_any, stated_unknowns
from pipelines.joint.posterior import Joint, find_mode
from pipelines.joint.vehicle.unknowns import Known
from pipelines.joint.ways.rigid_tyres import log_odds
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

BRAKE_GAIN = "stated brake gain"
WHEELBASE = "stated wheelbase"
MEASURED = 0.003
"""Chance beforehand that a wheelbase is off by so much, which every sheet has to a millimetre: then the file is rather another vehicle's."""
OPEN: Mapping[str, tuple[float, float]] = {
    "stated mass": (0.25, 0.0),
    "stated spring rates": (0.4, 0.0),
    BARS: (0.4, 0.0),
    PLACE: (0.0, 0.25),
    "stated height of the CG": (0.25, 0.0),
    UNSPRUNG: (0.4, 0.0),
    "stated roll centres": (0.0, 0.12),
    TRACKS: (0.06, 0.0),
    WHEELBASE: (0.06, 0.0),
    "stated roll inertia": (0.3, 0.0),
    BRAKE_GAIN: (0.4, 0.0),
    LOAD: (0.0, 100.0),
}
"""Spread of a group's figures where they may be anything: share of the figure, and SI."""

FARTHEST = 3.5
"""Spreads of `OPEN` beyond which a figure is no vehicle's: something else is wrong then."""

BAR = 0.6
"""The same of a bar, over its axle's roll stiffness by springs: a nought may stand for a bar that nobody looked up."""

CARRIED = 0.15
"""The same of a load's mass, over the empty vehicle's."""


def opened(known: Known, names: Sequence[str], spread: tuple[float, float]) -> Known:
    """The unknowns with some of them open about what is stated; never narrower than they were."""
    std = known.std.copy()
    for name in names:
        row, least = known.index(name), spread[1]
        if name.startswith("bar_"):
            rate, track = (known.mean[known.index(f"{part}_{name[4:]}")] for part in ("spring", "track"))
            least = BAR * 0.5 * rate * track**2
        elif name == "load":
            least = max(least, CARRIED * float(known.mean[known.index("empty_mass")]))
        elif name in ANYWHERE:
            least = of_any(known, name)
        std[row] = max(std[row], spread[0] * abs(known.mean[row]), least)
    return replace(known, std=std)


INERTIA, FREED = "pitch_inertia", 6.0
"""The inertia that was known by the wheelbase, and how many of its spreads it is open by where that may be another."""


def with_the_length(known: Known, free: Known) -> tuple[Known, Evidence, float]:
    """With the wheelbase open: the pitch inertia goes by its square, as far as measured vehicles do.

    Unknowns that allow it, what binds both, and ln of the mass that the inertia's open prior lacks, the second factor being none of a prior.
    """
    std, row = free.std.copy(), known.index(INERTIA)
    std[row] *= FREED
    usual, length = float(known.mean[row]), float(known.mean[known.index("wheelbase")])
    spread = np.array([[(float(known.std[row]) / usual) ** 2]])

    def predict(values: Values) -> FloatArray:
        share = np.asarray(values[INERTIA]) / usual / (np.asarray(values["wheelbase"]) / length) ** 2
        return share[None] if share.ndim else np.array([share])

    bound = Evidence(
        "length", "vehicle file", "pitch inertia by the wheelbase", "vehicle file", np.ones(1), spread, predict,
        (INERTIA, "wheelbase"),
    )  # fmt: skip
    return replace(free, std=std), bound, 0.5 * math.log1p(FREED**2)


def joined_again(joint: Joint, evidence: Sequence[Evidence], known: Known, free: Known) -> Joint:
    """The posterior with some unknowns more open (`free`), searched from what is usual and from where it was with them as `known`."""
    start = joint.u.copy()
    spread = np.where(free.std > 0, free.std, 1.0)
    start[: len(known.names)] = (start[: len(known.names)] * known.std + known.mean - free.mean) / spread
    return find_mode(evidence, free, near=[start])


def elsewhere_known(known: Known, figures: Mapping[str, tuple[float, float]]) -> Known:
    """The unknowns with some of them where they are usual: name -> mean and standard deviation, SI."""
    mean, std = known.mean.copy(), known.std.copy()
    for name, (value, spread) in figures.items():
        mean[known.index(name)], std[known.index(name)] = value, spread
    return replace(known, mean=mean, std=std)


def file_ways(
    joint: Joint, evidence: Sequence[Evidence], known: Known, vehicle: Vehicle
) -> Iterator[tuple[str, float, Joint, Known, tuple[Evidence, ...]]]:
    """For each group that the file states: its title, ln odds with the log that it is wrong, the posterior with it open, unknowns, relations."""
    for title, names in stated_unknowns(vehicle).items():
        # what is stated without a spread is no unknown of the relations
        if exact(known, names):
            continue
        free, whole, lacking = opened(known, names, OPEN[title]), tuple(evidence), 0.0
        free = elsewhere_known(free, not_as_stated(title, vehicle))
        if title == WHEELBASE and vehicle.get("pitch_inertia_kgm2") is None:
            free, bound, lacking = with_the_length(known, free)
            whole = (*whole, bound)
        found = joined_again(joint, whole, known, free)
        if max(abs(found.u[known.index(n)]) for n in names) > FARTHEST:
            continue
        chance = MEASURED if title == WHEELBASE else chance_wrong(title, vehicle)
        yield title, log_odds(joint, found) + lacking + math.log(chance / (1 - chance)), found, free, whole
