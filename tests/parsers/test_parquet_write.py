"""Tables written as Parquet read back equal with three readers that share no code with the writer."""

from __future__ import annotations

from contextlib import closing
from itertools import pairwise

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pyarrow.parquet as pq
import pytest

from parsers import parquet_write
from parsers.parquet_pages import DOUBLE, INT64, differences, pack_column
from parsers.parquet_thrift import BINARY, I32, I64, LIST, Thrift, varint
from parsers.parquet_write import PackedAhead, kinds_of, write_pieces, write_tables

LOW, HIGH = -(2**63), 2**63 - 1
STAMPS = {
    "none": [],
    "one": [7],
    "two": [7, 8],
    "an even clock": list(range(0, 10**9, 10**7)),
    "a block and its neighbours": list(range(127)),
    "a whole block": list(range(129)),
    "one more than a block": list(range(130)),
    "still": [5] * 1000,
    "steps as wide as there are": [LOW, HIGH, LOW, 0, HIGH, -1],
    "backwards": [3, 2, 1, 0, -1],
    "steps of 62 bits": [5, 2**62, -(2**62), 7],
}


def read_by_all(path):
    """The columns of a file, as pandas' reader, polars and DuckDB have them."""
    pandas = pd.read_parquet(path)
    duck = duckdb.sql(f"select * from '{path}'").df()
    frame = pl.read_parquet(path)
    yield {name: pandas[name].to_numpy() for name in pandas}
    yield {name: duck[name].to_numpy() for name in duck}
    yield {name: frame[name].to_numpy() for name in frame.columns}


@pytest.mark.parametrize("case", STAMPS)
def test_whole_numbers_read_back(tmp_path, case):
    stamps = np.array(STAMPS[case], dtype=np.int64)
    write_tables([(tmp_path / "t.parquet", {"time_ns": stamps})])
    for columns in read_by_all(tmp_path / "t.parquet"):
        assert columns["time_ns"].dtype == np.int64
        assert columns["time_ns"].tolist() == stamps.tolist()


@pytest.mark.parametrize("width", range(64))
def test_steps_of_every_width_read_back(tmp_path, width):
    rng = np.random.default_rng(width)
    steps = rng.integers(0, 1 << width, 300, dtype=np.uint64, endpoint=width == 0)
    stamps = np.cumsum(steps, dtype=np.uint64).view(np.int64)
    write_tables([(tmp_path / "t.parquet", {"time_ns": stamps})])
    assert pl.read_parquet(tmp_path / "t.parquet")["time_ns"].to_list() == stamps.tolist()


@pytest.mark.parametrize("rows", [1, 7, 8, 9, 1000])
def test_numbers_and_empty_cells_read_back(tmp_path, rows):
    rng = np.random.default_rng(rows)
    full = rng.normal(size=rows) * 10.0 ** rng.integers(-300, 300, rows)
    holey = np.where(rng.random(rows) < 0.5, np.nan, full)
    table = {
        "time_ns": np.arange(rows, dtype=np.int64),
        "full": full,
        "holey": holey,
        "empty": np.full(rows, np.nan),
        "infinite": np.where(full > 0, np.inf, -np.inf),
        "every second": np.repeat(full, 2)[::2],
    }
    write_tables([(tmp_path / "t.parquet", table)])
    for columns in read_by_all(tmp_path / "t.parquet"):
        assert list(columns) == list(table)
        for name, values in table.items():
            assert np.array_equal(columns[name], values, equal_nan=name != "time_ns")
    assert pl.read_parquet(tmp_path / "t.parquet")["holey"].null_count() == np.isnan(holey).sum()


def test_long_tables_are_written_in_groups_of_rows(tmp_path, monkeypatch):
    monkeypatch.setattr(parquet_write, "MOST_ROWS", 300)
    values = np.random.default_rng(3).normal(size=1000)
    long = {"time_ns": np.arange(1000, dtype=np.int64), "v": values}
    short = {"time_ns": np.arange(5, dtype=np.int64), "w": values[:5]}
    write_tables([(tmp_path / "long.parquet", long), (tmp_path / "short.parquet", short)])
    about = pq.ParquetFile(tmp_path / "long.parquet").metadata
    assert [about.row_group(k).num_rows for k in range(about.num_row_groups)] == [300, 300, 300, 100]
    assert pl.read_parquet(tmp_path / "long.parquet")["v"].to_list() == values.tolist()
    assert pl.read_parquet(tmp_path / "short.parquet")["w"].to_list() == values[:5].tolist()


