"""What each part of the reproduction hands back."""

from __future__ import annotations

from dataclasses import dataclass

from pipelines.reproduce.base import Agreement, Claim, ReproducedTable
from pipelines.results import Trace


@dataclass(frozen=True)
class Part:
    """Tables, claims and figures of one section of the dissertation."""

    tables: tuple[ReproducedTable, ...] = ()
    claims: tuple[Claim, ...] = ()
    traces: tuple[Trace, ...] = ()


def agreement(holds: bool) -> Agreement:
    """In the page's words."""
    return "agrees" if holds else "differs"
