"""MultiArrays whose label lists the wheels: in bags of both versions and MCAP; labels that change, and such as say nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from parsers.load import LoadOptions, load_drive, open_log
from parsers.mapping import propose, propose_and_say
from parsers.ros.labelled_topics import OTHER_LABEL
from parsers.signals import WHEELS

START = 1_700_000_000_000_000_000
TYPE = "std_msgs/msg/Float64MultiArray"
KINDS = ["ros1", "sqlite", "mcap", "packed"]
TOPIC = "/suspension/travel"


def write(tmp_path: Path, kind: str, labels: list[list[str]]) -> Path:
    """A bag of so many messages, each with the label of its one dimension, or of several."""
    store = get_typestore(Stores.ROS1_NOETIC if kind == "ros1" else Stores.ROS2_HUMBLE)
    t = store.types
    path = tmp_path / ("bag.bag" if kind == "ros1" else "bag")
    if kind == "ros1":
        writer: Any = Writer1(path)
    else:
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        writer = Writer2(path, version=9, storage_plugin=plugin)
    if kind == "packed":
        writer.set_compression(CompressionMode.FILE, CompressionFormat.ZSTD)
    serialise = store.serialize_ros1 if kind == "ros1" else store.serialize_cdr
    with writer:
        connection = writer.add_connection(TOPIC, TYPE, typestore=store)
        for i, own in enumerate(labels):
            dims = [t["std_msgs/msg/MultiArrayDimension"](label=label, size=4, stride=4) for label in own]
            layout = t["std_msgs/msg/MultiArrayLayout"](dim=dims, data_offset=0)
            values = 0.01 * np.sin(i / 40) + 0.001 * np.arange(4)
            writer.write(
                connection, START + i * 20_000_000, serialise(t[TYPE](layout=layout, data=values), TYPE)
            )
    return path


def places(path: Path) -> dict[str, str]:
    proposals = propose(open_log(path, LoadOptions()).reader.channels, None)
    return {signal: found[0].channels[0] for signal, found in proposals.items()}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "label", ["fl,fr,rl,rr", "rear_left; rear_right; front_left; front_right", "VL VR HL HR"]
)
def test_the_label_is_the_order(tmp_path: Path, kind: str, label: str) -> None:
    path = write(tmp_path, kind, [[label]] * 600)
    order = (2, 3, 0, 1) if label.startswith("rear") else (0, 1, 2, 3)
    assert places(path) == {
        f"suspension_deflection_{wheel}": f"{TOPIC}.data[{k}]" for wheel, k in zip(WHEELS, order, strict=True)
    }
    drive = load_drive([path], LoadOptions(fix=False))
    for wheel, k in zip(WHEELS, order, strict=True):
        values = drive.signals[f"suspension_deflection_{wheel}"].values
        assert len(values) == 600
        assert values[:2] == pytest.approx([0.001 * k, 0.001 * k + 0.01 * np.sin(1 / 40)])


@pytest.mark.parametrize("kind", ["ros1", "mcap"])
def test_values_under_another_label_are_left_out_and_counted(tmp_path: Path, kind: str) -> None:
    path = write(tmp_path, kind, [["fl,fr,rl,rr"]] * 450 + [["fr,fl,rr,rl"]] * 50 + [["fl,fr,rl,rr"]] * 100)
    drive = load_drive([path], LoadOptions(fix=False))
    assert len(drive.signals["suspension_deflection_rr"].values) == 550
    assert drive.record.rejected[OTHER_LABEL] == 50


@pytest.mark.parametrize(
    "labels",
    [
        [["wheels"]] * 60,
        [["fl,fr,rl,fl"]] * 60,
        [[]] * 60,
        [[""]] * 60,
        [["fl,fr,rl,rr"], ["fr,fl,rr,rl"]] * 30,
        [["fl,fr,rl,rr" + "_of_a_vehicle_whose_labels_are_longer_than_anybody_needs"]] * 60,
    ],
)
def test_a_label_that_names_no_places_is_none(tmp_path: Path, labels: list[list[str]]) -> None:
    channels = open_log(write(tmp_path, "sqlite", labels), LoadOptions()).reader.channels
    proposals, said = propose_and_say(channels, None)
    assert proposals == {}
    assert any(f"suspension deflection ({TOPIC}.data[0-3])" in text for text in said)
