"""The view of a store's tables: what is known, and that nothing odd in a table is taken for a figure."""

from __future__ import annotations

import math
from urllib.parse import unquote, urlsplit

import polars as pl
import pytest
from sample_fleet import empty_fleet, facts, sample_fleet, silent_fleet

from pipelines.fleet.tables import TABLES, table
from pipelines.hierarchy.changes import NOT_SEEN, OR_SPRINGS
from reports.blocks import Table
from reports.fleet.failures import groups_of, pattern_of
from reports.fleet.findings import findings_of
from reports.fleet.records import NEAR_G, FleetView
from reports.fleet.sections import OR_SPRINGS_SHORT, left_out, load_changes
from reports.fleet.view import href, moment, view_of
from reports.fleet.words import chance_text, spread_text


def badges(view: FleetView) -> list[str]:
    return [f.badge for f in findings_of(view)]


@pytest.mark.parametrize(
    ("stamp", "seconds"),
    [
        ("1970-01-02T00:00:00Z", 86_400),
        ("1970-01-02T02:00:00+02:00", 86_400),
        ("1970-01-02T00:00:00", 86_400),
        ("1970-01-02", 86_400),
        ("yesterday", None),
        ("", None),
        (None, None),
    ],
)
def test_a_start_is_read_in_its_own_zone(stamp: str | None, seconds: int | None) -> None:
    assert moment(stamp) == seconds


@pytest.mark.parametrize(
    "path",
    ["javascript:alert(1)", "//evil/x", "a b/ü#?.html", "c:\\x", "a\"'<>.html", "\ud800"],
)
def test_a_link_is_always_relative(path: str) -> None:
    link = href(path)
    assert link is not None
    parts = urlsplit(link)
    assert (parts.scheme, parts.netloc, parts.query, parts.fragment) == ("", "", "", "")
    assert not link.startswith("/")
    assert not set(link) & set("\"'<>: \\#?")


def test_a_link_leads_where_its_path_says() -> None:
    assert unquote(href("drives/ab/x ü/report.html") or "") == "drives/ab/x ü/report.html"
    assert href("../my store/drives/x/report.html") == "../my%20store/drives/x/report.html"
    assert href("https://host/a b/report.html") == "https://host/a%20b/report.html"
    assert [href(path) for path in ("s3://bucket/x.html", "javascript://x", "file:///x", "")] == [None] * 4
    assert href(None) is None


def test_what_is_not_identifiable_has_no_value(fleet: dict[str, pl.DataFrame]) -> None:
    answers = view_of(fleet, facts()).own["cg_height_m"]
    assert 3 in answers.status
    for value, status in zip(answers.value, answers.status, strict=True):
        assert math.isfinite(value) == (status in (1, 2))


def test_answers_stand_at_their_drives(fleet: dict[str, pl.DataFrame]) -> None:
    shuffled = {**fleet, "parameters": fleet["parameters"].sample(fraction=1.0, shuffle=True, seed=1)}
    view = view_of(shuffled, facts())
    rows = fleet["parameters"].filter((pl.col("parameter") == "mass_kg") & (pl.col("source") == "fleet"))
    known = dict(zip(rows["drive_id"], rows["value"], strict=True))
    found = {d.drive_id: v for d, v in zip(view.drives, view.joined["mass_kg"].value, strict=True) if v == v}
    assert found == known


def test_near_load_change_and_failure_are_counted(fleet: dict[str, pl.DataFrame]) -> None:
    view = view_of(fleet, facts())
    near = fleet["drives"].filter(
        (pl.col("least_margin_g") <= NEAR_G) | (pl.col("exceedance_probability") >= 0.05)
    )
    changed = fleet["load_changes"].filter("detected").height
    failed = fleet["drives"].filter(pl.col("status") != "done").height
    assert failed > 0
    assert changed > 0
    assert near.height > 0
    assert badges(view)[:3] == [f"{failed} failed", f"{near.height} near rollover", f"{changed} load changes"]


