"""Joint states that a mapping file takes by place are said to be by place."""

from __future__ import annotations

from pathlib import Path

from parsers.channels import ChannelInfo
from parsers.mapping import propose_and_say, read_map

STEER = ChannelInfo(
    "/joint_states.position[0]",
    "/joint_states",
    None,
    "ros",
    tags={"topic": "/joint_states", "type": "sensor_msgs/JointState", "field": "position[0]"},
)


def test_a_joint_by_its_place_is_said(tmp_path: Path) -> None:
    path = tmp_path / "map.toml"
    path.write_text(f'[signals.steering_wheel_angle]\nchannel = "{STEER.name}"\nunit = "rad"\n')
    proposals, (sentence,) = propose_and_say([STEER], read_map(path))
    assert proposals["steering_wheel_angle"][0].channels == (STEER.name,)
    assert sentence.startswith("steering_wheel_angle: of /joint_states, by place")


def test_joints_that_nobody_takes_are_not() -> None:
    assert propose_and_say([STEER], None) == ({}, ())
