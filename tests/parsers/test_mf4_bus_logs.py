"""CAN logs in MF4 files, written by the format's own libraries and recorded on a truck: every frame and signal equals theirs."""

from __future__ import annotations

from pathlib import Path

import can
import numpy as np
import pytest
from asammdf import MDF, Signal
from asammdf.blocks.source_utils import Source
from frame_rows import rows_of
from mf4_logs import START, opened, read_all

from parsers.importer import ImportLog

REAL = Path(__file__).parents[3] / "shared" / "real_logs"
pytestmark = pytest.mark.filterwarnings("ignore")


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
    ours = rows_of(reader.frames.frames(counting=False))
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
    rows = rows_of(reader.frames.frames(counting=False))
    return [(time_ns, ident, payload) for time_ns, ident, _, payload in rows], log


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
