"""A log in local time beside one in UTC: laid by whole quarters of an hour where a signal of both proves it."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from parsers.load import load_drive

BEGAN = datetime(2026, 11, 23, 12, 5, 22)


def speeds(t: np.ndarray) -> np.ndarray:
    rng = np.random.default_rng(3)
    knots = np.arange(0, 400, 4.0)
    return np.interp(t, knots, 15 + np.cumsum(rng.normal(0, 1.0, len(knots))).clip(-12, 20))


def table(path: Path, name: str, begins_s: float, zone: str, clock_h: float, other: float = 0.0) -> Path:
    """A minute and a half from `begins_s` of the drive on, stamps as a clock `clock_h` ahead of UTC shows them."""
    t = begins_s + np.arange(0, 90, 0.05)
    values = speeds(t + other)
    rows = [f"time,{name}"]
    for at, value in zip(t, values, strict=True):
        moment = BEGAN + timedelta(seconds=float(at), hours=clock_h)
        rows.append(f"{moment.isoformat(timespec='milliseconds')}{zone},{value:.4f}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("clock_h", [2.0, -5.0, 5.75])
@pytest.mark.parametrize("name", ["speed_mps", "wheel_speed_rl_mps"])
def test_local_time_is_laid_beside_utc(tmp_path: Path, name: str, clock_h: float) -> None:
    local = table(tmp_path / "bus.csv", name, 10.0, "", clock_h)
    receiver = table(tmp_path / "receiver.csv", "gps_speed_2d_mps", 0.0, "Z", 0.0)
    drive = load_drive([local, receiver])
    bus, satellites = drive.signals[name.removesuffix("_mps")], drive.signals["gps_speed_2d"]
    assert bus.time_ns[0] - satellites.time_ns[0] == pytest.approx(10e9, abs=1e6)
    (said,) = [
        note
        for note in drive.record.notes
        if ("local time" in note and "ahead of UTC" in note) or "behind UTC" in note
    ]
    assert f"bus.csv are local time, {abs(clock_h):g} h" in said
    assert not [note for note in drive.record.notes if "share no time" in note]


@pytest.mark.parametrize(
    ("zone", "clock_h", "other"), [("Z", 2.0, 0.0), ("", 2.0, 170.0), ("", 2.1, 0.0), ("", 0.0, 0.0)],
    ids=["said to be UTC", "another drive", "no time zone", "as it is"],
)  # fmt: skip
def test_without_proof_a_log_lies_where_its_stamps_say(
    tmp_path: Path, zone: str, clock_h: float, other: float
) -> None:
    bus = table(tmp_path / "bus.csv", "speed_mps", 10.0, zone, clock_h, other)
    receiver = table(tmp_path / "receiver.csv", "gps_speed_2d_mps", 0.0, "Z", 0.0)
    drive = load_drive([bus, receiver])
    apart = drive.signals["speed"].time_ns[0] - drive.signals["gps_speed_2d"].time_ns[0]
    assert apart == pytest.approx(10e9 + clock_h * 3600e9, abs=1e6)
