"""A vehicle's drives whose relations are made by hand, linear, and what is true in each."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pipelines.hierarchy.common import RHO
from pipelines.hierarchy.own_outputs import outputs_at
from pipelines.hierarchy.records import DriveTold
from pipelines.joint.kept import KeptRelations
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import FloatArray, ParameterEstimate, Prior
from tests.pipelines.joint_parts import vehicle

KNOWN = before_the_log(vehicle())
SHOWN = ("mass_kg", "cg_height_m", "roll_stiffness_nmprad", "cg_lateral_offset_m")
SEES = {
    "weight": ("vertical", {"empty_mass": 1.0, "load": 1.0}, 12.0),
    "height": ("pitch", {"empty_h": 1.0, "load_h": 0.1, "load": 0.0003}, 0.012),
    "front springs": ("roll", {"spring_front": 1.0}, 300.0),
    "rear springs": ("roll", {"spring_rear": 1.0}, 300.0),
    "side": ("roll", {"empty_y": 1.0, "load_y": 0.1}, 0.006),
}
"""Relation -> kind, weights by unknown, standard deviation of its error."""


def kept(truth: dict[str, float], errors: FloatArray) -> KeptRelations:
    """Relations of a drive in which the unknowns are `truth`, linear. errors: (m,) in standard deviations."""
    rows = np.zeros((len(SEES), len(KNOWN.names)))
    for i, (_, weights, std) in enumerate(SEES.values()):
        for name, weight in weights.items():
            rows[i, KNOWN.index(name)] = weight / std
    at = np.array([truth[name] for name in KNOWN.names])
    observed = rows @ at + errors
    covariance = np.linalg.inv(np.diag(1 / KNOWN.std**2) + rows.T @ rows)
    mode = covariance @ (KNOWN.mean / KNOWN.std**2 + rows.T @ observed)
    kinds = tuple(kind for kind, _, _ in SEES.values())
    return KeptRelations(
        KNOWN.names, KNOWN.mean, KNOWN.std, mode, rows, observed, tuple(SEES), kinds, ("by hand",) * len(rows), {}, {},
        1.0, True,
    )  # fmt: skip


def verdict(relations: KeptRelations) -> dict[str, ParameterEstimate]:
    """A drive's own answers, and one that is no matter of relations."""
    covariance = np.linalg.inv(np.diag(1 / relations.std**2) + relations.rows.T @ relations.rows)
    values, gradients = outputs_at(relations.names, relations.mode, relations.std, {})
    before, slopes = outputs_at(relations.names, relations.mean, relations.std, {})
    found = {
        "roll_gradient_degpg": ParameterEstimate(
            "roll_gradient_degpg", 5.0, 0.1, 4.8, 5.2, "identified", "fitted"
        )
    }
    for name in SHOWN:
        std = float(np.sqrt(gradients[name] @ covariance @ gradients[name]))
        prior = Prior(before[name], float(np.linalg.norm(slopes[name] * relations.std)), "by hand")
        low, high = values[name] - 1.96 * std, values[name] + 1.96 * std
        found[name] = ParameterEstimate(
            name, values[name], std, low, high, "identified", "by hand", prior, None, ("me",)
        )
    return found


def fleet(count: int, seed: int = 1) -> tuple[list[DriveTold], list[dict[str, float]]]:
    """Drives of one vehicle with loads of their own, and what is true in each."""
    rng = np.random.default_rng(seed)
    same = dict(
        zip(
            KNOWN.names,
            (KNOWN.mean + KNOWN.std * rng.standard_normal(len(KNOWN.names))).tolist(),
            strict=True,
        )
    )
    # a stream of its own: how many unknowns there are moves none of these
    rng = np.random.default_rng([seed, 1])
    common = np.sqrt(RHO) * rng.standard_normal(len(SEES))
    drives, truths = [], []
    for day in range(count):
        load = {
            "load": 100 + 60 * rng.standard_normal(),
            "load_h": 0.9 + 0.2 * rng.standard_normal(),
            "load_y": 0.1,
        }
        truth = same | {name: float(value) for name, value in load.items()}
        relations = kept(truth, common + np.sqrt(1 - RHO) * rng.standard_normal(len(SEES)))
        drives.append(
            DriveTold(f"d{day:02d}", f"2024-03-{day + 1:02d}T07:00:00+00:00", verdict(relations), relations)
        )
        truths.append(truth)
    return drives, truths


def std_of(entry: ParameterEstimate) -> float:
    assert entry.std is not None
    return entry.std


def said(drive: DriveTold, name: str, **other: Any) -> DriveTold:
    """The drive with another entry for one parameter."""
    return replace(drive, verdict={**drive.verdict, name: replace(drive.verdict[name], **other)})
