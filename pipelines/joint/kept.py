"""What a drive's relations told of the unknowns, as linear relations that can be stored and joined with other drives'.

At the posterior's mode a relation's whitened prediction is p(v) ≈ p(v₀) + J (v - v₀), so that its likelihood is that of
rows @ v = observed + N(0, I) with rows = J and observed = whitened figures - p(v₀) + J v₀. Turned by an orthogonal matrix
(QR), m figures of n unknowns become at most n rows with the same likelihood but for a constant.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipelines.joint.conflict import Check
from pipelines.joint.posterior import Joint, Part
from pipelines.results import FloatArray


@dataclass(frozen=True)
class KeptRelations:
    """A drive's relations, whitened and linear about its mode: rows @ values = observed + N(0, I).

    names: the k unknowns (`pipelines.joint.vehicle.unknowns.before_the_log`, then those that single relations have of their own).
    mean, std: (k,) before the log, SI. mode: (k,) with it. rows: (m, k) per SI unit; observed: (m,). relation, kind, source:
    (m,) of each row, its title, physics and estimator ("vehicle file": stated, no drive's own). given: measured figures
    that outputs need ("sag"). widened: relation -> factor on its standard deviations for a conflict, where above 1.
    inflation: factor on the drive's spreads for misfit as a whole, 1 or more. normal: whether the posterior was close to
    normal; where not, linear relations say less than the drive's own verdict did. told: parameter -> value and standard deviation that the
    drive leaves of it with all its doubts, whether or not its verdict shows them: one that a drive does not tell stands there with
    the figures that were known before. empty: the same of the vehicle's own figures (`pipelines.joint.vehicle.empty`). Both empty in files of
    earlier versions.
    """

    names: tuple[str, ...]
    mean: FloatArray
    std: FloatArray
    mode: FloatArray
    rows: FloatArray
    observed: FloatArray
    relation: tuple[str, ...]
    kind: tuple[str, ...]
    source: tuple[str, ...]
    given: Mapping[str, float]
    widened: Mapping[str, float]
    inflation: float
    normal: bool
    told: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    empty: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def less_sure(self, names: Collection[str], share: float) -> KeptRelations:
        """The same, where what is told of these parameters has that share of its value in its spread."""
        wider = {
            name: (value, math.hypot(std, share * value)) if name in names else (value, std)
            for name, (value, std) in self.told.items()
        }
        return replace(self, told=wider)


def _turned(part: Part) -> tuple[FloatArray, FloatArray]:
    """Slope (m, k) and residual (m,), turned so that rows beyond the rank are gone: their misfit is a constant."""
    used = np.flatnonzero(np.abs(part.slope).max(axis=0) > 0)
    if len(part.residual) <= len(used):
        return part.slope, part.residual
    q, r = np.linalg.qr(part.slope[:, used])
    slope = np.zeros((len(used), part.slope.shape[1]))
    slope[:, used] = r
    return slope, q.T @ part.residual


def kept_of(
    joint: Joint,
    checks: Sequence[Check],
    inflation: float,
    normal: bool,
    told: Mapping[str, tuple[float, float]],
    empty: Mapping[str, tuple[float, float]],
) -> KeptRelations:
    """The relations of a joint posterior in the form that is stored."""
    known = joint.known
    turned = [_turned(part) for part in joint.parts]
    width = len(known.names)
    slope = np.concatenate([s for s, _ in turned]) if turned else np.zeros((0, width))
    residual = np.concatenate([r for _, r in turned]) if turned else np.zeros(0)
    mode = known.mean + known.std * joint.u
    labels = [(p.evidence, len(r)) for p, (_, r) in zip(joint.parts, turned, strict=True)]
    widened: dict[str, float] = {}
    for check in checks:
        if check.record.widened > 1:
            widened[check.record.relation] = max(
                check.record.widened, widened.get(check.record.relation, 1.0)
            )
    rows = slope / known.std
    return KeptRelations(
        known.names, known.mean, known.std, mode, rows, residual + rows @ mode,
        tuple(e.title for e, n in labels for _ in range(n)),
        tuple(str(e.kind) for e, n in labels for _ in range(n)),
        tuple(e.source for e, n in labels for _ in range(n)),
        dict(joint.given), widened, inflation, normal, dict(told), dict(empty),
    )  # fmt: skip