def test_pieces_become_one_table(tmp_path):
    values = np.random.default_rng(4).normal(size=1000)
    whole = {"time_ns": np.arange(1000, dtype=np.int64), "v": values}
    cuts = [0, 3, 400, 410, 1000]
    pieces = ({name: each[a:b] for name, each in whole.items()} for a, b in pairwise(cuts))
    write_pieces(pieces, tmp_path / "t.parquet", {"time_ns": INT64, "v": DOUBLE}, least_bytes=6000)
    frame = pl.read_parquet(tmp_path / "t.parquet")
    assert frame["time_ns"].to_list() == list(range(1000))
    assert frame["v"].to_list() == values.tolist()
    about = pq.ParquetFile(tmp_path / "t.parquet").metadata
    assert [about.row_group(k).num_rows for k in range(about.num_row_groups)] == [400, 600]


def test_a_table_of_no_pieces_has_its_columns(tmp_path):
    write_pieces(iter([]), tmp_path / "t.parquet", {"time_ns": INT64, "v": DOUBLE})
    assert pl.read_parquet(tmp_path / "t.parquet").schema == {"time_ns": pl.Int64, "v": pl.Float64}


def test_the_table_of_contents_tells_codec_and_extent(tmp_path):
    table = {"time_ns": np.array([3, 9, 4], dtype=np.int64), "v": np.array([np.nan, -2.5, 7.0])}
    write_tables([(tmp_path / "t.parquet", table)])
    about = pq.ParquetFile(tmp_path / "t.parquet").metadata.row_group(0)
    first, second = about.column(0), about.column(1)
    assert {first.compression, second.compression} == {"ZSTD"}
    assert "DELTA_BINARY_PACKED" in first.encodings
    assert "PLAIN" in second.encodings
    assert (first.statistics.min, first.statistics.max, first.statistics.null_count) == (3, 9, 0)
    assert (second.statistics.min, second.statistics.max, second.statistics.null_count) == (-2.5, 7.0, 1)
    # a reader may skip a file by its extent alone
    assert pl.scan_parquet(tmp_path / "t.parquet").filter(pl.col("v") > 8).collect().is_empty()


def test_an_error_of_the_pieces_is_raised_as_it_is(tmp_path):
    def pieces():
        yield {"time_ns": np.arange(3, dtype=np.int64)}
        raise ValueError("slip")

    with pytest.raises(ValueError, match="slip"):
        write_pieces(pieces(), tmp_path / "t.parquet", {"time_ns": INT64})


def test_packed_columns_tell_their_sizes():
    column = pack_column("v", np.zeros(1000))
    assert (column.rows, column.empty, column.kind) == (1000, 0, DOUBLE)
    assert len(column.data) < 200 < 8000 < column.size
    assert len(differences(np.arange(1000, dtype=np.int64))) < 100
    assert kinds_of({"a": np.zeros(1), "b": np.zeros(1, np.int64)}) == {"a": DOUBLE, "b": INT64}


@pytest.mark.parametrize(("value", "data"), [(0, b"\0"), (127, b"\x7f"), (128, b"\x80\1"), (300, b"\xac\2")])
def test_numbers_of_varying_length(value, data):
    assert varint(value) == data


def test_structures_as_the_specification_shows_them():
    assert Thrift([(1, I32, 1), (3, I64, -1)]).pack() == b"\x15\2\x26\1\0"
    assert Thrift([(2, BINARY, "é"), (4, I32, None)]).pack() == b"\x28\2\xc3\xa9\0"
    assert Thrift([(1, LIST, (I32, [1, 2]))]).pack() == b"\x19\x25\2\4\0"
    assert Thrift([(1, LIST, (I32, [0] * 15))]).pack() == b"\x19\xf5\x0f" + bytes(15) + b"\0"
    assert Thrift([(1, Thrift, Thrift([]))]).pack() == b"\x1c\0\0"


def test_columns_packed_ahead_are_written_where_they_stayed_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr("parsers.parquet_write.cores", lambda: 2)
    stamps = np.arange(1000, dtype=np.int64)
    columns = [np.random.default_rng(k).normal(size=1000) for k in range(20)]
    with closing(PackedAhead([stamps, *columns])) as ahead:
        # every other one is changed in the meantime
        now = [-column if k % 2 else column for k, column in enumerate(columns)]
        table = {"time_ns": stamps} | {f"v{k}": column for k, column in enumerate(now)}
        write_tables([(tmp_path / "a.parquet", table), (tmp_path / "b.parquet", table)], ahead)
    write_tables([(tmp_path / "c.parquet", table)])
    first, *others = [(tmp_path / f"{name}.parquet").read_bytes() for name in "abc"]
    assert others == [first, first]
    assert pl.read_parquet(tmp_path / "a.parquet")["v1"].to_list() == (-columns[1]).tolist()
