"""Longitudinal acceleration against the change of speed: scales that differ are said, and what hangs on them is no surer."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from parsers.drive import Decision, Drive, ImportRecord, Signal
from pipelines.analyze import Request, analyze
from pipelines.prepare.longitudinal_scale import DIVES, hanging_along, longitudinal_doubt
from pipelines.prepare.scale_doubt import ScaleDoubt, as_sure_as_the_scale, kept_as_sure, with_doubt
from pipelines.results import ParameterEstimate

HZ = 50.0
SAMPLE = Path(__file__).parents[2] / "sample_logs"
DOUBT = ScaleDoubt(0.2, "accel_x is 1.20 times the change of speed: the scale of one of them is wrong", "")


def _drive(scale: float = 1.0, *, dives: float = 0.03, late_s: float = 0.0, grade: float = 0.03) -> Drive:
    """Two minutes of pedals on rolling hills. dives: m/s² of gravity that a m/s² of braking brings."""
    rng = np.random.default_rng(4)
    t = np.arange(int(120 * HZ)) / HZ
    change = 1.6 * np.sin(0.9 * t) + 1.1 * np.sin(1.7 * t) * np.sin(0.2 * t)
    speed = 18 + np.cumsum(change) / HZ
    felt = change * (1 + dives) + 9.81 * grade * np.sin(speed.mean() * t / 80)
    felt = np.interp(t - late_s, t, felt)
    columns = {
        "speed": speed + 0.02 * rng.standard_normal(len(t)),
        "yaw_rate": 0.03 * np.sin(0.2 * t),
        "accel_x": scale * felt + 0.1 * rng.standard_normal(len(t)),
    }
    stamps = (t * 1e9).astype(np.int64)
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", len(t), {}, (), "t", None, 120.0, ())
    return Drive({n: Signal(n, stamps, v, n) for n, v in columns.items()}, record)


@pytest.mark.parametrize("scale", [0.97, 1.0, 1.03])
@pytest.mark.parametrize("dives", [0.01, 0.045, 0.08])
def test_honest_sensors_are_left_alone(scale: float, dives: float) -> None:
    assert longitudinal_doubt(_drive(scale, dives=dives)) is None


@pytest.mark.parametrize("scale", [0.5, 0.8, 0.88, 1.12, 1.2, 1.6])
def test_a_wrong_scale_is_said_with_its_size(scale: float) -> None:
    doubt = longitudinal_doubt(_drive(scale, dives=DIVES - 1))
    assert doubt is not None
    assert doubt.off == pytest.approx(abs(scale - 1), abs=0.03)
    assert f"accel_x is {1 + (scale > 1) * doubt.off - (scale < 1) * doubt.off:.2f} times" in doubt.found
    (said,) = with_doubt(_drive(), doubt).record.decisions
    assert (said.signal, said.kind, said.applied) == ("accel_x", "unit", False)
    assert with_doubt(_drive(), None).record.decisions == ()


def test_what_tells_no_scale_says_none() -> None:
    late = _drive(0.7, late_s=1.5)
    assert longitudinal_doubt(late) is None
    turned = _drive(-1.3)
    assert longitudinal_doubt(turned) is None
    alone = _drive(0.7)
    assert longitudinal_doubt(Drive({"accel_x": alone.signals["accel_x"]}, alone.record)) is None
    # the speed's scale is said already: both accelerations contradict it
    said = Decision("speed", "scale", "speed is 1.30 times", "left", "", applied=False)
    again = replace(alone, record=replace(alone.record, decisions=(said,)))
    assert longitudinal_doubt(again) is None
    short = Drive(
        {n: replace(s, time_ns=s.time_ns[:500], values=s.values[:500]) for n, s in alone.signals.items()},
        alone.record,
    )
    assert longitudinal_doubt(short) is None


def test_only_what_hangs_on_it_gets_less_sure() -> None:
    told = {
        name: ParameterEstimate(name, 2.0, 0.02, 1.96, 2.04, "identified", "from it", None)
        for name in ("mass_kg", "roll_gradient_degpg")
    }
    found = as_sure_as_the_scale(told, DOUBT, ("mass_kg",))
    assert found["mass_kg"].status == "weak"
    assert found["mass_kg"].std == pytest.approx(0.4, abs=0.01)
    assert found["mass_kg"].reason.startswith(DOUBT.found)
    assert found["roll_gradient_degpg"] == told["roll_gradient_degpg"]
    assert as_sure_as_the_scale(told, None, ("mass_kg",)) == told
    assert hanging_along((), None, tuple(told)) == ()
    assert kept_as_sure(None, DOUBT, ("mass_kg",)) is None


@pytest.mark.parametrize("scale", [0.8, 1.25])
def test_a_drive_with_a_wrong_scale_tells_no_height_for_sure(scale: float, tmp_path: Path) -> None:
    table = pl.read_csv(SAMPLE / "csv" / "drive.csv")
    table.with_columns(pl.col("accel_x_mps2") * scale).write_csv(tmp_path / "drive.csv")
    found = analyze(Request((tmp_path / "drive.csv",), vehicle=SAMPLE / "vehicle.toml"))
    assert any("accel_x is" in d.found and "change of speed" in d.found for d in found.record.decisions)
    arm = found.verdict.get("pitch_arm_m")
    assert arm is None or (arm.status != "identified" and "times the change of speed" in arm.reason)
    height = found.verdict["cg_height_m"]
    assert height.value is not None
    assert height.std is not None
    truth = json.loads((SAMPLE / "truth.json").read_text())["parameters"]["cg_height_m"]
    assert abs(height.value - truth) < 2.5 * height.std
    # statics do not hang on it
    assert "change of speed" not in found.verdict["cg_to_front_axle_m"].reason
