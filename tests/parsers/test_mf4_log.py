"""MF4 files written by asammdf: every value equals what asammdf reads."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from asammdf import MDF, Signal
from asammdf.blocks.conversion_utils import from_dict
from mf4_logs import START, opened, read_all

from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.mf4 import stamps
from parsers.mf4_log import Mf4Importer

START_NS = round(START.timestamp() * 1000) * 1_000_000
pytestmark = pytest.mark.filterwarnings("ignore")


def plain_signals(count: int = 5000) -> list[Signal]:
    rng = np.random.default_rng(5)
    t = np.arange(count) * 0.01
    kinds = [
        "u1",
        "i1",
        "<u2",
        ">u2",
        "<i2",
        ">i2",
        "<u4",
        ">u4",
        "<i4",
        ">i4",
        "<u8",
        "<i8",
        "<f4",
        ">f4",
        "<f8",
        "f2",
    ]
    signals = []
    for kind in kinds:
        dtype = np.dtype(kind)
        if dtype.kind == "f":
            values = rng.normal(size=count).astype(dtype)
        else:
            info = np.iinfo(dtype)
            values = rng.integers(
                info.min, info.max, count, dtype=dtype.newbyteorder("="), endpoint=True
            ).astype(dtype)
        signals.append(
            Signal(values, t, name=f"c_{kind.strip('<>')}{'be' if kind[0] == '>' else ''}", unit="m/s²")
        )
    return signals


def write(path: Path, *groups: list[Signal], compression: int = 0, **options: Any) -> Path:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mdf = MDF(version=options.pop("version", "4.10"), **options)
        mdf.start_time = START
        for number, group in enumerate(groups):
            mdf.append(group, acq_name=f"ECU{number}", common_timebase=True)
        mdf.save(path, overwrite=True, compression=compression)
        mdf.close()
    return path


def same_as_peer(path: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Read with both, compare all, return ours."""
    reader, log = opened(path)
    got = read_all(reader)
    assert log.status == "complete", log.notes
    with MDF(path) as peer:
        for gi, group in enumerate(peer.groups):
            for ci, channel in enumerate(group.channels):
                if channel.channel_type in (2, 3):
                    continue
                theirs = peer.get(group=gi, index=ci, ignore_invalidation_bits=True)
                name = channel.name if channel.name in got and gi == 0 else f"{channel.name}@group{gi + 1}"
                name = name if name in got else channel.name
                if theirs.samples.dtype.kind not in "uif":
                    assert name not in got
                    continue
                time_ns, values = got[name]
                start = peer.header.abs_time
                assert abs(start - START_NS) < 1000
                np.testing.assert_array_equal(
                    time_ns - start, np.rint(theirs.timestamps * 1e9).astype(np.int64)
                )
                expected = theirs.samples.astype(np.float64)
                if theirs.invalidation_bits is not None:
                    expected[theirs.invalidation_bits] = np.nan
                np.testing.assert_allclose(values, expected, rtol=1e-12, atol=0, err_msg=name)
    return got


@pytest.mark.parametrize("compression", [0, 1, 2])
def test_plain_channels_of_all_types(tmp_path: Path, compression: int) -> None:
    path = write(tmp_path / "a.mf4", plain_signals(), compression=compression)
    got = same_as_peer(path)
    assert len(got) == 16
    reader, _ = opened(path)
    assert reader.absolute
    info = {c.name: c for c in reader.channels}["c_f8"]
    assert (info.unit, info.family, info.count, info.group) == ("m/s²", "mdf", 5000, "group 1 (ECU0)")


def test_many_data_blocks(tmp_path: Path) -> None:
    # 2.4 MB of records in blocks of at most 100 kB, records straddle them
    path = tmp_path / "a.mf4"
    mdf = MDF(version="4.10")
    mdf.start_time = START
    mdf.configure(write_fragment_size=100_001)
    mdf.append(plain_signals(40_000), common_timebase=True)
    mdf.save(path, compression=2)
    mdf.close()
    got = same_as_peer(path)
    assert got["c_u1"][0].size == 40_000


def test_only_wanted_channels_are_given(tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.mf4", plain_signals(), [Signal(np.arange(3.0), np.arange(3) * 1.0, name="other")]
    )
    reader, log = opened(path)
    chunks = list(reader.read(frozenset({"other"})))
    assert [list(chunk.columns) for chunk in chunks] == [["other"]]
    assert log.messages == 3


def test_conversions(tmp_path: Path) -> None:
    t = np.arange(300) * 0.1
    raw = np.arange(300, dtype=np.uint16)
    rules: dict[str, dict[str, Any]] = {
        "linear": {"a": 0.25, "b": -3.0},
        "rational": {"P1": 0.0, "P2": 2.0, "P3": 1.0, "P4": 0.0, "P5": 0.5, "P6": 4.0},
        "formula": {"formula": "2.5 * X1 + 3 - sin(X1 / 10)"},
        "interpolated": {"raw_0": 0.0, "raw_1": 100.0, "raw_2": 200.0, "phys_0": 1.0, "phys_1": 5.0, "phys_2": -9.0, "interpolation": True},
        "table": {"raw_0": 0.0, "raw_1": 100.0, "raw_2": 200.0, "phys_0": 1.0, "phys_1": 5.0, "phys_2": -9.0, "interpolation": False},
    }  # fmt: skip
    signals = [Signal(raw, t, name=name, conversion=from_dict(rule)) for name, rule in rules.items()]
    got = same_as_peer(write(tmp_path / "a.mf4", signals))
    assert set(got) == set(rules)
    np.testing.assert_array_equal(got["linear"][1][:3], [-3.0, -2.75, -2.5])


