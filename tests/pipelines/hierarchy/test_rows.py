"""A vehicle's knowledge as rows of the store's tables: every column, nulls where there is nothing to say."""

from __future__ import annotations

import math

import polars as pl

from pipelines.fleet.tables import LOAD_CHANGES, OUTLIERS, PARAMETERS, TRENDS, VEHICLES, table
from pipelines.hierarchy.records import LoadChange, Outlier, Trend
from pipelines.hierarchy.rows import (
    change_rows,
    drive_rows,
    outlier_rows,
    parameter_rows,
    trend_rows,
    vehicle_rows,
)
from tests.pipelines.hierarchy.knowledge import estimate, knowledge

CHANGE = LoadChange(
    "d2", "d1", 0.001, True, {"mass_kg": (300.0, 20.0), "cg_height_m": (0.02, math.inf)}, "about 300 kg more"
)
TREND = Trend(
    "roll_damping_nmsprad", "Roll damping", "N·m·s/rad", -100.0, 20.0, -140.0, -60.0, 0.001, True,
    "2024-01-01T00:00:00+00:00", "2025-01-01T00:00:00+00:00", 12, "falls",
)  # fmt: skip
UNTOLD = Trend(
    "spring_rate_front_npm", "Springs", "N/m", *[math.nan] * 4, 1.0, False, "", "", 2, "cannot be told"
)
KNOWN = knowledge(
    "van-1",
    {"roll_stiffness_nmprad": estimate("roll_stiffness_nmprad", 80e3, 900.0, prior=(70e3, 9e3))},
    {
        "d2": {"mass_kg": estimate("mass_kg", 2000.0, 20.0, reference=1990.0)},
        "d1": {"mass_kg": estimate("mass_kg", None, None, status="not_identifiable")},
    },
    (CHANGE,),
    (TREND, UNTOLD),
)
STARTS = {"d1": None, "d2": "2024-05-01T08:00:00+00:00"}


def test_vehicle_rows() -> None:
    frame = table("vehicles", vehicle_rows(KNOWN, "Van"))
    assert frame.columns == list(VEHICLES)
    row = frame.row(0, named=True)
    assert (row["vehicle_id"], row["vehicle_name"], row["title"]) == ("van-1", "Van", "Roll stiffness")
    assert (row["value"], row["prior"], row["single_std"], row["drives"]) == (80e3, 70e3, None, 3)


def test_drive_rows() -> None:
    frame = table("parameters", drive_rows(KNOWN, STARTS))
    assert frame.columns == list(PARAMETERS)
    assert frame["drive_id"].to_list() == ["d1", "d2"]
    assert frame["source"].unique().to_list() == ["fleet"]
    assert frame["start_utc"].to_list() == [None, "2024-05-01T08:00:00+00:00"]
    assert frame["value"].to_list() == [None, 2000.0]
    assert frame["reference"].to_list() == [None, 1990.0]


def test_a_drives_own_verdict() -> None:
    rows = parameter_rows("van-1", "d2", None, "drive", KNOWN.drives["d2"])
    assert [row["source"] for row in rows] == ["drive"]


def test_change_rows() -> None:
    frame = table("load_changes", change_rows(KNOWN, STARTS))
    assert frame.columns == list(LOAD_CHANGES)
    row = frame.row(0, named=True)
    assert (row["drive_id"], row["before"], row["start_utc"]) == ("d2", "d1", STARTS["d2"])
    assert (row["mass_change_kg"], row["mass_change_std_kg"]) == (300.0, 20.0)
    # infinite: nothing is known of it; not there: nothing is said
    assert (row["cg_height_change_m"], row["cg_height_change_std_m"]) == (0.02, None)
    assert row["cg_lateral_change_m"] is None


def test_trend_rows() -> None:
    frame = table("trends", trend_rows(KNOWN))
    assert frame.columns == list(TRENDS)
    assert frame["parameter"].to_list() == ["roll_damping_nmsprad", "spring_rate_front_npm"]
    assert frame["per_year"].to_list() == [-100.0, None]
    assert frame["from_utc"].to_list() == ["2024-01-01T00:00:00+00:00", None]
    assert frame.select(pl.col(pl.Float64).is_nan().any()).row(0) == (False,) * 5


def test_outlier_rows() -> None:
    far = Outlier(2, "b", 1.0, 0.5, "mass_kg", 1.0, 2.0, 0.5, "far")
    first = Outlier(1, "a", 9.0, 0.0001, "mass_kg", 1.0, 2.0, math.nan, "farther")
    frame = table("outliers", outlier_rows([far, first], {"a": "Van"}))
    assert frame.columns == list(OUTLIERS)
    assert frame["vehicle_id"].to_list() == ["a", "b"]
    assert frame["vehicle_name"].to_list() == ["Van", None]
    assert frame["others_std"].to_list() == [None, 0.5]


def test_nothing_to_say_makes_empty_tables() -> None:
    silent = knowledge("v", {})
    for name, rows in (
        ("vehicles", vehicle_rows(silent, None)), ("parameters", drive_rows(silent, {})),
        ("load_changes", change_rows(silent, {})), ("trends", trend_rows(silent)), ("outliers", outlier_rows([], {})),
    ):  # fmt: skip
        assert table(name, rows).height == 0
