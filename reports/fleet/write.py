"""Make the fleet report, and write it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import polars as pl

from parsers.errors import ReportError
from reports.files import make_folder, write_whole
from reports.fleet.facts import FleetFacts
from reports.fleet.view import view_of

FORMATS: dict[str, str] = {"html": "fleet.html", "pdf": "fleet.pdf"}
"""What may be asked for, and the file that it gives."""


def fleet_pages(
    tables: Mapping[str, pl.DataFrame], facts: FleetFacts, formats: Sequence[str] = tuple(FORMATS)
) -> dict[str, bytes]:
    """File name -> content, in the order of `FORMATS`; a table that is missing counts as empty.

    The same tables and facts give the same bytes. Raises ReportError on an unknown format, or where the PDF cannot be set.
    """
    unknown = [name for name in formats if name not in FORMATS]
    if unknown:
        raise ReportError(
            f"unknown format {unknown[0]!r}", hint=f"known are {', '.join(FORMATS)}", wrong_usage=True
        )
    view = view_of(tables, facts)
    made: dict[str, bytes] = {}
    if "html" in formats:
        from reports.fleet.page import html_page

        made[FORMATS["html"]] = html_page(view).encode("utf-8")
    if "pdf" in formats:
        from reports.fleet.paper import document_of
        from reports.pdf import pdf_of

        made[FORMATS["pdf"]] = pdf_of(document_of(view))
    return made


def write_fleet_report(
    tables: Mapping[str, pl.DataFrame],
    facts: FleetFacts,
    out: Path,
    formats: Sequence[str] = tuple(FORMATS),
) -> list[Path]:
    """Write fleet.html, fleet.pdf into `out` (made if needed), whole or not at all, and give their paths. Raises ReportError."""
    pages = fleet_pages(tables, facts, formats)
    make_folder(out)
    paths = []
    for name, content in pages.items():
        write_whole(out / name, content)
        paths.append(out / name)
    return paths