def test_the_false_alarm_rate_is_said(fleet: dict[str, pl.DataFrame]) -> None:
    said = " ".join(f.text for f in findings_of(view_of(fleet, facts(false_alarm_rate=0.005))))
    assert "False-alarm rate 0.5\u202f%" in said
    unsaid = " ".join(f.text for f in findings_of(view_of(fleet, facts(false_alarm_rate=None))))
    assert "False-alarm" not in unsaid


def test_an_empty_fleet_says_so() -> None:
    for tables in (empty_fleet(), {}):
        view = view_of(tables, facts(notes=()))
        assert badges(view) == ["none"]


def test_all_failed_is_no_other_finding() -> None:
    found = badges(view_of(sample_fleet(6, 2, failed=1.0), facts(notes=())))
    assert found[0] == "6 failed"
    assert not any("told" in badge for badge in found)


def test_nulls_everywhere_are_nothing_known() -> None:
    view = view_of(silent_fleet(), facts())
    assert len(view.drives) == 8
    assert {d.status for d in view.drives} == {"unknown"}
    assert all(d.start is None and d.href is None and not d.near for d in view.drives)


def test_a_vehicle_of_which_nothing_was_told_is_named() -> None:
    rows: list[dict[str, object]] = [
        {"drive_id": "a", "drive": "a.csv", "vehicle_id": "mute", "status": "done", "duration_s": 10.0}
    ]
    said = [f.text for f in findings_of(view_of({"drives": table("drives", rows)}, facts()))]
    assert any("Nothing could be told of 1 vehicle: mute" in text for text in said)


def test_drives_that_are_not_joined_are_named_with_the_reason(fleet: dict[str, pl.DataFrame]) -> None:
    alone = {
        "drives": fleet["drives"].with_columns(
            notes=pl.lit(["the drives of its vehicle could not be joined: no"])
        ),
        "parameters": fleet["parameters"].filter(pl.col("source") == "drive"),
    }
    said = {f.badge: f.text for f in findings_of(view_of(alone, facts()))}
    assert "The drives of 6 vehicles are not joined" in said["6 not joined"]
    assert said["6 not joined"].endswith("The drives of its vehicle could not be joined: no.")
    assert not any("not joined" in badge for badge in badges(view_of(fleet, facts())))


def test_trends_that_cannot_be_told_are_no_drift_and_no_absence_of_one(
    fleet: dict[str, pl.DataFrame],
) -> None:
    none = pl.lit(None, dtype=pl.Float64)
    untold = fleet["trends"].with_columns(
        per_year=none,
        low=none,
        high=none,
        detected=pl.lit(False),
        text=pl.lit("cannot be told: 2 drives with a date"),
    )
    said = {f.badge: f.text for f in findings_of(view_of({**fleet, "trends": untold}, facts()))}
    assert said["drifts not told"] == "Whether springs or dampers drift cannot be told: 2 drives with a date."
    assert "no drift" not in said


def test_loads_that_no_drive_sees_are_said_to_be_unknown(fleet: dict[str, pl.DataFrame]) -> None:
    unseen = fleet["load_changes"].with_columns(detected=pl.lit(False), text=pl.lit(NOT_SEEN))
    said = badges(view_of({**fleet, "load_changes": unseen}, facts()))
    assert "loads not told" in said
    assert "no load change" not in said


def test_a_change_that_springs_would_explain_says_so_in_the_table(fleet: dict[str, pl.DataFrame]) -> None:
    told = fleet["load_changes"].with_columns(text=pl.lit(f"about 185 kg more; {OR_SPRINGS}"))
    for changes, said in ((told, OR_SPRINGS_SHORT), (fleet["load_changes"], "")):
        (shown,) = load_changes(view_of({**fleet, "load_changes": changes}, facts()))
        assert isinstance(shown, Table)
        assert {row[2].sub for row in shown.rows} == {said}


def test_two_vehicles_of_one_name_are_told_apart() -> None:
    rows: list[dict[str, object]] = [
        {"drive_id": v, "drive": v, "vehicle_id": v, "vehicle_name": "Van", "status": "done"}
        for v in ("p", "q")
    ]
    assert [v.label for v in view_of({"drives": table("drives", rows)}, facts()).vehicles] == [
        "Van (p)",
        "Van (q)",
    ]


