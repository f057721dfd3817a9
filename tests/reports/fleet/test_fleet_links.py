"""Links of a fleet report that lies outside its store."""

from __future__ import annotations

from pathlib import Path

import polars as pl
import pytest

from reports.fleet.stored import check_fleet_formats, led_back


@pytest.mark.parametrize(
    ("place", "link"),
    [
        ("{tmp}/store", "../store/drives/3f/a/report.html"),
        ("https://host/store/", "https://host/store/drives/3f/a/report.html"),
    ],
)
def test_links_lead_back_to_the_store(tmp_path: Path, place: str, link: str) -> None:
    drives = pl.DataFrame({"drive": ["a", "b"], "report": ["drives/3f/a/report.html", None]})
    led = led_back(drives, place.replace("{tmp}", str(tmp_path)), tmp_path / "page")
    assert led.columns == drives.columns
    assert led["report"].to_list() == [link, None]


def test_formats_of_the_fleet_report() -> None:
    assert check_fleet_formats("pdf, html,json") == ("html", "pdf")
    assert check_fleet_formats("none") == ()
