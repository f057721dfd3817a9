"""Logs behind URLs give the same drives as logs of the disk, and are read in ranges."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_importer_contract import options_for

from parsers.drive import Drive
from parsers.load import load_drive
from parsers.places import as_path

LOGS = (
    "csv/drive.csv",
    "tsv/drive.tsv",
    "vbo/drive.vbo",
    "mcap/drive_json.mcap",
    "mcap/drive_protobuf.mcap",
    "ros/drive.bag",
    "ros/drive_ros1.mcap",
    "ros/drive_ros2.mcap",
    "ros/drive_mcap",
    "ros/drive_sqlite3",
    "mf4/drive.mf4",
    "parquet/drive.parquet",
    "can/drive.asc",
    "can/drive.blf",
    "can/drive.log",
    "can/drive.mf4",
    "can/drive.trc",
    "fleet/suv/wednesday.mcap",
)


def same(one: Drive, other: Drive) -> None:
    """The drives hold the same samples, and their records say the same."""
    assert list(one.signals) == list(other.signals)
    for name, signal in one.signals.items():
        np.testing.assert_array_equal(signal.time_ns, other.signals[name].time_ns)
        np.testing.assert_array_equal(signal.values, other.signals[name].values)
    for what in (
        "format",
        "status",
        "messages",
        "rejected",
        "gaps",
        "clock",
        "start_utc",
        "mapped",
        "decisions",
    ):
        assert getattr(one.record, what) == getattr(other.record, what), what


@pytest.mark.parametrize("name", LOGS)
def test_a_log_in_a_store_is_the_same_drive(name: str, samples: Path, s3_store, counted) -> None:
    log = samples / name
    options = options_for(log)
    url = s3_store.put(log, name)
    here, there = load_drive([log], options), load_drive([as_path(url)], options)
    same(here, there)
    assert any("known by s3 etag" in note for note in there.record.notes)
    assert counted.calls["get_object"] > 0
    print(name, counted)
