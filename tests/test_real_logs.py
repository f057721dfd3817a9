"""Logs that other people recorded with real instruments: their known faults are found, and no figure is made up.

The logs lie beside the repository (../shared/real_logs); without them these tests skip.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from cogest_cli.main import app

VOLVO = """
[vehicle]
name = "Volvo V40"
body = "Hatchback"
mass_kg = 1355
wheelbase_m = 2.55
track_front_m = 1.565
track_rear_m = 1.565
"""

Results = dict[str, Any]


def run(*arguments: object) -> str:
    done = CliRunner().invoke(app, [str(a) for a in arguments])
    assert done.exit_code == 0, done.output
    assert done.stderr == ""
    return done.stdout


@pytest.fixture(scope="module")
def analyse(real_logs: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Results]:
    """Analyse a log with a vehicle file's text; the results.json."""

    def analyse(name: str, vehicle: str = "") -> Results:
        folder = tmp_path_factory.mktemp("real")
        options: list[object] = []
        if vehicle:
            (folder / "car.toml").write_text(vehicle, encoding="utf-8")
            options = ["--vehicle", folder / "car.toml"]
        printed = run("analyze", real_logs / name, *options, "--format", "json", "--out", folder)
        assert "not identifiable" in printed
        results: Results = json.loads((folder / "results.json").read_text(encoding="utf-8"))
        return results

    return analyse


@pytest.fixture(scope="module")
def slalom(analyse: Callable[[str, str], Results]) -> Results:
    return analyse("volvo_v40_slalom_35kph.vbo", VOLVO)


def decision(results: Results, signal: str, kind: str) -> dict[str, Any]:
    found = [d for d in results["import"]["decisions"] if (d["signal"], d["kind"]) == (signal, kind)]
    assert found, f"no {kind} of {signal} was found"
    return found[0]


def test_the_slaloms_faults_are_found_and_said(slalom):
    sign = decision(slalom, "yaw_rate", "sign")
    assert (sign["applied"], sign["action"]) == (True, "inverted")
    assert decision(slalom, "roll", "sign")["applied"]
    spikes = decision(slalom, "steering_wheel_angle", "spikes")
    assert spikes["applied"]
    assert "27899°" in spikes["evidence"]
    offset = decision(slalom, "roll_rate", "offset")
    assert not offset["applied"]
    assert 0.33 <= float(offset["found"].split("offset of ")[1].split()[0]) <= 0.40
    (gap,) = [gap for gap in slalom["import"]["gaps"] if gap["signal"] is None]
    assert (gap["start_s"], gap["end_s"]) == (pytest.approx(33.15, abs=0.05), pytest.approx(35.19, abs=0.05))
    assert not any(entry["used"] for entry in slalom["import"]["mapped"] if entry["signal"] == "pitch")
    assert slalom["import"]["status"] == "complete"


def test_the_slalom_gives_its_roll_gradient(slalom):
    gradient = slalom["verdict"]["roll_gradient_degpg"]
    # its spread of 8 % lies on the limit between the two
    assert gradient["status"] in ("identified", "weak")
    assert gradient["std"] < 0.1 * gradient["value"]
    assert gradient["low"] < 6.6 < 6.9 < gradient["high"]
    assert 6.3 <= gradient["value"] <= 7.2
    assert gradient["low"] < gradient["value"] < gradient["high"]


def test_the_slaloms_height_is_no_surer_than_the_log_justifies(slalom):
    height = slalom["verdict"]["cg_height_m"]
    assert height["status"] in ("weak", "not_identifiable")
    assert height["low"] <= 0.50
    assert height["high"] >= 0.60
    # the log says K/(m h) and the vehicle file no stiffness: the prior's spread must stay
    assert height["std"] >= 0.8 * height["prior"]["std"]
    assert height["reason"]


