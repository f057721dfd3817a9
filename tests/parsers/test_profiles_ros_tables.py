"""Tables that were written from ROS bags: the fields' paths are the columns' names."""

from __future__ import annotations

import pytest

from parsers.channels import ChannelInfo
from parsers.mapping import propose


def mapped(*names: str, unit: str | None = None) -> dict[str, tuple[str, str]]:
    columns = [ChannelInfo(name, "table", unit, tags={"column": name}) for name in names]
    found = propose(columns, None)
    return {signal: (each[0].channels[0], each[0].unit.text) for signal, each in found.items()}


IMU = {"accel_x": "linear_acceleration.x", "accel_y": "linear_acceleration.y", "accel_z": "linear_acceleration.z"} | {
    "roll_rate": "angular_velocity.x", "pitch_rate": "angular_velocity.y", "yaw_rate": "angular_velocity.z",
}  # fmt: skip


@pytest.mark.parametrize(
    ("before", "joint"), [("field.", "."), ("", "."), ("/imu/", "/"), ("/imu.", "."), ("/a/imu/data/", "/")]
)
def test_an_imu_message(before: str, joint: str) -> None:
    names = {signal: before + field.replace(".", joint) for signal, field in IMU.items()}
    found = mapped(*names.values())
    assert {signal: name for signal, (name, _) in found.items()} == names
    assert found["accel_x"][1] == "m/s2"


def test_an_imu_message_joined_by_underscores() -> None:
    names = {signal: field.replace(".", "_") for signal, field in IMU.items()}
    assert {signal: name for signal, (name, _) in mapped(*names.values()).items()} == names


@pytest.mark.parametrize(
    "name", ["/odom/twist/twist/linear/x", "/odom.twist.twist.linear.x", "twist.linear.x", "field.twist.twist.linear.x"]
)  # fmt: skip
def test_a_twist_is_the_speed(name: str) -> None:
    assert mapped(name) == {"speed": (name, "m/s")}


def test_a_units_own_comes_before_a_camera() -> None:
    assert mapped("/camera/imu/linear_acceleration/x", "/imu/linear_acceleration/x")["accel_x"][0].startswith(
        "/imu"
    )


@pytest.mark.parametrize(
    "name",
    [
        "Linear Acceleration x",  # an app's, without gravity
        "linear_acceleration_x",  # so as well, alone
        "/cmd_vel/twist/linear/x",
        "/gps/fix_velocity/twist/twist/linear/x",  # along east
        "/plan/twist/linear/x",
        "/imu/linear_acceleration_covariance/0",
    ],
)
def test_what_is_something_else(name: str) -> None:
    assert mapped(name) == {}
