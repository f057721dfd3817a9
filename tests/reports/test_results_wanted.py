"""What is asked of a table's file is what would have been chosen of the whole table."""

from __future__ import annotations

import itertools

import polars as pl
import pytest

from parsers.errors import StoreError
from pipelines.fleet.table_files import table_bytes, table_from
from pipelines.fleet.tables import table
from reports.results_export import chosen, wanted_rows

DRIVES = table(
    "drives",
    [
        {"drive_id": f"d{k}", "vehicle_id": vehicle, "vehicle_name": name, "status": status}
        for k, (vehicle, name, status) in enumerate(
            itertools.product(("a", "b"), ("Van", None), ("done", "error", "timeout"))
        )
    ],
)
PARAMETERS = table(
    "parameters",
    [
        {"drive_id": "d", "vehicle_id": vehicle, "parameter": name, "source": "drive", "status": "weak"}
        for vehicle, name in itertools.product(("a", "b"), ("mass_kg", "cg_height_m"))
    ],
)


def _both(whole: pl.DataFrame, name: str, **asked: tuple[str, ...]) -> tuple[pl.DataFrame, pl.DataFrame]:
    part = table_from(table_bytes(whole), name, "here", wanted_rows(name, **asked))
    return part, chosen(whole, name, **asked)


@pytest.mark.parametrize("vehicles", [(), ("a",), ("Van",), ("a", "b")])
@pytest.mark.parametrize("statuses", [(), ("done",), ("failed",), ("failed", "done"), ("error", "timeout")])
def test_drives(vehicles, statuses):
    part, all_of_it = _both(DRIVES, "drives", vehicles=vehicles, statuses=statuses)
    assert not part.is_empty()
    assert part.equals(all_of_it)


@pytest.mark.parametrize("parameters", [(), ("mass_kg",), ("mass_kg", "cg_height_m")])
@pytest.mark.parametrize("vehicles", [(), ("b",)])
def test_parameters(vehicles, parameters):
    part, all_of_it = _both(PARAMETERS, "parameters", vehicles=vehicles, parameters=parameters)
    assert part.equals(all_of_it)


def test_what_a_table_cannot_be_asked_is_left_to_chosen():
    assert wanted_rows("outliers", statuses=("done",)) is None
    with pytest.raises(StoreError, match="no column 'status'"):
        chosen(table("outliers", []), "outliers", statuses=("done",))
    assert wanted_rows("drives", statuses=("failed", "fialed")) is None
    with pytest.raises(StoreError, match=r"no status fialed .* there are done, error, .*, failed"):
        chosen(DRIVES, "drives", statuses=("failed", "fialed"))
    with pytest.raises(StoreError, match=r"there are identified, weak, not_identifiable$"):
        chosen(PARAMETERS, "parameters", statuses=("failed",))
    assert chosen(DRIVES, "drives", statuses=("memory",)).is_empty()
    assert wanted_rows("drives") is None


def test_other_columns_are_refused_before_rows_are_chosen():
    content = table_bytes(pl.DataFrame({"vehicle_id": ["a"]}))
    with pytest.raises(StoreError, match="not the columns"):
        table_from(content, "drives", "here", pl.col("status") == "done")
