"""MF4 files written by asammdf, and a real bus log: every value equals what asammdf reads."""

from __future__ import annotations

import warnings
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import can
import numpy as np
import pytest
from asammdf import MDF, Signal
from asammdf.blocks.conversion_utils import from_dict
from asammdf.blocks.source_utils import Source

from parsers.channels import Chunk
from parsers.importer import ImportLog, ReadOptions
from parsers.mf4.reader import Mf4Reader, open_mf4
from parsers.mf4_log import Mf4Importer

REAL = Path(__file__).parents[3] / "shared" / "real_logs"
START = datetime(2024, 5, 6, 7, 8, 9, 250_000, tzinfo=UTC)
START_NS = round(START.timestamp() * 1000) * 1_000_000

pytestmark = pytest.mark.filterwarnings("ignore")


def opened(path: Path, *dbc: Path) -> tuple[Mf4Reader, ImportLog]:
    log = ImportLog()
    return open_mf4(path, ReadOptions(dbc=dbc), log), log


def read_all(reader: Mf4Reader) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Channel -> (time_ns, values) over all chunks."""
    return gathered(list(reader.read(frozenset(c.name for c in reader.channels))))


def gathered(chunks: list[Chunk]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    parts: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for chunk in chunks:
        for name, values in chunk.columns.items():
            assert values.dtype == np.float64
            parts.setdefault(name, []).append((chunk.time_ns, values))
    return {
        name: (np.concatenate([p[0] for p in some]), np.concatenate([p[1] for p in some]))
        for name, some in parts.items()
    }


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


@pytest.mark.parametrize("level", [0, 2])
def test_frames_written_by_python_can(tmp_path: Path, level: int) -> None:
    rng = np.random.default_rng(1)
    path = tmp_path / "a.mf4"
    sent: list[tuple[int, int, bytes]] = []
    with can.MF4Writer(path, compression_level=level) as writer:
        for k in range(3000):
            fd, extended, remote = k % 5 == 0, k % 3 == 0, k % 100 == 99
            data = b"" if remote else rng.bytes([0, 8, 12, 64][k % 4] if fd else k % 9)
            ident = 0x100 + k % 7 + (0x10000000 if extended else 0)
            message = can.Message(
                timestamp=1.7e9 + k * 0.001, arbitration_id=ident, is_extended_id=extended, is_fd=fd and not remote,
                is_remote_frame=remote, data=data, channel=1 + k % 3,
            )  # fmt: skip
            writer.on_message_received(message)
            if not remote:
                sent.append((ident | (0x80000000 if extended else 0), 1 + k % 3, data))
    reader, log = opened(path)
    assert reader.frames is not None
    got = []
    for batch in reader.frames.frames(counting=False):
        ends = batch.offset + batch.length
        payloads = [batch.data[a:b].tobytes() for a, b in zip(batch.offset, ends, strict=True)]
        got += zip(batch.can_id.tolist(), batch.bus.tolist(), payloads, strict=True)
        np.testing.assert_allclose(np.diff(batch.time_ns), np.round(np.diff(batch.time_ns), -6), atol=200)
    assert got == sent
    assert log.rejected == {"CAN remote frame": 30}
    assert log.status == "complete"


FD_DBC = """VERSION ""

BU_: X

BO_ 291 Wide: 64 X
 SG_ First : 0|16@1- (0.01,0) [0|0] "" X
 SG_ Late : 71|24@0- (0.5,-3) [0|0] "" X
 SG_ Last : 496|16@1+ (1,0) [0|0] "" X

BO_ 292 Short: 8 X
 SG_ Whole : 0|64@1- (1,0) [0|0] "" X

BO_ 2566844926 Far: 8 X
 SG_ Odd : 5|13@1- (0.1,1) [0|0] "" X
