"""A joint verdict made by hand: three relations, one in conflict, one left out, and what each taught."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipelines.results import (
    JointVerdict,
    Learned,
    NextMeasurement,
    Prior,
    RelationCheck,
    Share,
)

ROLL, PITCH, SAG = (
    "roll balance by spring deflections",
    "pitch balance by torques",
    "vertical balance by spring deflections",
)


def learned(name, prior, value, std, shares, following=()):
    """What was taught of a parameter, with normal densities before and after."""
    grid = np.linspace(prior.value - 4 * prior.std, prior.value + 4 * prior.std, 241)

    def density(mean, spread):
        return np.exp(-0.5 * ((grid - mean) / spread) ** 2) / (spread * np.sqrt(2 * np.pi))

    return Learned(
        name, prior, float(np.log2(prior.std / std)), shares, following, grid, density(prior.value, prior.std), density(value, std),
    )  # fmt: skip


def joint() -> JointVerdict:
    """The CG height from roll and braking, which disagree; the mass from the static deflections."""
    height = learned(
        "cg_height_m", Prior(0.551, 0.062, "measured vehicles"), 0.5581, 0.0286,
        (Share(ROLL, 0.61, 0.0437, 0.0312), Share(PITCH, 0.24, 0.0338, 0.0471), Share(SAG, 0.02, 0.029, 0.0611)),
        (
            NextMeasurement("a suspension deflection sensor on each wheel", 0.0143),
            NextMeasurement("braking 0.1 g harder", 0.0251),
        ),
    )  # fmt: skip
    mass = learned(
        "mass_kg", Prior(1563.0, 160.0, "vehicle file, with an unknown load"), 1563.0, 15.8,
        (Share(SAG, 3.1, 135.0, 17.1),), (NextMeasurement("weighing one axle", 9.0),),
    )  # fmt: skip
    offset = learned("cg_lateral_offset_m", Prior(0.0, 0.03, "cars are built nearly even"), 0.0, 0.0299, ())
    return JointVerdict(
        {"cg_height_m": height, "mass_kg": mass, "cg_lateral_offset_m": offset},
        (
            RelationCheck(ROLL, "roll_map", 3, 2.9, 0.41, 1.0, "agrees with all others"),
            RelationCheck(PITCH, "load_balance", 4, 31.7, 2.2e-6, 2.6, "the brake torques may be a tenth off"),
            RelationCheck(SAG, "load_balance", 4, float("nan"), float("nan"), 1.0, "nothing else weighs the vehicle"),
        ),
        (("roll balance by gyro", "load_balance sees the same relation by the better sensor"),),
        ("scale of the brake torques (3.1 standard deviations)",),
        "Laplace (Gauss-Newton, 7 steps)", 1.12, 0.84, ("tyres that do not give (odds 62%): the answers hold both",),
    )  # fmt: skip


def hostile_joint(text: str) -> JointVerdict:
    """The same with a text of an attacker wherever a name or a word may come from a file."""
    good = joint()
    prior = Prior(0.551, float("inf"), text)
    bad = Learned(
        "cg_height_m", prior, float("nan"), (Share(text, 1.0, float("nan"), float("inf")), Share(text, 0.4, 0.1, 0.1)),
        (NextMeasurement(text, 0.01), NextMeasurement(text, float("nan"))),
        np.array([0.0, np.nan, 2.0]), np.array([1.0, 1.0, 1.0]), np.array([0.0, 1.0, np.inf]),
    )  # fmt: skip
    return replace(
        good,
        learned={**good.learned, "cg_height_m": bad, text: replace(good.learned["mass_kg"], parameter=text, shares=bad.shares)},
        relations=(*good.relations, replace(good.relations[1], relation=text, source=text, text=text, probability=float("nan"))),
        not_counted=((text, text),), far=(text,), spoke_for=(text,), method=text, inflation=float("inf"),
    )  # fmt: skip
