"""Train on one drive, apply to another with another load: errors, intervals, and what happens when something is missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from wheel_force_drives import Made, scaled, without

from parsers.errors import LogError
from parsers.signals import WHEELS
from pipelines.suspension_mapping.apply import Mapped, apply_map
from pipelines.suspension_mapping.data import collect, prepare_map, rate_of, second_rate_of
from pipelines.suspension_mapping.judge import judge, training_rms_n
from pipelines.suspension_mapping.manoeuvres import FOLDS, KINDS, split
from pipelines.suspension_mapping.record import SuspensionMap
from pipelines.suspension_mapping.train import train, training_drive


def _figures(mapped: Mapped, made: Made, time_s: np.ndarray) -> tuple[float, float, float]:
    """RMS error against the truth, share inside the interval, mean standard deviation; over all wheels."""
    squares, inside, std = [], [], []
    for wheel in WHEELS:
        own = mapped.wheels[wheel]
        off = own.force - made.true_at(wheel, time_s)
        squares.append(np.mean(off**2))
        inside.append(np.mean(np.abs(off) <= 1.96 * own.std))
        std.append(np.mean(own.std))
    return float(np.sqrt(np.mean(squares))), float(np.mean(inside)), float(np.mean(std))


def _applied(record: SuspensionMap, made: Made, *missing: str) -> tuple[float, float, float]:
    data = collect(prepare_map(without(made.drive, *missing), record.band_hz))
    mapped = apply_map(record, data)
    assert mapped is not None
    return _figures(mapped, made, data.time_s)


def test_training_drive_is_mapped(suspension_map: SuspensionMap) -> None:
    assert set(suspension_map.parts) == {"struts", "springs"}
    assert training_rms_n(suspension_map, "struts") < 60
    struts = suspension_map.parts["struts"]
    assert struts.held_out[struts.form] < 0.5 * struts.held_out["published"]
    lateral = {w: struts.wheels[w].coefficients["own_lateral"] for w in WHEELS}
    assert [np.sign(lateral[w]) for w in WHEELS] == [-1, 1, -1, 1]
    for own in struts.wheels.values():
        assert own.coefficients["carried"] == pytest.approx(1.0, abs=0.05)


def test_another_drive_with_another_load(suspension_map: SuspensionMap, other: Made) -> None:
    rms, inside, std = _applied(suspension_map, other)
    assert rms < 100
    assert inside > 0.8
    assert std < 120
    judged = {entry.kind: entry for entry in judge(suspension_map, other.drive, "other")}
    assert judged["struts"].ratio < 2.0
    assert judged["struts"].load_kg == pytest.approx(250, abs=40)
    assert judged["struts"].rms_n < 60


def test_without_struts_the_deflections_serve(suspension_map: SuspensionMap, other: Made) -> None:
    rms, inside, std = _applied(suspension_map, other, "suspension_force")
    assert rms < 150
    assert inside > 0.8
    assert std > _applied(suspension_map, other)[2]


def test_a_missing_signal_widens(suspension_map: SuspensionMap, other: Made) -> None:
    whole = _applied(suspension_map, other)[2]
    _, inside, std = _applied(suspension_map, other, "accel_y")
    assert std > 2 * whole
    assert inside > 0.9


def test_nothing_to_map_from(suspension_map: SuspensionMap, other: Made) -> None:
    data = collect(prepare_map(without(other.drive, "suspension_"), 10.0))
    assert apply_map(suspension_map, data) is None


def test_outside_the_training_it_is_wider_and_said(suspension_map: SuspensionMap, other: Made) -> None:
    data = collect(prepare_map(other.drive, suspension_map.band_hz))
    far = collect(prepare_map(scaled(other.drive, "accel_y", 3.0), suspension_map.band_hz))
    near, wild = apply_map(suspension_map, data), apply_map(suspension_map, far)
    assert near is not None
    assert wild is not None
    assert wild.wheels["fl"].outside["own_lateral"] > 0.02
    assert wild.wheels["fl"].std.max() > 2 * near.wheels["fl"].std.max()


def test_raw_strut_cells_with_a_lever_are_learned(training: Made, other: Made) -> None:
    lever = 1 / 0.72
    drive = without(scaled(training.drive, "suspension_force", lever), "suspension_deflection")
    record = train([training_drive(drive, "x")], training.vehicle, "suv")
    assert record.parts["struts"].wheels["rr"].coefficients["carried"] == pytest.approx(0.72, abs=0.04)
    changed = replace(other, drive=scaled(other.drive, "suspension_force", lever))
    assert _applied(record, changed, "suspension_deflection")[0] < 150


def test_two_training_drives(training: Made, other: Made) -> None:
    drives = [training_drive(made.drive, name) for made, name in ((training, "a"), (other, "b"))]
    record = train(drives, training.vehicle, "suv")
    assert [drive.log for drive in record.training] == ["a", "b"]
    assert "2 training drives" in record.zero_from
    assert training_rms_n(record, "struts") < 70


@pytest.mark.parametrize(
    ("missing", "words"),
    [(("tire_normal_force_rl",), "tire_normal_force_rl"), (("suspension_",), "neither suspension forces")],
)
def test_training_says_what_it_lacks(training: Made, missing: tuple[str, ...], words: str) -> None:
    with pytest.raises(LogError, match=words):
        training_drive(without(training.drive, *missing), "drive.csv")


def test_validation_needs_measuring_wheels(suspension_map: SuspensionMap, other: Made) -> None:
    with pytest.raises(LogError, match="cannot validate"):
        judge(suspension_map, without(other.drive, "tire_normal"), "other")


def test_manoeuvres_are_whole_and_spread_over_folds(training: Made) -> None:
    data = collect(prepare_map(training.drive, 10.0), need_measured=True)
    parts = split(data)
    for piece in np.unique(parts.piece):
        rows = parts.piece == piece
        assert len(np.unique(parts.kind[rows])) == 1
        assert len(np.unique(parts.fold[rows])) == 1
    assert set(np.unique(parts.fold)) == set(range(FOLDS))
    turning = data.columns["accel_y"][parts.kind == KINDS.index("left")]
    assert np.mean(turning) > 1.0


def test_derivatives_hold_up_to_the_band() -> None:
    rate, hz = 40.0, 9.0
    t = np.arange(400) / rate
    starts = np.zeros(400)
    starts[[0, 200]] = 1
    wave = np.sin(2 * np.pi * hz * t)
    omega = 2 * np.pi * hz
    inner = np.r_[5:195, 205:395]
    assert rate_of(wave, starts, rate)[inner] == pytest.approx(
        omega * np.cos(omega * t)[inner], abs=0.06 * omega
    )
    assert second_rate_of(wave, starts, rate)[inner] == pytest.approx(
        -(omega**2) * wave[inner], abs=0.03 * omega**2
    )
