"""What `inspect` finds out: rates and gaps however the rows come, what became of each channel, what is lacking."""

from __future__ import annotations

from pathlib import Path

import can
import numpy as np
import polars as pl
import pytest

from parsers.load import LoadOptions
from parsers.mapping import read_map
from pipelines.inspection import Inspection, inspect_log

SECONDS = np.arange(600) / 20


def motion(count: int = 600) -> dict[str, np.ndarray]:
    t = np.arange(count) / 20
    return {
        "time_s": t,
        "speed_mps": 10 + np.sin(t / 5),
        "accel_y_mps2": 2 * np.sin(t),
        "roll_rad": 0.03 * np.sin(t),
    }


def look(tmp_path: Path, columns: dict[str, object], options: LoadOptions | None = None) -> Inspection:
    path = tmp_path / "log.csv"
    pl.DataFrame(columns).write_csv(path)
    return inspect_log(path, options or LoadOptions(), None)


def channel(inspection: Inspection, name: str):
    return next(c for c in inspection.channels if c.name == name)


def test_samples_rates_ranges_and_gaps(tmp_path):
    columns = motion()
    columns["time_s"] = np.where(SECONDS < 15, SECONDS, SECONDS + 4)
    columns["speed_mps"] = [None if i % 10 == 3 else 10 + i / 1000 for i in range(600)]
    found = look(tmp_path, columns)
    speed = channel(found, "speed_mps")
    assert (speed.samples, speed.gaps, speed.signal) == (540, 1, "speed")
    assert (speed.low, speed.high) == (10.0, 10.599)
    # nine of ten samples at 20 Hz; where nothing was recorded no rate is
    assert speed.rate_hz == pytest.approx(18)
    assert found.duration_s == pytest.approx(33.95)
    assert found.readiness[0].ready


def test_a_clock_that_was_set_does_not_stretch_the_log(tmp_path):
    columns = motion()
    columns["time_s"][100] = 1e9
    found = look(tmp_path, columns)
    assert found.duration_s == pytest.approx(29.95)
    assert channel(found, "speed_mps").rate_hz == pytest.approx(20, rel=0.01)
    assert found.drive is not None
    assert found.drive.record.rejected["row beyond a jump of the clock"] == 1


def test_rows_out_of_order_make_no_gaps(tmp_path):
    columns = {name: values.copy() for name, values in motion().items()}
    for values in columns.values():
        values[[50, 51]] = values[[51, 50]]
    found = look(tmp_path, columns)
    assert channel(found, "speed_mps").gaps == 0
    assert channel(found, "speed_mps").rate_hz == pytest.approx(20)
    assert found.drive is not None
    assert found.drive.record.out_of_order == 1


def test_every_channel_says_what_became_of_it(tmp_path):
    columns = {**motion(), "wheel": 1.0, "empty_radps": [None] * 600, "comment": ["text"] * 600}
    columns["vehicle_speed"] = columns["speed_mps"] + 0.01
    columns["pitch_rad"] = 0.0
    found = look(tmp_path, columns)
    assert all(c.reason for c in found.channels if c.kind == "number")
    assert channel(found, "vehicle_speed").reason == "could be speed, but speed_mps ranks before it"
    assert channel(found, "pitch_rad").reason == "pitch, left out: pitch stands at 0° for the whole drive"
    assert channel(found, "pitch_rad").signal is None


def test_one_sample_is_no_signal_and_says_so(tmp_path):
    found = look(tmp_path, motion(1))
    assert found.drive is None
    assert "no signal has two valid samples" in (found.problem or "")
    assert channel(found, "speed_mps").reason == "could be speed, but has fewer than two valid samples"
    assert not found.readiness[0].ready
    assert found.duration_s == 0.0


def test_a_map_ignores_and_renames(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text(
        '[signals.roll]\nignore = true\n[signals.pitch]\nchannel = "roll_rad"\nunit = "rad"\n',
        encoding="utf-8",
    )
    found = look(tmp_path, motion(), LoadOptions(read_map(path)))
    assert found.drive is not None
    assert "roll" not in found.drive.signals
    assert channel(found, "roll_rad").signal == "pitch"


MUXED = """VERSION ""

BU_: A

BO_ 512 Chassis: 8 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" A
 SG_ VehicleSpeed m0 : 8|16@1+ (0.01,0) [0|0] "km/h" A
 SG_ YawRate m1 : 8|16@1- (0.01,0) [0|0] "deg/s" A
"""


def test_multiplexed_signals_have_their_own_rates(tmp_path):
    (tmp_path / "car.dbc").write_text(MUXED, encoding="utf-8")
    log = tmp_path / "drive.blf"
    with can.BLFWriter(log) as writer:
        for i in range(900):
            page = 0 if i % 3 else 1
            data = bytes([page, *(1000 + i).to_bytes(2, "little"), 0, 0, 0, 0, 0])
            writer.on_message_received(
                can.Message(timestamp=1.7e9 + i / 100, arbitration_id=512, data=data, is_extended_id=False)
            )
    found = inspect_log(log, LoadOptions(dbc=(tmp_path / "car.dbc",)), None)
    speed, yaw = (channel(found, f"Chassis.{name}") for name in ("VehicleSpeed", "YawRate"))
    assert (speed.samples, yaw.samples) == (600, 300)
    assert speed.rate_hz == pytest.approx(66.7, rel=0.01)
    assert yaw.rate_hz == pytest.approx(33.3, rel=0.01)
    assert (speed.gaps, yaw.gaps) == (0, 0)
    assert (speed.low, speed.high) == (pytest.approx(10.01), pytest.approx(18.99))


def test_many_channels_are_listed(tmp_path):
    rng = np.random.default_rng(0)
    columns = {**motion(200), **{f"x{i}": rng.normal(size=200) for i in range(1500)}}
    found = look(tmp_path, columns)
    assert len(found.channels) == 1503