def test_texts_are_listed_but_are_no_numbers(tmp_path: Path) -> None:
    t = np.arange(4) * 1.0
    words = Signal(np.array([b"a", b"bcd", b"", b"xy"]), t, name="words", encoding="utf-8")
    table = from_dict({"val_0": 0, "text_0": "off", "val_1": 1, "text_1": "on", "default_addr": "error"})
    states = Signal(np.array([0, 1, 0, 1], np.uint8), t, name="state", conversion=table)
    path = write(tmp_path / "a.mf4", [words, states, Signal(t, t, name="x")])
    reader, _ = opened(path)
    assert {c.name: c.kind for c in reader.channels} == {"words": "text", "state": "text", "x": "number"}
    assert set(read_all(reader)) == {"x"}


def test_invalid_samples_are_nan(tmp_path: Path) -> None:
    t = np.arange(200) * 1.0
    bad = t % 3 == 0
    path = write(
        tmp_path / "a.mf4", [Signal(t + 1, t, name="x", invalidation_bits=bad), Signal(t, t, name="y")]
    )
    got = same_as_peer(path)
    np.testing.assert_array_equal(np.isnan(got["x"][1]), bad)
    assert not np.isnan(got["y"][1]).any()


def test_repeated_names(tmp_path: Path) -> None:
    t = np.arange(5) * 1.0
    path = write(tmp_path / "a.mf4", [Signal(t, t, name="speed")], [Signal(t * 2, t, name="speed")])
    reader, log = opened(path)
    assert [c.name for c in reader.channels] == ["speed", "speed@group2"]
    got = read_all(reader)
    np.testing.assert_array_equal(got["speed@group2"][1], t * 2)
    assert any("speed@group2" in note for note in log.notes)


def test_columns_stored_apart(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mf4", plain_signals(500), version="4.20", column_storage=True)
    assert len(same_as_peer(path)) == 16


def test_claims_by_first_bytes() -> None:
    importer = Mf4Importer()
    assert importer.claims(Path("x"), b"MDF     4.10    ")
    assert importer.claims(Path("x"), b"UnFinMF 4.11    ")
    assert not importer.claims(Path("x.mf4"), b"PK\3\4")


def test_a_cut_file_is_called_cut_whatever_else_is_to_be_said(tmp_path: Path) -> None:
    path = tmp_path / "log.mf4"
    with MDF(version="4.10") as mdf:
        mdf.append([Signal(np.arange(20_000.0), np.arange(20_000) / 100, name="speed", unit="km/h")])
        mdf.save(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(LogError, match="breaks off"):
        Mf4Importer().open(path, ReadOptions(), ImportLog())


@pytest.mark.parametrize("compiled", [True, False])
def test_a_master_of_dates_is_not_added_to_the_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiled: bool
) -> None:
    """Seconds since 1970 in the time channel: the drive would be dated 54 years later. From the start on they are added as before."""
    if not compiled:
        monkeypatch.setattr(stamps, "find_rule", lambda _: None)
    seconds = np.arange(500) * 0.01
    values = np.sin(seconds)
    for name, begin, first_ns in (("epoch", 1.7e9, 1_700_000_000 * 10**9), ("own", 20.0, START_NS + 20 * 10**9)):  # fmt: skip
        path = write(tmp_path / f"{name}.mf4", [Signal(values, begin + seconds, name="speed", unit="m/s")])
        time_ns, found = read_all(opened(path)[0])["speed"]
        assert abs(int(time_ns[0]) - first_ns) < 1000
        assert np.allclose(np.diff(time_ns), 10**7, atol=1000)
        assert np.array_equal(found, values)


def test_the_record_says_that_time_channels_are_dates(tmp_path: Path) -> None:
    seconds = np.arange(500) * 0.01
    for name, begins, told in (
        ("all", (1.7e9, 1.7e9), "the MF4 file's time channels count from 1970: taken as dates in UTC"),
        ("some", (1.7e9, 0.0), "the MF4 file's time channels of 1 of 2 channel groups count from 1970"),
        ("none", (0.0, 0.0), None),
    ):
        signals = [
            Signal(np.sin(seconds), begin + seconds, name=signal, unit="m/s")
            for begin, signal in zip(begins, ("speed", "vx"), strict=True)
        ]
        reader, log = opened(write(tmp_path / f"{name}.mf4", *[[each] for each in signals]))
        read_all(reader)
        notes = [each for each in log.notes if "1970" in each]
        assert len(notes) == (told is not None)
        assert told is None or notes[0].startswith(told)
        assert reader.absolute
