"""Units that a Parquet file states beside its columns' names."""

from __future__ import annotations

import base64
import json
import warnings
from pathlib import Path

import pandas as pd
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from parsers.arrow_schema import field_metadata
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.load import LoadOptions, load_drive
from parsers.parquet_log import ParquetImporter
from parsers.parquet_units import file_metadata, with_stated_units
from parsers.table_names import split_header

OF_PYARROW = (
    "/////+AAAAAQAAAAAAAKAAwABgAFAAgACgAAAAABBAAMAAAACAAIAAAABAAIAAAABAAAAAEAAAAUAAAAEAAYAAgABgAHAAwAEAAUABAAAAAAAAEDFAAAAGwAAAAI"
    "AAAAFAAAAAAAAAAFAAAAc3BlZWQ="
)
"""A message that breaks off within its only field."""


def table(units: dict[str, dict[str, str]], about: dict[str, str] | None = None) -> pa.Table:
    fields = [pa.field(name, pa.float64(), metadata=said or None) for name, said in units.items()]
    rows = [[0.02 * k for k in range(100)]] + [[36.0] * 100] * (len(units) - 1)
    return pa.table(rows, schema=pa.schema(fields, metadata=about))


def units_of(path: Path) -> tuple[dict[str, str | None], list[str]]:
    log = ImportLog()
    reader = ParquetImporter().open(path, ReadOptions(), log)
    return {channel.name: channel.unit for channel in reader.channels}, log.notes


