"""The fleet's page in a real browser: it sorts, filters, opens vehicles, its links lead to files, its console is silent."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from statistics import median

import polars as pl
import pytest
from browser import needs_browser, run
from sample_fleet import HOSTILE, empty_fleet, facts, sample_fleet, silent_fleet, tiled

from reports.fleet.view import href
from reports.fleet.write import fleet_pages
from reports.text import clean

pytestmark = needs_browser

SORTS = """
  await set("f-vehicle", "");
  const out = {};
  all(".pager select")[0].value = "500"; all(".pager select")[0].dispatchEvent(new Event("change"));
  for (const [name, column] of [["duration", 3], ["margin", 7], ["vehicle", 0], ["start", 2]]) {
    const head = all("#drives-table th")[column], button = head.querySelector("button");
    button.click();
    out[name] = [head.getAttribute("aria-sort"), cells(column)];
    button.focus(); button.click();
    out[name + "_down"] = [head.getAttribute("aria-sort"), cells(column)];
    out[name + "_sorted"] = all("#drives-table th[aria-sort=ascending], #drives-table th[aria-sort=descending]").length;
  }
  out.margins = drivesTable.kept.length;
  return out;
"""


def figures(texts: list[str]) -> list[float | None]:
    return [None if t == "—" else float(t.replace("\u2212", "-").replace("\u202f", "")) for t in texts]


def test_the_table_sorts_by_every_kind_of_column(fleet_html: str, tmp_path: Path) -> None:
    found, console = run(fleet_html, tmp_path, SORTS)
    assert console == []
    for name, word in (("margin", "ascending"), ("margin_down", "descending")):
        state, texts = found[name]
        assert state == word
        values = figures(texts)
        known = [v for v in values if v is not None]
        assert values == [*sorted(known, reverse=word == "descending"), *[None] * (len(values) - len(known))]
        assert None in values
        assert len(known) > 20
    starts = found["start_down"][1]
    assert starts == sorted(starts, reverse=True)
    assert found["vehicle"][1] == sorted(found["vehicle"][1])
    assert found["start_sorted"] == 1


def test_numbers_sort_as_numbers_not_as_text(fleet: dict[str, pl.DataFrame], tmp_path: Path) -> None:
    kilos = {
        **fleet,
        "drives": fleet["drives"].with_columns(pl.Series("duration_s", [9.0, 100.0, 20.0] * 20)),
    }
    html = fleet_pages(kilos, facts(), ["html"])["fleet.html"].decode()
    found, _ = run(
        html,
        tmp_path,
        "all('#drives-table th button')[3].click(); drivesTable.size = 500; drivesTable.show(); return cells(3);",
    )
    assert found == ["9\u202fs"] * 20 + ["20\u202fs"] * 20 + ["100\u202fs"] * 20


FILTERS = """
  const count = () => drivesTable.kept.length, said = () => document.getElementById("f-count").textContent, out = {};
  out.all = count();
  await set("f-text", "van-03 drive_0004"); out.text = count(); out.said = said();
  await set("f-text", ""); await set("f-vehicle", "2"); out.vehicle = count();
  await set("f-vehicle", ""); await set("f-status", "failed"); out.failed = count(); out.reasons = all("#drives-table .why").length;
  document.getElementById("f-clear").click(); out.cleared = count();
  await set("f-only", "changed"); out.changed = count();
  await set("f-only", ""); await set("f-margin-high", "0.3"); out.near = count();
  await set("f-margin-low", "0.25"); out.between = count();
  await set("f-text", "no such drive"); out.none = [count(), all("#drives-table tbody tr").length, all("#drives-table tbody td")[0].textContent];
  document.querySelector("button[data-show=changed]").click(); out.shown = count();
  out.csv = csvOf(drivesTable.kept);
  return out;
