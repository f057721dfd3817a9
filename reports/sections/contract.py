"""What a chapter is: an anchor, a title, and a function that gives its blocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pipelines.drive_results import DriveResults
from reports.blocks import Block, Plot

Plots = Mapping[str, tuple[Plot, ...]]
"""Drawn figures by the place that they belong to."""


@dataclass(frozen=True)
class SectionSpec:
    """One chapter. short: its name in the contents. build gives its blocks; none at all = it is left out."""

    anchor: str
    title: str
    short: str
    build: Callable[[DriveResults, Plots], tuple[Block, ...]]
    intro: str = ""
