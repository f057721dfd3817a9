"""The chapters that are figures only."""

from __future__ import annotations

from dataclasses import replace

from pipelines.drive_results import DriveResults
from reports.blocks import Block, Plot
from reports.sections.contract import Plots


def _alone(found: tuple[Plot, ...]) -> tuple[Block, ...]:
    """A chapter's only figure needs no title beside the chapter's."""
    return (replace(found[0], title=""),) if len(found) == 1 else found


def tracks(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """Estimates over the drive: the figures that were drawn, or why there is none."""
    found = plots.get("tracks", ())
    return _alone(tuple(plot for plot in found if plot.svgs) or found[:1])


def fits(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """Fits, residuals, further relations."""
    return plots.get("fits", ())


def signals(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """Signals."""
    return _alone(plots.get("signals", ()))