def test_the_slaloms_height_is_weak_once_springs_roll_centres_and_load_are_stated(analyse):
    """What the log says is K / (m h): a height follows from what its reason asks for, and no surer than that."""
    stated = VOLVO.replace('body = "Hatchback"\n', "") + (
        "roll_stiffness_nmprad = {value = 62000, std = 3000}\n"
        "roll_center_height_front_m = {value = 0.06, std = 0.03}\n"
        "roll_center_height_rear_m = {value = 0.12, std = 0.04}\n"
        "[load]\nmass_kg = {value = 75, std = 5}\n"
    )
    height = analyse("volvo_v40_slalom_35kph.vbo", stated)["verdict"]["cg_height_m"]
    assert height["status"] == "weak"
    # the nearest of the measured vehicles: 0.55 ± 0.03
    assert height["low"] < 0.53 < 0.57 < height["high"]
    assert 0.02 < height["std"] < 0.8 * height["prior"]["std"]


def test_the_car_that_stands_still_teaches_nothing(analyse):
    results = analyse("volvo_v40_standstill.vbo", VOLVO)
    for name, parameter in results["verdict"].items():
        assert parameter["status"] == "not_identifiable", name
        assert parameter["reason"]
        if parameter["value"] is not None:
            assert parameter["value"] == pytest.approx(parameter["prior"]["value"])
    assert results["verdict"]["roll_gradient_degpg"]["value"] is None
    assert (
        0.33
        <= float(decision(results, "roll_rate", "offset")["found"].split("offset of ")[1].split()[0])
        <= 0.40
    )


@pytest.mark.parametrize("name", ["truck_j1939.mf4", "husky_imu_odometry.bag"])
def test_the_truck_and_the_robot_give_reasons_and_no_figures(analyse, name):
    results = analyse(name)
    assert results["verdict"]
    for parameter in results["verdict"].values():
        assert parameter["status"] == "not_identifiable"
        assert [parameter[key] for key in ("value", "std", "low", "high")] == [None] * 4
        assert len(parameter["reason"]) > 20
    assert results["rollover"]["static_stability_factor"] is None or (
        results["rollover"]["static_stability_factor"]["value"] is None
    )


@pytest.mark.parametrize(
    ("name", "usable"),
    [
        (
            "volvo_v40_slalom_35kph.vbo",
            {
                "X_Accel": "accel_x",
                "Y_Accel": "accel_y",
                "Z_Accel": "accel_z",
                "RollRate": "roll_rate",
                "PitchRate": "pitch_rate",
                "YawRate": "yaw_rate",
                "Roll_Angle": "roll",
                "velocity": "speed",
                "SteerAng": "steering_wheel_angle",
                "lat": "latitude",
                "long": "longitude",
            },
        ),
        ("volvo_v40_standstill.vbo", {"Y_Accel": "accel_y", "RollRate": "roll_rate", "velocity": "speed"}),
        (
            "truck_j1939.mf4",
            {
                "CCVS1.WheelBasedVehicleSpeed": "speed",
                "EBC2.RelativeSpeedFrontAxleLeftWheel": "wheel_speed_fl",
                "EBC2.RelativeSpeedRearAxle1RightWheel": "wheel_speed_rr",
            },
        ),
        (
            "husky_imu_odometry.bag",
            {
                "/imu/data.linear_acceleration.y": "accel_y",
                "/imu/data.angular_velocity.z": "yaw_rate",
                "/imu/data.orientation.w": "roll, pitch",
                "/jackal_velocity_controller/odom.twist.twist.linear.x": "speed",
            },
        ),
    ],
)
def test_inspect_names_the_usable_channels(real_logs, name, usable):
    found = json.loads(run("inspect", real_logs / name, "--json"))
    channels = {channel["name"]: channel for channel in found["channels"]}
    assert {channel: channels[channel]["signal"] for channel in usable} == usable
    assert all(channel["reason"] for channel in channels.values())
    assert found["problem"] is None
