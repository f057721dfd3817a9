"""CAN frames in MF4 files built by hand: payloads wherever the recorder put them."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from frame_rows import Frame
from mf4_files import bus_builder, frames_of, opened, unsorted

from parsers.can.frames import EXTENDED

FRAMES: list[Frame] = [
    (k * 10_000_000, (0x18FEF100 + k) | EXTENDED, 2, bytes(range(k, k + k))) for k in range(10)
]  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "wide"), [("fixed", 8), ("group", 8), ("group", 4), ("blocks", 8), ("blocks", 4)]
)
def test_can_frames(tmp_path: Path, kind: str, wide: int) -> None:
    reader, log = opened(tmp_path / "a.mf4", bus_builder(kind, wide=wide).build())
    assert frames_of(reader) == FRAMES
    assert log.messages == 10
    assert log.status == "complete"
    assert not log.rejected
    assert all(channel.family == "can" for channel in reader.channels)


def test_payloads_by_order_where_the_recorder_wrote_no_places(tmp_path: Path) -> None:
    reader, log = opened(tmp_path / "a.mf4", bus_builder("group", flags=0x41).build())
    assert frames_of(reader) == FRAMES
    assert not log.rejected


@pytest.mark.parametrize("kind", ["group", "blocks"])
def test_a_payload_that_is_not_there_rejects_its_frame(tmp_path: Path, kind: str) -> None:
    b = bus_builder(kind)
    block, links, data = b.blocks["dt"]
    # the place of the fifth frame's payload
    at = data.index(struct.pack("<QI", 50, 0x98FEF105)) + 14
    b.blocks["dt"] = (block, links, data[:at] + struct.pack("<Q", 1 << 63) + data[at + 8 :])
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert frames_of(reader) == FRAMES[:5] + FRAMES[6:]
    assert log.rejected == {"CAN frame without its payload": 1}


def test_remote_and_error_frames_are_counted(tmp_path: Path) -> None:
    b = unsorted(1)
    b.channel("v", 8, 16, after="err")
    b.channel("CAN_ErrorFrame", 8, 16, data_type=10, key="err", parts="code")
    b.channel("CAN_ErrorFrame.ErrorType", 8, 8, key="code")
    b.channel("w", 8, 32, data_type=4, after="frame")
    b.channel("CAN_DataFrame", 8, 32, data_type=10, key="frame", parts="id")
    b.channel("CAN_DataFrame.ID", 8, 11, key="id", after="data")
    b.channel("CAN_DataFrame.DataBytes", 10, 16, data_type=10, key="data")
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert len(frames_of(reader)) == 34
    assert log.rejected == {"CAN error frame": 100}
    # a file may hold both: measured channels stay
    assert [c.name for c in reader.channels] == ["v", "w"]
