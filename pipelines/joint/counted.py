"""Which relations count: each physical relation once, however many estimators looked at it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.evidence import Evidence
from pipelines.joint.posterior import extended, part_at, whitener_of
from pipelines.joint.vehicle.unknowns import Known


def bits_of(evidence: Sequence[Evidence], known: Known) -> float:
    """Information that some relations bring to the prior, in bits, linearised at the prior's mean."""
    known = extended(known, evidence)
    u = np.zeros(len(known.names))
    total = np.eye(len(u))
    for e in evidence:
        total += part_at(e, known, u, whitener_of(e.covariance)).information
    return float(0.5 * np.linalg.slogdet(total)[1] / np.log(2))


def _sound(e: Evidence, known: Known) -> bool:
    """Whether its numbers can be used: some, a covariance that is one, a finite prediction at the prior's mean."""
    if len(e.observed) == 0:
        return False
    try:
        whitener = whitener_of(e.covariance)
    except np.linalg.LinAlgError:
        return False
    names = set(extended(known, (e,)).names)
    if not (np.isfinite(e.observed).all() and np.isfinite(whitener).all() and names.issuperset(e.unknowns)):
        return False
    whole = extended(known, (e,))
    part = part_at(e, whole, np.zeros(len(whole.names)), whitener)
    return bool(np.isfinite(part.residual).all() and np.isfinite(part.slope).all())


def counted(
    evidence: Sequence[Evidence], known: Known
) -> tuple[tuple[Evidence, ...], tuple[tuple[str, str], ...]]:
    """The relations to join, and (relation, why not) of the others.

    Of several estimators that used one relation (alike in kind and carrier) the one made for these signals is kept, or the
    one that tells the most.
    """
    kept: list[Evidence] = []
    dropped: list[tuple[str, str]] = []
    groups: dict[tuple[str, str], dict[str, list[Evidence]]] = {}
    for e in evidence:
        if _sound(e, known):
            groups.setdefault((e.kind, e.carrier), {}).setdefault(e.source, []).append(e)
        else:
            dropped.append((f"{e.title} ({e.source})", "its figures cannot be used"))
    for sources in groups.values():
        ranked = sorted(
            sources.values(), key=lambda entries: (not entries[0].dedicated, -bits_of(entries, known))
        )
        kept += ranked[0]
        for entries in ranked[1:]:
            first = ranked[0][0]
            better = (
                "is made for these signals" if first.dedicated and not entries[0].dedicated else "tells more"
            )
            why = f"the same relation as {first.title} of {first.source}, which {better}: counted once"
            dropped += [(f"{e.title} ({e.source})", why) for e in entries]
    return tuple(kept), tuple(dropped)