"""
SENT = {0x123: 64, 0x124: 8, 0x98FEF1FE: 8, 0x555: 8}


def write_frames(path: Path, compression: int) -> None:
    """Classic and FD frames of four ids in one channel group with 64 bytes of data each."""
    rng = np.random.default_rng(12)
    count = 30_000
    kinds = ("BusChannel", "<u1"), ("ID", "<u4"), ("IDE", "<u1"), ("DLC", "<u1"), ("DataLength", "<u1")
    fields = [(f"CAN_DataFrame.{name}", kind) for name, kind in kinds]
    table = np.zeros(count, np.dtype([*fields, ("CAN_DataFrame.DataBytes", "(64,)u1")]))
    ids = rng.choice(list(SENT), count)
    table["CAN_DataFrame.ID"], table["CAN_DataFrame.IDE"] = ids & 0x1FFFFFFF, ids >> 31
    table["CAN_DataFrame.BusChannel"] = 1
    table["CAN_DataFrame.DataLength"] = [SENT[int(ident)] for ident in ids]
    table["CAN_DataFrame.DLC"] = np.where(table["CAN_DataFrame.DataLength"] == 64, 15, 8)
    table["CAN_DataFrame.DataBytes"] = rng.integers(0, 256, (count, 64), dtype=np.uint8)
    source = Source(
        name="CAN", path="CAN1", comment="", source_type=Source.SOURCE_BUS, bus_type=Source.BUS_TYPE_CAN
    )
    with MDF(version="4.10") as mdf:
        mdf.start_time = START
        # fragments that cut records
        mdf.configure(write_fragment_size=100_001)
        mdf.append(
            Signal(table, np.arange(count) * 1e-4, name="CAN_DataFrame", source=source), acq_source=source
        )
        mdf.save(path, compression=compression)


@pytest.mark.parametrize("compression", [0, 1, 2])
def test_every_signal_of_fd_frames(tmp_path: Path, compression: int) -> None:
    path, dbc = tmp_path / "fd.mf4", tmp_path / "fd.dbc"
    dbc.write_text(FD_DBC, encoding="ascii")
    write_frames(path, compression)
    reader, log = opened(path, dbc)
    got = read_all(reader)
    assert log.messages == 30_000
    assert set(got) == {"Wide.First", "Wide.Late", "Wide.Last", "Short.Whole", "Far.Odd"}
    with MDF(path) as raw, raw.extract_bus_logging(database_files={"CAN": [(str(dbc), 0)]}) as peer:
        for name, (time_ns, values) in got.items():
            theirs = peer.get(name.split(".")[1])
            assert values.size == theirs.samples.size > 5000
            np.testing.assert_array_equal(
                time_ns - raw.header.abs_time, np.rint(theirs.timestamps * 1e9).astype(np.int64)
            )
            np.testing.assert_allclose(values, theirs.samples.astype(np.float64), rtol=1e-12, err_msg=name)


def test_the_truck_frame_by_frame() -> None:
    path = REAL / "truck_j1939.mf4"
    if not path.exists():
        pytest.skip("the real logs are not here")
    reader, log = opened(path, REAL / "truck_j1939.dbc")
    assert reader.frames is not None
    ours: list[tuple[int, int, int, bytes]] = []
    for batch in reader.frames.frames(counting=False):
        for row in range(batch.time_ns.size):
            at = int(batch.offset[row])
            data = batch.data[at : at + int(batch.length[row])].tobytes()
            ours.append((int(batch.time_ns[row]), int(batch.can_id[row]), int(batch.bus[row]), data))
    assert log.messages == len(ours) == 150_411
    assert log.status == "complete"
    theirs: list[tuple[int, int, int, bytes]] = []
    with MDF(path) as peer:
        start = peer.header.abs_time
        for gi, group in enumerate(peer.groups):
            if not group.channel_group.cycles_nr or "CAN_DataFrame" not in [c.name for c in group.channels]:
                continue
            frames = peer.get("CAN_DataFrame", group=gi)
            fields = ("ID", "IDE", "BusChannel", "DataLength", "DataBytes")
            ident, ide, bus, length, data = (frames.samples[f"CAN_DataFrame.{f}"] for f in fields)
            times = (np.rint(frames.timestamps * 1e6) * 1000).astype(np.int64) + start
            ids = ident.astype(np.int64) | np.where(ide.astype(bool), 0x80000000, 0)
            rows = zip(times.tolist(), ids.tolist(), bus.tolist(), length.tolist(), data, strict=True)
            theirs += [(t, i, int(b), d[: int(n)].tobytes()) for t, i, b, n, d in rows]
    assert sorted(ours) == sorted(theirs)


def frames_of(path: Path) -> tuple[list[tuple[int, int, bytes]], ImportLog]:
    """All frames as (time_ns, id, payload)."""
    reader, log = opened(path)
    assert reader.frames is not None
    found: list[tuple[int, int, bytes]] = []
    for batch in reader.frames.frames(counting=False):
        ends = batch.offset + batch.length
        payloads = [batch.data[a:b].tobytes() for a, b in zip(batch.offset, ends, strict=True)]
        found += zip(batch.time_ns.tolist(), batch.can_id.tolist(), payloads, strict=True)
    return found, log


def test_the_truck_cut_damaged_and_sorted(tmp_path: Path) -> None:
    source = REAL / "truck_j1939.mf4"
    if not source.exists():
        pytest.skip("the real logs are not here")
    whole = source.read_bytes()
    frames, _ = frames_of(source)

    hole = tmp_path / "hole.mf4"
    hole.write_bytes(whole[:1_500_000] + np.random.default_rng(2).bytes(20_000) + whole[1_520_000:])
    some, log = frames_of(hole)
    assert log.status == "malformed"
    # nothing is invented but what rubbish can hide behind a whole record id, and little else is lost
    assert len(set(some) - set(frames)) <= 3
    assert 900 < len(frames) - len(some) < 1100
    assert len(log.lost_spans_ns) >= 1

    cut = tmp_path / "cut.mf4"
    cut.write_bytes(whole[:2_000_003])
    some, log = frames_of(cut)
    assert log.status == "truncated"
    assert len(some) > 90_000
    assert set(some) <= set(frames)

    resaved = tmp_path / "sorted.mf4"
    with MDF(source) as peer:
        peer.save(resaved, compression=2)
    some, log = frames_of(resaved)
    assert sorted(some) == sorted(frames)
    assert log.status == "complete"


def test_the_truck_decoded() -> None:
    path, dbc = REAL / "truck_j1939.mf4", REAL / "truck_j1939.dbc"
    if not path.exists():
        pytest.skip("the real logs are not here")
    reader, _ = opened(path, dbc)
    got = read_all(reader)
    with MDF(path) as raw, raw.extract_bus_logging(database_files={"CAN": [(str(dbc), 0)]}) as peer:
        for ours, theirs in (
            ("EEC1.EngineSpeed", "EngineSpeed"),
            ("CCVS1.WheelBasedVehicleSpeed", "WheelBasedVehicleSpeed"),
        ):
            signal = peer.get(theirs)
            time_ns, values = got[ours]
            assert time_ns.size == signal.timestamps.size == 3993
            expected = (np.rint(signal.timestamps * 1e6) * 1000).astype(np.int64) + peer.header.abs_time
            np.testing.assert_array_equal(time_ns, expected)
            there = np.isfinite(values)
            assert there.sum() > 3900
            np.testing.assert_allclose(values[there], signal.samples[there], rtol=1e-12)


def test_claims_by_first_bytes() -> None:
    importer = Mf4Importer()
    assert importer.claims(Path("x"), b"MDF     4.10    ")
    assert importer.claims(Path("x"), b"UnFinMF 4.11    ")
    assert not importer.claims(Path("x.mf4"), b"PK\3\4")