def test_missing_columns_are_not_known(fleet: dict[str, pl.DataFrame]) -> None:
    short = {**fleet, "drives": fleet["drives"].select("drive_id", "drive", "vehicle_id", "status")}
    view = view_of(short, facts())
    assert len(view.drives) == 60
    assert all(d.margin_g is None for d in view.drives)


def test_reasons_that_differ_in_names_are_one_group() -> None:
    a = pattern_of("/data/a b.csv: line 12: expected 4 columns, found 'x y'")
    assert a != pattern_of("timeout after 600 s")
    assert pattern_of("truck.csv, line 12: expected 4") == pattern_of("van_3.csv, line 77: expected 14")
    rows: list[dict[str, object]] = [
        {
            "drive_id": str(k),
            "drive": str(k),
            "vehicle_id": "v",
            "status": "error",
            "reason": f"x/{k}.csv: line {k}",
        }
        for k in range(5)
    ]
    rows.append({"drive_id": "t", "drive": "t", "vehicle_id": "v", "status": "timeout", "reason": "too long"})
    groups = groups_of(view_of({"drives": table("drives", rows)}, facts()).failed)
    assert [len(g.drives) for g in groups] == [5, 1]
    assert groups[0].example == "x/0.csv: line 0"


def test_figures_get_the_digits_of_their_spread() -> None:
    assert spread_text(30_164.0, 1400.0, "N/m") == "30\u202f200\u00a0±\u00a01400\u202fN/m"
    assert spread_text(None, 1.0) == "—"
    assert spread_text(math.nan, 1.0) == "—"
    assert chance_text(0.0) == "<\u00a00.01\u202f%"
    assert chance_text(0.034) == "3.4\u202f%"


def test_every_table_of_the_store_has_a_sample() -> None:
    assert set(sample_fleet(4, 1)) == set(TABLES)


def test_what_was_left_out_is_a_finding_and_a_table() -> None:
    named = (
        ("van/bad.csv", "no time column"),
        ("a.bin", "not a format"),
        ("b.bin", "not a format"),
        ("c", "x"),
    )
    view = view_of(sample_fleet(), facts(left_out=4, left_out_named=named))
    (found,) = [f for f in findings_of(view) if f.badge == "4 left out"]
    assert "4 files below the folder are in no drive: van/bad.csv: no time column; a.bin" in found.text
    assert found.text.endswith("and 1 more.")
    (block,) = left_out(view)
    assert isinstance(block, Table)
    assert [row[0].text for row in block.rows] == ["2", "1", "1"]
    assert block.rows[0][2].text == "a.bin"
    assert left_out(view_of(sample_fleet(), facts())) == ()


def test_a_start_of_unknown_time_zone_is_marked(fleet: dict[str, pl.DataFrame]) -> None:
    from reports.fleet.payload import payload

    starts = ["2024-05-01T10:00:00.000", *fleet["drives"]["start_utc"].to_list()[1:]]
    view = view_of({**fleet, "drives": fleet["drives"].with_columns(start_utc=pl.Series(starts))}, facts())
    assert view.drives[0].local
    assert view.drives[0].start == 1_714_557_600
    assert not any(d.local for d in view.drives[1:])
    assert payload(view)["drives"]["local"][:2] == "10"


def test_drives_that_do_not_fit_and_copies_are_findings_once(fleet: dict[str, pl.DataFrame]) -> None:
    ids = fleet["drives"]["drive_id"].to_list()
    apart = ["misfit" if k in (3, 12) else "copy" if k == 5 else None for k in range(len(ids))]
    marked = {**fleet, "drives": fleet["drives"].with_columns(apart=pl.Series(apart, dtype=pl.String))}
    view = view_of(marked, facts())
    said = [f for f in findings_of(view) if f.badge in ("2 do not fit", "1 copy")]
    misfit, copy = said
    assert misfit.tone == "warn"
    for k in (3, 12):
        assert f"{view.drives[k].name} ({view.vehicles[view.drives[k].vehicle].label})" in misfit.text
    assert "in a wrong folder?" in misfit.text
    assert view.drives[5].name in copy.text
    assert not any("fit" in f.badge for f in findings_of(view_of(fleet, facts())))
