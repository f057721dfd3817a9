"""Velocities along x and y: of a body's axes x is the speed, of others' their length is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.convert import convert_logs
from parsers.drive import Drive
from parsers.intake import Budget
from parsers.load import LoadOptions, load_drive
from parsers.mapping import propose, read_map

T = np.arange(6000) / 50
SPEED = 12 + 6 * np.sin(0.2 * T)
RATE = 0.25 * np.sin(0.35 * T) + 0.02
HEADING = np.cumsum(RATE) / 50


def log(path: Path, x: np.ndarray, y: np.ndarray, rate: np.ndarray | None = RATE) -> Path:
    head, columns = "t,Vx [m/s],Vy [m/s]", [T, x, y]
    if rate is not None:
        head, columns = f"{head},yaw_rate [rad/s]", [*columns, rate]
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=head, comments="", fmt="%.9g")
    return path


def loaded(path: Path, **more: object) -> Drive:
    return load_drive((path,), LoadOptions(**more))  # type: ignore[arg-type]


def said(drive: Drive) -> list[str]:
    return [note for note in drive.record.notes if "is not taken for speed" in note]


@pytest.mark.parametrize("turned", [0.0, 2.0])
def test_velocities_along_the_world_s_axes_become_their_length(tmp_path: Path, turned: float) -> None:
    at = HEADING + turned
    drive = loaded(log(tmp_path / "a.csv", SPEED * np.cos(at), SPEED * np.sin(at)))
    assert set(drive.signals) == {"gps_speed_2d", "yaw_rate"}
    assert drive.signals["gps_speed_2d"].values == pytest.approx(SPEED)
    assert "along fixed axes" in said(drive)[0]


def test_a_weave_about_the_x_axis_is_told_by_the_yaw_rate(tmp_path: Path) -> None:
    at = 0.15 * np.sin(1.5 * T)
    drive = loaded(log(tmp_path / "a.csv", SPEED * np.cos(at), SPEED * np.sin(at), np.gradient(at, T)))
    assert "gps_speed_2d" in drive.signals


def test_without_a_yaw_rate_the_size_beside_tells(tmp_path: Path) -> None:
    drive = loaded(log(tmp_path / "a.csv", SPEED * np.cos(0.5), SPEED * np.sin(0.5), None))
    assert drive.signals["gps_speed_2d"].values == pytest.approx(SPEED)
    assert "29° aside" in said(drive)[0]


BODIES = {
    "slip": -0.03 * SPEED * RATE + 1.4 * RATE,
    "none": 0 * T,
    "noise": 0.05 * np.random.default_rng(1).standard_normal(len(T)),
    "drift": -1.2 * SPEED * RATE,
}


@pytest.mark.parametrize("body", BODIES)
def test_a_body_s_velocity_ahead_stays_the_speed(tmp_path: Path, body: str) -> None:
    drive = loaded(log(tmp_path / "a.csv", SPEED, BODIES[body]))
    assert drive.signals["speed"].values == pytest.approx(SPEED)
    assert not said(drive)


def test_a_vehicle_that_goes_backwards_keeps_its_sign(tmp_path: Path) -> None:
    ahead = SPEED * np.sign(np.sin(0.1 * T))
    drive = loaded(log(tmp_path / "a.csv", ahead, 1.4 * RATE))
    assert drive.signals["speed"].values.min() < -10


def test_a_long_drive_is_told_alike(tmp_path: Path) -> None:
    path = log(tmp_path / "a.csv", SPEED * np.cos(HEADING), SPEED * np.sin(HEADING))
    budget = Budget(tmp_path / "out", rows=5_000, pending=2_000, window=9_000)
    convert_logs((path,), LoadOptions(), tmp_path / "out", budget)
    drive = load_drive(sorted((tmp_path / "out").glob("*.parquet")))
    assert set(drive.signals) == {"gps_speed_2d", "yaw_rate"}
    assert drive.signals["gps_speed_2d"].values == pytest.approx(SPEED)


def test_what_the_user_says_stands(tmp_path: Path) -> None:
    path = log(tmp_path / "a.csv", SPEED * np.cos(HEADING), SPEED * np.sin(HEADING))
    (tmp_path / "map.toml").write_text('[signals.speed]\nchannel = "Vx"\n')
    drive = loaded(path, map=read_map(tmp_path / "map.toml"))
    assert "speed" in drive.signals


def test_a_twist_of_odometry_knows_what_is_beside_it() -> None:
    fields = [f"twist.twist.{part}" for part in ("linear.x", "linear.y", "angular.z")]
    channels = [
        ChannelInfo(
            f"/truth.{field}",
            "/truth",
            None,
            "ros",
            tags={"topic": "/truth", "type": "nav_msgs/Odometry", "field": field},
        )
        for field in fields
    ]
    (speed,) = propose(channels, None)["speed"]
    assert speed.across == "/truth.twist.twist.linear.y"
    assert speed.turning == ("/truth.twist.twist.angular.z", 1.0)
