"""Command, version, seed, hashes and files: what it takes to make this report again."""

from __future__ import annotations

from pipelines.drive_results import DriveResults
from reports.blocks import Block, Fact, Facts
from reports.sections.contract import Plots
from reports.text import clean

MOST_LOGS = 30


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The chapter."""
    inputs = results.inputs
    rows = [
        Fact("Command", clean(inputs.command, 1500), code=True),
        Fact(
            "cogest",
            clean(inputs.version),
            f"made {clean(inputs.created_utc)} (UTC)" if inputs.created_utc else "",
        ),
        Fact("Seed", str(inputs.seed)),
    ]
    rows += [
        Fact("Log" if i == 0 else "", clean(log), code=True) for i, log in enumerate(inputs.logs[:MOST_LOGS])
    ]
    if len(inputs.logs) > MOST_LOGS:
        rows.append(Fact("", f"and {len(inputs.logs) - MOST_LOGS} more"))
    rows.append(Fact("SHA-256 of the log", clean(inputs.log_sha256), code=True))
    rows.append(
        Fact("Vehicle file", clean(inputs.vehicle) if inputs.vehicle else "none", code=bool(inputs.vehicle))
    )
    if inputs.vehicle_sha256:
        rows.append(Fact("SHA-256 of the vehicle file", clean(inputs.vehicle_sha256), code=True))
    rows.append(
        Fact(
            "Mapping file",
            clean(inputs.map) if inputs.map else "none: built-in profiles",
            code=bool(inputs.map),
        )
    )
    rows.append(
        Fact(
            "Settings file",
            clean(inputs.settings) if inputs.settings else "none: defaults",
            code=bool(inputs.settings),
        )
    )
    for place, dbc in enumerate(inputs.dbc[:MOST_LOGS]):
        rows.append(Fact("CAN databases" if place == 0 else "", clean(dbc), code=True))
    rows.append(
        Fact(
            "Forms of this report",
            "report.html, report.pdf and results.json, as they were asked for: the same results; the PDF leaves long tables to the others and says so",
        )
    )
    return (Facts(tuple(rows)),)
