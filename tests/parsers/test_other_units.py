"""Inertial units that are mounted otherwise: left out, and another one of the log taken where there is one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer

from parsers.checks.upright import not_upright
from parsers.convert import convert_logs
from parsers.drive import Drive, Signal
from parsers.intake import Budget
from parsers.load import LoadOptions, load_drive

T = np.arange(3000) / 50
SPEED = 15 + 6 * np.sin(0.5 * T) * (1 + 0.3 * np.sin(0.11 * T))
YAW = 0.25 * np.sin(0.8 * T)
BODY = {
    "accel_x": np.gradient(SPEED, T),
    "accel_y": SPEED * YAW,
    "accel_z": 9.81 + 0.3 * np.sin(7 * T),
    "roll_rate": np.gradient(0.006 * SPEED * YAW, T),
    "pitch_rate": -np.gradient(0.004 * np.gradient(SPEED, T), T),
    "yaw_rate": YAW,
}
AXES = ("x", "y", "z")


def turned(*axes: tuple[int, str]) -> dict[str, np.ndarray]:
    """What a unit measures whose x, y, z are these of the body's axes, with a sign."""
    rates = {"x": "roll_rate", "y": "pitch_rate", "z": "yaw_rate"}
    return {
        f"accel_{own}": sign * BODY[f"accel_{of}"] for own, (sign, of) in zip(AXES, axes, strict=True)
    } | {rates[own]: sign * BODY[rates[of]] for own, (sign, of) in zip(AXES, axes, strict=True)}


SIDEWAYS = turned((1, "y"), (-1, "x"), (1, "z"))
OPTICAL = turned((-1, "y"), (-1, "z"), (1, "x"))


def log(path: Path, **topics: dict[str, np.ndarray]) -> Path:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("vehicle", "jsonschema", b'{"type": "object"}')
        topics = {**topics, "wheels": {"speed": SPEED}}
        numbers = {topic: writer.register_channel(f"/{topic}", "json", schema) for topic in topics}
        for at, second in enumerate(T):
            stamp = 1_700_000_000_000_000_000 + round(second * 1e9)
            for topic, columns in topics.items():
                text = json.dumps({name: float(values[at]) for name, values in columns.items()})
                writer.add_message(numbers[topic], stamp, text.encode(), stamp)
        writer.finish()
    return path


def check_body(drive: Drive) -> None:
    assert set(drive.signals) == {*BODY, "speed"}
    for name, values in BODY.items():
        assert drive.signals[name].values == pytest.approx(values), name
        assert drive.signals[name].group == "/b"
    (said,) = (each for each in drive.record.decisions if each.kind == "choice")
    assert "/a" in said.found
    assert "of /b" in said.action
    entry = next(each for each in drive.record.mapped if each.signal == "accel_y")
    assert entry.channel == "/b.accel_y"
    assert entry.used
    assert "/a.accel_y" in entry.alternatives


@pytest.mark.parametrize("first", [SIDEWAYS, OPTICAL], ids=["sideways", "optical"])
def test_the_other_unit_is_taken(tmp_path: Path, first: dict[str, np.ndarray]) -> None:
    check_body(load_drive((log(tmp_path / "a.mcap", a=first, b=BODY),)))


def test_a_long_drive_takes_it_too(tmp_path: Path) -> None:
    path = log(tmp_path / "a.mcap", a=SIDEWAYS, b=BODY)
    budget = Budget(tmp_path / "out", rows=5_000, pending=2_000, window=9_000)
    record = convert_logs((path,), LoadOptions(), tmp_path / "out", budget).record
    entries = {each.signal: each for each in record.mapped if each.used}
    assert entries["accel_y"].channel == "/b.accel_y"
    drive = load_drive(sorted((tmp_path / "out").glob("*.parquet")))
    assert drive.signals["accel_y"].values == pytest.approx(BODY["accel_y"])


def test_no_unit_is_taken_for_another_that_is_no_better_or_with_no_fix(tmp_path: Path) -> None:
    path = log(tmp_path / "a.mcap", a=SIDEWAYS, b=SIDEWAYS)
    assert "accel_y" not in load_drive((path,)).signals
    path = log(tmp_path / "b.mcap", a=SIDEWAYS, b=BODY)
    assert load_drive((path,), LoadOptions(fix=False)).signals["accel_y"].group == "/a"


def test_a_unit_in_a_camera_s_axes_is_left_out_with_what_turns_it(tmp_path: Path) -> None:
    drive = load_drive((log(tmp_path / "a.mcap", a=OPTICAL),))
    assert set(drive.signals) == {"speed"}
    (said,) = (each for each in drive.record.decisions if "upright" in each.found)
    assert "gravity is on its y axis, which points down" in said.found
    assert "accel_x is z's channel, accel_y -1 × x's, accel_z -1 × y's" in said.action


def signals(columns: dict[str, np.ndarray]) -> dict[str, Signal]:
    time_ns = np.arange(len(T), dtype=np.int64) * 20_000_000
    return {name: Signal(name, time_ns, values, name, group="a") for name, values in columns.items()}


def test_units_that_are_upright_stay() -> None:
    assert not not_upright(signals(BODY))
    assert not not_upright(signals(BODY | {"accel_z": BODY["accel_z"] - 9.81}))
    # a skid pad at 1 g, which an upright unit feels beside gravity
    assert not not_upright(signals(BODY | {"accel_y": np.full(len(T), 9.8)}))
    nose_down = turned((1, "z"), (1, "y"), (-1, "x"))
    (decision,) = set(not_upright(signals(nose_down)).values())
    assert "its x axis, which points up" in decision.found