"""


def test_the_filters_and_the_download(
    fleet: dict[str, pl.DataFrame], fleet_html: str, tmp_path: Path
) -> None:
    found, console = run(fleet_html, tmp_path, FILTERS)
    assert console == []
    rows = fleet["drives"]
    margin = rows["least_margin_g"].round(3)
    changed = fleet["load_changes"].filter("detected")
    assert found["all"] == found["cleared"] == rows.height
    assert found["text"] == 1
    assert found["said"] == "1 of 60 drives"
    assert found["vehicle"] == rows.filter(pl.col("vehicle_id") == "van-02").height
    assert found["failed"] == found["reasons"] == rows.filter(pl.col("status") != "done").height > 0
    assert found["changed"] == found["shown"] == changed.height > 0
    assert found["near"] == (margin <= 0.3).sum() > 0
    assert found["between"] == ((margin <= 0.3) & (margin >= 0.25)).sum()
    assert found["none"] == [0, 1, "No drive passes these filters."]
    exported = list(csv.DictReader(io.StringIO(found["csv"])))
    assert {row["drive"] for row in exported} == set(
        rows.filter(pl.col("drive_id").is_in(changed["drive_id"].implode()))["drive"]
    )
    assert all(
        float(row["cg_height_m_low"]) < float(row["cg_height_m"]) for row in exported if row["cg_height_m"]
    )


def test_links_lead_to_the_drives_reports(tmp_path: Path) -> None:
    tables = sample_fleet(3, 1, failed=0.0)
    odd = ["drives/a b/ü#1?.html", "drives/x/%41.html", "drives/plain/report.html"]
    tables["drives"] = tables["drives"].with_columns(pl.Series("report", odd))
    for name in odd:
        place = tmp_path / name
        place.parent.mkdir(parents=True)
        place.write_text("<!doctype html><title>x</title>", encoding="utf-8")
    html = fleet_pages(tables, facts(), ["html"])["fleet.html"].decode()
    found, console = run(html, tmp_path, "return all('#drives-table tbody a').map((a) => a.href);")
    assert console == []
    assert found == [(tmp_path / name).as_uri() for name in odd]
    assert [href(name) for name in odd] == [link.removeprefix(tmp_path.as_uri() + "/") for link in found]


VEHICLE = """
  const button = all("#vehicles-table .opener").find((b) => b.textContent === "Delivery van 02");
  const before = button.getAttribute("aria-expanded");
  button.click(); await settle();
  const detail = document.getElementById(button.getAttribute("aria-controls"));
  const out = {
    before, after: button.getAttribute("aria-expanded"), title: detail.querySelector("h3").textContent,
    charts: all("svg.chart[role=img]", detail).map((s) => s.getAttribute("aria-label")), points: all("circle.s1, circle.s2", detail).length,
    changes: all("g.changed line", detail).length, links: all("svg a", detail).map((a) => a.getAttribute("href")),
    text: detail.textContent, wide: detail.scrollWidth <= document.documentElement.clientWidth,
    broken: all("svg *", detail).filter((n) => [...n.attributes].some((a) => /NaN|undefined|Infinity/.test(a.value))).length,
  };
  button.click(); out.closed = document.getElementById(button.getAttribute("aria-controls")) === null;
  drivesTable.size = 500; drivesTable.show();
  all("#drives-table .link").find((b) => b.textContent === "Delivery van 04").click(); await settle();
  out.other = all("#vehicles-table .vehicle h3").map((h) => h.textContent);
  return out;
