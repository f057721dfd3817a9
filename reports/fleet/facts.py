"""What the fleet report is told besides the tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class FleetFacts:
    """About the batch and the store; all of it text or figures that identical batches share, but for `created`.

    folder: the fleet's folder, as asked for. store: where the results lie. version: cogest's. created: when the page was
    made, as text, or "". false_alarm_rate: share of pairs of drives with the same load in which a change of load would be
    told nonetheless; trend_false_alarm_rate: the same for drifts; None = not known. left_out: files below the folder that
    are no log or could not be used; left_out_named: each with its reason. gone: drives in the store whose logs are no more, where
    the table of drives does not say which. notes: sentences for the whole fleet. vehicle_notes: vehicle_id -> sentences.
    """

    folder: str
    store: str = ""
    version: str = ""
    created: str = ""
    false_alarm_rate: float | None = None
    trend_false_alarm_rate: float | None = None
    left_out: int = 0
    left_out_named: tuple[tuple[str, str], ...] = ()
    gone: int = 0
    notes: tuple[str, ...] = ()
    vehicle_notes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
