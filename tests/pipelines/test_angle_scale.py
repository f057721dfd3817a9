"""Angles against their gyros: a wrong scale is said with its factor, filters, delays, drift and askew units are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.analyze import Request, analyze
from pipelines.joint.kept import KeptRelations
from pipelines.prepare.angle_scale import (
    AngleDoubt,
    angle_doubts,
    as_sure_as_angles,
    estimates_as_sure,
    kept_as_sure_as_angles,
    with_angle_doubts,
)
from pipelines.results import Estimate, FloatArray, ParameterEstimate

HZ = 100.0

Change = Callable[[FloatArray], FloatArray]


def _same(values: FloatArray) -> FloatArray:
    return values


def _filtered(values: FloatArray, hz: float) -> FloatArray:
    """First order, causal, by its response."""
    f = np.fft.rfftfreq(len(values), 1 / HZ)
    return np.asarray(np.fft.irfft(np.fft.rfft(values) / (1 + 1j * f / hz), len(values)))


def _drive(
    angle: Change = _same,
    gyro: Change = _same,
    *,
    axis: str = "roll",
    size: float = 1.0,
    noise: float = 0.003,
) -> Drive:
    """Two minutes of slaloms and bends of 0.2 to 1 Hz, on banked and uneven road: both see what the body does."""
    rng = np.random.default_rng(4)
    t = np.arange(int(120 * HZ)) / HZ
    yaw = 0.2 * np.sin(0.5 * t) + 0.15 * np.sin(3.5 * t + 2 * np.sin(0.2 * t)) * (np.sin(0.13 * t) > 0)
    bank = 0.03 * np.sin(0.21 * t) + _filtered(0.03 * rng.standard_normal(len(t)), 1.0)
    tilt = size * (0.06 * np.sin(3.5 * t + 2 * np.sin(0.2 * t)) * (1 + np.sin(0.13 * t)) + bank)
    columns = {
        axis: angle(tilt) + 0.0005 * rng.standard_normal(len(t)),
        f"{axis}_rate": gyro(np.gradient(tilt) * HZ + 0.03 * yaw)
        + noise * rng.standard_normal(len(t))
        + 0.004,
    }
    if axis == "roll":
        columns["yaw_rate"] = yaw
    stamps = (t * 1e9).astype(np.int64)
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", len(t), {}, (), "t", None, 120.0, ())
    return Drive({n: Signal(n, stamps, v, n) for n, v in columns.items()}, record)


def _said(doubt: AngleDoubt) -> float:
    """The factor that its sentence tells."""
    return float(doubt.found.split(" changes by ")[1].split(" times")[0])


def _late(seconds: float) -> Change:
    return lambda values: np.roll(values, int(seconds * HZ))


@pytest.mark.parametrize("axis", ["roll", "pitch"])
@pytest.mark.parametrize("factor", [0.5, 0.8, 1.25, 2.0])
def test_an_angle_of_another_scale_is_said_with_its_factor(axis: str, factor: float) -> None:
    (doubt,) = angle_doubts(_drive(lambda tilt: factor * tilt, axis=axis))
    assert doubt.axis == axis
    assert f"times what {axis}_rate integrates to" in doubt.found
    assert _said(doubt) == pytest.approx(factor, rel=0.01)
    # half of the angle is half of the gradient: the right one is as much again
    assert doubt.off == pytest.approx(max(abs(factor - 1), abs(1 / factor - 1)), abs=0.05)


def test_a_gyro_of_another_scale_is_told_the_same_way() -> None:
    (doubt,) = angle_doubts(_drive(gyro=lambda rate: 0.5 * rate))
    assert _said(doubt) == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize(
    ("angle", "gyro"),
    [
        (_same, _same),
        (lambda tilt: 1.05 * tilt, _same),
        (_same, lambda rate: _filtered(rate, 5.0)),
        (lambda tilt: _filtered(tilt, 1.6), _same),
        (_late(0.1), lambda rate: _filtered(rate, 5.0)),
        (_late(0.05), _same),
        (_same, _late(0.15)),
        (lambda tilt: tilt + 1e-5 * np.arange(len(tilt)), _same),
    ],
)
def test_honest_channels_are_left_alone(angle: Change, gyro: Change) -> None:
    assert angle_doubts(_drive(angle, gyro)) == ()


def test_a_late_angle_of_half_its_size_is_found_too() -> None:
    (doubt,) = angle_doubts(_drive(lambda tilt: 0.5 * _late(0.2)(tilt)))
    assert _said(doubt) == pytest.approx(0.5, rel=0.02)


def test_too_little_motion_tells_nothing() -> None:
    assert angle_doubts(_drive(lambda tilt: 0.5 * tilt, size=0.02)) == ()


def test_noise_is_no_scale() -> None:
    assert angle_doubts(_drive(noise=1.0)) == ()


def test_an_angle_that_was_derived_is_not_held_against_the_gyro() -> None:
    """Springs lean by less than the body turns: tyres give."""
    drive = _drive(lambda tilt: 0.7 * tilt)
    derived = replace(drive.signals["roll"], measured=False)
    assert angle_doubts(replace(drive, signals={**drive.signals, "roll": derived})) == ()


def test_a_gap_is_no_change() -> None:
    drive = _drive()
    kept = np.ones(int(120 * HZ), np.bool_)
    kept[4000:6000] = False
    signals = {
        n: replace(s, time_ns=s.time_ns[kept], values=s.values[kept]) for n, s in drive.signals.items()
    }
    assert angle_doubts(replace(drive, signals=signals)) == ()


DOUBT = AngleDoubt("roll", 1.0, "roll is half", "slope 0.5")
TOLD = ParameterEstimate(
    "roll_gradient_degpg", 3.5, 0.1, 3.3, 3.7, "identified", "seen", sources=("roll_map",)
)


def test_what_hangs_on_the_angle_is_no_surer() -> None:
    mass = replace(TOLD, name="mass_kg", value=1500.0)
    springs = replace(TOLD, name="cg_height_m", sources=("axle_load_gls",))
    verdict = {"roll_gradient_degpg": TOLD, "mass_kg": mass, "cg_height_m": springs}
    assert as_sure_as_angles(verdict, ()) == verdict
    found = as_sure_as_angles(verdict, (DOUBT,))
    assert found["mass_kg"] is mass
    assert found["cg_height_m"] is springs
    assert found["roll_gradient_degpg"].status == "not_identifiable"
    small = as_sure_as_angles(verdict, (replace(DOUBT, off=0.2),))["roll_gradient_degpg"]
    assert small.status == "weak"
    assert small.std == pytest.approx(np.hypot(0.1, 0.7))
    assert "roll is half" in small.reason


def test_an_estimators_own_answers_are_no_surer_either() -> None:
    rows = {"roll_gradient_degpg": replace(TOLD, sources=())}
    by_angle, by_loads = Estimate("roll_map", "ran", "", rows), Estimate("axle_load_gls", "ran", "", rows)
    first, second = estimates_as_sure([by_angle, by_loads], (replace(DOUBT, off=0.2),))
    assert first.parameters["roll_gradient_degpg"].status == "weak"
    assert second == by_loads


def test_it_is_in_the_record_and_in_what_is_joined() -> None:
    (said,) = with_angle_doubts(_drive(), (DOUBT,)).record.decisions
    assert (said.signal, said.applied) == ("roll", False)
    none = np.zeros(0)
    told = {"roll_gradient_degpg": (3.5, 0.1), "mass_kg": (1500.0, 10.0)}
    kept = KeptRelations(
        (), none, none, none, np.zeros((0, 0)), none, (), (), (), {}, {}, 1.0, True, told
    )  # fmt: skip
    found = kept_as_sure_as_angles(kept, (DOUBT,), {"roll_gradient_degpg": TOLD})
    assert found is not None
    assert found.told["roll_gradient_degpg"][1] == pytest.approx(np.hypot(0.1, 3.5))
    assert found.told["mass_kg"] == told["mass_kg"]
    assert kept_as_sure_as_angles(None, (DOUBT,), {}) is None


@pytest.mark.parametrize(("factor", "status"), [(1.0, "identified"), (0.5, "not_identifiable")])
def test_an_analysis_marks_what_a_halved_angle_tells(tmp_path: Path, factor: float, status: str) -> None:
    """In the estimator's own row, and in the verdict."""
    source = Path(__file__).parents[2] / "sample_logs"
    frame = pl.read_csv(source / "csv" / "drive.csv")
    log = tmp_path / "drive.csv"
    frame.with_columns(pl.col("roll_rad") * factor).write_csv(log)
    results = analyze(Request((log,), vehicle=source / "vehicle.toml", estimators="roll_map"))
    (told,) = [each.parameters["roll_gradient_degpg"] for each in results.estimates]
    assert told.status == status
    entry = results.verdict.get("roll_gradient_degpg")
    assert entry is not None
    assert (entry.status == "identified") == (factor == 1)
    assert any("integrates to" in each.found for each in results.record.decisions) == (factor != 1)
