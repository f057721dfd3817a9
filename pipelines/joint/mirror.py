"""The roll motion's two blind spots, said where its inertia was joined: the mirror solution, and the flat line between the two.

Its inertia term c = I/(m h) + h - z (Berntorp et al., equations (1)-(4), over m h) is the same for an arm h and for I/(m h), and next to
sqrt(I/m) it does not change with h at all: there the roll motion tells h by the springs alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from pipelines.models.roll import mirror_height

QUICK_ROLL = "quick_roll_motion"
"""Name in `Evidence.given` of a roll motion that was quick enough to tell its inertia."""

NAMED_WITH = ("roll_arm_m", "cg_height_m", "sprung_cg_height_m")
FLAT = (0.75, 1.33)
"""I/(m h²) within which the flat line is near: an error of c is three times as large in h at its ends, and larger between them."""

APART = 3.0
"""Standard deviations from which on an answer's interval leaves its mirror out."""


def mirror_words(sprung_mass_kg: float, roll_inertia_kgm2: float, arm_m: float, arm_std_m: float) -> str:
    """What the roll motion's inertia leaves open of the CG's height above the roll axis; empty where the figures are no vehicle's."""
    if min(sprung_mass_kg, roll_inertia_kgm2, arm_m) <= 0:
        return ""
    flat = math.sqrt(roll_inertia_kgm2 / sprung_mass_kg)
    other = mirror_height(arm_m, sprung_mass_kg, roll_inertia_kgm2)
    if FLAT[0] < (flat / arm_m) ** 2 < FLAT[1]:
        return (
            f"the roll motion's inertia hardly tells it: the arm above the roll axis is near sqrt(I/m) = {flat:.2f} m (the flat line), where "
            "I/(m h) + h does not change with h"
        )
    left = "what else is known leaves that out" if abs(other - arm_m) > APART * arm_std_m else "both are held"
    return f"by the roll motion's inertia an arm above the roll axis of {other:.2f} m (mirror solution) is the same as {arm_m:.2f} m; {left}"


def said_of_mirror(given: Mapping[str, float], told: Mapping[str, tuple[float, float]]) -> str:
    """The words of a joint posterior. given: what its relations hand on. told: value and spread of parameters by name."""
    if given.get(QUICK_ROLL, 0.0) == 0.0:
        return ""
    mass, inertia, arm = (told[name] for name in ("sprung_mass_kg", "roll_inertia_kgm2", "roll_arm_m"))
    return mirror_words(mass[0], inertia[0], *arm)