def test_units_of_fields_are_read_and_used(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    said = {
        "time": {"unit": "s"}, "speed": {"unit": "km/h", "source": "can"}, "AY": {"Units": "[g]"}, "yaw_rate": {"units": "deg/s"},
        "pitch": {"comment": "none stated"}, "roll": {"unit": "-"},
    }  # fmt: skip
    pq.write_table(table(said, {"recorder": "x"}), path)
    units, notes = units_of(path)
    assert units == {"speed": "km/h", "AY": "g", "yaw_rate": "deg/s", "pitch": None, "roll": None}
    assert notes == []
    drive = load_drive([path], LoadOptions(fix=False))
    assert drive.signals["speed"].values[0] == pytest.approx(10.0)
    assert drive.signals["accel_y"].values[0] == pytest.approx(36 * 9.80665)


@pytest.mark.parametrize("unit", ["ms", "us"])
def test_the_times_unit(tmp_path: Path, unit: str) -> None:
    path = tmp_path / "a.parquet"
    pq.write_table(table({"time": {"unit": unit}, "speed": {}}), path)
    reader = ParquetImporter().open(path, ReadOptions(), ImportLog())
    (chunk,) = reader.read(frozenset({"speed"}))
    assert int(chunk.time_ns[50]) == {"ms": 1_000_000, "us": 1000}[unit]


def test_units_of_the_whole_file_and_of_pandas(tmp_path: Path) -> None:
    plain, of_pandas, of_columns = (tmp_path / f"{name}.parquet" for name in "abc")
    pq.write_table(table({"time": {}, "speed": {}}, {"units": json.dumps({"speed": "mph"})}), plain)
    assert units_of(plain)[0] == {"speed": "mph"}
    frame = pd.DataFrame({"time": [0.0, 0.02, 0.04], "speed": 36.0, "AX": 1.0})
    frame.attrs["units"] = {"speed": "km/h", "AX": "g"}
    frame.to_parquet(of_pandas)
    assert units_of(of_pandas)[0] == {"speed": "km/h", "AX": "g"}
    frame.attrs = {"speed": {"unit": "km/h"}, "driver": "x", "run": 4}
    frame.to_parquet(of_columns)
    assert units_of(of_columns)[0] == {"speed": "km/h", "AX": None}


def test_a_fields_unit_comes_before_the_names_and_the_files(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    said = {"time": {}, "speed_mps": {"unit": "km/h"}, "AY [g]": {"unit": "G"}, "AX": {"unit": "m/s^2"}}
    pq.write_table(table(said, {"unit": json.dumps({"AX": "g", "speed_mps": "mph"})}), path)
    units, notes = units_of(path)
    assert units == {"speed_mps": "km/h", "AY": "G", "AX": "m/s^2"}
    assert notes[:1] == [
        "the file's metadata state other units than the columns' names, and are taken: \"speed_mps\" km/h"
    ]


def test_what_is_no_unit_is_passed_over_with_a_note(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    pq.write_table(table({"time": {}, "speed": {"unit": "IMU 2, left"}, "AY": {"unit": ""}}), path)
    units, notes = units_of(path)
    assert units == {"speed": None, "AY": None}
    assert notes[:1] == [
        "units in the file's metadata that cogest does not know are passed over: \"speed\" 'IMU 2, left'"
    ]


@pytest.mark.parametrize(
    "about",
    [
        {"units": "km/h"}, {"units": "[1, 2]"}, {"units": "{"}, {"units": "[" * 100_000}, {"units": '{"speed": 3}'},
        {"PANDAS_ATTRS": '{"units": ["km/h"], "speed": "km/h"}'}, {"unit": '{"other": "km/h"}'},
    ],
    ids=lambda about: str(about)[:40],
)  # fmt: skip
def test_metadata_of_another_meaning(about: dict[str, str]) -> None:
    found = with_stated_units([split_header("speed")], ["speed"], about)
    assert [column.unit for column in found.names] == [None]


def test_parts_of_one_table_state_one_unit(tmp_path: Path) -> None:
    def part(name: str, start: float, unit: str | None) -> None:
        schema = pa.schema([
            pa.field("time", pa.float64()), pa.field("speed", pa.float64(), metadata={"unit": unit} if unit else None),
        ])  # fmt: skip
        pq.write_table(pa.table([[start, start + 0.02], [36.0, 36.0]], schema=schema), tmp_path / name)

    part("a.parquet", 0.0, None)
    part("b.parquet", 1.0, "km/h")
    part("c.parquet", 2.0, "kph")
    assert units_of(tmp_path)[0] == {"speed": "km/h"}
    part("d.parquet", 3.0, "m/s")
    with pytest.raises(LogError, match=r'b\.parquet has column "speed" in km/h, d\.parquet in m/s'):
        units_of(tmp_path)


def test_nested_and_many_columns(tmp_path: Path) -> None:
    inner = pa.struct([pa.field("x", pa.float64(), metadata={"unit": "g"})])
    schema = pa.schema([
        pa.field("imu", inner), *(pa.field(f"c{k}", pa.float32(), metadata={"unit": f"u{k}"}) for k in range(3000)),
    ])  # fmt: skip
    pq.write_table(schema.empty_table(), tmp_path / "a.parquet")
    found = field_metadata(file_metadata(tmp_path / "a.parquet")["ARROW:schema"])
    assert {name: said["unit"] for name, said in found.items()} == {f"c{k}": f"u{k}" for k in range(3000)}


def test_a_cut_schema_says_nothing() -> None:
    assert field_metadata(OF_PYARROW) == {}
    for text in ("", "%%%", "AAAA", base64.b64encode(b"\xff" * 400).decode(), base64.b64encode(bytes(400)).decode()):  # fmt: skip
        assert field_metadata(text) == {}


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.integers(0, 10_000), value=st.binary(min_size=1, max_size=8), cut=st.integers(0, 400))
def test_any_damage_of_a_schema_is_no_error(place: int, value: bytes, cut: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        message = table({"time": {"unit": "s"}, "speed": {"unit": "km/h"}}).schema.serialize().to_pybytes()
    data = bytearray(message[: len(message) - min(cut, len(message) - 20)])
    at = place % len(data)
    data[at : at + len(value)] = value
    found = field_metadata(base64.b64encode(bytes(data)).decode())
    assert isinstance(found, dict)


def test_what_polars_writes(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    frame = pl.DataFrame({"time": [0.0, 0.02], "speed": [36.0, 36.0]})
    try:
        frame.write_parquet(path, metadata={"units": '{"speed": "km/h"}'})
    except TypeError:
        pytest.skip("this polars writes no metadata")
    assert units_of(path)[0] == {"speed": "km/h"}
