"""On which of the vehicle file's figures an answer rests that the drive hardly checks: such a figure, if wrong, makes it wrong unseen.

The posterior's mean moves by (S g)ᵢ where the prior mean of unknown i moves by one of its standard deviations; S is the posterior's
covariance of the unknowns in standard deviations of what was known before, g the answer's gradient by them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from pipelines.joint.posterior import Joint
from pipelines.parameters import spread_text
from pipelines.results import FloatArray, ParameterEstimate

CHECKED = 0.8
"""Share of a stated figure's error that is left of it, or in an answer, from which on the drive is said to check it hardly."""

OFF = 0.1
"""How far off a stated figure is taken to be, as a share of it: as a rate of another spring, or read off another line of the sheet."""

MOVES = 1.5
"""Standard deviations by which so wrong a figure has to move an answer for it to be named."""

PART: Mapping[str, tuple[str, ...]] = {
    "cg_to_front_axle_m": ("empty_x",), "cg_height_m": ("empty_h",), "sprung_cg_height_m": ("empty_h",), "mass_kg": ("empty_mass",),
    "sprung_mass_kg": ("empty_mass",), **{f"corner_mass_{wheel}_kg": ("empty_x",) for wheel in ("fl", "fr", "rl", "rr")},
    "roll_center_height_m": ("roll_center_front", "roll_center_rear"),
}  # fmt: skip
"""Parameter -> the unknowns that hold the empty vehicle's part of it, which a wrong figure moves alike."""

OF_PART = "the empty vehicle's part is the file's {}, which this drive hardly checks"
OF_RATE = "{} in the file, which this drive hardly checks, would move it by {} if 10 % off"
_OF_RATE = re.compile(OF_RATE.replace("{}", r"(\w+)", 1).replace("{}", r"([^;]+?)", 1))
KEYS: tuple[str, ...] = (
    "mass_kg", "cg_height_m", "cg_to_front_axle_m", "roll_center_height_front_m and roll_center_height_rear_m"
)  # fmt: skip
"""Of the vehicle file, that such a part may be."""
RATES = ("spring_", "bar_")
"""Unknowns that figures of springs and bars state: what is read off a sheet, and carries what a log shows."""


def part_on_file(name: str, gradient: FloatArray, joint: Joint, stated: Mapping[str, str]) -> str:
    """The keys of the stated figures that go into a parameter nearly as the file has them; empty where the drive checks them, or the file
    does not state them all.

    gradient: (k,) by the unknowns. stated: unknown -> the file's key.
    """
    unknowns = PART.get(name, ())
    if not unknowns or any(unknown not in stated for unknown in unknowns):
        return ""
    rows = [joint.known.index(unknown) for unknown in unknowns]
    # standard deviations by which one and the same error of all of them moves each
    moved = joint.known.std[rows[0]] / joint.known.std[rows]
    unseen = float(moved @ gradient[rows])
    if unseen == 0:
        return ""
    left = float(moved @ (joint.covariance[rows] @ gradient)) / unseen
    return " and ".join(stated[unknown] for unknown in unknowns) if left > CHECKED else ""


def rate_on_file(
    gradient: FloatArray, std: float, joint: Joint, stated: Mapping[str, str]
) -> tuple[str, float]:
    """The key of the stated rate that moves an answer most if it is `OFF`, and by how much (0 where none does by `MOVES`).

    std: the answer's. Only rates that are after the drive about as open as before it: others the drive would contradict.
    """
    known, pulled = joint.known, joint.covariance @ gradient
    best, most = "", 0.0
    for unknown, key in stated.items():
        if not unknown.startswith(RATES):
            continue
        row = known.index(unknown)
        if math.sqrt(float(joint.covariance[row, row])) < CHECKED:
            continue
        moved = abs(float(pulled[row]) * OFF * float(known.mean[row] / known.std[row]))
        if moved > max(most, MOVES * std):
            best, most = key, moved
    return best, most


def rests_on(name: str, gradient: FloatArray, std: float, joint: Joint, stated: Mapping[str, str]) -> str:
    """In words for an answer's reason; empty where the drive checks what the file states, or the file states nothing."""
    part = part_on_file(name, gradient, joint, stated)
    rate, moved = rate_on_file(gradient, std, joint, stated)
    said = [OF_PART.format(part)] if part else []
    if rate:
        said.append(OF_RATE.format(rate, spread_text(moved)))
    return "; ".join(said)


def hanging_on(verdict: Mapping[str, ParameterEstimate]) -> dict[str, list[str]]:
    """The file's figures that answers hang on and the drive hardly checks: key -> the answers' names."""
    told = [entry for entry in verdict.values() if entry.status != "not_identifiable"]
    found = {key: [e.name for e in told if OF_PART.format(key) in e.reason] for key in KEYS}
    return {key: names for key, names in found.items() if names}


def moved_by(verdict: Mapping[str, ParameterEstimate]) -> dict[str, dict[str, str]]:
    """The file's rates that the drive hardly checks: key -> answer's name -> by how much a tenth of it moves that, as told."""
    found: dict[str, dict[str, str]] = {}
    for entry in verdict.values():
        said = None if entry.status == "not_identifiable" else _OF_RATE.search(entry.reason)
        if said is not None:
            found.setdefault(said[1], {})[entry.name] = said[2]
    return found
