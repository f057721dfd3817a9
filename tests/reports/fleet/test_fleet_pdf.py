"""The fleet report on paper: what must be in it, what is left to the screen, and that odd fleets can be printed."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import polars as pl
import pytest
from sample_fleet import empty_fleet, facts, hostile_fleet, sample_fleet, silent_fleet

from parsers.errors import ReportError
from reports.blocks import Document, Paragraph, Plot, Table
from reports.fleet import paper
from reports.fleet.paper import MOST_DRIVES, by_importance, document_of
from reports.fleet.sections import MOST_PRINTED
from reports.fleet.view import view_of
from reports.fleet.write import fleet_pages, write_fleet_report


def document(tables: dict[str, pl.DataFrame]) -> Document:
    return document_of(view_of(tables, facts()))


def tables_of(doc: Document, anchor: str) -> list[Table]:
    section = next(s for s in doc.sections if s.anchor == anchor)
    return [b for b in section.blocks if isinstance(b, Table)]


@pytest.fixture(scope="module")
def large() -> Document:
    """A large fleet; two vehicles are drawn, which is enough to see that the others are not."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paper, "MOST_VEHICLES", 2)
        return document(sample_fleet(560, 14, seed=8, failed=0.02))


def test_the_vehicles_that_matter_come_first() -> None:
    view = view_of(sample_fleet(60, 6), facts())
    order = by_importance(view)
    near = [sum(view.drives[d].near for d in v.drives) for v in order]
    assert near == sorted(near, reverse=True)
    assert near[0] > 0
    calm = [v for v, n in zip(order, near, strict=True) if n == 0]
    assert calm[0].outlying or calm[0].drifts


def test_a_large_fleet_leaves_the_rest_to_the_screen(large: Document) -> None:
    pages = next(s for s in large.sections if s.anchor == "each-vehicle")
    assert sum(isinstance(b, Plot) for b in pages.blocks) == 2
    assert "The 2 that ask for attention most; 12 others in the HTML page." in pages.intro
    assert len(tables_of(large, "vehicles")[0].rows) == 14
    assert len(tables_of(large, "load-changes")[0].rows) == MOST_PRINTED
    assert re.search(r"\d+ more in load_changes.parquet", tables_of(large, "load-changes")[0].note)
    drives = next(s for s in large.sections if s.anchor == "drives")
    listed = tables_of(large, "drives")[0]
    assert len(listed.rows) <= MOST_DRIVES
    intro = drives.blocks[0]
    assert isinstance(intro, Paragraph)
    assert f"{len(listed.rows)} of 560 drives" in intro.text


def test_a_small_fleet_is_listed_whole() -> None:
    doc = document(sample_fleet(30, 3))
    assert len(tables_of(doc, "drives")[0].rows) == 30


def test_failures_stand_with_their_reasons() -> None:
    tables = sample_fleet(30, 3, seed=4, failed=0.4)
    rows = tables_of(document(tables), "failures")[0].rows
    failed = tables["drives"].filter(pl.col("status") != "done")
    assert sum(int(row[0].text) for row in rows) == failed.height > 5
    assert len(rows) == failed["status"].n_unique() > 2


@pytest.mark.parametrize(
    "tables",
    [
        empty_fleet(),
        silent_fleet(),
        hostile_fleet(),
        sample_fleet(4, 2, failed=1.0),
        sample_fleet(3, 1, dated=0.0),
    ],
    ids=["empty", "nulls", "hostile", "all failed", "no dates"],
)
def test_odd_fleets_are_set(tables: dict[str, pl.DataFrame], tmp_path: Path) -> None:
    paths = write_fleet_report(tables, facts(), tmp_path / "new" / "folder", ["pdf"])
    assert [p.name for p in paths] == ["fleet.pdf"]
    assert paths[0].read_bytes().startswith(b"%PDF")


@pytest.mark.skipif(shutil.which("pdftotext") is None, reason="no pdftotext on this machine")
def test_the_text_of_the_pdf(tmp_path: Path) -> None:
    fleet = sample_fleet(24, 3, failed=0.2)
    paths = write_fleet_report(fleet, facts(), tmp_path)
    assert [p.name for p in paths] == ["fleet.html", "fleet.pdf"]
    done = subprocess.run(["pdftotext", "-layout", str(paths[1]), "-"], capture_output=True, check=True)
    text = done.stdout.decode()
    pages = text.count("\f")
    assert 3 <= pages <= 8
    for words in (
        "Findings",
        "False-alarm rate",
        "Delivery van 02",
        "Outlying vehicles",
        "Drives that failed",
        "took too long",
        f"page 1 of {pages}",
    ):
        assert words in text
    assert fleet_pages(fleet, facts(), ["pdf"])["fleet.pdf"] == paths[1].read_bytes()


def test_an_unknown_format_is_refused() -> None:
    with pytest.raises(ReportError, match="unknown format 'docx'"):
        fleet_pages(empty_fleet(), facts(), ["html", "docx"])


def test_drives_without_a_date_stand_in_a_strip_at_the_right() -> None:
    from reports.fleet.vehicle_figure import _places, vehicle_plot

    view = view_of(sample_fleet(14, 1, dated=0.7, failed=0.0), facts())
    (vehicle,) = view.vehicles
    drives = list(vehicle.drives)
    undated = [d for d in drives if view.drives[d].start is None]
    assert undated
    places, days = _places(view, drives)
    assert days is not None
    assert places.keys() == set(drives)
    begin, end = days.strip
    assert days.last < begin < min(places[d] for d in undated)
    assert max(places[d] for d in undated) < end
    plot = vehicle_plot(view, vehicle, "v")
    assert f"In the strip at the right: {len(undated)} drive" in plot.caption
    assert "not drawn" not in plot.caption
    whole = view_of(sample_fleet(14, 1, dated=1.0, failed=0.0), facts())
    assert "strip" not in vehicle_plot(whole, whole.vehicles[0], "v").caption
