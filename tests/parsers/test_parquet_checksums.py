"""Parquet pages that are not what their checksum says cost what is in them, and the log says so."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from test_parquet_log import read

from parsers.parquet_checksums import torn_rows
from parsers.parquet_write import write_tables

ROWS = 20_000
TIME = np.arange(ROWS) * 10_000_000
VALUES = np.random.default_rng(1).normal(size=ROWS)


def write(path: Path, **options: Any) -> Path:
    """A table of several groups of rows, each column of several pages."""
    table = pa.table({"time_ns": TIME, "accel_y_mps2": VALUES})
    options = {"write_page_checksum": True, "use_dictionary": False, **options}
    pq.write_table(table, path, data_page_size=8000, row_group_size=8000, **options)
    return path


def damage(path: Path, column: int, group: int = 1) -> None:
    """Overwrite 300 bytes in the midst of a column."""
    about = pq.ParquetFile(path).metadata.row_group(group).column(column)
    data = bytearray(path.read_bytes())
    at = about.data_page_offset + about.total_compressed_size // 2
    data[at : at + 300] = np.random.default_rng(2).bytes(300)
    path.write_bytes(bytes(data))


@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("compression", ["none", "snappy"])
@pytest.mark.parametrize("slices", [False, True])
def test_values_in_a_torn_page_are_left_out_and_said(
    version: str, compression: str, slices: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path / "log.parquet", compression=compression, data_page_version=version)
    damage(path, 1)
    ((column, spans),) = torn_rows(path, {"time_ns", "accel_y_mps2"}).items()
    assert column == "accel_y_mps2"
    ((start, stop),) = spans
    assert 8000 < start < stop < 16000
    if slices:
        monkeypatch.setattr("parsers.parquet_log._CHUNK_BYTES", 16 * 3000)
    _, chunks, log = read(path)
    values = np.concatenate([chunk.columns["accel_y_mps2"] for chunk in chunks])
    expected = VALUES.copy()
    expected[start:stop] = np.nan
    np.testing.assert_array_equal(values, expected)
    assert np.concatenate([chunk.time_ns for chunk in chunks]).tolist() == TIME.tolist()
    assert log.status == "malformed"
    assert log.rejected == {"cell in a damaged page": stop - start}
    assert log.lost_spans_ns[0][0] == TIME[start - 1]
    assert log.lost_spans_ns[-1][1] == TIME[stop]
    assert any("a page is not what the checksum says" in note for note in log.notes)


def test_rows_whose_time_is_in_a_torn_page_are_left_out(tmp_path: Path) -> None:
    path = write(tmp_path / "log.parquet", compression="none")
    damage(path, 0)
    (spans,) = torn_rows(path, {"time_ns"}).values()
    ((start, stop),) = spans
    _, chunks, log = read(path)
    kept = np.concatenate([chunk.time_ns for chunk in chunks])
    assert kept.tolist() == np.delete(TIME, slice(start, stop)).tolist()
    assert (log.status, log.messages) == ("malformed", ROWS - (stop - start))
    assert sum(log.rejected.values()) == stop - start
    assert log.lost_spans_ns == [(TIME[start - 1], TIME[stop])]


@pytest.mark.parametrize("checksums", [False, True])
@pytest.mark.parametrize("group", [0, 1])
def test_a_column_that_cannot_be_decoded_costs_no_other(checksums: bool, group: int, tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    # random doubles are not compressed, and noise among them decodes
    coarse = np.round(VALUES, 1)
    table = pa.table({"time_ns": TIME, "accel_y_mps2": coarse, "speed_mps": VALUES})
    pq.write_table(
        table,
        path,
        write_page_checksum=checksums,
        use_dictionary=False,
        row_group_size=8000,
        compression="zstd",
    )
    damage(path, 1, group)
    _, chunks, log = read(path)
    assert np.concatenate([chunk.time_ns for chunk in chunks]).tolist() == TIME.tolist()
    assert np.concatenate([chunk.columns["speed_mps"] for chunk in chunks]).tolist() == VALUES.tolist()
    values = np.concatenate([chunk.columns["accel_y_mps2"] for chunk in chunks])
    lost = np.flatnonzero(np.isnan(values))
    assert 8000 <= len(lost) <= 11000
    assert set(range(8000 * group, 8000 * (group + 1))) <= set(lost.tolist())
    assert np.array_equal(np.delete(values, lost), np.delete(coarse, lost))
    assert log.status == "malformed"
    assert log.rejected == {"cell in a damaged page": len(lost)}
    assert log.lost_spans_ns[0][0] == TIME[max(lost[0] - 1, 0)]
    assert log.lost_spans_ns[-1][1] == TIME[lost[-1] + 1]


def test_a_torn_dictionary_costs_its_group_of_rows(tmp_path: Path) -> None:
    path = write(tmp_path / "log.parquet", compression="none", use_dictionary=True)
    about = pq.ParquetFile(path).metadata.row_group(1).column(1)
    data = bytearray(path.read_bytes())
    at = about.dictionary_page_offset + 500
    data[at : at + 100] = bytes(100)
    path.write_bytes(bytes(data))
    assert torn_rows(path, {"accel_y_mps2"}) == {"accel_y_mps2": [(8000, 16000)]}


def test_without_checksums_nothing_is_known(tmp_path: Path) -> None:
    path = write(tmp_path / "log.parquet", compression="none", write_page_checksum=False)
    damage(path, 1)
    assert not torn_rows(path, {"time_ns", "accel_y_mps2"})
    assert read(path)[2].status == "complete"


def test_whole_files_are_whole(tmp_path: Path) -> None:
    _, _, log = read(write(tmp_path / "log.parquet", compression="gzip"))
    assert (log.status, log.lost_spans_ns) == ("complete", [])


def test_what_cogest_writes_has_checksums_that_others_check(tmp_path: Path) -> None:
    path = tmp_path / "table.parquet"
    write_tables([(path, {"time_ns": TIME, "accel_y_mps2": VALUES})])
    assert not torn_rows(path, {"time_ns", "accel_y_mps2"})
    assert pq.read_table(path, page_checksum_verification=True).num_rows == ROWS
    damage(path, 1, group=0)
    assert torn_rows(path, {"time_ns", "accel_y_mps2"})
    with pytest.raises(OSError, match="checksum"):
        pq.read_table(path, page_checksum_verification=True)


def test_damage_anywhere_is_no_crash(tmp_path: Path) -> None:
    path = write(tmp_path / "log.parquet", compression="none")
    whole = path.read_bytes()
    rng = np.random.default_rng(3)
    for at in rng.integers(4, len(whole) - 50, 60):
        data = bytearray(whole)
        data[at : at + 40] = rng.bytes(40)
        path.write_bytes(bytes(data))
        for spans in torn_rows(path, {"time_ns", "accel_y_mps2"}).values():
            assert all(0 <= a < b for a, b in spans)
    path.write_bytes(b"PAR1")
    assert not torn_rows(path, {"time_ns"})
