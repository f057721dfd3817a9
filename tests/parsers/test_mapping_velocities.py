"""Columns u and v: velocities ahead and to the side where they stand together, and a speed that is none."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.load import load_drive
from parsers.mapping import propose_and_say, reasons_beside

M, R = "m/s", "rad/s"


def columns(units: Mapping[str, str | None]) -> list[ChannelInfo]:
    return [ChannelInfo(name, "t", unit, "table", tags={"column": name}) for name, unit in units.items()]


def speed_of(units: Mapping[str, str | None]) -> str | None:
    found = propose_and_say(columns(units), None)[0].get("speed")
    return None if found is None else found[0].channels[0]


SURE = [
    ({"u": M, "v": M, "w": M, "p": R, "q": R, "r": R}, "u"),
    ({"u": M, "v": M, "r": R}, "u"),
    ({"u": "km/h", "v": "km/h", "r": "deg/s"}, "u"),
    ({"u": None, "v": None, "p": None, "q": None, "r": None}, "u"),
    ({"U": M, "V": M, "P": R, "Q": R, "R": R}, "U"),
    ({"body.u": M, "body.v": M, "body.r": R}, "body.u"),
    ({"u_mps": M, "v_mps": M, "r_radps": R}, "u_mps"),
    ({"u": M, "v": M, "r": R, "speed": M}, "speed"),
]


@pytest.mark.parametrize(("units", "speed"), SURE)
def test_u_beside_v_and_angular_rates_is_the_speed(units: dict[str, str | None], speed: str) -> None:
    assert speed_of(units) == speed
    assert "to the side" in reasons_beside(columns(units))[[*units][1]]


@pytest.mark.parametrize(
    "units",
    [
        {"u": M, "v": M},
        {"u": None, "v": None, "psi": None},
        {"u": M, "v": M, "yaw_rate": R},
        {"u": None, "v": None, "r": None},
    ],
)
def test_without_the_rates_neither_is_and_it_is_said(units: dict[str, str | None]) -> None:
    assert speed_of(units) is None
    (said,) = (each for each in propose_and_say(columns(units), None)[1] if each.startswith("v is not taken"))
    assert "u the one ahead" in said


@pytest.mark.parametrize(
    "units",
    [{"u": "V", "v": M}, {"u": None, "v": "km/h"}, {"U": None, "v": None}, {"v": M, "r": R}, {"v": None}],
)
def test_a_v_without_such_a_u_is_a_speed(units: dict[str, str | None]) -> None:
    assert speed_of(units) == "v"


def drive(path: Path, head: str, *more: np.ndarray) -> Path:
    """A slalom at 20 m/s: time, lateral acceleration, yaw rate, and more columns."""
    t = np.arange(6000) / 100
    yaw_rate = 0.2 * np.sin(0.6 * t)
    table = np.column_stack([t, 20 * yaw_rate, yaw_rate, *more])
    np.savetxt(path, table, delimiter=",", header=head, comments="", fmt="%.9g")
    return path


def test_a_vehicle_s_table_by_textbook_letters(tmp_path: Path) -> None:
    side = 0.2 * np.sin(0.6 * np.arange(6000) / 100)
    path = drive(
        tmp_path / "sim.csv", "t,ay [m/s2],r [rad/s],v [m/s],u [m/s]", side, np.full(6000, 20) + side
    )
    found = load_drive((path,))
    assert found.signals["speed"].values == pytest.approx(20 + side)
    assert found.signals["yaw_rate"].values == pytest.approx(side)


def test_a_velocity_to_the_side_that_is_called_speed_is_left_out(tmp_path: Path) -> None:
    """Its yaw rate stays: as a speed it would make that one 57 times too small."""
    side = 0.35 * np.sin(0.6 * np.arange(6000) / 100)
    found = load_drive((drive(tmp_path / "sim.csv", "t,ay [m/s2],yaw_rate [rad/s],v [m/s]", side),))
    assert set(found.signals) == {"accel_y", "yaw_rate"}
    assert abs(found.signals["yaw_rate"].values).max() == pytest.approx(0.2, rel=1e-3)
    (said,) = (each for each in found.record.decisions if each.signal == "speed")
    assert "hardly exceeds 0.35 m/s" in said.found
    assert "about 20 m/s" in said.found


def test_a_vehicle_that_creeps_keeps_its_speed(tmp_path: Path) -> None:
    t = np.arange(6000) / 100
    yaw_rate = 0.2 * np.sin(0.6 * t)
    table = np.column_stack([t, 1.2 * yaw_rate, yaw_rate, np.full(6000, 1.2)])
    path = tmp_path / "slow.csv"
    head = "t,ay [m/s2],yaw_rate [rad/s],speed [m/s]"
    np.savetxt(path, table, delimiter=",", header=head, comments="", fmt="%.9g")
    assert "speed" in load_drive((path,)).signals
