"""Two channels whose scales contradict each other: said in the drive's record, and what hangs on them is no surer than that."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from parsers.drive import Decision, Drive
from pipelines.joint.kept import KeptRelations
from pipelines.prepare.decided import decided
from pipelines.results import ParameterEstimate
from pipelines.verdict.widened import by_share


@dataclass(frozen=True)
class ScaleDoubt:
    """off: by what share what hangs on it may be wrong. found, evidence: as in `Decision`. signal: whose record it is in; of: which results
    are marked."""

    off: float
    found: str
    evidence: str
    signal: str = "accel_y"
    of: str = "cornering"

    @property
    def decision(self) -> Decision:
        """As it stands in the import record: nothing was done about it."""
        action = (
            f"left as it is: the log does not tell which of them is wrong; results of {self.of} are marked"
        )
        return Decision(self.signal, "unit", self.found, action, self.evidence, applied=False)


def with_doubt(drive: Drive, doubt: ScaleDoubt | None) -> Drive:
    """The drive with what was found in its record."""
    return drive if doubt is None else decided(drive, [doubt.decision])


def kept_as_sure(
    kept: KeptRelations | None, doubt: ScaleDoubt | None, hanging: Collection[str]
) -> KeptRelations | None:
    """What a drive leaves of its parameters for others to be joined with, no surer than the scales that it rests on either."""
    return kept if kept is None or doubt is None else kept.less_sure(hanging, doubt.off)


def as_sure_as_the_scale(
    verdict: Mapping[str, ParameterEstimate], doubt: ScaleDoubt | None, hanging: Collection[str]
) -> dict[str, ParameterEstimate]:
    """The verdict, where the parameters that hang on it are no surer than the scales that they rest on."""
    if doubt is None:
        return dict(verdict)
    return {
        name: by_share(entry, doubt.off, doubt.found) if name in hanging else entry
        for name, entry in verdict.items()
    }