"""


@pytest.mark.parametrize("width", [1400, 420])
def test_a_vehicle_opens(fleet: dict[str, pl.DataFrame], fleet_html: str, tmp_path: Path, width: int) -> None:
    found, console = run(fleet_html, tmp_path, VEHICLE, width)
    assert console == []
    assert (found["before"], found["after"], found["closed"]) == ("false", "true", True)
    assert found["title"] == "Delivery van 02"
    assert len(found["charts"]) == 5 + 4
    assert found["broken"] == 0
    assert found["wide"]
    own = fleet["drives"].filter((pl.col("vehicle_id") == "van-02") & (pl.col("status") == "done"))
    changes = fleet["load_changes"].filter((pl.col("vehicle_id") == "van-02") & pl.col("detected"))
    assert found["points"] >= 4 * own.height
    assert found["changes"] == 4 * changes.height
    assert set(found["links"]) == set(own["report"])
    for words in (
        "Front spring rate",
        "Sharper than one drive",
        "falls: -16.0 % a year",
        "Not identifiable from its drives",
    ):
        assert words in found["text"]
    assert found["other"] == ["Delivery van 04"]


def test_hostile_text_stays_text(hostile_fleet_html: str, tmp_path: Path) -> None:
    script = """
      all("#vehicles-table .opener").forEach((button) => button.click()); await settle();
      return { names: all("#drives-table tbody tr").map((row) => row.children[1].textContent), images: all("img").length, bold: all("b").map((b) => b.textContent),
        scripts: all("script").length, links: all("#drives-table a").map((a) => a.protocol), csv: csvOf(drivesTable.order), vehicles: all(".vehicle").length };
    """
    found, console = run(hostile_fleet_html, tmp_path, script)
    assert console == []
    assert found["names"][0] == HOSTILE[0]
    assert found["names"][1] == clean(HOSTILE[1])
    assert found["images"] == 0
    assert found["scripts"] == 3
    assert set(found["links"]) == {"file:"}
    assert found["vehicles"] == 3
    assert "\n=" not in found["csv"]
    assert not any(
        field.startswith(("=", "@")) for row in csv.reader(io.StringIO(found["csv"])) for field in row
    )


@pytest.mark.parametrize(
    "tables",
    [empty_fleet(), silent_fleet(), sample_fleet(5, 2, failed=1.0), sample_fleet(1, 1, failed=0.0), sample_fleet(14, 2, dated=0.6)],
    ids=["empty", "nulls", "all failed", "one drive", "some without a date"],
)  # fmt: skip
def test_odd_fleets_open_without_an_error(tables: dict[str, pl.DataFrame], tmp_path: Path) -> None:
    html = fleet_pages(tables, facts(), ["html"])["fleet.html"].decode()
    script = """
      all("#vehicles-table .opener[aria-expanded=false]").forEach((button) => button.click()); await settle();
      all("th button").forEach((button) => { button.click(); button.click(); }); await settle();
      return { vehicles: all(".vehicle").length, broken: all("svg *").filter((n) => [...n.attributes].some((a) => /NaN|undefined|Infinity/.test(a.value))).length };
    """
    found, console = run(html, tmp_path, script)
    assert console == []
    assert found["vehicles"] == tables["drives"]["vehicle_id"].n_unique()
    assert found["broken"] == 0


def test_ten_thousand_drives_do_not_freeze_it(tmp_path: Path) -> None:
    html = fleet_pages(tiled(sample_fleet(1000, 10), 10), facts(), ["html"])["fleet.html"].decode()
    script = """
      const took = (work) => { const begin = performance.now(); work(); return performance.now() - begin; };
      const out = { rows: all("#drives-table tbody tr").length };
      out.text = took(() => drivesTable.sortBy(1, true)); out.number = took(() => drivesTable.sortBy(4));
      document.getElementById("f-text").value = "van-07"; out.filter = took(filterDrives); out.kept = drivesTable.kept.length;
      return out;
    """
    found, console = run(html, tmp_path, script)
    assert console == []
    assert found["rows"] == 25
    assert found["kept"] == 1000
    assert max(found["text"], found["number"], found["filter"]) < 2000


@pytest.mark.parametrize("drives", [7, 8])
def test_a_vehicles_figure_is_the_median_of_its_drives(tmp_path: Path, drives: int) -> None:
    html = fleet_pages(sample_fleet(drives, 1), facts(), ["html"])["fleet.html"].decode()
    script = """
      const value = valueOf("mass_kg"), v = Object.keys(OF_VEHICLE)[0];
      return { range: rangeOfVehicle(v, "mass_kg", value), all: OF_VEHICLE[v].map(value).filter(known) };
    """
    found, _ = run(html, tmp_path, script)
    assert len(found["all"]) > 3
    assert found["range"] == pytest.approx([min(found["all"]), median(found["all"]), max(found["all"])])
