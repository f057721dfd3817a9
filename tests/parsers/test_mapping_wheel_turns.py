"""Wheel speeds that are logged as turn rates: speeds with the wheel's radius, and refused without."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.errors import MappingError
from parsers.load import LoadOptions, load_drive
from parsers.mapping import WheelRadius, propose, propose_and_say, read_map, starter_map
from parsers.signals import WHEEL_SPEEDS
from pipelines.vehicles.vehicle_file import parse_vehicle
from pipelines.vehicles.wheel_radius import wheel_radius

RADIUS = WheelRadius(0.3, 0.4, "van.toml")
CORNERS = ("front_left", "front_right", "rear_left", "rear_right")


def column(name: str, unit: str | None) -> ChannelInfo:
    return ChannelInfo(name, "table", unit, "table", tags={"column": name})


def table_of(unit: str | None) -> list[ChannelInfo]:
    return [column(f"wheel_speed_{corner}", unit) for corner in CORNERS]


def of_ros(unit: str | None = None) -> list[ChannelInfo]:
    kind = "dbw_mkz_msgs/WheelSpeedReport"
    return [
        ChannelInfo(
            f"/vehicle/wheel_speed_report.{corner}", "/vehicle/wheel_speed_report", unit, "ros",
            tags={"topic": "/vehicle/wheel_speed_report", "type": kind, "field": corner},
        )
        for corner in CORNERS
    ]  # fmt: skip


def of_ford() -> list[ChannelInfo]:
    return [
        ChannelInfo(
            f"W.Whl{corner}_W_Meas", "W", None, "can", tags={"message": "W", "signal": f"Whl{corner}_W_Meas"}
        )
        for corner in ("Fl", "Fr", "Rl", "Rr")
    ]


@pytest.mark.parametrize(
    ("channels", "scale"),
    [
        (table_of("rad/s"), 1.0),
        (table_of("rpm"), math.pi / 30),
        (table_of("deg/s"), math.pi / 180),
        (of_ros(), 1.0),
        (of_ros("rad/s"), 1.0),
        (of_ford(), 1.0),
        ([column(f"Car.WheelSpd_{w}", None) for w in ("FL", "FR", "RL", "RR")], 1.0),
        ([column(f"AVy_{w}", None) for w in ("L1", "R1", "L2", "R2")], math.pi / 30),
        ([column(f"omega_{w} [rad/s]", None) for w in ("fl", "fr", "rl", "rr")], 1.0),
    ],
)
def test_a_turn_rate_is_a_speed_with_the_radius_and_refused_without(
    channels: list[ChannelInfo], scale: float
) -> None:
    proposals, said = propose_and_say(channels, None, RADIUS)
    scales = [proposals[signal][0].unit.scale for signal in WHEEL_SPEEDS]
    assert scales == pytest.approx([scale * 0.3] * 2 + [scale * 0.4] * 2)
    assert [proposals[signal][0].channels[0] for signal in WHEEL_SPEEDS] == [each.name for each in channels]
    assert any("0.3 m in front and 0.4 m behind as van.toml has it" in sentence for sentence in said)
    proposals, said = propose_and_say(channels, None)
    assert proposals == {}
    assert sum("without the wheel's radius: the vehicle file's wheel_radius_m" in each for each in said) == 4


def test_a_speed_that_is_one_comes_first_and_others_stay() -> None:
    channels = [*table_of("rad/s"), *(column(f"wss_{w}", "km/h") for w in ("fl", "fr", "rl", "rr"))]
    found = propose(channels, None, RADIUS)
    assert [found[signal][0].channels[0] for signal in WHEEL_SPEEDS] == [
        "wss_fl",
        "wss_fr",
        "wss_rl",
        "wss_rr",
    ]
    assert len(found["wheel_speed_fl"]) == 2
    # the radius makes nothing else a speed, and a speed stays what it is
    assert "speed" not in propose([column("speed", "rad/s"), column("engine_speed", "rpm")], None, RADIUS)
    (plain,) = propose([column("wheel_speed_fl", "m/s")], None, RADIUS)["wheel_speed_fl"]
    assert plain.unit.scale == 1.0


def test_the_mapping_file_tells_the_radius_and_comes_first(tmp_path: Path) -> None:
    path = tmp_path / "map.toml"
    path.write_text(
        '[wheels]\nradius_front_m = 0.25\nradius_rear_m = 0.5\n\n[signals.wheel_speed_fl]\nchannel = "omega"\nunit = "rpm"\n'
    )
    channels = [column("omega", None), column("wheel_speed_rr", "rad/s")]
    found, said = propose_and_say(channels, read_map(path), RADIUS)
    assert found["wheel_speed_fl"][0].unit.scale == pytest.approx(math.pi / 30 * 0.25)
    assert found["wheel_speed_rr"][0].unit.scale == pytest.approx(0.5)
    assert any("as map.toml has it" in sentence for sentence in said)
    # what the starter writes can be read again
    path.write_text(starter_map(channels, found))
    again = propose(channels, read_map(path))
    assert again["wheel_speed_fl"][0].unit.scale == pytest.approx(math.pi / 30 * 0.25)
    assert again["wheel_speed_rr"][0].unit.scale == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[wheels]\nradius_m = 3.4\n", "no wheel has a radius of 3.4 m"),
        ("[wheels]\nradius_m = 0\n", "no wheel has a radius of 0 m"),
        ("[wheels]\nradius_front_m = 0.3\n", "no wheel has a radius of 0 m"),
        ('[wheels]\nradius_m = "0.3"\n', "radius_m must be a finite number"),
        ("[wheels]\nradius = 0.3\n", "unknown key 'radius'.*radius_m"),
        ("wheels = 3\n", "must be a table"),
    ],
)
def test_what_is_no_radius(tmp_path: Path, text: str, problem: str) -> None:
    path = tmp_path / "map.toml"
    path.write_text(text)
    with pytest.raises(MappingError, match=problem):
        read_map(path)


def test_a_turn_rate_in_the_mapping_file_without_a_radius(tmp_path: Path) -> None:
    path = tmp_path / "map.toml"
    path.write_text('[signals.wheel_speed_fl]\nchannel = "omega"\nunit = "rad/s"\n')
    with pytest.raises(MappingError, match=r"without the wheel's radius.*wheel_radius_m"):
        propose([column("omega", None)], read_map(path))


def test_the_vehicle_files_radius_in_a_drive(tmp_path: Path) -> None:
    log = tmp_path / "drive.csv"
    rows = "".join(f"{k / 50:.2f},{50 + 10 * np.sin(k / 40):.6f}\n" for k in range(600))
    log.write_text("time,wheel_speed_fl [rad/s]\n" + rows)
    vehicle = parse_vehicle("[vehicle]\nwheel_radius_m = 0.32\n", tmp_path / "vehicle.toml")
    drive = load_drive([log], LoadOptions(radius=wheel_radius(vehicle)))
    assert drive.signals["wheel_speed_fl"].values[0] == pytest.approx(16.0)
    assert any("0.32 m as vehicle.toml has it" in note for note in drive.record.notes)
    assert wheel_radius(None) is None
    assert wheel_radius(parse_vehicle("[vehicle]\n", tmp_path / "vehicle.toml")) is None
