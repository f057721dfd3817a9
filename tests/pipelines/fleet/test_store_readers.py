"""The store's tables are read by others as they were written: polars, DuckDB, pandas; and the examples of docs/store.md run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from pipelines.fleet.store import open_store
from pipelines.fleet.tables import TABLES
from tests.reports.sample_fleet import empty_fleet, sample_fleet

FLEET = sample_fleet(30, 3, failed=0.2, dated=0.8)
PAGE = Path(__file__).resolve().parents[3] / "docs" / "store.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a store in "store" and an empty one in "empty"."""
    root = tmp_path_factory.mktemp("readers")
    open_store(str(root / "store"), create=True).write_tables(FLEET)
    open_store(str(root / "empty"), create=True).write_tables(empty_fleet())
    return root


@pytest.mark.parametrize("name", TABLES)
def test_polars(folder: Path, name: str) -> None:
    assert pl.read_parquet(folder / "store" / f"{name}.parquet").equals(FLEET[name])
    assert open_store(str(folder / "store")).read_table(name).equals(FLEET[name])
    assert open_store(str(folder / "empty")).read_table(name).is_empty()


@pytest.mark.parametrize("name", TABLES)
def test_duckdb(folder: Path, name: str) -> None:
    duckdb = pytest.importorskip("duckdb")
    for place, tables in (("store", FLEET), ("empty", empty_fleet())):
        found = duckdb.sql(f"SELECT * FROM '{folder / place / name}.parquet'")
        assert found.columns == list(TABLES[name])
        assert found.fetchall() == tables[name].rows()


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("reader", ["pyarrow", "duckdb"])
def test_pandas(folder: Path, name: str, reader: str) -> None:
    pandas = pytest.importorskip("pandas")
    library = pytest.importorskip(reader)
    path = folder / "store" / f"{name}.parquet"
    found = pandas.read_parquet(path) if reader == "pyarrow" else library.sql(f"FROM '{path}'").df()
    assert list(found.columns) == list(TABLES[name])
    for column, kind in TABLES[name].items():
        expected = FLEET[name][column].to_list()
        if kind == pl.List(pl.String()):
            assert [list(cell) for cell in found[column]] == expected
        else:
            assert [None if pandas.isna(cell) else cell for cell in found[column]] == expected


def test_tables_are_the_same_bytes_each_time(folder: Path, tmp_path: Path) -> None:
    again = open_store(str(tmp_path / "store"), create=True)
    again.write_tables(FLEET)
    for name in TABLES:
        first = (folder / "store" / f"{name}.parquet").read_bytes()
        assert (tmp_path / "store" / f"{name}.parquet").read_bytes() == first


def test_tables_that_did_not_change_are_left_alone(tmp_path: Path) -> None:
    store = open_store(str(tmp_path / "store"), create=True)
    store.write_tables(FLEET)
    before = (tmp_path / "store" / "drives.parquet").stat().st_mtime_ns
    store.write_tables(FLEET)
    assert (tmp_path / "store" / "drives.parquet").stat().st_mtime_ns == before


def _blocks() -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("code", _blocks(), ids=lambda code: code.split()[1])
def test_the_pages_examples_run(folder: Path, monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    library = code.split()[1]
    pytest.importorskip("pyarrow" if library == "pandas" else library)
    pytest.importorskip(library)
    monkeypatch.chdir(folder)
    names: dict[str, Any] = {}
    exec(code, names)
    found = [names[name] for name in ("heaviest", "failed", "masses", "near") if name in names]
    assert found
    assert all(len(rows) > 0 for rows in found)


def test_the_page_tells_every_table_and_column() -> None:
    page = PAGE.read_text(encoding="utf-8")
    for name, columns in TABLES.items():
        (part,) = re.findall(rf"^### {name}\.parquet\n(.*?)(?=^##)", page, re.MULTILINE | re.DOTALL)
        for column in columns:
            assert f"`{column}`" in part, f"{name}: {column}"
