"""Joint states by the joints' names, in bags of both versions and MCAP: wheels, suspensions, publishers that share a topic."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from parsers.load import LoadOptions, load_drive, open_log, read_chunks
from parsers.mapping import WheelRadius, propose_and_say

START = 1_700_000_000_000_000_000
TYPE = "sensor_msgs/msg/JointState"
WHEELS = ["front_left_wheel_joint", "front_right_wheel_joint", "rear_left_wheel_joint", "rear_right_wheel_joint"]  # fmt: skip
SUSPENSION = [f"{corner}_suspension_joint" for corner in ("fl", "fr", "rl", "rr")]
STEER = ["left_steering_hinge_joint", "right_steering_hinge_joint"]
KINDS = ["ros1", "sqlite", "mcap", "packed"]


def message(store: Any, kind: str, i: int, names: list[str], position: Any, velocity: Any) -> Any:
    t = store.types
    stamp = t["builtin_interfaces/msg/Time"](
        (START + i * 20_000_000) // 10**9, (START + i * 20_000_000) % 10**9
    )
    seq = {"seq": i} if kind == "ros1" else {}
    header = t["std_msgs/msg/Header"](stamp=stamp, frame_id="", **seq)
    empty = np.empty(0)
    return t[TYPE](header, names, np.asarray(position, float), np.asarray(velocity, float), empty)


def write(tmp_path: Path, kind: str, rows: list[tuple[int, list[str], Any, Any]]) -> Path:
    """A bag of joint states: (number, names, positions, velocities)."""
    store = get_typestore(Stores.ROS1_NOETIC if kind == "ros1" else Stores.ROS2_HUMBLE)
    path = tmp_path / ("bag.bag" if kind == "ros1" else "bag")
    serialise = store.serialize_ros1 if kind == "ros1" else store.serialize_cdr
    if kind == "ros1":
        writer: Any = Writer1(path)
    else:
        writer = Writer2(
            path, version=9, storage_plugin=StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        )
    if kind == "packed":
        writer.set_compression(CompressionMode.FILE, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/joint_states", TYPE, typestore=store)
        for row in rows:
            i = row[0]
            writer.write(connection, START + i * 20_000_000, serialise(message(store, kind, *row), TYPE))
    return path


def columns(path: Path) -> dict[str, np.ndarray]:
    opened = open_log(path, LoadOptions())
    names = frozenset(each.name for each in opened.reader.channels if "joint" in each.tags)
    found: dict[str, list[np.ndarray]] = {}
    for chunk in read_chunks(opened, names):
        assert set(chunk.columns) == names
        for name, values in chunk.columns.items():
            found.setdefault(name, []).append(values)
    return {name: np.concatenate(parts) for name, parts in found.items()}


@pytest.mark.parametrize("kind", KINDS)
def test_a_robot_car(tmp_path: Path, kind: str) -> None:
    names = [*STEER, *WHEELS, *SUSPENSION]
    rows = []
    for i in range(600):
        swing = np.sin(i / 40)
        travel = [0.01 * swing + 0.001 * k for k in range(4)]
        position = [0.1, 0.1, *(0.4 * i + k for k in range(4)), *travel]
        velocity = [0.0, 0.0, *(20 + 5 * swing + 0.1 * k for k in range(4)), *([0.0] * 4)]
        rows.append((i, names, position, velocity))
    path = write(tmp_path, kind, rows)
    opened = open_log(path, LoadOptions())
    proposals, said = propose_and_say(opened.reader.channels, None, WheelRadius(0.3, 0.3, "vehicle.toml"))
    wheels = ("fl", "fr", "rl", "rr")
    assert [proposals[f"wheel_speed_{w}"][0].channels[0] for w in wheels] == [
        f"/joint_states.velocity[{name}]" for name in WHEELS
    ]
    assert [proposals[f"suspension_deflection_{w}"][0].channels[0] for w in wheels] == [
        f"/joint_states.position[{name}]" for name in SUSPENSION
    ]
    assert not any("by place" in sentence for sentence in said)
    drive = load_drive([path], LoadOptions(fix=False, radius=WheelRadius(0.3, 0.3, "vehicle.toml")))
    assert drive.signals["wheel_speed_rr"].values[:2] == pytest.approx(
        [0.3 * 20.3, 0.3 * (20.3 + 5 * np.sin(1 / 40))]
    )
    assert drive.signals["suspension_deflection_fr"].values[0] == pytest.approx(0.001)
    # without a radius the speeds are named, and the travels stay
    proposals, said = propose_and_say(opened.reader.channels, None)
    assert set(proposals) == {f"suspension_deflection_{w}" for w in wheels}
    assert any("without the wheel's radius" in sentence for sentence in said)


@pytest.mark.parametrize("kind", KINDS)
def test_publishers_share_a_topic_and_lists_change_their_order(tmp_path: Path, kind: str) -> None:
    """One node publishes the wheels, one the steering; after a restart the wheels stand the other way round."""
    rows: list[tuple[int, list[str], Any, Any]] = []
    for i in range(300):
        order = WHEELS if i < 200 else WHEELS[::-1]
        rows.append((2 * i, order, [], [10.0 + i + 1000 * WHEELS.index(name) for name in order]))
        rows.append((2 * i + 1, STEER, [0.01 * i, -0.01 * i], []))
    got = columns(write(tmp_path, kind, rows))
    for k, name in enumerate(WHEELS):
        column = got[f"/joint_states.velocity[{name}]"]
        assert column[0::2].tolist() == [10.0 + i + 1000 * k for i in range(300)]
        assert np.isnan(column[1::2]).all()
    assert got["/joint_states.position[left_steering_hinge_joint]"][1::2].tolist() == [
        0.01 * i for i in range(300)
    ]


def test_odd_names_and_lists(tmp_path: Path) -> None:
    long = "a_robot/with_a_name/longer_than_forty_letters/front_left_wheel"
    names = ["wheel", "wheel", long, "", "größe", "fl_wheel"]
    rows = [(i, names, [], [float(k) for k in range(6)]) for i in range(20)]
    rows += [(20 + i, ["fl_wheel", "more"], [], [7.0]) for i in range(20)]
    rows += [(40 + i, [], [], []) for i in range(20)]
    got = columns(write(tmp_path, "sqlite", rows))
    # two of one name, none, and letters that a channel's name does not show are not told apart
    assert set(got) == {f"/joint_states.velocity[{name}]" for name in (long[:40], "fl_wheel", "more")}
    column = got["/joint_states.velocity[fl_wheel]"]
    assert column[:20].tolist() == [5.0] * 20
    assert column[20:40].tolist() == [7.0] * 20
    assert np.isnan(column[40:]).all()
    assert np.isnan(got["/joint_states.velocity[more]"]).all()
    assert got[f"/joint_states.velocity[{long[:40]}]"][:20].tolist() == [2.0] * 20


@pytest.mark.parametrize(
    ("joint", "value", "signal"),
    [
        ("wheel_front_left_joint", "velocity", "wheel_speed_fl"),
        ("left_rear_wheel", "velocity", "wheel_speed_rl"),
        ("robot/BR_wheel", "velocity", "wheel_speed_rr"),
        ("front_right_wheel_joint", "position", None),
        ("front_left_wheel_steer_joint", "velocity", None),
        ("left_wheel_joint", "velocity", None),
        ("flywheel_joint", "velocity", None),
        ("front_left_susp", "position", "suspension_deflection_fl"),
        ("front_left_suspension_arm", "position", None),
        ("fr_wheel_suspension", "position", "suspension_deflection_fr"),
        ("fr_wheel_suspension", "velocity", None),
    ],
)
def test_names_of_joints(joint: str, value: str, signal: str | None) -> None:
    from parsers.channels import ChannelInfo

    tags = {"topic": "/joint_states", "type": "sensor_msgs/JointState", "field": value, "joint": joint}
    channel = ChannelInfo(f"/joint_states.{value}[{joint}]", "/joint_states", None, "ros", tags=tags)
    found = propose_and_say([channel], None, WheelRadius(0.3, 0.3, "x"))[0]
    assert list(found) == ([] if signal is None else [signal])
