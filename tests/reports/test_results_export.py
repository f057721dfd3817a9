"""A store's tables for other programs: nothing in a cell runs in a spreadsheet, numbers stay whole, rows are the ones asked for."""

from __future__ import annotations

import csv
import io
import json

import polars as pl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.errors import StoreError
from pipelines.fleet.tables import TABLES, table
from reports.results_export import EXPORTS, chosen, csv_bytes, json_bytes, parquet_bytes
from tests.reports.sample_fleet import sample_fleet

TEXT = st.text(st.characters(exclude_categories=("Cs",)), max_size=20)


def read_csv(content: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(content.decode("utf-8"), newline="")))


def drives(**columns: object) -> pl.DataFrame:
    """One drive."""
    return table("drives", [{"drive_id": "d", "status": "done", "gone": False, **columns}])


@pytest.mark.parametrize("name", TABLES)
def test_every_table_in_every_form(name: str) -> None:
    rows = sample_fleet(12, 2)[name]
    assert pl.read_parquet(io.BytesIO(parquet_bytes(rows))).equals(rows)
    read = json.loads(json_bytes(rows))
    assert read == [json.loads(json.dumps(row)) for row in rows.to_dicts()]
    cells = read_csv(csv_bytes(rows))
    assert list(cells[0]) == list(TABLES[name])
    for column in (c for c, kind in TABLES[name].items() if kind == pl.Float64()):
        assert [float(cell[column]) if cell[column] else None for cell in cells] == rows[column].to_list()


@pytest.mark.parametrize(
    "text",
    [
        "=1+1",
        "+1",
        "-1",
        "@SUM(A1)",
        "\t=1",
        "\r=1",
        " =cmd|' /C calc'!A0",
        "\x00=1",
        "\u202e=1",
        "＝1",
        "\ufeff=1",
        "\n@x",
    ],
)
def test_no_cell_is_a_formula(text: str) -> None:
    rows = drives(drive=text, reason=text, notes=[text, "and more"])
    (cells,) = read_csv(csv_bytes(rows))
    for cell in (cells["drive"], cells["reason"], cells["notes"]):
        assert cell.startswith("'")
        assert cell.isprintable()
    (row,) = json.loads(json_bytes(rows))
    assert row["drive"] == text


def test_numbers_below_nought_stay_numbers() -> None:
    (cells,) = read_csv(csv_bytes(drives(least_margin_g=-0.1, wheel_lifts=0)))
    assert (cells["least_margin_g"], cells["wheel_lifts"], cells["duration_s"]) == ("-0.1", "0", "")


@settings(max_examples=100, deadline=None)
@given(TEXT, st.lists(TEXT, max_size=3))
def test_any_text(text: str, notes: list[str]) -> None:
    rows = drives(reason=text, notes=notes)
    (cells,) = read_csv(csv_bytes(rows))
    for cell in (cells["reason"], cells["notes"]):
        assert not cell.lstrip().startswith(("=", "+", "-", "@"))
        assert not any(ord(c) < 32 or ord(c) == 127 for c in cell)
    content = json_bytes(rows)
    assert content.isascii()
    assert (json.loads(content)[0]["reason"], json.loads(content)[0]["notes"]) == (text, notes)


def test_lists_are_joined() -> None:
    (cells,) = read_csv(csv_bytes(drives(logs=["a.csv", "b.csv"], notes=[])))
    assert (cells["logs"], cells["notes"]) == ("a.csv; b.csv", "")


def test_an_empty_table() -> None:
    empty = table("outliers", [])
    assert json.loads(json_bytes(empty)) == []
    assert csv_bytes(empty).decode().strip().split(",") == list(TABLES["outliers"])
    assert set(EXPORTS) == {"csv", "parquet", "json"}


def test_rows_of_a_vehicle_a_status_a_parameter() -> None:
    fleet = sample_fleet(40, 4, failed=0.3)
    found = chosen(fleet["drives"], "drives", vehicles=["van-01", "Delivery van 02"], statuses=["done"])
    assert sorted(found["vehicle_id"].unique()) == ["van-01", "van-02"]
    assert found["status"].unique().to_list() == ["done"]
    failed = chosen(fleet["drives"], "drives", statuses=["failed"])
    assert failed.height == fleet["drives"].height - fleet["drives"].filter(status="done").height > 0
    mass = chosen(fleet["parameters"], "parameters", parameters=["mass_kg"])
    assert mass["parameter"].unique().to_list() == ["mass_kg"]
    assert chosen(fleet["drives"], "drives").equals(fleet["drives"])


def test_what_is_not_there_is_said() -> None:
    fleet = sample_fleet(8, 2)
    with pytest.raises(StoreError, match=r"no vehicle van-77 in this table; there are van-00, van-01"):
        chosen(fleet["drives"], "drives", vehicles=["van-77"])
    with pytest.raises(StoreError, match="has no column 'parameter'"):
        chosen(fleet["drives"], "drives", parameters=["mass_kg"])
    with pytest.raises(StoreError, match="has no column 'status'"):
        chosen(fleet["trends"], "trends", statuses=["done"])
