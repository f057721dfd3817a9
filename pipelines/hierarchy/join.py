"""All drives of a vehicle joined: their order, which go together, and the posterior, made linear where they ended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime

import numpy as np

from pipelines.hierarchy.common import RHO
from pipelines.hierarchy.parts import Source, make_parts
from pipelines.hierarchy.posterior import VehiclePosterior, solve
from pipelines.hierarchy.records import DriveTold
from pipelines.hierarchy.robust import Misfit, Weighed, weigh

CURVED = 2.0
"""Factor on the errors of a drive whose posterior is not normal: linear relations say less than its own verdict did."""

ROUNDS = 2
"""Times that the relations are made linear anew."""


@dataclass(frozen=True)
class Joined:
    """drives: all, in order of time. posterior: of those that go together; None where nothing was to be joined.

    sources: of the posterior's drives. widened: drive -> factor on its errors. left_out: drive -> its misfit. apart:
    whether the drives contradict each other so that each stands on its own. other_sensors: drives that go with the others
    only with sensors of their own, and how they did before.
    """

    drives: tuple[DriveTold, ...]
    posterior: VehiclePosterior | None
    sources: tuple[Source, ...]
    widened: dict[str, float]
    left_out: dict[str, Misfit]
    apart: bool
    rho: float = RHO
    other_sensors: Mapping[str, Misfit] = field(default_factory=dict)


def when(drive: DriveTold) -> tuple[bool, float, str]:
    """Sorts drives by time; those without a time come last, by name."""
    try:
        at = datetime.fromisoformat(drive.start_utc or "")
    except ValueError:
        return True, 0.0, drive.drive_id
    at = at if at.tzinfo is not None else at.replace(tzinfo=UTC)
    return False, at.timestamp(), drive.drive_id


def usable(drive: DriveTold) -> bool:
    """Whether a drive has relations of its own, in figures."""
    kept = drive.kept
    return (
        kept is not None
        and any(source != "vehicle file" for source in kept.source)
        and all(
            bool(np.isfinite(x).all()) for x in (kept.rows, kept.observed, kept.mean, kept.std, kept.mode)
        )
    )


def joined(drives: Sequence[DriveTold], rho: float = RHO) -> Joined:
    """Join the drives of one vehicle, whatever their order. A drive without relations stays out."""
    ordered = tuple(sorted(drives, key=when))
    sources = [
        Source(d.drive_id, d.kept, max(1.0, d.kept.inflation) * (1.0 if d.kept.normal else CURVED))
        for d in ordered
        if d.kept is not None and usable(d)
    ]
    if not sources:
        return Joined(ordered, None, (), {}, {}, False, rho)
    if len(sources) == 1:
        return Joined(ordered, solve(*make_parts(sources, rho)), tuple(sources), {}, {}, False, rho)
    found: Weighed = weigh(sources, rho)
    if found.posterior is None:
        return Joined(ordered, None, (), {}, found.left_out, True, rho)
    kept, posterior = found.sources, found.posterior
    for _ in range(ROUNDS):
        kept = tuple(replace(s, place=posterior.mean(i)) for i, s in enumerate(kept))
        posterior = solve(*make_parts(kept, rho))
    return Joined(ordered, posterior, kept, found.widened, found.left_out, False, rho, found.other_sensors)
